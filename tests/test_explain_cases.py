"""Explanations of pixels that are no plain case: background, undecided, averted, outside of maps; and wrong calls."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from explain_support import CAUSE_NAMES as NAMES
from explain_support import explained, run_of, some, view_of

import shadowlab as sl


def test_a_pixel_of_the_background():
    scene = sl.library.scene("robots")
    up = scene.camera.replace(target=scene.camera.eye + np.array([0.2, 1.0, -0.3]), up=(0.0, 0.0, -1.0))
    found = explained(sl.View(scene, up, scene.light, size=(32, 18)), "uniform", 3, 4, 64, trials=True)
    assert (found.truth, found.verdict, found.light, found.surface) == ("nothing", "not compared", None, None)
    assert (found.reason, found.map, found.trials, found.mends) == ("nothing", None, (), ())
    assert "shows no surface" in str(found)


def test_an_undecided_pixel_counts_as_no_error():
    view = view_of("robots")
    truth = view.truth()
    for x, y in some(truth == sl.trace.Truth.UNDECIDED, 3, 1):
        found = explained(view, "lispsm", x, y, 256, trials=True)
        assert (found.truth, found.verdict, found.cause, found.trials) == ("undecided", "not compared", None, ())
        assert "undecided" in str(found)
        assert "no error" in str(found)


def test_a_surface_that_faces_away_asks_no_map():
    view = view_of("robots")
    cosine = -np.asarray(view.gbuffer("cpu").normal) @ np.asarray(view.light.direction)
    for x, y in some((cosine < -0.1) & (view.truth() == 0), 5, 1):
        found = explained(view, "lispsm", x, y, 256)
        assert (found.reason, found.map, found.texel, found.verdict) == ("averted", None, None, "right")
        assert not found.surface.faces_light
        assert found.surface.light_cosine < 0
        assert "faces away" in str(found)


def test_a_point_outside_of_the_map_is_lit_and_missing():
    """A map that holds nothing of what is seen: shadows are missing, and the explanation says why."""
    view = view_of("robots")
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light, resolution=64)
    moved = np.array(p.matrix)
    moved[0] += 5.0 * moved[3]
    run = sl.evaluate(view, sl.Parameterization.from_matrix(moved), 64, renderer="cpu")
    (x, y), *_ = some(run.causes.image == 4, 1, 1)
    found = explained(view, run.item, x, y, 64)
    assert (found.reason, found.map, found.cause, found.light) == ("outside", None, "missing", 1.0)
    assert "No map holds the receiver" in str(found)
    assert found.blocker is not None


@pytest.mark.parametrize(
    ("stored", "words"),
    [("front", "The map itself is wrong"), ("second", "Surfaces lie on one another in the texel, or the map")],
)
def test_another_map_is_named_wrong(stored, words):
    """Depths that the light does not meet: the cause is other, the ray does not agree, and the text says so."""
    view = view_of("robots")

    class Broken:
        """A renderer whose maps hold a surface that is not there."""

        backend, adapter = "cpu", "broken"

        def __init__(self):
            self.ours = sl.Renderer("cpu")

        def gbuffer(self, *args, **more):
            return self.ours.gbuffer(*args, **more)

        def shadow_mask(self, *args, **more):
            raise NotImplementedError

        def shadow_map(self, *args, **more):
            depth = self.ours.shadow_map(*args, **more).copy()
            depth[::2] = 0.25
            return depth

    broken = Broken()
    run = sl.evaluate(view, "uniform", 128, renderer=broken, stored=stored)
    (x, y), *_ = some(run.causes.image == 5, 1, 1)
    found = explained(view, "uniform", x, y, 128, renderer=broken, stored=stored)
    assert found.cause == "other"
    assert not found.held.agrees
    assert found.held.depth == 0.25
    assert words in str(found)


@pytest.mark.parametrize(
    ("x", "y", "name"),
    [(-1, 0, "x"), (320, 0, "x"), (0, 180, "y"), (0, -1, "y"), (1.5, 0, "x"), (0, "3", "y"), (True, 0, "x")],
)  # fmt: skip
def test_a_pixel_out_of_the_picture_is_refused(x, y, name):
    with pytest.raises(sl.errors.ArgumentError, match=f"^{name}: expected a whole number from 0 to"):
        explained(view_of("robots"), "uniform", x, y, 64)


def test_several_lights_are_refused():
    view = view_of("robots")
    several = sl.View(view.scene, view.camera, [view.light, sl.DirectionalLight((0, -1, 0.1))], size=(32, 18))
    with pytest.raises(sl.errors.ArgumentError, match=r"view: expected one light, got 2"):
        explained(several, "uniform", 0, 0, 64)


def test_a_technique_that_cannot_serve_the_light_is_an_error():
    view = view_of("robots")
    light = sl.PointLight((0.0, 4.0, 0.0), range=30.0)
    with pytest.raises(sl.errors.UnsupportedError):
        explained(sl.View(view.scene, view.camera, light, size=(32, 18)), "log", 3, 14, 64)


@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
def test_placed_lights_are_explained(technique):
    view = view_of("robots")
    light = sl.PointLight((0.5, 4.0, 1.0), range=60.0)
    lit = sl.View(view.scene, view.camera, light, size=(160, 90))
    run = sl.evaluate(lit, technique, 128, renderer="cpu")
    wrong = some(run.errors.image > 0, 12, 1)
    assert wrong
    for x, y in wrong:
        found = explained(lit, technique, x, y, 128)
        assert found.cause == NAMES[run.causes.image[y, x]]
        if found.map is not None:
            assert found.light == found.comparison.light
            assert found.maps > 1


def test_the_text_begins_with_what_matters():
    run, view = run_of("robots", "lispsm", 256), view_of("robots")
    (x, y), *_ = some(run.causes.image == 3, 1, 2)
    found = explained(view, "lispsm", x, y, 256, trials=True)
    first, second, third, *_ = str(found).splitlines()
    assert first.startswith(f"Pixel ({x}, {y}) of lispsm at 256² is wrong: the map lights it")
    assert first.endswith("Cause: leak.")
    assert "bias" in second
    assert third == "Right with:"
    assert repr(found) == f"PixelExplanation(lispsm at 256², pixel ({x}, {y}), false light: leak)"
    for word in ("Surface:", "Truth:", "Map:", "Texel:", "Stored:", "Comparison:", "Verdict:"):
        assert word in str(found)


def test_an_explanation_travels():
    run, view = run_of("robots", "lispsm", 256), view_of("robots")
    (x, y), *_ = some(run.causes.image == 3, 1, 2)
    found = explained(view, "lispsm", x, y, 256)
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert str(again) == str(found)
    assert hash(again) == hash(found)


def test_a_caster_that_the_map_cuts_off_is_named():
    """Depths that begin behind the casters: the explanation gives the depth at which the map would hold them."""
    view = view_of("robots")
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light, resolution=256)
    cut = np.array(p.matrix)
    origin = np.asarray(view.gbuffer("cpu").position)[view.gbuffer("cpu").triangle >= 0]
    depths = p.partitions[0].project(origin)[0][:, 2]
    near = float(np.percentile(depths, 40))
    cut[2] = (cut[2] - near * cut[3]) / (1.0 - near)
    run = sl.evaluate(view, sl.Parameterization.from_matrix(cut), 256, renderer="cpu")
    tested = 0
    for x, y in some(run.causes.image == 4, 20, 1):
        found = explained(view, run.item, x, y, 256)
        if found.map is not None and found.blocker is not None and found.blocker_depth < 0:
            assert "outside of the map's depths" in str(found)
            tested += 1
    assert tested > 0
