"""The page stands alone: parsed with html.parser, no resource of any other place, every picture with its text."""

from __future__ import annotations

import base64
import io
import json
import re
import sys
from html.parser import HTMLParser
from importlib import metadata

import numpy as np
import pytest
from PIL import Image

import shadowlab as sl
from shadowlab.reports import study_record
from shadowlab.reports.html import page as report_html
from shadowlab.reports.html.chart import decades, error_chart

VOID = {"meta", "br", "img", "link", "input", "hr"}


class Page(HTMLParser):
    """What a page refers to, its ids, its nesting and its text."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.resources, self.links, self.tags, self.text = [], [], [], [], [], []
        self.pictures = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        self._look(tag, named)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)
        self._look(tag, dict(attributes))

    def _look(self, tag, named):
        if "id" in named:
            self.ids.append(named["id"])
        for name in ("src", "href", "data", "srcset", "action", "poster", "xlink:href"):
            if name in named:
                (self.links if tag == "a" else self.resources).append(named[name])
        if tag == "svg" and named.get("aria-hidden") != "true":
            self.pictures.append(named)
        if tag == "img":
            assert named.get("alt")

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def study():
    scene = sl.library.scene("skylight")
    return sl.compare(
        scene, scene.camera, scene.light, ["uniform", "lispsm"], resolution=[64, 256], size=(96, 54), progress=False
    )


@pytest.fixture(scope="module")
def saved(study, tmp_path_factory):
    directory = tmp_path_factory.mktemp("report")
    return study.save(directory / "deep" / "er")


@pytest.fixture(scope="module")
def page(saved):
    return Page(saved.read_text(encoding="utf-8"))


def test_every_resource_is_in_the_page(page):
    assert page.resources
    for resource in page.resources:
        assert resource.startswith(("data:image/png;base64,", "#")), resource[:80]
    assert not {"script", "link", "iframe", "object", "embed", "base", "form"} & set(page.tags)


def test_no_style_reaches_outside(saved):
    text = saved.read_text(encoding="utf-8")
    style = re.search(r"<style>(.*?)</style>", text, re.DOTALL)[1]
    assert not re.search(r"@import|url\(|https?:|//", style)
    without_data = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "", text)
    assert not re.search(r"https?://", without_data)
    assert "default-src 'none'" in text


def test_every_link_has_its_place(page):
    assert len(page.ids) == len(set(page.ids))
    for target in [*page.links, *(r for r in page.resources if r.startswith("#"))]:
        assert target.startswith("#")
        assert target[1:] in page.ids


def test_every_picture_has_a_text(page):
    assert len(page.pictures) >= 4 * 4
    for named in page.pictures:
        assert named["role"] == "img"
        assert len(named["aria-label"]) > 10


def test_the_page_is_well_formed_and_names_its_language(page, saved):
    assert page.open == []
    text = saved.read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    assert '<html lang="en">' in text
    assert 'name="viewport"' in text
    assert "prefers-color-scheme: dark" in text
    assert "@media print" in text


def test_pictures_are_pictures(saved):
    text = saved.read_text(encoding="utf-8")
    for data in re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", text):
        Image.open(io.BytesIO(base64.b64decode(data, validate=True))).verify()


def test_the_page_says_what_the_table_says(page, study):
    text = "".join(page.text)
    assert study.verdict.split(". ")[0] in text
    for row in study.table.to_dict("records"):
        assert f"{row['misclassified']:,}" in text
        assert f"{row['resolution']}²" in text
    assert "shadowlab compare @skylight" in text
    assert "sl.library.scene('skylight', seed=1)" in text


def test_the_truth_is_stored_once(saved):
    text = saved.read_text(encoding="utf-8")
    assert text.count('<symbol id="truth"') == 1
    assert text.count('href="#truth"') >= 8


def test_beside_the_page(saved, study):
    names = {path.name for path in saved.parent.iterdir()}
    assert {"report.html", "results.csv", "results.json", "truth.png"} <= names
    for stem in ("uniform_64", "uniform_256", "lispsm_64", "lispsm_256"):
        for kind in ("eye", "difference", "map"):
            assert f"{stem}_{kind}.png" in names
    image = np.asarray(Image.open(saved.parent / "lispsm_256_eye.png"))
    assert image.shape == (54, 96, 3)
    difference = np.asarray(Image.open(saved.parent / "lispsm_256_difference.png"))
    wrong = (difference == sl.plot.pictures.FALSE_LIGHT_RGB).all(axis=-1)
    np.testing.assert_array_equal(wrong, study.differences["lispsm", 256] == 2)


def test_names_from_outside_are_text_not_markup(study):
    from dataclasses import replace

    runs = tuple(replace(run, label=f"<img src=x onerror=alert(1)> & {run.label}") for run in study.runs)
    hostile = replace(study, runs=runs, source=sl.Source('"><script>alert(1)</script>'))
    text, files = report_html.build(hostile)
    page = Page(text)
    assert "script" not in page.tags
    assert "img" not in page.tags
    assert all(re.fullmatch(r"[a-z0-9_-]+\.png", name) for name in files)
    assert len(files) == 1 + 5 * 4
    assert "<script" not in hostile._repr_html_()


def test_labels_that_look_alike_in_files_keep_their_own_pictures(study):
    from dataclasses import replace

    first, second = (replace(study.runs[i], label=label, resolution=64) for i, label in ((0, "a b"), (2, "a-b")))
    _, files = report_html.build(replace(study, runs=(first, second)))
    assert len(files) == 1 + 2 * 5


def test_a_directory_that_cannot_be_written(study, tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("not a directory")
    with pytest.raises(sl.errors.ArgumentError, match="cannot write"):
        study.save(blocker)
    with pytest.raises(sl.errors.ArgumentError, match="cannot write"):
        study.save(blocker / "below")


def test_a_study_without_truth_has_a_page(study):
    scene = sl.library.scene("skylight")
    plain = sl.compare(
        scene, scene.camera, scene.light, "uniform", resolution=32, size=(16, 9), truth=False, progress=False
    )
    text, files = report_html.build(plain)
    page = Page(text)
    assert page.open == []
    assert "truth.png" not in files
    assert all(target[1:] in page.ids for target in page.resources if target.startswith("#"))


def test_several_maps_are_shown_side_by_side(study):
    from dataclasses import replace

    run = study.runs[0]
    matrix = np.asarray(run.parameterization.matrix)
    many = sl.Parameterization.from_matrix(np.stack([matrix, matrix]))
    double = replace(run, parameterization=many, item=many)
    text, files = report_html.build(replace(study, runs=(double,)))
    assert {"uniform_64_map_1.png", "uniform_64_map_2.png"} <= set(files)
    assert Page(text).open == []


def test_chart_needs_two_resolutions(study):
    chart = error_chart(study.table)
    assert chart.count("<polyline") == 2
    assert Page(chart).open == []
    assert error_chart(study.table[study.table["resolution"] == 64]) == ""


@pytest.mark.parametrize(("low", "high"), [(1e-4, 30.0), (0.5, 0.5), (1.0, 10.0), (0.03, 0.031), (2.0, 2.0)])
def test_ticks_enclose_the_numbers(low, high):
    ticks = decades(low, high)
    assert len(ticks) >= 2
    assert ticks == sorted(set(ticks))
    assert ticks[0] <= low
    assert ticks[-1] >= high


def test_pictures_of_an_earlier_report_go_and_nothing_else(tmp_path):
    scene = sl.library.scene("robots")

    def saved(labels):
        sl.compare(
            scene, scene.camera, scene.light, labels, resolution=32, size=(32, 18), renderer="cpu", progress=False
        ).save(tmp_path)
        return {path.name for path in tmp_path.iterdir()}

    (tmp_path / "holiday.png").write_bytes(b"mine")
    both = saved({"one": "uniform", "two": "lispsm"})
    assert any("two" in name for name in both)
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert set(data["pictures"]) == {name for name in both if name.endswith(".png")} - {"holiday.png"}
    one = saved({"one": "uniform"})
    assert one == {name for name in both if "two" not in name}
    assert (tmp_path / "holiday.png").read_bytes() == b"mine"


@pytest.mark.parametrize(
    "results", ["", "[]", '{"pictures": 3}', '{"pictures": ["../a.png", "notes.txt", 7, "/a.png", ".."]}']
)
def test_a_results_file_of_somebody_else_removes_nothing(tmp_path, results):
    from shadowlab.reports.html.page import own_pictures

    folder = tmp_path / "report"
    folder.mkdir()
    for path in (tmp_path / "a.png", folder / "notes.txt"):
        path.write_bytes(b"mine")
    (folder / "results.json").write_text(results, encoding="utf-8")
    assert own_pictures(folder / "results.json") == set()
    assert own_pictures(folder / "none.json") == set()


def test_versions_are_those_of_the_installer(tmp_path, monkeypatch):
    for package in study_record.PACKAGES:
        assert study_record.versions()[package] == metadata.version(package)
    assert study_record.recorded_version("no_such_package") is None
    # Where folders cannot be read, or are not there, by what Python knows of packages.
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(tmp_path / "none")])
    assert study_record.recorded_version("numpy") is None
    (tmp_path / "numpy-0.5.dist-info").mkdir()
    assert study_record.recorded_version("numpy") == "0.5"
