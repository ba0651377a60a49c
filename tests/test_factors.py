"""The factors of a map's matrix: light space, the homography that makes the technique, and the crop."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl

RESOLUTION = 256
# Of the largest entry of a matrix.
EXACT = 1e-12
TECHNIQUES = (
    "uniform", "uniform:stable=true", "uniform:focus=none", "lispsm", "lispsm:near=optimal", "lispsm:axis=middle",
    "psm", "tsm", "gmnpr", "glpr", "xpsm", "xpsm:fit=published", "plane_optimal:fallback=uniform", "log_psm", "log",
    "rectilinear", "z_partition:inner=lispsm", "z_partition:stable=true", "face_partition",
)  # fmt: skip


def lights_of(scene: sl.Scene) -> dict[str, object]:
    """The scene's own light, awkward ones, and placed ones."""
    forward = np.asarray(scene.camera.forward)
    middle = np.asarray(scene.bounds).mean(axis=0)
    size = float(np.linalg.norm(np.subtract(*scene.bounds)))
    return {
        "own": scene.light,
        "along the view": sl.DirectionalLight(forward),
        "against the view": sl.DirectionalLight(-forward),
        "nearly along": sl.DirectionalLight(forward + np.array([1e-5, 0, 0])),
        "straight down": sl.DirectionalLight((0, -1, 0)),
        "spot": sl.SpotLight(middle + size * np.array([0, 0.7, 0.3]), (0, -1, -0.4), cone_angle=1.2, range=3 * size),
        "point": sl.PointLight(middle + size * np.array([0, 0.1, 0]), range=size),
    }


@pytest.mark.parametrize("name", sl.library.names())
def test_the_product_is_the_matrix(name):
    scene = sl.library.scene(name)
    samples = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(64, 36))
    checked = dict.fromkeys(TECHNIQUES, 0)
    for light in lights_of(scene).values():
        for technique in TECHNIQUES:
            made = sl.technique(technique)
            try:
                p = made.parameterize(scene, scene.camera, light, resolution=RESOLUTION, samples=samples)
            except sl.errors.UnsupportedError:
                continue
            for part in p.partitions:
                product = part.fit @ part.warp @ part.lift
                assert np.abs(product - part.matrix).max() <= EXACT * np.abs(part.matrix).max(), (technique, light)
                # The depth row is part of it, and no row of the ray reads the place along the ray.
                depth = np.abs(product[2] - part.matrix[2]).max()
                assert depth <= 2 * EXACT * np.abs(part.matrix[2]).max(), (technique, light)
                assert not part.warp[[0, 1, 3], 2].any()
                checked[technique] += 1
    assert {technique for technique, count in checked.items() if not count} <= {"log"}, checked
    assert sum(checked.values()) > 100


@pytest.mark.parametrize("light", ["own", "spot"])
def test_light_space_knows_the_rays(light):
    scene = sl.library.scene("robots")
    source = lights_of(scene)[light]
    (part,) = sl.technique("lispsm").parameterize(scene, scene.camera, source, resolution=RESOLUTION).partitions
    ray = part.lift @ np.asarray(source.point)
    assert np.abs(ray[[0, 1, 3]]).max() <= 1e-14 * np.abs(part.lift).max()
    assert abs(ray[2]) > 0.1
    (uniform,) = sl.technique("uniform").parameterize(scene, scene.camera, source, resolution=RESOLUTION).partitions
    np.testing.assert_allclose(uniform.warp, np.eye(4), atol=1e-14)
    np.testing.assert_array_equal(uniform.lift, part.lift)


def test_the_warp_of_lispsm_shows_its_distance():
    scene = sl.library.scene("robots")
    for near in ("basic", "delta-z", 3.0):
        made = sl.technique("lispsm", near=near).by_body()
        (part,) = made.parameterize(scene, scene.camera, scene.light, resolution=RESOLUTION).partitions
        # w = 0 on the reference line, n before the near end: theory.md 5.1.
        across, along, _, constant = part.warp[3]
        n = constant / along + part.values["y_min"]
        assert abs(across) <= 1e-15
        assert n == pytest.approx(part.values["warp_distance"], rel=1e-12)
        if near == "basic":
            # n_opt of Wimmer et al. 2004, theory.md 5.2.
            z_near, z_far = part.eye_depth
            sine = np.linalg.norm(np.cross(scene.camera.forward, scene.light.direction))
            assert n == pytest.approx((z_near + np.sqrt(z_near * z_far)) / sine, rel=1e-9)
        elif near != "delta-z":
            assert n == pytest.approx(near, rel=1e-12)


def test_the_crop_of_uniform_has_the_bounds_of_the_receivers():
    box = np.array([[x, y, z] for x in (-1.0, 2.0) for y in (0.0, 1.5) for z in (-3.0, 1.0)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]]
    scene = sl.Scene.from_arrays(box, faces)
    camera = sl.Camera.look_at((0.3, 5, 20), (0.5, 0.5, -1), fov_y=1.0, aspect=1.0, near=1, far=100)
    light = sl.DirectionalLight((0.4, -1, -0.3))
    (part,) = sl.technique("uniform").parameterize(scene, camera, light, resolution=RESOLUTION).partitions
    in_light_space = (np.column_stack([box, np.ones(8)]) @ part.lift.T)[:, :2]
    crop = part.fit / part.fit[3, 3]
    low, high = (([end, end] - crop[:2, 3]) / np.diag(crop)[:2] for end in (-1.0, 1.0))
    border = 0.5 * np.ptp(in_light_space, axis=0) * (RESOLUTION / (RESOLUTION - 2 * 1) - 1.0)
    np.testing.assert_allclose(low, in_light_space.min(axis=0) - border, rtol=1e-9)
    np.testing.assert_allclose(high, in_light_space.max(axis=0) + border, rtol=1e-9)


def test_matrices_from_elsewhere_have_no_factors():
    scene = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=RESOLUTION)
    (part,) = sl.Parameterization.from_matrix(p.matrix).partitions
    assert part.lift is None
    assert part.warp is None
    assert part.fit is None
