"""States that are damaged, or from a newer version: a typed error each time, never another object."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from travel_support import bits, examples, leafy_scene, name_of, public_classes, small_scene

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import StateError
from shadowlab.travel import Value, checksum, restored

CORE = sorted(name for name, thing in vars(_core).items() if isinstance(thing, type) and name != "Renderer")
WITH_ARRAYS = ("GBuffer", "Mesh", "Misclassified", "Samples", "Scene")
VALUES = sorted(name_of(cls) for cls in public_classes() if issubclass(cls, Value))
# Those whose pickles are small, and hold no array that a changed length could make large.
SMALL = ("Bias", "Camera", "Convention", "DirectionalLight", "Partition", "PointLight", "SpotLight", "Technique")


def core_example(name: str):
    """An example of a class of the extension, one with dropped faces and alpha tests where it has meshes."""
    if name == "Scene":
        return _core.Scene(leafy_scene())
    return examples(name_of(getattr(_core, name)))[-1]


def parts_of(name: str) -> list:
    """Name, version, bytes, arrays."""
    function, parts = core_example(name).__reduce__()
    assert function is _core.restore
    assert parts[0] == name
    return list(parts)


def refused(*parts, match: str | None = None) -> None:
    with pytest.raises(StateError, match=match) as raised:
        _core.restore(*parts)
    assert isinstance(raised.value, ValueError)
    assert len(str(raised.value)) < 400


@pytest.mark.parametrize("name", CORE)
def test_a_newer_version_is_named(name):
    _, version, *rest = parts_of(name)
    newest = max(one.__reduce__()[1][1] for one in (*examples(name_of(getattr(_core, name))), core_example(name)))
    refused(name, newest + 1, *rest, match=rf"{name}.*version {newest + 1}.*newer shadowlab.*update")
    refused(name, 2**32 - 1, *rest, match="newer")
    for wrong in (0, -1, 2**40, "1", None, 1.5, b"1", []):
        refused(name, wrong, *rest)
    refused("Hologram", version, *rest, match="no such class")


@pytest.mark.parametrize("name", CORE)
def test_bytes_that_end_too_early_or_too_late(name):
    _, version, head, *arrays = parts_of(name)
    for end in range(len(head)):
        refused(name, version, head[:end], *arrays)
    refused(name, version, head + b"\0", *arrays)
    refused(name, version, b"\0" + head, *arrays)
    for wrong in (None, "text", bytearray(head), list(head), 7):
        refused(name, version, wrong, *arrays)


@pytest.mark.parametrize("name", CORE)
def test_every_byte_counts(name):
    _, version, head, *arrays = parts_of(name)
    for at in range(len(head)):
        for bit in (1, 128):
            changed = bytearray(head)
            changed[at] ^= bit
            refused(name, version, bytes(changed), *arrays)


@pytest.mark.parametrize("name", CORE)
def test_states_of_other_classes(name):
    for other in CORE:
        if other != name:
            refused(name, *parts_of(other)[1:])


@pytest.mark.parametrize("name", WITH_ARRAYS)
def test_arrays_that_are_not_those(name):
    _, version, head, *arrays = parts_of(name)
    refused(name, version, head, *arrays[:-1])
    refused(name, version, head, *arrays, arrays[-1])
    refused(name, version, head, *arrays[::-1], np.zeros(3))
    for i, array in enumerate(arrays):
        wrong = [
            None,
            array.tolist(),
            array.tobytes(),
            array[..., None],
            array.reshape(-1, 1, 1, 1),
            array.astype(np.complex128),
            array.astype(object),
            array.view(np.int8 if array.dtype == np.uint8 else np.uint8),
            np.zeros(0, array.dtype),
            np.zeros((0, *array.shape[1:]), array.dtype),
            np.repeat(array, 2, axis=0) if array.size else np.zeros((1, *array.shape[1:]), array.dtype),
        ]
        if array.size:
            changed = array.copy()
            changed.view(np.uint8).reshape(-1)[-1] ^= 1
            wrong += [array[:-1], changed]
        for one in wrong:
            if array.size or not isinstance(one, np.ndarray) or one.shape != array.shape or one.dtype != array.dtype:
                refused(name, version, head, *arrays[:i], one, *arrays[i + 1 :])


@pytest.mark.parametrize("name", WITH_ARRAYS)
def test_arrays_of_another_machine_or_layout_are_read(name):
    """Another byte order, another order of axes, an odd address: the numbers are the same."""
    _, version, head, *arrays = parts_of(name)

    def odd(array):
        raw = np.zeros(array.nbytes + 1, np.uint8)
        found = raw[1:].view(array.dtype) if array.dtype.itemsize == 1 else np.frombuffer(raw.data, np.uint8)[1:]
        found = found.view(array.dtype).reshape(array.shape)
        found.flags.writeable = True
        found[...] = array
        return found

    for change in (lambda a: a.astype(a.dtype.newbyteorder(">")), np.asfortranarray, odd):
        back = _core.restore(name, version, head, *map(change, arrays))
        assert bits(back) == bits(core_example(name))


def test_nothing_at_all():
    refused()
    refused(None)
    refused("Camera")
    refused("Camera", 1)
    refused(1, 2, 3)


@pytest.mark.parametrize("name", [*CORE, *VALUES])
def test_pickles_that_end_too_early(name):
    value = core_example(name) if name in CORE else examples(name)[-1]
    whole = pickle.dumps(value, 4)
    ends = range(len(whole)) if len(whole) < 2000 else np.linspace(0, len(whole) - 1, 500).astype(int)
    for end in ends:
        with pytest.raises(Exception):  # noqa: B017, PT011 - pickle raises what it likes; a panic is no Exception
            pickle.loads(whole[:end])


@pytest.mark.parametrize("name", SMALL)
@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_pickles_with_changed_bytes_raise_or_are_the_same(name, data):
    value = examples(name)[-1]
    whole = bytearray(pickle.dumps(value, 4))
    for _ in range(data.draw(st.integers(1, 3))):
        whole[data.draw(st.integers(0, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        back = pickle.loads(bytes(whole))
    except Exception:  # noqa: BLE001 - pickle raises what it likes; a panic is no Exception
        return
    assert type(back) is not type(value) or bits(back) == bits(value)


@pytest.mark.parametrize("name", VALUES)
def test_states_of_dataclasses(name):
    value = examples(name)[-1]
    function, (cls, version, state, digest) = value.__reduce__()
    assert function is restored
    assert bits(restored(cls, version, dict(state), digest)) == bits(value)

    def is_refused(*parts, match=None):
        with pytest.raises(StateError, match=match):
            restored(*parts)

    is_refused(cls, version + 1, state, digest, match=f"{cls.__name__}.*newer shadowlab.*update")
    for wrong in (0, -1, True, None, "1", 1.0):
        is_refused(cls, wrong, state, digest)
    is_refused(cls, version, state, b"")
    is_refused(cls, version, state, digest[:-1])
    is_refused(cls, version, list(state), digest)
    is_refused(cls, version, {}, checksum({}))
    is_refused(cls, version, {**state, "more": 1}, checksum({**state, "more": 1}))
    is_refused(int, version, state, digest)
    is_refused(None, version, state, digest)
    is_refused(cls, version, state)
    is_refused()
    for field in state:
        for wrong in (None, "nothing", -1, np.zeros(3)):
            if bits(wrong) != bits(state[field]):
                is_refused(cls, version, {**state, field: wrong}, digest)


def test_a_checksum_sees_every_bit_of_plain_data():
    base = [1, True, None, 2.0, "a", b"a", (1, 2), [1, 2], {"a": 1}, np.arange(3), np.float32(1.0)]
    others = [
        2,
        False,
        -2.0,
        2.0000000000000004,
        "b",
        b"b",
        (1, 3),
        [2, 1],
        (1,),
        {"b": 1},
        {"a": 2},
        0.0,
        -0.0,
        np.arange(4),
        np.arange(3.0),
        np.arange(3, dtype=np.int32),
        np.arange(3).reshape(3, 1),
        np.array(["a", None], object),
        np.array(["a", 1], object),
        np.float32(1.5),
        np.array([0.0]),
        np.array([-0.0]),
        ((1, 2),),
        ((1,), 2),
        "1",
        b"",
    ]
    found = [checksum(value) for value in base + others]
    assert len(set(found)) == len(found)
    assert checksum(np.arange(6).reshape(2, 3)) == checksum(np.asfortranarray(np.arange(6).reshape(2, 3)))
    assert checksum(np.arange(3, dtype=">i8")) == checksum(np.arange(3, dtype="<i8"))


def test_scenes_of_the_package():
    scene = small_scene()
    function, (cls, version, geometry, attributes, digest) = scene.__reduce__()
    assert cls is sl.Scene
    cases = [
        ((cls, version + 1, geometry, attributes, digest), "newer shadowlab"),
        ((cls, None, geometry, attributes, digest), "version"),
        ((cls, version, geometry, {**attributes, "source": "elsewhere"}, digest), "checksum"),
        ((cls, version, geometry, None, digest), "checksum"),
        ((cls, version, None, attributes, digest), "checksum"),
        ((cls, version, sl.Bias().__reduce__()[1], attributes, digest), "Bias"),
        ((cls, version, geometry[:-1], attributes, digest), "Scene"),
        ((cls, version, geometry, attributes), "class"),
        ((sl.Camera, version, geometry, attributes, digest), "class"),
        ((), "class"),
    ]
    for parts, match in cases:
        with pytest.raises(StateError, match=match):
            function(*parts)
