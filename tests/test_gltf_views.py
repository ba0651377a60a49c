"""Cameras and lights of glTF, and their names on the command line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from gltf_support import Gltf, loaded, told, written

import shadowlab as sl
from shadowlab import cli
from shadowlab.errors import ArgumentError, LoadError, UnknownNameError
from shadowlab.scene.placed import unique

HALF = np.sqrt(0.5)
#: From -z down to -y.
DOWN = [-HALF, 0, 0, HALF]
FLOOR = [[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]]
LENS = {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.5, "zfar": 40}
PUNCTUAL = "KHR_lights_punctual"


def floor(lights=(), **top) -> Gltf:
    gltf = Gltf(**top)
    if lights:
        gltf.json.update(extensionsUsed=[PUNCTUAL], extensions={PUNCTUAL: {"lights": list(lights)}})
    gltf.node(mesh=gltf.mesh(FLOOR, [0, 1, 2, 0, 2, 3]))
    return gltf


def with_camera(lens=None, kind="perspective", camera=None, **node) -> Gltf:
    gltf = floor()
    gltf.add("cameras", **{"type": kind, kind: LENS if lens is None else lens, **(camera or {})})
    gltf.node(camera=0, **node)
    return gltf


def lit(light, **node) -> Gltf:
    gltf = floor([light])
    gltf.node(extensions={PUNCTUAL: {"light": 0}}, **node)
    return gltf


def test_a_camera_stands_where_its_nodes_put_it(tmp_path):
    gltf = with_camera(translation=[0, 3, 0], name="eye")
    gltf.node(children=[1], translation=[1, 0, 2])
    scene = loaded(tmp_path, gltf.scene(0, 2))
    assert dict(scene.cameras) == {
        "eye": sl.Camera.look_at((1, 3, 2), (1, 3, 1), fov_y=0.8, aspect=1.5, near=0.5, far=40)
    }


@pytest.mark.parametrize(
    ("node", "camera", "expected"),
    [
        ({"name": "a"}, {"name": "b"}, "a"),
        ({}, {"name": "b"}, "b"),
        ({}, {}, "camera 1"),
        ({"name": ""}, {}, "camera 1"),
    ],
)
def test_names(tmp_path, node, camera, expected):
    assert list(loaded(tmp_path, with_camera(camera=camera, **node)).cameras) == [expected]
    scene = loaded(tmp_path, lit({"type": "directional", **camera}, **node))
    assert list(scene.lights) == [expected.replace("camera", "light")]


def test_equal_names_are_numbered(tmp_path):
    gltf = with_camera(name="eye")
    gltf.node(camera=0, name="eye", translation=[0, 1, 0])
    assert list(loaded(tmp_path, gltf).cameras) == ["eye", "eye (2)"]
    assert unique("a", {"a": 1, **{f"a ({k})": k for k in range(2, 100)}}) == "a (100)"


def test_a_camera_without_far_plane_or_aspect_is_completed(tmp_path):
    gltf = with_camera({"yfov": 1.0, "znear": 0.1}, translation=[0, 3, 9], name="eye")
    scene, text = told(tmp_path, gltf)
    camera = scene.cameras["eye"]
    assert camera.aspect == pytest.approx(16 / 9)
    assert camera.far == np.inf
    assert "'eye' has no aspect ratio" in text


def test_scaled_cameras(tmp_path):
    """Depths follow the scale; a scale along the picture's axes stretches the picture."""
    camera = loaded(tmp_path, with_camera(scale=[2, 2, 2])).cameras["camera 1"]
    assert (camera.near, camera.far) == pytest.approx((1, 80))
    assert (camera.fov_y, camera.aspect) == pytest.approx((0.8, 1.5))
    camera = loaded(tmp_path, with_camera(scale=[3, 2, 1])).cameras["camera 1"]
    # A point on the upper right edge of the picture at depth 2, in the camera's own space.
    y = 2 * np.tan(0.4)
    clip = camera.clip_from_world @ [3 * 1.5 * y, 2 * y, -2, 1]
    np.testing.assert_allclose(clip[:2] / clip[3], [1, 1], rtol=1e-6)


@pytest.mark.parametrize(
    ("gltf", "match"),
    [
        (with_camera(scale=[-1, 1, 1], name="flip"), "flip.*mirrors"),
        (with_camera(scale=[0, 1, 1], name="flat"), "flat.*flattens"),
        (with_camera(matrix=[1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], name="skew"), "skew.*shears"),
        (with_camera({**LENS, "yfov": 4}, name="wide"), "wide.*fov"),
        (with_camera({**LENS, "znear": 0}, name="close"), "close.*near"),
        (with_camera({**LENS, "zfar": 0.1}, name="short"), "short.*far"),
        (with_camera({**LENS, "aspectRatio": -1}, name="odd"), "odd.*aspect"),
    ],
)
def test_cameras_that_cannot_be_taken_are_told(tmp_path, gltf, match):
    with pytest.warns(sl.errors.ShadowlabWarning, match=f"left out camera '{match.replace('.*', chr(39) + '.*')}"):
        scene = sl.load_scene(written(tmp_path, gltf))
    assert not scene.cameras
    assert scene.triangle_count == 2


def test_an_orthographic_camera(tmp_path):
    lens = {"xmag": 3, "ymag": 2, "znear": 0.5, "zfar": 9}
    gltf = with_camera(lens, "orthographic", name="map", translation=[1, 5, 3], rotation=DOWN, scale=[2, 2, 2])
    camera = loaded(tmp_path, gltf).cameras["map"]
    assert camera.is_orthographic
    np.testing.assert_allclose(camera.eye, [1, 5, 3])
    np.testing.assert_allclose(camera.forward, [0, -1, 0], atol=1e-7)
    assert (camera.height, camera.aspect, camera.near, camera.far) == pytest.approx((8, 1.5, 1, 18))


@pytest.mark.parametrize(
    "camera",
    [{"type": "fisheye"}, {"type": "perspective"}, {"type": "perspective", "perspective": {"yfov": 1}}, {}, 5],
)
def test_broken_cameras(tmp_path, camera):
    gltf = with_camera()
    gltf.json["cameras"] = [camera]
    with pytest.raises(LoadError, match="cameras"):
        loaded(tmp_path, gltf)


def test_lights_of_all_kinds_with_their_world_transforms(tmp_path):
    gltf = floor([
        {"type": "directional", "intensity": 3},
        {"type": "spot", "range": 12, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.4}},
        {"type": "point", "range": 6},
        {"type": "spot", "range": 1},
    ])  # fmt: skip
    for i, name in enumerate(("sun", "spot", "lamp", "plain")):
        gltf.node(extensions={PUNCTUAL: {"light": i}}, name=name, translation=[0, i, 0], rotation=DOWN)
    # Scale changes places, and neither range nor cone.
    gltf.node(children=[1, 2, 3, 4], scale=[2, 2, 2])
    scene = loaded(tmp_path, gltf.scene(0, 5))
    lights = scene.lights
    assert list(lights) == ["sun", "spot", "lamp", "plain"]
    np.testing.assert_allclose(lights["sun"].direction, [0, -1, 0], atol=1e-9)
    np.testing.assert_allclose(lights["spot"].direction, [0, -1, 0], atol=1e-9)
    # Theirs is half of the cone, ours all of it.
    assert (lights["spot"].cone_angle, lights["spot"].range, lights["spot"].position.tolist()) == (0.8, 12, [0, 2, 0])
    assert lights["lamp"] == sl.PointLight((0, 4, 0), range=6)
    assert lights["plain"].cone_angle == pytest.approx(np.pi / 2)


def test_a_light_without_a_range_reaches_the_scene(tmp_path):
    for light in ({"type": "point"}, {"type": "spot"}):
        scene = loaded(tmp_path, lit(light, translation=[0, 50, 0]))
        (found,) = scene.lights.values()
        assert 50.3 < found.range < 60


def test_lights_that_cannot_be_taken_are_told(tmp_path):
    wide = {"type": "spot", "range": 2, "spot": {"outerConeAngle": np.pi / 2}}
    for light, node in (
        (wide, {}),
        ({"type": "point", "range": 0}, {}),
        ({"type": "directional"}, {"scale": [1, 1, 0]}),
    ):
        scene, text = told(tmp_path, lit(light, name="lamp", **node))
        assert not scene.lights
        assert "left out light 'lamp'" in text
    for light in ({"type": "area"}, {}, {"type": "point", "range": "far"}, {"type": "spot", "spot": 5}):
        with pytest.raises(LoadError, match=r"lights\[0\]"):
            loaded(tmp_path, lit(light))
    gltf = lit({"type": "point"})
    gltf.json["nodes"][1]["extensions"][PUNCTUAL]["light"] = 1
    with pytest.raises(LoadError, match="light: expected one of the file's 1 lights"):
        loaded(tmp_path, gltf)


def test_an_invisible_node_lights_nothing_and_sees(tmp_path):
    gltf = lit({"type": "point", "range": 3}, translation=[0, 1, 0])
    gltf.add("cameras", type="perspective", perspective=LENS)
    gltf.json["nodes"][1].update(camera=0)
    gltf.json["nodes"][1]["extensions"]["KHR_node_visibility"] = {"visible": False}
    scene = loaded(tmp_path, gltf)
    assert not scene.lights
    assert len(scene.cameras) == 1


def test_cameras_and_lights_outside_of_the_scene_are_left_out(tmp_path):
    gltf = with_camera()
    assert not loaded(tmp_path, gltf.scene(0)).cameras


def test_a_turned_file_turns_its_cameras(tmp_path):
    scene = sl.load_scene(written(tmp_path, with_camera(name="eye", translation=[1, 2, 3])), up="z")
    np.testing.assert_allclose(scene.cameras["eye"].eye, [1, 3, -2])


@pytest.fixture
def stage(tmp_path):
    """A file with a block on a floor, a rolled camera, a sun and a lamp."""
    gltf = floor([{"type": "directional"}, {"type": "spot", "range": 30}])
    points = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]]
    gltf.node(mesh=gltf.mesh(points, [0, 1, 2, 0, 2, 3]))
    gltf.add("cameras", type="perspective", perspective=LENS)
    roll = [0, 0, np.sin(0.1), np.cos(0.1)]
    gltf.node(camera=0, name="Shot 1", translation=[0, 1.5, 9], rotation=roll)
    tilt = [-np.sin(0.5), 0, 0, np.cos(0.5)]
    gltf.node(extensions={PUNCTUAL: {"light": 0}}, name="Sun", rotation=tilt)
    gltf.node(extensions={PUNCTUAL: {"light": 1}}, name="Lamp", translation=[0, 6, 4], rotation=tilt)
    return str(written(tmp_path, gltf))


SMALL = ("--size", "48x32", "--resolution", "64", "--backend", "cpu", "--technique", "uniform")


def results(folder):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("light", ["Sun", "Lamp"])
def test_named_cameras_and_lights_are_taken_and_repeated(run, stage, tmp_path, light):
    words = ("compare", stage, "--camera", "Shot 1", "--light", light)
    status, out, err = run(*words, *SMALL, "--out", tmp_path / "a")
    assert status == 0, err
    scene = sl.load_scene(stage)
    data = results(tmp_path / "a")
    np.testing.assert_allclose(data["camera"]["eye"], scene.cameras["Shot 1"].eye)
    assert f"--camera='Shot 1' --light={light}" in out.replace("'--camera=Shot 1'", "--camera='Shot 1'")
    assert "The file brings" not in out
    # The command of the report repeats it, though the camera is rolled.
    import shlex

    command = shlex.split(data["reproduce"]["command"])
    assert run(*command[1:-2], "--out", tmp_path / "b")[0] == 0
    again = results(tmp_path / "b")
    assert (again["camera"], again["light"]) == (data["camera"], data["light"])


def test_what_a_file_brings_is_said_once(run, stage, tmp_path):
    _, out, _ = run("compare", stage, *SMALL, "--out", tmp_path / "a")
    assert out.count("The file brings camera Shot 1 (--camera NAME) and lights Sun, Lamp (--light NAME).") == 1
    status, out, err = run(
        "advise", stage, "--light", "Sun", "--light", "Lamp", "--camera", "Shot 1", "--memory", "16KiB",
        "--size", "48x32", "--technique", "uniform", "--backend", "cpu", "--out", tmp_path / "b",
    )  # fmt: skip
    assert status == 0, err
    assert "--light=Sun --light=Lamp" in out


def view_of(*words):
    options = cli.given_options(["matrix", *words])
    return cli.load_view(options, None)


def test_settings_beside_a_named_camera(stage):
    own = sl.load_scene(stage).cameras["Shot 1"]
    _, camera, _, _ = view_of(stage, "--camera", "Shot 1")
    assert camera == own
    _, camera, _, _ = view_of(stage, "--camera", "Shot 1", "--near", "1", "--fov-deg", "30")
    assert camera == own.replace(near=1.0, fov_y=np.radians(30))
    _, camera, light, _ = view_of(stage, "--light", "Lamp")
    assert light == sl.load_scene(stage).lights["Lamp"]
    assert camera == sl.default_view(sl.load_scene(stage))[0]
    _, camera, light, _ = view_of(stage, "--camera", "Shot 1", "--light", "0,-1,0", "--ground")
    assert (camera, light) == (own, sl.DirectionalLight((0, -1, 0)))


@pytest.mark.parametrize(
    ("words", "error", "match"),
    [
        (["--camera", "Shot"], UnknownNameError, "camera: unknown name 'Shot'; expected one of Shot 1"),
        (["--light", "Moon"], UnknownNameError, "light: unknown name 'Moon'; expected one of Sun, Lamp"),
        (["--camera", "Shot 1", "--eye", "1,2,3"], ArgumentError, "no --eye"),
        (["--camera", "Shot 1", "--view", "above"], ArgumentError, "no --view"),
        (["--light", "Sun", "--cone-deg", "30"], ArgumentError, "no --cone-deg"),
        (["--light", "Sun", "--light-position", "1,2,3"], ArgumentError, "no --light-position"),
        (["--light", "1,2"], ArgumentError, "light"),
        (["--light", ""], ArgumentError, "light"),
        (["--camera", ""], UnknownNameError, "camera"),
    ],
)
def test_names_that_are_wrong(stage, words, error, match):
    with pytest.raises(error, match=match):
        view_of(stage, *words)


def test_scenes_without_cameras_say_so(mesh):
    for word, match in (("--camera", "--eye"), ("--light", "--light dx,dy,dz")):
        with pytest.raises(UnknownNameError, match=f"brings none: {match}"):
            view_of(mesh, word, "any")
    with pytest.raises(UnknownNameError, match="brings none"):
        view_of("@robots", "--camera", "any")
