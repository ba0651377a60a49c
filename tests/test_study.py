"""compare: the table and its pictures against the parts they are made of; failures, labels, bad input, Ctrl-C."""

from __future__ import annotations

import json
import math
import warnings

import numpy as np
import pandas as pd
import pytest
import trimesh

import shadowlab as sl
from shadowlab.experiments import compare as study_module
from shadowlab.experiments.arguments import picture_size
from shadowlab.experiments.columns import TABLES
from shadowlab.experiments.compare import compare

SQUARE = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
FACES = [[0, 2, 1], [0, 3, 2]]


@pytest.fixture(scope="module")
def view():
    scene = sl.Scene.from_arrays(4 * SQUARE, FACES) + sl.Scene.from_arrays(SQUARE + np.array([0, 1.0, 0]), FACES)
    camera = sl.Camera.look_at((0, 6, 5), (0, 0, 0), aspect=1.25, near=1.0, far=20.0)
    return scene, camera, sl.DirectionalLight((0.3, -1, 0.1))


@pytest.fixture(scope="module")
def study(view):
    return compare(*view, ["uniform", "lispsm"], resolution=[32, 128], size=(80, 64), progress=False)


def test_one_row_a_technique_and_resolution(study):
    table = study.table
    assert list(table.columns) == list(TABLES["compare"])
    assert list(zip(table["technique"], table["resolution"], strict=True)) == [
        ("uniform", 32), ("uniform", 128), ("lispsm", 32), ("lispsm", 128),
    ]  # fmt: skip
    assert (table["failure"] == "").all()
    assert (table[["fit_us", "map_ms", "lookup_ms"]] > 0).all(axis=None)


def test_the_table_counts_what_the_pictures_show(study, view):
    truth = sl.trace.shadow_mask(*view, size=(80, 64))
    np.testing.assert_array_equal(study.truth, truth)
    for row in study.table.to_dict("records"):
        key = (row["technique"], row["resolution"])
        image, mask = study.differences[key], study.masks[key]
        assert row["false_shadow"] == (image == 1).sum()
        assert row["false_light"] == (image == 2).sum()
        assert row["misclassified"] == row["false_shadow"] + row["false_light"]
        assert row["compared"] == (image >= 0).sum()
        assert math.isclose(row["share"], row["misclassified"] / row["compared"])
        seen = truth >= 0
        np.testing.assert_array_equal(image[seen] == 1, (truth[seen] == 1) & (mask[seen] < 0.5))
        np.testing.assert_array_equal(image[seen] == 2, (truth[seen] == 0) & (mask[seen] >= 0.5))


def test_masks_and_maps_are_the_renderers(study, view):
    scene, camera, light = view
    renderer = sl.Renderer()
    samples = sl.View(scene, camera, light, size=(80, 64)).samples(renderer=renderer)
    p = sl.technique("lispsm").parameterize(scene, camera, light, resolution=128, samples=samples)
    np.testing.assert_array_equal(study.maps["lispsm", 128], renderer.shadow_map(scene, p, resolution=128))
    mask = renderer.shadow_mask(scene, camera, light, p, resolution=128, size=(80, 64))
    np.testing.assert_array_equal(study.masks["lispsm", 128], mask)


def test_finer_maps_have_fewer_errors(study):
    wrong = study.table.set_index(["technique", "resolution"])["misclassified"]
    assert wrong["uniform", 32] > wrong["uniform", 128]


def test_a_label_alone_names_a_run_where_it_is_the_only_one(view, study):
    single = compare(*view, "uniform", resolution=32, size=(20, 16), progress=False)
    assert single.masks["uniform"].shape == (16, 20)
    with pytest.raises(KeyError, match="'lispsm', 128"):
        study.masks["lispsm"]
    with pytest.raises(KeyError, match="tsm"):
        single.masks["tsm"]


def test_techniques_come_in_any_form(view):
    scene, camera, light = view
    p = sl.technique("uniform").parameterize(scene, camera, light, resolution=64)
    given = sl.Parameterization.from_matrix(p.matrix)
    study = compare(
        *view, {"a": "uniform", "b": sl.technique("lispsm"), "c": given}, resolution=64, size=(20, 16), progress=False
    )
    assert list(study.table["technique"]) == ["a", "b", "c"]
    np.testing.assert_array_equal(study.masks["a"], study.masks["c"])
    assert study.table["fit_us"].isna().tolist() == [False, False, True]
    assert "nan" not in study.verdict


def test_one_failing_technique_leaves_the_others(view, monkeypatch):
    class Broken:
        name, settings = "broken", {}

        def parameterize(self, *_, **__):
            raise sl.errors.UnsupportedError("no such light here")

    study = compare(
        *view, {"broken": Broken(), "uniform": "uniform"}, resolution=[32, 64], size=(20, 16), progress=False
    )
    assert study.table["failure"].tolist() == ["no such light here"] * 2 + [""] * 2
    assert study.table["misclassified"].isna().tolist() == [True, True, False, False]
    assert list(study.masks) == [("uniform", 32), ("uniform", 64)]
    assert study.verdict.count("broken failed: no such light here.") == 1
    assert "failed" in repr(study)


def test_a_defect_is_not_hidden_as_a_failure(view):
    class Defect:
        name, settings = "defect", {}

        def parameterize(self, *_, **__):
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        compare(*view, {"x": Defect()}, resolution=32, size=(10, 8), progress=False)


def test_ctrl_c_is_a_keyboard_interrupt(view, capsys):
    class Impatient:
        name, settings = "impatient", {}

        def parameterize(self, *_, **__):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compare(*view, {"x": Impatient()}, resolution=32, size=(10, 8))
    assert capsys.readouterr().err.strip() == ""  # no half-drawn bar, no traceback


def test_truth_is_traced_once(view, monkeypatch):
    from shadowlab import _core

    calls = []
    real = _core.trace_shadow_mask
    monkeypatch.setattr(_core, "trace_shadow_mask", lambda *a, **k: calls.append(1) or real(*a, **k))
    sl.View(*view, size=(10, 8)).clear()
    compare(*view, resolution=[16, 32], size=(10, 8), progress=False)
    assert len(calls) == 1


def test_without_truth_there_are_pictures_but_no_errors(view):
    study = compare(*view, "uniform", resolution=32, size=(10, 8), truth=False, progress=False)
    assert study.truth is None
    assert study.table["misclassified"].isna().all()
    assert len(study.masks) == 1
    assert len(study.differences) == 0


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"resolution": 0}, "resolution: expected a whole number above 0, got 0"),
        ({"resolution": -5}, "resolution"),
        ({"resolution": 3.5}, "resolution"),
        ({"resolution": True}, "resolution"),
        ({"resolution": []}, "resolution: expected at least one"),
        ({"resolution": [64, 32, 64]}, "resolution: 64 comes twice"),
        ({"resolution": "1024"}, "resolution"),
        ({"size": (0, 0)}, "size"),
        ({"size": (8, -1)}, "size"),
        ({"size": 8}, "size: expected .width, height."),
        ({"size": (8, 8, 8)}, "size"),
        ({"techniques": []}, "techniques: expected at least one"),
        ({"techniques": ["uniform", "uniform"]}, "'uniform' comes twice"),
        ({"techniques": [3]}, "expected a name, a Technique or a Parameterization, got int"),
        ({"techniques": ["lispsm:near"]}, "lispsm:near"),
        ({"techniques": None}, "techniques: expected names.*got None"),
        ({"techniques": {}}, "techniques: expected at least one"),
        ({"techniques": 7}, "techniques: expected names.*got 7"),
        ({"filter": None}, "filter: expected one of nearest, bilinear, pcf, tent, poisson"),
        ({"bias": 0.01}, "bias: expected a Bias, got float; try sl.Bias"),
        ({"renderer": 3}, 'renderer: expected a Renderer, "cpu", "gpu" or "auto", got int'),
    ],
)
def test_wrong_arguments_are_said_before_any_work(view, monkeypatch, keywords, message):
    monkeypatch.setattr(study_module, "View", lambda *_: pytest.fail("worked before it looked"))
    arguments = {"resolution": 32, "size": (10, 8), "techniques": ["uniform"], "progress": False} | keywords
    with pytest.raises(sl.errors.ArgumentError, match=message):
        compare(*view, arguments.pop("techniques"), **arguments)


def test_an_unknown_technique_lists_those_there_are(view):
    with pytest.raises(sl.errors.UnknownNameError, match="uniform"):
        compare(*view, ["unifrom"], size=(10, 8), progress=False)


def test_unknown_filters_and_renderers_list_those_there_are(view):
    with pytest.raises(
        sl.errors.UnknownNameError,
        match="filter: unknown filter 'vsm'; expected one of nearest, bilinear, pcf, tent, poisson",
    ):
        compare(*view, filter="vsm", size=(10, 8), progress=False)
    with pytest.raises(sl.errors.UnknownNameError, match="cpu, gpu"):
        compare(*view, renderer="cuda", size=(10, 8), progress=False)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (0, trimesh.creation.box(), r"scene: expected a Scene, got Trimesh; sl.Scene.from_trimesh\(it\)"),
        (0, "box.ply", r"scene: expected a Scene, got str; sl.load_scene\(it\)"),
        (0, None, "scene: expected a Scene, got NoneType"),
        (1, np.eye(4), "camera: expected a Camera, got ndarray; sl.Camera.look_at"),
        (2, (0.3, -1, 0.1), "light: expected a DirectionalLight, a SpotLight or a PointLight, got tuple"),
    ],
)
def test_things_of_another_type_are_told_with_what_makes_one(view, place, value, message):
    given = list(view)
    given[place] = value
    with pytest.raises(sl.errors.ArgumentError, match=message):
        compare(*given, size=(10, 8), progress=False)


def test_a_renderer_by_name(view):
    assert compare(*view, "uniform", renderer="cpu", resolution=32, size=(10, 8), progress=False).backend == "cpu"


@pytest.mark.parametrize("aspect", [1.0, 16 / 9, 4 / 3, 1.25, 21 / 9, 9 / 16, np.pi, 1.234567, 30.0, 1 / 30])
def test_the_size_that_nobody_chose_has_the_cameras_aspect(aspect):
    width, height = picture_size(aspect)
    assert abs(width * height / 1024**2 - 1) < 0.05
    # Exact for ratios of small whole numbers, else within a pixel of the shorter side.
    exact = aspect not in (np.pi, 1.234567)
    assert width / height == (aspect if exact else pytest.approx(aspect, rel=1 / min(width, height)))


def test_sizes_of_common_cameras():
    assert (picture_size(1.0), picture_size(16 / 9)) == ((1024, 1024), (1360, 765))


def test_a_size_that_stretches_the_picture_warns(view):
    with pytest.warns(sl.errors.ShadowlabWarning, match=r"size: 40 x 40 stretches.*aspect 1.25"):
        compare(*view, "uniform", resolution=32, size=(40, 40), truth=False, progress=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compare(*view, "uniform", resolution=32, size=(126, 100), truth=False, progress=False)


def test_without_a_size_the_picture_is_the_cameras(view):
    study = compare(*view, "uniform", resolution=32, truth=False, progress=False)
    assert study.size == picture_size(1.25)
    assert study.masks["uniform"].shape == study.size[::-1]


def test_study_is_frozen(study):
    with pytest.raises(AttributeError):
        study.size = (1, 1)


def test_texts_and_figure(study):
    import matplotlib as mpl

    mpl.use("Agg")
    text = repr(study)
    assert study.verdict in text
    assert "uniform" in text
    html = study._repr_html_()
    assert html.count("<img") == 4
    figure = study.figure()
    assert len(figure.axes) == 12


def test_csv_and_json_hold_the_table(study, tmp_path):
    study.save(tmp_path)
    read = pd.read_csv(tmp_path / "results.csv", keep_default_na=False)
    assert list(read.columns) == list(TABLES["compare"])
    assert read["misclassified"].tolist() == study.table["misclassified"].tolist()
    np.testing.assert_allclose(read["share"].astype(float), study.table["share"], rtol=1e-15)
    text = (tmp_path / "results.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert [run["misclassified"] for run in data["runs"]] == study.table["misclassified"].tolist()
    assert data["verdict"] == study.verdict
    assert data["camera"]["near"] == study.camera.near
    matrices = [np.array(run["matrices"]) for run in data["runs"]]
    for run, matrix in zip(study.runs, matrices, strict=True):
        np.testing.assert_array_equal(matrix, run.parameterization.matrices)


def test_failed_rows_survive_csv_and_json(view, tmp_path):
    class Broken:
        name, settings = "broken", {"near": math.inf}

        def parameterize(self, *_, **__):
            raise sl.errors.UnsupportedError('a, "quoted"\nreason <b>')

    study = compare(*view, {"broken": Broken()}, resolution=32, size=(10, 8), progress=False)
    page = study.save(tmp_path).read_text(encoding="utf-8")
    assert "reason <b>" not in page
    assert "reason &lt;b&gt;" in page
    read = pd.read_csv(tmp_path / "results.csv")
    assert read["failure"].tolist() == ['a, "quoted" reason <b>']
    assert read["misclassified"].isna().all()
    run = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))["runs"][0]
    assert (run["misclassified"], run["settings"]["near"]) == (None, "inf")


def test_the_python_of_the_report_gives_the_same_numbers():
    scene = sl.library.scene("skylight")
    study = compare(
        scene, scene.camera, scene.light, ["uniform", "lispsm"],
        resolution=[64, 128], size=(48, 27), filter="bilinear", bias=sl.Bias(world=0.01), progress=False,
    )  # fmt: skip
    from shadowlab.reports.reproduce import python_snippet

    names: dict = {}
    exec(compile(python_snippet(study, study.runs), "snippet", "exec"), names)
    again = names["study"]
    for key in ("misclassified", "false_shadow", "false_light", "undecided", "settings"):
        assert again.table[key].tolist() == study.table[key].tolist()


def test_the_python_of_a_given_matrix_gives_the_same_numbers(view):
    from shadowlab.reports.reproduce import command_line, python_snippet

    scene, camera, light = view
    p = sl.technique("lispsm").parameterize(scene, camera, light, resolution=64)
    given = sl.Parameterization.from_matrix(p.matrix)
    study = compare(scene, camera, light, {"engine": given}, resolution=64, size=(40, 32), progress=False)
    assert command_line(study, study.runs) is None  # arrays and matrices have no command line
    snippet = python_snippet(study, study.runs)
    assert "scene = ...  # the scene of this study" in snippet
    names: dict = {"given_scene": scene}
    exec(compile(snippet.replace("scene = ...", "scene = given_scene"), "snippet", "exec"), names)
    np.testing.assert_array_equal(names["study"].masks["engine"], study.masks["engine"])


@pytest.mark.parametrize("kind", ["spot", "point"])
def test_other_lights_are_written_down(kind):
    from shadowlab.reports.reproduce import light_python

    light = (
        sl.SpotLight((1, 2, 3), (0.1, -1, 0.2), cone_angle=0.7, range=9.5)
        if kind == "spot"
        else sl.PointLight((1, 2, 3), range=4)
    )
    names: dict = {"sl": sl}
    exec(light_python(light), names)
    assert names["light"] == light
