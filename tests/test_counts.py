"""Wrong pixels with their noise: what is about equal, whose noise is measured, and what a study says of it."""

from __future__ import annotations

import math

import pytest

import shadowlab as sl
from shadowlab.experiments.counts import Comparison, WrongPixels, against_uniform, relation, to_decide
from shadowlab.experiments.phases import PHASES
from shadowlab.experiments.thresholds import ABOUT_EQUAL, CLOSE, LATTICE_SCATTER, UNJUDGED
from shadowlab.reports.study_verdict import sentences

SIZE = (160, 90)


def row(technique, count, resolution=512, **more):
    """A row of a study's table."""
    return {
        "technique": technique, "resolution": resolution, "misclassified": count, "share": count / 100_000,
        "compared": 100_000, "undecided": 0, "unmatched": 0, "false_shadow": count, "false_light": 0, "maps": 1,
        "failure": "", **more,
    }  # fmt: skip


def measured(mean, sd, phases=PHASES):
    return WrongPixels(mean, 100_000, sd, phases)


def test_a_row_gives_the_mean_where_it_was_measured():
    plain = WrongPixels.of(row("a", 400, undecided=60, unmatched=40))
    assert (plain.count, plain.sd, plain.phases, plain.share) == (400.0, None, 1, 0.004)
    assert plain.unjudged == pytest.approx(100 / 100_100)
    assert plain.variance == 400 + (LATTICE_SCATTER * 400) ** 2
    shifted = WrongPixels.of(row("a", 400, phases=8, misclassified_mean=410.5, misclassified_sd=12.0))
    assert (shifted.count, shifted.sd, shifted.phases) == (410.5, 12.0, 8)
    assert shifted.variance == 144 / 8
    assert WrongPixels.of({}).share == 0.0


def test_what_is_about_equal_is_so_by_the_measured_noise():
    """Three standard errors of the difference of the means: 1.06 standard deviations of a difference of two counts."""
    for difference, found in ((140, "about_equal"), (160, "fewer")):
        assert relation(measured(1000, 100), measured(1000 + difference, 100)) == found
        assert relation(measured(1000 + difference, 100), measured(1000, 100)) == (
            "more" if found == "fewer" else found
        )
    assert 1.0 < 150 / math.hypot(100, 100) < 1.1
    # More shifts decide more, and one part in twenty decides nothing.
    assert relation(measured(1000, 100, 64), measured(1140, 100, 64)) == "fewer"
    assert relation(measured(1000, 0.1), measured(1000 * ABOUT_EQUAL, 0.1)) == "about_equal"
    assert relation(measured(0, 0.0), measured(0, 0.0)) == "about_equal"


def test_warps_are_compared_at_equal_texels_with_the_best_uniform_map():
    rows = [row("loose", 900), row("tight", 700), row("warp", 500), row("split", 100, maps=2), row("other", 50, 256)]
    techniques = {"loose": "uniform", "tight": "uniform"}
    (pair,) = against_uniform(rows, techniques)["warp"]
    assert pair == Comparison("warp", "tight", 512, WrongPixels.of(rows[2]), WrongPixels.of(rows[1]))
    assert (pair.relation, pair.ratio) == ("fewer", 5 / 7)
    assert against_uniform(rows, techniques).keys() == {"warp"}
    assert against_uniform([row("uniform", 0), row("warp", 3)], {})["warp"][0].ratio is None


def test_only_rows_between_which_a_verdict_decides_are_measured():
    assert to_decide([row("uniform", 4000), row("warp", 1000)], {}) == []
    near = round(1000 * CLOSE) - 1
    assert to_decide([row("uniform", near), row("warp", 1000), row("far", 9000)], {}) == [0, 1]
    # The best of all against everybody close, uniform or not.
    assert to_decide([row("uniform", 4000), row("warp", 1000), row("other", near)], {}) == [1, 2]
    # Of the best warp each resolution, and uniform with more texels; no other pair.
    rows = [
        row("uniform", 4000, 256), row("warp", 3900, 256), row("far", 4100, 256), row("uniform", 3000),
        row("warp", 900),
    ]  # fmt: skip
    assert to_decide(rows, {}) == [0, 1, 3]
    assert to_decide([row("uniform", 3), row("warp", 2)], {}) == []


def verdict(*rows):
    import pandas as pd

    return " ".join(sentences(pd.DataFrame(list(rows))))


def test_a_difference_within_the_measured_noise_is_told_as_none_and_one_beyond_it_is_told():
    def noisy(technique, mean, sd):
        return row(technique, mean, phases=8, misclassified_mean=float(mean), misclassified_sd=float(sd))

    equal = verdict(noisy("uniform", 1100, 100), noisy("warp", 1000, 100))
    assert (
        "warp at 512² has the fewest wrong pixels: 1,000 ± 100 pixels (1.00 % of 100,000 compared; as fitted" in equal
    )
    assert "About as few have uniform at 512², 1,100 ± 100 (1.10 %)" in equal
    assert "makes little difference" in equal
    assert "over 8 shifts of the texels" in equal
    clear = verdict(noisy("uniform", 1100, 20), noisy("warp", 1000, 20))
    assert "slightly better" in clear
    assert "About as few" not in clear
    assert "±" not in verdict(row("uniform", 1100), row("warp", 300))


def test_a_verdict_over_less_than_all_pixels_says_so_first():
    few = row("uniform", 500, undecided=round(100_000 * UNJUDGED) - 1)
    assert "undecided" not in verdict(few, row("warp", 300))
    many = verdict(row("uniform", 500), row("warp", 300, undecided=1500, unmatched=500))
    first = "Only 98.0 % of the visible pixels could be judged; 1.96 % are undecided or not compared."
    assert many.startswith(f"{first} warp at 512² has the fewest wrong pixels")
    right = verdict(row("warp", 0, undecided=4000))
    assert right.startswith("Only 96.2 % of the visible pixels could be judged; 3.85 % are undecided or not compared.")
    # Where nothing at all could be judged, that is the sentence.
    none = verdict(row("warp", 0, compared=0, undecided=4000))
    assert none == "No pixel could be compared: the truth of all 4,000 visible pixels is undecided."


@pytest.fixture(scope="module")
def study():
    scene = sl.library.scene("robots")
    names = ["uniform", "lispsm", "tsm", "glpr"]
    return sl.compare(
        scene, scene.camera, scene.light, names, resolution=256, size=SIZE, renderer="cpu", progress=False
    )


def test_a_study_measures_noise_where_its_verdict_needs_it(study):
    rows = [run.row() for run in study.runs]
    plain = [{**one, "phases": None, "misclassified_mean": None, "misclassified_sd": None} for one in rows]
    chosen = to_decide(plain, {})
    assert 2 <= len(chosen) < len(rows)
    assert [i for i, one in enumerate(rows) if one["phases"]] == chosen
    for i in chosen:
        assert rows[i]["phases"] == PHASES
        again = sl.evaluate(
            study.view, rows[i]["technique"], 256, metrics=["misclassified"], renderer="cpu", phases=PHASES
        )
        assert again.numbers["misclassified_mean"] == rows[i]["misclassified_mean"]
        assert again.numbers["misclassified_sd"] == rows[i]["misclassified_sd"]


def test_a_study_says_in_fields_what_its_verdict_says(study):
    wrong = {run.label: WrongPixels.of(run.numbers) for run in study.runs}
    best = min(wrong, key=lambda label: wrong[label].count)
    assert study.best[0].label == best
    near = {label for label in wrong if relation(wrong[label], wrong[best]) == "about_equal"}
    assert {run.label for run in study.best} == near
    assert {one.technique for one in study.comparisons} == {"lispsm", "tsm", "glpr"}
    for one in study.comparisons:
        assert (one.baseline, one.mine, one.other) == ("uniform", wrong[one.technique], wrong["uniform"])
    assert study.unjudged == max(one.unjudged for one in wrong.values())


def test_without_phases_or_truth_nothing_is_shifted(study):
    view = (study.scene, study.camera, study.light, ["uniform", "lispsm"])
    how = {"resolution": 64, "size": (32, 18), "renderer": "cpu", "progress": False}
    plain = sl.compare(*view, **how, phases=1)
    assert plain.table["phases"].isna().all()
    untold = sl.compare(*view, **how, truth=False)
    assert untold.best == untold.comparisons == ()
    assert untold.unjudged == 0.0
    with pytest.raises(sl.errors.ArgumentError, match="phases"):
        sl.compare(*view, **how, phases=0)
