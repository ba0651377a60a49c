"""Loaded scenes against what trimesh itself says of them: bounds, areas, transforms of shared geometry."""

import numpy as np
import pytest
import trimesh
from trimesh.transformations import rotation_matrix, shear_matrix

import shadowlab as sl

# A mesh's vertices are kept as float32 relative to the middle of the mesh: half a unit in the last place of its half
# diagonal, and twice that for the order of the products.
ROUNDING = 3 * 2.0**-24

FORMATS = ("glb", "gltf", "ply", "obj", "stl", "off", "3mf")


def _graph() -> trimesh.Scene:
    """A scene graph: two geometries, seven placements: moved, turned, scaled, mirrored, sheared, nested."""
    scene = trimesh.Scene()
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    ball = trimesh.creation.icosphere(2, radius=0.7)
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[:3, 3] = (5, 0, 0)
    sheared = shear_matrix(0.4, (1, 0, 0), (0, 0, 0), (0, 1, 0))
    sheared[:3, 3] += (0, 6, 0)
    stretched = np.diag([0.2, 3.0, 1.0, 1.0])
    stretched[:3, 3] = (0, 0, -7)
    turned = rotation_matrix(0.8, (1, 2, 3), (0.5, 0, 0))
    turned[:3, 3] += (-4, 1, 0)
    scene.add_geometry(box, "box at home", "box")
    for name, transform in (("mirrored", mirrored), ("sheared", sheared), ("turned", turned)):
        scene.graph.update(frame_to=name, matrix=transform, geometry="box")
    scene.add_geometry(ball, "stretched ball", "ball", transform=stretched)
    # A child of a sheared parent, mirrored within it.
    scene.graph.update(frame_to="child", frame_from="sheared", matrix=mirrored @ turned, geometry="ball")
    scene.graph.update(frame_to="grandchild", frame_from="child", matrix=turned, geometry="box")
    return scene


def _close(scene: sl.Scene, reference: trimesh.Scene | trimesh.Trimesh, turn=None) -> None:
    """The scene has the reference's triangles, each corner in its place, up to the order of the triangles."""
    baked = reference.to_mesh() if isinstance(reference, trimesh.Scene) else reference
    expected = np.asarray(baked.vertices, np.float64)
    if turn is not None:
        expected = trimesh.transform_points(expected, turn)
    expected = expected[baked.faces]
    vertices, faces = scene.to_arrays()
    assert vertices.dtype == np.float64
    assert faces.dtype == np.int32
    ours = vertices[faces]
    assert ours.shape == expected.shape
    size = np.abs(expected).max()
    tolerance = ROUNDING * size
    used = expected.reshape(-1, 3)
    np.testing.assert_allclose(scene.bounds, [used.min(axis=0), used.max(axis=0)], rtol=0, atol=tolerance)

    def areas(corner):
        return 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)

    longest = np.linalg.norm(expected - np.roll(expected, 1, axis=1), axis=2).max()
    np.testing.assert_allclose(np.sort(areas(ours)), np.sort(areas(expected)), rtol=0, atol=4 * tolerance * longest)
    np.testing.assert_allclose(areas(ours).sum(), areas(expected).sum(), rtol=1e-6)
    # Triangle by triangle: each has its partner among the others.
    apart = np.linalg.norm(ours.mean(axis=1)[:, None] - expected.mean(axis=1), axis=2)
    partner = apart.argmin(axis=1)
    assert sorted(set(partner)) == sorted(set(range(len(expected))))
    assert apart.min(axis=1).max() <= 2 * tolerance
    corners = np.sort(ours.reshape(len(ours), -1)) - np.sort(expected[partner].reshape(len(ours), -1))
    assert np.abs(corners).max() <= 2 * tolerance


def test_a_scene_graph_with_shared_geometry():
    graph = _graph()
    scene = sl.Scene.from_trimesh(graph)
    assert scene.instance_count == len(graph.graph.nodes_geometry) == 7
    assert scene.triangle_count == sum(len(graph.geometry[graph.graph[n][1]].faces) for n in graph.graph.nodes_geometry)
    _close(scene, graph)


def test_a_scene_graph_through_a_file(tmp_path):
    _graph().export(tmp_path / "graph.glb")
    reference = trimesh.load_scene(tmp_path / "graph.glb")
    scene = sl.load_scene(tmp_path / "graph.glb")
    assert scene.instance_count == 7
    _close(scene, reference)
    # The file keeps single-precision matrices; what was written comes back within that.
    np.testing.assert_allclose(scene.bounds, _graph().bounds, rtol=0, atol=1e-5)


@pytest.mark.parametrize("extension", FORMATS)
def test_a_mesh_through_a_file(extension, tmp_path):
    mesh = trimesh.creation.annulus(0.5, 1.0, 2.0).apply_translation((3, -1, 0.5))
    path = tmp_path / f"mesh.{extension}"
    mesh.export(path)
    _close(sl.load_scene(path, unit=1), trimesh.load_scene(path))


def test_z_up_is_turned_to_y_up(tmp_path):
    mesh = trimesh.creation.cone(1.0, 4.0).apply_translation((1, 2, 3))
    mesh.export(tmp_path / "cone.ply")
    # x stays, z becomes y: a quarter turn about x.
    turn = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    _close(sl.load_scene(tmp_path / "cone.ply", up="z"), trimesh.load(tmp_path / "cone.ply", force="mesh"), turn)
    _close(sl.load_scene(tmp_path / "cone.ply", up="y"), trimesh.load(tmp_path / "cone.ply", force="mesh"))


@pytest.mark.parametrize("name", ["graveyard.glb", "kenney_city.glb", "dragon_20k.ply", "delft_city.ply"])
def test_a_shared_scene(name, shared_scenes):
    reference = trimesh.load_scene(shared_scenes / name, process=False)
    scene = sl.load_scene(shared_scenes / name)
    assert scene.instance_count == len(reference.graph.nodes_geometry)
    baked = reference.to_mesh()
    assert scene.triangle_count == len(baked.faces)
    corner = np.asarray(baked.vertices, np.float64)[baked.faces].reshape(-1, 3)
    vertices, faces = scene.to_arrays()
    tolerance = ROUNDING * np.abs(corner).max()
    np.testing.assert_allclose(scene.bounds, [corner.min(axis=0), corner.max(axis=0)], rtol=0, atol=tolerance)
    ours = vertices[faces]
    area = 0.5 * np.linalg.norm(np.cross(ours[:, 1] - ours[:, 0], ours[:, 2] - ours[:, 0]), axis=1).sum()
    np.testing.assert_allclose(area, baked.area, rtol=1e-5)
