"""The eye-space blur: binomial weights and their variance on walls, no light across edges, widths over depth."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl

SIDE = 49
# Normals and positions are in single precision, and so is every step.
CLOSE = 2e-5


def quad(*corners: tuple[float, float, float]) -> tuple[np.ndarray, list[list[int]]]:
    return np.array(corners, float), [[0, 1, 2], [0, 2, 3]]


def scene_of(*quads: tuple[np.ndarray, list[list[int]]]) -> sl.Scene:
    faces = [[i + 4 * k for i in face] for k, (_, of) in enumerate(quads) for face in of]
    return sl.Scene.from_arrays(np.concatenate([vertices for vertices, _ in quads]), faces)


def wall(z: float, left: float, right: float, lean: float = 0.0) -> tuple[np.ndarray, list[list[int]]]:
    """A wall at a depth from x = left to x = right, which falls back by `lean` along x."""
    return quad(*[(x, y, -z - lean * x) for x, y in ((left, -400), (right, -400), (right, 400), (left, 400))])


PARALLEL = sl.Camera.orthographic((0, 0, 0), (0, 0, -1), height=SIDE, aspect=1.0, near=-200, far=1000)
PERSPECTIVE = sl.Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=1.0, aspect=1.0, near=0.5, far=1000)


def seen(scene: sl.Scene, camera: sl.Camera, size: int = SIDE) -> sl.GBuffer:
    return sl.Renderer("cpu").gbuffer(scene, camera, size=size)


def impulse(row: int = SIDE // 2, column: int = SIDE // 2) -> np.ndarray:
    mask = np.zeros((SIDE, SIDE), np.float32)
    mask[row, column] = 1.0
    return mask


def binomial(n: int) -> np.ndarray:
    kernel = np.ones(1)
    for _ in range(n):
        kernel = np.convolve(kernel, [0.25, 0.5, 0.25])
    return kernel


def variances(image: np.ndarray) -> tuple[float, float]:
    weights = image / image.sum()
    at = np.arange(SIDE)
    return tuple(
        float((part * at**2).sum() - (part * at).sum() ** 2) for part in (weights.sum(axis=0), weights.sum(axis=1))
    )


@pytest.mark.parametrize("iterations", [0, 1, 2, 7, 20])
@pytest.mark.parametrize("lean", [0.0, 0.4, 2.0, 20.0])
@pytest.mark.parametrize("strength", ["even", "depth"])
def test_a_wall_gets_binomial_weights(iterations, lean, strength):
    """Also one that is seen at a grazing angle: a plane is one surface."""
    g = seen(scene_of(wall(500, -400, 400, lean)), PARALLEL.replace(near=-9000, far=9000))
    assert (g.triangle >= 0).all()
    blurred = sl.blur(impulse(), g, PARALLEL, iterations=iterations, strength=strength)
    kernel = np.zeros(SIDE)
    kernel[SIDE // 2 - iterations : SIDE // 2 + iterations + 1] = binomial(iterations)
    # A steep wall is 20 deep per pixel: its positions are rounded by more.
    close = CLOSE * (1 + lean)
    assert np.abs(blurred - np.outer(kernel, kernel)).max() <= close
    assert variances(blurred) == pytest.approx([iterations / 2] * 2, rel=10 * close, abs=1e-6)
    assert blurred.sum() == pytest.approx(1, abs=10 * close)


def test_no_light_crosses_an_edge_of_depth():
    g = seen(scene_of(wall(10, -400, 0), wall(11.5, 0, 400)), PARALLEL)
    lit = np.asarray(g.position[..., 0] < 0).astype(np.float32)
    assert 0 < lit.mean() < 1
    assert np.array_equal(sl.blur(lit, g, PARALLEL, iterations=50, strength="even"), lit)
    # A step of a quarter of a pixel is no edge: three quarters of the weight are left.
    low = seen(scene_of(wall(10, -400, 0), wall(10.25, 0, 400)), PARALLEL)
    once = sl.blur(lit, low, PARALLEL, iterations=1, strength="even")
    column = int(lit[0].sum())
    assert once[5, column] == pytest.approx(0.25 * 0.75, abs=CLOSE)
    assert once[5, column - 1] == pytest.approx(1 - 0.25 * 0.75, abs=CLOSE)


def test_no_light_crosses_a_right_angle():
    corner = scene_of(wall(200, -400, 0, lean=1.0), wall(200, 0, 400, lean=-1.0))
    g = seen(corner, PARALLEL.replace(near=-9000, far=9000))
    lit = np.asarray(g.position[..., 0] < 0).astype(np.float32)
    assert np.array_equal(sl.blur(lit, g, PARALLEL, iterations=9, strength="even"), lit)


def test_a_blur_is_as_wide_in_the_world_at_every_depth():
    n, z = 16, 10.0
    for times in (1.0, 1.5, 2.0, 4.0):
        near, far = scene_of(wall(z, -400, 400)), scene_of(wall(z * times, -400, 400))
        blurred = sl.blur(impulse(), seen(far, PERSPECTIVE), PERSPECTIVE, iterations=n, depth=z)
        # Of a pixel times the depth: the variance in the world is the same.
        assert np.mean(variances(blurred)) * times**2 == pytest.approx(n / 2, rel=1e-3)
        assert np.mean(variances(sl.blur(impulse(), seen(near, PERSPECTIVE), PERSPECTIVE, iterations=n))) == (
            pytest.approx(n / 2, rel=1e-3)
        )
    # Nearer than that depth there are no more iterations; even ones do not ask.
    close = seen(scene_of(wall(z / 3, -400, 400)), PERSPECTIVE)
    full = sl.blur(impulse(), close, PERSPECTIVE, iterations=n, depth=z)
    assert variances(full) == pytest.approx([n / 2] * 2, rel=1e-3)
    far = seen(scene_of(wall(4 * z, -400, 400)), PERSPECTIVE)
    even = sl.blur(impulse(), far, PERSPECTIVE, iterations=n, depth=z, strength="even")
    assert variances(even) == pytest.approx([n / 2] * 2, rel=1e-3)


def test_two_walls_in_one_picture():
    z = 10.0
    g = seen(scene_of(wall(z, -400, 0), wall(2 * z, 0, 400)), PERSPECTIVE)
    apart = [sl.blur(impulse(column=c), g, PERSPECTIVE, iterations=8) for c in (12, 36)]
    for blurred, expected in zip(apart, (4.0, 1.0), strict=True):
        assert variances(blurred) == pytest.approx([expected] * 2, rel=1e-3)


def test_holes_stay_and_take_no_part():
    g = seen(scene_of(wall(10, -400, 3)), PARALLEL)
    nothing = np.asarray(g.triangle) < 0
    assert nothing.any()
    mask = np.where(nothing, np.float32(np.nan), np.float32(1))
    mask[4, 4] = np.nan
    blurred = sl.blur(mask, g, PARALLEL, iterations=6)
    assert np.array_equal(np.isnan(blurred), np.isnan(mask))
    assert (blurred[~np.isnan(mask)] == 1).all(), "what is even stays so, bit for bit"
    assert np.isnan(sl.blur(np.ones_like(mask), g, PARALLEL, iterations=6)[nothing]).all()


def test_scenes_stay_within_light():
    scene = sl.library.scene("forest")
    view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    run = sl.evaluate(view, "lispsm", 512, renderer="cpu")
    g = view.gbuffer("cpu")
    for strength in ("even", "depth"):
        blurred = sl.blur(run.mask, g, scene.camera, iterations=12, strength=strength)
        assert np.array_equal(np.isnan(blurred), np.isnan(run.mask))
        assert np.nanmin(blurred) >= 0
        assert np.nanmax(blurred) <= 1
        assert 0.02 < np.mean((blurred > 0.01) & (blurred < 0.99)) < 0.9


def test_every_scale_is_the_same():
    """Units do not matter, nor where the scene stands."""
    scene = sl.library.scene("robots")
    mask = sl.evaluate(sl.View(scene, scene.camera, scene.light, size=(96, 54)), "uniform", 256, renderer="cpu").mask
    results = []
    for scale in (1.0, 2.0**-20, 2.0**20):
        camera = scene.camera.replace(
            eye=scene.camera.eye * scale, near=scene.camera.near * scale, far=scene.camera.far * scale
        )
        moved = scene.transformed(np.diag([scale, scale, scale, 1.0]))
        results.append(sl.blur(mask, sl.Renderer("cpu").gbuffer(moved, camera, size=(96, 54)), camera, iterations=6))
    assert np.allclose(results[0], results[1], atol=1e-5, equal_nan=True)
    assert np.allclose(results[0], results[2], atol=1e-5, equal_nan=True)


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"iterations": -1}, sl.errors.ArgumentError, "iterations: expected"),
        ({"iterations": 4097}, sl.errors.ArgumentError, "iterations: expected"),
        ({"iterations": 2.5}, sl.errors.ArgumentError, "iterations: expected"),
        ({"strength": "hard"}, sl.errors.UnknownNameError, "strength"),
        ({"strength": 3}, sl.errors.ArgumentError, "strength"),
        ({"depth": 0}, sl.errors.ArgumentError, "depth: expected a finite depth above 0"),
        ({"depth": -2.0}, sl.errors.ArgumentError, "depth"),
        ({"depth": float("nan")}, sl.errors.ArgumentError, "depth"),
        ({"depth": "far"}, sl.errors.ArgumentError, "depth"),
        ({"mask": np.zeros((3, 3), np.float32)}, sl.errors.ArgumentError, "mask: expected"),
        ({"mask": np.full((SIDE, SIDE), 2, np.float32)}, sl.errors.ArgumentError, r"mask: expected values in \[0, 1\]"),
        ({"gbuffer": None}, sl.errors.ArgumentError, "gbuffer"),
        ({"camera": 1}, sl.errors.ArgumentError, "camera"),
        ({"progress": "yes"}, sl.errors.ArgumentError, "progress"),
    ],
)
def test_bad_input(change, error, said):
    g = seen(scene_of(wall(10, -400, 400)), PARALLEL)
    with pytest.raises(error, match=said):
        sl.blur(**{"mask": impulse(), "gbuffer": g, "camera": PARALLEL, **change})
