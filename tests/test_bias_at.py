"""How far a bias carries pixels: each part against its definition, all together against explained pixels."""

from __future__ import annotations

import numpy as np
import pytest
from explain_support import explained, run_of, some, view_of

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError

ONLY = {"world": 0.0, "texels": 0.0, "ndc": 0.0, "slope": 0.0, "slope_limit": float("inf"), "plane": 0.0}
WHOLE = sl.Bias(world=0.003, texels=0.2, ndc=1e-5, slope=0.6, slope_limit=8.0, plane=0.7, normal=0.3)


def tilted(angle: float) -> tuple[sl.View, np.ndarray, np.ndarray]:
    """A plane that the light meets at an angle from its normal; the normal and the unit vector to the light."""
    to_light = np.array([np.sin(angle), np.cos(angle), 0.0])
    # High above its middle something small, so that the map begins well before the plane.
    corners = [[-30, 0, -30], [30, 0, -30], [30, 0, 30], [-30, 0, 30], [0, 20, 0], [0.01, 20, 0], [0, 20, 0.01]]
    scene = sl.Scene.from_arrays(np.array(corners, float), [[0, 2, 1], [0, 3, 2], [4, 6, 5]])
    camera = sl.Camera.look_at((0, 6, 2), (0, 0, 0), up=(0, 0, -1), aspect=16 / 9, near=0.5, far=60)
    return sl.View(scene, camera, sl.DirectionalLight(-to_light), size=(64, 36)), np.array([0, 1.0, 0]), to_light


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2])
def test_each_part_is_what_it_says(angle):
    view, normal, to_light = tilted(angle)
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light, resolution=512)
    rows = p.matrix
    # Steps across the ray by a texel along each axis, and what they are on the plane along the ray.
    sides = [rows[i, :3] / (rows[i, :3] @ rows[i, :3]) * 2 / 512 for i in range(2)]
    texel = max(np.linalg.norm(side) for side in sides)
    gain = [abs(normal @ side) / (normal @ to_light) for side in sides]

    def at(**parts):
        found = sl.Bias(**ONLY | parts).at(view, p, 512, renderer="cpu")
        assert found.dtype == np.float32
        assert found.shape == (36, 64)
        return found

    assert at(world=0.02) == pytest.approx(0.02, rel=1e-4)
    assert at(texels=2) == pytest.approx(2 * texel, rel=1e-4)
    assert at(ndc=1e-3) == pytest.approx(1e-3 / abs(rows[2, :3] @ to_light), rel=1e-3)
    assert at(slope=1) == pytest.approx(0.5 * sum(gain), rel=1e-4, abs=1e-6)
    # A step along the normal is nearer to the light by its part along the ray.
    assert at(normal=1) == pytest.approx(texel * (normal @ to_light), rel=1e-4)
    # A texel's gain along either axis, and of depth in single precision a step at 0.5 to 1.
    assert at(factor=1) == pytest.approx(max(gain), rel=1e-4, abs=1e-6)
    steps = at(units=8) * abs(rows[2, :3] @ to_light) / 8 * 2**24
    assert np.isin(np.round(steps, 2), [0.5, 1.0, 2.0]).all()
    # On either side of the centre, by no more than the plane gains within the texel.
    plane = at(plane=1)
    assert np.abs(plane).max() <= 0.5 * sum(gain) * (1 + 1e-3) + 1e-6
    if angle > 0:
        assert plane.min() < 0 < plane.max()


def test_the_slope_covers_the_reach_of_the_filter():
    view, _, _ = tilted(0.8)
    bias = sl.Bias(**ONLY | {"slope": 1.0})
    narrow, wide = (bias.at(view, "uniform", 512, filter=one, renderer="cpu") for one in ("nearest", "pcf2x2"))
    assert wide == pytest.approx(2 * narrow, rel=1e-4)


@pytest.mark.parametrize(
    ("scene", "technique", "resolution"),
    [("robots", "lispsm", 256), ("robots", "z_partition:count=3,inner=lispsm", 128), ("dueling", "log_psm", 256)],
)
def test_it_is_what_explained_pixels_say(scene, technique, resolution):
    view = view_of(scene)
    found = WHOLE.at(view, technique, resolution, renderer="cpu")
    run = run_of(scene, technique, resolution)
    compared = 0
    for x, y in some(run.errors.image >= 0, 40, 5):
        said = explained(view, technique, x, y, resolution, bias=WHOLE).comparison
        if said is None:
            assert np.isnan(found[y, x])
        elif said.reference is not None:
            assert found[y, x] == pytest.approx(said.bias_world, rel=1e-4, abs=1e-5)
            compared += 1
    assert compared > 20


def test_what_is_not_compared_has_none():
    view = view_of("robots")
    found = sl.Bias().at(view, "uniform", 256, renderer="cpu")
    mask = sl.Renderer("cpu").shadow_mask(
        view.scene, view.camera, view.light,
        sl.technique("uniform").parameterize(view.scene, view.camera, view.light), size=view.size, resolution=256,
    )  # fmt: skip
    assert np.isnan(mask).any()
    assert np.isnan(found[np.isnan(mask)]).all()
    averted = view.gbuffer("cpu").normal @ np.asarray(view.light.direction) > 0
    assert np.isnan(found[averted]).all()


def test_past_the_light_it_ends():
    view, _, to_light = tilted(0.3)
    light = sl.SpotLight(9 * to_light, -to_light, cone_angle=1.2, range=60)
    view = sl.View(view.scene, view.camera, light, size=view.size)
    found = sl.Bias(**ONLY | {"world": 100.0}).at(view, "uniform", 256, renderer="cpu")
    away = np.linalg.norm(view.gbuffer("cpu").position - np.asarray(light.position), axis=-1)
    compared = ~np.isnan(found)
    assert compared.any()
    assert (found[compared] <= away[compared]).all()


def test_wrong_arguments_are_named():
    view, bias = view_of("robots"), sl.Bias()
    with pytest.raises(ArgumentError, match="view"):
        bias.at(view.scene, "uniform")
    with pytest.raises(UnknownNameError, match="unifrom"):
        bias.at(view, "unifrom")
    with pytest.raises(ArgumentError, match="resolution"):
        bias.at(view, "uniform", 0)
    with pytest.raises(UnknownNameError, match="filter"):
        bias.at(view, "uniform", filter="median")
