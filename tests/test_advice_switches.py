"""Where the winner changes, how noise is kept out of it, and what is said of it: on tables made by hand."""

from __future__ import annotations

import itertools
import math
import random
import re
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shadowlab.aliasing.causes import CAUSES
from shadowlab.experiments.candidates import Outcome
from shadowlab.experiments.measures import LATTICE_SCATTER, MEASURES, measure_of
from shadowlab.experiments.ranking import changes, standings, stretches, switches
from shadowlab.experiments.thresholds import about_equal
from shadowlab.reports.advice_verdict import OF_BIAS, advice_sentences

MIB = 2**20


@dataclass(frozen=True)
class At:
    """What a ranking reads of a view."""

    label: str
    camera_label: str
    light_label: str
    light_angle: float
    light_elevation: float
    light: None = None
    camera: None = None


PIXELS = 100_000


def seen(label, angle, camera="camera", elevation=0.5):
    return At(label, camera, label, math.radians(angle), elevation)


def outcome(candidate, view, error, memory=MIB, **keywords):
    measure = measure_of("misclassified")
    wrong = round((error or 0.0) * PIXELS)
    numbers = {"misclassified": wrong, "share": error, "compared": PIXELS, "edge": wrong}
    variance = measure.variance(error or 0.0, PIXELS)
    given = {"maps": 1, "resolution": 512, "error": error, "variance": variance, "numbers": numbers}
    return Outcome(candidate, candidate.partition(":")[0], candidate, memory, view, **{**given, **keywords})


def table(angles, memory=MIB, **errors):
    """Outcomes of candidates with an error for each angle."""
    return [
        outcome(name, seen(f"at {angle}", angle), error, memory)
        for name, of in errors.items()
        for angle, error in zip(angles, of, strict=True)
    ]


def said(outcomes, error="misclassified", over="mean", filled=None):
    ranking = standings(outcomes, over)
    labels = {o.view.label: 1.0 for o in outcomes}
    changed = switches(outcomes, ranking)
    return " ".join(advice_sentences(ranking, changed, outcomes, measure_of(error), over, filled or labels))


def test_a_switch_lies_between_neighbours_with_both_errors():
    outcomes = table([60, 10, 35, 80], uniform=[0.04, 0.01, 0.012, 0.05], lispsm=[0.01, 0.03, 0.03, 0.01])
    (row,) = switches(outcomes, standings(outcomes, "mean"))
    assert (row["along"], row["from"], row["to"]) == ("light angle", "at 35", "at 60")
    assert (row["winner_from"], row["winner_to"]) == ("uniform", "lispsm")
    assert (row["error_from"], row["other_from"]) == (0.012, 0.03)
    assert (row["error_to"], row["other_to"]) == (0.01, 0.04)
    assert math.isclose(row["at_from"], math.radians(35))
    assert (row["equal_from"], row["equal_to"]) == (None, None)
    text = said(outcomes)
    told = (
        "The answer switches at a light angle between 35° and 60°: at 35° uniform (1.20 %; lispsm 3.00 %), at 60° lis"
    )
    assert told in text
    # No angle is told that was not measured.
    assert set(re.findall(r"\d+(?=°)", text)) == {"35", "60"}


def test_noise_switches_nothing():
    # 0.0100 and 0.0104 of 100,000 pixels are no different: the one that holds all along stays.
    outcomes = table([10, 40, 70], a=[0.0100, 0.0104, 0.0100], b=[0.0104, 0.0100, 0.0104])
    assert switches(outcomes, standings(outcomes, "mean")) == []
    text = said(outcomes)
    assert "b does about as well (within the noise)" in text
    assert "The answer does not switch between views: one candidate is best or about equal all along." in text


def test_a_real_change_is_found_through_a_tie():
    outcomes = table([10, 40, 70], a=[0.01, 0.0201, 0.05], b=[0.05, 0.0200, 0.01])
    (row,) = switches(outcomes, standings(outcomes, "mean"))
    assert (row["from"], row["to"], row["winner_from"], row["winner_to"]) == ("at 10", "at 70", "a", "b")
    assert row["equal_from"] == row["equal_to"] == math.radians(40)
    told = (
        "between 10° and 70°: at 10° a (1.00 %; b 5.00 %), at 70° b (1.00 %; a 5.00 %); at 40° both do about as well ("
    )
    assert f"{told}within the noise)." in said(outcomes)
    longer = table([10, 30, 50, 70], a=[0.01, 0.0201, 0.02, 0.05], b=[0.05, 0.0200, 0.0201, 0.01])
    assert "; from 30° to 50° both do about as well (within the noise)." in said(longer)


def test_budgets_at_which_both_winners_are_about_equal_are_told():
    outcomes = table([10], MIB, a=[0.01], b=[0.03]) + table([10], 2 * MIB, a=[0.01], b=[0.0101])
    outcomes += table([10], 4 * MIB, a=[0.01], b=[0.002])
    told = (
        "up to 1 MiB a (1.00 %; b 3.00 %), from 4 MiB on b (0.200 %; a 1.00 %); at 2 MiB both do about as well (within"
    )
    assert told in said(outcomes)


def test_budgets_switch_over_all_views():
    outcomes = table([10, 70], MIB, a=[0.01, 0.02], b=[0.03, 0.05])
    outcomes += table([10, 70], 4 * MIB, a=[0.008, 0.016], b=[0.002, 0.003])
    rows = switches(outcomes, standings(outcomes, "mean"))
    (row,) = [row for row in rows if row["along"] == "memory"]
    assert (row["from"], row["to"], row["at_from"], row["at_to"]) == ("1 MiB", "4 MiB", MIB, 4 * MIB)
    assert (row["winner_from"], row["error_from"]) == ("a", 0.015)
    assert (row["winner_to"], row["error_to"], row["other_to"]) == ("b", 0.0025, 0.012)
    assert "The answer switches with memory: up to 1 MiB a (1.50 %; b 4.00 %), from 4 MiB on b" in said(outcomes)


def test_cameras_are_rows_of_their_own():
    outcomes = []
    for camera, flip in (("front", False), ("side", True)):
        for angle, light, (first, second) in ((10, "x", (0.01, 0.05)), (70, "y", (0.05, 0.01))):
            view = At(f"{camera}, {light}", camera, light, math.radians(angle), 0.1)
            a, b = (second, first) if flip else (first, second)
            outcomes += [outcome("a", view, a), outcome("b", view, b)]
    rows = switches(outcomes, standings(outcomes, "mean"))
    assert [(r["camera"], r["winner_from"], r["winner_to"]) for r in rows] == [("front", "a", "b"), ("side", "b", "a")]
    assert "between 10° and 70° for front: at 10° a (1" in said(outcomes)


def test_a_light_that_climbs_beside_the_view_is_told_by_its_elevation():
    outcomes = []
    for up, a, b in ((10, 0.01, 0.04), (50, 0.01, 0.04), (80, 0.04, 0.01)):
        view = seen(f"up {up}", 88, elevation=math.radians(up))
        outcomes += [outcome("a", view, a), outcome("b", view, b)]
    assert "The answer switches at a light elevation between 50° and 80°: at 50° a (1.00 %; b" in said(outcomes)


errors = st.sampled_from([0.01, 0.0102, 0.013, 0.02])
points = st.lists(st.dictionaries(st.sampled_from("abc"), st.tuples(errors, st.just(0.0)), max_size=3), max_size=6)


@given(points)
@settings(max_examples=300)
def test_stretches_are_as_few_as_can_be(points):
    """Against all ways to give each point a candidate about equal to its best."""
    present = [point for point in points if point]
    found = stretches(present)
    near = [
        {name for name, (e, _) in point.items() if about_equal(e, min(e for e, _ in point.values()), 0.0)}
        for point in present
    ]
    changes = [sum(x != y for x, y in itertools.pairwise(way)) for way in itertools.product(*near)]
    assert len(found) == (1 + min(changes) if present else 0)
    # Each winner is about best all along its stretch.
    for one in found:
        for point in present[one.first : one.last + 1]:
            assert about_equal(point[one.winner][0], min(e for e, _ in point.values()), 0.0)
    # Together they leave nothing out, and none holds another.
    edges = [0, *(one.last + 1 for one in found)]
    assert all(one.first <= edge for one, edge in zip(found, edges, strict=False))
    assert edges[-1] == len(present)
    for before, after in itertools.pairwise(found):
        assert before.first < after.first
        assert before.last < after.last


@given(points, st.integers(0, 2**32), st.sampled_from([0.0, 1e-8]))
@settings(max_examples=300)
def test_mirrored_views_give_mirrored_switches(points, seed, variance):
    """What is about equal is so from either side; no two sums of errors are the same."""
    scatter = random.Random(seed)
    points = [{name: (e * (1 + 1e-3 * scatter.random()), variance) for name, (e, _) in p.items()} for p in points]
    places = [(f"at {i}", float(i)) for i in range(len(points))]
    rows = changes(points, places, {})
    turned = changes(points[::-1], places[::-1], {})[::-1]
    other = {"from": "to", "at_from": "at_to", "equal_from": "equal_to", "winner_from": "winner_to",
             "error_from": "error_to", "other_from": "other_to"}  # fmt: skip
    other |= {to: name for name, to in other.items()}
    assert [{other[name]: value for name, value in row.items()} for row in turned] == rows


def test_lights_from_the_other_side_give_the_mirrored_sentence():
    a, b = [0.01, 0.011, 0.0201, 0.05], [0.05, 0.03, 0.0200, 0.01]
    first = table([10, 30, 50, 80], a=a, b=b)
    (row,) = switches(first, standings(first, "mean"))
    second = table([170, 150, 130, 100], a=a, b=b)
    (turned,) = switches(second[::-1], standings(second[::-1], "mean"))
    assert (row["from"], row["to"]) == ("at 30", "at 80")
    assert (turned["from"], turned["to"]) == ("at 100", "at 150")
    assert math.isclose(row["equal_from"], math.pi - turned["equal_to"])
    assert (row["winner_from"], row["winner_to"]) == (turned["winner_to"], turned["winner_from"]) == ("a", "b")


def test_the_noise_is_that_of_counts_and_of_the_lattice():
    measure = measure_of("misclassified")
    few, many = measure.variance(0.01, 1000), measure.variance(0.01, 10**9)
    assert few > many > 0
    assert math.isclose(many, (LATTICE_SCATTER * 0.01) ** 2, rel_tol=1e-3)
    # Lengths have no counts behind them; the longest of all scatters most, by a factor that nothing short of ten beats.
    worst, p95 = measure_of("worst"), measure_of("p95")
    assert worst.variance(7.0, 1000) == worst.variance(7.0, 10) == (worst.scatter * 7.0) ** 2
    assert about_equal(700.0, 100.0, worst.variance(700.0, 1) + worst.variance(100.0, 1))
    assert not about_equal(1200.0, 100.0, worst.variance(1200.0, 1) + worst.variance(100.0, 1))
    assert not about_equal(1.06, 1.0, p95.variance(1.06, 1) + p95.variance(1.0, 1))
    assert all(measure.scatter > 0 for measure in MEASURES)
    assert worst.scatter == max(measure.scatter for measure in MEASURES)
    assert about_equal(0.0, 0.0, 0.0)
    assert not about_equal(0.0, 0.01, 0.0)


def test_uniform_at_the_top_says_that_nothing_is_worth_it():
    text = said(table([10, 70], uniform=[0.01, 0.01], lispsm=[0.02, 0.02]))
    assert "uniform (512²) has the least share of wrong pixels: 1.00 % on average over 2 views" in text
    assert "; the other candidate drawn does not have less by more than the noise; lispsm has 2.00 %." in text
    near = said(table([10], uniform=[0.0101], lispsm=[0.01]))
    told = (
        "lispsm (512²) has the least share of wrong pixels: 1.00 % (1,000 of 100,000 compared pixels), about as much as"
    )
    assert f"{told} uniform with 1.01 %; the other candidate drawn does not have less than that by more than" in near
    # Nothing is said of warps that were not drawn.
    assert "no warp" not in text + near


def test_the_gain_over_uniform_and_ties_with_fewer_maps():
    outcomes = [outcome("uniform", seen("x", 10), 0.04), outcome("lispsm", seen("x", 10), 0.0101)]
    outcomes.append(outcome("z_partition", seen("x", 10), 0.01, maps=4, resolution=256))
    text = said(outcomes)
    told = "z_partition (4 × 256²) has the least share of wrong pixels: 1.00 % (1,000 of 100,000 compared pixels), "
    assert f"{told}4 times less than uniform in as much memory (4.00 %)." in text
    assert "lispsm does about as well (within the noise); lispsm needs only 1 map." in text
    best, second, third = standings(outcomes, "mean")
    assert (best.about_best, second.about_best, third.about_best) == (True, True, False)
    assert (third.ratio_to_best, third.ratio_to_uniform, best.ratio_to_uniform) == (4.0, 1.0, 0.25)


def test_a_slight_gain_is_told_as_a_share():
    text = said(table([10], uniform=[0.2], lispsm=[0.17]))
    assert "compared pixels), 15.0 % less than uniform in as much memory (20.0 %)." in text


def test_a_warning_where_no_candidate_is_good():
    text = said(table([10], uniform=[0.3], lispsm=[0.2]))
    assert "No candidate drawn is good here: even the best has 20.0 % at 1 MiB, and from 5.00 % on" in text
    assert "No candidate drawn is good" not in said(table([10], uniform=[0.3], lispsm=[0.02]))
    long = said(table([10], uniform=[30.0], lispsm=[4.0]), error="p95")
    assert "even the best has 4 px" in long
    assert "It would take about 4 times the memory." in long


@pytest.mark.parametrize("name", [measure.name for measure in MEASURES])
def test_memory_is_foretold_only_where_lengths_go_with_the_sides(name):
    text = said(table([10], uniform=[3e5], lispsm=[2e5]), error=name)
    assert ("times the memory" in text) == (name in ("p95", "perspective"))


def test_of_the_longest_texel_nothing_is_told_but_the_number():
    outcomes = table([10, 70], uniform=[3e5, 2e4], lispsm=[2e4, 3e5], tsm=[9e6, 9e6])
    assert said(outcomes, error="worst") == (
        "At 1 MiB, lispsm (512²) has the least longest texel: 160,000 px on average over 2 views (300,000 px at worst: "
        "at 70). One pixel decides this length, most often of a surface that the light grazes: p95 is the measure to "
        "choose by. Drawn: lispsm, tsm and uniform."
    )
    doc = measure_of("worst").doc
    assert "one pixel decides it, use p95" in doc


def test_views_that_hardly_test_shadows_and_causes_of_bias():
    text = said(table([10], uniform=[0.00002], lispsm=[0.0]))
    assert "These views hardly test shadows: no run has 10 wrong pixels or more." in text
    assert "switch" not in text
    numbers = {"misclassified": 1000, "share": 0.01, "compared": PIXELS, "acne": 900, "edge": 100}
    acne = [outcome("lispsm", seen("x", 10), 0.01, numbers=numbers)]
    told = "90.0 % of the 1,000 wrong pixels of lispsm at 1 MiB are surfaces that shadow themselves; more bias trades"
    assert told in said(acne)
    leak = [outcome("lispsm", seen("x", 10), 0.01, numbers={**numbers, "acne": 0, "leak": 600, "other": 300})]
    told = (
        "60.0 % of the 1,000 wrong pixels of lispsm at 1 MiB are light that its bias lets through (without the bias "
        "they would be dark); less bias trades them for acne."
    )
    assert told in said(leak)
    other = [outcome("lispsm", seen("x", 10), 0.01, numbers={**numbers, "acne": 100, "other": 800})]
    assert "bias" not in said(other)
    assert "more texels" not in said(leak) + said(acne)
    # Nothing is told of a cause that does not exist.
    assert set(OF_BIAS) < set(CAUSES.values())


def test_zeros_have_no_ratio_and_infinity_is_said():
    ranking = standings(table([10], uniform=[0.01], lispsm=[0.0]), "mean")
    assert [s.ratio_to_best for s in ranking] == [1.0, math.inf]
    assert "where uniform has 1.00 % in as much memory" in said(table([10], uniform=[0.01], lispsm=[0.0]))


def test_little_seen_and_pixels_outside_are_told():
    outcomes = table([10], uniform=[0.01], lispsm=[0.02])
    assert "The view at 10 has less than 5.00 % of the pixels filled: move closer." in said(
        outcomes, filled={"at 10": 0.01}
    )
    numbers = {"misclassified": 1000, "share": 0.01, "compared": PIXELS, "outside": 99, "outside_shadow": 77}
    lost = [outcome("mine", seen("x", 10), 0.01, numbers=numbers)]
    assert "mine leaves up to 77 pixels in shadow of a view outside of its maps" in said(lost)


def test_failures_for_one_reason_are_told_together_and_with_their_budget():
    view = seen("x", 10)
    outcomes = [outcome("uniform", view, 0.01), outcome("uniform", view, 0.005, 4 * MIB)]
    for name in ("b", "a"):
        outcomes.append(outcome(name, view, None, MIB, variance=0.0, numbers={}, failure="too small."))
        outcomes.append(outcome(name, view, 0.01, 4 * MIB))
    assert "a and b failed at 1 MiB: too small." in said(outcomes)


@pytest.mark.parametrize("over", ["mean", "worst"])
def test_over_decides_who_wins(over):
    outcomes = table([10, 70], a=[0.01, 0.05], b=[0.035, 0.035])
    best = standings(outcomes, over)[0]
    assert (best.candidate, best.worst_view) == (("a", "at 70") if over == "mean" else ("b", "at 10"))
    assert (best.mean, best.worst) == pytest.approx((0.03, 0.05) if over == "mean" else (0.035, 0.035))


def test_a_switch_with_every_budget_is_told_once():
    outcomes = table([10, 70], MIB, a=[0.01, 0.04], b=[0.04, 0.01])
    outcomes += table([10, 70], 4 * MIB, a=[0.005, 0.02], b=[0.02, 0.005])
    assert len(switches(outcomes, standings(outcomes, "mean"))) == 2
    text = said(outcomes)
    told = "With every budget the answer switches at a light angle between 10° and 70°: at 10° a (0.500 % in 4 MiB; b"
    assert told in text
    assert text.count("switches") == 1


def test_one_candidate_alone_is_not_compared():
    assert "worth" not in said(table([10], uniform=[0.01]))
    assert "uniform (512²) has this share of wrong pixels: 1.00 % (1,000 of 100,000 compared pixels)." in said(
        table([10], uniform=[0.01])
    )


def test_memory_that_maps_cannot_use_is_told():
    largest = outcome("uniform", seen("x", 10), 0.01, 2**31, resolution=16384)
    assert "uniform cannot use all the memory: its map is the largest, 16384²." in said([largest])
