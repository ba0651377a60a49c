"""What would mend a pixel, tried again."""

from __future__ import annotations

import numpy as np
import pytest
from explain_support import CASES, explained, run_of, some, view_of

import shadowlab as sl
from shadowlab.text import BIAS


@pytest.mark.parametrize(("scene", "technique", "resolution"), [CASES[1], CASES[3], CASES[4]])
def test_what_mends_mends(scene, technique, resolution):
    """Each trial, evaluated again, gives the same pixel and the same count."""
    run, view = run_of(scene, technique, resolution), view_of(scene)
    kinds = set()
    for code in (1, 2, 3, 4):
        for x, y in some(run.causes.image == code, 2, code):
            found = explained(view, technique, x, y, resolution, trials=True)
            assert {trial.kind for trial in found.trials} == {"resolution", "bias", "stored", "technique"}
            for trial in found.trials:
                again = sl.evaluate(
                    view, trial.technique, trial.resolution, metrics=["misclassified"], renderer="cpu", bias=trial.bias,
                    stored=trial.stored,
                )  # fmt: skip
                assert trial.failure == again.failure
                if again.failure:
                    assert not trial.is_right
                    continue
                assert trial.is_right == (again.errors.image[y, x] == 0), trial.text
                assert trial.wrong_before == run.errors.count
                if trial.wrong is not None:
                    assert trial.wrong == again.errors.count
                kinds |= {trial.kind} if trial.is_right else set()
    assert {"resolution", "technique"} <= kinds


def test_the_bias_that_mends_is_the_least():
    """A hundredth less of the change leaves the pixel wrong."""
    run, view = run_of("skylight", "uniform", 256), view_of("skylight")
    tested = 0
    for x, y in some(np.isin(run.causes.image, (1, 3)), 12, 9):
        found = explained(view, "uniform", x, y, 256, trials=True)
        for trial in found.mends:
            if trial.kind != "bias":
                continue
            own, new = getattr(run.bias, trial.part), getattr(trial.bias, trial.part)
            values = {name: getattr(run.bias, name) for name in BIAS}
            less = sl.Bias(**values | {trial.part: own + 0.98 * (new - own)})
            again = sl.evaluate(view, "uniform", 256, metrics=["misclassified"], renderer="cpu", bias=less)
            assert again.errors.image[y, x] != 0, trial.text
            tested += 1
    assert tested > 5


def test_neighbours_are_counted():
    run, view = run_of("robots", "lispsm", 256), view_of("robots")
    (x, y), *_ = some(run.causes.image == 3, 1, 1)
    found = explained(view, "lispsm", x, y, 256, trials=True)
    trial = next(trial for trial in found.mends if trial.kind == "technique")
    again = sl.evaluate(view, trial.technique, 256, metrics=["misclassified"], renderer="cpu")
    around = (slice(max(0, y - 16), y + 17), slice(max(0, x - 16), x + 17))
    before, after = run.errors.image[around], again.errors.image[around]
    assert trial.mended == np.count_nonzero((before > 0) & (after == 0))
    assert trial.broken == np.count_nonzero((before == 0) & (after > 0))


def test_trials_of_an_object_name_all_of_its_settings():
    """What is explained may be no text; the trials' technique is one all the same, and makes the same maps."""
    view = view_of("robots")
    item = sl.technique("lispsm", near=0.5)
    run = sl.evaluate(view, item, 128, metrics=["misclassified"], renderer="cpu")
    (x, y), *_ = some(run.errors.image > 0, 1, 1)
    found = explained(view, item, x, y, 128, trials=True)
    trial = next(trial for trial in found.trials if trial.kind == "resolution")
    again = sl.evaluate(view, trial.technique, trial.resolution, metrics=["misclassified"], renderer="cpu")
    assert again.errors.count == trial.wrong
    assert again.parameterization == sl.evaluate(view, item, trial.resolution, renderer="cpu").parameterization


def test_no_map_is_drawn_beyond_the_limit():
    from shadowlab.experiments.pixel_trials import LONGEST_MAP, MOST_TRIED_TEXELS

    assert LONGEST_MAP == 8192
    view, several = view_of("robots"), "z_partition:count=3,inner=lispsm"
    for technique, maps in (("lispsm", 1), (several, 3)):
        run = run_of("robots", technique, 2048)
        chosen = some(run.errors.image > 0, 1, 2)
        for x, y in chosen:
            found = explained(view, technique, x, y, 2048, trials=True)
            sides = [trial.resolution for trial in found.trials if trial.kind == "resolution"]
            assert sides == [4096, 8192][: len(sides)]
            assert all(maps * side**2 <= MOST_TRIED_TEXELS for side in sides)


@pytest.mark.parametrize("stored", ["back:format=unorm16", "midpoint:spacing=linear"])
def test_what_else_maps_could_store_is_tried(stored):
    """Each surface, the other spacing, and single precision in place of less; of a technique's own text, too."""
    view, text = view_of("robots"), f"lispsm:stored=({stored}),bias=none,filter=bilinear"
    run = sl.evaluate(view, text, 128, renderer="cpu")
    (x, y), *_ = some(run.errors.image > 0, 1, 1)
    found = explained(view, text, x, y, 128, trials=True)
    of = sl.Stored(stored)
    others = {trial.stored for trial in found.trials if trial.kind == "stored"}
    assert {one.surface for one in others} == {"front", "back", "second", "midpoint", "dual"}
    assert {one.spacing for one in others} == {"projective", "linear"}
    assert of not in others
    assert len(others) == 5 + (of.format != "f32")
    assert "f32" in {one.format for one in others}
    for trial in found.trials:
        read = {"bias": trial.bias, "filter": "bilinear", "stored": trial.stored}
        again = sl.evaluate(
            view, trial.technique, trial.resolution, metrics=["misclassified"], renderer="cpu", **read
        )  # fmt: skip
        if trial.wrong is not None:
            assert trial.wrong == again.errors.count, trial.text
            assert trial.is_right == (again.errors.image[y, x] == 0), trial.text
