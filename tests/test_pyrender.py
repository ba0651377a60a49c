"""Depth against pyrender: from the light's camera, and the shadow texture that pyrender itself renders for a light."""

import numpy as np
import pytest
from peers.cases import case_of
from peers.compare import assert_agree

import shadowlab as sl

SCENES = ("courtyard", "robots", "dragon_20k.ply")
# The size of pyrender's shadow textures, a constant of its renderer.
SHADOW_TEXTURE = 2048


@pytest.fixture(scope="module")
def pyrender(pyrender_peer):
    """pyrender itself, after the shim."""
    import pyrender

    return pyrender


@pytest.fixture(scope="module")
def tools(pyrender_peer):
    """The functions beside the peer."""
    from peers import pyrender_peer as tools

    return tools


def _light_camera(kind: str, case, pyrender, tools):
    """A pyrender camera at a light over the scene's far corner, in coordinates relative to the scene's middle."""
    radius = 0.5 * case.diagonal
    direction = np.array([0.5, -0.8, 0.33])
    if kind == "orthographic":
        position = -3 * radius * direction / np.linalg.norm(direction)
        camera = pyrender.OrthographicCamera(radius, radius, znear=radius, zfar=5 * radius)
    else:
        position = -1.5 * radius * direction / np.linalg.norm(direction)
        camera = pyrender.PerspectiveCamera(yfov=1.2, aspectRatio=1.0, znear=0.3 * radius, zfar=4 * radius)
    return camera, tools.world_from_light(position, direction)


def _relative(case):
    """A matrix that takes world points to coordinates relative to the scene's middle."""
    matrix = np.eye(4)
    matrix[:3, 3] = -case.middle
    return matrix


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("name", SCENES)
def test_depth_from_the_lights_camera(name, kind, renderer, pyrender_peer, pyrender, tools, request):
    case = case_of(name, request)
    camera, pose = _light_camera(kind, case, pyrender, tools)
    size = 1024
    theirs = pyrender_peer.camera_depth(case.vertices - case.middle, case.faces, camera, pose, (size, size))
    clip_from_world = tools.clip_from_world(camera, pose, (size, size)) @ _relative(case)
    p = sl.Parameterization.from_matrix(clip_from_world)
    ours = renderer.shadow_map(case.scene, p, resolution=size)
    assert (theirs < 1).mean() > 0.05
    by_driver = renderer.backend == "gpu"
    assert_agree(ours, theirs, case.vertices, case.faces, clip_from_world, by_driver=by_driver)


@pytest.mark.parametrize("kind", ["directional", "spot"])
@pytest.mark.parametrize("name", SCENES)
def test_the_shadow_texture_that_pyrender_renders(name, kind, renderer, pyrender_peer, pyrender, tools, request):
    case = case_of(name, request)
    direction = np.array([0.5, -0.8, 0.33])
    position = -0.8 * case.diagonal * direction
    if kind == "directional":
        light = pyrender.DirectionalLight()
    else:
        light = pyrender.SpotLight(innerConeAngle=0.3, outerConeAngle=0.5)
    pose = tools.world_from_light(position, direction)
    theirs, matrix = pyrender_peer.shadow_texture(case.vertices - case.middle, case.faces, light, pose)
    assert theirs.shape == (SHADOW_TEXTURE, SHADOW_TEXTURE)
    assert (theirs < 1).mean() > 0.02
    clip_from_world = matrix @ _relative(case)
    ours = renderer.shadow_map(case.scene, sl.Parameterization.from_matrix(clip_from_world), resolution=SHADOW_TEXTURE)
    by_driver = renderer.backend == "gpu"
    assert_agree(ours, theirs, case.vertices, case.faces, clip_from_world, by_driver=by_driver)


def test_pyrenders_orthographic_distance_is_wrong_and_undone_exactly(pyrender_peer, pyrender, tools):
    # A plane square to the view at distance 5 between near 1 and far 9: the middle of the range.
    near, far, distance = 1.0, 9.0, 5.0
    square = np.array([[-2.0, -2, -distance], [2, -2, -distance], [2, 2, -distance], [-2, 2, -distance]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    for camera, buffer in (
        (pyrender.OrthographicCamera(1.0, 1.0, znear=near, zfar=far), (distance - near) / (far - near)),
        (
            pyrender.PerspectiveCamera(yfov=0.5, aspectRatio=1.0, znear=near, zfar=far),
            far * (distance - near) / (distance * (far - near)),
        ),
    ):
        depth = pyrender_peer.camera_depth(square, faces, camera, np.eye(4), (16, 16))
        # Half a step of the 24-bit buffer and the rounding of a float32 distance, taken through the inverse formula.
        assert np.abs(depth - buffer).max() < 4 * 2.0**-24 * far / (far - near)
    # The distance that pyrender reports: right for the perspective camera, and should it ever be right for the other,
    # pyrender was repaired and the inverse formula must go.
    for camera, reported in (
        (pyrender.PerspectiveCamera(yfov=0.5, aspectRatio=1.0, znear=near, zfar=far), distance),
        (pyrender.OrthographicCamera(1.0, 1.0, znear=near, zfar=far), 2 * near * far / (far + near)),
    ):
        raw = pyrender_peer.camera_distance(square, faces, camera, np.eye(4), (16, 16))
        np.testing.assert_allclose(raw, reported, rtol=1e-5)


def test_an_empty_texel_comes_back_as_one(tools):
    depth = tools.depth_from_pyrender_distance(np.float32([[1.8, 0.0]]), 1.0, 9.0)
    np.testing.assert_allclose(depth, [[0.5, 1.0]], atol=1e-7)
