"""Geometry of glTF: accessors of every kind, sparse values, strips and fans, against numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import imported
from gltf_support import COMPONENTS, TRIANGLE, Gltf, corners, loaded, told

import shadowlab as sl
from shadowlab.errors import LoadError, SceneError

# Meshes keep 24 bits of their extent.
ROUNDING = 2.0**-22
TOWER = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]


def only(gltf: Gltf, mesh: int = 0) -> Gltf:
    return gltf.scene(gltf.node(mesh=mesh))


@pytest.mark.parametrize("indexed", [True, False])
@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        (4, [[0, 1, 2], [3, 4, 5]]),
        # The order of glTF 2.0: strips turn every other triangle round, fans name their middle last.
        (5, [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]),
        (6, [[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 5, 0]]),
    ],
)
def test_modes(tmp_path, mode, expected, indexed):
    points = np.random.default_rng(1).normal(size=(6, 3)).astype(np.float32)
    order = np.array([3, 1, 4, 0, 5, 2]) if indexed else np.arange(6)
    gltf = Gltf()
    only(gltf, gltf.mesh(points, order if indexed else None, mode=mode))
    np.testing.assert_allclose(corners(loaded(tmp_path, gltf)), points[order][expected], atol=4 * ROUNDING)


def test_strips_and_fans_show_one_side(tmp_path):
    """A flat strip and fan, drawn as glTF says: all normals agree."""
    zigzag = [[i // 2, i % 2, 0] for i in range(9)]
    circle = [[0, 0, 0], *([np.cos(a), np.sin(a), 0] for a in np.linspace(0, 6, 8))]
    for mode, points in ((5, zigzag), (6, circle)):
        gltf = Gltf()
        found = corners(loaded(tmp_path, only(gltf, gltf.mesh(points, mode=mode))))
        normals = np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0])[:, 2]
        assert (np.sign(normals) == np.sign(normals[0])).all()


def test_degenerate_triangles_of_strips_keep_their_rows(tmp_path):
    gltf = Gltf()
    only(gltf, gltf.mesh([*TOWER, [5, 5, 0], [6, 5, 0], [5, 6, 0]], [0, 1, 2, 3, 3, 4, 4, 5, 6], mode=5))
    scene = loaded(tmp_path, gltf)
    assert scene.triangle_count == 7
    assert scene.meshes[0].faces[-1].tolist() != scene.meshes[0].faces[0].tolist()
    np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [6, 6, 0]], atol=1e-6)


@pytest.mark.parametrize(("mode", "word"), [(0, "points"), (1, "lines"), (2, "line loop"), (3, "line strip")])
def test_points_and_lines_are_left_out_and_told(tmp_path, mode, word):
    gltf = Gltf()
    gltf.scene(gltf.node(mesh=gltf.mesh()), gltf.node(mesh=gltf.mesh(np.array(TRIANGLE) * 9, mode=mode, name="wire")))
    scene, text = told(tmp_path, gltf)
    assert scene.bounds[1, 0] == 1
    assert "wire" in text
    assert word in text


@pytest.mark.parametrize("mode", [7, -1, "fan", 4.5, None, True])
def test_other_modes_are_refused(tmp_path, mode):
    gltf = Gltf()
    with pytest.raises(LoadError, match=r"meshes\[0\].primitives\[0\].*mode"):
        loaded(tmp_path, only(gltf, gltf.mesh(mode=mode)))


def test_whole_numbers_may_be_written_with_a_point(tmp_path):
    gltf = Gltf()
    only(gltf, gltf.mesh(mode=4.0))
    gltf.json["scene"] = 0.0
    assert loaded(tmp_path, gltf).triangle_count == 1


@pytest.mark.parametrize("base", [True, False])
@pytest.mark.parametrize("rows", ["u1", "u2", "u4"])
def test_sparse_positions(tmp_path, base, rows):
    gltf = Gltf()
    sparse = gltf.sparse([1, 3], [[7, 0, 0], [1, 5, 0]], rows)
    start = TOWER if base else np.zeros((4, 3))
    at = gltf.accessor(start, sparse=sparse, **({} if base else {"bufferView": None}))
    found = corners(loaded(tmp_path, only(gltf, gltf.mesh(at, [0, 1, 2, 2, 1, 3]))))
    points = np.array(start, float)
    points[[1, 3]] = [[7, 0, 0], [1, 5, 0]]
    np.testing.assert_allclose(found, points[[[0, 1, 2], [2, 1, 3]]], atol=8 * ROUNDING)


def test_sparse_indices_and_a_base_that_two_accessors_share(tmp_path):
    gltf = Gltf()
    first = gltf.accessor([0, 1, 2], "u2")
    view = gltf.json["accessors"][first]["bufferView"]
    second = gltf.accessor([0, 1, 2], "u2", bufferView=view, sparse=gltf.sparse([2], [3], "u1", "u2"))
    points = gltf.accessor(TOWER)
    meshes = [gltf.mesh(points, at) for at in (second, first)]
    gltf.scene(*(gltf.node(mesh=mesh) for mesh in meshes))
    found = corners(loaded(tmp_path, gltf))
    # The sparse value stays with its accessor.
    assert sorted(found[:, 2].tolist()) == [[0, 1, 0], [1, 1, 0]]


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2"])
@pytest.mark.parametrize("normalized", [True, False])
def test_quantised_positions(tmp_path, kind, normalized):
    gltf = Gltf(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    info = np.iinfo(kind)
    stored = np.array([[info.min, 3, 7], [info.max, 100, 0], [5, info.max, 9]], kind)
    # Padded to four bytes, as attributes are.
    padded = np.zeros((3, 4), kind)
    padded[:, :3] = stored
    view = gltf.view(padded.tobytes(), byteStride=padded.strides[0])
    only(gltf, gltf.mesh(gltf.accessor(stored, kind, bufferView=view, normalized=normalized)))
    expected = stored.astype(float)
    if normalized:
        expected = np.maximum(expected / info.max, -1)
    found = corners(loaded(tmp_path, gltf))[0]
    np.testing.assert_allclose(found, expected, atol=ROUNDING * np.abs(expected).max())


def test_interleaved_views_with_offsets(tmp_path):
    gltf = Gltf()
    rows = np.zeros(5, np.dtype([("pad", "<f4"), ("normal", "<f4", 3), ("at", "<f4", 3), ("uv", "<u2", 2)]))
    rows["at"] = np.random.default_rng(2).normal(size=(5, 3))
    rows["pad"], rows["normal"] = 99, 77
    view = gltf.view(b"\x55" * 8 + rows.tobytes(), byteStride=rows.itemsize)
    at = gltf.accessor(rows["at"][1:], bufferView=view, byteOffset=8 + rows.itemsize + 16)
    found = corners(loaded(tmp_path, only(gltf, gltf.mesh(at, [0, 1, 2, 1, 2, 3]))))
    np.testing.assert_allclose(found, rows["at"][1:][[[0, 1, 2], [1, 2, 3]]], atol=8 * ROUNDING)


@pytest.mark.parametrize("kind", ["u1", "u2", "u4"])
def test_indices_of_every_kind(tmp_path, kind):
    gltf = Gltf()
    found = corners(loaded(tmp_path, only(gltf, gltf.mesh(TOWER, [3, 1, 0], kind=kind))))
    np.testing.assert_allclose(found[0], np.array(TOWER)[[3, 1, 0]], atol=ROUNDING)


def test_what_indices_must_not_be(tmp_path):
    for indices, kind, mode, match in (
        ([0, 1, 4], "u2", 4, "'wall'|wall: expected indices below its 4 vertices, got 4 in triangle 0"),
        ([0, 1, 2, 255], "u1", 5, "wall.*255.*restarts"),
        ([0, 1, 2, 65535], "u2", 6, "wall.*65535.*restarts"),
        ([0, 1, 2, 9], "u1", 5, "wall.*got 9 in triangle 1"),
    ):
        gltf = Gltf()
        with pytest.raises(SceneError, match=match):
            loaded(tmp_path, only(gltf, gltf.mesh(TOWER, indices, kind=kind, mode=mode, name="wall")))
    gltf = Gltf()
    with pytest.raises(LoadError, match="componentType"):
        loaded(tmp_path, only(gltf, gltf.mesh(TOWER, gltf.accessor([0.0, 1, 2]))))


def test_left_over_vertices_are_told(tmp_path):
    gltf = Gltf()
    scene, text = told(tmp_path, only(gltf, gltf.mesh(TOWER, name="odd")))
    assert scene.triangle_count == 1
    assert "1 of the vertices of odd" in text


def test_a_primitive_without_positions_or_triangles_is_told(tmp_path):
    gltf = Gltf()
    gltf.add("meshes", primitives=[{"attributes": {"NORMAL": gltf.accessor(TRIANGLE)}}], name="bare")
    gltf.mesh(TRIANGLE[:2], mode=5, name="short")
    gltf.add("meshes", name="hollow", primitives=[])
    gltf.mesh([[np.nan] * 3] * 3, name="lost")
    gltf.scene(*(gltf.node(mesh=mesh) for mesh in (0, 1, 2, 3, gltf.mesh())))
    scene, text = told(tmp_path, gltf)
    assert scene.triangle_count == 1
    assert all(name in text for name in ("bare (no positions)", "short", "hollow", "lost", "1 face"))
    gltf = Gltf()
    gltf.mesh(TRIANGLE[:2], mode=5, name="short")
    with pytest.raises(SceneError, match="short"):
        loaded(tmp_path, gltf.scene(gltf.node(mesh=0)))


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda a, v: a.update(count=4), r"accessors\[0\].*4 elements of 12 bytes"),
        (lambda a, v: a.update(byteOffset=4), r"accessors\[0\]"),
        (lambda a, v: a.update(byteOffset=2**62), r"accessors\[0\]"),
        (lambda a, v: a.update(count=10**10), "elements.*10,000,000,000"),
        (lambda a, v: a.update(count=2**70), "elements"),
        (lambda a, v: a.update(count=900_000_000, bufferView=0), "900,000,000"),
        (lambda a, v: (a.pop("bufferView"), a.update(count=900_000_000)), "ratio|for each byte"),
        (lambda a, v: a.update(count=-1), "count"),
        (lambda a, v: a.update(count="3"), "count"),
        (lambda a, v: a.update(componentType=5124), "componentType"),
        (lambda a, v: a.update(type="VEC2"), "type: expected VEC3"),
        (lambda a, v: a.update(type=["VEC3"]), "type"),
        (lambda a, v: a.update(bufferView=7), "bufferView"),
        (lambda a, v: a.update(normalized=1), "normalized"),
        (lambda a, v: v.update(byteLength=35), "36|35"),
        (lambda a, v: v.update(byteLength=4000), r"bufferViews\[0\]"),
        (lambda a, v: v.update(byteOffset=1), r"bufferViews\[0\]"),
        (lambda a, v: v.update(byteOffset=-1), "byteOffset"),
        (lambda a, v: v.update(buffer=1), "buffer"),
        (lambda a, v: v.update(byteStride=8), "byteStride"),
        (lambda a, v: v.update(byteStride=252), "252 apart"),
        (lambda a, v: v.update(byteStride=10**9), "byteStride"),
        (lambda a, v: v.update(byteStride=0), "byteStride"),
        (lambda a, v: v.clear(), "buffer"),
        (lambda a, v: a.clear(), "componentType"),
        (lambda a, v: a.update(sparse=[]), "sparse"),
        (lambda a, v: a.update(sparse={"count": 1}), "indices|values"),
        (lambda a, v: a.update(sparse={"count": 9, "indices": {}, "values": {}}), "count.*at most the 3"),
    ],
)
def test_broken_accessors_are_refused_by_name(tmp_path, change, match):
    gltf = Gltf()
    only(gltf, gltf.mesh(name="thing"))
    change(gltf.json["accessors"][0], gltf.json["bufferViews"][0])
    with pytest.raises(LoadError, match=match):
        loaded(tmp_path, gltf)


def test_sparse_rows_out_of_range(tmp_path):
    gltf = Gltf()
    at = gltf.accessor(TRIANGLE, sparse=gltf.sparse([0, 3], [[0, 0, 0]] * 2))
    with pytest.raises(LoadError, match=r"sparse.indices.*below the 3 elements.*got 3"):
        loaded(tmp_path, only(gltf, gltf.mesh(at)))


def test_a_last_element_without_its_padding(tmp_path):
    """The last element of an interleaved view may end before its stride does."""
    gltf = Gltf()
    data = b"".join(np.array(p, "<f4").tobytes() + b"\0" * 4 for p in TRIANGLE)[:-4]
    at = gltf.accessor(TRIANGLE, bufferView=gltf.view(data, byteStride=16))
    np.testing.assert_allclose(corners(loaded(tmp_path, only(gltf, gltf.mesh(at))))[0], TRIANGLE, atol=ROUNDING)


def test_coordinates_in_single_precision_far_away(tmp_path):
    points = np.array([[5e5, 0, 4.6e6], [5e5 + 8, 0, 4.6e6], [5e5, 9, 4.6e6]], np.float32)
    gltf = Gltf()
    found = corners(loaded(tmp_path, only(gltf, gltf.mesh(points))))[0]
    np.testing.assert_allclose(found, points.astype(float), rtol=0, atol=1e-6)


def test_against_pygltflib_and_numpy(tmp_path):
    """A forest of random nodes over meshes of every index kind, placed by another reader of the document."""
    pygltflib = imported("pygltflib")
    rng = np.random.default_rng(7)
    gltf = Gltf()
    for kind in ("u1", "u2", "u4"):
        gltf.mesh(rng.normal(size=(9, 3)), rng.integers(0, 9, 12), kind=kind)
    for i in range(30):
        turn = rng.normal(size=4)
        fields = {
            "translation": rng.normal(size=3).tolist(),
            "rotation": (turn / np.linalg.norm(turn)).tolist(),
            "scale": rng.normal(size=3).tolist(),
        }
        if i % 4 == 0:
            matrix = np.eye(4)
            matrix[:3] = rng.normal(size=(3, 4))
            fields = {"matrix": matrix.T.ravel().tolist()}
        children = [c for c in (2 * i + 1, 2 * i + 2) if c < 30]
        gltf.node(mesh=int(rng.integers(3)), **fields, **({"children": children} if children else {}))
    path = tmp_path / "scene.glb"
    path.write_bytes(gltf.scene(0).glb())
    theirs = pygltflib.GLTF2().load(str(path))
    blob = theirs.binary_blob()

    def array(index):
        accessor = theirs.accessors[index]
        view = theirs.bufferViews[accessor.bufferView]
        kind = {number: name for name, number in COMPONENTS.items()}[accessor.componentType]
        values = np.frombuffer(
            blob, "<" + kind, accessor.count * (3 if accessor.type == "VEC3" else 1), view.byteOffset
        )
        return values.reshape(accessor.count, -1)

    transformations = imported("trimesh").transformations
    expected = []

    def walk(index, above):
        node = theirs.nodes[index]
        if node.matrix is not None:
            own = np.array(node.matrix).reshape(4, 4).T
        else:
            x, y, z, w = node.rotation
            own = transformations.translation_matrix(node.translation)
            own = own @ transformations.quaternion_matrix([w, x, y, z]) @ np.diag([*node.scale, 1])
        world = above @ own
        (primitive,) = theirs.meshes[node.mesh].primitives
        points = array(primitive.attributes.POSITION).astype(float)
        placed = points @ world[:3, :3].T + world[:3, 3]
        expected.append(placed[array(primitive.indices).ravel().reshape(-1, 3)])
        for child in node.children:
            walk(child, world)

    walk(0, np.eye(4))
    everything = np.concatenate(expected)
    scene = loaded(tmp_path, path.read_bytes())
    found = corners(scene)
    assert found.shape == everything.shape
    size = np.abs(everything).max()
    key = [np.round(a.reshape(len(a), 9) / size, 5) for a in (found, everything)]
    order = [np.lexsort(k.T) for k in key]
    np.testing.assert_allclose(found[order[0]], everything[order[1]], atol=4 * ROUNDING * size)
    assert (scene.mesh_count, scene.instance_count) == (3, 30)


def test_primitives_are_named_in_errors_and_kept_apart(tmp_path):
    gltf = Gltf()
    gltf.mesh(name="pair")
    second = {"attributes": {"POSITION": gltf.accessor(TOWER)}, "indices": gltf.accessor([0, 1, 9], "u2")}
    gltf.json["meshes"][0]["primitives"].append(second)
    with pytest.raises(SceneError, match="pair, primitive 1"):
        loaded(tmp_path, only(gltf))


def test_limits_of_accessors_do_not_hold_for_what_is_not_used(tmp_path):
    gltf = Gltf()
    only(gltf, gltf.mesh())
    gltf.accessor(TRIANGLE, count=10**10)
    gltf.json["meshes"].append({"primitives": [{"attributes": {"POSITION": 1}}]})
    assert loaded(tmp_path, gltf).triangle_count == 1
    assert isinstance(sl.load_scene(tmp_path / "scene.glb"), sl.Scene)


@pytest.mark.parametrize("kind", ["f4", "u2"])
def test_many_primitives_that_share_vertices(tmp_path, kind):
    """Each takes a few of them; its mesh is that of all of them, with the same triangles."""
    points = np.random.default_rng(5).integers(0, 1000, (500, 3))
    gltf = Gltf()
    padded = np.zeros((500, 4), kind)
    padded[:, :3] = points
    at = gltf.accessor(points, kind, bufferView=gltf.view(padded.tobytes(), byteStride=padded.strides[0]))
    orders = [np.random.default_rng(i).integers(0, 500, 6) for i in range(20)]
    for order in orders:
        gltf.mesh(at, order)
    scene = loaded(tmp_path, gltf.scene(*(gltf.node(mesh=i) for i in range(20))))
    for mesh, order in zip(scene.meshes, orders, strict=True):
        assert mesh == sl.Scene.from_arrays(points.astype(float), order.reshape(-1, 3)).meshes[0]
    gltf.json["accessors"][-1]["count"] = 3
    gltf.data[-12:-10] = b"\xff\xff"
    with pytest.raises(SceneError, match="65535"):
        loaded(tmp_path, gltf)
