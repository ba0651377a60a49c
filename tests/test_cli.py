"""The command line: what it prints and writes, and one line with exit status 2 for everything that can be wrong."""

from __future__ import annotations

import io
import json
import math
import os
import shlex
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from cli_support import fails

import shadowlab as sl
from shadowlab import cli
from shadowlab.text import BIAS, format_spec, parse_size, parse_spec, parse_value, parse_vector

SMALL = ("--size", "32x24", "--resolution", "64", "--backend", "cpu")


def test_compare_writes_the_report_and_says_where(run, mesh, tmp_path):
    out_dir = tmp_path / "out"
    status, out, err = run("compare", mesh, "--ground", *SMALL, "--out", out_dir)
    assert (status, err) == (0, "")
    assert "uniform" in out
    assert "lispsm" in out
    assert "fewest wrong pixels" in out or "share the fewest" in out or "right" in out
    assert str(out_dir / "report.html") in out
    names = {path.name for path in out_dir.iterdir()}
    assert {"report.html", "results.csv", "results.json", "truth.png"} <= names
    assert ".shadowlab-probe" not in names
    data = json.loads((out_dir / "results.json").read_text(encoding="utf-8"))
    assert [r["technique"] for r in data["runs"]] == ["uniform", "lispsm"]
    assert data["size"] == [32, 24]


def test_compare_of_the_library_with_parameters(run, tmp_path):
    words = ("@forest:trees=20,seed=3", "--technique", "uniform", "--technique=lispsm:near=basic", "--resolution=32,64")
    status, out, _ = run("compare", *words, "--size", "16x16", "--backend", "cpu", "--out", tmp_path)
    assert status == 0
    assert out.count("lispsm:near=basic") >= 2
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert data["scene"]["instances"] == sl.library.scene("forest", trees=20, seed=3).instance_count
    assert "seed=3" in data["scene"]["python"]


def test_the_command_in_the_report_gives_the_same_numbers(run, tmp_path):
    run("compare", "@skylight", "--light", "-0.3,-1,0.2", *SMALL, "--out", tmp_path / "a")
    first = json.loads((tmp_path / "a" / "results.json").read_text(encoding="utf-8"))
    words = shlex.split(first["reproduce"]["command"])
    assert words[0] == "shadowlab"
    status, _, _ = run(*words[1:], "--out", tmp_path / "b")
    assert status == 0
    second = json.loads((tmp_path / "b" / "results.json").read_text(encoding="utf-8"))
    for before, after in zip(first["runs"], second["runs"], strict=True):
        assert before["misclassified"] == after["misclassified"]
        # Through degrees and a target point: a few last digits of the camera may differ.
        np.testing.assert_allclose(after["matrices"], before["matrices"], rtol=1e-9, atol=1e-12)


def test_vectors_come_back_as_they_were_given(run, tmp_path):
    given = ("--eye", "2.5, 3 4", "--target", "-1,1.6,0", "--light", "-0.3,-1,0.2")
    run("compare", "@skylight", *given, *SMALL, "--out", tmp_path / "a")
    first = json.loads((tmp_path / "a" / "results.json").read_text(encoding="utf-8"))
    words = shlex.split(first["reproduce"]["command"])
    assert {"--eye=2.5,3,4", "--target=-1,1.6,0", "--light=-0.3,-1,0.2"} <= set(words)
    assert run(*words[1:], "--out", tmp_path / "b")[0] == 0
    second = json.loads((tmp_path / "b" / "results.json").read_text(encoding="utf-8"))
    for before, after in zip(first["runs"], second["runs"], strict=True):
        np.testing.assert_array_equal(after["matrices"], before["matrices"])


def test_all_with_a_point_light_says_in_one_line_what_it_leaves_out(run, tmp_path):
    words = ("@robots", "--light-position", "0,4,0", *SMALL)
    status, out, err = run("compare", *words, "--technique", "all", "--technique", "uniform", "--out", tmp_path)
    assert status == 0
    assert err.startswith("shadowlab: warning: left out, they serve no point light: psm, tsm")
    assert err.count("\n") == 1
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    labels = [run["label"] for run in data["runs"]]
    assert labels.count("uniform") == 1
    assert "psm" not in labels
    # At most a line of notes for each.
    assert all(sum(line.startswith(f"{label}: ") for line in out.splitlines()) <= 1 for label in labels)
    fails(run("compare", *words, "--technique", "uniform", "--technique", "uniform"), "'uniform' is given twice")


def test_presets_are_listed(run):
    status, out, _ = run("techniques")
    assert status == 0
    for name in sl.presets()["name"]:
        assert f"preset:{name}: " in out


def test_a_bias_reaches_the_maps_and_the_command_in_the_report(run, tmp_path):
    words = ("compare", "@skylight", *SMALL, "--bias", "world=0.5,slope-limit=3")
    assert run(*words, "--out", tmp_path / "a")[0] == 0
    first = json.loads((tmp_path / "a" / "results.json").read_text(encoding="utf-8"))
    assert first["bias"] == {name: getattr(sl.Bias(world=0.5, slope_limit=3), name) for name in BIAS}
    again = shlex.split(first["reproduce"]["command"])
    assert again[again.index("--out") + 1] == str(tmp_path / "a")
    run(*again[1:], "--out", tmp_path / "b")
    run(*words[:-2], "--out", tmp_path / "c")
    second, other = (json.loads((tmp_path / d / "results.json").read_text(encoding="utf-8")) for d in "bc")
    counts = [[r["misclassified"] for r in data["runs"]] for data in (first, second, other)]
    assert counts[0] == counts[1] != counts[2]


def test_the_python_of_a_file_with_ground_is_its_scene(run, mesh, tmp_path):
    run("compare", mesh, "--up", "z", "--ground", *SMALL, "--out", tmp_path)
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    names: dict = {"sl": sl}
    exec(data["scene"]["python"], names)
    np.testing.assert_array_equal(names["scene"].bounds, data["scene"]["bounds"])
    assert "--up z --ground" in data["reproduce"]["command"]


@pytest.mark.parametrize(
    "form", [["--light=-1,-2,0.5"], ["--light", "-1,-2,0.5"], ["--light", "-1 -2 .5"], ["--light", "-1, -2, 5e-1"]]
)
def test_vectors_may_begin_with_a_minus(run, mesh, form):
    status, out, _ = run("matrix", mesh, *form, "--format", "json")
    assert status == 0
    matrix = np.array(json.loads(out)["matrix"])
    # Two points on one ray of the light have one place in the map.
    a, b = (matrix @ [*(np.array([0.1, 0.2, 0.3]) + t * np.array([-1, -2, 0.5])), 1.0] for t in (0.0, 0.4))
    np.testing.assert_allclose(a[:2] / a[3], b[:2] / b[3], atol=1e-12)


def test_coordinates_are_those_of_the_file(run, tmp_path):
    """A z-up file seen with z-up coordinates is the y-up file seen with y-up ones."""
    box = trimesh.creation.box(extents=(1, 2, 3))
    box.export(tmp_path / "y.ply")
    standing = box.copy()
    standing.vertices = np.stack([box.vertices[:, 0], -box.vertices[:, 2], box.vertices[:, 1]], axis=1)
    standing.export(tmp_path / "z.ply")
    _, first, _ = run(
        "matrix", tmp_path / "y.ply", "--eye", "4,5,6", "--target", "0,1,0", "--light", "1,-2,-0.5", "--format", "json"
    )
    _, second, _ = run(
        "matrix",
        tmp_path / "z.ply",
        "--up",
        "z",
        "--eye",
        "4,-6,5",
        "--target",
        "0,0,1",
        "--light",
        "1,0.5,-2",
        "--format",
        "json",
    )
    first, second = (np.array(json.loads(text)["matrices"]) for text in (first, second))
    np.testing.assert_allclose(second, first, rtol=1e-6, atol=1e-7)  # ply holds float32


@pytest.mark.parametrize("kind", ["npy", "json", "text"])
def test_matrix_formats_hold_the_same_matrix(mesh, kind):
    words = [
        "matrix",
        mesh,
        "--technique",
        "lispsm",
        "--eye",
        "3,2,4",
        "--light",
        "-1,-1,-1",
        "--resolution",
        "512",
        "--format",
        kind,
    ]
    done = subprocess.run([sys.executable, "-m", "shadowlab.cli", *words], capture_output=True, check=True)
    if kind == "npy":
        matrix = np.load(io.BytesIO(done.stdout))
    elif kind == "json":
        matrix = np.array(json.loads(done.stdout)["matrix"])
    else:
        matrix = np.array([line.split() for line in done.stdout.decode().splitlines()], dtype=float)
    scene = sl.load_scene(mesh)
    options = cli.given_options(words)
    _, camera, light, _ = cli.load_view(options, None)
    np.testing.assert_array_equal(np.asarray(light.direction), np.asarray(sl.DirectionalLight((-1, -1, -1)).direction))
    samples = sl.View(scene, camera, light, size=None).samples(renderer="cpu")
    technique = sl.technique("lispsm")
    expected = technique.parameterize(scene, camera, light, resolution=512, samples=samples).matrix
    np.testing.assert_array_equal(matrix, expected)


def test_matrix_to_a_file(run, mesh, tmp_path):
    status, out, _ = run("matrix", mesh, "--format", "npy", "--out", tmp_path / "m.npy")
    assert (status, out) == (0, "")
    assert np.load(tmp_path / "m.npy").shape == (4, 4)
    fails(run("matrix", mesh, "--out", tmp_path / "none" / "m.npy"), "cannot write")


def test_techniques_and_version(run):
    status, out, _ = run("techniques")
    assert status == 0
    for name in sl.techniques()["name"].unique():
        assert name in out
    with pytest.raises(SystemExit) as left:
        cli.main(["--version"])
    assert left.value.code == 0


def test_doctor(run):
    status, out, _ = run("doctor")
    assert status == 0
    assert "The core works." in out


# Every way to be wrong, with what the line must say.
BAD = {
    "no command": ([], "COMMAND", "--help"),
    "unknown command": (["compre"], "compre"),
    "no scene": (["compare"], "MESH"),
    "unknown option": (["compare", "MESH", "--resolutoin", "4"], "--resolutoin"),
    "abbreviated option": (["compare", "MESH", "--res", "4"], "--res"),
    "missing file": (["compare", "no/such/file.ply"], "no/such/file.ply", "check the path"),
    "a directory": (["compare", "DIR"], "directory"),
    "not a mesh": (["compare", "TEXT"], "notes.txt"),
    "no ending": (["compare", "BARE"], "bare"),
    "empty file": (["compare", "EMPTY"], "empty.ply"),
    "broken file": (["compare", "BROKEN"], "broken.ply"),
    "truncated file": (["compare", "TRUNCATED"], "truncated.glb"),
    "points only": (["compare", "POINTS"], "points.ply"),
    "nothing finite": (["compare", "NAN"], "no usable triangle"),
    "index out of range": (["compare", "RANGE"],),
    "unknown technique": (["compare", "MESH", "--technique", "lipsm"], "lipsm", "lispsm", "uniform"),
    "unknown parameter": (["compare", "MESH", "--technique", "lispsm:nera=1"], "nera", "near"),
    "parameter without value": (["compare", "MESH", "--technique", "lispsm:near"], "near"),
    "parameter twice": (["compare", "MESH", "--technique", "lispsm:near=1,near=2"], "twice"),
    "bad parameter value": (["compare", "MESH", "--technique", "lispsm:near=nowhere"], "near"),
    "empty technique": (["compare", "MESH", "--technique", ""], "name is missing"),
    "technique twice": (["compare", "MESH", "--technique", "uniform", "--technique", "uniform"], "twice"),
    "unknown library scene": (["compare", "@courtyrad"], "courtyrad", "courtyard"),
    "unknown library parameter": (["compare", "@forest:tress=4"], "tress", "trees"),
    "bad library value": (["compare", "@forest:trees=many"], "trees", "many"),
    "library value out of range": (["compare", "@forest:trees=-4"], "trees"),
    "bad seed": (["compare", "@forest:seed=1.5"], "seed"),
    "library name missing": (["compare", "@"], "name is missing"),
    "library with up z": (["compare", "@forest", "--up", "z"], "up"),
    "unknown view": (["compare", "MESH", "--view", "below"], "--view", "along", "above", "against"),
    "arrays into nothing": (["compare", "MESH", "--save-arrays", ""], "save-arrays: expected the name of a file"),
    "arrays nowhere": (["compare", "MESH", "--save-arrays", "TEXT/below"], "save-arrays: cannot write"),
    "unknown up": (["compare", "MESH", "--up", "x"], "--up"),
    "unknown backend": (["compare", "MESH", "--backend", "cuda"], "cuda", "cpu", "gpu"),
    "unknown filter": (["compare", "MESH", "--filter", "vsm"], "vsm", "nearest"),
    "vector of two": (["compare", "MESH", "--light", "1,2"], "light", "three numbers"),
    "vector of four": (["compare", "MESH", "--eye", "1,2,3,4"], "eye"),
    "vector of words": (["compare", "MESH", "--target", "a,b,c"], "target"),
    "empty vector": (["compare", "MESH", "--light", ""], "light"),
    "vector with nan": (["compare", "MESH", "--light", "nan,0,1"], "light", "finite"),
    "vector with infinity": (["compare", "MESH", "--light", "-inf,0,1"], "light", "finite"),
    "zero light": (["compare", "MESH", "--light", "0,0,0"], "direction"),
    "eye is target": (["compare", "MESH", "--eye", "1,2,3", "--target", "1,2,3"], "target"),
    "near beyond far": (["compare", "MESH", "--near", "10", "--far", "1"], "far"),
    "near is far": (["compare", "MESH", "--near", "2", "--far", "2"], "far"),
    "near zero": (["compare", "MESH", "--near", "0"], "near"),
    "near negative": (["compare", "MESH", "--near", "-1"], "near"),
    "far negative": (["compare", "MESH", "--far", "-1"], "far"),
    "far not a number": (["compare", "MESH", "--far", "far"], "--far", "far"),
    "far is nan": (["compare", "MESH", "--far", "nan"], "far"),
    "fov zero": (["compare", "MESH", "--fov-deg", "0"], "fov"),
    "fov too wide": (["compare", "MESH", "--fov-deg", "180"], "fov-deg: expected degrees above 0 and below 180"),
    "fov is nan": (["compare", "MESH", "--fov-deg", "nan"], "degrees"),
    "bias without value": (["compare", "MESH", "--bias", "world"], "bias", "world"),
    "bias empty": (["compare", "MESH", "--bias", ""], "bias"),
    "bias unknown": (["compare", "MESH", "--bias", "wrold=1"], "wrold", "slope_limit, plane, normal, factor, units"),
    "bias a word": (["compare", "MESH", "--bias", "world=much"], "expected a number for world", "much"),
    "bias twice": (["compare", "MESH", "--bias", "world=1,world=2"], "twice"),
    "out empty": (["compare", "MESH", "--out", ""], "out: expected the name of a directory"),
    "matrix out empty": (["matrix", "MESH", "--out", ""], "out: expected the name of a file"),
    "matrix of two techniques": (
        ["matrix", "MESH", "--technique", "uniform", "--technique", "lispsm"], "technique", "uniform and lispsm"
    ),
    "resolution zero": (["compare", "MESH", "--resolution", "0"], "resolution"),
    "resolution negative": (["compare", "MESH", "--resolution", "-4"], "resolution"),
    "resolution a fraction": (["compare", "MESH", "--resolution", "10.5"], "resolution"),
    "resolution a word": (["compare", "MESH", "--resolution", "big"], "resolution"),
    "resolution empty": (["compare", "MESH", "--resolution", ""], "resolution"),
    "resolution twice": (["compare", "MESH", "--resolution", "64,32", "--resolution", "64"], "resolution", "twice"),
    "resolution too large": (["compare", "MESH", "--resolution", "100000"], "resolution", "16384"),
    "size zero": (["compare", "MESH", "--size", "0x0"], "size"),
    "size of one": (["compare", "MESH", "--size", "64"], "size"),
    "size negative": (["compare", "MESH", "--size", "-4x4"], "size"),
    "size too large": (["compare", "MESH", "--size", "99999x2"], "size"),
    "out is a file": (["compare", "MESH", "--out", "TEXT"], "out", "cannot write"),
    "out below a file": (["compare", "MESH", "--out", "TEXT/below"], "cannot write"),
    "matrix of two resolutions": (["matrix", "MESH", "--resolution", "4,8"], "resolution"),
    "matrix format": (["matrix", "MESH", "--format", "xml"], "xml"),
}  # fmt: skip


@pytest.fixture(scope="module")
def places(tmp_path_factory, mesh):
    """The files that the table of mistakes names."""
    folder = tmp_path_factory.mktemp("bad")
    (folder / "notes.txt").write_text("not a mesh\n")
    (folder / "bare").write_text("not a mesh\n")
    (folder / "empty.ply").write_bytes(b"")
    (folder / "broken.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 9\n")
    glb = trimesh.creation.box().export(file_type="glb")
    (folder / "truncated.glb").write_bytes(glb[: len(glb) // 2])
    trimesh.PointCloud(np.eye(3)).export(folder / "points.ply")
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    (folder / "nan.ply").write_text(header + "nan 0 0\nnan 1 0\nnan 0 1\n3 0 1 2\n")
    (folder / "range.ply").write_text(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    files = {"TEXT": "notes.txt", "BARE": "bare", "EMPTY": "empty.ply", "BROKEN": "broken.ply", "NAN": "nan.ply"}
    files |= {
        "TRUNCATED": "truncated.glb",
        "POINTS": "points.ply",
        "RANGE": "range.ply",
        "TEXT/below": "notes.txt/below",
    }
    return {"MESH": mesh, "DIR": folder, **{key: folder / name for key, name in files.items()}}


@pytest.mark.parametrize("name", BAD)
def test_a_mistake_is_one_line(run, places, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    words, *parts = BAD[name]
    fails(run(*[places.get(word, word) for word in words]), *parts)
    assert list(tmp_path.iterdir()) == [] or name in ("resolution too large", "size too large")


def test_debug_shows_where(places):
    with pytest.raises(sl.errors.ArgumentError):
        cli.main(["compare", places["MESH"], "--light", "0,0,0", "--debug"])


def test_a_defect_is_one_line_too(run, mesh, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("division by\nzero")

    monkeypatch.setattr("shadowlab.scene.files.load_scene", broken)
    fails(run("compare", mesh), "ZeroDivisionError: division by zero", "--debug")
    with pytest.raises(ZeroDivisionError):
        cli.main(["--debug", "compare", mesh])


def test_a_terminal_without_our_letters_gets_question_marks(mesh, tmp_path):
    words = [sys.executable, "-m", "shadowlab.cli", "compare", mesh, *SMALL, "--out", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, check=False, env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"64?" in done.stdout


def test_dropped_faces_are_a_warning_on_one_line(run, tmp_path):
    vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\n"
    (tmp_path / "part.obj").write_text(vertices + "f 1 2 3\nf 1 2 4\n")
    status, _, err = run("matrix", tmp_path / "part.obj", "--format", "json")
    assert status == 0
    assert err.startswith("shadowlab: warning: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("value", [True, False, 3, -2, 0.1, 1e-300, 12345.678901234567, "optimal", "scene-fit"])
def test_values_survive_their_text(value):
    name, values = parse_spec(format_spec("x", {"key": value}), "technique")
    assert name == "x"
    assert values == {"key": value}
    assert type(values["key"]) is type(value)


def test_texts_of_values():
    assert parse_value("1e3") == 1000.0
    assert parse_vector(" 1, -2.5 ,+3e0", "eye") == (1.0, -2.5, 3.0)
    assert parse_size("1280×720") == (1280, 720)


def test_a_value_may_begin_with_a_minus_and_an_option_is_no_value(run):
    given = cli.given_options(["matrix", "@robots", "--light", "-1,2,3", "--ground", "--near", "-.5", "--far=-inf"])
    assert (given.light, given.ground, given.near, given.far) == ("-1,2,3", True, -0.5, -math.inf)
    assert cli.given_options(["matrix", "@robots", "--out=--ground"]).out == "--ground"
    fails(run("matrix", "@robots", "--out", "--ground"), "'--out' requires an argument", "shadowlab matrix --help")
    fails(run("matrix", "@robots", "--light"), "'--light' requires an argument")
