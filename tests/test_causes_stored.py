"""Causes of wrong pixels of maps that store any surface, spacing and format: scenes whose causes are known."""

from __future__ import annotations

import numpy as np
import pytest
from explain_support import view_of
from test_causes import CAMERA, SUN, View, floor, joined, only, plate

import shadowlab as sl

SURFACES = ("front", "back", "second", "midpoint", "dual")
SPACINGS = ("projective", "linear")
FORMATS = ("f32", "unorm24", "unorm16", "f16")


class StoredView(View):
    """A view whose maps may store anything."""

    def counts(self, stored, technique="uniform", *, resolution=256, bias=None, filter="nearest", blend=0.0):
        by_body = sl.technique(technique).by_body()
        p = by_body.parameterize(self.scene, self.camera, self.light, resolution=resolution)
        maps = self.renderer.shadow_map(self.scene, p, resolution=resolution, stored=stored)
        read = {"bias": bias, "filter": filter, "blend": blend, "stored": stored}
        looks = (self.gbuffer, self.camera, self.light, p)
        mask = sl.aliasing.look_up(maps, *looks, **read)
        found = sl.aliasing.causes(
            self.scene, self.camera, self.light, p, mask, self.truth, gbuffer=self.gbuffer, maps=maps, **read
        )
        return found.counts


def slab(y, thick, low=(-3, -3), high=(3, 3)):
    """A closed box whose lower side is at y."""
    (x0, z0), (x1, z1), top = low, high, y + thick
    corners = np.array([[x, h, z] for x in (x0, x1) for h in (y, top) for z in (z0, z1)], float)
    faces = [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]  # fmt: skip
    return corners, np.array(faces)


@pytest.fixture(scope="module")
def plane():
    return StoredView(joined(floor()))


@pytest.fixture(scope="module")
def roof():
    """A closed slab above a closed ground."""
    return StoredView(joined(slab(-3, 3, (-20, -20), (20, 20)), slab(2.5, 0.5)))


@pytest.fixture(scope="module")
def awning():
    """An open plate above an open floor, both with their outer sides up."""
    return StoredView(joined(floor(), plate(2.5)))


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
def test_a_plane_alone_has_acne_and_nothing_else(plane, technique, spacing, format):
    """Rounding of depths is acne, too, with a bias for the plane's slope alone or none."""
    stored = sl.Stored(spacing=spacing, format=format)
    for bias in (sl.Bias.none(), sl.Bias(world=0, texels=0, ndc=0, slope=1.02, plane=0)):
        counts = plane.counts(stored, technique, bias=bias)
        assert counts == only(acne=counts["acne"])
    assert plane.counts(stored, technique, bias=sl.Bias.none())["acne"] > 1000


@pytest.mark.filterwarnings("ignore::shadowlab.errors.ShadowlabWarning")
@pytest.mark.parametrize("surface", ["back", "second", "midpoint"])
def test_a_plane_alone_has_nothing_behind_it(plane, surface):
    assert plane.counts(surface, bias=sl.Bias.none()) == only()


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("spacing", SPACINGS)
def test_closed_casters_have_displaced_edges_alone(roof, surface, spacing):
    """Whatever is stored of them, light and shadow end at the silhouettes of what light meets first."""
    for technique, resolution in (("uniform", 64), ("lispsm", 128)):
        counts = roof.counts(sl.Stored(surface, spacing=spacing), technique, resolution=resolution)
        assert counts["edge"] > 25
        assert counts == only(edge=counts["edge"])


@pytest.mark.filterwarnings("ignore::shadowlab.errors.ShadowlabWarning")
@pytest.mark.parametrize("surface", ["back", "second"])
def test_an_open_caster_is_missing(awning, surface):
    """What it has no such surface of is lit; without bias the floor below shades itself: acne of lit pixels."""
    counts = awning.counts(surface)
    assert counts["missing"] > 1000
    assert counts == only(missing=counts["missing"])
    bare = awning.counts(surface, bias=sl.Bias.none())
    assert bare["missing"] > 500
    assert bare == only(missing=bare["missing"], acne=bare["acne"])


@pytest.mark.filterwarnings("ignore::shadowlab.errors.ShadowlabWarning")
@pytest.mark.parametrize("surface", ["midpoint", "dual"])
def test_an_open_caster_is_held_by_depths_between(awning, surface):
    counts = awning.counts(surface)
    assert counts["edge"] > 25
    assert counts["missing"] == counts["leak"] == counts["other"] == 0


@pytest.mark.parametrize("surface", SURFACES)
def test_a_bias_that_passes_what_is_stored_leaks(roof, surface):
    counts = roof.counts(surface, bias=sl.Bias(world=8.0, texels=0, slope=0, ndc=0), resolution=512)
    assert counts["leak"] > 1000
    assert roof.counts(surface, bias=sl.Bias.none(), resolution=512)["leak"] == 0


@pytest.mark.parametrize("surface", SURFACES)
def test_a_map_that_holds_what_is_not_there_is_named(surface):
    """Depths moved towards the light by a tenth of the map: what they hold, light does not meet."""
    view = StoredView(joined(slab(-3, 3, (-20, -20), (20, 20)), slab(2.5, 0.5)), CAMERA, SUN, (160, 90))
    p = sl.technique("uniform").by_body().parameterize(view.scene, view.camera, view.light, resolution=128)
    maps = np.asarray(view.renderer.shadow_map(view.scene, p, resolution=128, stored=surface)).copy()
    maps[maps < 1] = np.maximum(maps[maps < 1] - 0.3, 0)
    mask = sl.aliasing.look_up(maps, view.gbuffer, view.camera, view.light, p, stored=surface)
    found = sl.aliasing.causes(
        view.scene, view.camera, view.light, p, mask, view.truth, gbuffer=view.gbuffer, maps=maps, stored=surface
    )
    assert found.other > 0.9 * found.count > 1000


@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
def test_linear_depth_has_the_causes_of_projective_depth(technique):
    """Most pixels that are wrong with both have the same cause: edges are the same, bias differs."""
    view = view_of("skylight")
    images = [
        sl.evaluate(view, technique, 256, renderer="cpu", stored=sl.Stored(spacing=spacing)).causes.image
        for spacing in SPACINGS
    ]
    both = (images[0] > 0) & (images[1] > 0)
    assert both.sum() > 500
    assert (images[0] == images[1])[both].mean() > 0.98


def test_where_maps_blend_the_cause_is_that_of_the_map_that_errs():
    """A pixel whose own map is right alone has the cause that it has in the next map."""
    view = view_of("skylight")
    technique = "z_partition:count=3,overlap=0.5,inner=uniform"
    run = sl.evaluate(view, technique, 64, renderer="cpu", blend=0.5)
    alone = sl.evaluate(view, technique, 64, renderer="cpu")
    wrong = (run.errors.image > 0) & (alone.errors.image == 0)
    assert wrong.sum() > 20
    assert (run.causes.image[wrong] > 0).all()
    # What the map itself holds is right, whichever is asked.
    assert run.causes.other <= 0.02 * run.causes.count
    same = (run.errors.image > 0) & (alone.errors.image > 0)
    assert (run.causes.image == alone.causes.image)[same].mean() > 0.95
