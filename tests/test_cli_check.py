"""`shadowlab check`: bounds that hold and that do not, matrices of an engine, JUnit's XML, mistakes by their lines."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from cli_support import fails_in

import shadowlab as sl
from shadowlab.cli.check_config import PATH_COLUMNS, VIEW_COLUMNS, Bound
from shadowlab.cli.check_path import CameraPath
from shadowlab.cli.check_run import value_of_bound
from shadowlab.experiments.columns import COLUMNS
from shadowlab.reports.junit import Case, junit_xml

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "check.md"
SMALL = 'scene = "@robots"\nsize = "64x36"\nresolution = 64\nbackend = "cpu"\n'


@pytest.fixture
def check(run_config):
    """Runs `shadowlab check` on a text."""
    return functools.partial(run_config, "check", "b.toml")


def test_the_configuration_of_the_page_passes_and_its_xml_has_a_case_for_each_bound(check):
    text = re.findall(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)[0]
    status, out, err = check(text, "--junit", "out/shadows.xml")
    assert (status, err) == (0, ""), out
    assert "All of 9 bounds hold" in out
    top = ElementTree.parse("out/shadows.xml").getroot()
    assert (top.tag, top.attrib["tests"], top.attrib["failures"], top.attrib["errors"]) == ("testsuites", "9", "0", "0")
    suites = top.findall("testsuite")
    assert [suite.attrib["name"] for suite in suites] == ["robots at noon", "walking through the robots"]
    # What Jenkins' junit-10.xsd has for these elements.
    of_suites = {"name", "tests", "failures", "errors", "time"}
    assert set(top.attrib) == of_suites
    assert all(set(suite.attrib) == {*of_suites, "skipped"} for suite in suites)
    cases = top.findall("testsuite/testcase")
    assert len(cases) == 9
    assert all(set(case.attrib) == {"classname", "name", "time"} and not len(case) for case in cases)
    assert ("uniform:stable=true at 512", "drift_max at most 0.01 texels") in [
        (case.attrib["classname"], case.attrib["name"]) for case in cases
    ]


def test_the_workflow_of_the_page_runs_that_command():
    page = DOCUMENT.read_text(encoding="utf-8")
    workflow = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[0]
    assert "      - run: shadowlab check shadows.toml --junit shadows.xml\n" in workflow
    assert "$ shadowlab check shadows.toml --junit shadows.xml\n" in page


def test_a_broken_bound_is_exit_status_1_and_the_values_are_those_of_evaluate(check):
    scene = sl.library.scene("robots")
    view = sl.View(scene, scene.camera, scene.light, size=(64, 36))
    row = sl.evaluate(view, "uniform", 64, renderer="cpu").row()
    wrong, texel = row["misclassified"], row["texel_max"]
    assert wrong > 0
    text = f'{SMALL}technique = "uniform"\nbounds.misclassified = {{ max = %d }}\n'
    text += f"bounds.texel_max = {{ min = {texel!r}, max = {texel!r} }}\n"
    status, out, err = check(text % wrong)
    assert (status, err) == (0, "")
    status, out, err = check(text % (wrong - 1), "--junit", "x.xml")
    assert (status, err) == (1, "")
    said = f"misclassified: expected at most {wrong - 1} px, got {wrong} px"
    assert f"@robots, uniform at 64²: {said}\n" in out
    assert "1 of 2 bounds broken" in out
    failures = ElementTree.parse("x.xml").findall("testsuite/testcase/failure")
    assert [(one.attrib["message"], one.text) for one in failures] == [(said, said)]


def test_matrices_of_an_engine_are_held_like_the_technique_that_made_them(check, tmp_path):
    scene = sl.library.scene("robots")
    camera, light = scene.camera, scene.light
    view = sl.View(scene, camera, light, size=(64, 36))
    for i, each in enumerate(CameraPath(3, (0.03, 0.0, 0.01), 0.01).cameras(camera, "y")):
        p = sl.technique("uniform").parameterize(scene, each, light, resolution=64)
        np.save(tmp_path / f"f{i:02}.npy", p.to(sl.Convention.opengl()))
    wrong = sl.evaluate(view, "uniform", 64, metrics=["misclassified"], renderer="cpu").row()["misclassified"]
    text = f'{SMALL}technique = "matrix:file=f00.npy,convention=opengl"\n'
    text += f"bounds.misclassified = {{ min = {wrong}, max = {wrong} }}\n"
    assert check(text)[0] == 0
    # Frame by frame the engine's matrices drift as much as the technique that wrote them.
    turn = np.degrees(0.01)
    path = f"path = {{ frames = 3, step = [0.03, 0, 0.01], turn-deg = {turn} }}\nbounds.drift_max = {{ max = 0 }}\n"
    of_both = 'technique = { ours = "uniform", theirs = "matrix:file=f{frame:02}.npy,convention=opengl" }\n'
    status, out, _ = check(f"{SMALL}{of_both}{path}")
    got = [float(line.split()[-2]) for line in out.splitlines() if ": drift_max: expected" in line]
    assert status == 1
    assert ", ours at 64²: drift_max" in out
    assert ", theirs at 64²: drift_max" in out
    np.testing.assert_allclose(got[1], got[0], rtol=1e-6)
    assert got[0] > 0.01


def test_cameras_of_an_engine_are_those_of_its_matrices(check, tmp_path):
    scene = sl.library.scene("robots")
    step = (0.03, 0.0, 0.01)
    opengl = np.diag([1.0, 1, 2, 1]) + np.eye(4)[2][:, None] * [0, 0, 0, -1]
    for i, camera in enumerate(CameraPath(3, step, 0.0).cameras(scene.camera, "y")):
        np.save(tmp_path / f"v{i}.npy", camera.view)
        np.save(tmp_path / "p.npy", opengl @ camera.projection)
    bounds = 'technique = "uniform"\nbounds.drift_max.max = 0\nbounds.misclassified.max = 0\n'
    files = 'camera = { view = "v{frame}.npy", projection = "p.npy", convention = "opengl" }\npath = { frames = 3 }\n'
    said = []
    for text in (f"path = {{ frames = 3, step = {list(step)} }}\n", files):
        status, out, err = check(f"{SMALL}{bounds}{text}")
        assert (status, err) == (1, "")
        lines = [line.split() for line in out.splitlines() if ": expected at most" in line]
        said.append({line[4].rstrip(":"): float(line[-2]) for line in lines})
    by_step, by_files = said
    assert set(by_step) == {"drift_max", "misclassified"}
    # Far planes come back up to rounding, which may move a pixel that lies on an edge.
    assert by_files["drift_max"] == pytest.approx(by_step["drift_max"], rel=1e-4)
    assert by_files["misclassified"] == pytest.approx(by_step["misclassified"], abs=1)


def test_a_technique_that_refuses_the_light_is_an_error_of_the_gate(check):
    text = f'{SMALL}technique = ["tsm", "uniform"]\nlight-position = [0, 4, 0]\nbounds.share = {{ max = 1 }}\n'
    status, out, err = check(text, "--junit", "x.xml")
    assert (status, err) == (1, "")
    assert "tsm at 64²: " in out
    assert "does not support a point light" in out
    top = ElementTree.parse("x.xml").getroot()
    assert (top.attrib["tests"], top.attrib["failures"], top.attrib["errors"]) == ("2", "0", "1")


def test_own_keys_go_before_those_at_the_top(check):
    text = f'{SMALL}technique = "uniform"\n[bounds]\nshare = {{ max = 0 }}\nmaps = {{ max = 1 }}\n'
    text += '[[check]]\nname = "a"\nbounds.share = { max = 1 }\n'
    text += '[[check]]\nname = "b"\nresolution = 32\ntechnique = "lispsm"\n'
    status, out, _ = check(text)
    assert status == 1
    rows = [line.split()[:4] for line in out.splitlines()[2:6]]
    assert rows == [
        ["a", "uniform", "64²", "share"], ["a", "uniform", "64²", "maps"], ["b", "lispsm", "32²", "share"],
        ["b", "lispsm", "32²", "maps"],
    ]  # fmt: skip
    assert "1 of 4 bounds broken" in out


GOOD = f'{SMALL}technique = "uniform"\nbounds.share = {{ max = 1 }}\n'
BAD = {
    "no scene": ("technique = 1\n", ":1: expected a key scene"),
    "unknown key": (f"{GOOD}resolutoin = 3\n", ":7: resolutoin: unknown key; did you mean 'resolution'?"),
    "unknown column": (
        f"{GOOD}bounds.shaer = {{}}\n", ":7: bounds.shaer: unknown key; did you mean 'share'? expected one of maps"
    ),
    "unknown side": (f"{GOOD}bounds.maps = {{ mx = 1 }}\n", ":7: bounds.maps.mx: unknown key; did you mean 'max'?"),
    "no side": (f"{GOOD}bounds.maps = {{}}\n", ":7: bounds.maps: expected max or min, got neither"),
    "a bare bound": (f"{GOOD}bounds.maps = 3\n", ":7: bounds.maps: expected a table such as { max = 0.02 }, got 3"),
    "a bound of words": (f'{GOOD}bounds.maps.max = "2"\n', ":7: bounds.maps.max: expected a number, got '2'"),
    "a bound without end": (f"{GOOD}bounds.maps.max = inf\n", ":7: bounds.maps.max: expected a finite number"),
    "crossed": (f"{GOOD}bounds.maps = {{ min = 2, max = 1 }}\n", ":7: bounds.maps: expected min up to max"),
    "no bounds": (f'{SMALL}technique = "uniform"\n', ":1: bounds: expected at least one bound"),
    "no technique": (f"{SMALL}bounds.maps.max = 1\n", ":1: technique: expected a technique"),
    "unknown technique": (GOOD.replace("uniform", "unifrom"), ":5: technique: ", "unifrom"),
    "label of nothing": (GOOD.replace('"uniform"', "{ a = 3 }"), ":5: technique.a: expected a technique such as"),
    "no labels": (GOOD.replace('"uniform"', "{}"), ":5: technique: expected a technique such as"),
    "all techniques": (GOOD.replace("uniform", "all"), ":5: technique: expected techniques by their names"),
    "missing matrix": (GOOD.replace("uniform", "matrix:file=no.npy"), ":5: technique: file: cannot read 'no.npy'"),
    "frame without a path of letters": (GOOD.replace("uniform", "matrix:file={frame:q}"), ":5: technique: "),
    "technique twice": (GOOD.replace('"uniform"', '["uniform", "uniform"]'), ":5: technique: 'uniform' comes twice"),
    "resolution a word": (GOOD.replace("= 64", '= "64"'), ":3: resolution: expected a whole number of 1 or more"),
    "size": (GOOD.replace("64x36", "64"), ":2: size: expected width x height"),
    "light of two": (f"{GOOD}light = [1, 2]\n", ":7: light: expected three numbers"),
    "zero light": (f"{GOOD}light = [0, 0, 0]\n", ":1: light: expected a direction"),
    "view": (f'{GOOD}view = "below"\n', ":7: view: ", "'below' is not one of 'along', 'above', 'against'"),
    "ground": (f"{GOOD}ground = 1\n", ":7: ground: expected true or false, got 1"),
    "fov a word": (f'{GOOD}fov-deg = "wide"\n', ":7: fov-deg: expected a number, got 'wide'"),
    "eye of tables": (f"{GOOD}eye = [[1]]\n", ":7: eye: expected a text, a number or a list of numbers"),
    "unknown scene": (GOOD.replace("@robots", "@robot"), ":1: scene: ", "robots"),
    "missing scene": (GOOD.replace("@robots", "no.glb"), ":1: scene: ", "no.glb"),
    "bias": (f'{GOOD}bias = "wrold=1"\n', ":7: bias: ", "wrold"),
    "filter": (f'{GOOD}filter = "vsm"\n', ":7: filter: unknown filter 'vsm'"),
    "phases missing": (f"{GOOD}bounds.misclassified_mean.max = 1\n", ":7: bounds.misclassified_mean: expected phases"),
    "path missing": (f"{GOOD}bounds.drift_max.max = 1\n", ":7: bounds.drift_max: expected a camera path"),
    "path unused": (f"{GOOD}path = {{ step = [1, 0, 0] }}\n", ":7: path: expected a bound on one of receivers"),
    "path that stands": (f"{GOOD}path.frames = 3\n", ":7: path: expected a camera that moves"),
    "path too long": (f"{GOOD}path = {{ frames = 1000000000, step = [1, 0, 0] }}\n", ":7: path.frames: expected at"),
    "path of one frame": (f"{GOOD}path = {{ frames = 1, step = [1, 0, 0] }}\n", ":7: path.frames: expected a whole"),
    "step of two": (f"{GOOD}path.step = [1, 0]\n", ":7: path.step: expected three numbers"),
    "name twice": (
        f'{GOOD}[[check]]\nname = "a"\n[[check]]\nname = "a"\n', ":8: check.name: expected a name of its own"
    ),
    "stored along a path": (
        f'{GOOD}stored = "back"\npath.step = [1, 0, 0]\nbounds.flips.max = 1\n', ":7: stored: expected none beside"
    ),
    "camera with one matrix": (f'{GOOD}camera = {{ view = "v.npy" }}\n', ":7: camera: expected view and projection"),
    "unknown key of a camera": (f'{GOOD}camera = {{ vew = "v" }}\n', ":7: camera.vew: unknown key; did you mean"),
    "missing matrices": (f'{GOOD}camera = {{ view = "v", projection = "p" }}\n', ":7: camera: file: cannot read 'v'"),
    "camera twice": (
        f'{GOOD}camera = {{ view = "v", projection = "p" }}\nfar = 3\n', ":8: far: expected none beside the matrices"
    ),
    "camera that stands": (
        f'{GOOD}camera = {{ view = "v", projection = "p" }}\npath.frames = 3\nbounds.flips.max = 1\n',
        ":7: camera.view: expected {frame} in the name",
    ),
    "no tables": ("check = 1\n", ":1: check: expected tables [[check]], got 1"),
    "no toml": ("[", ": no valid TOML: "),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_mistake_is_one_line_with_file_line_and_key(check, name):
    text, *says = BAD[name]
    fails_in("b.toml", check(text), *says)


def test_every_bounded_column_is_in_the_vocabulary_and_has_numbers():
    assert all(COLUMNS[name].dtype in ("Int64", "float64") for name in (*VIEW_COLUMNS, *PATH_COLUMNS))


def test_of_a_path_the_worst_step_counts_and_what_is_missing_does_not_hold():
    most, least = Bound("drift_max", None, 0.5), Bound("drift_max", 0.2, None)
    steps = {"drift_max": [0.1, 0.4, 0.3]}
    assert (value_of_bound(most, steps), value_of_bound(least, steps)) == (0.4, 0.1)
    both = Bound("drift_max", 0.2, 0.5)
    assert value_of_bound(both, steps) == 0.1
    assert value_of_bound(most, {"drift_max": [0.1, float("nan")]}) is None
    assert value_of_bound(most, {}) is None
    # No edge is displaced: the distance is none that is missing.
    edges = Bound("edge_px", None, 1.0)
    assert value_of_bound(edges, {"edge_px": None, "edge": 0}) == 0.0
    assert value_of_bound(edges, {"edge_px": None, "edge": None}) is None


def test_a_path_moves_and_turns_the_camera_in_the_axes_of_the_file():
    camera = sl.Camera.look_at((1, 2, 3), (1, 2, 0))
    cameras = CameraPath(3, (0.5, 0.0, 0.25), np.pi / 2).cameras(camera, "z")
    assert cameras[0] == camera
    np.testing.assert_allclose([c.eye for c in cameras], [(1, 2, 3), (1.5, 2.25, 3), (2, 2.5, 3)], atol=1e-12)
    np.testing.assert_allclose([c.forward for c in cameras], [(0, 0, -1), (-1, 0, 0), (0, 0, 1)], atol=1e-12)


def test_xml_holds_any_text():
    said = json.dumps("<&\"'") + "\x00\x1b é"
    top = ElementTree.fromstring(junit_xml("n\x01", {said: [Case(said, said, 0.5, failure=said), Case("b", "g", 1.0)]}))
    assert (top.attrib["tests"], top.attrib["failures"], top.attrib["time"]) == ("2", "1", "1.500")
    suite = top.find("testsuite")
    assert suite.attrib["name"] == said.replace("\x00", "\ufffd").replace("\x1b", "\ufffd")
    assert suite.find("testcase/failure").text == suite.attrib["name"]
