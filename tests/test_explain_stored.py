"""Explanations of pixels of maps that store any surface, spacing and format, against independent rays."""

from __future__ import annotations

import numpy as np
import pytest
from explain_support import (
    ABOUT,
    CAUSE_NAMES,
    FORMAT_STEPS,
    SNAP,
    WRONG_PIXELS,
    Triangles,
    explained,
    ndc_of,
    some,
    texel_ray,
    texel_size,
    view_of,
)

import shadowlab as sl

STORED = (
    "back", "second", "midpoint", "dual", "dual:limit=0.5", "front:spacing=linear",
    "back:spacing=linear,format=unorm16", "second:spacing=linear", "midpoint:spacing=linear,format=f16",
    "dual:spacing=linear,format=unorm24",
    "front:format=f16", "front:format=unorm16",
)  # fmt: skip
RUNS = (("robots", "lispsm", 256), ("skylight", "uniform", 256))
# Depths that single precision does not tell apart.
APART = 2.0**-22
# Share of wrong pixels whose stored depth no ray about the centre may confirm: along the silhouettes of solids, where
# the layers of a ray come together, a rasteriser draws more of them than the five rays meet.
UNCONFIRMED = 0.02
# Share of texels whose triangles are those that one of the five rays meets: others share an edge with them.
NAMED = 0.9


class Expected:
    """What a projective map of a directional light stores of its rays, by the definitions of theory.md 13."""

    def __init__(self, view, matrix, resolution, stored):
        self.triangles, self.matrix, self.resolution = Triangles.of(view.scene), matrix, resolution
        self.stored, self.light = stored, view.light
        self.along = np.asarray(view.light.direction) / np.linalg.norm(view.light.direction)
        corners = [np.linalg.inv(matrix) @ [x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]
        places = [corner[:3] / corner[3] @ self.along for corner in corners]
        self.ends = min(places), max(places)

    def depth(self, point):
        """What is stored of a point, before it is rounded."""
        if self.stored.spacing == "projective":
            return ndc_of(self.matrix, point)[2]
        return (point @ self.along - self.ends[0]) / (self.ends[1] - self.ends[0])

    def texel(self, point):
        return texel_size(self.matrix, point, self.light, np.zeros(3), self.resolution)

    def of(self, place):
        """Depth and names of the triangles that it comes from, by the ray of a place; 1 and none for nothing."""
        origin, way = texel_ray(self.matrix, place, self.resolution)
        t, index = self.triangles.hits(origin, way)
        points = [origin + one * way for one in t]
        z = np.array([ndc_of(self.matrix, point)[2] for point in points])
        within = z < 1 if len(z) else np.zeros(0, bool)
        if not within.any():
            return 1.0, []
        name = [(int(self.triangles.instance[k]), int(self.triangles.triangle[k])) for k in index]
        surface = self.stored.surface
        if surface == "front":
            return self.depth(points[0]), [name[0]]
        if surface == "back":
            averted = np.flatnonzero(within & (self.triangles.outer[index] @ way > 0))
            return (self.depth(points[averted[0]]), [name[averted[0]]]) if len(averted) else (1.0, [])
        later = np.flatnonzero(within & (z > z[0] + APART))
        second = later[0] if len(later) else None
        if surface == "second":
            return (self.depth(points[second]), [name[second]]) if second is not None else (1.0, [])
        if second is None and surface == "midpoint":
            return 1.0, []
        half = np.inf if second is None else 0.5 * np.linalg.norm(points[second] - points[0])
        if surface == "dual":
            half = min(half, self.stored.limit * self.texel(points[0]))
        place = points[0] + half * way / np.linalg.norm(way)
        return min(self.depth(place), 1.0), [name[0]] + ([] if second is None else [name[second]])


@pytest.mark.filterwarnings("ignore::shadowlab.errors.ShadowlabWarning")
@pytest.mark.parametrize("stored", STORED)
def test_stored_depth_and_triangles_are_those_of_an_independent_ray(stored):
    stored = sl.Stored(stored)
    each = -(-WRONG_PIXELS // (len(STORED) * len(RUNS)))
    checked = unconfirmed = filled = named = 0
    for scene, technique, resolution in RUNS:
        view = view_of(scene)
        run = sl.evaluate(view, technique, resolution, renderer="cpu", stored=stored)
        expected = Expected(view, np.asarray(run.parameterization.matrix), resolution, stored)
        for x, y in some(run.errors.image > 0, each, 6):
            found = explained(view, technique, x, y, resolution, stored=stored)
            assert found.cause == CAUSE_NAMES.get(run.causes.image[y, x])
            held, texel = found.held, found.texel
            assert held.depth == run.maps[texel.row, texel.column]
            checked += 1
            rays = [expected.of(np.array([texel.column, texel.row]) + 0.5 + step) for step in ABOUT]
            depths = np.array([depth for depth, _ in rays])
            if not held.agrees:
                unconfirmed += 1
                continue
            step = FORMAT_STEPS[stored.format]
            # A part of a texel along the ray, in the units of what is stored, and a step of its format.
            here = expected.depth(found.surface.point)
            moved = abs(expected.depth(found.surface.point + max(texel.size_world) * expected.along) - here)
            slack = 4 * SNAP * moved + 4e-7 + step
            assert depths.min() - slack <= held.depth <= depths.max() + slack, (x, y, held.depth, depths)
            if held.is_empty:
                # Nothing is stored, or what is lies within a step of the end.
                assert depths.max() >= 1 - step
                continue
            names = [(met.instance, met.triangle) for met in held.surfaces]
            filled += 1
            named += names in [triangles for _, triangles in rays]
            assert held.ray_depth == pytest.approx(held.depth, abs=np.ptp(depths) + slack)
            # Where the depth is, is on the ray of the texel's centre.
            assert expected.depth(held.point) == pytest.approx(held.depth, abs=1e-6)
            centre = texel_ray(expected.matrix, np.array([texel.column, texel.row]) + 0.5, resolution)[0]
            assert ndc_of(expected.matrix, held.point)[:2] == pytest.approx(
                ndc_of(expected.matrix, centre)[:2], abs=1e-6
            )
            assert held.first is not None
    assert checked >= 0.5 * each * len(RUNS)
    assert unconfirmed <= max(1, UNCONFIRMED * checked)
    assert filled >= 0.2 * checked
    assert named >= NAMED * filled


def test_a_pixel_at_which_maps_blend_is_explained_in_the_map_that_errs():
    """The two lights mix to that of the mask; the map explained is the one whose light alone is wrong."""
    view, technique = view_of("skylight"), "z_partition:count=3,overlap=0.5,inner=uniform"
    read = {"blend": 0.5, "filter": "bilinear"}
    run = sl.evaluate(view, technique, 64, renderer="cpu", **read)
    looks = (view.gbuffer("cpu"), view.camera, view.light, run.parameterization)
    every = np.argwhere(run.errors.image >= 0)[:, ::-1]
    maps, _ = sl._core.blended(*looks, every, 0.5)
    zone = np.zeros(run.errors.image.shape, bool)
    zone[tuple(every[maps >= 0].T[::-1])] = True
    blended = 0
    wrong = run.errors.image > 0
    for x, y in some(wrong & zone, 20, 3) + some(wrong & ~zone, 10, 4) + some(~wrong & zone, 10, 5):
        found = explained(view, technique, x, y, 64, **read)
        assert found.cause == CAUSE_NAMES.get(run.causes.image[y, x])
        if found.blend is None:
            assert found.map is None or found.light == pytest.approx(found.comparison.light, abs=1e-6)
            continue
        blended += 1
        (own, other), shares, lights = found.blend.maps, found.blend.shares, found.blend.lights
        assert own == run.chosen[y, x] != other
        assert sum(shares) == pytest.approx(1)
        assert found.light == pytest.approx(np.dot(shares, lights), abs=1e-6)
        assert found.map in (own, other)
        assert found.comparison.light == pytest.approx(lights[found.blend.maps.index(found.map)], abs=1e-6)
        if found.is_wrong:
            assert (found.comparison.light >= 0.5) == (found.verdict == "false light")
        assert "Explained here" in str(found)
    assert blended > 15
    assert explained(view, f"{technique},mix=0.5", x, y, 64, filter="bilinear").light == found.light


@pytest.mark.filterwarnings("ignore::shadowlab.errors.ShadowlabWarning")
@pytest.mark.parametrize("stored", STORED)
def test_every_cause_has_a_text_and_a_figure(stored):
    view, stored = view_of("robots"), sl.Stored(stored)
    for bias in (None, sl.Bias.none()):
        run = sl.evaluate(view, "lispsm", 128, renderer="cpu", stored=stored, bias=bias)
        for code in np.unique(run.causes.image[run.causes.image >= 0]):
            (x, y), *_ = some(run.causes.image == code, 1, 3)
            found = explained(view, "lispsm", x, y, 128, stored=stored, bias=bias)
            assert found.run.stored == stored
            text = str(found)
            if stored.surface != "front" and found.map is not None:
                assert "It stores" in text
            if stored.format != "f32" and found.map is not None:
                assert f"rounded to {stored.format}" in text
            assert len(found.figure().axes) == 3
