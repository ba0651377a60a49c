"""Texels across the light's beam, of finished maps: closed forms, the published storage factors, and the footprint."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing import closed_form as cf
from shadowlab.aliasing.beam_texels import beam_texels
from shadowlab.aliasing.frustum_body import outline
from shadowlab.experiments.frustum_scene import frustum_scene

# The ends of the frustum's range are where w is smallest: rounding over near / far.
ROUNDING = 1e-9
FOV_Y = np.radians(60)
RATIOS = (10.0, 100.0, 1000.0, 1e4)
MAPS = {"uniform": "uniform", "psm:slide=0": "psm", "lispsm:near=basic": "lispsm", "log": "log", "log_psm": "log"}


def seen(ratio, *, aspect=1.0, gamma_deg=90.0):
    """A camera with near 1, and light at an angle to its view from above."""
    camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=FOV_Y, aspect=aspect, near=1, far=ratio)
    gamma = np.radians(gamma_deg)
    return camera, sl.DirectionalLight((0, -np.sin(gamma), -np.cos(gamma)))


def made(text, camera, light, resolution=512):
    """The map that a technique's text stands for."""
    name, _, setting = text.partition(":")
    key, _, value = setting.partition("=")
    params = {key: float(value) if value.isdigit() else value} if key else {}
    return sl.technique(name, **params).parameterize(frustum_scene(camera), camera, light, resolution=resolution)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("text", MAPS)
def test_one_map_has_the_published_factors(text, ratio):
    camera, light = seen(ratio)
    p = made(text, camera, light)
    t = beam_texels(outline(camera), camera, light, p, size=512)
    given = {"near": 1, "far": ratio, "technique": MAPS[text]}
    worst = cf.worst(**given)
    # Pixels per texel of what the border leaves, from lengths on a near plane 2 tan(30°) high and widths of the image.
    assert t.height.max() * t.used * 2 * np.tan(FOV_Y / 2) == pytest.approx(worst.max_dp_ds, rel=ROUNDING)
    assert t.across.max() * t.used == pytest.approx(worst.max_dp_dt, rel=ROUNDING)
    published = cf.storage_factor(ratio=ratio, fov_y=FOV_Y, technique=MAPS[text])
    assert t.storage_factor == pytest.approx(published, rel=ROUNDING)
    # At every point of the outline, wherever on its face.
    close = {"rtol": 1e-7, "atol": 0}
    z = np.clip(t.depth, 1, ratio)
    np.testing.assert_allclose(t.height * t.used * 2 * np.tan(FOV_Y / 2), cf.dp_ds(z, **given) + 0 * z, **close)
    np.testing.assert_allclose(t.across * t.used, cf.dp_dt(z, **given), **close)


def test_several_maps_add_up():
    camera, light = seen(100.0)
    settings = {"count": 4, "splits": "logarithmic", "range": "camera"}
    for inner, technique in (("uniform", "uniform"), ("(lispsm:near=basic)", "lispsm"), ("log", "log")):
        t = sl.technique("z_partition", inner=inner, **settings)
        p = t.parameterize(frustum_scene(camera), camera, light, resolution=512)
        ends = cf.splits(near=1, far=100, count=4)
        points = [outline(camera, near=a * (1 + 1e-9), far=b * (1 - 1e-9)) for a, b in itertools.pairwise(ends)]
        found = beam_texels(np.concatenate(points), camera, light, p, size=512)
        assert (np.bincount(found.map) == len(points[0])).all()
        published = cf.storage_factor(ratio=100, fov_y=FOV_Y, technique=technique, splits=4)
        assert found.storage_factor == pytest.approx(published, rel=1e-7)


@pytest.mark.parametrize("gamma_deg", [25, 50, 90, 120])
@pytest.mark.parametrize("text", ["uniform", "lispsm", "tsm", "log_psm"])
def test_footprints_differ_by_what_the_picture_stretches(text, gamma_deg):
    camera, light = seen(100.0, aspect=1.5, gamma_deg=gamma_deg)
    p = made(text, camera, light)
    points = np.random.default_rng(1).uniform(-1, 1, (200, 3)) * [0.8, 0.5, 0] + [0, 0, -1]
    points *= np.geomspace(1.01, 99, 200)[:, None]
    t = beam_texels(points, camera, light, p, size=(768, 512))
    normals = sl.aliasing.halfway_normals(points, camera, light)
    e = sl.aliasing.footprint_at(points, normals, camera, light, p, size=(768, 512))
    stretch = np.linalg.norm(points, axis=1) / t.depth
    for i, ours in ((0, t.across), (1, t.along)):
        ratio = e.perspective_ts[:, i] / ours
        assert (ratio >= 1 - ROUNDING).all()
        assert (ratio <= stretch * (1 + ROUNDING)).all()
    # An area is stretched by exactly that.
    np.testing.assert_allclose(e.perspective / (t.across * t.height), stretch, rtol=1e-6)
    assert (t.height <= t.along * (1 + ROUNDING)).all()
    # On the axis nothing is.
    axis = np.array([[0, 0, -3.0], [0, 0, -40]])
    on, normals = beam_texels(axis, camera, light, p, size=(768, 512)), sl.aliasing.halfway_normals(axis, camera, light)
    e = sl.aliasing.footprint_at(axis, normals, camera, light, p, size=(768, 512))
    np.testing.assert_allclose(e.perspective_ts, np.stack([on.across, on.along], axis=1), rtol=1e-9)


def test_point_lights_and_points_that_no_map_holds():
    camera = seen(100.0)[0]
    light = sl.SpotLight((0, 30, -20), (0, -1, 0), cone_angle=1.0, range=100.0)
    p = made("uniform", camera, light)
    points = np.array([[0, 0, -20.0], [1, 0, -25], [0, 0, -99], [0, 0, 3]])
    t = beam_texels(points, camera, light, p, size=512)
    assert (t.map[:2] == 0).all()
    assert (t.map[2:] < 0).all()
    for found in (t.along, t.across, t.height):
        assert np.isfinite(found[:2]).all()
        assert np.isnan(found[2:]).all()
    e = sl.aliasing.footprint_at(points, sl.aliasing.halfway_normals(points, camera, light), camera, light, p, size=512)
    np.testing.assert_allclose(e.perspective_ts[0], [t.across[0], t.along[0]], rtol=1e-9)
    assert np.isfinite(t.storage_factor)
    assert "2 in maps" in repr(t)
    nothing = beam_texels(points[2:], camera, light, p, size=512)
    assert nothing.storage_factor == 0
    assert "none in a map" in repr(nothing)


def test_resolutions_and_bare_matrices():
    camera, light = seen(100.0)
    p = made("lispsm:near=basic", camera, light)
    points = outline(camera)
    one = beam_texels(points, camera, light, p, size=512)
    two = beam_texels(points, camera, light, p, size=512, resolution=1024)
    np.testing.assert_allclose(two.height, one.height / 2, rtol=ROUNDING)
    assert two.storage_factor == pytest.approx(one.storage_factor, rel=ROUNDING)
    # A matrix alone says nothing of a border: its texels count.
    bare = beam_texels(points, camera, light, p.matrix, size=512, resolution=512)
    assert bare.used == 1
    assert bare.storage_factor == pytest.approx(one.storage_factor / one.used**2, rel=ROUNDING)
    assert one.storage_factor_sheared > one.storage_factor
