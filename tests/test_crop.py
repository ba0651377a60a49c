"""Rectangles of G-buffers, and what the core says of single pixels: the same as of whole pictures, bit for bit."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from explain_support import run_of, view_of

import shadowlab as sl
from shadowlab import _core

ARRAYS = ("depth", "view_depth", "position", "position_relative", "normal", "triangle", "instance")
# Left, top, width, height in a picture of 320 x 180.
RECTANGLES = ((0, 0, 1, 1), (319, 179, 1, 1), (0, 0, 320, 180), (40, 30, 7, 100), (313, 0, 7, 180), (0, 179, 320, 1))


@pytest.mark.parametrize("of", RECTANGLES)
def test_a_rectangle_has_the_same_records(of):
    g = view_of("robots").gbuffer("cpu")
    x, y, width, height = of
    part = g.crop(x, y, width, height)
    assert part.size == (width, height)
    assert np.array_equal(part.origin, g.origin)
    for name in ARRAYS:
        whole = np.asarray(getattr(g, name))[y : y + height, x : x + width]
        assert np.asarray(getattr(part, name)).tobytes() == np.ascontiguousarray(whole).tobytes()
    assert (part == g) == ((width, height) == g.size)
    assert pickle.loads(pickle.dumps(part)) == part
    assert part.crop(0, 0, width, height) == part


@pytest.mark.parametrize("technique", ["lispsm", "rectilinear", "z_partition:count=3,inner=lispsm"])
@pytest.mark.parametrize("of", RECTANGLES)
def test_look_ups_of_a_rectangle_are_those_of_the_picture(technique, of):
    run, view = run_of("robots", technique, 128), view_of("robots")
    x, y, width, height = of
    part = view.gbuffer("cpu").crop(x, y, width, height)
    mask = sl.aliasing.look_up(run.maps, part, view.camera, view.light, run.parameterization)
    assert mask.tobytes() == np.ascontiguousarray(run.mask[y : y + height, x : x + width]).tobytes()


@pytest.mark.parametrize(
    ("of", "name"),
    [
        ((-1, 0, 1, 1), "x"), ((320, 0, 1, 1), "x"), ((0, 180, 1, 1), "y"), ((0, 0, 0, 1), "width"),
        ((1, 0, 320, 1), "width"), ((0, 1, 1, 180), "height"), ((0, 0, 1, -3), "height"), ((0.5, 0, 1, 1), "x"),
        ((0, 0, True, 1), "width"), ((0, 0, 1, "2"), "height"), ((0, 0, 1 << 70, 1), "width"),
    ],
)  # fmt: skip
def test_a_rectangle_that_leaves_the_picture_is_refused(of, name):
    with pytest.raises(sl.errors.ArgumentError, match=f"^{name}: expected a whole number from"):
        view_of("robots").gbuffer("cpu").crop(*of)


@pytest.mark.parametrize("technique", ["lispsm", "rectilinear", "log_psm", "z_partition:count=3,inner=lispsm"])
def test_pixels_are_compared_as_the_picture_is(technique):
    """Map and place are those of `texel_coordinates`, and the stored depth against the reference is the mask."""
    run, view = run_of("robots", technique, 256), view_of("robots")
    p, g = run.parameterization, view.gbuffer("cpu")
    places, which = sl.aliasing.texel_coordinates(g, view.camera, view.light, p, resolution=256)
    rows, columns = np.indices(which.shape)
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1)
    found, place, depth, *_ = _core.compared(g, view.camera, view.light, p, pixels, resolution=256)
    assert np.array_equal(found.reshape(which.shape), which)
    assert np.array_equal(np.isnan(place).reshape(places.shape), np.isnan(places))
    known = ~np.isnan(depth)
    assert place[known] == pytest.approx(places.reshape(-1, 2)[known], abs=1e-9)
    maps = run.maps if run.maps.ndim == 3 else run.maps[None]
    i, j = np.clip(np.floor(place[known]).astype(int), 0, 255).T
    lit = maps[found[known], j, i].astype(float) >= depth[known]
    assert np.array_equal(lit, run.mask.ravel()[known] == 1.0)
    # Without a look it is lit, but where the light does not reach.
    rest = run.mask.ravel()[~known & (found != sl.aliasing.NoTexel.NOTHING)]
    assert set(np.unique(rest)) <= {0.0, 1.0}
    assert (run.mask.ravel()[found == sl.aliasing.NoTexel.AVERTED] == 0.0).all()


@pytest.mark.parametrize("pixels", [[(320, 0)], [(0, -1)], [(0, 0), (3, 180)]])
def test_pixels_outside_are_refused(pixels):
    run, view = run_of("robots", "lispsm", 128), view_of("robots")
    with pytest.raises(sl.errors.ArgumentError, match=r"^pixels: expected columns and rows of a picture of 320 x 180"):
        _core.compared(view.gbuffer("cpu"), view.camera, view.light, run.parameterization, pixels)
