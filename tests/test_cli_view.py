"""The view on the command line: which is taken, the options that repeat it, and the arrays that are saved of it."""

from __future__ import annotations

import json
import shlex

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import cli
from shadowlab.reports.study_arrays import RUN_KEYS, VIEW_KEYS

SMALL = ("--size", "32x24", "--resolution", "64", "--backend", "cpu")


def test_a_scene_without_its_own_view_gets_one(run, mesh):
    options = cli.given_options(["matrix", mesh, "--size", "200x100"])
    scene, camera, light, _ = cli.load_view(options, (200, 100))
    fitting, sun = sl.default_view(scene, aspect=2.0)
    assert camera == fitting
    assert light == sun


def test_without_a_size_a_library_scene_keeps_its_aspect_and_others_are_wide(run, mesh, tmp_path):
    words = ("--resolution", "32", "--technique", "uniform", "--backend", "cpu")
    run("compare", "@skylight", *words, "--out", tmp_path / "library")
    data = json.loads((tmp_path / "library" / "results.json").read_text(encoding="utf-8"))
    own = sl.library.scene("skylight").camera
    assert data["size"] == [1360, 765]
    assert data["camera"]["aspect"] == own.aspect
    assert "--size 1360x765" in data["reproduce"]["command"]
    options = cli.given_options(["matrix", mesh])
    assert cli.load_view(options, None)[1].aspect == 16 / 9


@pytest.mark.parametrize("view", ["along", "above", "against"])
def test_the_options_that_are_printed_repeat_the_view(run, mesh, tmp_path, view):
    """Camera and light bit for bit, and with them the whole table."""
    words = ("compare", mesh, "--ground", "--up", "z", "--resolution", "64", "--backend", "cpu")
    status, out, _ = run(*words, "--size", "64x36", "--view", view, "--out", tmp_path / "a")
    assert status == 0
    assert f"View: {view}, chosen for the scene" in out
    flags = shlex.split(next(line for line in out.splitlines() if line.startswith("  --eye=")))
    assert run(*words, *flags, "--out", tmp_path / "b")[0] == 0
    first, second = (json.loads((tmp_path / d / "results.json").read_text(encoding="utf-8")) for d in "ab")
    assert second["camera"] == first["camera"]
    assert second["light"] == first["light"]
    timed = ("fit_us", "map_ms", "lookup_ms", "scene")
    rows = [[{k: v for k, v in one.items() if k not in timed} for one in data["runs"]] for data in (first, second)]
    assert rows[0] == rows[1]
    assert "misclassified" in rows[0][0]
    scene, camera, light, source = view_of(words[1:], ["--size", "64x36", "--view", view])
    assert (source.view, camera, light) == (view, *sl.default_view(scene, focus=sl.load_scene(mesh, up="z"), view=view))


def view_of(words, more):
    options = cli.given_options(["compare", *words, *more])
    return cli.load_view(options, tuple(map(int, options.size.split("x"))) if options.size else None)


def test_a_view_that_is_given_is_no_default_one(run, mesh, tmp_path):
    _, out, _ = run("compare", mesh, "--eye", "3,2,4", *SMALL, "--out", tmp_path)
    assert "View: as given, the rest chosen for the scene" in out
    assert "  --eye=3,2,4 " in out
    _, out, _ = run("compare", "@robots", *SMALL, "--out", tmp_path)
    assert "View: that of the scene; --view along or --view above or --view against for another" in out
    scene, camera, light, source = view_of(["@robots", "--view", "above"], [])
    assert (source.view, camera, light) == ("above", *sl.default_view(scene, view="above"))
    assert camera != scene.camera


def test_arrays_are_saved_and_read_without_pickle(run, tmp_path):
    path = tmp_path / "study.npz"
    words = ("@robots", "--technique", "uniform", "--technique", "z_partition:count=2", "--technique", "psm")
    status, out, _ = run(
        "compare", *words, "--light-position", "0,6,0", *SMALL, "--save-arrays", path, "--out", tmp_path / "r"
    )
    assert status == 0
    assert f"Arrays: {path}" in out
    data = json.loads((tmp_path / "r" / "results.json").read_text(encoding="utf-8"))
    with np.load(path, allow_pickle=False) as arrays:
        found = {name: arrays[name] for name in arrays}
    view = {name: (found[name].shape, str(found[name].dtype)) for name in ("depth", "position", "normal", "triangle")}
    assert view == {
        "depth": ((24, 32), "float32"), "position": ((24, 32, 3), "float64"), "normal": ((24, 32, 3), "float32"),
        "triangle": ((24, 32), "int32"),
    }  # fmt: skip
    assert list(found["label"]) == ["uniform", "z_partition:count=2", "psm"]
    assert found["failure"][2]
    assert not any(name.startswith("run_2") for name in found)
    # Neither has a rectilinear warp, whose knots are in no file of theirs.
    keys = [name for name in RUN_KEYS if not name.startswith("post_warp_")]
    documented = {*VIEW_KEYS, *(f"run_{i}_{name}" for i in (0, 1) for name in keys)}
    assert set(found) == documented  # six faces each: all have a map to choose
    for i, run_data in enumerate(data["runs"][:2]):
        np.testing.assert_array_equal(found[f"run_{i}_matrices"], run_data["matrices"])
        assert found[f"run_{i}_maps"].shape == (len(run_data["matrices"]), 64, 64)
        assert (found[f"run_{i}_difference"] > 0).sum() == run_data["misclassified"]
        # The masks are those that were compared: differences from the truth where both know.
        mask, truth = found[f"run_{i}_mask"], found["truth"]
        assert ((mask < 0.5) & (truth == 1)).sum() == run_data["false_shadow"]
    # Positions are those of the pixels' depths, through the camera.
    seen = found["triangle"] >= 0
    clip = np.append(found["position"][seen], np.ones((seen.sum(), 1)), axis=1)
    clip = clip @ (found["camera_projection"] @ found["camera_view"]).T
    np.testing.assert_allclose(clip[:, 2] / clip[:, 3], found["depth"][seen], atol=1e-5)
    np.testing.assert_allclose(found["light_point"][:3] / found["light_point"][3], (0, 6, 0))


def test_an_eye_alone_looks_at_the_middle(mesh):
    options = cli.given_options(["matrix", mesh, "--eye", "9,0,0"])
    scene, camera, _, _ = cli.load_view(options, (8, 8))
    np.testing.assert_allclose(camera.forward, (-1, 0, 0), atol=1e-12)
    depth = camera.depth(np.array([[0.5, 0, 0], [-0.5, 0, 0]]))
    assert camera.near < depth[0] < depth[1] < camera.far
    assert scene.triangle_count == 12


@pytest.mark.parametrize("target", ["0,-9,0", "0,9,0"])
def test_straight_down_and_up_have_a_picture(mesh, target):
    options = cli.given_options(["matrix", mesh, "--eye", "0,0,0", "--target", target])
    with pytest.warns(sl.errors.ShadowlabWarning, match="^up: the camera looks straight"):
        _, camera, _, _ = cli.load_view(options, (8, 8))
    assert np.isfinite(camera.clip_from_world).all()
    assert camera == sl.Camera.look_at(
        (0, 0, 0), camera.forward, up=(0, 0, -1) if target == "0,-9,0" else (0, 0, 1),
        fov_y=camera.fov_y, aspect=1.0, near=camera.near, far=camera.far,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("--light", "0,0,0"), "light"),
        (("--ortho-height", "0"), "ortho-height"),
        (("--light-position", "1e308,1e308,1e308"), "light-position"),
    ],
)
def test_errors_have_the_names_of_options(run, mesh, words, name):
    status, _, err = run("matrix", mesh, *words)
    assert status == 2
    assert err.startswith(f"shadowlab: error: {name}: expected")
    assert err.count("\n") == 1
