"""Damaged glTF files: each is a scene, or an error that is typed, within limits of time and memory."""

from __future__ import annotations

import copy
import io
import json
import time
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from gltf_support import TRIANGLE, Gltf, glb_of, loaded
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import shadowlab as sl
from shadowlab.errors import LoadError, SceneError, ShadowlabWarning

#: Of one load: what a file of a few thousand bytes may expand to, with room for temporary arrays; and a slow machine.
MOST_BYTES, MOST_SECONDS = 1 << 30, 60.0
EVIL = [
    None, True, False, 0, -1, 1, 2, 3, 255, 65535, 2**31, 2**32 - 1, 2**53, 10**10, 10**19, 10**400, 0.5, -0.0, 1e-320,
    1e30, 1e300, -1e300, "", "0", "..", "data:,", "data:;base64,AAAA", "x" * 3000, [], [0], [-1], [10**10], [[]], {},
    {"a": 1}, [0, 0, 0], [0, 0, 0, 0], [1e300, 1e300, 1e300], [1e-320] * 4, [1] * 16, [None] * 3, "SCALAR", "VEC3",
    "VEC4", "MAT4", 5120, 5121, 5122, 5123, 5125, 5126, "POINTS", "MASK", "BLEND", "TRIANGLES", "INDICES",
    "EXPONENTIAL", "perspective", "KHR_draco_mesh_compression", "EXT_meshopt_compression",
    ["KHR_draco_mesh_compression"],
]  # fmt: skip


def leafy() -> Gltf:
    """Materials, textures, vertex colours."""
    gltf = Gltf()
    picture = io.BytesIO()
    Image.fromarray(np.arange(64, dtype=np.uint8).reshape(4, 4, 4)).save(picture, "PNG")
    gltf.add("images", bufferView=gltf.view(picture.getvalue()))
    gltf.add("samplers", wrapS=33071)
    gltf.add("textures", source=0, sampler=0)
    transform = {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 0.1, "scale": [2, 2]}}
    info = {"index": 0, "texCoord": 0, "extensions": transform}
    gltf.add("materials", alphaMode="MASK", alphaCutoff=0.1, pbrMetallicRoughness={"baseColorTexture": info})
    uv = gltf.accessor([[0, 0], [255, 0], [0, 255]], "u1", normalized=True)
    colors = gltf.accessor([[1, 1, 1, 0.5], [1, 1, 1, 1], [1, 1, 1, 1]])
    gltf.mesh(TRIANGLE, [0, 1, 2], attributes={"TEXCOORD_0": uv, "COLOR_0": colors}, material=0)
    return gltf.scene(gltf.node(mesh=0, rotation=[0, 0, 0.6, 0.8], scale=[1, 2, 3], translation=[1, 2, 3]))


def posed() -> Gltf:
    """Sparse values, morph targets, a skin, strips."""
    gltf = Gltf()
    at = gltf.accessor(np.eye(4, 3), sparse=gltf.sparse([1, 2], [[1, 2, 3], [4, 5, 6]]))
    move = gltf.accessor(np.zeros((4, 3)), bufferView=None, sparse=gltf.sparse([3], [[0, 9, 0]], "u1"))
    joints = gltf.accessor([[0, 1, 0, 0]] * 4, "u1")
    weights = gltf.accessor([[255, 0, 0, 0], [128, 127, 0, 0]] * 2, "u1", normalized=True)
    own = {"JOINTS_0": joints, "WEIGHTS_0": weights}
    gltf.mesh(at, [0, 1, 2, 3], mode=5, attributes=own, targets=[{"POSITION": move}], weights=[0.5])
    gltf.node(children=[1, 2])
    gltf.node(translation=[0, 1, 0], children=[3])
    gltf.node(mesh=0, skin=0, weights=[1])
    gltf.node(matrix=np.eye(4).ravel().tolist())
    gltf.add("skins", joints=[1, 3], inverseBindMatrices=gltf.accessor(np.tile(np.eye(4).ravel(), (2, 1))))
    return gltf.scene(0)


def lit() -> Gltf:
    """Instances, cameras, lights, visibility, fans."""
    gltf = Gltf(extensionsUsed=["EXT_mesh_gpu_instancing", "KHR_lights_punctual"])
    listed = [{"type": "point"}, {"type": "spot", "spot": {"outerConeAngle": 0.4}, "range": 3}, {"type": "directional"}]
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": listed}}
    gltf.mesh(np.eye(5, 3), mode=6)
    gltf.add("cameras", type="perspective", perspective={"yfov": 1, "znear": 0.1})
    gltf.add("cameras", type="orthographic", orthographic={"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9})
    placing = {
        "TRANSLATION": gltf.accessor(np.eye(3)),
        "ROTATION": gltf.accessor([[0, 0, 0, 127]] * 3, "i1", normalized=True),
    }
    gltf.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": placing}})
    for i in range(3):
        light = {"KHR_lights_punctual": {"light": i}, "KHR_node_visibility": {"visible": True}}
        gltf.node(camera=i % 2, extensions=light, translation=[0, i, 0])
    return gltf.scene(0, 1, 2, 3)


def compressed() -> Gltf | None:
    """Draco and meshoptimizer, where both are installed."""
    try:
        import DracoPy
        import meshoptimizer
    except ImportError:
        return None
    gltf = Gltf(extensionsUsed=["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
    points = np.random.default_rng(1).normal(size=(9, 3)).astype(np.float32)
    faces = np.array([[0, 1, 2], [2, 3, 4], [5, 6, 7], [6, 7, 8]], np.uint32)
    data = DracoPy.encode(points, faces)
    packed = {"bufferView": gltf.view(data), "attributes": {"POSITION": 0}}
    own = gltf.accessor(points, bufferView=None, count=len(DracoPy.decode(data).points))
    indices = gltf.accessor(faces.ravel(), "u4", bufferView=None)
    gltf.mesh(own, indices, extensions={"KHR_draco_mesh_compression": packed})
    made = []
    for stream, count, stride, mode in (
        (meshoptimizer.encode_vertex_buffer(points, 9, 12), 9, 12, "ATTRIBUTES"),
        (meshoptimizer.encode_index_buffer(faces.ravel(), 12, 9), 12, 4, "TRIANGLES"),
    ):
        view = gltf.view(bytes(stream))
        own_view = {**gltf.json["bufferViews"][view], "count": count, "byteStride": stride, "mode": mode}
        outer = {"buffer": 1, "byteLength": count * stride, "extensions": {"EXT_meshopt_compression": own_view}}
        gltf.json["bufferViews"][view] = outer
        made.append(view)
    gltf.mesh(gltf.accessor(points, bufferView=made[0]), gltf.accessor(faces.ravel(), "u4", bufferView=made[1]))
    gltf.json["buffers"] = [{"byteLength": len(gltf.data)}, {"byteLength": 1000}]
    return gltf.scene(gltf.node(mesh=0), gltf.node(mesh=1))


WHOLE = [gltf for gltf in (leafy(), posed(), lit(), compressed()) if gltf is not None]
FILES = [(json.dumps(gltf.document()), bytes(gltf.data)) for gltf in WHOLE]


def places(value, path=()):
    """All places in a JSON value."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in items:
        yield from places(below, (*path, key))


def changed(document, path, value):
    """The document with a value at a place, or without it."""
    document = copy.deepcopy(document)
    *above, last = path
    holder = document
    for key in above:
        holder = holder[key]
    if value is ...:
        del holder[last]
    else:
        holder[last] = value
    return document


def outcome(path: Path, data: bytes) -> str:
    """What loading says: the name of the error, or "scene". Anything else than these is a failure."""
    path.write_bytes(data)
    tracing = not tracemalloc.is_tracing()
    if tracing:
        tracemalloc.start()
    tracemalloc.reset_peak()
    before, start = tracemalloc.get_traced_memory()[0], time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ShadowlabWarning)
            scene = sl.load_scene(path)
        assert np.isfinite(scene.bounds).all()
        found = "scene"
    except (LoadError, SceneError) as error:
        found, text = type(error).__name__, str(error)
    assert found == "scene" or str(path) in text or "no usable triangle" in text
    used = tracemalloc.get_traced_memory()[1] - before
    if tracing:
        tracemalloc.stop()
    assert used < MOST_BYTES, f"{used:,} bytes"
    assert time.perf_counter() - start < MOST_SECONDS
    return found


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "scene.glb"


@pytest.mark.parametrize("i", range(len(FILES)))
def test_the_files_are_whole(path, i):
    text, data = FILES[i]
    assert outcome(path, glb_of(text.encode(), data)) == "scene"


@settings(max_examples=250, deadline=None)
@given(st.data())
def test_values_of_the_text(path, data):
    text, blob = data.draw(st.sampled_from(FILES))
    document = json.loads(text)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.sampled_from([p for p in places(document) if p]))
        document = changed(document, at, data.draw(st.sampled_from([..., *EVIL])))
    outcome(path, glb_of(json.dumps(document).encode(), blob))


@settings(max_examples=250, deadline=None)
@given(st.data())
def test_bytes(path, data):
    text, blob = data.draw(st.sampled_from(FILES))
    whole = bytearray(glb_of(text.encode(), blob))
    for _ in range(data.draw(st.integers(1, 8))):
        at = data.draw(st.integers(0, len(whole) - 1))
        kind = data.draw(st.sampled_from(["set", "flip", "cut", "insert", "remove"]))
        if kind == "set":
            whole[at] = data.draw(st.integers(0, 255))
        elif kind == "flip":
            whole[at] ^= 1 << data.draw(st.integers(0, 7))
        elif kind == "cut":
            whole = whole[: max(at, 1)]
        elif kind == "insert":
            whole[at:at] = data.draw(st.binary(max_size=9))
        elif len(whole) > 1:
            del whole[at]
    outcome(path, bytes(whole))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_bytes_of_the_buffers(path, data):
    """The text stays, so that what it describes is reached."""
    text, blob = data.draw(st.sampled_from(FILES))
    blob = bytearray(blob)
    for _ in range(data.draw(st.integers(1, 20))):
        blob[data.draw(st.integers(0, len(blob) - 1))] = data.draw(st.sampled_from([0, 1, 127, 128, 254, 255]))
    outcome(path, glb_of(text.encode(), bytes(blob)))


def test_the_helper_notices(path, monkeypatch):
    """Another error passes through it; memory and time are measured."""
    whole = glb_of(FILES[0][0].encode(), FILES[0][1])
    with monkeypatch.context() as patch:
        patch.setattr("test_gltf_fuzz.MOST_BYTES", 10)
        with pytest.raises(AssertionError, match="bytes"):
            outcome(path, whole)
    for error in (ValueError, RecursionError, sl.errors.ArgumentError):

        def load(path, error=error):
            raise error("x")

        with monkeypatch.context() as patch:
            patch.setattr(sl, "load_scene", load)
            with pytest.raises(error):
                outcome(path, whole)


def test_deep_texts(path):
    deep = Gltf()
    deep.scene(deep.node(mesh=deep.mesh()))
    deep.json["extras"] = json.loads("[" * 500 + "]" * 500)
    assert loaded(path.parent, deep).triangle_count == 1
    nested = b'{"asset":{"version":"2.0"},"extras":' + b'{"a":' * 50_000 + b"1" + b"}" * 50_001
    assert outcome(path, nested) == "LoadError"
