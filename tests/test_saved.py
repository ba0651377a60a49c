"""Saved results come back: numbers and settings bit for bit, pictures drawn again, and files that are none refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import trimesh
from travel_support import bits, preset_of_ones_own

import shadowlab as sl
from shadowlab.errors import ArgumentError, LoadError, StateError, UnsupportedError
from shadowlab.reports import result_keys, saved
from shadowlab.scene.recipe import scene_of_recipe

SIZE = (48, 27)


class Mine:
    """A technique of a class from elsewhere."""

    name, settings = "mine", {"width": 2.0}

    def parameterize(self, scene, camera, light, *, resolution=1024, samples=None):
        return sl.technique("uniform").parameterize(scene, camera, light, resolution=resolution)


def compared(scene, techniques=("uniform", "lispsm:filter=bilinear", "gmnpr"), **how):
    how = {"resolution": [32, 48], "size": SIZE, "renderer": "cpu", "progress": False, **how}
    light = how.pop("light", scene.lights.get("sun") if scene.lights else None) or sl.DirectionalLight((0.3, -1, 0.2))
    camera = getattr(scene, "camera", None) or sl.Camera.look_at((0, 4, 9), (0, 0, 0), aspect=16 / 9, near=1, far=99)
    return sl.compare(scene, camera, light, techniques, **how)


@pytest.fixture(scope="module")
def study():
    scene = sl.library.scene("robots", seed=2).with_ground(size=50.0)
    made = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, made.camera, made.light, resolution=32)
    scene.camera = made.camera
    techniques = {
        "uniform": "uniform", "lispsm": "lispsm:bias=(slope=1),filter=bilinear", "cascades": "z_partition:count=3",
        "engine": "preset:filament", "matrices": p, "psm": "psm", "rectilinear": "rectilinear",
        "log": "log",
    }  # fmt: skip
    return compared(scene, techniques, light=made.light, bias=sl.Bias(slope_limit=np.inf), blend=0.1, stored="back")


@pytest.fixture(scope="module")
def folder(study, tmp_path_factory):
    path = tmp_path_factory.mktemp("report")
    study.save(path, progress=False)
    return path


@pytest.fixture(scope="module")
def advice():
    scene = sl.library.scene("robots")
    lights = {"sun": scene.light, "lamp": sl.PointLight((0, 9, 0), range=99)}
    return sl.advise(
        scene, scene.camera, lights, techniques=["uniform", "lispsm", "gmnpr"], memory=["4 KiB", "16 KiB"], size=SIZE,
        renderer="cpu", progress=False,
    )  # fmt: skip


def changed(folder, tmp_path, change):
    """A copy of a report whose results.json is changed."""
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    change(data)
    path = tmp_path / "results.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_a_study_comes_back_as_it_was(study, folder):
    again = sl.Study.load(folder)
    assert again == study
    assert hash(again) == hash(study)
    pd.testing.assert_frame_equal(again.table, study.table, check_exact=True)
    assert bits(again.table) == bits(study.table)
    assert again.verdict == study.verdict
    assert repr(again) == repr(study)
    assert (again.read, again.size, again.truth_ms) == (study.read, study.size, study.truth_ms)
    for one, other in zip(again.runs, study.runs, strict=True):
        assert bits(one.values) == bits(other.values)
        assert one.parameterization == other.parameterization
        assert one.summary == other.summary
    assert "scene" not in again.view.__dict__, "nothing of this needed the scene"


def test_pictures_are_drawn_again(study, folder):
    again = sl.Study.load(folder / "results.json")
    assert np.array_equal(again.truth, study.truth)
    for key in [(run.label, run.resolution) for run in study.runs if not run.failure]:
        assert np.array_equal(again.masks[key], study.masks[key], equal_nan=True)
        assert np.array_equal(again.maps[key], study.maps[key])
    assert again.scene == study.scene


def test_a_loaded_study_is_saved_as_before(study, folder, tmp_path):
    sl.Study.load(folder).save(tmp_path, progress=False)
    first, second = (json.loads((path / "results.json").read_text(encoding="utf-8")) for path in (folder, tmp_path))
    for name in ("created", "digest"):
        first.pop(name), second.pop(name)
    assert second == first


def test_an_advice_comes_back_as_it_was(advice, tmp_path):
    advice.save(tmp_path)
    again = sl.Advice.load(tmp_path)
    assert again == advice
    for name in ("table", "runs", "switches"):
        assert bits(getattr(again, name)) == bits(getattr(advice, name))
    assert again.verdict == advice.verdict
    assert again.best == advice.best
    assert "scene" not in again.views[0].view.__dict__
    assert again.scene == advice.scene
    assert again.views[0].view.scene is again.views[1].view.scene, "one scene for all views"


def test_a_file_that_is_gone_or_changed_keeps_its_numbers(tmp_path):
    mesh, report = tmp_path / "ball.obj", tmp_path / "report"
    trimesh.creation.icosphere(2).export(mesh)
    study = compared(sl.load_scene(mesh).with_ground(), ["uniform", "lispsm"])
    study.save(report, progress=False)
    assert np.array_equal(sl.Study.load(report).truth, study.truth)
    trimesh.creation.icosphere(1).export(mesh)
    again = sl.Study.load(report)
    assert again == study
    again.view.clear()
    with pytest.raises(LoadError, match=r"scene: 'ball\.obj' has changed.*scene="):
        _ = again.truth
    mesh.unlink()
    with pytest.raises(LoadError, match=r"scene: cannot make 'ball\.obj' again"):
        _ = again.masks["uniform", 32]
    given = sl.Study.load(report, scene=study.scene)
    assert np.array_equal(given.truth, study.truth)
    with pytest.raises(ArgumentError, match="scene: expected the scene"):
        sl.Study.load(report, scene=sl.library.scene("robots"))
    with pytest.raises(ArgumentError, match="scene: expected a Scene"):
        sl.Study.load(report, scene="ball.obj")


def test_a_scene_of_arrays_is_given(tmp_path):
    scene = sl.Scene.from_arrays(np.array([[-4.0, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]]), [[0, 2, 1], [0, 3, 2]])
    study = compared(scene, ["uniform", "lispsm"])
    study.save(tmp_path, progress=False)
    again = sl.Study.load(tmp_path)
    assert again == study
    with pytest.raises(LoadError, match="was arrays; load it with scene="):
        again.save(tmp_path / "again", progress=False)
    sl.Study.load(tmp_path, scene=scene).save(tmp_path / "again", progress=False)


def test_techniques_from_elsewhere_keep_their_rows(tmp_path):
    scene = sl.library.scene("robots")
    study = compared(scene, {"mine": Mine(), "own": preset_of_ones_own()}, light=scene.light)
    study.save(tmp_path, progress=False)
    again = sl.Study.load(tmp_path)
    assert bits(again.table) == bits(study.table)
    assert np.array_equal(again.masks["mine", 32], study.masks["mine", 32], equal_nan=True), "matrices are there"
    with pytest.raises(UnsupportedError, match="from outside"):
        again.runs[0].item.parameterize(scene, scene.camera, scene.light)


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data["runs"][0].update(misclassified=0), lambda data: data.update(verdict="fine"),
        lambda data: data["state"].update(truth_ms=0.0), lambda data: data.pop("digest"),
        lambda data: data["state"]["objects"].pop(), lambda data: data.update(more=1),
    ],
)  # fmt: skip
def test_a_file_that_was_changed_is_refused(folder, tmp_path, change):
    with pytest.raises(StateError, match=r"results\.json.*has changed"):
        sl.Study.load(changed(folder, tmp_path, change))


@pytest.mark.parametrize(
    "harm",
    [
        {"objects": [], "root": {"at": 0}}, {"objects": [{"class": ["os", 1, {}]}], "root": {"at": 0}},
        {"objects": [{"class": ["Study", 1, {}]}], "root": {"at": 0}}, {"root": 1}, {"objects": 1, "root": 1},
        {"objects": [{"tuple": [{"at": 0}]}], "root": {"at": 0}}, {"root": {"at": 0}},
        {"objects": [{"core": ["Camera", 1, "%"]}], "root": 1},
        {"objects": [{"core": ["Camera", 99, ""]}], "root": 1}, {"objects": [{"what": 1}], "root": {"at": 0}},
        {"objects": [{"class": ["Study", 99, {}]}], "root": {"at": 0}}, {"objects": [[]], "root": 1},
        {"objects": [{"array": ["|O", [1], "AAAAAAAAAAA="]}], "root": 1}, {"objects": [{}], "root": {"at": -1}},
        {"objects": [{"preset": "none"}], "root": 1}, {"objects": [{"array": ["<f8", [1 << 50], ""]}], "root": 1},
    ],
)  # fmt: skip
def test_states_that_nobody_wrote_are_refused(folder, tmp_path, harm):
    def change(data):
        data["state"] = harm
        data.pop("digest")
        data["digest"] = saved.digest_of_document(data)

    with pytest.raises(StateError, match="state"):
        sl.Study.load(changed(folder, tmp_path, change))


def test_files_that_are_no_results_are_refused(folder, advice, tmp_path):
    with pytest.raises(LoadError, match=r"results\.json of a saved Study, cannot read it.*Study\.save"):
        sl.Study.load(tmp_path)
    for text in ("", "[]", "{}", '{"runs": []}', "[" * 100_000, "\x00"):
        (tmp_path / "results.json").write_text(text)
        with pytest.raises(LoadError, match="path"):
            sl.Study.load(tmp_path)
    with pytest.raises(StateError, match="update shadowlab"):
        sl.Study.load(changed(folder, tmp_path, lambda data: data.update(format=99)))
    advice.save(tmp_path)
    shutil.copy(tmp_path / "advice.json", tmp_path / "results.json")
    with pytest.raises(LoadError, match="got that of Advice"):
        sl.Study.load(tmp_path)
    with pytest.raises(LoadError, match=r"advice\.json"):
        sl.Advice.load(folder)


@pytest.mark.parametrize(
    "recipe",
    [
        "", "1", "sl", "sl.library.scene", "print(1)", "sl.library.scene('robots').meshes", "__import__('os')", "a + b",
        "sl.library.scene('robots').to_trimesh()", "sl.library.scene('none')", "sl.load_scene(open('x'))", "(" * 500,
        "sl.library.scene('robots', seed=-1)", "sl.Limits(size=10)", "sl.library.scene(*['robots'])", "lambda: 1",
        "sl.library.scene('robots').with_ground(1, 2, 3, 4)", "sl.Scene.from_arrays([], [])",
        "sl.library.scene(name=x)",
    ],
)  # fmt: skip
def test_what_is_no_recipe_makes_no_scene(recipe):
    with pytest.raises(sl.errors.ShadowlabError):
        scene_of_recipe(recipe)


def test_recipes_make_the_scene_again(tmp_path):
    mesh = tmp_path / "ball.obj"
    trimesh.creation.icosphere(1).export(mesh)
    turned = sl.load_scene(mesh, up="z", limits=sl.Limits(size=10**6)).with_ground(-2.0, 9.0)
    scene = sl.library.scene("forest", trees=3, seed=4) + turned.transformed(np.diag([2.0, 2, -2, 1]))
    moved = scene.with_transforms([1], scene.transforms[[2]])
    for one in (turned, scene, moved):
        assert scene_of_recipe(one.recipe) == one


def leaves(data, path=""):
    """Every key of a file with its values, as the page writes it: `[]` after lists of objects."""
    if isinstance(data, dict):
        for name, value in data.items():
            yield from leaves(value, f"{path}.{name}" if path else name)
    elif (
        isinstance(data, list)
        and data
        and isinstance(data[0], (dict, list))
        and not path.endswith(("post_warp.x", "post_warp.y", "[]"))
    ):
        for value in data:
            yield from leaves(value, f"{path}[]")
    else:
        yield path, data


def declared(path, keys, tables):
    """The key of the page that a key of a file is."""
    parts = path.split(".")
    for n in range(len(parts), 0, -1):
        head = ".".join(parts[:n])
        for name in (head, f"{head}.*") if n == len(parts) or f"{head}.*" in keys else (head,):
            if name in keys and (n == len(parts) or name.endswith("*")):
                return name
    head, _, last = path.rpartition(".")
    return f"{head}.COLUMN" if f"{head}.COLUMN" in keys and last in tables[head] else None


TYPES = {"text": str, "integer": int, "number": (int, float), "flag": bool, "texts": list, "integers": list}


def fits(value, kind):
    """Whether a value is of the type that the page says."""
    kind = kind.partition(":")[0].partition(";")[0]
    if kind in ("value", "object") or (value is None and "null" in kind):
        return True
    word = kind.split()[0]
    if value == "inf" and word == "number":
        return True
    if word in ("2", "3", "4", "pairs"):
        return isinstance(value, list) and (word == "pairs" or len(value) == int(word))
    return isinstance(value, TYPES[word])


def test_the_page_has_every_key_and_no_other(study, folder, advice, tmp_path):
    scene = sl.library.scene("robots")
    spot = sl.SpotLight((0, 9, 0), (0, -1, 0.1), cone_angle=1.0, range=50)
    camera = sl.Camera.orthographic((0, 4, 9), (0, 0, 0), height=6.0, aspect=16 / 9, near=1, far=99, shift=(0.1, 0))
    sl.compare(scene, camera, spot, ["uniform"], resolution=16, size=SIZE, renderer="cpu", progress=False).save(
        tmp_path / "spot", progress=False
    )
    advice.save(tmp_path)
    sun = advice.views[0].light
    matrices = {"m": sl.technique("uniform").parameterize(scene, camera, sun), "uniform": "uniform"}
    sl.advise(scene, camera, sun, techniques=matrices, size=SIZE, renderer="cpu", progress=False).save(tmp_path / "m")
    measured = {name for run in study.runs for name in run.row()}
    advised = {"table": set(advice.table), "runs": set(advice.runs), "switches": set(advice.switches)}
    for keys, tables, files in (
        (result_keys.STUDY_KEYS, {"runs[]": measured}, [folder / "results.json", tmp_path / "spot" / "results.json"]),
        (
            result_keys.ADVICE_KEYS, {f"{name}[]": of for name, of in advised.items()},
            [tmp_path / "advice.json", tmp_path / "m" / "advice.json"],
        ),
    ):  # fmt: skip
        seen = set()
        for file in files:
            document = json.loads(file.read_text(encoding="utf-8"))
            document["state"] = None
            for path, value in leaves(document):
                name = declared(path, keys, tables)
                if value == [] and name is None:
                    continue  # objects, of which there are none
                assert name is not None, f"{file.name}: {path} is not on the page"
                assert fits(value, keys[name]), f"{file.name}: {path} is {value!r}, the page says {keys[name]}"
                seen.add(name)
        hidden = {"gains[].drawn", "views[].camera.height", "views[].camera.shift", "views[].light.cone_angle"}
        assert set(keys) - seen - hidden == set(), "keys of the page that no file has"
    page = (Path(__file__).resolve().parents[1] / "docs" / "results.md").read_text(encoding="utf-8")
    assert f"format {saved.FORMAT_OF_RESULTS}" in page
