"""Techniques that look at what the camera sees, and techniques within techniques, from Python."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError, UnsupportedError
from shadowlab.text import format_spec


@pytest.fixture(scope="module")
def scene():
    return sl.library.scene("courtyard")


@pytest.fixture(scope="module")
def seeing():
    """A technique that splits by the depths that are seen."""
    return sl.technique("z_partition", splits="equal-log", count=3)


def ends(p):
    return np.array([part.eye_depth[1] for part in p.partitions])


def test_samples_are_drawn_where_none_are_given(scene, seeing):
    assert seeing.needs_samples
    assert not sl.technique("z_partition").needs_samples
    own = seeing.parameterize(scene, scene.camera, scene.light, resolution=256)
    # The size that the documentation names: about 128 by 128 pixels of the camera's aspect, drawn by the CPU renderer.
    root = np.sqrt(scene.camera.aspect)
    g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(round(128 * root), round(128 / root)))
    given = seeing.parameterize(scene, scene.camera, scene.light, resolution=256, samples=g)
    np.testing.assert_array_equal(given.matrices, own.matrices)
    np.testing.assert_array_equal(ends(given), ends(own))


def test_samples_that_are_given_are_used(scene, seeing):
    near = sl.Camera.look_at(
        scene.camera.eye, np.add(scene.camera.eye, [0, -1, -0.2]), near=scene.camera.near, far=scene.camera.far
    )
    other = sl.Renderer("cpu").gbuffer(scene, near, size=64)  # the ground below the eye alone
    make = {
        name: seeing.parameterize(scene, scene.camera, scene.light, samples=g)
        for name, g in (("own", None), ("other", other))
    }
    assert ends(make["other"])[0] < ends(make["own"])[0]


@pytest.mark.parametrize("shadows", ["mapped", "traced", None])
def test_samples_of_a_view_are_those_of_its_gbuffer_light_by_light(scene, shadows):
    lights = [
        scene.light,
        sl.DirectionalLight((0.4, -1, 0.2)),
        sl.SpotLight((2, 12, 2), (0, -1, 0), cone_angle=1.2, range=60),
    ]
    view = sl.View(scene, scene.camera, lights, size=(64, 48))
    g = view.gbuffer("cpu")
    for light, samples in zip(lights, view.samples(shadows=shadows, renderer="cpu"), strict=True):
        states = sl._core.mapped_states(scene, scene.camera, light, g)
        if shadows == "traced":
            states = sl.trace.shadow_mask(scene, scene.camera, light, size=(64, 48))
        known = {} if shadows is None else {"light": light, "shadows": states}
        assert samples == sl._core.Samples.from_gbuffer(g, scene.camera, **known)


def test_samples_of_another_picture_are_refused(scene):
    first, other = (sl.View(scene, scene.camera, scene.light, size=(24, 18 + k)).gbuffer("cpu") for k in range(2))
    samples = sl._core.Samples.from_gbuffer(first, scene.camera)
    states = sl._core.mapped_states(scene, scene.camera, scene.light, other)
    with pytest.raises(ArgumentError, match="samples: expected"):
        sl._core.samples_under(samples, other, scene.light, states, 64)


@pytest.mark.parametrize("aspect", [1e-4, 1e4])
def test_a_camera_of_any_aspect_has_samples(scene, seeing, aspect):
    c = scene.camera
    thin = sl.Camera.look_at(c.eye, np.asarray(c.eye) + c.forward, aspect=aspect, near=c.near, far=c.far)
    assert np.isfinite(seeing.parameterize(scene, thin, scene.light, resolution=64).matrices).all()


def test_compare_hands_over_the_pixels_that_it_compares(scene):
    got = []

    class Seeing:
        name, settings, needs_samples = "seeing", {}, True

        def parameterize(self, scene, camera, light, *, resolution, samples):
            got.append(samples)
            return sl.technique("uniform").parameterize(scene, camera, light, resolution=resolution)

    study = sl.compare(
        scene, scene.camera, scene.light, [Seeing(), "z_partition:splits=min-max"],
        resolution=64, size=(64, 36), renderer="cpu", progress=False,
    )  # fmt: skip
    assert got[0] == sl.View(scene, scene.camera, scene.light, size=(64, 36)).samples(renderer="cpu")
    assert (got[0].size, got[0].receivers) == ((64, 36), np.count_nonzero(np.asarray(study.gbuffer.triangle) >= 0))
    assert study.table["failure"].tolist() == ["", ""]
    exact = sl.technique("z_partition:splits=min-max").parameterize(
        scene, scene.camera, scene.light, resolution=64, samples=study.gbuffer
    )
    np.testing.assert_array_equal(study.runs[1].parameterization.matrices, exact.matrices)


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a process work differently there")
def test_ctrl_c_stops_a_technique_that_draws():
    code = (
        "import os, signal, threading, shadowlab as sl\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "scene = sl.library.scene('forest')\n"
        "seeing = sl.technique('z_partition', splits='min-max')\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    for _ in range(100000): seeing.parameterize(scene, scene.camera, scene.light)\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.strip() == "stopped", done.stderr


@pytest.mark.parametrize(
    ("inner", "text"),
    [
        ("lispsm", "lispsm"),
        ("lispsm:near=optimal", "lispsm:near=optimal"),
        (sl.technique("lispsm"), "lispsm"),
        (sl.technique("lispsm", near="optimal"), "lispsm"),  # its default
        (sl.technique("lispsm", near="delta-z"), "lispsm:near=delta-z"),
        (
            [sl.technique("lispsm", near="delta-z", axis="middle"), "uniform"],
            "(lispsm:near=delta-z,axis=middle)/uniform",
        ),
        (("uniform", "lispsm:near=basic"), "uniform/(lispsm:near=basic)"),
    ],
    ids=str,
)
def test_techniques_within_techniques(scene, inner, text):
    outer = sl.technique("z_partition", count=3, inner=inner)
    assert outer.settings["inner"] == text
    again = sl.technique(format_spec(outer.name, outer.settings))
    assert again.settings == outer.settings
    made = [t.parameterize(scene, scene.camera, scene.light, resolution=128) for t in (outer, again)]
    np.testing.assert_array_equal(made[0].matrices, made[1].matrices)
    names = [one.partition(":")[0].strip("(") for one in text.split("/")]
    assert [part.technique for part in made[0].partitions] == (names + 3 * names[-1:])[:3]


@pytest.mark.parametrize(
    "distances", [(5, 20), [5.0, 20.0], np.array([5, 20]), np.array([5.0, 20.0], np.float32), "5,20"]
)
def test_lists_of_numbers(distances):
    one = sl.technique("z_partition", distances=distances)
    assert one.settings["distances"] == (5.0, 20.0)
    assert sl.technique(format_spec(one.name, one.settings)).settings == one.settings


def test_the_report_of_a_technique_within_a_technique_runs_again(scene):
    from shadowlab.reports.reproduce import command_line, python_snippet

    study = sl.compare(
        scene, scene.camera, scene.light, ["z_partition:distances=(5,20),inner=(lispsm:near=basic)/uniform"],
        resolution=64, size=(64, 36), renderer="cpu", progress=False,
    )  # fmt: skip
    names: dict = {}
    exec(compile(python_snippet(study, study.runs), "snippet", "exec"), names)
    assert names["study"].table["misclassified"].tolist() == study.table["misclassified"].tolist()
    assert "inner=(lispsm:near=basic)/uniform" in command_line(study, study.runs)


def test_what_is_wrong_is_told(scene, seeing):
    with pytest.raises(UnknownNameError, match="lipsm"):
        sl.technique("z_partition", inner="lipsm")
    for bad in (object(), {}, [], [1, "lispsm"]):
        with pytest.raises(ArgumentError, match="inner: expected"):
            sl.technique("z_partition", inner=bad)
    with pytest.raises(ArgumentError, match=r"samples: expected a shadowlab.Samples"):
        seeing.parameterize(scene, scene.camera, scene.light, samples="mine")
    with pytest.raises(UnsupportedError):
        sl.technique("log").parameterize(scene, scene.camera, sl.PointLight((0, 3, 0), range=9))
