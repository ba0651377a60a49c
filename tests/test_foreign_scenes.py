"""Scenes of trimesh and pyrender and of anything with vertices and faces, and the way back to trimesh."""

from __future__ import annotations

import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from conftest import imported
from travel_support import bits, small_scene
from trimesh.transformations import rotation_matrix

import shadowlab as sl
from shadowlab.errors import ArgumentError, SceneError, ShadowlabWarning

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]])
FACE = np.array([[0, 1, 2]])
SAME = 64 * np.finfo(np.float64).eps


def posed(x=0.0, y=0.0, z=0.0, turn=None):
    """A pose at a place, turned."""
    found = np.eye(4) if turn is None else np.array(turn)
    found[:3, 3] = x, y, z
    return found


@pytest.fixture(scope="module")
def pyrender():
    """pyrender itself, with no context; it is asked for its classes alone."""
    imported("pyrender")
    from peers import pyrender_shim

    pyrender_shim.install()
    return sys.modules["pyrender"]


@pytest.mark.parametrize("name", ["robots", "courtyard", "forest", "city"])
def test_library_scenes_through_trimesh_and_back(name):
    if name not in sl.library.names():
        name = sl.library.names()[-1]
    scene = sl.library.scene(name)
    there = scene.to_trimesh()
    assert isinstance(there, trimesh.Scene)
    assert len(there.geometry) == scene.mesh_count
    assert len(there.graph.nodes_geometry) == scene.instance_count
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        back = sl.Scene.from_trimesh(there)
    assert back == scene
    assert bits(back.transforms) == bits(scene.transforms)
    # The vertices that trimesh has are those that everybody here sees.
    np.testing.assert_allclose(there.bounds, scene.bounds, rtol=1e-12, atol=1e-9)


def test_scenes_far_away_and_dropped_faces_through_trimesh():
    far = sl.Scene.from_arrays(
        np.random.default_rng(1).normal((5e5, 4.6e6, 120), size=(50, 3)), np.arange(48).reshape(-1, 3)
    )
    assert sl.Scene.from_trimesh(far.to_trimesh()) == far
    # The rows of faces that were dropped are known here alone.
    scene = small_scene()
    back = sl.Scene.from_trimesh(scene.to_trimesh())
    assert back.dropped_faces == 0
    assert back != scene
    assert bits(back.to_arrays()) == bits(scene.to_arrays())


def test_what_was_changed_in_trimesh_counts():
    scene = sl.Scene.from_arrays(TRIANGLE * 0.1, FACE)
    for change in (
        lambda mesh: mesh.apply_translation((1, 0, 0)),
        lambda mesh: mesh.vertices.__setitem__((0, 0), 0.5),
        lambda mesh: mesh.invert(),
        lambda mesh: mesh.metadata.update(shadowlab_frame="nonsense"),
        lambda mesh: mesh.metadata.update(shadowlab_frame=[3.0, 0, 0, 0]),
        lambda mesh: mesh.vertex_attributes.update(shadowlab_local=np.zeros((3, 3))),
        lambda mesh: mesh.update_faces([True]),
    ):
        there = scene.to_trimesh()
        (mesh,) = there.geometry.values()
        change(mesh)
        back = sl.Scene.from_trimesh(there)
        plain = sl.Scene.from_trimesh(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
        np.testing.assert_allclose(back.bounds, plain.bounds, atol=1e-7)
        np.testing.assert_allclose(back.to_arrays()[0], plain.to_arrays()[0], atol=1e-7)


def test_a_trimesh_scene_survives_a_file(tmp_path):
    scene = sl.library.scene("robots")
    scene.to_trimesh().export(tmp_path / "robots.glb")
    back = sl.load_scene(tmp_path / "robots.glb")
    assert (back.triangle_count, back.instance_count) == (scene.triangle_count, scene.instance_count)
    np.testing.assert_allclose(back.bounds, scene.bounds, atol=1e-4)


def test_the_camera_of_a_trimesh_scene():
    source = trimesh.Scene(trimesh.creation.box())
    assert not sl.Scene.from_trimesh(source).cameras
    assert not source.has_camera, "asking for it makes one"
    source.camera = trimesh.scene.Camera(
        "eye", resolution=(400, 200), fov=(90, 53.13010235415598), z_near=0.5, z_far=30
    )
    source.camera_transform = posed(1, 2, 3, rotation_matrix(np.pi / 2, (0, 1, 0)))
    (camera,) = sl.Scene.from_trimesh(source).cameras.values()
    np.testing.assert_allclose(camera.eye, [1, 2, 3])
    np.testing.assert_allclose(camera.forward, [-1, 0, 0], atol=SAME)
    np.testing.assert_allclose([camera.fov_y, camera.aspect, camera.near, camera.far], [2 * np.arctan(0.5), 2, 0.5, 30])


def test_anything_with_vertices_and_faces():
    for thing in (
        SimpleNamespace(vertices=TRIANGLE, faces=FACE),
        SimpleNamespace(vertices=TRIANGLE.tolist(), faces=FACE.astype(np.uint32)),
        trimesh.Trimesh(TRIANGLE, FACE, process=False),
    ):
        assert sl.Scene.from_trimesh(thing) == sl.Scene.from_arrays(TRIANGLE, FACE)
    bad = np.vstack([TRIANGLE, [[np.nan, 0, 0]]])
    with pytest.warns(ShadowlabWarning, match="1 face"):
        assert sl.Scene.from_trimesh(SimpleNamespace(vertices=bad, faces=[[0, 1, 2], [0, 1, 3]])).triangle_count == 1


@pytest.mark.parametrize(
    ("thing", "error", "match"),
    [
        (None, ArgumentError, "pyrender.*got NoneType"),
        ("scene.glb", ArgumentError, "got str"),
        (TRIANGLE, ArgumentError, "got ndarray"),
        (trimesh.PointCloud(TRIANGLE), ArgumentError, "got PointCloud"),
        (SimpleNamespace(vertices=TRIANGLE), ArgumentError, "faces"),
        (SimpleNamespace(vertices=TRIANGLE[:, :2], faces=FACE), ArgumentError, r"vertices.*\(N, 3\)"),
        (SimpleNamespace(vertices=TRIANGLE, faces=[[0, 1, 2, 0]]), ArgumentError, r"faces.*\(N, 3\)"),
        (SimpleNamespace(vertices=TRIANGLE, faces=[[0, 1, 3]]), SceneError, "vertex 3"),
        (SimpleNamespace(vertices=TRIANGLE * np.nan, faces=FACE), SceneError, "non-finite"),
        (SimpleNamespace(vertices=None, faces=None), ArgumentError, "vertices"),
        (SimpleNamespace(primitives=[]), SceneError, "no usable triangle"),
        (trimesh.Scene(), SceneError, "no usable triangle"),
    ],
)
def test_what_is_no_scene(thing, error, match):
    with pytest.raises(error, match=match):
        sl.Scene.from_trimesh(thing)


def test_pyrender_meshes(pyrender):
    box = trimesh.creation.box((1, 2, 3))
    for smooth in (True, False):
        scene = sl.Scene.from_trimesh(pyrender.Mesh.from_trimesh(box, smooth=smooth))
        assert scene.triangle_count == 12
        np.testing.assert_allclose(scene.bounds, box.bounds, atol=1e-6)
    placed = np.array([posed(x) for x in (0, 10, 20)])
    scene = sl.Scene.from_trimesh(pyrender.Mesh.from_trimesh(box, poses=placed))
    assert (scene.mesh_count, scene.instance_count) == (1, 3)
    np.testing.assert_allclose(scene.transforms, placed)
    points = pyrender.Mesh.from_points(TRIANGLE)
    with pytest.warns(ShadowlabWarning, match="another kind than triangles"), pytest.raises(SceneError):
        sl.Scene.from_trimesh(points)


def test_pyrender_scenes_with_cameras_and_lights(pyrender):
    box = pyrender.Mesh.from_trimesh(trimesh.creation.box((1, 2, 3)), smooth=False)
    source = pyrender.Scene()
    parent = source.add(pyrender.Mesh.from_trimesh(trimesh.creation.icosphere(1)), pose=posed(5), name="ball")
    source.add(box, pose=posed(0, 1), name="first")
    source.add(box, pose=posed(0, 4), name="second", parent_node=parent)
    turn = rotation_matrix(-np.pi / 2, (1, 0, 0))  # from -z to -y
    source.add(pyrender.PerspectiveCamera(0.8, znear=0.5, zfar=40, aspectRatio=1.5), pose=posed(1, 2, 3), name="eye")
    source.add(pyrender.DirectionalLight(), pose=posed(7, 7, 7, turn), name="sun")
    source.add(
        pyrender.SpotLight(innerConeAngle=0.1, outerConeAngle=0.4, range=12.0), pose=posed(1, 9, 0, turn), name="spot"
    )
    source.add(pyrender.PointLight(range=6.0), pose=posed(0, 3, 0), name="lamp")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = sl.Scene.from_trimesh(source)
    assert (scene.mesh_count, scene.instance_count) == (2, 3)
    np.testing.assert_allclose(scene.bounds, source.bounds, atol=1e-6)
    assert dict(scene.cameras) == {
        "eye": sl.Camera.look_at((1, 2, 3), (1, 2, 2), fov_y=0.8, aspect=1.5, near=0.5, far=40.0)
    }
    assert set(scene.lights) == {"sun", "spot", "lamp"}
    np.testing.assert_allclose(scene.lights["sun"].direction, [0, -1, 0], atol=SAME)
    spot = scene.lights["spot"]
    np.testing.assert_allclose(spot.direction, [0, -1, 0], atol=SAME)
    # Theirs is half of the cone, ours all of it.
    assert (spot.cone_angle, spot.range, spot.position.tolist()) == (0.8, 12.0, [1, 9, 0])
    assert scene.lights["lamp"] == sl.PointLight((0, 3, 0), range=6)
    # pyrender's own matrices say the same of the camera.
    (node,) = source.camera_nodes
    theirs = node.camera.get_projection_matrix(300, 200)
    found = sl.Camera.from_matrices(np.linalg.inv(source.get_pose(node)), theirs, "opengl")
    np.testing.assert_allclose(found.clip_from_world, scene.cameras["eye"].clip_from_world, rtol=1e-12, atol=1e-12)


def test_pyrender_scenes_are_the_same_in_any_order(pyrender):
    boxes = [pyrender.Mesh.from_trimesh(trimesh.creation.box((1, 2, i)), smooth=False) for i in range(1, 8)]
    lamps = [pyrender.PointLight(range=float(i)) for i in range(1, 8)]

    def scene(order):
        source = pyrender.Scene()
        for i in order:
            source.add(boxes[i])
            source.add(lamps[i])
        return sl.Scene.from_trimesh(source)

    scenes = [scene(order) for order in (range(7), range(6, -1, -1), (3, 1, 2, 0, 6, 5, 4))]
    assert len({one.content_hash for one in scenes}) == 1
    assert scenes[0].lights == scenes[1].lights == scenes[2].lights


def test_what_pyrender_leaves_open_is_filled_in_and_told(pyrender):
    source = pyrender.Scene()
    source.add(pyrender.Mesh.from_trimesh(trimesh.creation.box()))
    source.add(pyrender.PerspectiveCamera(1.0, znear=0.1), pose=posed(0, 0, 5), name="endless")
    source.add(pyrender.PointLight(), pose=posed(0, 100, 0))
    with pytest.warns(ShadowlabWarning, match=r"'endless' has no aspect ratio"):
        scene = sl.Scene.from_trimesh(source)
    camera = scene.cameras["endless"]
    assert camera.aspect == pytest.approx(16 / 9)
    corners = np.array(np.meshgrid(*scene.bounds.T)).reshape(3, -1).T
    assert camera.far == np.inf
    assert camera.depth(corners).max() < camera.bounded(scene).far < 20
    (lamp,) = scene.lights.values()
    assert np.linalg.norm(corners - lamp.position, axis=1).max() < lamp.range < 120


def test_cameras_and_lights_that_cannot_be_taken_are_named(pyrender):
    source = pyrender.Scene()
    source.add(pyrender.Mesh.from_trimesh(trimesh.creation.box()))
    lens = pyrender.PerspectiveCamera(1.0, znear=0.1, zfar=9, aspectRatio=1)
    source.add(pyrender.IntrinsicsCamera(100, 100, 50, 50), name="pinhole")
    source.add(lens, pose=np.diag([1.0, 2, 1, 1]), name="stretched")
    source.add(lens, pose=np.diag([2.0, 2, 2, 1]), name="doubled")
    source.add(pyrender.SpotLight(outerConeAngle=np.pi / 2, range=3.0), name="wide")
    with pytest.warns(ShadowlabWarning) as caught:
        scene = sl.Scene.from_trimesh(source)
    (told,) = [str(one.message) for one in caught]
    for part in (
        "'pinhole'",
        "from_matrices",
        "'stretched'",
        "'wide'",
        "cone_angle",
    ):
        assert part in told
    assert list(scene.cameras) == ["doubled"]
    # A view that is scaled has depths that are.
    assert (scene.cameras["doubled"].near, scene.cameras["doubled"].far) == pytest.approx((0.2, 18))
    assert not scene.lights


def test_orthographic_cameras_come_as_they_are(pyrender):
    source = pyrender.Scene()
    source.add(pyrender.Mesh.from_trimesh(trimesh.creation.box()))
    lens = pyrender.OrthographicCamera(3.0, 1.5, znear=0.5, zfar=9)
    source.add(lens, pose=posed(0, 0, 5), name="flat")
    source.add(lens, pose=np.diag([2.0, 2, 2, 1]), name="doubled")
    scene = sl.Scene.from_trimesh(source)
    for name, scale in (("flat", 1), ("doubled", 2)):
        camera = scene.cameras[name]
        assert camera.is_orthographic
        found = (camera.height, camera.aspect, camera.near, camera.far)
        assert found == pytest.approx((3 * scale, 2, 0.5 * scale, 9 * scale))
    flat, theirs = scene.cameras["flat"], lens.get_projection_matrix()
    again = sl.Camera.from_matrices(np.linalg.inv(posed(0, 0, 5)), theirs, "opengl")
    np.testing.assert_allclose(again.projection, flat.projection, atol=1e-12)
    np.testing.assert_allclose(again.view, flat.view, atol=1e-12)


def test_scenes_that_only_look_like_pyrenders():
    """What is asked of a scene is its attributes; pyrender itself keeps no mirrored pose."""
    primitive = SimpleNamespace(positions=TRIANGLE, indices=FACE.astype(np.float32), poses=None, mode=4)
    mesh = SimpleNamespace(primitives=[primitive, primitive])
    lens = SimpleNamespace(yfov=1.0, aspectRatio=1.0, znear=0.1, zfar=9.0, name=None)

    def node(**things):
        return SimpleNamespace(**{"name": None, "mesh": None, "camera": None, "light": None, **things})

    placed = [
        node(mesh=mesh),
        node(camera=lens),
        node(camera=lens, name="mirrored"),
        node(light=SimpleNamespace(name="a")),
    ]
    source = SimpleNamespace(
        mesh_nodes=placed[:1],
        camera_nodes=placed[1:3],
        light_nodes=placed[3:],
        get_pose=lambda one: np.diag([-1.0 if one.name == "mirrored" else 1.0, 1, 1, 1]),
    )
    with pytest.warns(ShadowlabWarning, match="left out camera 'mirrored': its pose mirrors"):
        scene = sl.Scene.from_trimesh(source)
    assert (scene.mesh_count, scene.instance_count) == (1, 2)
    assert dict(scene.lights) == {"a": sl.DirectionalLight((0, 0, -1))}
    assert list(scene.cameras) == ["camera 1"]
    primitive.indices = FACE + 0.5
    with pytest.raises(ArgumentError, match="faces"):
        sl.Scene.from_trimesh(source)


def test_cameras_and_lights_move_with_their_scene():
    scene = small_scene()
    scene.lights = {**scene.lights, "spot": sl.SpotLight((1, 2, 3), (0, -1, 0), cone_angle=0.5, range=4)}
    turn = rotation_matrix(0.7, (1, 2, 3)) @ np.diag([2.0, 2, 2, 1])
    turn[:3, 3] = 1, 2, 3
    moved = scene.transformed(turn)
    eye, eye_moved = scene.cameras["eye"], moved.cameras["eye"]
    points = np.random.default_rng(2).normal(size=(20, 4))
    points[:, 3] = 1
    before, after = points @ eye.clip_from_world.T, (points @ turn.T) @ eye_moved.clip_from_world.T
    np.testing.assert_allclose(after / after[:, 3:], before / before[:, 3:], rtol=1e-9)
    assert moved.lights["lamp"].range == pytest.approx(18)
    np.testing.assert_allclose(
        moved.lights["sun"].direction, turn[:3, :3] @ scene.lights["sun"].direction / 2, atol=SAME
    )
    np.testing.assert_allclose(moved.lights["spot"].position, (turn @ (1, 2, 3, 1))[:3])
    with pytest.warns(ShadowlabWarning, match=r"camera 'eye'.*mirrors.*light 'lamp'.*light 'spot'"):
        mirrored = scene.transformed(np.diag([-1.0, 1, 1, 1]))
    assert set(mirrored.lights) == {"sun"}
    assert not mirrored.cameras
    joined = scene + scene
    assert list(joined.cameras) == ["eye", "eye (2)"]
    assert len(joined.lights) == 6
    assert scene.with_ground().cameras == scene.cameras
