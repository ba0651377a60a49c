"""Every public type through pickle, copy, deepcopy, == and hash: found by looking at the package, none left out."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import travel_support as support
from travel_support import EXAMPLES, SIZE, STAYS, bits, examples, name_of, public_classes

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import StateError
from shadowlab.travel import Value

CLASSES = public_classes()
ERRORS = [cls for cls in CLASSES if issubclass(cls, Exception)]
TRAVELS = [cls for cls in CLASSES if name_of(cls) not in STAYS]
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
# A pickle of a scene by the bytes that its meshes and transforms take (one affine map and one index an instance).
MOST_OVERHEAD = 1.1
INSTANCE_BYTES = 12 * 8 + 4

named = pytest.mark.parametrize("cls", TRAVELS, ids=name_of)


def check_same(back, value) -> None:
    """Asserts that one object is another's equal, to the bit."""
    assert type(back) is type(value)
    if not isinstance(value, Exception):
        assert back == value
        assert not back != value  # noqa: SIM202 - __ne__ is looked at
        assert hash(back) == hash(value)
    assert bits(back) == bits(value)


def test_every_public_class_has_examples_or_a_reason():
    names = {name_of(cls) for cls in CLASSES}
    assert len(CLASSES) == len(names), "two public classes of one name"
    known = {*EXAMPLES, *STAYS, *(name_of(cls) for cls in ERRORS)}
    assert names - known == set(), "add examples to tests/travel_support.py, or say there why it does not travel"
    assert known - names == set(), "there is no such public class any more"
    assert STAYS.keys() <= names
    assert all(len(reason) > 10 for reason in STAYS.values())
    assert len(TRAVELS) > 30


@named
def test_pickle_in_every_protocol(cls):
    for value in examples(name_of(cls)):
        assert type(value) is cls
        for protocol in PROTOCOLS:
            check_same(pickle.loads(pickle.dumps(value, protocol)), value)


@named
def test_copy_and_deepcopy(cls):
    for value in examples(name_of(cls)):
        check_same(copy.copy(value), value)
        check_same(copy.deepcopy([value])[0], value)


# Exceptions compare by identity, as Python's own do.
@pytest.mark.parametrize("cls", [cls for cls in TRAVELS if cls not in ERRORS], ids=name_of)
def test_equal_to_itself_alone(cls):
    values = examples(name_of(cls))
    made_again = EXAMPLES[name_of(cls)]()
    for i, (value, again) in enumerate(zip(values, made_again, strict=True)):
        # Milliseconds, and times of drivers, are no part of what is compared here.
        if cls not in (sl.Run, sl.Study, sl.Advice):
            assert again == value
            assert len({again, value}) == 1
        assert value != "something else"
        assert value != None  # noqa: E711
        for other in values[:i]:
            assert value != other
            assert not value == other  # noqa: SIM201
            # Of -1 and -2 Python's own hashes are the same.
            assert hash(value) != hash(other) or isinstance(value, int)


def test_bits_tell_what_equality_does_not():
    for a, b in ((0.0, -0.0), (np.nan, support.PAYLOAD)):
        assert bits(a) != bits(b)
        assert bits(np.array([a])) != bits(np.array([b]))
        assert bits({"a": (a,)}) != bits({"a": (b,)})
    light = sl.DirectionalLight((0.0, -1, 0)), sl.DirectionalLight((-0.0, -1, 0))
    assert light[0] == light[1]
    assert hash(light[0]) == hash(light[1])
    assert bits(light[0]) != bits(light[1])


def test_nan_with_a_payload_is_one_nan_and_keeps_its_bits():
    changed = support.gbuffer()
    plain = support.gbuffer()
    plain.normal[0, 0, 0] = np.nan
    assert plain == changed
    assert hash(plain) == hash(changed)
    assert bits(plain) != bits(changed)
    plain.normal[0, 0, 1] = 1.0
    assert plain != changed
    first, _, third = support.footprints()
    assert (np.isnan(first.major) == (first.map < 0)).all()
    assert bits(pickle.loads(pickle.dumps(third)).depth) == bits(third.depth)
    assert bits(third.depth[0]) == bits(np.float64(support.PAYLOAD))


def test_a_renderer_stays_and_says_what_to_do():
    renderer = sl.Renderer("cpu")
    for protocol in PROTOCOLS:
        with pytest.raises(StateError, match=r'make one in the other process: sl\.Renderer\("cpu"\)'):
            pickle.dumps(renderer, protocol)
    assert copy.copy(renderer) is renderer
    assert copy.deepcopy(renderer) is renderer


def test_a_pickled_scene_shares_its_geometry():
    scene = sl.library.scene("forest", trees=3000)
    content = sum(mesh.memory for mesh in scene.meshes) + INSTANCE_BYTES * scene.instance_count
    assert scene.triangle_count > 5 * sum(mesh.triangle_count for mesh in scene.meshes)
    assert len(pickle.dumps(scene, 5)) < MOST_OVERHEAD * content


def test_arrays_go_out_of_band():
    for value, arrays in (
        (support.gbuffer(), SIZE[0] * SIZE[1] * 36),
        (support.footprints()[0], SIZE[0] * SIZE[1] * 42),
        (support.view()[0], sum(mesh.memory for mesh in support.view()[0].meshes)),
    ):
        buffers: list[pickle.PickleBuffer] = []
        inside = pickle.dumps(value, 5, buffer_callback=buffers.append)
        assert sum(buffer.raw().nbytes for buffer in buffers) >= 0.9 * arrays
        assert len(inside) < 4096 + 0.1 * arrays
        # Buffers that may not be written to, as shared memory and the network give them.
        frozen = [bytes(buffer.raw()) for buffer in buffers]
        check_same(pickle.loads(inside, buffers=frozen), value)
        assert bits(_drawn(pickle.loads(inside, buffers=frozen))) == bits(_drawn(value))


def _drawn(value):
    """Something that uses all of the arrays."""
    _, camera, light = support.view()
    if isinstance(value, sl.GBuffer):
        return sl.aliasing.texel_coordinates(value, camera, light, support.parameterization("uniform"))
    return sl.Renderer("cpu").gbuffer(value, camera, size=16) if isinstance(value, sl.Scene) else value.summary()


def test_scenes_of_one_content_are_equal_whatever_they_are_called():
    library = sl.library.scene("robots")
    plain = sl.Scene(library.meshes, library.mesh_index, library.transforms)
    assert (plain.source, library.source) == ("", "@robots")
    assert plain == library
    assert library == plain
    assert len({plain, library, _core.Scene(plain)}) == 1
    assert {library: 1}[plain] == 1
    assert plain != plain.with_ground()
    assert library.meshes[0] == plain.meshes[0] != plain.meshes[1]


def test_what_a_scene_knows_travels_with_it():
    for scene in (sl.library.scene("robots", seed=3), support.small_scene()):
        for back in (pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)):
            assert (back.source, back.recipe, back.cameras) == (scene.source, scene.recipe, scene.cameras)
            assert bits(back.world_from_source) == bits(scene.world_from_source)
            assert back.lights == scene.lights
            assert getattr(back, "light", None) == getattr(scene, "light", None)
    kept = support.small_scene()
    copy.deepcopy(kept).world_from_source[0, 3] = 9
    assert kept.world_from_source[0, 3] == 0


def test_copies_share_geometry_and_subclasses_stay_what_they_are():
    class Mine(sl.Scene):
        pass

    scene = Mine(sl.library.scene("robots"))
    scene.note = {"of": "mine"}
    for back in (copy.copy(scene), copy.deepcopy(scene)):
        assert type(back) is Mine
        assert back == scene
        assert back.note == {"of": "mine"}
    assert copy.copy(scene).note is scene.note
    assert copy.deepcopy(scene).note is not scene.note
    # Geometry that is shared is there at once: its structure for rays, too.
    assert _core.trace_memory(copy.copy(scene)) == _core.trace_memory(scene)


def test_a_preset_is_the_one_of_its_name():
    for name in ("godot", "filament"):
        assert pickle.loads(pickle.dumps(sl.preset(name))) is sl.preset(name)
    with pytest.raises((pickle.PicklingError, AttributeError)):
        pickle.dumps(sl.Preset("a", "b", "c", "d", "e", lambda scene, camera, light: None))


def test_techniques_and_maps_do_the_same_as_before():
    scene, camera, light = support.view()
    for technique in examples("Technique"):
        back = pickle.loads(pickle.dumps(technique))
        assert back.settings == technique.settings
        made = [t.parameterize(scene, camera, light, resolution=64) for t in (back, technique)]
        assert made[0] == made[1]
        assert bits(made[0]) == bits(made[1])
    for p in examples("Parameterization"):
        back = pickle.loads(pickle.dumps(p))
        maps = [sl.Renderer("cpu").shadow_map(scene, q, resolution=32) for q in (p, back)]
        assert bits(maps[0]) == bits(maps[1])


def test_values_of_one_class_are_never_equal_to_another_class():
    values = [value for cls in TRAVELS if issubclass(cls, Value) for value in examples(name_of(cls))[:1]]
    for i, value in enumerate(values):
        assert all(value != other for other in values[:i])
