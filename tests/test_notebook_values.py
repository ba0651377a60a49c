"""What notebooks show of views, cameras and maps: pictures that are the view's, tables that say what it is."""

from __future__ import annotations

import base64
import io
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

import shadowlab as sl
from shadowlab import pictures
from shadowlab.reports.html.values import MOST_SHOWN, camera_html, parameterization_html

HOSTILE = '"><script>alert(1)</script>'
VOID = ("img", "br")


class Page(HTMLParser):
    """Its tags, whether they nest, its images' attributes and the cells of its tables, row by row."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.images, self.rows = set(), [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "img":
            self.images.append(dict(attributes))
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def page_of(text):
    page = Page(text)
    assert page.open == []
    assert page.tags <= {"div", "table", "tr", "th", "td", "img", "p"}
    return page


def matrices(page):
    """The tables of numbers, four rows of four each."""
    rows = [row for row in page.rows if len(row) == 4]
    return np.array(rows, dtype=float).reshape(-1, 4, 4)


@pytest.fixture(scope="module")
def scene():
    return sl.library.scene("robots")


def test_a_view_shows_its_picture_and_what_it_is(scene):
    view = sl.View(scene, scene.camera, scene.light, size=(1920, 1080), label="noon")
    page = page_of(view._repr_html_())
    (image,) = page.images
    drawn = np.asarray(Image.open(io.BytesIO(base64.b64decode(image["src"].partition(",")[2]))))
    small = sl.View(scene, scene.camera, scene.light, size=(480, 270))
    expected = pictures.shade(small.gbuffer(), small.light, pictures.truth_mask(small.truth()))
    np.testing.assert_array_equal(drawn, expected)
    assert "noon" in image["alt"]
    told = dict(page.rows)
    assert set(told) == {"label", "scene", "eye", "view", "depth range", "light", "size"}
    assert told["size"] == "1920 × 1080 pixels"
    assert f"{scene.triangle_count:,} triangles" in told["scene"]
    assert told["light"].startswith("directional")


def test_a_view_of_several_lights_shows_some_and_counts_the_others(scene):
    suns = [sl.DirectionalLight((1, -height, 0.2)) for height in range(1, MOST_SHOWN + 3)]
    text = sl.View(scene, scene.camera, suns, size=32)._repr_html_()
    page = page_of(text)
    assert len(page.images) == MOST_SHOWN
    assert len({image["src"] for image in page.images}) == MOST_SHOWN
    assert [row[0] for row in page.rows].count("light") == MOST_SHOWN
    assert "and 2 more lights" in text


def test_names_from_outside_are_text(scene):
    named = sl.Scene(scene)
    named.source = HOSTILE
    view = sl.View(named, scene.camera, scene.light, size=16, label=HOSTILE)
    page = page_of(view._repr_html_())
    assert dict(page.rows)["label"] == HOSTILE
    assert HOSTILE in page.images[0]["alt"]


def test_a_camera_shows_its_settings_and_its_matrix():
    camera = sl.Camera.look_at((1, 2, 3), (4, 5, -6), fov_y=0.7, aspect=1.5, near=0.25, far=70)
    page = page_of(camera_html(camera))
    told = dict(row for row in page.rows if len(row) == 2)
    assert told["depth range"] == "0.25 to 70"
    assert told["eye"].startswith("(1, 2, 3)")
    np.testing.assert_allclose(matrices(page)[0], camera.clip_from_world, rtol=1e-3)


@pytest.mark.parametrize("text", ["uniform", "lispsm", "psm", "log", "z_partition:count=3,inner=(lispsm:near=optimal)"])
def test_maps_show_settings_values_notes_and_matrices(scene, text):
    p = sl.technique(text).parameterize(scene, scene.camera, scene.light, resolution=256)
    html = parameterization_html(p)
    page = page_of(html)
    rows = [row for row in page.rows if len(row) == 2]
    assert dict(rows)["technique"] == p.technique
    for name in p.settings:
        assert f"{name}=" in dict(rows)["settings"]
    assert [row[1] for row in rows if row[0] == "note"] == [str(note) for note in p.notes]
    for part in p.partitions:
        for name, value in part.values.items():
            assert f"{name} {value:.4g}" in re.sub(r"<[^>]*>", "", html)
    np.testing.assert_allclose(matrices(page), p.matrices, rtol=1e-3, atol=1e-12)
    assert ("log: scale" in html) == any(part.post_warp == "log" for part in p.partitions)


def test_of_many_maps_some_are_shown(scene):
    html = parameterization_html(sl.technique("z_partition", count=9).parameterize(scene, scene.camera, scene.light))
    assert len(matrices(page_of(html))) == MOST_SHOWN
    assert "and 5 more maps" in html


def test_somebodys_matrices_and_notes_are_shown(scene):
    along = sl.DirectionalLight(scene.camera.forward)
    page = page_of(parameterization_html(sl.technique("lispsm").parameterize(scene, scene.camera, along)))
    assert ["note", "no warp, a uniform map: the light runs along the view"] in page.rows
    given = sl.Parameterization.from_matrix(np.diag([0.5, 0.25, 0.125, 1.0]))
    page = page_of(parameterization_html(given))
    assert ["technique", "matrix"] in page.rows
    assert ["camera depths", "all"] in page.rows
    np.testing.assert_array_equal(matrices(page)[0], given.matrix)
