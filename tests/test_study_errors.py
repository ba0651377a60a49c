"""What a study says of causes and texels: its columns, its report, its verdict; for matrices from elsewhere, too."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.aliasing.causes import CAUSES
from shadowlab.reports.html import errors as report_errors
from shadowlab.reports.study_errors import error_sentences

SIZE = (160, 90)


@pytest.fixture(scope="module")
def scene():
    return sl.library.scene("robots")


@pytest.fixture(scope="module")
def study(scene):
    samples = sl.View(scene, scene.camera, scene.light, size=SIZE).samples()
    technique = sl.technique("lispsm")
    p = technique.parameterize(scene, scene.camera, scene.light, resolution=256, samples=samples)
    mine = sl.Parameterization.from_matrix(np.array(p.matrix), resolution=256)
    techniques = {"uniform": "uniform", "lispsm": "lispsm", "mine": mine, "split": "z_partition:count=2", "log": "log"}
    return sl.compare(scene, scene.camera, scene.light, techniques, resolution=256, size=SIZE, progress=False)


def test_columns_are_what_the_parts_say(study, scene):
    table = study.table.set_index("technique")
    for run in study.runs:
        row = table.loc[run.label]
        e = sl.aliasing.footprint(study.gbuffer, scene.camera, scene.light, run.parameterization, resolution=256)
        s = e.summary()
        assert row["undersampled"] == s.undersampled
        assert row["texel_max"] == s.max == float(np.nanmax(e.major))
        assert row["texel_p95"] == s.percentiles[95]
        assert row["storage_factor"] == s.storage_factor
        assert sum(row[name] for name in CAUSES.values()) == row["misclassified"]
        assert row["unused"] == study.usage(run.label).unused
        np.testing.assert_array_equal(study.footprint(run.label).major, e.major)
        assert study.causes[run.label].count == run.errors.count
        assert study.summaries[run.label].max == s.max


def test_a_matrix_from_elsewhere_has_the_same_numbers_as_the_technique_it_comes_from(study):
    table = study.table.set_index("technique")
    columns = ["misclassified", *CAUSES.values(), "undersampled", "texel_max", "texel_mean", "storage_factor", "unused"]
    pd.testing.assert_series_equal(table.loc["mine", columns], table.loc["lispsm", columns], check_names=False)


def test_without_truth_there_are_texels_and_no_causes(scene):
    study = sl.compare(
        scene, scene.camera, scene.light, ["uniform"], resolution=64, size=SIZE, truth=False, progress=False
    )
    row = study.table.iloc[0]
    assert pd.isna(row["acne"])
    assert pd.isna(row["edge_px"])
    assert row["texel_mean"] > 0
    assert "Why pixels" not in report_errors.section_errors(study)
    assert "How large" in report_errors.section_errors(study)


def test_a_view_of_nothing_has_no_texels_and_says_so(scene, tmp_path):
    away = sl.Camera.look_at((0, 50, 0), (0, 100, 1), fov_y=0.5, aspect=1, near=0.1, far=10)
    study = sl.compare(scene, away, scene.light, ["uniform"], resolution=16, size=(8, 8), progress=False)
    row = study.table.iloc[0]
    assert pd.isna(row["texel_mean"])
    assert row["unused"] == 1
    assert row["acne"] == 0
    assert "nothing" in study.save(tmp_path, progress=False).read_text().lower()


def test_a_technique_that_fails_has_no_numbers_and_harms_no_other(scene):
    spot = sl.SpotLight((0, 12, 0), (0, -1, 0), cone_angle=1.2, range=50)
    study = sl.compare(scene, scene.camera, spot, ["psm", "uniform"], resolution=64, size=SIZE, progress=False)
    table = study.table.set_index("technique")
    assert table.loc["psm", [*CAUSES.values(), "texel_mean", "unused"]].isna().all()
    assert table.loc["uniform", "texel_mean"] > 0
    assert report_errors.section_errors(study).count("<tr>") == 4  # two tables of a head and a row
    with pytest.raises(sl.errors.UnknownNameError, match="uniform"):
        study.footprint("psm")


def test_the_report_has_a_picture_of_texels_and_of_causes_for_each_run(study, tmp_path):
    page = study.save(tmp_path, progress=False).read_text(encoding="utf-8")
    for run in study.runs:
        for kind in ("texels", "causes"):
            assert (tmp_path / f"{run.label}_256_{kind}.png").stat().st_size > 100
    assert page.count("Length of a texel</b>") == page.count("Why pixels are wrong</b>") == len(study.runs)
    data = json.loads((tmp_path / "results.json").read_text())
    for record, run in zip(data["runs"], study.runs, strict=True):
        assert record["texels"]["max"] == run.summary.max
        assert record["causes"]["acne"] == run.causes.acne
        assert len(record["texels"]["bands"]) == 6


def row(**values):
    base = {"technique": "lispsm", "resolution": 512, "maps": 1, "misclassified": 1000, "acne": 0, "leak": 0}
    return {**base, "missing": 0, "edge": 1000, "texel_p95": 3.0, **values}


def test_the_verdict_names_causes_that_are_many_and_the_map_that_would_do():
    assert error_sentences(row()) == [
        "A texel of lispsm at 512² is up to 3 px long in 95 % of the picture; one pixel would take 1,536² texels."
    ]
    (first, _) = error_sentences(row(leak=400))
    assert first.startswith("Of the wrong pixels of lispsm at 512², 40.0 % are leaks")
    assert "shadow themselves" in error_sentences(row(acne=900))[0]
    assert len(error_sentences(row(acne=20, misclassified=25))) == 1, "few pixels are no reason"
    assert error_sentences(row(texel_p95=0.7)) == [
        "A texel of lispsm at 512² is up to 0.7 px long in 95 % of the picture: fine enough."
    ]
    assert error_sentences(row(maps=3))[-1].endswith("1,536² texels a map.")
    assert error_sentences({"technique": "a", "resolution": 1, "misclassified": 5}) == []
    assert error_sentences(row(texel_p95=None, acne=None, leak=None, missing=None)) == []
