"""The least bias of maps that store other surfaces, linear depth or fewer digits: planes against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from explain_support import FORMAT_STEPS
from test_smallest_bias import NEAR_CORNER, PARTS, SNAPPED, TOLERANCE, found_in, plane_view

import shadowlab as sl
from shadowlab.aliasing.bias_parts import with_part

SURFACES = ("back", "second", "midpoint", "dual")


def needed_of_plane(view, part, resolution=512, step=0.0):
    """What an endless plane needs under a uniform map of a directional light that stores linear depth, by hand."""
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light, resolution=resolution)
    rows, to_light = p.matrix, -np.asarray(view.light.direction)
    normal = view.gbuffer("cpu").normal[90, 160].astype(float)
    sides = [np.asarray(rows[i, :3]) / np.dot(rows[i, :3], rows[i, :3]) * 2 / resolution for i in range(2)]
    gain = 0.5 * sum(abs(np.dot(normal, side) / np.dot(normal, to_light)) for side in sides)
    # World length of the map along the light: what linear depth is in units of.
    corners = [np.linalg.inv(rows) @ [x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]
    length = np.ptp([corner[:3] / corner[3] @ to_light for corner in corners])
    world = gain + 0.5 * step * length
    return {
        "slope": world / gain,
        "world": world,
        "texels": world / max(np.linalg.norm(side) for side in sides),
        "ndc": world / length,
    }[part]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("part", PARTS)
def test_a_plane_needs_its_closed_form_in_linear_depth(seed, part):
    view = plane_view(seed)
    found = found_in(view, "uniform", part, acne=0.0, stored="front:spacing=linear")
    by_hand = needed_of_plane(view, part)
    assert found.closed_form == pytest.approx(by_hand, rel=1e-5)  # normals are in single precision
    assert NEAR_CORNER * by_hand < found.value < by_hand * SNAPPED * (1 + TOLERANCE)
    assert found.acne == 0 < found.curve.acne[0]


@pytest.mark.parametrize("technique", ["lispsm", "log_psm", "rectilinear", "z_partition:count=3,inner=lispsm"])
@pytest.mark.parametrize("part", PARTS)
def test_a_plane_needs_no_more_than_its_closed_form_in_any_linear_map(technique, part):
    found = found_in(plane_view(11), technique, part, acne=0.0, stored="front:spacing=linear")
    assert 0.5 * found.closed_form < found.value < found.closed_form * SNAPPED * (1 + TOLERANCE)
    assert found.curve.acne[0] > 1000


@pytest.mark.parametrize("part", PARTS)
def test_placed_lights_in_linear_depth(part):
    at = -9 * np.asarray(plane_view(3).light.direction)
    view = plane_view(3, sl.SpotLight(at, -at, cone_angle=1.6, range=60))
    found = found_in(view, "uniform", part, acne=0.0, stored="front:spacing=linear")
    assert 0.5 * found.closed_form < found.value < found.closed_form * SNAPPED * (1 + TOLERANCE)
    assert found.curve.acne[0] > 1000


@pytest.mark.parametrize("filter", ["bilinear", "pcf:size=3"])
def test_the_reach_of_a_filter_counts_in_linear_depth(filter):
    found = found_in(plane_view(11), "lispsm", "slope", acne=0.0, stored="front:spacing=linear", filter=filter)
    assert found.closed_form == 1.0
    assert 0 < found.value < SNAPPED * (1 + TOLERANCE)


@pytest.mark.parametrize("spacing", ["projective", "linear"])
@pytest.mark.parametrize("format", ["f16", "unorm16", "unorm24"])
@pytest.mark.parametrize("part", ["ndc", "texels"])
def test_a_plane_needs_half_a_step_more(spacing, format, part):
    """Rounded depths are nearer to the light by up to half a step."""
    view, stored = plane_view(1), f"front:spacing={spacing},format={format}"
    # Texels so fine that half a step is a good part of what is needed.
    found = found_in(view, "uniform", part, acne=0.0, stored=stored, resolution=2048)
    plain = found_in(view, "uniform", part, acne=0.0, resolution=2048)
    length = needed_of_plane(view, "world", 2048) / needed_of_plane(view, "ndc", 2048)
    if spacing == "linear" and format != "f16":
        assert found.closed_form == pytest.approx(needed_of_plane(view, part, 2048, FORMAT_STEPS[format]), rel=1e-5)
    assert found.closed_form > plain.closed_form
    assert found.value < found.closed_form * SNAPPED * (1 + TOLERANCE)
    if format != "unorm24":
        assert found.value > plain.value, f"half a step, {0.5 * FORMAT_STEPS[format] * length} world units, is needed"
    else:
        assert found.value == pytest.approx(plain.value, rel=0.05)


def test_slope_does_not_mend_rounding():
    """Straight across the light a plane gains nothing, and rounded depths shade it all the same."""
    scene = sl.Scene.from_arrays([[-9, 0, -9], [9, 0.01, -9], [9, 0.01, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    camera = sl.Camera.look_at((0, 5, 6), (0, 0, 0), aspect=16 / 9, near=1, far=40)
    box = sl.Scene.from_arrays([[0, 8, 0], [0.01, 8, 0], [0, 8, 0.01]], [[0, 1, 2]])
    view = sl.View(scene + box, camera, sl.DirectionalLight((0, -1, 0)), size=(160, 90))
    stored = sl.Stored(format="f16")
    slope, world = (found_in(view, "uniform", part, acne=0.0, stored=stored) for part in ("slope", "world"))
    assert slope.curve.acne[0] > 1000
    assert world.closed_form == pytest.approx(
        0.5 * stored.step(
            sl.technique("uniform").parameterize(view.scene, camera, view.light, resolution=512), [[0.0, 0.005, 0.0]]
        )[0], rel=0.05,
    )  # fmt: skip
    assert 0.5 * world.closed_form < world.value < world.closed_form * SNAPPED * (1 + TOLERANCE)
    assert slope.closed_form > 5


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("spacing", ["projective", "linear"])
def test_counts_of_other_surfaces_are_those_of_an_evaluation(surface, spacing):
    scene = sl.library.scene("robots")
    view = sl.View(scene, scene.camera, scene.light, size=(320, 180))
    stored = sl.Stored(surface, spacing=spacing)
    found = found_in(view, "lispsm", "texels", acne=0.0001, stored=stored)
    assert found.closed_form is None
    assert found.stored == stored
    assert str(stored) in str(found)
    assert found.value is not None
    assert found.acne <= found.allowed < found.curve.acne[0]
    for value in (0.0, found.value):
        bias = with_part(sl.Bias.none(), "texels", value)
        run = sl.evaluate(view, "lispsm", 512, renderer="cpu", bias=bias, stored=stored)
        row = found.curve[found.curve.value == value].iloc[0]
        assert (row.wrong, row.leaks) == (run.errors.count, run.errors.false_light)
        assert row.acne == run.causes.acne


def test_a_techniques_own_text_says_it_too():
    view = plane_view(2)
    said = found_in(view, "uniform", "ndc", acne=0.0, stored="front:spacing=linear,format=f16")
    own = found_in(view, "uniform:stored=(front:spacing=linear,format=f16)", "ndc", acne=0.0)
    assert (own.value, own.closed_form, own.stored) == (said.value, said.closed_form, said.stored)
