"""Techniques as text, as the core reads it, and within techniques; lights and matrices on the command line."""

from __future__ import annotations

import io
import json
import shlex

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import shadowlab as sl
from shadowlab import cli
from shadowlab.conventions.files import details, written
from shadowlab.errors import ArgumentError, LoadError, ShadowlabWarning, UnknownNameError
from shadowlab.reports.reproduce import given_python
from shadowlab.techniques.registry import technique_of, with_all
from shadowlab.text import bare, format_spec, parse_spec, parse_value, pieces

numbers = st.one_of(st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False))
words = st.from_regex(r"[a-z][a-z_]{0,8}", fullmatch=True).filter(lambda w: w not in ("true", "false", "inf", "nan"))
texts = st.recursive(
    words, lambda inner: st.builds(lambda a, b, c: f"{a}:x={c},y=({b})/{a}", inner.filter(str.isalpha), inner, words)
)
values = st.one_of(st.booleans(), numbers, words, texts, st.lists(numbers, min_size=2, max_size=5).map(tuple))


@given(words, st.dictionaries(words, values, max_size=4))
def test_specs_survive_their_text(name, settings):
    assert parse_spec(format_spec(name, settings), "technique") == (name, settings)


def test_what_is_in_parentheses_is_one_value():
    assert parse_spec("z_partition:count=4,inner=(lispsm:near=optimal,axis=middle)/uniform", "technique") == (
        "z_partition", {"count": 4, "inner": "(lispsm:near=optimal,axis=middle)/uniform"},
    )  # fmt: skip
    assert parse_spec("plane_optimal:plane=(0,1,0,0)", "technique")[1] == {"plane": (0, 1, 0, 0)}
    assert parse_spec("x:inner=(lispsm:near=optimal)", "technique")[1] == {"inner": "lispsm:near=optimal"}
    assert parse_value("((1,2),(3,inf))") == ((1, 2), (3, np.inf))
    assert parse_value(" ( 5 ) ") == 5
    assert parse_value("(x,-z,y)") == "x,-z,y"
    assert bare("((x))") == "x"
    assert bare("(a)/(b)") == "(a)/(b)"
    assert pieces("a=(1,2),b=3", ",") == ["a=(1,2)", "b=3"]
    assert pieces("a)(", ",") is None


@pytest.mark.parametrize("text", ["x:a=(1", "x:a=1)", "x:a=)1(", "x:(a=1"])
def test_parentheses_without_a_partner_are_refused(text):
    with pytest.raises(ArgumentError, match="a parenthesis has no partner"):
        parse_spec(text, "technique")


def test_a_text_brings_parameters():
    one = sl.technique("lispsm:near=basic", axis="middle")
    assert one.settings == sl.technique("lispsm", near="basic", axis="middle").settings
    with pytest.raises(ArgumentError, match="near is given twice"):
        sl.technique("lispsm:near=basic", near="basic")


def test_a_technique_is_itself_and_a_preset_has_its_name():
    assert sl.technique("preset:filament") is sl.preset("filament")
    for thing in (sl.technique("psm"), sl.preset("bevy"), sl.Parameterization.from_matrix(np.eye(4))):
        assert sl.technique(thing) is thing
        with pytest.raises(ArgumentError, match="expected no parameters, got near"):
            sl.technique(thing, near=1)
    with pytest.raises(ArgumentError, match="expected no parameters"):
        sl.technique("preset:filament", near=1)
    for wrong in (None, 3, [1]):
        with pytest.raises(ArgumentError, match=r"name: expected the name of a technique .* got "):
            sl.technique(wrong)


def test_arguments_of_another_type_are_told_on_one_line(tmp_path):
    scene = sl.library.scene("robots")
    wrong = [
        (lambda: sl.PointLight((0, 1, 0), range="4"), "range: expected a number"),
        (lambda: sl.PointLight((0, 1, 0), range=None), "range: expected a number"),
        (lambda: sl.PointLight("abc", range=4), "position: expected an array"),
        (lambda: sl.SpotLight((0, 1, 0), (0, -1, 0), cone_angle=[1, 2], range=4), "cone_angle: expected a number"),
        (lambda: sl.load_scene(3), "source: expected the path of a mesh file, its bytes or an open file, got 3"),
        (lambda: sl.compare(scene, scene.camera, scene.light, truth="no"), "truth: expected True or False, got 'no'"),
        (lambda: sl.compare(scene, scene.camera, scene.light, size=np.eye(60)), "size: expected"),
        (lambda: sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=np.eye(60)), "got"),
    ]
    for call, says in wrong:
        with pytest.raises(ArgumentError) as raised:
            call()
        text = str(raised.value)
        assert says in text
        assert "got " in text
        assert "\n" not in text
        assert len(text) < 300
    study = sl.compare(
        scene, scene.camera, scene.light, "uniform", resolution=16, size=(16, 9), renderer="cpu", progress=False
    )
    with pytest.raises(ArgumentError, match="directory: expected a path, got 3"):
        study.save(3)


def test_all_leaves_out_what_serves_no_such_light():
    point = sl.PointLight((0, 4, 0), range=40)
    with pytest.warns(ShadowlabWarning, match=r"^left out, they serve no point light: psm, tsm") as caught:
        served = with_all(["all"], point)
    assert len(caught) == 1
    assert {"uniform", "lispsm", "z_partition"} <= set(served)
    assert not {"psm", "tsm", "xpsm", "log"} & set(served)
    with pytest.warns(ShadowlabWarning):
        assert set(with_all(["psm", "all"], point)) == {"psm", *served}  # named, so it fails in its row
    directional = sl.library.scene("robots").light
    assert with_all(["all", "uniform"], directional) == with_all(["all"])
    assert with_all(["lispsm", "all"])[0] == "lispsm"
    assert len(with_all(["lispsm", "all"])) == len(with_all(["all"]))
    assert with_all(["uniform", "uniform"]) == ["uniform", "uniform"]  # told as what comes twice


def test_all_is_every_technique():
    names = list(sl.techniques()["name"].unique())
    assert with_all(["all"]) == names
    assert with_all(["uniform:stable=true", "all"]) == ["uniform:stable=true", *names]
    scene = sl.library.scene("robots")
    study = sl.compare(
        scene, scene.camera, scene.light, "all", resolution=64, size=(32, 18), renderer="cpu", progress=False
    )
    assert [run.label for run in study.runs] == names
    for run in study.runs:  # what cannot serve the view says why
        assert bool(run.failure) == (run.mask is None)


@pytest.fixture
def files(tmp_path):
    """A matrix of a library scene in every form, in OpenGL's convention."""
    scene = sl.library.scene("robots")
    samples = sl.View(scene, scene.camera, scene.light, size=(64, 36)).samples(renderer="cpu")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=64, samples=samples)
    found = {"matrix": p.matrix, "folder": tmp_path}
    for form, name in (("npy", "m.npy"), ("json", "m.json"), ("text", "m.txt")):
        out = tmp_path / name
        words = ["matrix", "@robots", "--resolution", "64", "--size", "64x36", "--convention", "opengl"]
        words += ["--format", form, "--out", out]
        assert cli.main([str(word) for word in words]) == 0
        found[form] = out
    return found


@pytest.mark.parametrize("form", ["npy", "json", "text"])
def test_a_matrix_in_a_file_is_a_technique(files, form, capsys):
    convention = "" if form == "json" else ",convention=opengl"  # JSON says it itself
    text = f"matrix:file={files[form]}{convention}"
    p = technique_of(text)
    np.testing.assert_allclose(p.matrix, files["matrix"], rtol=1e-12, atol=1e-12)
    out = files["folder"] / "report"
    small = ["--resolution", "64", "--size", "64x36", "--backend", "cpu", "--out", str(out)]
    assert cli.main(["compare", "@robots", "--technique", "lispsm", "--technique", text, *small]) == 0
    capsys.readouterr()
    data = json.loads((out / "results.json").read_text(encoding="utf-8"))
    ours, theirs = data["runs"]
    assert theirs["misclassified"] == ours["misclassified"] > 0
    assert theirs["technique"] == "matrix"
    command = data["reproduce"]["command"]
    assert shlex.split(command)[5:7] == ["--technique", text]
    assert cli.main(shlex.split(command)[1:]) == 0
    again = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert [r["misclassified"] for r in again["runs"]] == [r["misclassified"] for r in data["runs"]]


def test_json_has_what_one_needs_beside_the_numbers(files):
    data = json.loads(files["json"].read_text(encoding="utf-8"))
    assert data["convention"] == "opengl"
    assert data["resolution"] == 64
    assert data["selection"] == "depth"
    assert data["post_warp"] == [{"kind": "none"}]
    assert len(data["eye_depth"]) == 1
    assert data["values_of_maps"][0].keys() == data["values"].keys() > set()


def test_several_matrices_keep_their_depths(tmp_path):
    stack = np.array([np.eye(4), 2 * np.eye(4) + np.eye(4)[::-1] * 0])
    np.save(tmp_path / "k.npy", stack)
    text = f"matrix:file={tmp_path / 'k.npy'},eye_depth=((0.5,3),(3,inf)),selection=containment,resolution=77"
    p = technique_of(text)
    assert [part.eye_depth for part in p.partitions] == [(0.5, 3.0), (3.0, np.inf)]
    assert (p.selection, p.resolution, len(p.matrices)) == ("containment", 77, 2)
    (tmp_path / "k.txt").write_text("# first\n" + "\n".join(" ".join(map(str, row)) for m in stack for row in m))
    np.testing.assert_array_equal(technique_of(f"matrix:file={tmp_path / 'k.txt'}").matrices, stack)


KEPT = {
    "rectilinear": sl.library.scene("robots").light,
    "z_partition:count=2,inner=rectilinear/log_psm": sl.library.scene("robots").light,
    "log_psm": sl.library.scene("robots").light,
    "log": sl.library.scene("robots").light,
    "z_partition:count=3,inner=log_psm": sl.library.scene("robots").light,
    "face_partition": sl.library.scene("robots").light,
    "lispsm": sl.PointLight((0, 4, 0), range=40),
    "z_partition": sl.PointLight((0, 4, 0), range=40),
}


@pytest.mark.parametrize("convention", ["webgpu", "opengl"])
@pytest.mark.parametrize("name", KEPT)
def test_json_keeps_all_that_a_map_is(name, convention, tmp_path):
    scene = sl.library.scene("robots")
    made = sl.technique(name).parameterize(scene, scene.camera, KEPT[name], resolution=64)
    path = tmp_path / "p.json"
    path.write_bytes(written(made, "json", sl.Convention.of(convention)))
    back = sl.technique(f"matrix:file={path}")
    assert (back.selection, back.resolution) == (made.selection, made.resolution)
    np.testing.assert_allclose(back.matrices, made.matrices, rtol=1e-13, atol=1e-13)
    for mine, theirs in zip(back.partitions, made.partitions, strict=True):
        assert mine.eye_depth == theirs.eye_depth
        assert (mine.post_warp, mine.post_warp_terms) == (theirs.post_warp, theirs.post_warp_terms)
        assert_same_knots(mine, theirs)
        np.testing.assert_array_equal(mine.region, theirs.region)
    draw = [sl.Renderer("cpu").shadow_mask(scene, scene.camera, KEPT[name], p, size=(64, 36)) for p in (made, back)]
    draw = [np.nan_to_num(mask, nan=-1.0) for mask in draw]  # nothing is seen there in either
    assert np.mean(draw[0] != draw[1]) < 0.01  # the last digits of a convention and back may move a pixel
    lost = details(made, sl.Convention())[-1]
    assert lost.startswith("not kept in this format: ")
    for word, kind, kept in (("log", "log", "logarithms"), ("rectilinear", "rectilinear", "rectilinear warps")):
        assert any(part.post_warp == kind for part in made.partitions) == (word in name)
        assert (kept in lost) == (word in name)
    assert ("camera depths" in lost) == (len(made.matrices) > 1)
    names: dict = {"sl": sl, "np": np}
    again = eval(given_python(back), names)
    np.testing.assert_array_equal(again.matrices, back.matrices)
    for mine, theirs in zip(again.partitions, back.partitions, strict=True):
        assert (mine.eye_depth, mine.post_warp_terms) == (theirs.eye_depth, theirs.post_warp_terms)
        assert_same_knots(mine, theirs)
        np.testing.assert_array_equal(mine.region, theirs.region)


def assert_same_knots(mine, theirs):
    one, other = mine.post_warp_knots, theirs.post_warp_knots
    assert (one is None) == (other is None)
    for a, b in zip(one or (), other or (), strict=True):
        np.testing.assert_array_equal(a, b)


def test_what_follows_a_matrix_is_checked():
    one = np.eye(4)
    make = sl.Parameterization.from_matrix
    assert make(one, post_warp=[("log", 2, -1)]).partitions[0].post_warp_terms == {"scale": 2.0, "offset": -1.0}
    for bad in (3, [], [None, None], [("log", 0, 1)], [("exp", 1, 1)], [("log", 1, np.nan)], [7]):
        with pytest.raises(ArgumentError, match=r"post_warp: expected .* got "):
            make(one, post_warp=bad)
    with pytest.raises(ArgumentError, match="y up"):
        make(one, post_warp=[("log", 2, -1)], convention="vulkan")
    even, bent = [(-1, -1), (1, 1)], np.array([(-1, -1), (0.5, 0), (1, 1)])
    part = make(one, post_warp=[("rectilinear", even, bent)]).partitions[0]
    assert (part.post_warp, part.post_warp_terms) == ("rectilinear", {})
    np.testing.assert_array_equal(part.post_warp_knots[0], even)
    np.testing.assert_array_equal(part.post_warp_knots[1], bent)
    np.testing.assert_allclose(part.project([(0.5, 0.5, 0), (-2, 0.75, 0.1)])[0], [(0.5, 0, 0), (-2, 0.5, 0.1)])
    for bad in ([], [(0, 0)], [(0, 0), (1, 0)], [(1, 0), (0, 1)], [(0, 0), (1, np.nan)], [(0, 0, 0)], "even", 7):
        with pytest.raises(ArgumentError, match=r"post_warp: expected .* got "):
            make(one, post_warp=[("rectilinear", even, bad)])
        with pytest.raises(ArgumentError, match=r"post_warp: expected .* got "):
            make(one, post_warp=[("rectilinear", bad, even)])
    for changed in ("vulkan", "direct3d_texture", "unity"):
        with pytest.raises(ArgumentError, match="x to the right and y up"):
            make(one, post_warp=[("rectilinear", even, bent)], convention=changed)
        with pytest.raises(ArgumentError, match="x to the right and y up"):
            make(one, post_warp=[("rectilinear", even, bent)]).to(changed)
    assert make(one, post_warp=[("rectilinear", even, bent)]).to("opengl").shape == (4, 4)
    for bad in (3, [], [np.ones((9, 4))], [np.full((1, 4), np.nan)], [np.ones((1, 3))]):
        with pytest.raises(ArgumentError, match=r"regions: expected .* got "):
            make(one, regions=bad)


BAD_FILES = {
    "words": (b"not a matrix", "holds no matrices"),
    "seven.txt": (b"1 2 3 4\n5 6 7\n", "holds no matrices"),
    "binary": (bytes(range(256)), "holds no matrices"),
    "empty": (b"", "holds no matrices"),
    "broken.json": (b"{\"matrices\": [1,", "holds no matrices"),
    "bare.json": (b"{}", "holds no matrices"),
    "log.json": (b'{"matrix": [], "post_warp": [{"kind": "log"}]}', "holds no matrices"),
    "bent.json": (b'{"matrix": [], "post_warp": [{"kind": "bent"}]}', "unknown post_warp"),
    "zero.txt": (b"0 0 0 0\n" * 4, "singular"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_file_without_matrices_is_told(tmp_path, name):
    content, says = BAD_FILES[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises((LoadError, ArgumentError), match=says) as raised:
        technique_of(f"matrix:file={tmp_path / name}")
    assert "\n" not in str(raised.value)


def test_a_pickle_is_not_opened(tmp_path):
    stream = io.BytesIO()
    np.save(stream, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    (tmp_path / "p.npy").write_bytes(stream.getvalue())
    with pytest.raises(LoadError, match="holds no matrices"):
        technique_of(f"matrix:file={tmp_path / 'p.npy'}")


def test_a_matrix_technique_says_what_it_misses(tmp_path):
    with pytest.raises(ArgumentError, match="got no file"):
        technique_of("matrix")
    with pytest.raises(LoadError, match=r"cannot read .*check the path"):
        technique_of(f"matrix:file={tmp_path / 'none.npy'}")
    with pytest.raises(UnknownNameError, match="unknown field 'conv'"):
        technique_of("matrix:file=a,conv=opengl")


def view_of(*words):
    options = cli.given_options(["matrix", "@robots", *words])
    return cli.load_view(options, None)


def test_lights_of_the_command_line():
    scene, _, light, _ = view_of("--light-position", "1,9,-2", "--range", "30")
    assert light == sl.PointLight((1, 9, -2), range=30)
    low, high = np.asarray(scene.bounds)
    _, _, light, _ = view_of("--light-position", "1,9,-2")
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    assert light.range == pytest.approx(np.linalg.norm(corners - [1, 9, -2], axis=1).max())
    _, _, light, _ = view_of("--light-position", "1,9,-2", "--cone-deg", "60", "--range", "30")
    middle = (low + high) / 2
    assert light == sl.SpotLight((1, 9, -2), middle - [1, 9, -2], cone_angle=np.radians(60), range=30)
    _, _, light, _ = view_of("--light-position", "1,9,-2", "--cone-deg", "60", "--range", "30", "--light", "-1,-2,0")
    assert light == sl.SpotLight((1, 9, -2), (-1, -2, 0), cone_angle=np.radians(60), range=30)


@pytest.mark.parametrize(
    ("given_words", "says"),
    [
        (["--range", "3"], "range: expected a light with a place"),
        (["--cone-deg", "3"], "cone-deg: expected a light with a place"),
        (["--light-position", "0,5,0", "--light", "0,-1,0"], "--cone-deg makes it a spot"),
        (["--light-position", "0,5,0", "--cone-deg", "180"], "cone-deg: expected degrees"),
        (["--light-position", "0,5,0", "--cone-deg", "nan"], "cone-deg: expected degrees"),
        (["--light-position", "0,5"], "light-position: expected three numbers"),
        (["--light-position", "0,5,0", "--range", "0"], "range"),
        (["--light", "0,-1,0", "--light", "1,-1,0"], "light: expected one --light, got 2; shadowlab advise"),
        (["--convention", "glide"], "unknown name 'glide'"),
        (["--convention", "opengl:y=sideways"], "y: expected 'up' or 'down'"),
        (["--technique", "matrix:file=none.npy"], "none.npy"),
        (["--technique", "lispsm:near=(1"], "parenthesis"),
    ],
)
def test_a_mistake_is_one_line(given_words, says, capsys):
    assert cli.main(["matrix", "@robots", *given_words]) == 2
    err = capsys.readouterr().err.strip()
    assert says in err
    assert "\n" not in err
    assert "defect" not in err


@pytest.mark.parametrize(
    "light", [["--light-position", "0,6,1"], ["--light-position", "0,6,1", "--cone-deg", "80", "--light", "0,-1,-0.2"]]
)
def test_the_command_of_a_placed_light_gives_the_same_numbers(light, tmp_path, capsys):
    small = ["--resolution", "64", "--size", "64x36", "--backend", "cpu", "--out", str(tmp_path)]
    assert cli.main(["compare", "@robots", *light, *small]) == 0
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert cli.main(shlex.split(data["reproduce"]["command"])[1:]) == 0
    again = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert again["light"].keys() == data["light"].keys()
    for name in data["light"].keys() - {"kind"}:
        np.testing.assert_allclose(again["light"][name], data["light"][name], rtol=1e-14, atol=1e-15)
    assert [r["misclassified"] for r in again["runs"]] == [r["misclassified"] for r in data["runs"]]
    capsys.readouterr()


def test_the_command_line_names_a_difference(files, capsys):
    ours = files["folder"] / "ours.txt"
    np.savetxt(ours, files["matrix"])
    assert cli.main(["diagnose", str(ours), str(files["npy"])]) == 0
    out = capsys.readouterr().out
    assert out.startswith("the same map, written otherwise: z in [-1, 1]\nconvention: opengl\n")
    # JSON says how it is written: mine is read as ours, theirs is taken as it is.
    assert cli.main(["diagnose", str(files["json"]), str(ours)]) == 0
    assert capsys.readouterr().out.startswith("the matrices are equal")
    np.savetxt(ours, np.diag([0.5, 1, 1, 1]) @ files["matrix"])
    assert cli.main(["diagnose", str(ours), str(files["npy"]), "--resolution", "64"]) == 1
    assert "x scaled by 2" in capsys.readouterr().out
    assert cli.main(["diagnose", str(ours), str(files["npy"]), "--resolution", "64", "--resolution", "32"]) == 2
    assert "expected one number of texels, got '64,32'" in capsys.readouterr().err
    assert cli.main(["diagnose", str(ours), "none.npy"]) == 2
    assert "cannot read 'none.npy'" in capsys.readouterr().err
