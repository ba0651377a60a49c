"""The page of an advice: one file that stands alone, with tables, pictures and the Python that makes it again."""

from __future__ import annotations

import base64
import html
import json
import re
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest
from advice_support import SETS, advise, made_view
from PIL import Image

import shadowlab as sl
from shadowlab.experiments.counts import WrongPixels


@pytest.fixture(scope="module")
def advice():
    return advise(made_view(), memory="16 KiB")


@pytest.fixture(scope="module")
def page(advice, tmp_path_factory):
    return advice.save(tmp_path_factory.mktemp("advice")).read_text(encoding="utf-8")


class Parts(HTMLParser):
    """Tags that are open, addresses that are named, and texts."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.addresses, self.ids, self.texts = [], [], [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        for name, value in attributes:
            if name in ("href", "src", "xlink:href", "action", "data"):
                self.addresses.append(value)
            if name == "id":
                self.ids.append(value)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        self.texts.append(data)


def parsed(page):
    found = Parts()
    found.feed(page)
    return found


def test_the_page_stands_alone_and_is_well_formed(page):
    found = parsed(page)
    assert (found.open, found.wrong) == ([], [])
    assert found.addresses
    inside = [one for one in found.addresses if one.startswith("#")]
    assert all(one.startswith(("#", "data:image/png;base64,")) for one in found.addresses)
    assert {one[1:] for one in inside} <= set(found.ids)
    assert len(set(found.ids)) == len(found.ids)
    assert "<script" not in page
    assert "url(" not in page
    assert "@import" not in page


def test_it_has_the_verdict_the_ranking_and_what_was_not_drawn(advice, page):
    text = html.unescape(" ".join(parsed(page).texts))
    for sentence in advice.sentences:
        assert sentence in text
    for one in advice.standings:
        assert one.candidate in text
        if one.sd is not None:
            assert advice.measure.noisy_text(one.error, one.sd) in text
    for one in advice.untried:
        assert one.technique in text


def test_it_shows_the_best_and_uniform_beside_the_truth_in_every_view(advice, page, tmp_path):
    """The pictures of the page are those of the runs: the same mask, shaded, for each of both."""
    from shadowlab import pictures

    def shade(view, mask):
        return pictures.png(pictures.shade(view.view.gbuffer("cpu"), view.light, mask))

    best, uniform = advice.best.candidate, "uniform"
    assert best != uniform
    for view in advice.views:
        truth = shade(view, pictures.truth_mask(view.view.truth()))
        assert page.count(base64.b64encode(truth).decode()) == 1
        for name in (best, uniform):
            (one,) = (o for o in advice.outcomes if (o.candidate, o.view.label) == (name, view.label))
            assert base64.b64encode(shade(view, one.run.mask)).decode() in page
            wrong = WrongPixels.of(one.numbers)
            assert f"{wrong.count:,.0f} ± " in page
    # And they are pictures: a PNG of the view's size.
    content = base64.b64decode(re.findall(r"data:image/png;base64,([^\"]+)", page)[-1])
    (tmp_path / "a.png").write_bytes(content)
    assert Image.open(tmp_path / "a.png").size == advice.views[0].size


def test_where_uniform_is_best_the_best_warp_stands_beside_it():
    from shadowlab.reports.html.advice import pictured

    scene, camera, lights = made_view()
    along = sl.DirectionalLight(camera.forward)
    found = advise((scene, camera, along), memory="16 KiB", techniques=["uniform", "z_partition:count=4"])
    shown = [one.candidate for one in pictured(found, found.standings)]
    assert shown[0] == found.best.candidate
    assert sorted(shown) == ["uniform", "z_partition:count=4"]
    alone = advise((scene, camera, lights), memory="16 KiB", techniques=["uniform"])
    assert [one.candidate for one in pictured(alone, alone.standings)] == ["uniform"]


def test_the_python_of_the_whole_advice_gives_its_tables(tmp_path):
    scene = sl.library.scene("robots")
    lights = {
        "noon": sl.DirectionalLight((0.1, -1, 0.1)),
        "spot": sl.SpotLight((3, 9, 0), (0, -1, 0), cone_angle=1, range=40),
    }
    found = sl.advise(
        scene, {"front": scene.camera}, lights, memory=["16 KiB", "32 KiB"], size=(64, 36), renderer="cpu",
        progress=False, techniques={"plain": "uniform", "mine": "lispsm:near=basic"}, phases=3, over="worst",
        bias=sl.Bias(world=0.01), filter="bilinear",
    )  # fmt: skip
    data = json.loads(found.save(tmp_path).with_name("advice.json").read_text(encoding="utf-8"))
    names: dict = {}
    exec(compile(data["reproduce"], "snippet", "exec"), names)
    again = names["advice"]
    assert [view.label for view in again.views] == [view.label for view in found.views]
    # A camera that is made again from its rounded target may turn a pixel.
    columns = ["technique", "memory", "maps", "resolution", "phases", "view"]
    pd.testing.assert_frame_equal(again.runs[columns], found.runs[columns])
    assert np.abs(again.runs["error"] - found.runs["error"]).max() <= 1 / found.runs["compared"].min()
    assert data["gains"][0]["relation"] == found.gains[0].relation
    assert [one["technique"] for one in data["untried"]] == [one.technique for one in found.untried]


def test_failures_and_views_that_show_nothing_have_a_page(tmp_path):
    scene, camera, lights = made_view()
    away = sl.Camera.look_at((0, 6, 0), (0, 12, 0.1), aspect=1.25, near=1.0, far=20.0)
    nothing = advise((scene, away, lights), techniques=SETS[:2], memory="16 KiB")
    page = nothing.save(tmp_path / "a").read_text(encoding="utf-8")
    assert html.escape(nothing.verdict) in page
    assert parsed(page).wrong == []
    lamp = sl.PointLight((0.5, 4, 0.2), range=20)
    some = advise((scene, camera, lamp), techniques=["uniform", "tsm"], memory="96 KiB")
    page = some.save(tmp_path / "b").read_text(encoding="utf-8")
    failure = next(one.failure for one in some.standings if one.candidate == "tsm")
    assert html.escape(failure) in page
    assert parsed(page).wrong == []
