"""The verdict says what the table shows, and nothing more: each sentence against a table made for it."""

from __future__ import annotations

import re

import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.reports.study_verdict import Remarks, sentences
from shadowlab.reports.words import factor, times, unwarped_maps
from shadowlab.text import share_text

WHY = "the light runs along the view"
NO_WARP = sl.Note("no_warp", ["light_along_axis"])
OTHER = sl.Note("cover_unused")


def verdict(*given, **known):
    return " ".join(sentences(*given, **known))


def noted(*notes_of_rows):
    """Remarks of rows with these notes."""
    return [Remarks(notes) for notes in notes_of_rows]


def table(*rows):
    """A study's table from (technique, resolution, false_shadow, false_light), or with a failure as the fifth."""
    compared = 100_000
    made = []
    for name, resolution, shadow, light, *failure in rows:
        known = not failure and shadow is not None
        made.append(
            {
                "technique": name,
                "resolution": resolution,
                "misclassified": shadow + light if known else None,
                "false_shadow": shadow if known else None,
                "false_light": light if known else None,
                "share": (shadow + light) / compared if known else None,
                "compared": compared if known else None,
                "undecided": 0 if known else None,
                "notes": "",
                "failure": failure[0] if failure else "",
            }
        )
    counts = dict.fromkeys(
        ("resolution", "misclassified", "false_shadow", "false_light", "compared", "undecided"), "Int64"
    )
    return pd.DataFrame(made).astype(counts)


def test_the_note_of_a_technique_without_warp_is_the_one_the_verdict_looks_for():
    scene = sl.library.scene("robots")
    along = sl.DirectionalLight(scene.camera.forward)
    assert sl.technique("lispsm").parameterize(scene, scene.camera, along).notes == (NO_WARP,)


def test_the_texts_in_the_table_are_not_read():
    rows = table(("uniform", 512, 300, 100), ("lispsm", 512, 100, 0))
    plain = verdict(rows)
    rows["notes"] = [str(sl.Note("check_matrix", ["nothing_in_map"])), str(NO_WARP)]
    assert verdict(rows) == plain
    with pytest.raises(ValueError, match="argument"):
        verdict(rows, remarks=noted(()))


def test_the_warp_that_pays():
    text = verdict(table(("uniform", 1024, 3000, 1000), ("lispsm", 1024, 900, 100)))
    assert "lispsm at 1024² has the fewest wrong pixels: 1,000 pixels (1.00 % of 100,000 compared" in text
    assert "900 false shadow, 100 false light" in text
    counts = "1,000 (1.00 %) against 4,000 (4.00 %)."
    assert f"lispsm is worth it here: at 1024² it leaves 4 times fewer wrong pixels than uniform, {counts}" in text


def test_the_warp_that_costs():
    text = verdict(table(("uniform", 1024, 500, 500), ("lispsm", 1024, 1000, 500)))
    assert "uniform at 1024² has the fewest" in text
    counts = "1,500 (1.50 %) against 1,000 (1.00 %)."
    assert f"not worth it here: at 1024² it has 1.5 times as many wrong pixels as uniform, {counts}" in text


def test_small_differences_decide_nothing():
    text = verdict(table(("uniform", 1024, 500, 500), ("lispsm", 1024, 500, 480)))
    assert "makes little difference" in text
    assert "worth it" not in text


def test_the_uniform_map_that_does_as_well():
    rows = [
        ("uniform", 1024, 4000, 0),
        ("uniform", 2048, 2000, 0),
        ("uniform", 4096, 900, 0),
        ("lispsm", 1024, 1000, 0),
    ]
    text = verdict(table(*rows))
    told = "Of the sizes run, uniform first does as well at 4096² as lispsm at 1024², with 16 times the texels: "
    assert f"{told}900 wrong pixels (0.900 %) against 1,000 (1.00 %)." in text


def test_no_uniform_map_of_the_run_does_as_well():
    text = verdict(table(("uniform", 1024, 4000, 0), ("uniform", 2048, 2000, 0), ("lispsm", 1024, 1000, 0)))
    told = "2,000 wrong pixels (2.00 %) against 1,000 (1.00 %)."
    assert f"No uniform map of this run, up to 2048², does as well as lispsm at 1024²: {told}" in text


def test_several_resolutions_give_a_range():
    rows = [("uniform", 512, 4000, 0), ("uniform", 1024, 2000, 0), ("lispsm", 512, 2000, 0), ("lispsm", 1024, 500, 0)]
    assert "better than uniform at every resolution from 512² to 1024²: 2 to 4 times fewer" in verdict(table(*rows))
    mixed = [("uniform", 512, 4000, 0), ("uniform", 1024, 500, 0), ("lispsm", 512, 2000, 0), ("lispsm", 1024, 900, 0)]
    text = verdict(table(*mixed))
    assert "better at 1, worse at 1 and about equal at 0 of 2 resolutions: 2,000 (2.00 %) against 4,000" in text
    worse = [("uniform", 512, 100, 0), ("uniform", 1024, 100, 0), ("lispsm", 512, 300, 0), ("lispsm", 1024, 200, 0)]
    assert "worse than uniform at every resolution from 512² to 1024²: 2 to 3 times as many" in verdict(table(*worse))


def test_no_ratio_against_nothing():
    assert "has 70 wrong pixels (0.0700 %) where uniform has none" in verdict(
        table(("uniform", 64, 0, 0), ("lispsm", 64, 70, 0))
    )
    assert "leaves no wrong pixel where uniform has 70 wrong pixels (0.0700 %)." in verdict(
        table(("uniform", 64, 70, 0), ("lispsm", 64, 0, 0))
    )
    both = verdict(table(("uniform", 64, 0, 0), ("lispsm", 64, 0, 0)))
    assert "uniform and lispsm at 64² get all 100,000 compared pixels right" in both
    assert "worth" not in both


def test_one_row_alone_is_not_compared():
    assert verdict(table(("lispsm", 1024, 100, 1))) == (
        "lispsm at 1024² gets 101 pixels wrong (0.101 % of 100,000 compared; 100 false shadow, 1 false light)."
    )
    hardly = "This view hardly tests shadows: no run has 10 wrong pixels or more."
    assert verdict(table(("lispsm", 1024, 1, 0))) == (
        f"lispsm at 1024² gets 1 pixel wrong (0.00100 % of 100,000 compared; 1 false shadow, 0 false light). {hardly}"
    )
    assert verdict(table(("lispsm", 1024, 0, 0))) == f"lispsm at 1024² gets all 100,000 compared pixels right. {hardly}"


def test_a_view_that_hardly_tests_shadows_ranks_no_warp():
    text = verdict(table(("uniform", 512, 9, 0), ("lispsm", 512, 0, 0)))
    assert "hardly tests shadows" in text
    assert "worth" not in text
    # One run of ten wrong pixels, or a large share of few pixels, is something.
    assert "hardly" not in verdict(table(("uniform", 512, 10, 0), ("lispsm", 512, 0, 0)))
    few = table(("uniform", 512, 9, 0), ("lispsm", 512, 0, 0))
    few["compared"], few["share"] = pd.array([90, 90], dtype="Int64"), [0.1, 0.0]
    assert "hardly" not in verdict(few)


def test_differences_within_the_noise_of_counts_decide_nothing():
    # sqrt(100 + 135) is 15.3: a difference of 35 is 2.3 of it, one of 60 is 3.7 of sqrt(260).
    noisy = verdict(table(("uniform", 512, 135, 0), ("lispsm", 512, 100, 0)))
    assert "makes little difference" in noisy
    assert "1.6 times fewer" in verdict(table(("uniform", 512, 160, 0), ("lispsm", 512, 100, 0)))
    as_well = [("uniform", 512, 400, 0), ("uniform", 1024, 110, 0), ("lispsm", 512, 100, 0)]
    assert "uniform first does as well at 1024² as lispsm at 512²" in verdict(table(*as_well))


def test_a_tie_tells_only_what_holds_for_all():
    text = verdict(table(("uniform", 512, 30, 10), ("lispsm", 512, 10, 30)))
    assert "uniform and lispsm at 512² share the fewest wrong pixels: 40 pixels (0.0400 % of 100,000 compared)." in text
    same = verdict(table(("uniform", 512, 30, 10), ("lispsm", 512, 30, 10)))
    assert "compared; 30 false shadow, 10 false light)" in same


def test_a_matrix_that_is_no_map_is_left_out_of_the_ranking():
    rows = table(("uniform", 512, 300, 100), ("engine", 512, 1, 0))
    doubt = sl.Note("check_matrix", ["depth_falls_away", "nothing_in_map"])
    text = verdict(rows, remarks=noted((OTHER,), (OTHER, doubt)))
    assert text.startswith("uniform at 512² gets 400 pixels wrong")
    left_out = "engine is left out of the ranking: depth falls away from the light: reversed z?; no visible surface"
    assert text.endswith(f"{left_out} lies in the map.")
    assert "worth" not in text
    assert verdict(rows[1:], remarks=noted((doubt,))) == f"Nothing is ranked. {left_out} lies in the map."


def test_a_picture_of_almost_nothing_is_told():
    rows = table(("uniform", 512, 300, 100))
    assert "Only 3.00 % of the picture's pixels show anything" in verdict(rows, seen=0.03)
    assert "show anything" not in verdict(rows, seen=0.05)


def test_without_uniform_no_word_about_worth():
    assert "worth" not in verdict(table(("lispsm", 1024, 10, 0), ("tsm", 1024, 100, 0)))


def test_the_baseline_is_known_under_any_label():
    rows = table(("plain", 1024, 4000, 0), ("sun", 1024, 1000, 0))
    text = verdict(rows, {"plain": "uniform", "sun": "lispsm"})
    assert "sun is worth it here: at 1024² it leaves 4 times fewer wrong pixels than plain" in text


def test_the_best_uniform_map_is_the_baseline():
    rows = table(("loose", 1024, 4000, 0), ("tight", 1024, 1500, 0), ("lispsm", 1024, 1000, 0))
    assert "1.5 times fewer wrong pixels than tight" in verdict(rows, {"loose": "uniform", "tight": "uniform"})


def test_failures_are_told_and_leave_the_rest():
    text = verdict(table(("uniform", 1024, 50, 0), ("lispsm", 1024, None, None, "no receiver in view")))
    assert text.endswith("lispsm failed: no receiver in view.")
    assert text.startswith("uniform at 1024² gets 50 pixels wrong")
    assert (
        verdict(table(("lispsm", 1024, None, None, "broken"))) == "No technique gave a result. lispsm failed: broken."
    )


def test_without_truth_nothing_is_claimed():
    text = verdict(table(("uniform", 1024, None, None), ("lispsm", 1024, None, None)))
    assert text == "The truth was not traced, so nothing is said about errors."


def test_nothing_to_compare():
    rows = table(("uniform", 1024, 0, 0))
    rows["compared"] = pd.array([0], dtype="Int64")
    assert verdict(rows) == "No pixel could be compared: the camera sees nothing of the scene."
    rows["undecided"] = 7
    assert verdict(rows) == "No pixel could be compared: the truth of all 7 visible pixels is undecided."


def test_a_technique_that_did_not_warp_is_told_and_not_compared():
    rows = table(("uniform", 512, 30, 10), ("lispsm", 512, 30, 10))
    text = verdict(rows, remarks=noted((), (NO_WARP,)))
    assert text.startswith("uniform at 512² gets 40 pixels wrong")
    assert text.endswith(f"lispsm does not warp here ({WHY}): its map is a uniform one.")
    assert "worth it" not in text
    assert "difference" not in text


def test_a_uniform_map_that_fits_closer_is_named_before_uniform():
    rows = table(("uniform", 512, 300, 100), ("lispsm", 512, 150, 50), ("tsm", 512, 300, 100))
    text = verdict(rows, remarks=noted((), (NO_WARP,), (NO_WARP,)))
    assert text.startswith("lispsm at 512² has the fewest wrong pixels: 200 pixels")
    assert "worth it" not in text
    assert text.count("does not warp here") == 2


@pytest.mark.parametrize("counts", [(4000, 1000), (70, 70), (0, 12), (12, 0), (100, 97)])
def test_every_number_comes_from_the_table(counts):
    rows = table(("uniform", 512, counts[0], 0), ("lispsm", 512, counts[1], 0))
    numbers = {
        int(n.replace(",", ""))
        for n in re.findall(r"\b\d[\d,]*(?= against| wrong| pixels| false| \(|\))", verdict(rows))
    }
    assert numbers <= {*counts, 0, 100_000}


def test_shares_are_never_rounded_to_nothing():
    assert share_text(0.0) == "0 %"
    assert share_text(1e-7) == "1.00e-05 %"
    assert share_text(0.99999) == "100 %"
    assert (times(1.04), times(2.0), times(9.94), times(123.4)) == ("1", "2", "9.9", "123")


def test_many_techniques_give_one_sentence_beside_the_best():
    rows = table(("uniform", 512, 1000, 0), ("lispsm", 512, 250, 0), ("tsm", 512, 500, 0), ("psm", 512, 2000, 0))
    text = verdict(rows)
    assert "lispsm is worth it here" in text
    assert text.endswith(
        "Relative to uniform at equal resolution the others leave: tsm 0.5 times the wrong pixels, 500 (0.500 %); "
        "psm 2 times, 2,000 (2.00 %)."
    )


def test_slight_differences_are_called_slight():
    better = verdict(table(("uniform", 512, 10_000, 0), ("lispsm", 512, 9000, 0)))
    counts = "9,000 (9.00 %) against 10,000 (10.0 %)."
    assert (
        f"lispsm is slightly better here: at 512² it leaves 10.0 % fewer wrong pixels than uniform, {counts}" in better
    )
    worse = verdict(table(("uniform", 512, 1000, 0), ("lispsm", 512, 1200, 0)))
    counts = "1,200 (1.20 %) against 1,000 (1.00 %)."
    assert f"lispsm is slightly worse here: at 512² it has 20.0 % more wrong pixels than uniform, {counts}" in worse
    rows = [("uniform", 512, 20_000, 0), ("uniform", 1024, 10_000, 0)]
    rows += [("lispsm", 512, 23_000, 0), ("lispsm", 1024, 11_500, 0)]
    several = verdict(table(*rows))
    assert "lispsm is slightly worse here: it is worse than uniform at every resolution from 512² to 1024²" in several


def test_several_maps_are_unwarped_only_together():
    rows = table(("uniform", 64, 3000, 0), ("split", 64, 900, 0))
    rows["maps"] = [1, 2]
    assert "does not warp here" not in verdict(rows, remarks=noted((), (NO_WARP.about([0]),)))
    for notes in ((NO_WARP,), (NO_WARP.about([0]), NO_WARP.about([1])), (OTHER, NO_WARP, OTHER)):
        told = verdict(rows, remarks=noted((), notes))
        assert f"split does not warp here ({WHY}): its map is a uniform one." in told
    flat = sl.Note("no_warp", ["flat_body"], maps=[5])
    assert unwarped_maps([NO_WARP.about([0, 1, 2, 4])], 6) == (4, WHY)
    assert unwarped_maps([NO_WARP.about([0, 1]), flat], 6) == (3, f"{WHY}; {flat.reasons[0]}")
    assert unwarped_maps([OTHER.about([0, 1, 2])], 6) == (0, "")


def test_numbers_are_written_as_people_do():
    assert (times(123_456.0), factor(1.0), factor(100.0), factor(0.5)) == ("123,456", "1", "100", "0.5")
    assert (factor(0.0), factor(1e-6), factor(0.014)) == ("0", "less than 0.01", "0.014")
    rows = table(("uniform", 512, 20, 0), ("lispsm", 512, 10, 0), ("psm", 512, 2000, 0))
    assert "psm 100 times the wrong pixels, 2,000 (2.00 %)." in verdict(rows)
    assert "e+" not in verdict(rows)


def test_more_maps_are_told_with_what_they_cost():
    rows = table(("uniform", 512, 4000, 0), ("lispsm", 512, 2000, 0), ("split", 512, 800, 0))
    rows["maps"] = [1, 1, 4]
    text = verdict(rows)
    told = "split at 4 × 512² leaves 5 times fewer wrong pixels than uniform at 512², with 4 times the texels: "
    assert f"{told}800 (0.800 %) against 4,000 (4.00 %)." in text
    assert "lispsm is worth it here" in text
    assert "split is" not in text
    rows["misclassified"] = pd.array([4000, 2000, 4010], dtype="Int64")
    assert "leaves about as many wrong pixels as uniform at 512², with 4 times the texels" in verdict(rows)
    rows["maps"] = [6, 6, 6]  # of a point light all have as many
    assert "the texels" not in verdict(rows)


def test_techniques_that_fail_for_one_reason_fail_in_one_sentence():
    reason = "does not support a point light; it supports directional"
    rows = table(*[(name, 64, None, None, f'technique "{name}" {reason}') for name in ("psm", "tsm", "log")])
    remarks = [Remarks(refusal=reason)] * 3
    told = verdict(rows, remarks=remarks)
    assert told == f"No technique gave a result. psm, tsm and log failed: such a technique {reason}."
    assert verdict(rows[:1], remarks=remarks[:1]).endswith(f'psm failed: technique "psm" {reason}.')
    scene = sl.library.scene("robots")
    light = sl.PointLight((0, 3, 0), range=20)
    runs = [sl.evaluate(sl.View(scene, scene.camera, light, size=(8, 8)), name, 64) for name in ("psm", "tsm")]
    assert {run.refusal for run in runs} == {reason}
    assert all(run.failure == f'technique "{run.label}" {reason}' for run in runs)
