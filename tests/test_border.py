"""The border between Python and Rust: types, errors, the GIL, Ctrl-C, and arrays that are not copied."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import errors
from shadowlab.errors import ArgumentError, DeviceError, ShadowlabError, UnknownNameError

CAMERA = sl.Camera.look_at((0, 0, -3), (0, 0, 1))
LIGHT = sl.DirectionalLight((0, 0, 1))
SCENE = sl.Scene.from_arrays([[-1, -1, 0.5], [1, -1, 0.5], [0, 1, 0.5]], [[0, 1, 2]])


def test_importing_the_package_touches_no_driver_and_no_heavy_library():
    code = (
        "import sys, shadowlab\n"
        "heavy = {'matplotlib', 'pandas', 'trimesh', 'tqdm'} & set(sys.modules)\n"
        "maps = open('/proc/self/maps').read() if sys.platform == 'linux' else ''\n"
        "drivers = [n for n in ('libvulkan', 'libGL', 'libEGL', 'libnvidia') if n in maps]\n"
        "assert not heavy and not drivers, (heavy, drivers)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.skipif(sys.platform != "linux", reason="the driver that prints is Mesa on Linux")
def test_looking_for_adapters_prints_nothing_and_leaves_the_environment_alone():
    code = "import os, shadowlab as sl; sl.Renderer(); sl._core.adapters(); assert 'XDG_RUNTIME_DIR' not in os.environ"
    environment = {k: v for k, v in os.environ.items() if k != "XDG_RUNTIME_DIR"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert (done.stdout, done.stderr) == ("", "")


def test_a_matrix_is_singular_by_its_rank_not_by_its_size():
    for scale in (1e-150, 1.0, 1e150):
        sl.Parameterization.from_matrix(np.diag([scale, scale, scale, 1.0]))


def test_unaligned_arrays_are_read_right():
    raw = bytearray(9 * 8 + 1)
    vertices = np.frombuffer(raw, np.uint8)[1:].view(np.float64).reshape(3, 3)
    vertices[:] = np.eye(3)
    assert not vertices.flags.aligned
    np.testing.assert_array_equal(sl.Scene.from_arrays(vertices, [[0, 1, 2]]).bounds, [[0, 0, 0], [1, 1, 1]])


def test_every_public_name_resolves_and_is_documented():
    for name in sl.__all__:
        value = getattr(sl, name)
        assert name.startswith("__") or value.__doc__, name
    with pytest.raises(AttributeError, match="nonsense"):
        _ = sl.nonsense


def test_every_error_has_the_base_and_a_builtin():
    for name in dir(errors):
        value = getattr(errors, name)
        if isinstance(value, type) and name.endswith("Error") and value is not ShadowlabError:
            assert issubclass(value, ShadowlabError)
            assert len([b for b in value.__mro__ if b.__module__ == "builtins"]) > 3


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 0)), ArgumentError, "target"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 1, 0), up=(0, 1, 0)), ArgumentError, "up: .*parallel.*leave it out"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, -1, 0), (0, 2, 0), height=1), ArgumentError, "up: .*parallel"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, 0, 1), height=0), ArgumentError, "height"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, 0, 1), height=np.inf), ArgumentError, "height"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, 0, 1), height=1, near=np.nan), ArgumentError, "near"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, 0, 1), height=1, far=np.inf), ArgumentError, "far.*perspective"),
        (lambda: sl.Camera.orthographic((0, 0, 0), (0, 0, 1), height=1, near=2, far=1), ArgumentError, "far.*near = 2"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), far=-np.inf), ArgumentError, "far"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), near=np.inf, far=np.inf), ArgumentError, "near"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), shift=(0, np.inf)), ArgumentError, "shift"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), shift="left"), ArgumentError, "shift"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), aspect=1e308, fov_y=3), ArgumentError, "aspect"),
        (lambda: CAMERA.corners(np.inf), ArgumentError, "depth"),
        (lambda: CAMERA.rays([(0, 0, 0)], 8), ArgumentError, "pixels"),
        (lambda: CAMERA.rays([(0, 0)], 0), ArgumentError, "size"),
        (lambda: CAMERA.rays([(0, np.nan)], 8), ArgumentError, "pixels"),
        (lambda: sl.Camera.look_at((0, 0, np.nan), (0, 0, 1)), ArgumentError, "eye.*finite"),
        (lambda: sl.Camera.look_at((0, 0), (0, 0, 1)), ArgumentError, r"eye.*\(3,\)"),
        (lambda: sl.Camera.look_at((0, 0, "a"), (0, 0, 1)), ArgumentError, "eye"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), near=2, far=1), ArgumentError, "far.*near = 2"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), near=1, far=1), ArgumentError, "far"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), near=0), ArgumentError, "near"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), fov_y=0), ArgumentError, "fov_y.*radians"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), fov_y=60), ArgumentError, "np.radians"),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), aspect=0), ArgumentError, "aspect"),
        (lambda: sl.DirectionalLight((0, 0, 0)), ArgumentError, "direction"),
        (lambda: sl.DirectionalLight((np.inf, 0, 0)), ArgumentError, "direction"),
        (lambda: sl.SpotLight((0, 0, 0), (0, 1, 0), cone_angle=4, range=1), ArgumentError, "cone_angle"),
        (lambda: sl.SpotLight((0, 0, 0), (0, 1, 0), cone_angle=1, range=0), ArgumentError, "range"),
        (lambda: sl.PointLight((0, 0, np.nan), range=1), ArgumentError, "position"),
        (lambda: sl.Renderer("cuda"), UnknownNameError, "auto, cpu, gpu"),
        (lambda: sl.Renderer("gpu", adapter="no such card"), DeviceError, "no such card"),
        (lambda: sl.technique("nonsense"), UnknownNameError, "lispsm"),
        (lambda: sl.technique("lispsm", nonsense=1), UnknownNameError, "near"),
        (lambda: sl.technique("lispsm", near="nonsense"), ArgumentError, "near"),
        (lambda: sl.technique("lispsm", near_factor=-1), ArgumentError, "near_factor"),
        (lambda: sl.technique("uniform", focus=[1]), ArgumentError, "focus"),
        (lambda: sl.library.scene("nonsense"), UnknownNameError, "courtyard"),
        (lambda: sl.library.scene("forest", nonsense=1), UnknownNameError, "trees"),
        (lambda: sl.library.scene("forest", trees=-1), ArgumentError, "trees"),
        (lambda: sl.library.scene("forest", trees="many"), ArgumentError, "trees"),
        (lambda: sl.library.scene("robots", seed=-1), ArgumentError, "seed"),
        (lambda: sl.Parameterization.from_matrix(np.eye(3)), ArgumentError, r"\(4, 4\)"),
        (lambda: sl.Parameterization.from_matrix(np.full((4, 4), np.nan)), ArgumentError, "finite"),
        (lambda: sl.Parameterization.from_matrix(np.zeros((0, 4, 4))), ArgumentError, "at least one"),
        (lambda: sl.Parameterization.from_matrix(np.zeros((4, 4))), ArgumentError, "singular"),
        (lambda: sl.Parameterization.from_matrix(np.eye(4), resolution=1.5), ArgumentError, "resolution"),
        (lambda: sl.Renderer("cpu").shadow_map("city.glb", np.eye(4)), ArgumentError, "load_scene"),
        (lambda: sl.Renderer("cpu").gbuffer(SCENE, LIGHT, size=4), ArgumentError, "camera.*look_at"),
        (lambda: sl.Renderer("cpu").shadow_mask(SCENE, CAMERA, CAMERA, np.eye(4), size=4), ArgumentError, "light"),
        (
            lambda: sl.Renderer("cpu").shadow_mask(SCENE, CAMERA, LIGHT, np.eye(4), size=4, bias=0.1),
            ArgumentError,
            "unit",
        ),
        (lambda: sl.technique("uniform").parameterize(None, CAMERA, LIGHT), ArgumentError, "scene.*NoneType"),
        (lambda: sl.technique("uniform").parameterize(SCENE, CAMERA, LIGHT, resolution=1.5), ArgumentError, "1.5"),
        (lambda: sl.technique("uniform").parameterize(SCENE, CAMERA, LIGHT, resolution=0), ArgumentError, "16384"),
        (lambda: sl.Scene.from_arrays(np.eye(3), [[True, False, True]]), ArgumentError, "truth values"),
        (lambda: sl.Bias(slope=-1), ArgumentError, "slope"),
        (lambda: sl.Bias(world=np.nan), ArgumentError, "world"),
        (lambda: sl.Stored("front", limit=-1), ArgumentError, "stored.limit"),
        (lambda: sl.Stored("front:depth=3"), UnknownNameError, "spacing, format, limit"),
        (lambda: sl.Stored("fornt"), UnknownNameError, "midpoint"),
        (lambda: sl.Stored(spacing="log"), UnknownNameError, "linear"),
        (lambda: sl.Stored(format="f64"), UnknownNameError, "unorm24"),
        (lambda: sl.Renderer("cpu").shadow_map(SCENE, np.eye(4), stored=4), ArgumentError, "stored.*Stored"),
        (lambda: sl.Stored().step(np.eye(4), [[9.0, 0.0, 0.0]]), ArgumentError, r"points\[0\]"),
        (lambda: sl.trace.first_hit(SCENE, [[0, 0, 0]], [[0, 0, 0]]), ArgumentError, "direction"),
        (lambda: sl.trace.first_hit(SCENE, [[0, 0, 0]], [[0, 0, 1], [0, 0, 1]]), ArgumentError, r"\(1, 3\)"),
        (lambda: sl.trace.first_hit(SCENE, [[0, 0, np.nan]], [[0, 0, 1]]), ArgumentError, "finite"),
        (lambda: sl.trace.occluded(SCENE, [[0, 0, 0]], [[0, 0, 1]], np.nan), ArgumentError, "t_max"),
        (lambda: sl.aliasing.misclassified(np.ones((2, 2)), np.ones((2, 3))), ArgumentError, "truth"),
        (lambda: sl.aliasing.misclassified(np.ones((0, 0)), np.ones((0, 0), np.int8)), ArgumentError, "pixel"),
    ],
)
def test_bad_input_is_a_typed_error_that_helps(call, error, match):
    with pytest.raises(error, match=match) as caught:
        call()
    assert isinstance(caught.value, ShadowlabError)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("bad", [0, -1, 16385, (4, 0), (1, 2, 3), 1.5, "big", None])
def test_bad_sizes(bad):
    camera, light = sl.Camera.look_at((0, 0, -3), (0, 0, 1)), sl.DirectionalLight((0, 0, 1))
    r = sl.Renderer("cpu")
    with pytest.raises(ArgumentError, match=r"size.*16384"):
        r.gbuffer(SCENE, camera, size=bad)
    with pytest.raises(ArgumentError, match=r"size.*16384"):
        sl.trace.shadow_mask(SCENE, camera, light, size=bad)
    if bad is not None:
        with pytest.raises(ArgumentError, match=r"resolution.*16384"):
            r.shadow_map(SCENE, np.eye(4), resolution=bad)


def test_shadow_map_of_a_bare_matrix_and_of_several():
    r = sl.Renderer("cpu")
    one = r.shadow_map(SCENE, np.eye(4), resolution=(8, 4))
    assert (one.shape, one.dtype) == ((4, 8), np.float32)
    assert one.flags.owndata or one.base is not None
    np.testing.assert_allclose(one[one < 1], 0.5, atol=1e-6)
    several = r.shadow_map(SCENE, np.stack([np.eye(4)] * 3), resolution=4)
    assert several.shape == (3, 4, 4)


def test_gbuffer_arrays_are_handed_over_once():
    camera = sl.Camera.look_at((0, 0, -3), (0, 0, 1))
    g = sl.Renderer("cpu").gbuffer(SCENE, camera, size=(16, 9))
    assert g.depth.shape == (9, 16)
    assert g.position.shape == g.normal.shape == (9, 16, 3)
    assert np.shares_memory(g.depth, g.depth)
    assert np.shares_memory(g.position, g.position)
    hit = g.triangle >= 0
    np.testing.assert_allclose(g.position[hit][:, 2], 0.5, atol=1e-6)
    np.testing.assert_allclose(g.normal[hit], [[0, 0, -1]] * hit.sum(), atol=1e-6)


def test_triangle_numbers_are_the_callers_rows_even_where_faces_were_dropped():
    vertices = [[-1, -1, 0.5], [1, -1, 0.5], [0, 1, 0.5], [np.nan, 0, 0]]
    with pytest.warns(errors.ShadowlabWarning):
        scene = sl.Scene.from_arrays(vertices, [[0, 1, 3], [3, 1, 2], [0, 1, 2]])
    camera = sl.Camera.look_at((0, 0, -3), (0, 0, 1))
    g = sl.Renderer("cpu").gbuffer(scene, camera, size=32)
    assert set(np.unique(g.triangle)) == {-1, 2}
    t, triangle, instance = sl.trace.first_hit(scene, [[0, 0, -3]], [[0, 0, 1]])
    assert (t[0], triangle[0], instance[0]) == (pytest.approx(3.5), 2, 0)


def test_long_work_releases_the_gil():
    scene = sl.library.scene("courtyard")
    r, ticks = sl.Renderer("cpu"), []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    for _ in range(5):
        r.gbuffer(scene, scene.camera, size=2048)
    inside = len(ticks) - before
    stop.set()
    thread.join()
    assert inside > 10


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a process work differently there")
def test_ctrl_c_stops_long_work():
    code = (
        "import os, signal, threading, time, shadowlab as sl\n"
        # Started in the background of a script, a process inherits that SIGINT is ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "scene = sl.library.scene('forest')\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    for _ in range(1000): sl.trace.shadow_mask(scene, scene.camera, scene.light, size=4096)\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped')\n"
    )
    start = time.monotonic()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.strip() == "stopped", done.stderr
    assert time.monotonic() - start < 60


def test_progress_is_reported():
    scene = sl.library.scene("robots")
    seen = []
    sl._core.trace_shadow_mask(
        scene, scene.camera, scene.light, size=256, progress=lambda done, total: seen.append((done, total))
    )
    assert seen
    assert seen[-1][0] == seen[-1][1] > 0


def test_an_exception_in_the_progress_callback_comes_back():
    scene = sl.library.scene("robots")

    def fail(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sl._core.trace_shadow_mask(scene, scene.camera, scene.light, size=64, progress=fail)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), fov_y=5e-324), ("fov_y", "aspect", "5e-324")),
        (lambda: sl.Camera.look_at((0, 0, 0), (0, 0, 1), near=1e300), ("far", "near = 1e300")),
        (lambda: sl.SpotLight((0, 0, 0), (0, 0, 1), cone_angle=1e-300, range=1), ("cone_angle", "1e-300")),
        (lambda: sl.aliasing.footprint_at(np.zeros((3, 3)), np.ones((2, 3)), CAMERA, LIGHT, np.eye(4), size=8),
         ("normals", "points", "(3, 3)")),
        (lambda: sl.Samples.from_arrays(np.zeros((3, 3)), np.ones((2, 3)), camera=CAMERA), ("normals", "positions")),
        (lambda: sl.trace.occluded(SCENE, np.zeros((3, 3)), np.ones((2, 3))), ("directions", "origins")),
        (lambda: SCENE.with_ground(height=1e308), ("height", "size")),
        (lambda: sl.Convention.opengl().in_atlas(2, 10**9), ("columns", "rows")),
        (lambda: sl.TemporalFit(slack=10**5000), ("slack",)),
    ],
)  # fmt: skip
def test_messages_name_all_that_belong_together_and_are_short(call, words):
    with pytest.raises(ArgumentError) as caught:
        call()
    text = str(caught.value)
    assert all(word in text for word in words), text
    assert len(text) < 300, text


def test_every_message_is_on_one_line_that_can_be_written():
    for error in (errors.LoadError("a\nb\r\nc\udc80: expected"), errors.ArgumentError("a\n b")):
        text = str(error)
        assert "\n" not in text
        assert text.encode("utf-8").decode() == text


def test_long_lists_are_the_arrays_that_they_list():
    """They are read in parts; one part of another kind counts as before."""
    many = np.arange(3.0 * 70_000).reshape(-1, 3)
    np.testing.assert_array_equal(CAMERA.depth(many.tolist()), CAMERA.depth(many))
    mixed = many.tolist()
    mixed[-1] = [0, 0, 0]
    assert CAMERA.depth(mixed)[-1] == CAMERA.depth([[0, 0, 0]])[0]
    for wrong in ([0.0, 0.0], ["a", 0, 0], [None, 0, 0]):
        mixed[-1] = wrong
        with pytest.raises(ArgumentError, match=r"^points: expected an array"):
            CAMERA.depth(mixed)
