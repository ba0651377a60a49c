"""Studies of several maps: their count, which of them each pixel asks, their pictures, their numbers; point lights."""

from __future__ import annotations

import json
import re

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.experiments.counts import texels
from shadowlab.pictures import frustum_segments
from shadowlab.pictures.maps import MAP_RGB, even_in_log, framed, frustum_in, map_colour, mosaic
from shadowlab.reports.reproduce import command_line, python_snippet
from shadowlab.reports.study_verdict import sentences
from shadowlab.reports.words import size_text

mpl.use("Agg")
SIZE = (64, 36)


@pytest.fixture(scope="module")
def cascades():
    """A library scene, and two maps of it, one for the near half of the depths and one for all."""
    scene = sl.library.scene("courtyard")
    camera = scene.camera
    middle = 12.0
    near = sl.Camera.look_at(
        camera.eye, np.asarray(camera.eye) + camera.forward, up=camera.up,
        fov_y=camera.fov_y, aspect=camera.aspect, near=camera.near, far=middle,
    )  # fmt: skip
    uniform = sl.technique("uniform")
    stack = [uniform.parameterize(scene, c, scene.light, resolution=128).matrix for c in (near, camera)]
    p = sl.Parameterization.from_matrix(
        np.array(stack), resolution=128, eye_depth=[(camera.near, middle), (middle, camera.far)]
    )
    return scene, p, middle


@pytest.fixture(scope="module")
def study(cascades):
    scene, p, _ = cascades
    return sl.compare(
        scene, scene.camera, scene.light, {"uniform": "uniform", "two": p},
        resolution=[128, 256], size=SIZE, renderer="cpu", phases=1, progress=False,
    )  # fmt: skip


def test_the_table_counts_the_maps(study):
    assert study.table["maps"].tolist() == [1, 1, 2, 2]
    assert (study.table["failure"] == "").all()
    wrong = study.table.set_index(["technique", "resolution"])["misclassified"]
    assert wrong["two", 128] < wrong["uniform", 128]
    assert "2 × 128²" in repr(study)
    assert study.maps["two", 128].shape == (2, 128, 128)


def test_each_pixel_asks_the_map_of_its_depth(study, cascades):
    scene, _, middle = cascades
    assert set(study.chosen) == {("two", 128), ("two", 256)}
    chosen = study.chosen["two", 128]
    assert chosen.shape == SIZE[::-1]
    depth = np.asarray(scene.camera.depth(np.asarray(study.gbuffer.position).reshape(-1, 3))).reshape(SIZE[::-1])
    asked = chosen >= 0
    assert asked.sum() > 100
    # Float positions may fall on either side of the split; nothing else does.
    clear = asked & (np.abs(depth - middle) > 1e-4)
    np.testing.assert_array_equal(chosen[clear], (depth[clear] > middle).astype(int))


def test_the_verdict_tells_equal_resolution_from_equal_memory(study):
    text = study.verdict
    assert "two is worth it" not in text
    table = study.table.set_index(["technique", "resolution"])
    (plain, of_plain), (split, of_split) = (
        (row["misclassified"], f"{100 * row['share']:.3g} %")
        for row in (table.loc[("uniform", 256)], table.loc[("two", 128)])
    )
    told = f"{plain:,} wrong pixels ({of_plain}) against {split:,} ({of_split})"
    assert f"uniform at 256² has 2 times the texels of two at 2 × 128², and {told}." in text


def verdict(table):
    return " ".join(sentences(table))


def rows(*given):
    """A table of (technique, resolution, maps, wrong)."""
    made = [
        {"technique": t, "resolution": r, "maps": k, "misclassified": n, "false_shadow": n, "false_light": 0,
         "share": n / 1e5, "compared": 100_000, "undecided": 0, "notes": "", "failure": ""}
        for t, r, k, n in given
    ]  # fmt: skip
    return pd.DataFrame(made)


def test_as_many_texels_are_said_so():
    text = verdict(rows(("uniform", 1024, 1, 4000), ("uniform", 2048, 1, 1500), ("split", 1024, 4, 1000)))
    assert "split at 4 × 1024² has the fewest wrong pixels: 1,000 pixels" in text
    told = "1,500 wrong pixels (1.50 %) against 1,000 (1.00 %)"
    assert f"uniform at 2048² has as many texels as split at 4 × 1024², and {told}." in text


def test_of_equal_counts_the_fewest_texels_come_first():
    text = verdict(rows(("split", 512, 4, 50), ("uniform", 768, 1, 50)))
    assert text.startswith("uniform at 768² has the fewest")
    text = verdict(rows(("split", 512, 4, 50), ("uniform", 1024, 1, 50)))
    assert text.startswith("split at 4 × 512² and uniform at 1024² share the fewest")
    assert "maps" not in verdict(rows(("a", 64, 1, 50), ("b", 64, 1, 60)))
    assert "maps" not in verdict(rows(("a", 64, 6, 50), ("b", 64, 6, 60)))


def test_sizes():
    assert size_text({"resolution": 512, "maps": 4}) == "4 × 512²"
    assert size_text({"resolution": 512, "maps": None}) == size_text({"resolution": 512}) == "512²"
    assert texels({"resolution": 512, "maps": 4}) == 4 * 512 * 512


def test_the_report_shows_every_map_and_its_numbers(study, tmp_path):
    page = study.save(tmp_path).read_text(encoding="utf-8")
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert {"two_128_map_1.png", "two_128_map_2.png", "two_128_chosen.png"} <= set(data["pictures"])
    assert [len(run["partitions"]) for run in data["runs"]] == [1, 1, 2, 2]
    assert data["runs"][2]["partitions"][0]["eye_depth"][1] == 12.0
    assert data["runs"][0]["partitions"][0]["values"]
    assert page.count("The map that each pixel asks") == 2
    assert page.count("Numbers of the maps") == 2
    for index in (0, 1):
        assert f"background:rgb{map_colour(index)}" in page
    shares = [float(share) for share in re.findall(r"map \d: ([\d.]+) %", page)[:2]]
    chosen, seen = study.chosen["two", 128], np.asarray(study.gbuffer.triangle) >= 0
    assert shares == pytest.approx([100 * (chosen == i).sum() / seen.sum() for i in (0, 1)], rel=5e-3)


def test_the_figure_has_a_column_for_what_is_asked(study):
    figure = study.figure()
    titles = [ax.get_title() for ax in figure.axes]
    assert titles.count("the map that is asked") == 2
    assert "2 maps from the light" in titles
    assert len(figure.axes) == 4 * 4


def test_the_python_of_several_matrices_gives_the_same_numbers(study, cascades):
    two = study.runs[2:]
    assert command_line(study, two) is None
    names: dict = {}
    exec(compile(python_snippet(study, two), "snippet", "exec"), names)
    assert names["study"].table["misclassified"].tolist() == study.table["misclassified"].tolist()[2:]


def test_a_point_light_goes_all_the_way(tmp_path):
    scene = sl.library.scene("robots")
    low, high = np.asarray(scene.bounds)
    light = sl.PointLight((low + high) / 2 + [0, 3, 0], range=100)
    study = sl.compare(
        scene, scene.camera, light, ["uniform", "lispsm"], resolution=128, size=SIZE, renderer="cpu", progress=False
    )
    assert study.table["maps"].tolist() == [6, 6]
    assert (study.table["share"] < 0.1).all()
    assert "6 maps" not in study.verdict  # nothing with one map to tell them from
    assert "uniform_128_map_6.png" in json.loads((study.save(tmp_path).parent / "results.json").read_text())["pictures"]
    assert "6 maps from the light" in [ax.get_title() for ax in study.figure().axes]


def test_a_mosaic_keeps_every_picture():
    tiles = [np.full((4, 6, 3), i, np.uint8) for i in range(5)]
    made = mosaic(tiles)
    assert made.shape == (4 + 1 + 4, 6 * 3 + 2, 3)
    for i in range(5):
        assert (made == i).all(axis=2).sum() == 24
    assert mosaic(tiles[:1]) is not tiles[0]
    assert mosaic(tiles[:1]).shape == (4, 6, 3)


def test_frames_and_colours():
    picture = np.zeros((200, 200, 3), np.uint8)
    made = framed(picture, (1, 2, 3))
    assert (made[:3] == (1, 2, 3)).all()
    assert not made[3:-3, 3:-3].any()
    assert not picture.any()
    assert map_colour(0) == map_colour(len(MAP_RGB))
    assert len(set(MAP_RGB)) == len(MAP_RGB)


def test_the_frustum_follows_a_logarithm():
    scene = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light)
    np.testing.assert_array_equal(frustum_in(p.partitions[0], scene.camera), frustum_segments(p.matrix, scene.camera))
    camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), aspect=1.0, near=1, far=100)
    matrix = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0.5], [0, 0, -1, 0]])  # w is the camera depth
    scale = 2 / np.log(100)
    logarithmic = sl.Parameterization.from_matrix(matrix, post_warp=[("log", scale, -1.0)])
    lines = frustum_in(logarithmic.partitions[0], camera)
    assert np.abs(lines).max() <= 1
    # The edges along the view are upright in this map: x / w does not change, y covers all of it.
    upright = lines[np.isclose(np.abs(lines[..., 0]), np.tan(camera.fov_y / 2)).all(axis=1)]
    steps = np.unique(np.round(np.abs(np.diff(upright[..., 1], axis=1)), 12))
    assert steps[-1] == pytest.approx(2 / 48)
    np.testing.assert_array_equal(even_in_log(1.0, 1.0), np.linspace(0, 1, 49))


def test_the_frustum_follows_knots():
    camera = sl.Camera.look_at((0, 0, 5), (0, 0, 0), aspect=1.0, near=1, far=3)
    matrix = np.diag([0.4, 0.4, 0.1, 1.0])
    bent = [(-1, -1), (0, 0.5), (1, 1)]
    warped = sl.Parameterization.from_matrix(matrix, post_warp=[("rectilinear", bent, [(-1, -1), (1, 1)])])
    lines = frustum_in(warped.partitions[0], camera)
    straight = frustum_segments(matrix, camera)
    # Upright lines stay upright, at the places of their ends; y is as before.
    ends = {round(float(np.interp(x, (-1, 0, 1), (-1, 0.5, 1))), 9) for x in straight[..., 0].ravel()}
    assert ends <= {round(float(x), 9) for x in lines[..., 0].ravel()}
    np.testing.assert_allclose(np.ptp(lines[..., 1]), np.ptp(straight[..., 1]))
    assert np.abs(lines[..., 0]).max() <= 1
