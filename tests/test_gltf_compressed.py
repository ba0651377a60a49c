"""Compressed glTF: Draco and meshoptimizer, decoded where their packages are installed, else refused by name."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from conftest import imported
from gltf_support import TRIANGLE, Gltf, corners, loaded, told

from shadowlab.errors import LoadError, SceneError
from shadowlab.scene.gltf.meshopt import filtered

DRACO = "KHR_draco_mesh_compression"
POINTS = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 1]], np.float32)
FACES = np.array([[0, 1, 2], [2, 1, 3]], np.uint32)
INSTALL = r"pip install 'shadowlab\[compressed\]'"


@pytest.fixture
def no_decoders(monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)


def draco(data: bytes, *, required=True, fallback=False, **attributes) -> Gltf:
    gltf = Gltf(extensionsUsed=[DRACO], **({"extensionsRequired": [DRACO]} if required else {}))
    own = {} if fallback else {"bufferView": None}
    at = gltf.accessor(POINTS, **own)
    indices = gltf.accessor(FACES.ravel(), "u4", **own)
    packed = {"bufferView": gltf.view(data), "attributes": {"POSITION": 0, **attributes}}
    gltf.mesh(at, indices, extensions={DRACO: packed}, name="packed")
    gltf.scene(gltf.node(mesh=0), gltf.node(mesh=gltf.mesh()))
    return gltf


def encoded(**more) -> bytes:
    return imported("DracoPy").encode(POINTS, FACES, quantization_bits=16, preserve_order=True, **more)


@pytest.mark.parametrize("required", [True, False])
def test_draco_is_decoded(tmp_path, required):
    scene = loaded(tmp_path, draco(encoded(), required=required))
    found = {tuple(map(tuple, np.round(c[np.lexsort(c.T)], 3))) for c in corners(scene)}
    expected = {
        tuple(map(tuple, c[np.lexsort(c.T)].astype(float))) for c in [*POINTS[FACES], np.array(TRIANGLE, float)]
    }
    assert found == expected


def test_draco_with_other_attributes_and_ids(tmp_path):
    # Texture coordinates come first, so the positions' identity is another.
    data = encoded(tex_coord=np.zeros((4, 2)))
    (identity,) = [a["unique_id"] for a in imported("DracoPy").decode(data).attributes if a["attribute_type"] == 0]
    assert identity != 0
    scene = loaded(tmp_path, draco(data, POSITION=identity))
    np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [4, 2, 1]], atol=1e-3)
    with pytest.raises(LoadError, match=r"POSITION.*identity"):
        loaded(tmp_path, draco(data, POSITION=9))


def test_draco_data_that_do_not_fit(tmp_path):
    imported("DracoPy")
    for data in (b"DRACO", encoded()[:40], b"\0" * 100, encoded()[:20] + b"\xff" * 30):
        with pytest.raises(LoadError, match=DRACO):
            loaded(tmp_path, draco(data))
    gltf = draco(encoded())
    gltf.json["accessors"][0]["count"] = 5
    with pytest.raises(LoadError, match="expected 5 elements of 3 components"):
        loaded(tmp_path, gltf)
    points = imported("DracoPy").encode(POINTS)
    with pytest.raises(LoadError, match="point cloud"):
        loaded(tmp_path, draco(points))


def test_without_a_decoder_draco_is_refused_or_told(tmp_path, no_decoders):
    data = b"DRACO"
    with pytest.raises(LoadError, match=f"{DRACO}.*{INSTALL}"):
        loaded(tmp_path, draco(data))
    scene, text = told(tmp_path, draco(data, required=False))
    assert scene.triangle_count == 1
    assert "packed" in text
    assert DRACO in text
    assert "pip install" in text
    # Data without compression beside it: nothing is missing, and nothing is said.
    assert loaded(tmp_path, draco(data, required=False, fallback=True)).triangle_count == 3
    gltf = draco(data, required=False)
    gltf.json["scenes"][0]["nodes"] = [0]
    with pytest.raises(SceneError, match=DRACO):
        loaded(tmp_path, gltf)


EXTENSIONS = ["EXT_meshopt_compression", "KHR_meshopt_compression"]


class Meshopt:
    """A document whose views are compressed; the buffer without compression has no bytes, unless it is a fallback."""

    def __init__(self, name=EXTENSIONS[0], *, required=True, fallback=None):
        self.name, self.fallback = name, bytearray()
        self.gltf = Gltf(extensionsUsed=[name], **({"extensionsRequired": [name]} if required else {}))
        self.of_fallback = {"extensions": {name: {"fallback": True}}} if fallback is None else {"uri": fallback}

    def view(self, stream: bytes, raw: bytes, count: int, stride: int, mode: str, **more) -> int:
        at = self.gltf.view(stream)
        packed = self.gltf.json["bufferViews"][at]
        offset = len(self.fallback)
        self.fallback += raw
        packed = {**packed, "byteStride": stride, "count": count, "mode": mode, **more}
        fields = {"byteStride": stride} if mode == "ATTRIBUTES" else {}
        self.gltf.json["bufferViews"][at] = {
            "buffer": 1, "byteOffset": offset, "byteLength": count * stride, **fields,
            "extensions": {self.name: packed},
        }  # fmt: skip
        return at

    def done(self) -> Gltf:
        self.gltf.json["buffers"] = [
            {"byteLength": len(self.gltf.data)},
            {"byteLength": max(len(self.fallback), 1), **self.of_fallback},
        ]
        return self.gltf


def grid(side=12):
    """Points and triangles of a bumpy square."""
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    points = np.stack([x, y, np.sin(x + 2.0 * y)], axis=-1).reshape(-1, 3).astype(np.float32)
    a = (x[:-1, :-1] * side + y[:-1, :-1]).ravel()
    faces = np.concatenate([np.column_stack([a, a + 1, a + side]), np.column_stack([a + side, a + 1, a + side + 1])])
    return points, faces.astype(np.uint32)


def same_triangles(found, expected, atol):
    """Equal up to the first corner of each triangle, which the codec of triangles may turn."""
    assert found.shape == expected.shape
    turned = np.stack([np.roll(expected, k, axis=1) for k in range(3)])
    assert (np.abs(found - turned).max(axis=(2, 3)).min(axis=0) <= atol).all()


@pytest.mark.parametrize("name", EXTENSIONS)
@pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
@pytest.mark.parametrize("stride", [2, 4])
def test_meshopt_streams(tmp_path, name, mode, stride):
    codec = imported("meshoptimizer")
    points, faces = grid()
    document = Meshopt(name)
    gltf = document.gltf
    stream = codec.encode_vertex_buffer(points, len(points), 12)
    at = gltf.accessor(points, bufferView=document.view(stream, b"", len(points), 12, "ATTRIBUTES"))
    encode = codec.encode_index_buffer if mode == "TRIANGLES" else codec.encode_index_sequence
    stream = encode(faces.ravel(), faces.size, len(points))
    kind = {2: "u2", 4: "u4"}[stride]
    view = document.view(stream, b"", faces.size, stride, mode)
    gltf.mesh(at, gltf.accessor(faces.ravel(), kind, bufferView=view))
    found = corners(loaded(tmp_path, document.done().scene(gltf.node(mesh=0))))
    same_triangles(found, points[faces].astype(float), 1e-5)


def test_meshopt_exponential_filter_in_a_file(tmp_path):
    codec = imported("meshoptimizer")
    points = np.array([[0, 0, 0], [8, 0, 0], [0, -3, 0.5]], np.float32)
    # Mantissas in halves: exponent -1 in the high byte.
    words = ((-1 & 0xFF) << 24 | (np.round(points * 2).astype(np.int64) & 0xFFFFFF)).astype("<u4")
    document = Meshopt()
    stream = codec.encode_vertex_buffer(words, 3, 12)
    view = document.view(stream, b"", 3, 12, "ATTRIBUTES", filter="EXPONENTIAL")
    document.gltf.mesh(document.gltf.accessor(points, bufferView=view))
    found = corners(loaded(tmp_path, document.done().scene(document.gltf.node(mesh=0))))
    np.testing.assert_allclose(found[0], points, atol=1e-6)


def test_meshopt_quaternions_turn_instances(tmp_path):
    codec = imported("meshoptimizer")
    # A quarter turn about z: z = w; w is left out (3), its bits beside a one of 15 bits.
    one = 32767
    stored = np.array([[0, 0, one, (one & ~3) | 3]], "<i2")
    document = Meshopt()
    gltf = document.gltf
    stream = codec.encode_vertex_buffer(stored, 1, 8)
    view = document.view(stream, b"", 1, 8, "ATTRIBUTES", filter="QUATERNION")
    turn = gltf.accessor([[0, 0, 0, 0]], "i2", bufferView=view, normalized=True)
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turn}}}
    gltf.mesh(np.array([[0, 0, 0], [9, 0, 0], [0, 1, 0]], np.float32))
    scene = loaded(tmp_path, document.done().scene(gltf.node(mesh=0, extensions=extension)))
    np.testing.assert_allclose(scene.bounds, [[-1, 0, 0], [0, 9, 0]], atol=1e-3)


@pytest.mark.parametrize(
    ("name", "decode", "stride"),
    [("OCTAHEDRAL", "decode_filter_oct", 4), ("OCTAHEDRAL", "decode_filter_oct", 8),
     ("QUATERNION", "decode_filter_quat", 8), ("EXPONENTIAL", "decode_filter_exp", 16)],
)  # fmt: skip
def test_filters_against_meshoptimizer(name, decode, stride):
    codec = imported("meshoptimizer")
    rng = np.random.default_rng(3)
    count = 500
    kind = {4: "<i1", 8: "<i2", 16: "<i4"}[stride]
    if name == "EXPONENTIAL":
        raw = (rng.integers(-60, 60, (count, 4)) << 24 | rng.integers(0, 1 << 24, (count, 4))).astype("<i4")
    else:
        one = 127 if stride == 4 else 2047
        v = rng.normal(size=(count, 3))
        v /= np.abs(v).sum(axis=1, keepdims=True) if name == "OCTAHEDRAL" else 1.01 * np.linalg.norm(v, axis=1)[:, None]
        raw = np.round(v[:, [0, 1, 2, 2]] * one).astype(kind)
        if name == "OCTAHEDRAL":
            raw[:, 2] = one
        else:
            raw[:, 3] = (one & ~3) | rng.integers(0, 4, count)
    bytes_ = np.ascontiguousarray(raw).view(np.uint8).ravel()
    ours = filtered(name, bytes_, count, stride)
    theirs = getattr(codec, decode)(bytes_.copy(), count, stride)
    theirs = np.frombuffer(np.ascontiguousarray(theirs).tobytes(), ours.dtype).reshape(ours.shape)
    if name == "EXPONENTIAL":
        np.testing.assert_array_equal(ours, theirs)
    else:
        assert np.abs(ours.astype(int) - theirs.astype(int)).max() <= 1


def test_the_color_filter_by_hand():
    # White and half: y 127, differences 0, alpha bits 64 + 63: scale 255 / 127.
    raw = np.array([[127, 0, 0, 127], [63, 0, 0, 64]], np.uint8).view(np.uint8).ravel()
    found = filtered("COLOR", raw, 2, 4)
    assert found[0].tolist() == [255, 255, 255, 255]
    assert found[1, 3] == 0


def test_a_fallback_is_read_where_compression_is_not_required(tmp_path, no_decoders):
    points, faces = grid(4)
    document = Meshopt(required=False, fallback="plain.bin")
    gltf = document.gltf
    raw = points.tobytes()
    at = gltf.accessor(points, bufferView=document.view(b"broken!!", raw, len(points), 12, "ATTRIBUTES"))
    gltf.mesh(at, faces.ravel())
    (tmp_path / "plain.bin").write_bytes(raw)
    found = corners(loaded(tmp_path, document.done().scene(gltf.node(mesh=0))))
    np.testing.assert_allclose(found, points[faces], atol=1e-5)


def test_without_a_decoder_meshopt_is_refused(tmp_path, no_decoders):
    for required in (True, False):
        document = Meshopt(required=required)
        view = document.view(b"\xa0" * 40, b"", 3, 12, "ATTRIBUTES")
        document.gltf.mesh(document.gltf.accessor(TRIANGLE, bufferView=view))
        with pytest.raises(LoadError, match=f"EXT_meshopt_compression.*{INSTALL}"):
            loaded(tmp_path, document.done().scene(document.gltf.node(mesh=0)))


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"mode": "ZIP"}, "mode"),
        ({"filter": "SEPIA"}, "filter"),
        ({"filter": "QUATERNION"}, "byteStride"),
        ({"mode": "TRIANGLES"}, "byteStride"),
        ({"mode": "INDICES", "filter": "EXPONENTIAL"}, "filter"),
        ({"byteStride": 10, "count": 3}, "byteLength"),
        ({"count": 10**12}, "byteLength"),
        ({"buffer": 7}, "buffer"),
        ({"byteLength": 10**6}, "bytes"),
        ({}, "could not decode"),
    ],
)
def test_broken_compression(tmp_path, change, match):
    imported("meshoptimizer")
    document = Meshopt()
    view = document.view(b"\xff" * 40, b"", 3, 12, "ATTRIBUTES")
    document.gltf.json["bufferViews"][view]["extensions"][EXTENSIONS[0]].update(change)
    document.gltf.mesh(document.gltf.accessor(TRIANGLE, bufferView=view))
    with pytest.raises(LoadError, match=match):
        loaded(tmp_path, document.done().scene(document.gltf.node(mesh=0)))
