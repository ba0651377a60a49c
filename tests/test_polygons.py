"""Triangles of polygons: areas by the shoelace formula, every corner used, trimesh's order where fans are right."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trimesh.geometry import triangulate_quads
from trimesh.transformations import random_rotation_matrix

from shadowlab.errors import SceneError
from shadowlab.scene.formats import polygons
from shadowlab.scene.formats.polygons import NEGLIGIBLE, clipped, triangulated, with_holes

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
DART = [[0, 0], [2, 1], [0, 2], [1, 1]]
U = [[0, 3], [3, 3], [3, 0], [2, 0], [2, 2], [1, 2], [1, 0], [0, 0]]
COMB = [[0, 0], *[[x, 3 if x % 2 else 1] for x in range(1, 10)], [10, 0]]
LINED = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 3], [2, 3], [2, 2], [2, 1], [1, 1], [1, 2], [1, 3], [0, 3], [0, 1]]
BOW = [[0, 0], [1, 1], [1, 0], [0, 1]]


def shoelace(corners):
    """Area of a polygon in the plane."""
    x, y = np.array(corners, float).T
    return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def in_space(corners, seed=0):
    """A polygon of the plane, turned and moved in space."""
    flat = np.column_stack([np.array(corners, float), np.zeros(len(corners))])
    return flat @ random_rotation_matrix(np.random.default_rng(seed).random(3))[:3, :3].T + [5, -7, 11]


def areas(points, triangles):
    """Areas of triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def triangles_of(polygons, **options):
    """Points, and the triangles of polygons."""
    points = np.concatenate(polygons)
    corners = np.arange(len(points))
    found = triangulated(points, corners, np.array([len(one) for one in polygons]), **options)
    return points, corners[found.at]


@pytest.mark.parametrize("shape", [SQUARE, DART, U, COMB, LINED])
@pytest.mark.parametrize("begin", range(4))
@pytest.mark.parametrize("turn", [1, -1])
def test_simple_polygons_keep_their_area_and_all_corners(shape, begin, turn):
    corners = np.roll(shape, begin, axis=0)[::turn]
    points, triangles = triangles_of([in_space(corners, begin)])
    assert len(triangles) == len(shape) - 2
    assert set(triangles.ravel()) == set(range(len(shape)))
    assert areas(points, triangles).sum() == pytest.approx(shoelace(shape), rel=4 * NEGLIGIBLE)
    # All turn as the polygon does.
    around = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a) @ around >= -1e-9 * (around @ around)).all()


@given(st.integers(3, 40), st.integers(0, 10_000))
def test_star_shaped_polygons(count, seed):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, count))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    if gaps.max() >= np.pi or gaps.min() < 1e-3:
        return
    corners = rng.uniform(0.2, 1, count)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    points, triangles = triangles_of([in_space(corners, seed)])
    assert areas(points, triangles).sum() == pytest.approx(shoelace(corners), rel=count * 4 * NEGLIGIBLE)
    assert len(triangles) == count - 2


STAIRS = [[1, 3], [0, 3], [0, 0], [3, 0], [3, 1], [2, 1], [2, 2], [1, 2]]


@pytest.mark.parametrize("shape", [DART, U, COMB, LINED, STAIRS])
@pytest.mark.parametrize("times", [2, 3])
def test_a_corner_that_stands_there_twice_changes_no_area(shape, times):
    for begin in range(len(shape)):
        for repeated in range(len(shape)):
            corners = np.repeat(
                np.roll(shape, begin, axis=0), np.eye(len(shape), dtype=int)[repeated] * (times - 1) + 1, 0
            )
            points, triangles = triangles_of([np.column_stack([corners, np.zeros(len(corners))]).astype(float)])
            assert areas(points, triangles).sum() == pytest.approx(shoelace(shape), rel=4 * NEGLIGIBLE)


def test_polygons_that_cross_themselves_and_those_without_area_are_fans():
    for shape in (BOW, [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0]], [[0, 0], [2, 2], [0, 2], [2, 0], [1, 3], [5, 1]]):
        _, triangles = triangles_of([in_space(shape)])
        assert len(triangles) == len(shape) - 2
        assert set(triangles.ravel()) == set(range(len(shape)))
    _, simple = clipped(np.array([in_space([[0, 0], [4, 0], [4, 4], [-2, -2], [0, 4]]), in_space(LINED[:5])]))
    assert simple.tolist() == [False, True]


def test_points_that_are_no_numbers_and_extreme_ones_get_fans_or_ears():
    for scale in (np.nan, np.inf, 1e300, 1e-300):
        points, triangles = triangles_of([in_space(U) * scale])
        assert len(triangles) == 6
        assert len(points) == 8


def test_the_order_is_that_of_trimesh():
    rng = np.random.default_rng(3)
    sizes = rng.integers(3, 8, 60)
    angle = [np.linspace(0, 2 * np.pi, n, endpoint=False) for n in sizes]
    polygons = [in_space(np.column_stack([np.cos(a), np.sin(a)]), k) for k, a in enumerate(angle)]
    starts = np.cumsum(sizes) - sizes
    theirs = triangulate_quads([list(range(s, s + n)) for s, n in zip(starts, sizes, strict=True)])
    np.testing.assert_array_equal(triangles_of(polygons)[1], theirs)
    in_place = triangles_of(polygons, in_place=True)[1]
    assert (np.diff(in_place.min(axis=1)) >= 0).all()
    assert sorted(map(tuple, np.sort(in_place, axis=1))) == sorted(map(tuple, np.sort(theirs, axis=1)))


def test_repeated_corners_are_passed_over_and_what_is_left_without_three_is_counted():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corners = np.array([0, 1, 1, 2, 0, 0, 1, 0, 1, 2, 3, 3, 0, 1, 0, 1, 2, 2])
    found = triangulated(points, corners, np.array([4, 3, 5, 4, 2]))
    assert found.degenerate == 3
    assert sorted(map(tuple, corners[found.at])) == [(0, 1, 2), (0, 1, 2), (2, 3, 0)]
    assert triangulated(points, corners[:0], np.zeros(0, int)).at.shape == (0, 3)
    assert triangulated(points, corners[:2], np.array([0, 2, 0])).degenerate == 3


def test_concave_polygons_of_too_many_corners_are_refused():
    comb = np.column_stack([np.arange(60_000), np.arange(60_000) % 2 * 5.0 + 1])
    with pytest.raises(SceneError, match="at most 50,000 corners, got 60,002"):
        triangles_of([in_space(np.concatenate([comb, [[60_000, 0], [0, 0]]]))])


def test_holes():
    outer, inner = np.array(SQUARE) * 4.0, np.array(SQUARE) + 1.5
    points = in_space(np.concatenate([outer, inner]))
    for ring in (np.arange(4, 8), np.arange(7, 3, -1)):
        triangles = with_holes(points, [np.arange(4), ring])
        assert areas(points, triangles).sum() == pytest.approx(15)
    assert with_holes(in_space(np.concatenate([outer, inner + 3])), [np.arange(4), np.arange(4, 8)]) is None


@pytest.mark.parametrize("in_place", [False, True])
@pytest.mark.parametrize("at_once", [1, 5, 9, 14])
def test_blocks_of_polygons_change_nothing(monkeypatch, at_once, in_place):
    shapes = [SQUARE, U, SQUARE[:3], DART, COMB, SQUARE[:2], LINED, SQUARE, [], SQUARE[:3], U, [], []]
    points = np.concatenate([np.reshape(in_space(one), (-1, 3)) for one in shapes if one])
    corners, counts = np.arange(len(points)), np.array([len(one) for one in shapes])
    whole = triangulated(points, corners, counts, in_place=in_place)
    monkeypatch.setattr(polygons, "CORNERS_AT_ONCE", at_once)
    found = triangulated(points, corners, counts, in_place=in_place)
    np.testing.assert_array_equal(found.at, whole.at)
    assert found.degenerate == whole.degenerate == 4
