"""advise: views and their names, failures, bad input, and views that show nothing."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from advice_support import SETS, SIZE, advise, made_view

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError, UnsupportedError
from shadowlab.experiments import advise as advice_module
from shadowlab.experiments.measures import MEASURES, docs, measure_of
from shadowlab.experiments.tried import default_techniques
from shadowlab.scene import view as view_module
from shadowlab.scene.kept import Kept

ONE_PIXEL = 1.0 / (SIZE[0] * SIZE[1])


@pytest.fixture(scope="module")
def view():
    return made_view()


# ---- views


def test_labels_tell_the_light_and_its_angle_to_the_view(view):
    scene, camera, _ = view
    lights = [sl.DirectionalLight((0, -1, -1)), sl.DirectionalLight((1, -1, 0)), sl.DirectionalLight((1, -1, 0))]
    found = advise((scene, camera, lights), techniques="uniform", memory=4096)
    angle = math.degrees(math.acos(np.dot(camera.forward, (0, -1, -1)) / math.sqrt(2)))
    labels = [one.label for one in found.views]
    assert labels[0] == f"light 45° up, {angle:.0f}° to the view"
    assert labels[1].endswith("(1)")
    assert labels[2].endswith("(2)")
    np.testing.assert_allclose(found.runs["light_elevation"], math.pi / 4)
    np.testing.assert_allclose(found.runs["light_angle"].iloc[0], math.radians(angle))


def test_every_camera_is_taken_with_every_light(view):
    scene, camera, lights = view
    other = sl.Camera.look_at((5, 3, 0), (0, 0, 0), aspect=1.25, near=1.0, far=20.0)
    found = advise((scene, [camera, other], lights), techniques="uniform", memory=4096)
    assert [one.label for one in found.views] == ["camera 1, noon", "camera 1, low", "camera 2, noon", "camera 2, low"]
    named = advise((scene, {"front": camera, "side": other}, lights["low"]), techniques="uniform", memory=4096)
    assert [one.label for one in named.views] == ["front", "side"]
    single = advise((scene, {"front": camera}, lights["low"]), techniques="uniform", memory=4096)
    assert [one.label for one in single.views] == ["front"]


def test_truth_is_traced_once_a_view_and_the_eye_view_drawn_once_a_camera(view, monkeypatch):
    from shadowlab import _core

    calls = []
    real = _core.trace_shadow_mask
    monkeypatch.setattr(_core, "trace_shadow_mask", lambda *a, **k: calls.append("truth") or real(*a, **k))

    class Counting:
        inner = sl.Renderer("cpu")
        backend, adapter, shadow_map, shadow_mask = "cpu", "x", inner.shadow_map, inner.shadow_mask

        def gbuffer(self, *a, **k):
            calls.append("eye")
            return self.inner.gbuffer(*a, **k)

    monkeypatch.setattr(view_module, "KEPT_VIEWS", Kept(1 << 30))
    advise(view, renderer=Counting())
    assert (calls.count("truth"), calls.count("eye")) == (2, 1)


@pytest.mark.parametrize("kind", ["spot", "point"])
def test_lights_with_a_place(view, kind):
    scene, camera, _ = view
    light = (
        sl.PointLight((0.5, 4, 0.2), range=20)
        if kind == "point"
        else sl.SpotLight((0.5, 4, 0.2), (0, -1, 0), cone_angle=1.2, range=20)
    )
    found = advise((scene, camera, light), techniques=None, memory="96 KiB")
    assert "tsm" not in set(found.table["technique"])
    # A plane that the light cannot see is the one thing that fails.
    assert set(found.table[found.table["failure"] != ""]["technique"]) <= {"plane_optimal"}
    assert found.table.set_index("technique").loc["uniform", "maps"] == (6 if kind == "point" else 1)
    assert found.views[0].label.startswith(f"{kind} light ")
    assert "several kinds" not in found.verdict
    mixed = advise((scene, camera, [sl.DirectionalLight((1, -1, 0)), light]), techniques="uniform", memory="96 KiB")
    assert f"Lights are of several kinds, directional and {kind}, and share the resolution" in mixed.verdict


def test_a_light_parallel_to_the_view_is_told(view):
    scene, camera, _ = view
    lights = {"side": sl.DirectionalLight((1, -0.5, 0)), "behind": sl.DirectionalLight(camera.forward)}
    found = advise((scene, camera, lights), techniques=["uniform", "lispsm"])
    assert "lispsm does not warp in behind (the light runs along the view): its map is a uniform one." in found.verdict
    assert found.runs.query("view == 'behind'")["light_angle"].abs().max() < 1e-7
    assert np.isfinite(found.runs["error"]).all()


def test_a_camera_that_sees_nothing_is_left_out_and_told(view):
    scene, camera, lights = view
    away = sl.Camera.look_at((0, 6, 0), (0, 12, 0.1), aspect=1.25, near=1.0, far=20.0)
    found = advise((scene, {"front": camera, "sky": away}, lights["noon"]), techniques=SETS[:2])
    alone = advise((scene, camera, lights["noon"]), techniques=SETS[:2])
    assert found.table["error_mean"].tolist() == alone.table["error_mean"].tolist()
    assert "The view sky has nothing to compare and is left out." in found.verdict
    nothing = advise((scene, away, lights), techniques=SETS[:2])
    assert nothing.verdict == "Nothing could be compared: the camera sees nothing of the scene."
    assert nothing.table["rank"].isna().all()
    assert nothing.table["failure"].str.contains("no camera sees anything").all()
    with pytest.raises(UnsupportedError, match="Nothing could be compared"):
        nothing.best  # noqa: B018 - a property that raises
    assert "Nothing could be compared" in repr(nothing)
    assert nothing.figure()


# ---- failures


class Broken:
    """Serves no light from the side."""

    name, settings = "broken", {}

    def parameterize(self, scene, camera, light, *, resolution=1024):
        if abs(np.asarray(light.direction)[0]) > 0.5:
            raise sl.errors.UnsupportedError("no light from the side, please")
        return sl.technique("lispsm").parameterize(scene, camera, light, resolution=resolution)


def test_failures_become_rows_and_are_ranked_last(view, tmp_path):
    found = advise(view, techniques={"b": Broken(), "uniform": "uniform"})
    for _, table in found.table.groupby("memory"):
        assert table["technique"].tolist() == ["uniform", "b"]
        assert table["failure"].tolist()[1] == "no light from the side, please (in 1 of 2 views: low)"
        assert table["rank"].isna().tolist() == [False, True]
    runs = found.runs.query("technique == 'b'").set_index("view")
    assert runs.loc["noon", "error"].notna().all()
    assert runs.loc["low", "error"].isna().all()
    assert "b failed: no light from the side, please (in 1 of 2 views: low)." in found.verdict
    # Where it serves it takes part.
    assert found.best_for(view="noon").candidate == "b"
    assert found.best_for(view="low").candidate == "uniform"
    with pytest.raises(ArgumentError, match="row: expected one with a number, got one that failed: no light"):
        found.reproduce(1)
    data = json.loads(found.save(tmp_path).with_name("advice.json").read_text(encoding="utf-8"))
    assert data["table"][1]["error_mean"] is None
    assert "failed" in repr(found)
    assert found.figure()


def test_where_all_fail_it_is_said(view):
    found = advise((view[0], view[1], view[2]["low"]), techniques={"b": Broken()})
    assert found.verdict == "No candidate gave a result. b failed: no light from the side, please."
    with pytest.raises(UnsupportedError, match="no candidate gave a number"):
        found.best_for(memory="16 KiB")
    assert found.figure()


def test_candidates_without_a_few_texels_are_told(view):
    found = advise(view, memory=600, techniques=["uniform", "z_partition:count=4"])
    rows = found.table.set_index("technique")
    assert rows.loc["uniform", "resolution"] == 12
    assert rows.loc["z_partition:count=4", "failure"] == (
        "memory: 4 maps of 8 x 8 texels, the smallest drawn, take 1,024 bytes, more than the 600 there are"
    )
    assert "z_partition:count=4 failed: memory: 4 maps" in found.verdict


def test_a_defect_is_not_hidden_and_ctrl_c_is_a_keyboard_interrupt(view, capsys):
    for error in (ZeroDivisionError, KeyboardInterrupt):

        class Defect:
            name, settings = "defect", {}

            def parameterize(self, *_, __error=error, **__):
                raise __error

        with pytest.raises(error):
            advise(view, techniques={"x": Defect()}, progress=True)
    assert capsys.readouterr().err.strip() == ""


def test_matrices_serve_one_view(view):
    scene, camera, lights = view
    p = sl.technique("lispsm").parameterize(scene, camera, lights["noon"], resolution=64)
    mine = sl.Parameterization.from_matrix(p.matrix)
    with pytest.raises(ArgumentError, match="techniques: 'mine' is matrices made for one view, there are 2"):
        advise(view, techniques={"mine": mine})
    one = (scene, camera, lights["noon"])
    found = advise(one, techniques={"mine": mine, "uniform": "uniform", "flat": np_matrix()}, memory="16 KiB")
    assert found.table["technique"].tolist()[:2] == ["mine", "uniform"]
    # What is no map of this light is not ranked, and is told.
    assert found.table["rank"].isna().tolist() == [False, False, True]
    assert "flat is left out of the ranking: not a map of this light" in found.verdict
    names: dict = {}
    source = found.reproduce(0).replace("scene = ...", "scene = given_scene")
    names["given_scene"] = scene
    exec(compile(source, "snippet", "exec"), names)
    assert abs(names["error_mean"] - found.table["error_mean"][0]) <= ONE_PIXEL


def np_matrix():
    """A map of another light."""
    return sl.Parameterization.from_matrix(np.diag([0.2, 0.2, 0.02, 1.0]))


# ---- arguments


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({"memory": 100}, ArgumentError, "memory: expected at least 256 bytes"),
        ({"memory": 0}, ArgumentError, "memory: expected at least 256 bytes"),
        ({"memory": -1}, ArgumentError, "memory"),
        ({"memory": math.inf}, ArgumentError, "memory"),
        ({"memory": math.nan}, ArgumentError, "memory"),
        ({"memory": "much"}, ArgumentError, "memory: expected bytes such as 4194304"),
        ({"memory": "4 XiB"}, UnknownNameError, "memory: unknown unit 'XiB'.*MiB"),
        ({"memory": True}, ArgumentError, "memory: expected bytes"),
        ({"memory": None}, ArgumentError, "memory: expected bytes"),
        ({"memory": []}, ArgumentError, "memory: expected at least one budget"),
        ({"memory": ["1 MiB", 2**20]}, ArgumentError, "memory: 1 MiB comes twice"),
        ({"error": "typo"}, UnknownNameError, "error: unknown error 'typo'; expected one of misclassified, worst, p95"),
        ({"error": 3}, ArgumentError, "error: expected one of misclassified"),
        ({"over": "median"}, UnknownNameError, "over: unknown choice 'median'; expected one of mean, worst"),
        ({"over": None}, ArgumentError, "over: expected one of"),
        ({"techniques": []}, ArgumentError, "techniques: expected at least one"),
        ({"techniques": [3]}, ArgumentError, "techniques: expected a name"),
        ({"techniques": ["unifrom"]}, UnknownNameError, "uniform"),
        ({"techniques": ["uniform", "uniform"]}, ArgumentError, "'uniform' comes twice"),
        ({"size": (0, 3)}, ArgumentError, "size"),
        ({"bias": 0.1}, ArgumentError, "bias: expected a Bias"),
        ({"filter": "vsm"}, UnknownNameError, "filter"),
        ({"renderer": 3}, ArgumentError, "renderer"),
    ],
)
def test_wrong_arguments_are_said_before_any_work(view, monkeypatch, keywords, error, message):
    monkeypatch.setattr(advice_module, "outcomes_of", lambda *_: pytest.fail("worked before it looked"))
    with pytest.raises(error, match=message):
        advise(view, **keywords)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (0, "box.ply", "scene: expected a Scene, got str"),
        (1, [], "cameras: expected at least one, got none"),
        (1, {}, "cameras: expected at least one"),
        (1, np.eye(4), "cameras: expected a Camera, got ndarray"),
        (1, None, "cameras: expected a Camera, several, or a dict of them, got None"),
        (2, [], "lights: expected at least one"),
        (2, (0.3, -1, 0.1), "lights: expected a DirectionalLight, a SpotLight or a PointLight, got float"),
        (2, {"a": 3}, "lights: expected .* for 'a', got int"),
        (2, {" ": sl.DirectionalLight((0, -1, 0))}, "lights: expected labels with letters"),
        (2, {1: sl.DirectionalLight((0, -1, 0)), "1": sl.DirectionalLight((0, -1, 1))}, "lights: expected text, got 1"),
    ],
)
def test_views_of_another_type_are_told(view, place, value, message):
    given = list(view)
    given[place] = value
    with pytest.raises(ArgumentError, match=message):
        advise(given)


def test_errors_are_a_registry(view):
    assert set(docs()) == {"misclassified", "worst", "p95", "mean", "undersampled", "perspective"}
    assert all(m.direction == "lower" and m.unit in ("share", "px") for m in MEASURES)
    assert measure_of("p95").text(3.14159) == "3.14 px"


def test_the_default_set_serves_the_lights_and_runs(view):
    lights = {"directional": 1, "spot": 1}
    assert "tsm" in default_techniques({"directional": 1})
    assert "tsm" not in default_techniques(lights)
    found = advise(view, techniques=None, memory="16 KiB", predict=None)
    assert (found.table["failure"] == "").all()
    assert found.table["technique"].tolist().count("uniform") == 1
    assert {2, 3, 4} <= set(found.table["maps"])
    assert (found.table["technique"] == found.table["spec"]).all()


@pytest.mark.parametrize("count", [1, 2])
def test_figures_for_one_or_several_views_and_budgets(view, count):
    import matplotlib as mpl

    mpl.use("Agg")
    scene, camera, lights = view
    some = dict(list(lights.items())[:count])
    panels = {(1, 1): 1, (1, 2): 1, (2, 1): 1, (2, 2): 3}
    for budgets in (1, 2):
        found = advise((scene, camera, some), memory=["16 KiB", "48 KiB"][:budgets])
        figure = found.figure()
        assert len(figure.axes) == panels[count, budgets]
        for ax in figure.axes:
            assert ax.get_xlabel() or ax.get_xticklabels()
        labels = [ax.get_ylabel() for ax in figure.axes] + [ax.get_xlabel() for ax in figure.axes]
        assert any("share of wrong pixels (%)" in label for label in labels)
        figure.canvas.draw()


def test_a_figure_of_many_candidates_has_as_many_lines_as_can_be_told_apart(view):
    from shadowlab.plot.advice import MOST_LINES, lines_of

    counts = range(2, 14)
    many = advise(view, memory="64 KiB", techniques=["uniform", *(f"z_partition:count={n}" for n in counts)], phases=1)
    lines = many.figure().axes[0].get_lines()
    assert len(lines) == MOST_LINES < len(many.candidates)
    looks = {(line.get_color(), line.get_marker(), line.get_linestyle()) for line in lines}
    assert len(looks) == MOST_LINES
    ranked = [one.candidate for one in many.standings if one.ranked]
    assert lines_of(many, many.standings) == {
        "uniform",
        *[name for name in ranked if name != "uniform"][: MOST_LINES - 1],
    }
