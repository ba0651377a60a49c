"""Depth maps of both renderers against OpenGL through moderngl, under our matrices and under random ones."""

import functools

import numpy as np
import pytest
from peers.cases import LIBRARY, SHARED, case_of
from peers.compare import DIFFERING_SHARE, SUBPIXEL_BITS, assert_agree

import shadowlab as sl

RESOLUTION = 2048


@functools.cache
def _theirs(peer, case, technique: str):
    """The parameterization and OpenGL's map, made once for both renderers."""
    p = sl.technique(technique).parameterize(case.scene, case.camera, case.light, resolution=RESOLUTION)
    return p, peer.depth(case.vertices, case.faces, p.matrix, (RESOLUTION, RESOLUTION))


def test_the_subpixel_grid_is_ours(moderngl_peer):
    assert moderngl_peer.subpixel_bits == SUBPIXEL_BITS


@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
@pytest.mark.parametrize("name", [*LIBRARY, *SHARED])
def test_depth_of_a_scene(name, technique, renderer, moderngl_peer, request, record_property):
    case = case_of(name, request)
    p, theirs = _theirs(moderngl_peer, case, technique)
    ours = renderer.shadow_map(case.scene, p, resolution=RESOLUTION)
    assert ours.shape == theirs.shape
    assert ours.dtype == np.float32
    # A map of nothing would agree with another one.
    assert (theirs < 1).mean() > 0.05
    by_driver = renderer.backend == "gpu"
    difference = assert_agree(ours, theirs, case.vertices, case.faces, p.matrix, by_driver=by_driver)
    record_property("difference", str(difference))


@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
def test_depth_for_a_spot_light(technique, renderer, moderngl_peer):
    case = case_of("robots", None)
    low, high = case.vertices.min(axis=0), case.vertices.max(axis=0)
    position = [low[0], high[1] + 0.5 * case.diagonal, high[2]]
    light = sl.SpotLight(position, case.middle - position, cone_angle=np.radians(70), range=3 * case.diagonal)
    p = sl.technique(technique).parameterize(case.scene, case.camera, light, resolution=RESOLUTION)
    theirs = moderngl_peer.depth(case.vertices, case.faces, p.matrix, (RESOLUTION, RESOLUTION))
    ours = renderer.shadow_map(case.scene, p, resolution=RESOLUTION)
    assert (theirs < 1).mean() > 0.05
    assert_agree(ours, theirs, case.vertices, case.faces, p.matrix, by_driver=renderer.backend == "gpu")


def _soup(rng) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of all sizes and shapes, slivers and points among them, some behind the projection's centre."""
    count = 400
    middle = rng.uniform(-2, 2, (count, 1, 3))
    size = 10.0 ** rng.uniform(-3, 0.3, (count, 1, 1))
    corner = middle + size * rng.normal(size=(count, 3, 3))
    corner[:40, 2] = corner[:40, 1] + 1e-4 * (corner[:40, 2] - corner[:40, 1])
    corner[40:50, 2] = corner[40:50, 0]
    vertices = corner.reshape(-1, 3).astype(np.float32).astype(np.float64)
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
def test_depth_of_random_triangles_under_a_random_matrix(kind, seed, renderer, moderngl_peer):
    rng = np.random.default_rng(seed)
    vertices, faces = _soup(rng)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    view = np.eye(4)
    view[:3, :3] = rotation
    if kind == "orthographic":
        projection = np.diag([0.4, 0.4, -0.2, 1.0])
        projection[2, 3] = 0.5
    else:
        # Near plane and centre among the triangles, so that many have to be clipped.
        near, far, view[2, 3] = 0.05, 6.0, -0.5
        projection = np.array(
            [[1.2, 0, 0, 0], [0, 1.2, 0, 0], [0, 0, far / (near - far), near * far / (near - far)], [0, 0, -1, 0]]
        )
    clip_from_world = projection @ view
    size = 512
    theirs = moderngl_peer.depth(vertices, faces, clip_from_world, (size, size))
    scene = sl.Scene.from_arrays(vertices, faces)
    ours = renderer.shadow_map(scene, sl.Parameterization.from_matrix(clip_from_world), resolution=size)
    assert (theirs < 1).mean() > 0.2
    # Few large texels under many slivers, put there to differ: ten times the share, each explained all the same.
    by_driver = renderer.backend == "gpu"
    assert_agree(ours, theirs, vertices, faces, clip_from_world, share=10 * DIFFERING_SHARE, by_driver=by_driver)


def test_without_clip_control_opengl_says_the_same(moderngl_peer):
    case = case_of("robots", None)
    p = sl.technique("uniform").parameterize(case.scene, case.camera, case.light, resolution=512)
    symmetric = type(moderngl_peer)(zero_to_one=False)
    try:
        other = symmetric.depth(case.vertices, case.faces, p.matrix, (512, 512))
    finally:
        symmetric.release()
    depth = moderngl_peer.depth(case.vertices, case.faces, p.matrix, (512, 512))
    assert_agree(depth, other, case.vertices, case.faces, p.matrix)
