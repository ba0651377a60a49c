"""The study of prefiltered maps: against other functions, against closed forms of leaks, in every kind of map."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from test_smallest_bias import plane_view

import shadowlab as sl
from shadowlab.experiments.prefiltered_arguments import ALL_FORMATS

PAGE = Path(__file__).parents[1] / "docs" / "prefiltered.md"
SIZE = (320, 180)
PREFILTERED = ALL_FORMATS[2:]


def found_in(view: sl.View, technique: str | sl.Parameterization = "lispsm", **changes: object) -> sl.PrefilteredMaps:
    options = {"memory": "256 KiB", "renderer": "cpu", "progress": False, **changes}
    return sl.prefiltered_maps(view, technique, **options)


@pytest.fixture(scope="module")
def robots() -> sl.View:
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=SIZE)


@pytest.fixture(scope="module")
def found(robots: sl.View) -> sl.PrefilteredMaps:
    return found_in(robots)


def row_of(found: sl.PrefilteredMaps, name: str):
    return found.table.set_index("format").loc[name]


def under_two_boards(gap: float) -> sl.View:
    """A floor under a wide board `gap` above it, with the edge of a second board far above that: all in shadow."""

    def board(x0: float, x1: float, y: float, half: float) -> list[list[float]]:
        return [[x0, y, -half], [x1, y, -half], [x1, y, half], [x0, y, half]]

    vertices = board(-6, 6, 0, 6) + board(-5, 5, gap, 5) + board(-5, 0.013, 6.0, 5)
    faces = [[4 * i + j for j in three] for i in range(3) for three in ((0, 2, 1), (0, 3, 2))]
    scene = sl.Scene.from_arrays(np.array(vertices), faces)
    camera = sl.Camera.look_at((0, 0.8 * gap, 3), (0, 0, 0), aspect=16 / 9, near=0.05, far=20)
    return sl.View(scene, camera, sl.DirectionalLight((0, -1, 0)), size=SIZE)


@pytest.mark.parametrize("gap", [0.3, 1.0, 2.0])
def test_leaks_between_two_boards_are_those_of_the_closed_form(gap):
    """Shares p at 0 and 1 - p at `d`, the receiver `gap` behind: p (1-p) d² / (p (1-p) d² + (p d + gap)²)."""
    view = under_two_boards(gap)
    seen = found_in(view, "uniform", resolution=256, memory=None)
    shares, d = np.linspace(0, 1, 100_001), 6.0 - gap
    variance = shares * (1 - shares) * d**2
    bleeding = (variance / (variance + (shares * d + gap) ** 2)).max()
    inside = view.truth() == 0
    # The floor that is seen beneath both boards, away from its rim.
    of_floor = inside & (np.abs(view.gbuffer("cpu").position[..., 0]) < 1) & (view.gbuffer("cpu").normal[..., 1] > 0.9)
    of_floor &= view.gbuffer("cpu").position[..., 1] < 0.01
    assert of_floor.sum() > 500
    for name in ("variance:f32", "variance:unorm16"):
        light = seen.mask(name)[of_floor]
        # Shares come in the steps of a kernel that lies anywhere, and rounding adds to the variance.
        assert bleeding * 0.98 - 0.01 < light.max() < bleeding + 0.01
    # Two depths before the receiver: four moments know them exactly, comparisons and one exponential see no light.
    for name in ("moment:f32", "moment:unorm16"):
        assert seen.mask(name)[of_floor].max() < 0.02
    assert seen.mask("depth:pcf")[of_floor].max() == 0
    assert seen.mask("exponential:f32")[of_floor].max() == pytest.approx(np.exp(-80 * gap / 6), rel=0.2, abs=1e-3)
    assert (row_of(seen, "variance:f32").leaks > 0) == (bleeding > 0.5)
    assert row_of(seen, "variance:f32").bleeding > row_of(seen, "moment:f32").bleeding


@pytest.mark.parametrize("seed", range(4))
def test_a_plane_stays_lit(seed):
    """No acne at one half in any format; the few moments of f32 come to the bound of a plane, which is 0.72."""
    seen = found_in(plane_view(seed), "uniform", resolution=256, memory=None)
    for row in seen.table.itertuples():
        allowed = 0.002 if row.format.startswith("moment") else 0.0
        assert row.false_shadow <= allowed * SIZE[0] * SIZE[1], row.format
    assert (seen.table.false_light == 0).all()


def test_the_nearest_texel_is_what_everything_else_counts(robots, found):
    row = row_of(found, "depth:nearest")
    assert row.resolution == 256
    run = sl.evaluate(robots, "lispsm", 256, metrics=["misclassified"], renderer="cpu")
    assert (row.misclassified, row.false_shadow, row.false_light) == (
        run.errors.count, run.errors.false_shadow, run.errors.false_light,
    )  # fmt: skip
    assert np.array_equal(found.mask("depth:nearest"), run.mask, equal_nan=True)


def test_each_row_is_of_its_mask(robots, found):
    truth = robots.truth()
    soft = sl.trace.soft_shadow_mask(robots.scene, robots.camera, robots.light, size=SIZE)
    assert list(found.table.format) == list(ALL_FORMATS)
    for row, mask, leaking in zip(found.table.itertuples(), found.masks, found.leaking, strict=True):
        wrong, error = sl.aliasing.misclassified(mask, truth), sl.aliasing.soft_error(mask, soft)
        assert (row.misclassified, row.false_shadow, row.false_light) == (
            wrong.count, wrong.false_shadow, wrong.false_light,
        )  # fmt: skip
        assert (row.soft_error, row.too_dark, row.too_light) == (error.mean, error.too_dark, error.too_light)
        assert row.leaks == leaking.sum() <= row.false_light
        assert (truth[leaking] == 0).all()
        assert (mask[leaking] >= 0.5).all()
        seen = np.isnan(found.mask("depth:nearest"))
        assert np.array_equal(np.isnan(mask), seen)
        assert ((mask[~seen] >= 0) & (mask[~seen] <= 1)).all()
        # What faces away from the light is dark in all of them.
        away = (truth == 0) & (found.mask("depth:nearest") == 0) & (found.masks.max(axis=0) == 0)
        assert away.any()


def test_comparisons_do_not_leak(found):
    for name in ("depth:nearest", "depth:pcf"):
        row = row_of(found, name)
        assert row.covered > 1000
        # The nearest texel is looked up with another bias.
        assert row.leaks <= (2 if name == "depth:nearest" else 0)
        assert row.bleeding <= (1e-3 if name == "depth:nearest" else 0.0)
    assert row_of(found, "exponential:f16").leaks > 100
    assert row_of(found, "exponential:f16").bleeding > 0.1


def test_the_maps_are_the_largest_that_fit(found):
    for row in found.table.itertuples():
        assert row.bytes == row.maps * row.resolution**2 * row.texel_bytes <= 1 << 18
        assert row.maps * (row.resolution + 1) ** 2 * row.texel_bytes > 1 << 18
    assert found.memory == 1 << 18
    sizes = dict(zip(found.table.format, found.table.texel_bytes, strict=True))
    assert sizes == {
        "depth:nearest": 4, "depth:pcf": 4, "variance:f16": 4, "variance:unorm16": 4, "variance:f32": 8,
        "exponential:f16": 2, "exponential:f32": 4, "moment:unorm16": 8, "moment:f32": 16,
    }  # fmt: skip


def test_several_maps_share_the_budget(robots):
    seen = found_in(robots, "z_partition:count=3,inner=lispsm", formats=["depth:pcf", "variance:f32"])
    assert list(seen.table.maps) == [3, 3]
    assert (seen.table.bytes <= 1 << 18).all()
    one = found_in(robots, "lispsm", formats=["depth:pcf", "variance:f32"])
    assert (seen.table.resolution < one.table.resolution).all()
    assert (seen.table.misclassified < 3 * one.table.misclassified).all()


@pytest.mark.parametrize(
    ("technique", "kind"),
    [
        ("log_psm", "directional"),
        *((name, kind) for name in ("uniform", "rectilinear", "z_partition:count=3", "face_partition")
          for kind in ("directional", "spot", "point")),
    ],
)  # fmt: skip
def test_every_kind_of_map_and_light(robots, technique, kind):
    """The formats stay close to comparisons over the same kernel: a wrong depth or place would darken or light all."""
    middle = np.asarray(robots.scene.bounds).mean(axis=0)
    at = middle + np.array([4.0, 12.0, 3.0])
    light = {
        "directional": robots.light,
        "spot": sl.SpotLight(at, middle - at, cone_angle=1.5, range=200),
        "point": sl.PointLight(at, range=200),
    }[kind]
    view = sl.View(robots.scene, robots.camera, light, size=(160, 90))
    formats = ["depth:nearest", "depth:pcf", "variance:f32", "moment:f32"]
    seen = found_in(view, technique, resolution=512, memory=None, kernel=1, formats=formats)
    nearest, *others = seen.table.misclassified
    lit = (view.truth() == 1).mean()
    assert 0.01 < lit < 0.99
    assert nearest < 0.1 * 160 * 90
    assert max(others) < 1.3 * nearest + 30


def test_more_texels_are_better(robots):
    sides = [found_in(robots, memory=None, resolution=side, kernel=3) for side in (128, 512)]
    assert (sides[1].table.soft_error[1:] < sides[0].table.soft_error[1:]).all()


def test_a_reduction_takes_leaks_for_darker_edges(robots, found):
    cut = found_in(robots, reduction=0.3)
    for name in ("variance:unorm16", "variance:f32", "moment:unorm16"):
        assert row_of(cut, name).bleeding < row_of(found, name).bleeding
        assert row_of(cut, name).too_dark > row_of(found, name).too_dark
    for name in ("depth:pcf", "exponential:f32"):
        assert np.array_equal(cut.mask(name), found.mask(name), equal_nan=True)


def test_a_box_of_one_texel_is_bilinear(robots):
    """The four nearest texels, weighted: the project's own pcf2x2, but for its bias."""
    seen = found_in(robots, memory=None, resolution=512, kernel=1, formats="depth:pcf")
    own = sl.evaluate(robots, "lispsm", 512, metrics=["mask"], renderer="cpu", filter="pcf2x2").mask
    same = np.isclose(seen.masks[0], own, atol=1e-5, equal_nan=True)
    assert same.mean() > 0.97
    assert seen.table.lookups[0] == 4


def test_nothing_to_see(robots):
    upwards = robots.camera.replace(target=robots.camera.eye + np.array([0.0, 50.0, 0.1]))
    away = sl.View(robots.scene, upwards, robots.light, size=(32, 18))
    seen = found_in(away, "uniform")
    assert np.isnan(seen.masks).all()
    assert (seen.table.misclassified == 0).all()
    assert seen.table.bleeding.isna().all()
    seen.figure()
    assert "None leaks" in seen.verdict


def test_it_travels_and_shows_itself(found):
    assert pickle.loads(pickle.dumps(found)) == found
    assert found.verdict == str(found)
    assert "depth:pcf has" in found.verdict
    assert "<table" in found._repr_html_()
    assert repr(found).startswith("PrefilteredMaps(lispsm, 256 KiB, kernel 5, 9 formats")


def test_the_figure_has_a_picture_of_each(found):
    figure = sl.plot.prefiltered_figure(found)
    titles = [ax.get_title() for ax in figure.axes]
    assert len(titles) == 9
    for row, title in zip(found.table.itertuples(), titles, strict=True):
        assert title.startswith(f"{row.format}, {row.resolution}²")
        assert f"{row.misclassified:,} wrong" in title
    from shadowlab.plot.prefiltered import LEAK_RGB

    names = list(found.table.format)
    for name in ("depth:pcf", "exponential:f16"):
        picture = np.asarray(figure.axes[names.index(name)].images[0].get_array())
        marked = (picture == LEAK_RGB).all(axis=-1)
        assert np.array_equal(marked, found.leaking[names.index(name)])
    with pytest.raises(sl.errors.ArgumentError, match="found: expected a PrefilteredMaps"):
        sl.plot.prefiltered_figure(3)


def test_the_example_prints_what_the_page_says(capsys):
    mpl.use("Agg")
    python, printed = re.search(r"```python\n(.*?)```\n\n```\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL).groups()
    exec(compile(python, str(PAGE), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out == printed


@pytest.mark.parametrize("name", ["courtyard", "robots", "ceiling", "skylight", "dueling", "forest", "statues"])
def test_the_tables_of_the_page_are_true(name):
    scene = sl.library.scene(name, **({"trees": 300} if name == "forest" else {}))
    seen = found_in(sl.View(scene, scene.camera, scene.light, size=SIZE), memory="1 MiB").table
    page = PAGE.read_text("utf-8")
    for column, rows in (("misclassified", seen), ("leaks", seen[2:])):
        assert f"| {name} | " + " | ".join(f"{value:,}" for value in rows[column]) + " |\n" in page


@pytest.mark.parametrize(("memory", "kernel"), [(m, k) for m in ("1 MiB", "4 MiB", "16 MiB") for k in (3, 5)])
def test_the_table_of_memory_is_true(robots, memory, kernel):
    names = ["depth:nearest", "depth:pcf", "variance:f32", "moment:unorm16"]
    rows = found_in(robots, memory=memory, kernel=kernel, formats=names).table.itertuples()
    cells = " | ".join(f"{row.misclassified:,}, {row.soft_error:.4f}" for row in rows)
    assert f"| {memory} | {kernel} | {cells} |\n" in PAGE.read_text("utf-8")


def test_the_sums_of_the_page_are_true():
    lines = [
        [cell.strip().strip("*") for cell in line.strip("|").split("|")]
        for line in PAGE.read_text("utf-8").splitlines()
    ]
    for length in (len(ALL_FORMATS), len(PREFILTERED)):
        rows = [line for line in lines if len(line) == length + 1 and re.fullmatch(r"[\d,]+", line[1])]
        assert len(rows) == 8
        *scenes, last = [[int(cell.replace(",", "")) for cell in row[1:]] for row in rows]
        assert last == [sum(column) for column in zip(*scenes, strict=True)]


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"view": 1}, sl.errors.ArgumentError, "view: expected a View"),
        ({"technique": "nothing"}, sl.errors.UnknownNameError, "nothing"),
        ({"technique": 3}, sl.errors.ArgumentError, "technique: expected a name"),
        ({"memory": "4 parsecs"}, sl.errors.UnknownNameError, "memory: unknown unit"),
        ({"memory": 10}, sl.errors.ArgumentError, "memory: expected at least"),
        ({"memory": "1 GiB"}, sl.errors.ArgumentError, "memory: expected at most 256 MiB, got 1 GiB"),
        ({"memory": 1000, "formats": ["moment:f32"]}, sl.errors.ArgumentError, "memory: 1 map"),
        ({"resolution": 64}, sl.errors.ArgumentError, "memory, resolution: expected one of both"),
        ({"memory": None, "resolution": 0}, sl.errors.ArgumentError, "resolution: expected"),
        ({"memory": None, "resolution": 10_000}, sl.errors.ArgumentError, "resolution: expected at most 8192"),
        ({"kernel": 4}, sl.errors.ArgumentError, "kernel: expected an odd number of texels from 1 to 31, got 4"),
        ({"kernel": 33}, sl.errors.ArgumentError, "kernel: expected an odd"),
        ({"kernel": 2.5}, sl.errors.ArgumentError, "kernel: expected"),
        ({"formats": ["variance:f8"]}, sl.errors.UnknownNameError, "formats: unknown formats 'variance:f8'"),
        ({"formats": []}, sl.errors.ArgumentError, "formats: expected at least one format"),
        ({"formats": ["depth:pcf", "depth:pcf"]}, sl.errors.ArgumentError, "formats: 'depth:pcf' is given more"),
        ({"formats": 7}, sl.errors.ArgumentError, "formats: expected"),
        ({"reduction": 1.0}, sl.errors.ArgumentError, "reduction: expected a share of the light"),
        ({"reduction": -0.1}, sl.errors.ArgumentError, "reduction: expected"),
        ({"renderer": "fast"}, sl.errors.UnknownNameError, "renderer"),
        ({"progress": 1}, sl.errors.ArgumentError, "progress"),
    ],
)
def test_bad_input(robots, change, error, said):
    arguments = {"view": robots, "technique": "uniform", "memory": "64 KiB", "renderer": "cpu", "progress": False}
    with pytest.raises(error, match=said):
        sl.prefiltered_maps(**{**arguments, **change})


def test_several_lights_are_taken_one_by_one(robots):
    both = sl.View(robots.scene, robots.camera, (robots.light, sl.DirectionalLight((0, -1, 0.1))), size=SIZE)
    with pytest.raises(sl.errors.ArgumentError, match="view: expected one light, got 2"):
        found_in(both)
    with pytest.raises(sl.errors.UnknownNameError, match="format: unknown format"):
        found_in(robots, formats="depth:pcf").mask("depth:nearest")
