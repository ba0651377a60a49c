"""The whole frustum as the body of receivers, and its outline."""

from __future__ import annotations

import doctest
import importlib

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing.frustum_body import outline
from shadowlab.errors import ArgumentError
from shadowlab.experiments.frustum_scene import frustum_scene

# Of float64 through a projection.
EXACT = 1e-12
CAMERAS = (
    sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=np.pi / 3, aspect=1.0, near=1, far=100),
    sl.Camera.look_at((70, -3, 12), (1, 2, 3), up=(0, 0, 1), fov_y=1.9, aspect=1.7, near=0.2, far=9),
    sl.Camera.look_at((1e5, 0, 0), (1e5, 1, 0.2), up=(0, 0, 1), fov_y=0.3, aspect=0.5, near=3, far=3000),
)


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_outline_lies_on_the_edges(camera):
    points = outline(camera, steps=5)
    assert points.shape == (12 * 5 - 4, 3)
    clip = np.c_[points, np.ones(len(points))] @ camera.clip_from_world.T
    ndc = clip[:, :3] / clip[:, 3:]
    # A point of an edge touches two of the six planes, a corner three.
    ends = np.stack(
        [np.abs(np.abs(ndc[:, 0]) - 1), np.abs(np.abs(ndc[:, 1]) - 1), np.minimum(ndc[:, 2], 1 - ndc[:, 2])]
    )
    touched = (np.abs(ends) < 1e-8).sum(axis=0)
    assert (touched[:8] == 3).all()
    assert (touched[8:] == 2).all()
    depth = (points - camera.eye) @ camera.forward
    np.testing.assert_allclose([depth.min(), depth.max()], [camera.near, camera.far], rtol=1e-9)
    assert len(np.unique(points.round(9), axis=0)) == len(points)


def test_the_outline_of_a_part():
    depth = -outline(CAMERAS[0], near=2, far=50, steps=2)[:, 2]
    np.testing.assert_allclose(np.unique(depth.round(9)), [2, 10, 50], rtol=EXACT)
    np.testing.assert_allclose(outline(CAMERAS[0], near=1, far=100), outline(CAMERAS[0]), rtol=EXACT)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("light", [(0.1, -1, 0.2), (0.3, -0.2, -1)])
def test_maps_hold_the_whole_frustum_and_no_more(camera, light):
    p = sl.technique("uniform").parameterize(frustum_scene(camera), camera, sl.DirectionalLight(light), resolution=1000)
    ndc, _ = p.partitions[0].project(outline(camera))
    inset = 1 - 2 * p.border_texels / p.resolution
    np.testing.assert_allclose([ndc[:, :2].min(axis=0), ndc[:, :2].max(axis=0)], [[-inset] * 2, [inset] * 2], rtol=1e-6)


def test_what_is_wrong_is_said():
    for call in (
        lambda: frustum_scene("eye"),
        lambda: outline(3),
        lambda: outline(CAMERAS[0], steps=0),
        lambda: outline(CAMERAS[0], near=5, far=2),
        lambda: outline(CAMERAS[0], far=np.inf),
    ):
        with pytest.raises(sl.errors.ArgumentError):
            call()


def test_what_is_no_camera_light_or_point_is_refused():
    camera, light = sl.Camera.look_at((0, 0, 0), (0, 0, -1)), sl.DirectionalLight((0, -1, 0))
    for given, says in (((3, light), "camera: expected a Camera"), ((camera, None), "light: expected")):
        with pytest.raises(ArgumentError, match=says):
            sl.aliasing.halfway_normals([[0, 0, -3]], *given)
    with pytest.raises(ArgumentError, match="points: expected an array"):
        sl.aliasing.halfway_normals("x", camera, light)
    with pytest.raises(ArgumentError, match="steps: expected at most"):
        sl.aliasing.outline(camera, steps=10**9)


@pytest.mark.parametrize("module", ["aliasing.beam_texels", "aliasing.frustum_body", "experiments.frustum_scene"])
def test_examples_run_as_pasted(module):
    module = importlib.import_module(f"shadowlab.{module}")
    examples = [e for e in doctest.DocTestFinder().find(module, globs={}) if e.examples]
    assert examples
    for example in examples:
        assert doctest.DocTestRunner().run(example).failed == 0
