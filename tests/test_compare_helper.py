"""The comparison helper fails where it should: a changed texel, a shifted map, a foreign matrix."""

import numpy as np
import pytest
import trimesh
from peers.compare import DEPTH_TOLERANCE, assert_agree, compare

SIZE = (96, 64)


@pytest.fixture(scope="module")
def ball(moderngl_peer):
    """A ball before a wall, its matrix and its map."""
    ball = trimesh.creation.icosphere(3)
    wall = trimesh.creation.box((3.0, 2.5, 0.1)).apply_translation((0.1, 0.1, -1.5))
    mesh = trimesh.util.concatenate([ball, wall])
    clip_from_world = np.array([[0.5, 0, 0, 0.1], [0, 0.6, 0, -0.2], [0, 0, -0.25, 0.5], [0, 0, 0, 1.0]])
    depth = moderngl_peer.depth(mesh.vertices, mesh.faces, clip_from_world, SIZE)
    return depth, np.asarray(mesh.vertices), np.asarray(mesh.faces), clip_from_world


def test_same_map_agrees(ball):
    depth, *scene = ball
    assert assert_agree(depth, depth.copy(), *scene).count == 0


def test_noise_below_the_tolerance_agrees(ball):
    depth, *scene = ball
    assert assert_agree(depth, depth - 0.9 * DEPTH_TOLERANCE * (depth < 1), *scene).count == 0


@pytest.mark.parametrize("change", [2 * DEPTH_TOLERANCE, -2 * DEPTH_TOLERANCE, 0.05])
def test_one_texel_inside_a_face_is_unexplained(ball, change):
    depth, *scene = ball
    changed = depth.copy()
    changed[40, 50] += change
    difference = compare(depth, changed, *scene)
    assert (difference.count, difference.of("unexplained")) == (1, 1)
    with pytest.raises(AssertionError, match="row 40 column 50"):
        assert_agree(depth, changed, *scene, share=1.0)


def test_every_texel_emptied_or_filled_is_noticed(ball):
    depth, *scene = ball
    rng = np.random.default_rng(5)
    for row, column in rng.integers((0, 0), depth.shape, size=(40, 2)):
        changed = depth.copy()
        changed[row, column] = 1.0 if depth[row, column] < 1 else 0.6
        difference = compare(depth, changed, *scene)
        assert difference.count == 1
        # Only a texel whose centre an outline passes within a few thousandths may be either.
        assert difference.of("unexplained") == 1


@pytest.mark.parametrize("shift", [(0, 1), (1, 0), (0, -1), (-1, 0)])
def test_a_shift_by_one_texel_fails(ball, shift):
    depth, *scene = ball
    with pytest.raises(AssertionError, match="differ"):
        assert_agree(depth, np.roll(depth, shift, axis=(0, 1)), *scene)


@pytest.mark.parametrize("flip", [np.flipud, np.fliplr])
def test_a_mirrored_map_fails(ball, flip):
    depth, *scene = ball
    with pytest.raises(AssertionError, match="differ"):
        assert_agree(depth, flip(depth), *scene)


def test_a_twentieth_of_a_texel_of_shift_is_noticed(ball, moderngl_peer):
    depth, vertices, faces, clip_from_world = ball
    moved = clip_from_world.copy()
    moved[0, 3] += 2 / SIZE[0] * 0.05
    other = moderngl_peer.depth(vertices, faces, moved, SIZE)
    with pytest.raises(AssertionError, match="differ"):
        assert_agree(depth, other, vertices, faces, clip_from_world)


def test_not_finite_or_out_of_range_fails(ball):
    depth, *scene = ball
    for value in (np.nan, np.inf, -0.5, 1.5):
        broken = depth.copy()
        broken[0, 0] = value
        with pytest.raises(AssertionError, match="outside"):
            compare(broken, depth, *scene)
