"""How maps are read, said for all and in a technique's text: experiments, records, reproductions and commands agree."""

from __future__ import annotations

import json
import shlex

import pytest

import shadowlab as sl
from shadowlab.reports.reproduce import python_snippet
from shadowlab.reports.reproduce_advice import whole_advice

CASCADES = "z_partition:count=2,overlap=0.4,inner=uniform"
READ = {"filter": "bilinear", "blend": 0.4, "stored": "midpoint:spacing=linear"}
SIZE = (160, 90)


@pytest.fixture(scope="module")
def scene():
    return sl.library.scene("robots")


@pytest.fixture(scope="module")
def advice(scene):
    techniques = {"for all": CASCADES, "own": f"{CASCADES},mix=0,stored=front,filter=nearest"}
    return sl.advise(
        scene, scene.camera, scene.light, memory="64 KiB", techniques=techniques, size=SIZE, renderer="cpu", phases=1,
        progress=False, **READ,
    )  # fmt: skip


def run_again(text):
    """The names that a snippet leaves behind."""
    names: dict[str, object] = {}
    exec(text, names)
    return names


def test_advice_reads_as_an_evaluation_does(scene, advice):
    view = sl.View(scene, scene.camera, scene.light, size=SIZE)
    for one in advice.outcomes:
        own = {"filter": "nearest"} if one.candidate == "own" else READ
        run = sl.evaluate(view, CASCADES, one.resolution, metrics=["misclassified"], renderer="cpu", **own)
        assert one.numbers["misclassified"] == run.errors.count, one.candidate
    assert len({one.numbers["misclassified"] for one in advice.outcomes}) == 2


def test_rows_and_the_whole_of_an_advice_come_again(advice):
    for row in (0, 1):
        names = run_again(advice.reproduce(row))
        assert names["error_mean"] == pytest.approx(advice.table.loc[row, "error_mean"], rel=1e-12)
    again = run_again(whole_advice(advice))["advice"]
    assert again.blend == 0.4
    assert again.stored == sl.Stored(READ["stored"])
    assert again.table["error_mean"].tolist() == advice.table["error_mean"].tolist()


def test_an_advice_records_how_maps_were_read(advice, tmp_path):
    advice.save(tmp_path)
    data = json.loads((tmp_path / "advice.json").read_text())
    assert (data["blend"], data["stored"], data["filter"]) == (0.4, READ["stored"], "bilinear")
    assert "bilinear, blend 0.4, stored midpoint:spacing=linear lookup" in (tmp_path / "report.html").read_text()


def test_a_technique_that_blends_comes_again(scene, tmp_path):
    text = f"{CASCADES},mix=0.4,filter=bilinear"
    study = sl.compare(
        scene, scene.camera, scene.light, [CASCADES, text], resolution=64, size=SIZE, renderer="cpu", phases=1,
        progress=False,
    )  # fmt: skip
    plain, blended = study.runs
    assert (plain.blend, blended.blend) == (0.0, 0.4)
    assert (plain.mask != blended.mask).any()
    snippet = python_snippet(study, [blended])
    assert "mix=0.4" in snippet
    again = run_again(snippet)["study"]
    assert again.table["misclassified"].tolist() == [study.table["misclassified"][1]]
    study.save(tmp_path)
    (_, record) = json.loads((tmp_path / "results.json").read_text())["runs"]
    assert record["settings"]["mix"] == 0.4


def test_the_commands_take_it(run, tmp_path):
    common = ("--size", "160x90", "--backend", "cpu", "--filter", "bilinear", "--blend", "0.4", "--stored", "midpoint")
    asked = ("--technique", CASCADES)
    status, out, err = run(
        "explain", "@robots", *asked, "--resolution", "64", *common, "--no-trials", "--pixel", "80,60"
    )
    assert status in (0, 1)
    assert "It stores the middle" in out
    status, *_ = run("advise", "@robots", *asked, "--memory", "64KiB", *common, "--out", str(tmp_path))
    assert status == 0
    data = json.loads((tmp_path / "advice.json").read_text())
    assert (data["blend"], data["stored"]) == (0.4, "midpoint")
    for command in ("explain", "advise"):
        pixel = ("--pixel", "1,1") if command == "explain" else ()
        for words, said in (("--blend 2", "blend: expected a number from 0 to 1"), ("--stored fornt", "fornt")):
            status, out, err = run(command, "@robots", *pixel, *shlex.split(words), "--size", "32x18")
            assert (status, out) == (2, "")
            assert said in err
            assert len(err.splitlines()) == 1
