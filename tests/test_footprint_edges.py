"""Footprints of surfaces that eye or light meet edge on, and of points that are no image."""

from __future__ import annotations

import math

import numpy as np
import pytest
from footprint_support import EXACT, MAPS, ROBOTS, made, seen

import shadowlab as sl

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")


def test_a_surface_that_the_eye_sees_edge_on():
    # It has no area in the image, and a texel on it a length; perspective alone is what it is on any surface.
    camera = ROBOTS.camera
    point = camera.eye + np.array([0, 0, -9.0])
    f = sl.aliasing.footprint_at([point], [[0, 1.0, 0]], camera, ROBOTS.light, MAPS["lispsm"], size=64)
    other = sl.aliasing.footprint_at([point], [[0.1, 1.0, 0.1]], camera, ROBOTS.light, MAPS["lispsm"], size=64)
    assert f.measured.all()
    assert f.projection[0] == 0
    assert f.minor[0] == 0
    assert f.major[0] > 0
    assert np.isfinite(f.perspective).all()
    assert np.isfinite(f.perspective_major).all()
    np.testing.assert_allclose(f.perspective_major, other.perspective_major, rtol=1e-7)
    s = f.summary()
    assert math.isfinite(s.perspective_max)
    assert math.isfinite(s.storage_factor)


def test_the_storage_factor_is_over_the_pixels_of_the_image():
    # However many points tell of it.
    point, factors = ROBOTS.camera.eye + 10 * np.asarray(ROBOTS.camera.forward), []
    for n in (1, 7):
        points, normals = np.tile(point, (n, 1)), np.tile([0.0, 1, 0], (n, 1))
        f = sl.aliasing.footprint_at(points, normals, ROBOTS.camera, ROBOTS.light, MAPS["lispsm"], size=(64, 32))
        s = f.summary()
        factors.append(s.storage_factor)
        expected = s.perspective_s_max * s.perspective_t_max * 512 * 512 / (64 * 32)
        assert s.storage_factor == pytest.approx(expected, rel=EXACT)
    assert factors[0] == factors[1]


@pytest.mark.parametrize("name", ["courtyard", "robots", "ceiling"])
def test_walls_along_the_light_do_not_drown_the_rest(name):
    # The normal of a wall is level up to a rounding of float32, and so is the angle at which light from above meets it.
    scene, g = seen(name)
    noon = sl.DirectionalLight((0, -1, 0))
    f = sl.aliasing.footprint(g, scene.camera, noon, made("uniform", scene, noon))
    assert np.nanmax(f.projection) <= 1 / np.finfo(np.float32).eps
