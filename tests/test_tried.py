"""What an advice tries, what it leaves untried and why, and what it says of uniform and of what was drawn."""

from __future__ import annotations

import math

import pytest
from advice_support import SETS, SIZE, advise, made_view

import shadowlab as sl
from shadowlab.errors import ArgumentError
from shadowlab.experiments.candidates import Outcome
from shadowlab.experiments.choice import gains
from shadowlab.experiments.counts import WrongPixels
from shadowlab.experiments.memory import DEFAULT_MEMORY, bytes_of
from shadowlab.experiments.noise import outcomes_to_decide
from shadowlab.experiments.phases import PHASES
from shadowlab.experiments.ranking import standings
from shadowlab.experiments.tried import SETTINGS, TWINS, Untried, default_techniques, untried_of
from shadowlab.reports.advice_remarks import tried_sentences

PIXELS = 100_000


@pytest.fixture(scope="module")
def view():
    return made_view()


def names():
    return list(dict.fromkeys(sl.techniques()["name"]))


def serving(kind):
    table = sl.techniques().drop_duplicates("name")
    return {row["name"] for row in table.to_dict("records") if kind in row["lights"].split(", ")}


# ---- candidates


@pytest.mark.parametrize("kind", ["directional", "spot", "point"])
def test_every_technique_that_serves_the_light_is_tried_and_none_twice(kind):
    found = default_techniques([kind])
    made = [sl.technique(text) for text in found]
    assert {one.name for one in made} == serving(kind) - set(TWINS)
    assert len({(one.name, repr(sorted(one.settings.items(), key=str))) for one in made}) == len(made)
    assert set(SETTINGS) <= set(names())


def test_settings_that_matter_begin_with_the_defaults_and_splits_have_every_count():
    for name, texts in SETTINGS.items():
        if name != "z_partition":
            assert texts[0] == name
    splits = [sl.technique(text).settings for text in SETTINGS["z_partition"]]
    assert {one["count"] for one in splits} == {2, 3, 4}


def test_several_kinds_of_light_leave_what_serves_all():
    both = {sl.technique(text).name for text in default_techniques(["directional", "point"])}
    assert both == (serving("directional") & serving("point")) - set(TWINS)


def test_what_is_not_tried_has_its_cause():
    found = {one.technique: one for one in untried_of(["uniform", "lispsm"], ["point"])}
    assert found.keys() == set(names()) - {"uniform", "lispsm"}
    for name, one in found.items():
        assert one == (Untried(name, "not_asked") if name in serving("point") else Untried(name, "light", ("point",)))


def test_a_technique_that_makes_the_map_of_another_is_named_and_not_drawn():
    found = {one.technique: one for one in untried_of(["log_psm", "uniform"], ["directional"])}
    assert found["log"] == Untried("log", "same", twin="log_psm")
    assert "log (the map of log_psm)" in tried_sentences([], list(found.values()))[-1]
    # Named alone it is drawn, and where the other was not asked for neither was it.
    assert "log" not in {one.technique for one in untried_of(["log"], ["directional"])}
    assert {one.technique: one for one in untried_of(["uniform"], ["directional"])}["log"] == Untried(
        "log", "not_asked"
    )


@pytest.mark.parametrize(("name", "twin"), TWINS.items())
def test_twins_have_the_same_map(name, twin):
    scene = sl.library.scene("robots")
    one, other = (sl.technique(t).parameterize(scene, scene.camera, scene.light, resolution=512) for t in (name, twin))
    assert (one.matrix == other.matrix).all()
    assert one.partitions[0].post_warp_terms == other.partitions[0].post_warp_terms


def test_an_advice_needs_no_budget(view):
    scene, camera, lights = view
    found = sl.advise(scene, camera, lights["noon"], techniques=SETS[:2], size=SIZE, renderer="cpu", progress=False)
    assert found.budgets == (bytes_of(DEFAULT_MEMORY),) == (4 * 1024**2,)
    assert found.table.set_index("technique").loc["uniform", "resolution"] == 1024
    assert {one.technique for one in found.untried} == set(names()) - {"uniform", "lispsm"}
    assert all(one.cause == "not_asked" for one in found.untried)
    for one in found.untried:
        assert one.technique in found.sentences[-1]


# ---- what warps gain over uniform, by fields


def made(candidate, count, sd=None, memory=2**20):
    """An outcome in the one view there is."""
    from types import SimpleNamespace

    numbers = {"misclassified": count, "compared": PIXELS, "share": count / PIXELS}
    if sd is not None:
        numbers |= {"phases": PHASES, "misclassified_mean": float(count), "misclassified_sd": sd}
    wrong = WrongPixels.of(numbers)
    return Outcome(
        candidate, candidate.partition(":")[0], candidate, memory, SimpleNamespace(label="x", light=None), 1, 512,
        wrong.share, wrong.variance / PIXELS**2, None if sd is None else sd / PIXELS, numbers,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("warp", "sd", "relation"),
    [(900, 20.0, "fewer"), (900, 80.0, "about_equal"), (1100, 80.0, "about_equal"), (1100, 20.0, "more"),
     (960, 1.0, "about_equal"), (500, None, "fewer")],
)  # fmt: skip
def test_a_gain_is_held_against_its_noise(warp, sd, relation):
    ranking = standings([made("uniform", 1000, sd), made("lispsm", warp, sd), made("tsm", 3000)], "mean")
    (gain,) = gains(ranking)
    assert (gain.best.candidate, gain.baseline.candidate, gain.drawn) == ("lispsm", "uniform", ("lispsm", "tsm"))
    assert gain.relation == relation
    best, second = ranking[:2]
    assert second.about_best == (relation == "about_equal")
    assert (best.sd is None) == (sd is None)


def test_there_is_no_gain_without_uniform_or_without_others():
    assert gains(standings([made("lispsm", 10), made("tsm", 10)], "mean")) == []
    assert gains(standings([made("uniform", 10)], "mean")) == []


def test_the_noise_of_a_mean_over_views_is_that_of_its_parts(view):
    found = advise(view, memory="16 KiB")
    for row in found.table.to_dict("records"):
        runs = found.runs.query("technique == @row['technique']")
        if runs["phases"].notna().all():
            assert math.isclose(row["error_sd"], math.hypot(*runs["error_sd"]) / len(runs))
        else:
            assert math.isnan(row["error_sd"])
    measured = set(found.runs[found.runs["phases"].notna()]["technique"])
    assert {"uniform", found.best.candidate} <= measured
    assert (found.runs["phases"].dropna() == PHASES).all()
    plain = advise(view, memory="16 KiB", phases=1)
    assert plain.runs["phases"].isna().all()
    assert plain.runs["error"].tolist() == plain.runs["share"].tolist()
    assert advise(view, memory="16 KiB", error="p95").runs["phases"].isna().all()


def test_only_what_has_to_be_decided_is_counted_again():
    outcomes = [made(name, n) for name, n in (("uniform", 9000), ("a", 1000), ("b", 1400), ("c", 3000))]
    assert outcomes_to_decide(outcomes, "mean") == {(2**20, name) for name in ("uniform", "a", "b")}
    assert outcomes_to_decide([made("uniform", 3), made("a", 2)], "mean") == set()
    # Each budget for itself.
    more = [made("uniform", 500, memory=2**22), made("c", 510, memory=2**22), made("b", 5000, memory=2**22)]
    found = outcomes_to_decide(outcomes + more, "mean")
    assert {name for memory, name in found if memory == 2**22} == {"uniform", "c"}


def test_an_advice_over_less_than_all_pixels_says_so_first():
    from shadowlab.experiments.measures import measure_of
    from shadowlab.reports.advice_verdict import advice_sentences

    def first(undecided):
        outcomes = [made("uniform", 900), made("a", 300)]
        for one in outcomes:
            one.numbers["undecided"] = undecided
        return advice_sentences(standings(outcomes, "mean"), [], outcomes, measure_of("misclassified"), "mean", {})[0]

    assert "undecided" not in first(900)
    assert first(3000) == "Only 97.1 % of the visible pixels could be judged; 2.91 % are undecided or not compared."


# ---- predictions


def test_only_the_first_of_a_prediction_are_drawn_and_uniform(view):
    asked = []

    def predict(view, technique, *, resolution):
        asked.append((view.label, technique.name, resolution))
        return {"lispsm": 10.0, "z_partition": 20.0}.get(technique.name, 5.0) + technique.settings.get("count", 0)

    found = advise(view, memory="16 KiB", predict=predict, drawn=1)
    assert set(found.table["technique"]) == {"uniform", "lispsm"}
    left = {one.technique: one for one in found.untried if one.cause == "predicted"}
    # Over two views.
    assert {name: (one.predicted, one.memory) for name, one in left.items()} == {
        SETS[2]: (44.0, 2**14), SETS[3]: (46.0, 2**14),
    }  # fmt: skip
    assert len(asked) == 2 * 3
    assert all(one.resolution == side for one in found.outcomes for _, name, side in asked if name == one.technique)
    assert found.gains[0].drawn == ("lispsm",)
    for name in left:
        assert name in found.sentences[-1]
    # What was drawn has the numbers that it has without a prediction.
    plain = advise(view, memory="16 KiB", techniques=SETS[:2])
    assert found.table["error_mean"].tolist() == plain.table["error_mean"].tolist()
    assert found.figure()


def test_predictions_are_for_the_bias_of_the_advice(view):
    scene, camera, lights = view
    bias = sl.Bias(world=2.0)
    found = advise(view, techniques=None, memory="16 KiB", bias=bias, drawn=1)
    left = {one.technique: one.predicted for one in found.untried if one.cause == "predicted"}
    views = [sl.View(scene, camera, light, size=found.views[0].view.size) for light in lights.values()]
    # One map of 16 KiB has 64 x 64 texels. The board's shadow goes with a bias above its height.
    for name in [name for name in ("gmnpr", "tsm", "psm") if name in left]:
        with_it, without = (
            sum(float(sl.predict(one, name, 64, bias=given, renderer="cpu")) for one in views) for given in (bias, None)
        )
        assert left[name] == pytest.approx(with_it)
        assert with_it > 1.5 * without
    assert {"gmnpr", "tsm", "psm"} & set(left)


def test_what_cannot_be_predicted_is_drawn(view):
    def predict(view, technique, *, resolution):
        if technique.name == "lispsm":
            raise sl.errors.UnsupportedError("not this one")
        return 1.0

    found = advise(view, memory="16 KiB", predict=predict, drawn=1)
    assert set(found.table["technique"]) == {"uniform", "lispsm", SETS[2]}


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"predict": 3}, "predict: expected a function"),
        ({"drawn": 0}, "drawn: expected a whole number above 0"),
        ({"drawn": 2.5}, "drawn: expected a whole number above 0"),
        ({"phases": 0}, "phases: expected a whole number of shifts"),
    ],
)
def test_wrong_arguments_are_refused(view, keywords, message):
    with pytest.raises(ArgumentError, match=message):
        advise(view, **keywords)
