"""Views that hold a whole scene: at any scale, flat, or a single triangle. Places are in test_default_views.py."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.text.checks import VIEWS

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def scene_of(vertices):
    return sl.Scene.from_arrays(vertices, [[0, 1, 2]])


def box(low, high):
    low, high = np.asarray(low, float), np.asarray(high, float)
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    return sl.Scene.from_arrays(corners, [[i, (i + 1) % 8, (i + 3) % 8] for i in range(8)])


DEGENERATE = {
    "triangle": scene_of(TRIANGLE),
    "unit box": box((-1, -1, -1), (1, 1, 1)),
    "flat": box((-50, 0, -50), (50, 0, 50)),
    "wall": box((0, 0, -5), (0, 9, 5)),
    "pole": box((3, 0, 3), (3, 100, 3)),
    "tiny": scene_of(1e-6 * TRIANGLE),
    "huge": scene_of(1e9 * TRIANGLE),
    "far away": scene_of(TRIANGLE + np.array([455_000.0, 30.0, -5_900_000.0])),
    "one line": scene_of([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]]),
    "one point": scene_of(np.zeros((3, 3))),
    "one point far away": scene_of(np.full((3, 3), 1e6)),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
@pytest.mark.parametrize("name", DEGENERATE)
def test_the_whole_scene_is_in_the_picture(name, aspect, view):
    scene = DEGENERATE[name]
    camera, light = sl.default_view(scene, aspect=aspect, view=view)
    assert camera.aspect == aspect
    assert 0 < camera.near < camera.far
    assert np.isfinite(light.direction).all()
    assert light.direction[1] < 0
    vertices = scene.to_arrays()[0]
    clip = np.column_stack([vertices, np.ones(len(vertices))]) @ camera.clip_from_world.T
    # Coordinates of 1e6 times a view of the last digits: what rounding leaves of a margin of 6 %.
    slack = 1.0 if name != "one point far away" else 1.2
    assert (np.abs(clip[:, :2]) <= slack * clip[:, 3:]).all()
    depth = camera.depth(vertices)
    assert (depth >= camera.near).all()
    assert (depth <= camera.far).all()


def ndc_of(scene, camera):
    vertices = scene.to_arrays()[0]
    clip = np.column_stack([vertices, np.ones(len(vertices))]) @ camera.clip_from_world.T
    return clip[:, :2] / clip[:, 3:]


DISC = np.array([[np.cos(t), 0, np.sin(t)] for t in np.linspace(0, 2 * np.pi, 50)])
FILLED = {
    "unit box": DEGENERATE["unit box"],
    "a single triangle": DEGENERATE["triangle"],
    "a disc, whose box has corners in the air": sl.Scene.from_arrays(DISC, [[0, i, i + 1] for i in range(1, 49)]),
    "a slope, far from its box's corners": scene_of([[0.0, 0, 0], [1, 5, 9], [1.2, 5, 9]]),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("name", FILLED)
def test_the_picture_is_filled(name, aspect, view):
    camera, _ = sl.default_view(FILLED[name], aspect=aspect, view=view)
    ndc = ndc_of(FILLED[name], camera)
    assert 0.93 < np.abs(ndc).max() <= 0.95  # what the margin leaves
    # Centred: as much room on one side as on the other, along the axis that is filled.
    assert abs(ndc.max(axis=0) + ndc.min(axis=0)).min() < 0.01


def test_instances_are_framed_one_by_one_or_by_their_boxes(monkeypatch):
    """Spheres on a slope: framed by vertices, and with boxes a little looser; never cut."""
    turns = np.random.default_rng(3).normal(size=(400, 3))
    ball = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    mesh = sl.Scene.from_arrays(ball, np.arange(399).reshape(-1, 3)).meshes[0]
    transforms = np.tile(np.eye(4), (30, 1, 1))
    transforms[:, :3, 3] = np.arange(30)[:, None] * np.array([1.0, 0.3, -2.0])
    scene = sl.Scene([mesh], np.zeros(30, int), transforms)
    exact, _ = sl.default_view(scene)
    assert 0.93 < np.abs(ndc_of(scene, exact)).max() <= 0.95
    monkeypatch.setattr("shadowlab.scene.framing.VERTICES_AT_ONCE", 7)
    piecewise, _ = sl.default_view(scene)
    np.testing.assert_allclose(piecewise.eye, exact.eye, rtol=1e-12)
    monkeypatch.setattr("shadowlab.scene.framing.MOST_VERTICES", 100)
    loose, _ = sl.default_view(scene)
    assert 0.8 < np.abs(ndc_of(scene, loose)).max() <= 0.95


def test_a_line_along_the_view_is_not_in_the_eye():
    from shadowlab.scene.framing import INSIDE_DEPTH_RATIO, fitting_offset, orientation

    right, up, forward = orientation(0.5, 0.5)
    line = np.outer([0.0, 3.0, 10.0], forward)
    depth = (line - fitting_offset(line, right, up, forward, 0.9, 1.0)) @ forward
    np.testing.assert_allclose(depth.max() / depth.min(), INSIDE_DEPTH_RATIO, rtol=1e-9)


def test_a_strip_along_the_diagonal_is_seen_from_the_side_that_shows_more(monkeypatch):
    def area(side):
        ahead, across = np.array([17.0, 0, side * 10.0]), np.array([side * -1.0, 0, 1.7])
        corners = [-ahead - across, ahead - across, ahead + across, -ahead + across]
        strip = sl.Scene.from_arrays(corners, [[0, 1, 2], [0, 2, 3]])
        return np.ptp(ndc_of(strip, sl.default_view(strip)[0]), axis=0).prod()

    chosen = [area(side) for side in (1, -1)]
    monkeypatch.setattr("shadowlab.scene.framing.OTHER_SIDE_GAIN", np.inf)
    usual = [area(side) for side in (1, -1)]
    assert min(chosen) > 1.25 * min(usual)
    assert max(chosen) == max(usual)


def test_a_city_fills_the_picture(shared_scenes):
    """A flat town, cut round: the corners of its box are empty."""
    found = sorted(path for path in shared_scenes.rglob("*delft*") if path.suffix in (".glb", ".ply", ".obj"))
    if not found:
        pytest.skip("no town among the shared scenes")
    scene = sl.load_scene(found[0])
    camera, _ = sl.default_view(scene, aspect=1.0, view="above")
    gbuffer = sl.Renderer("cpu").gbuffer(scene, camera, size=(128, 128))
    seen = np.asarray(gbuffer.triangle) >= 0
    assert seen.any(axis=0).mean() > 0.9 or seen.any(axis=1).mean() > 0.9


def test_same_picture_at_every_scale():
    reference, light = sl.default_view(scene_of(TRIANGLE))
    for scale in (1e-6, 1e3, 1e9):
        camera, scaled_light = sl.default_view(scene_of(scale * TRIANGLE))
        # Meshes keep their vertices in single precision, so a scale may change the bounds by its eps.
        np.testing.assert_allclose(camera.eye / scale, reference.eye, rtol=1e-6)
        np.testing.assert_allclose(
            [camera.near / scale, camera.far / scale], [reference.near, reference.far], rtol=1e-6
        )
        np.testing.assert_array_equal(scaled_light.direction, light.direction)


def test_a_floor_is_seen_to_its_end_but_the_object_is_framed():
    bare = DEGENERATE["unit box"]
    whole = bare.with_ground()
    camera, _ = sl.default_view(whole, focus=bare)
    framed, _ = sl.default_view(bare)
    np.testing.assert_allclose(camera.eye, framed.eye)
    corners = np.array([[x, y, z] for x in whole.bounds[:, 0] for y in whole.bounds[:, 1] for z in whole.bounds[:, 2]])
    assert camera.depth(corners).max() <= camera.far
    # The floor's point at the bottom of the picture, where the lowest ray meets it.
    lowest = np.asarray(camera.forward) - np.tan(camera.fov_y / 2) * np.asarray(camera.up)
    assert camera.near <= (whole.bounds[0, 1] - camera.eye[1]) / lowest[1]


@pytest.mark.parametrize("aspect", [0.0, -1.0, np.nan, np.inf])
def test_a_wrong_aspect_is_said(aspect):
    with pytest.raises(sl.errors.ArgumentError, match="aspect"):
        sl.default_view(DEGENERATE["unit box"], aspect=aspect)
