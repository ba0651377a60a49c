"""Pictures: the frustum stays inside the map, colours say what they mean, thin casters survive a smaller picture."""

from __future__ import annotations

import types

import matplotlib as mpl
import numpy as np
import pytest

import shadowlab as sl
from shadowlab import pictures, plot
from shadowlab.pictures.eye import widened
from shadowlab.pictures.frustum import clip_segment

mpl.use("Agg")
RNG = np.random.default_rng(7)


def camera(eye=(0.0, 2.0, 5.0), near=0.1, far=100.0):
    place = np.array(eye)
    return sl.Camera.look_at(place, place - (0, 0, 1), fov_y=1.0, aspect=1.5, near=near, far=far)


def view(height=6, width=8):
    """A floor below a row that sees nothing."""
    triangle = np.zeros((height, width), np.int32)
    triangle[0] = -1
    normal = np.zeros((height, width, 3), np.float32)
    normal[..., 1] = 1.0
    return types.SimpleNamespace(triangle=triangle, normal=normal, position=np.zeros((height, width, 3)))


SUN = sl.DirectionalLight((0.0, -1.0, 0.0))


def perspective_map(seed):
    """A random projection whose w changes its sign within the view."""
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(4, 4))
    matrix[3] = [*rng.normal(size=3) * 0.3, rng.normal()]
    return matrix


@pytest.mark.parametrize("seed", range(200))
def test_the_frustum_never_leaves_the_image(seed):
    segments = pictures.frustum_segments(perspective_map(seed), camera())
    assert np.isfinite(segments).all()
    assert (np.abs(segments) <= 1.0).all()


@pytest.mark.parametrize("seed", range(60))
def test_every_drawn_point_is_on_an_edge_in_front_of_the_projection(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=4), rng.normal(size=4)
    segment = clip_segment(a, b)
    t = np.linspace(0.0, 1.0, 20001)[:, None]
    points = a + t * (b - a)
    inside = (points[:, 3] > 0) & (np.abs(points[:, :2]) < points[:, 3:]).all(axis=1)
    if segment is None:
        assert not inside.any()
        return
    ndc = points[inside, :2] / points[inside, 3:]
    if len(ndc):
        # The ends of what is inside, to the step of the sampling.
        step = np.abs(np.diff(ndc, axis=0)).max(initial=1e-3) + 1e-6
        np.testing.assert_allclose(np.sort(segment, axis=0), np.sort([ndc[0], ndc[-1]], axis=0), atol=2 * step)


def test_an_edge_that_passes_behind_is_cut_where_it_leaves():
    # From the middle of the image to behind the projection: it may leave on one side only.
    segment = clip_segment(np.array([0.0, 0, 0, 1]), np.array([1.0, 0, 0, -1]))
    np.testing.assert_allclose(segment, [[0, 0], [1, 0]])


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ((0, 0, 0, -1), (0.5, 0, 0, -2)),  # all behind
        ((3, 0, 0, 1), (5, 0, 0, 1)),  # all to the right
        ((0, 0, 0, 0), (1, 0, 0, 0)),  # at infinity
        ((0, 0, 0, 0), (0, 0, 0, 0)),
        ((0, 0, 0, -1), (0, 0, 0, 0)),  # reaches the centre only
    ],
)
def test_what_is_not_in_the_image_is_not_drawn(a, b):
    assert clip_segment(np.array(a, float), np.array(b, float)) is None


def test_an_inner_edge_is_drawn_as_it_is():
    segment = clip_segment(np.array([-0.5, 0.25, 0, 1]), np.array([1.0, 0.5, 0, 2]))
    np.testing.assert_allclose(segment, [[-0.5, 0.25], [0.5, 0.25]])


def test_frustum_lines_change_pixels_only_near_them():
    picture = np.full((128, 128, 3), 100, np.uint8)
    drawn = pictures.with_frustum(picture, np.array([[[-0.5, 0.0], [0.5, 0.0]]]))
    changed = np.argwhere((drawn != picture).any(axis=-1))
    assert len(changed)
    assert np.abs(changed[:, 0] - 63.5).max() <= 4
    assert changed[:, 1].min() > 26
    assert changed[:, 1].max() < 101


def test_shadow_is_darker_and_nothing_is_background():
    g = view()
    lit = pictures.shade(g, SUN, np.ones((6, 8), np.float32))
    dark = pictures.shade(g, SUN, np.zeros((6, 8), np.float32))
    assert lit.dtype == np.uint8
    assert (lit[1:].astype(int) - dark[1:] > 30).all()
    np.testing.assert_array_equal(lit[0], dark[0])
    nothing = np.where(g.triangle < 0, np.nan, 1.0).astype(np.float32)
    np.testing.assert_array_equal(pictures.shade(g, SUN, nothing), lit)


def test_a_spot_lights_along_its_rays():
    g = view()
    g.position[..., 0] = np.linspace(-9, 9, 8)
    spot = sl.SpotLight((0.0, 3.0, 0.0), (0.0, -1.0, 0.0), cone_angle=2.0, range=50.0)
    picture = pictures.shade(g, spot, np.ones((6, 8), np.float32)).astype(int).sum(axis=-1)
    assert picture[3, 3] > picture[3, 0]  # the grazing edge is darker than the middle
    at_light = view()
    at_light.position[...] = spot.position
    assert np.isfinite(pictures.shade(at_light, spot, np.ones((6, 8), np.float32))).all()


def test_differences_have_their_own_colours():
    g = view()
    image = np.zeros((6, 8), np.int8)
    image[2, 3], image[4, 5], image[0, 0] = 1, 2, -1
    picture = pictures.difference(g, SUN, np.where(g.triangle < 0, -2, 1).astype(np.int8), image)
    assert tuple(picture[2, 3]) == pictures.FALSE_SHADOW_RGB
    assert tuple(picture[4, 5]) == pictures.FALSE_LIGHT_RGB
    rest = np.ones((6, 8), bool)
    rest[2, 3] = rest[4, 5] = False
    assert (np.ptp(picture[rest].astype(int), axis=-1) == 0).all()  # grey


def test_truth_as_light():
    mask = pictures.truth_mask(np.array([[1, 0, -1, -2]], np.int8))
    np.testing.assert_array_equal(mask, [[1.0, 0.0, 0.5, np.nan]])


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (5, 5), (33, 64)])
@pytest.mark.parametrize("fill", ["empty", "full", "flat", "mixed"])
def test_any_map_has_a_picture(shape, fill):
    depth = {
        "empty": np.ones(shape),
        "full": RNG.uniform(0, 0.9, shape),
        "flat": np.full(shape, 0.25),
        "mixed": np.where(RNG.uniform(size=shape) < 0.5, 1.0, 0.5),
    }[fill].astype(np.float32)
    with np.errstate(all="raise"):
        picture = pictures.relief(depth)
    assert picture.shape == (*shape, 3)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_depths_that_no_map_has_are_drawn_all_the_same():
    for odd in (np.nan, np.inf, -np.inf, 3e38, -3e38):
        depth = RNG.uniform(0, 0.9, (9, 14)).astype(np.float32)
        whole = pictures.relief(depth)
        depth[3, 4], depth[6, 6:9] = odd, odd
        assert pictures.relief(depth).shape == whole.shape == (9, 14, 3)


def test_reduced_maps_keep_the_nearest_depth():
    depth = np.ones((100, 70), np.float32)
    depth[37, 41] = 0.125
    small = pictures.reduced(depth, 32)
    assert max(small.shape) <= 32
    assert small.min() == 0.125
    assert (small < 1).sum() == 1
    assert pictures.reduced(depth, 100) is depth


def test_the_densest_window_holds_the_cluster():
    image = np.zeros((50, 80), np.int8)
    image[30:34, 60:64] = 1
    image[5, 5] = 2
    row, column = pictures.densest_window([image], 10)
    assert row <= 30 < 34 <= row + 10
    assert column <= 60 < 64 <= column + 10
    assert pictures.densest_window([np.zeros((3, 4), np.int8)], 10) == (0, 0)


def test_axes_are_taken_and_returned():
    import matplotlib.pyplot as plt

    g = view()
    figure, ax = plt.subplots()
    assert plot.eye_view(g, SUN, np.ones((6, 8)), ax) is ax
    assert plot.difference_view(g, SUN, np.ones((6, 8), np.int8), np.zeros((6, 8), np.int8), ax, title="t") is ax
    assert plot.shadow_map(np.ones((8, 8), np.float32), ax) is ax
    assert plot.frustum(np.eye(4), camera(), ax) is ax
    plt.close(figure)
    assert plot.eye_view(g, SUN, np.ones((6, 8))).images
    plt.close("all")


def test_marks_grow_and_hide_no_other():
    marked = np.zeros((5, 6), bool)
    marked[1, 2] = marked[4, 5] = True
    grown = widened(marked, 2)
    assert np.argwhere(grown).tolist() == [[1, 2], [1, 3], [2, 2], [2, 3], [4, 5]]
    np.testing.assert_array_equal(widened(marked, 1), marked)
    g = view()
    image = np.zeros((6, 8), np.int8)
    image[2, 3], image[2, 4] = 1, 2
    picture = pictures.difference(g, SUN, np.ones((6, 8), np.int8), image, width=3)
    assert tuple(picture[2, 3]) == pictures.FALSE_SHADOW_RGB
    assert tuple(picture[2, 4]) == pictures.FALSE_LIGHT_RGB
