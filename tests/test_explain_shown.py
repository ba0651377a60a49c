"""Explained pixels on the command line and as figures."""

from __future__ import annotations

import importlib.util
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from explain_support import run_of, some, view_of
from matplotlib.backends.backend_agg import FigureCanvasAgg

import shadowlab as sl

ROOT = Path(__file__).resolve().parents[1]
WORDS = ("explain", "@robots", "--technique", "lispsm", "--resolution", "256", "--size", "320x180", "--backend", "cpu")


@pytest.fixture(scope="module")
def page():
    spec = importlib.util.spec_from_file_location("explain_page", ROOT / "docs" / "explain.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where its dataclasses look for their module
    spec.loader.exec_module(module)
    return module


def test_the_command_prints_the_explanation(run):
    (x, y), *_ = some(run_of("robots", "lispsm", 256).causes.image == 3, 1, 2)
    found = sl.explain_pixel(view_of("robots"), "lispsm", x, y, resolution=256, renderer="cpu", trials=False)
    status, out, err = run(*WORDS, "--no-trials", "--pixel", f"{x},{y}")
    assert (status, err) == (1, "")
    assert out == f"{found}\n"
    (x, y), *_ = some(run_of("robots", "lispsm", 256).causes.image == 0, 1, 2)
    assert run(*WORDS, "--no-trials", "--pixel", f"{x},{y}")[0] == 0


@pytest.mark.parametrize("ending", ["png", "svg", "PDF"])
def test_the_command_writes_the_figure(run, tmp_path, ending):
    file = tmp_path / f"pixel.{ending}"
    status, out, _ = run(*WORDS, "--no-trials", "--pixel", "172,101", "--figure", file)
    assert status in (0, 1)
    assert out.endswith(f"Figure: {file}\n")
    assert file.stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--pixel", "320,0"), "x: expected a whole number from 0 to 319"),
        (("--pixel", "0,180"), "y: expected a whole number from 0 to 179"),
        (("--pixel", "-1,0"), "pixel: expected column and row such as 412,233"),
        (("--pixel", "1"), "pixel: expected column and row"),
        (("--pixel", "1.5,2"), "pixel: expected column and row"),
        (("--pixel", "99999999999,2"), "pixel: expected column and row"),
        ((), "--pixel"),
        (("--pixel", "3,3", "--technique", "uniform"), "technique: expected one, got lispsm and uniform"),
        (("--pixel", "3,3", "--figure", "pixel.txt"), "figure: expected a file that ends in one of"),
        (("--pixel", "3,3", "--figure", ""), "figure: expected the name of a file"),
        (("--pixel", "3,3", "--resolution", "32"), "resolution: expected one number of texels"),
    ],
)
def test_a_mistake_of_the_command_is_one_line(run, words, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*WORDS, *words)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert part in err
    assert list(tmp_path.iterdir()) == []


def explained(x, y, technique="lispsm", resolution=256, **more):
    more = {"renderer": "cpu", "trials": False} | more
    return sl.explain_pixel(view_of("robots"), technique, x, y, resolution=resolution, **more)


def drawn(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())


@pytest.mark.parametrize("technique", ["lispsm", "rectilinear", "z_partition:count=3,inner=lispsm", "log_psm"])
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_pixels_of_every_kind_have_a_figure(technique, filter):
    image = run_of("robots", technique, 256, filter).causes.image
    for code in np.unique(image):
        (x, y), *_ = some(image == code, 1, 3)
        figure = explained(x, y, technique, filter=filter).figure()
        assert len(figure.axes) == 3
        assert np.ptp(drawn(figure)[..., :3]) == 255


def test_the_figure_shows_where_pixel_texel_and_depths_are():
    (x, y), *_ = some(run_of("robots", "lispsm", 256).causes.image == 3, 1, 2)
    found = explained(x, y)
    eye, light, cut = found.figure().axes
    lines = {line.get_label(): np.asarray(line.get_data()).T for line in eye.lines}
    assert lines["the pixel"].min(axis=0).tolist() == [x, y]
    assert lines["the pixel"].max(axis=0).tolist() == [x + 1, y + 1]
    assert lines["its texel"][:4] == pytest.approx(found.texel.corners_px)
    lines = {line.get_label(): np.asarray(line.get_data()).T for line in light.lines}
    assert lines["the texel"].min(axis=0).tolist() == [found.texel.column, found.texel.row]
    assert lines["the pixel's point"][0] == pytest.approx(found.chain.place)
    # The triangle that the ray met is around the texel's centre.
    corners = lines["stored surface's triangle"][:3]
    centre = np.array([found.texel.column, found.texel.row]) + 0.5
    sides = np.roll(corners, -1, axis=0) - corners
    turns = np.cross(np.pad(sides, ((0, 0), (0, 1))), np.pad(centre - corners, ((0, 0), (0, 1))))[:, 2]
    assert (turns >= -0.1).all() or (turns <= 0.1).all()
    words = " ".join(text.get_text() for text in cut.texts)
    for part in ("receiver's plane", "the texel", "bias", "stored", "blocker"):
        assert part in words


def test_a_right_pixel_an_averted_one_and_background_have_a_figure():
    view = view_of("robots")
    cosine = -np.asarray(view.gbuffer("cpu").normal) @ np.asarray(view.light.direction)
    (x, y), *_ = some((cosine < -0.1) & (view.truth() == 0), 1, 1)
    figure = explained(x, y).figure()
    assert "no light can arrive" in [text.get_text() for text in figure.axes[2].texts]
    up = view.camera.replace(target=view.camera.eye + np.array([0.2, 1.0, -0.3]), up=(0.0, 0.0, -1.0))
    sky = sl.View(view.scene, up, view.light, size=(32, 18))
    found = sl.explain_pixel(sky, "uniform", 3, 4, resolution=64, renderer="cpu")
    assert "no map is asked" in [text.get_text() for text in found.figure().axes[1].texts]


def test_only_an_explanation_has_a_figure():
    with pytest.raises(sl.errors.ArgumentError, match=r"explanation: expected a PixelExplanation, got 3"):
        sl.plot.pixel_figure(3)


def test_a_notebook_shows_text_and_figure():
    html = explained(172, 101)._repr_html_()
    assert html.startswith("<pre>Pixel (172, 101)")
    assert 'src="data:image/png;base64,' in html


def test_the_page_is_what_the_explanations_say(page):
    """Its texts are made again; every example has a picture."""
    text = page.PAGE.read_text(encoding="utf-8")
    for example in page.EXAMPLES:
        found = example.explained()
        assert str(found) in text
        assert f"$ {example.command}\n" in text
        assert found.is_wrong
    assert len(list(page.PICTURES.glob("*.png"))) == len(page.EXAMPLES)


def test_the_commands_of_the_page_are_commands(page):
    from shadowlab import cli

    for example in page.EXAMPLES:
        options = cli.given_options(shlex.split(example.command)[1:])
        assert options.pixel == ",".join(map(str, example.pixel))
