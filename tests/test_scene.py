"""Scenes from arrays, trimesh objects and files: what comes in, what is left out, what is refused."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import shadowlab as sl
from shadowlab.errors import ArgumentError, LoadError, SceneError, ShadowlabWarning

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]])
FACE = np.array([[0, 1, 2]])


def two_boxes() -> trimesh.Scene:
    """One box placed three times: as it is, mirrored and moved, sheared."""
    scene = trimesh.Scene()
    box = trimesh.creation.box((1, 2, 3))
    scene.add_geometry(box, node_name="a", geom_name="box")
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[:3, 3] = 5, 0, 0
    scene.graph.update(frame_to="b", matrix=mirrored, geometry="box")
    sheared = np.eye(4)
    sheared[0, 1] = 0.5
    sheared[2, 3] = -7
    scene.graph.update(frame_to="c", matrix=sheared, geometry="box")
    return scene


def test_shared_geometry_stays_shared_and_bounds_are_exact():
    source = two_boxes()
    scene = sl.Scene.from_trimesh(source)
    assert (scene.mesh_count, scene.instance_count, scene.triangle_count) == (1, 3, 36)
    np.testing.assert_allclose(scene.bounds, source.bounds, atol=1e-6)
    vertices, faces = scene.to_arrays()
    baked = source.to_mesh()
    got = trimesh.Trimesh(vertices, faces, process=False)
    assert got.area == pytest.approx(baked.area, rel=1e-6)


def test_unreferenced_vertices_have_no_say_in_the_bounds():
    scene = sl.Scene.from_arrays(np.vstack([TRIANGLE, [[1e6, 1e6, 1e6]]]), FACE)
    np.testing.assert_array_equal(scene.bounds, [[0, 0, 0], [1, 2, 0]])


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("offset", [(0, 0, 0), (5e5, 4.6e6, 120.0)])
def test_bounds_at_any_scale_and_place(scale, offset):
    vertices = TRIANGLE * scale + np.asarray(offset) * scale
    scene = sl.Scene.from_arrays(vertices, FACE)
    np.testing.assert_allclose(scene.bounds, [vertices.min(0), vertices.max(0)], rtol=0, atol=2.0**-23 * scale)


def test_faces_with_bad_vertices_are_counted_in_a_warning():
    vertices = np.vstack([TRIANGLE, [[np.nan, 0, 0], [np.inf, 0, 0]]])
    with pytest.warns(ShadowlabWarning, match="2 faces"):
        scene = sl.Scene.from_arrays(vertices, [[0, 1, 3], [0, 1, 2], [0, 4, 2]])
    assert (scene.triangle_count, scene.dropped_faces) == (1, 2)
    assert np.isfinite(scene.bounds).all()


def test_geometry_that_is_no_mesh_is_named_in_the_warning():
    source = trimesh.Scene()
    source.add_geometry(trimesh.creation.box(), geom_name="box")
    source.add_geometry(trimesh.PointCloud(np.zeros((4, 3))), geom_name="dots")
    with pytest.warns(ShadowlabWarning, match="dots"):
        assert sl.Scene.from_trimesh(source).triangle_count == 12
    only_dots = trimesh.Scene(trimesh.PointCloud(np.random.default_rng(0).random((4, 3))))
    with pytest.warns(ShadowlabWarning), pytest.raises(SceneError, match="no usable triangle"):
        sl.Scene.from_trimesh(only_dots)


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "match"),
    [
        (TRIANGLE, [[0, 1, 3]], SceneError, "vertex 3"),
        (TRIANGLE, [[0, 1, -1]], SceneError, "vertex -1"),
        (TRIANGLE, np.zeros((0, 3), int), SceneError, "no face"),
        (np.zeros((0, 3)), np.zeros((0, 3), int), SceneError, "no usable triangle"),
        (TRIANGLE * np.nan, FACE, SceneError, "non-finite"),
        (TRIANGLE[:, :2], FACE, ArgumentError, r"vertices.*\(N, 3\).*\[3, 2\]"),
        (TRIANGLE, FACE[:, :2], ArgumentError, r"faces.*\(N, 3\)"),
        (TRIANGLE, FACE + 0.5, ArgumentError, "faces.*int64"),
        ("nonsense", FACE, ArgumentError, "vertices"),
        (None, FACE, ArgumentError, "vertices"),
        (TRIANGLE * 1e200, FACE, ArgumentError, "scale the scene down"),
    ],
)
def test_bad_arrays(vertices, faces, error, match):
    with pytest.raises(error, match=match):
        sl.Scene.from_arrays(vertices, faces)


@pytest.mark.parametrize("dtype", [np.int8, np.uint16, np.int32, np.uint32, np.int64, np.uint64])
def test_any_integer_indices_will_do(dtype):
    assert sl.Scene.from_arrays(TRIANGLE.astype(np.float32), FACE.astype(dtype)).triangle_count == 1


def test_arrays_may_be_strided_or_fortran_ordered():
    wide = np.zeros((3, 6))
    wide[:, ::2] = TRIANGLE
    for vertices in (wide[:, ::2], np.asfortranarray(TRIANGLE)):
        np.testing.assert_array_equal(sl.Scene.from_arrays(vertices, FACE).bounds, [[0, 0, 0], [1, 2, 0]])


def test_projective_transform_is_refused():
    mesh = sl._core.Mesh(TRIANGLE, FACE)
    projective = np.eye(4)
    projective[3, 2] = 1
    with pytest.raises(ArgumentError, match="last row"):
        sl.Scene([mesh], [0], projective[None])
    with pytest.raises(ArgumentError, match="16 finite numbers"):
        sl.Scene([mesh], [0], np.diag([np.nan, 1, 1, 1])[None])
    with pytest.raises(ArgumentError, match="the place of one of the 1 meshes"):
        sl.Scene([mesh], [1], np.eye(4)[None])
    with pytest.raises(SceneError, match="no instance"):
        sl.Scene([mesh], [], np.zeros((0, 4, 4)))


def test_ground_and_joining():
    scene = sl.Scene.from_arrays(TRIANGLE, FACE)
    grounded = scene.with_ground()
    assert (grounded.triangle_count, grounded.instance_count) == (3, 2)
    low, high = grounded.bounds
    assert low[1] == 0
    assert high[0] - low[0] == pytest.approx(12 * 2)
    placed = scene.with_ground(height=-3, size=10)
    assert placed.bounds[0, 1] == -3
    assert (placed.bounds[1] - placed.bounds[0])[0] == pytest.approx(10)
    assert scene.with_ground(up="z").bounds[1, 1] > 2
    assert (scene + scene + scene).instance_count == 3
    for bad in ({"height": np.nan}, {"size": 0}, {"size": -1}, {"size": np.inf}, {"up": "x"}):
        with pytest.raises(ArgumentError):
            scene.with_ground(**bad)


def test_the_ground_faces_up():
    for up, axis in (("y", 1), ("z", 2)):
        grounded = sl.Scene.from_arrays(TRIANGLE, FACE).with_ground(up=up)
        ground = grounded.meshes[1]
        a, b, c = (ground.vertices[i] for i in ground.faces[0])
        assert np.cross(b - a, c - a)[axis] > 0


def test_turning_z_up():
    np.testing.assert_array_equal(sl.turned([1, 2, 3], up="z"), [1, 3, -2])
    np.testing.assert_array_equal(sl.turned([[1, 2, 3]], up="y"), [[1, 2, 3]])


@pytest.mark.parametrize("ending", ["glb", "ply", "obj", "stl", "off", "3mf"])
def test_every_common_format_loads(tmp_path: Path, ending):
    path = tmp_path / f"box.{ending}"
    trimesh.Scene(trimesh.creation.box((1, 2, 3))).export(path) if ending in ("glb", "3mf") else (
        trimesh.creation.box((1, 2, 3)).export(path)
    )
    # 3MF states millimetres; the numbers of the file are asked for.
    scene = sl.load_scene(path, unit=1)
    assert scene.triangle_count == 12
    np.testing.assert_allclose(np.sort(np.ptp(scene.bounds, axis=0)), [1, 2, 3], rtol=1e-6)
    turned = sl.load_scene(path, up="z", unit=1)
    np.testing.assert_allclose(np.ptp(turned.bounds, axis=0), np.ptp(scene.bounds, axis=0)[[0, 2, 1]], rtol=1e-6)


def test_files_that_are_no_meshes(tmp_path: Path):
    cases = {
        "missing.ply": None,
        "empty.ply": b"",
        "broken.glb": b"glTF" + bytes(40),
        "broken.ply": b"ply\nformat ascii 1.0\nelement vertex 3\n",
        "text.stl": b"hello",
        "notes.txt": b"hello",
        "noending": b"hello",
        "empty.obj": b"# nothing\n",
    }
    for name, content in cases.items():
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        with pytest.raises((LoadError, SceneError), match=name if name != "text.stl" else "."):
            sl.load_scene(path)
    with pytest.raises(LoadError, match="directory"):
        sl.load_scene(tmp_path)
    with pytest.raises(OSError, match="nothing there"):
        sl.load_scene(tmp_path / "missing.ply")
    with pytest.raises(ArgumentError, match="'y' or 'z'"):
        sl.load_scene(tmp_path / "missing.ply", up="x")


def test_index_out_of_range_in_a_file(tmp_path: Path):
    path = tmp_path / "range.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    with pytest.raises((SceneError, LoadError)):
        sl.load_scene(path)


def test_what_a_scene_says_of_itself():
    scene = sl.Scene.from_arrays(TRIANGLE, FACE)
    assert "1 triangles" in repr(scene)
    assert "<table>" in scene._repr_html_()
