"""The summary of a footprint: against numpy, by bands, published storage factors, the same wherever the scene is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from footprint_support import EXACT, MAPS, RENDERER, ROBOTS, ROBOTS_SEEN, SIZE, of, synthetic
from summary_support import numbers_of

import shadowlab as sl
from shadowlab.aliasing import closed_form as cf
from shadowlab.aliasing.footprint import NO_MAP, NOTHING
from shadowlab.errors import ArgumentError

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")
# Images of a scene that moved: edges of single pixels and the last digits of positions and normals.
MOVED = 1e-3


@pytest.fixture(params=MAPS)
def measured(request):
    """Footprints of some maps."""
    return of(MAPS[request.param])


def test_the_summary_is_what_numpy_says(measured):
    f, s = measured, measured.summary(bands=5)
    m = f.measured
    major = f.major[m].astype(np.float64)
    assert s.measured == np.count_nonzero(m)
    assert s.pixels == m.size
    assert s.counts == f.counts()
    assert s.max == major.max()
    np.testing.assert_allclose([s.mean, s.rms], [major.sum() / major.size, math.sqrt((major**2).mean())], rtol=EXACT)
    in_order = np.sort(major)
    for percent, value in s.percentiles.items():
        rank = percent / 100 * (major.size - 1)
        assert in_order[math.floor(rank)] <= value <= in_order[math.ceil(rank)]
    assert s.undersampled == np.count_nonzero(major > 1) / major.size
    perspective = f.perspective_major[m].astype(np.float64)
    np.testing.assert_allclose([s.perspective_max, s.perspective_mean], [perspective.max(), perspective.mean()])
    logarithms = np.log(f.projection[m].astype(np.float64))
    np.testing.assert_allclose(s.projection_mean, np.exp(logarithms.mean()), rtol=1e-6)
    along_t, along_s = (f.perspective_ts[..., k].astype(np.float64) for k in (0, 1))
    assert (s.perspective_s_max, s.perspective_t_max) == (along_s[m].max(), along_t[m].max())
    needed = sum(along_s[f.map == k].max() * along_t[f.map == k].max() for k in range(f.maps) if (f.map == k).any())
    np.testing.assert_allclose(s.storage_factor, needed * np.prod(f.resolution) / m.size, rtol=EXACT)
    # So many texels on a side, and 95 % have one a pixel.
    again = of_resolution(f, s.resolution_needed)
    assert np.count_nonzero(again <= 1) >= 0.95 * major.size - 1
    assert np.count_nonzero(of_resolution(f, s.resolution_needed - 1) <= 1) <= 0.95 * major.size + 1
    # Told along the longer side.
    wide = of(MAPS["lispsm"], (512, 256)).summary()
    assert wide.resolution_needed == math.ceil(512 * wide.percentiles[95])
    # All of them, once.
    h = s.histogram
    assert h.pixels.sum() == s.measured
    assert list(h["to"][:-1]) == list(h["from"][1:])
    for low, high, pixels in h.itertuples(index=False):
        assert pixels == np.count_nonzero((major >= low) & (major < high))
    d, depth = s.bands, f.depth[m].astype(np.float64)
    assert len(d) == 5
    assert d.pixels.sum() == s.measured
    assert d.near.iloc[0] == depth.min()
    assert d.far.iloc[-1] == depth.max()
    np.testing.assert_allclose(d.far / d.near, (depth.max() / depth.min()) ** 0.2, rtol=1e-9)
    for row in d.itertuples():
        last = row.Index == len(d) - 1
        inside = (depth >= row.near) & ((depth < row.far) | last)
        assert row.pixels == np.count_nonzero(inside)
        if row.pixels:
            assert row.max == major[inside].max()
            assert row.undersampled == (major[inside] > 1).mean()
            np.testing.assert_allclose([row.mean, row.p95], [major[inside].mean(), np.percentile(major[inside], 95)])
    assert max(d["max"]) == s.max
    told = s.to_dict()
    assert told["p50"] == s.percentiles[50]
    assert told["bands"][0]["pixels"] == d.pixels.iloc[0]
    assert repr(s).startswith(f"Summary of {s.measured:,} pixels")
    assert "<table" in s._repr_html_()


def of_resolution(f, texels):
    """The longest extents with another number of texels along the longer side."""
    return f.major[f.measured].astype(np.float64) * max(f.resolution) / texels


# Sums of blocks and numpy's pairwise sums round differently: some hundred roundings at most of numbers of one sign.
SUMMED = 1e-12


@pytest.mark.parametrize("bands", [1, 6, 97, (0.5, 3.0, 4.0, 80.0)])
@pytest.mark.parametrize("threads", [1, 3])
def test_the_core_counts_what_numpy_counts(measured, bands, threads):
    with_threads(threads, lambda: same_numbers(measured, bands))


@pytest.mark.parametrize("n", [1, 2, 3, 7, 4096, 4097, 50_000])
def test_the_core_counts_what_numpy_counts_of_points(n):
    random = np.random.default_rng(n)
    codes = random.choice([-3, -1, 0, 1, 4], n, p=[0.1, 0.1, 0.4, 0.3, 0.1]).astype(np.int16)
    codes[0] = 0
    jacobians = random.lognormal(0.0, 2.0, (n, 2, 2))
    depth = random.lognormal(2.0, 1.0, n)
    f = synthetic(jacobians, codes, depth, columns=random.lognormal(0.0, 1.0, (n, 2)), maps=5)
    same_numbers(f, 6)
    same_numbers(f, (1.0, 2.0, 50.0))


def same_numbers(f, bands):
    """Holds a summary against its twin in numpy."""
    s, expected = f.summary(bands=bands), numbers_of(f, bands)
    found = s.to_dict()
    for name, value in expected.items():
        if name not in ("histogram", "bands"):
            assert found[name] == pytest.approx(value, rel=SUMMED), name
    for name in ("measured", "max", "perspective_s_max", "perspective_t_max"):
        assert found[name] == expected[name], name
    assert {k: s.percentiles[k] for k in s.percentiles} == {k: expected[f"p{k}"] for k in s.percentiles}
    assert s.histogram.pixels.tolist() == expected["histogram"]
    for row, (pixels, most, mean, p95, share) in zip(found["bands"], expected["bands"], strict=True):
        assert (row["pixels"], row["max"], row["p95"], row["undersampled"]) == (pixels, most, p95, share)
        assert row["mean"] == (None if mean is None else pytest.approx(mean, rel=SUMMED))


def with_threads(count, work):
    """Works with so many threads."""
    sl.set_threads(count)
    try:
        return work()
    finally:
        sl.set_threads(None)


def test_the_summary_does_not_depend_on_the_threads(measured):
    one, three = (with_threads(count, measured.summary) for count in (1, 3))
    assert one == three


def test_numbers_that_are_none_are_refused():
    f = synthetic([np.eye(2)] * 3)
    f.major[1] = np.nan
    with pytest.raises(ArgumentError, match="NaN"):
        f.summary()


def test_bands_by_limits():
    j = np.eye(2) * np.array([0.5, 2, 3, 4, 1.0])[:, None, None]
    f = synthetic(j, depth=[1, 2, 3, 4, 5])
    d = f.summary(bands=[2, 3, 5]).bands
    # The last limit is part of the last band, others begin one; what lies before the first is in none.
    assert list(d.pixels) == [1, 3]
    assert list(d["max"]) == [2, 4]
    assert list(d["undersampled"]) == [1, 2 / 3]
    np.testing.assert_allclose(d["mean"], [2, 8 / 3])
    empty = f.summary(bands=(10, 20, 30)).bands
    assert list(empty.pixels) == [0, 0]
    assert empty["max"].isna().all()
    # All depths are one: one band.
    flat = synthetic(j, depth=[2.0] * 5).summary(bands=4).bands
    assert list(flat.pixels) == [5]
    assert list(f.summary(bands=np.int64(2)).bands.pixels) == [2, 3]
    # A texel as long as a pixel is none too long.
    assert f.summary().undersampled == 3 / 5
    assert list(f.undersampled) == [False, True, True, True, False]


@pytest.mark.parametrize("bands", [0, -1, True, 2.5, "six", [1], [2, 1], [1, 1, 2], [1, np.nan], [[1, 2]], None, {}])
def test_bands_that_are_none(bands):
    f = synthetic([np.eye(2)] * 3)
    with pytest.raises(ArgumentError, match="bands"):
        f.summary(bands=bands)
    # Nothing measured is no excuse.
    with pytest.raises(ArgumentError, match="bands"):
        synthetic([np.eye(2)], [NOTHING]).summary(bands=bands)


def test_an_empty_summary_says_why():
    below, elsewhere = sl.DirectionalLight((0, 1, 0)), np.eye(4)
    elsewhere[0, 3] = 1e6
    with pytest.warns(sl.errors.ShadowlabWarning, match="no visible surface lies in the map"):
        f = sl.aliasing.footprint(ROBOTS_SEEN, ROBOTS.camera, below, elsewhere)
    s = f.summary()
    assert s.measured == 0
    assert s.max is None
    assert s.storage_factor is None
    assert s.percentiles is None
    assert s.bands.empty
    assert s.histogram.pixels.sum() == 0
    assert s.to_dict()["bands"] == []
    # Robots stand on a ground that light from below does not reach, and have some faces that it does.
    assert "facing away" in repr(s)
    assert "showing nothing" in repr(s)
    assert "held by no map" in repr(s)
    assert "nothing measured" in repr(f)
    assert "nothing measured" in f._repr_html_()
    counts = f.counts()
    assert counts["showing nothing"] == np.count_nonzero(ROBOTS_SEEN.triangle < 0)
    assert counts["measured"] == 0
    alone = synthetic([np.eye(2)] * 2, [NO_MAP, NO_MAP]).summary()
    assert repr(alone) == "Summary: no pixel looks up a texel (2 held by no map)"
    nothing = sl.aliasing.footprint_at(
        np.empty((0, 3)), np.empty((0, 3)), ROBOTS.camera, ROBOTS.light, MAPS["lispsm"], size=8
    )
    assert nothing.major.shape == (0,)
    assert repr(nothing.summary()) == "Summary: no pixel looks up a texel (no pixels)"


FOV_Y = np.pi / 3


def whole_frustum(far):
    """A camera whose whole frustum is full of receivers, and light from overhead."""
    corners = 2 * far * np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
    quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]]
    scene = sl.Scene.from_arrays(corners, [f for a, b, c, d in quads for f in ([a, b, c], [a, c, d])])
    camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=FOV_Y, aspect=1.0, near=1.0, far=far)
    return scene, camera, sl.DirectionalLight((0, -1, 0))


@pytest.mark.parametrize("far", [10.0, 100.0, 1000.0])
@pytest.mark.parametrize(
    ("technique", "name", "params"),
    [
        ("uniform", "uniform", {}),
        ("psm", "psm", {"slide": 0.0}),
        ("lispsm", "lispsm", {"near": "basic"}),
        ("log", "log", {}),
        ("log", "log_psm", {}),
    ],
)
def test_storage_factors_of_a_frustum(technique, name, params, far):
    scene, camera, light = whole_frustum(far)
    p = sl.technique(name, **params).parameterize(scene, camera, light, resolution=512)
    used = 1 - 2 * p.border_texels / p.resolution
    z = np.geomspace(1, far, 50)
    # The published factors are those of the axis; above and below it a flat image is longer by 1 / cos.
    for tangent, longer in ((0.0, 1.0), (np.tan(FOV_Y / 2), 1 / np.cos(FOV_Y / 2))):
        for side in (-1 + 1e-12, 1 - 1e-12):
            points = np.stack([0 * z, side * tangent * z, -z], axis=-1)
            normals = sl.aliasing.halfway_normals(points, camera, light)
            f = sl.aliasing.footprint_at(points, normals, camera, light, p, size=(70, 50))
            assert f.measured.all()
            assert f.size == (70, 50)
            s = f.summary()
            published = cf.storage_factor(ratio=far, fov_y=FOV_Y, technique=technique)
            worst = s.perspective_s_max * s.perspective_t_max * p.resolution**2 / (70 * 50) * used**2
            assert worst == pytest.approx(published * longer, rel=1e-8)


def moved_view(scene, camera, light, scale, turn, offset):
    """The same view elsewhere."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * turn, offset
    eye, forward, up = (np.asarray(a) for a in (camera.eye, camera.forward, camera.up))
    place = matrix[:3, :3] @ eye + offset
    target = place + turn @ forward * max(np.linalg.norm(place), scale)
    there = sl.Camera.look_at(
        place, target, up=turn @ up, fov_y=camera.fov_y, aspect=camera.aspect, near=camera.near * scale,
        far=camera.far * scale,
    )  # fmt: skip
    return scene.transformed(matrix), there, sl.DirectionalLight(turn @ light.direction), matrix


def rotation(angle):
    """About a slanted axis."""
    axis = np.array([0.6, 0.0, -0.8])
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@pytest.mark.parametrize(
    ("scale", "angle", "offset"),
    [(1e-6, 0, 0), (1e6, 0, 0), (1, 1.1, 0), (1, 0, 1), (1, -0.7, 1), (1e3, 2.0, 1e3)],
)
def test_the_summary_wherever_the_scene_is(scale, angle, offset):
    offset = offset * np.array([455_000.0, 5_411_000.0, -1_200.0])
    scene, camera, light, matrix = moved_view(ROBOTS, ROBOTS.camera, ROBOTS.light, scale, rotation(angle), offset)
    here = of(MAPS["lispsm"])
    f = RENDERER.footprint(
        scene, camera, light, MAPS["lispsm"].matrix @ np.linalg.inv(matrix), size=SIZE, resolution=512
    )
    one, two = here.summary().to_dict(), f.summary().to_dict()
    # An edge moves by a pixel or two, and the largest extent is that of one pixel.
    assert abs(one["measured"] - two["measured"]) <= 3e-4 * one["pixels"]
    for name in ("mean", "undersampled", "perspective_max", "perspective_mean", "projection_mean", "storage_factor",
                 "p5", "p25", "p50", "p75", "p95"):  # fmt: skip
        # A mean moves with the pixels whose slope nearly hides them.
        assert two[name] == pytest.approx(one[name], rel=0.02 if name == "mean" else MOVED), name
    for a, b in zip(one["bands"], two["bands"], strict=True):
        assert b["near"] == pytest.approx(a["near"] * scale, rel=MOVED)
        assert abs(a["pixels"] - b["pixels"]) <= 2e-3 * one["pixels"]
