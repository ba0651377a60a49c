"""The truth averaged over pixels, and masks against it: half planes, whose area in a pixel has a closed form."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import shadowlab as sl

SIDE = 24
SAMPLES = 8


def half_plane(angle: float, offset: float) -> tuple[sl.Scene, sl.Camera, sl.DirectionalLight]:
    """A floor seen from above, one pixel to a unit, in shadow where ``x cos + y sin > offset``.

    x is to the right and y up, from the middle of the picture. The sheet that shades it stands beside the picture.
    """
    normal, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    # The light leans so that the sheet, 100 higher, lies 100 units further along the normal.
    light = sl.DirectionalLight((-normal[0], -1.0, normal[1]))
    rim = offset * normal + 100.0 * normal
    corners = [rim - 80 * along, rim + 80 * along, rim + 80 * along + 90 * normal, rim - 80 * along + 90 * normal]
    sheet = [[x, 100.0, -y] for x, y in corners]
    floor = [[-40, 0, -40], [40, 0, -40], [40, 0, 40], [-40, 0, 40]]
    scene = sl.Scene.from_arrays(np.array(floor + sheet), [[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]])
    camera = sl.Camera.orthographic((0, 50, 0), (0, 0, 0), up=(0, 0, -1), height=SIDE, aspect=1.0, near=1, far=200)
    return scene, camera, light


def lit_area(angle: float, offset: float) -> np.ndarray:
    """The part of each pixel on the lit side, in closed form: the integral over the square, twice."""
    c, s = abs(np.cos(angle)), abs(np.sin(angle))
    at = np.arange(SIDE) + 0.5 - SIDE / 2
    # The signed distance of the edge from each pixel's middle, positive where the middle is lit.
    t = offset - (at[None, :] * np.cos(angle) - at[:, None] * np.sin(angle))
    if min(c, s) < 1e-12:
        return np.clip(t / max(c, s) + 0.5, 0, 1)
    ramp = lambda x: np.maximum(x, 0.0) ** 2  # noqa: E731
    corner = (c + s) / 2
    both = ramp(t + corner) - ramp(t + corner - c) - ramp(t + corner - s) + ramp(t + corner - c - s)
    return both / (2 * c * s)


def test_the_closed_form_of_an_area_is_one():
    # Against many points.
    angle, offset = 0.4, 1.3
    at = (np.arange(SIDE * 50) + 0.5) / 50 - SIDE / 2
    lit = at[None, :] * np.cos(angle) - at[:, None] * np.sin(angle) < offset
    counted = lit.reshape(SIDE, 50, SIDE, 50).mean(axis=(1, 3))
    assert np.abs(counted - lit_area(angle, offset)).max() < 0.01


@pytest.mark.parametrize("offset", [0.1, 0.25, 0.37, -2.6, 0.93])
@pytest.mark.parametrize("quarter", range(4))
def test_an_edge_along_the_pixels(quarter, offset):
    angle = quarter * np.pi / 2
    soft = sl.trace.soft_shadow_mask(*half_plane(angle, offset), size=SIDE, samples=SAMPLES)
    assert soft.dtype == np.float32
    # Half a step; where an edge runs through rays, these are undecided and left out.
    assert np.abs(soft - lit_area(angle, offset)).max() <= 0.5 / SAMPLES + 1e-6
    assert np.count_nonzero((soft > 0) & (soft < 1)) == SIDE


@pytest.mark.parametrize("angle", [0.2, 0.7, 1.9, 2.8, 4.0, 5.9])
def test_a_slanted_edge(angle):
    soft = sl.trace.soft_shadow_mask(*half_plane(angle, 0.3), size=SIDE, samples=SAMPLES)
    exact = lit_area(angle, 0.3)
    # An edge crosses fewer than 2 n of the n² squares, and of each the average is off by at most a half.
    assert np.abs(soft - exact).max() < 1.0 / SAMPLES
    assert abs((soft - exact).mean()) < 1e-3
    away = (exact == 0) | (exact == 1)
    assert np.array_equal(soft[away], exact[away].astype(np.float32))
    assert np.count_nonzero(~away) >= SIDE


def test_more_rays_are_closer():
    view, exact = half_plane(0.6, 0.2), lit_area(0.6, 0.2)
    errors = [np.abs(sl.trace.soft_shadow_mask(*view, size=SIDE, samples=n) - exact).mean() for n in (1, 2, 4, 8, 16)]
    assert all(b < 0.7 * a for a, b in pairwise(errors))


@pytest.mark.parametrize("offset", [0.1, 0.25, 0.4])
def test_the_error_of_an_exact_mask_is_the_lesser_part(offset):
    """A mask that is exact at centres is wrong by the part of the pixel on the other side of the edge."""
    view = half_plane(0.0, offset)
    hard = sl.trace.shadow_mask(*view, size=SIDE).astype(np.float32)
    soft = sl.trace.soft_shadow_mask(*view, size=SIDE, samples=64)
    error = sl.aliasing.soft_error(hard, soft)
    # The middle of a pixel lies at 1/2: from 0 on the edge at `offset` leaves this part of one column lit.
    part = min(offset, 1 - offset)
    assert error.compared == SIDE * SIDE
    assert error.unmatched == 0
    assert error.mean == pytest.approx(part / SIDE, abs=0.5 / 64 / SIDE)
    assert error.too_dark == pytest.approx(error.mean)
    assert error.too_light == 0
    assert sl.aliasing.misclassified(hard, sl.trace.shadow_mask(*view, size=SIDE)).count == 0


def test_a_quarter_on_average():
    means = [
        float(
            sl.aliasing.soft_error(sl.trace.shadow_mask(*view, size=SIDE), sl.trace.soft_shadow_mask(*view, size=SIDE))
        )
        for view in (half_plane(0.0, (k + 0.5) / 16) for k in range(16))
    ]
    assert np.mean(means) == pytest.approx(0.25 / SIDE, rel=0.01)


def test_one_ray_is_the_truth():
    scene = sl.library.scene("robots")
    view = (scene, scene.camera, scene.light)
    truth, soft = (
        sl.trace.shadow_mask(*view, size=(160, 90)),
        sl.trace.soft_shadow_mask(*view, size=(160, 90), samples=1),
    )
    assert np.array_equal(np.isnan(soft), truth < 0)
    assert np.array_equal(soft[truth >= 0], truth[truth >= 0])


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.3, -0.2)])
def test_it_is_the_average_of_a_larger_picture(shift):
    scene = sl.library.scene("forest")
    camera = scene.camera.replace(shift=shift)
    soft = sl.trace.soft_shadow_mask(scene, camera, scene.light, size=(96, 54), samples=3)
    fine = sl.trace.shadow_mask(scene, camera, scene.light, size=(288, 162)).reshape(54, 3, 96, 3)
    lit, decided = ((fine == 1).sum(axis=(1, 3)), (fine >= 0).sum(axis=(1, 3)))
    exact = np.divide(lit, decided, out=np.full(lit.shape, np.nan), where=decided > 0)
    assert np.isnan(soft).any()
    # Rays of both differ in the last digits, which a silhouette may notice.
    assert np.count_nonzero(~np.isclose(soft, exact, equal_nan=True)) <= 2


def test_what_counts():
    """By hand: pixels without a value in one of both are unmatched, in both they are nothing."""
    nan = np.nan
    error = sl.aliasing.soft_error([[1, 0, 0.5, nan, nan, 1]], [[0.25, 0.5, 0.5, nan, 1, nan]])
    assert np.array_equal(error.image, np.array([[0.75, -0.5, 0, nan, nan, nan]], np.float32), equal_nan=True)
    assert (error.compared, error.unmatched) == (3, 2)
    assert error.mean == pytest.approx(1.25 / 3)
    assert (error.too_light, error.too_dark) == (pytest.approx(0.25), pytest.approx(0.5 / 3))
    assert float(error) == error.mean
    nothing = sl.aliasing.soft_error([[nan]], [[nan]])
    assert (nothing.mean, nothing.compared, nothing.unmatched) == (0.0, 0, 0)


def test_a_background_does_not_count():
    """The floor's own rim: pixels half on it are as light as their part of the floor."""
    vertices = [[-5.5, 0, -5.5], [5.5, 0, -5.5], [5.5, 0, 5.5], [-5.5, 0, 5.5]]
    scene = sl.Scene.from_arrays(vertices, [[0, 2, 1], [0, 3, 2]])
    camera = sl.Camera.orthographic((0, 50, 0), (0, 0, 0), up=(0, 0, -1), height=16, aspect=1.0, near=1, far=200)
    soft = sl.trace.soft_shadow_mask(scene, camera, sl.DirectionalLight((0.1, -1, 0)), size=16, samples=4)
    assert np.count_nonzero(soft == 1) == 12 * 12
    assert np.count_nonzero(np.isnan(soft)) == 16 * 16 - 12 * 12


def test_a_filter_is_nearer_to_the_average():
    """What the count cannot say: a filtered mask of the same map is nearer to the average."""
    scene = sl.library.scene("robots")
    view = (scene, scene.camera, scene.light)
    p = sl.technique("lispsm").parameterize(*view, resolution=2048)
    soft = sl.trace.soft_shadow_mask(*view, size=(320, 180), samples=4)
    looks = {"size": (320, 180), "resolution": 2048}
    masks = [sl.Renderer("cpu").shadow_mask(*view, p, filter=one, **looks) for one in ("nearest", "bilinear")]
    nearest, wide = (sl.aliasing.soft_error(mask, soft) for mask in masks)
    assert wide.mean < nearest.mean


def test_the_table_of_the_page_is_true():
    scene = sl.library.scene("robots")
    view, size = (scene, scene.camera, scene.light), (640, 360)
    truth = sl.trace.shadow_mask(*view, size=size)
    soft = sl.trace.soft_shadow_mask(*view, size=size, samples=8)
    masks = {"| truth at the centres | |": np.where(truth < 0, np.float32(np.nan), truth.astype(np.float32))}
    for side in (512, 2048):
        p = sl.technique("lispsm").parameterize(*view, resolution=side)
        for name in ("nearest", "bilinear"):
            mask = sl.Renderer("cpu").shadow_mask(*view, p, size=size, resolution=side, filter=name)
            masks[f"| {side}² | `{name}` |"] = mask
    page = (Path(__file__).parents[1] / "docs" / "errors.md").read_text("utf-8")
    for head, mask in masks.items():
        found = sl.aliasing.soft_error(mask, soft)
        shares = f"{found.mean:.4f} | {found.too_dark:.5f} | {found.too_light:.5f}"
        assert f"{head} {sl.aliasing.misclassified(mask, truth).count:,} | {shares} |\n" in page


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"samples": 0}, "samples: expected a whole number from 1 to 64"),
        ({"samples": 65}, "samples: expected"),
        ({"samples": 2.5}, "samples: expected"),
        ({"samples": True}, "samples: expected"),
        ({"size": None}, "size: expected"),
        ({"size": 0}, "size: expected"),
        ({"size": (1 << 40, 3)}, "size: expected"),
        ({"scene": 1}, "scene: expected"),
        ({"camera": None}, "camera: expected"),
        ({"light": "sun"}, "light: expected"),
        ({"progress": 2}, "progress: expected"),
    ],
)
def test_bad_input(change, said):
    scene, camera, light = half_plane(0, 0)
    with pytest.raises(sl.errors.ArgumentError, match=said):
        sl.trace.soft_shadow_mask(**{"scene": scene, "camera": camera, "light": light, "size": 8, **change})


@pytest.mark.parametrize(
    ("mask", "soft", "said"),
    [
        ([[0, 1]], [[0, 1, 1]], "mask, soft: expected images of one size"),
        ([0, 1], [0, 1], "mask: expected"),
        ([[0, 2]], [[0, 1]], "mask: expected values in"),
        ([[0, 1]], [[0, -1]], "soft: expected values in"),
        ([[0, np.inf]], [[0, 1]], "mask: expected values in"),
        ("mask", [[0, 1]], "mask: expected"),
    ],
)
def test_bad_images(mask, soft, said):
    with pytest.raises(sl.errors.ArgumentError, match=said):
        sl.aliasing.soft_error(mask, soft)
