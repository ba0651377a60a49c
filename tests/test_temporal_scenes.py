"""Paths along which the scene moves: points go with their instances, and truth is asked where they are."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import _core
from shadowlab.experiments.frame_pair import seen_by

# Rounding of texel coordinates of a few hundred, at positions rounded to float32 in each frame.
NO_DRIFT = 1e-4
SIZE = (128, 72)
HOW = {"size": SIZE, "renderer": "cpu", "progress": False}


@pytest.fixture(scope="module")
def robots():
    return sl.library.scene("robots")


def shifted(way):
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix


def pushed(scene, way, index=None):
    index = np.arange(1, scene.instance_count) if index is None else np.asarray(index)
    return scene.with_transforms(index, shifted(way) @ scene.transforms[index])


class Standing:
    """One map for all frames."""

    name, settings = "standing", {}

    def __init__(self, p):
        self.p = p

    def parameterize(self, scene, camera, light, *, resolution):
        return self.p


def test_a_scene_that_does_not_move_is_a_path_of_cameras(robots):
    cameras = [robots.camera.replace(eye=robots.camera.eye + 0.05 * i) for i in range(3)]
    everything = np.arange(robots.instance_count)
    again = robots.with_transforms(everything, robots.transforms)
    plain = sl.aliasing.temporal(robots, cameras, robots.light, ["uniform", "lispsm"], resolution=256, **HOW)
    listed = sl.aliasing.temporal(
        [robots, again, robots], cameras, [robots.light] * 3, ["uniform", "lispsm"], resolution=256, **HOW
    )
    assert plain == listed
    assert (plain.table["moving"] == 0).all()


def test_receivers_drift_by_their_own_way_over_a_map_that_stands(robots):
    # Straight down, a texel of a uniform map is as long as on the ground: what moves by 2.25 texels drifts by 0.25.
    light = sl.DirectionalLight((0, -1, 0))
    p = sl.technique("uniform").parameterize(robots, robots.camera, light, resolution=512)
    clip_way = np.linalg.solve(np.asarray(p.matrix)[[0, 1], :][:, [0, 2]], np.array([2.25, 0]) * 2 / 512)
    walk = [robots, pushed(robots, (clip_way[0], 0, clip_way[1]))]
    found = sl.aliasing.temporal(walk, robots.camera, light, {"s": Standing(p)}, resolution=512, **HOW)
    row = found.table.iloc[0]
    g = sl.Renderer("cpu").gbuffer(robots, robots.camera, size=SIZE)
    texels, which = sl.aliasing.texel_coordinates(g, robots.camera, light, p, resolution=512)
    after = _core.moved_gbuffer(g, *walk)
    moved, which_moved = sl.aliasing.texel_coordinates(after, robots.camera, light, p, resolution=512)
    both = (which >= 0) & (which_moved >= 0)
    moving = np.asarray(g.instance) > 0
    np.testing.assert_allclose((moved - texels)[both & moving], [[2.25, 0]] * (both & moving).sum(), atol=NO_DRIFT)
    np.testing.assert_array_equal(moved[both & ~moving], texels[both & ~moving])
    assert row["drift_max"] == pytest.approx(0.25, abs=NO_DRIFT)
    seen = both & seen_by(robots.camera, after.position)
    assert row["receivers"] == seen.sum()
    assert row["drift_mean"] == pytest.approx(0.25 * (seen & moving).sum() / seen.sum(), abs=NO_DRIFT)
    assert row["scale"] == pytest.approx(1, abs=1e-3)
    assert 0.01 < row["moving"] < 0.9


def test_the_whole_world_moved_with_its_light_and_camera_changes_nothing(robots):
    # Maps fitted for it move with it: no drift, no flip.
    way = np.array([3.0, 0.5, -2.0])
    spot = sl.SpotLight((4, 9, 6), (-0.4, -1, -0.6), cone_angle=1.2, range=40)
    again = sl.SpotLight(np.array((4, 9, 6)) + way, (-0.4, -1, -0.6), cone_angle=1.2, range=40)
    walk = [robots, pushed(robots, way, np.arange(robots.instance_count))]
    cameras = [robots.camera, robots.camera.replace(eye=robots.camera.eye + way)]
    found = sl.aliasing.temporal(walk, cameras, [spot, again], ["uniform", "lispsm"], resolution=256, **HOW)
    assert (found.table["moving"] == 1).all()
    assert (found.table["drift_max"] < 0.01).all()
    assert (found.table["judged"] > 1000).all()
    assert (found.table["flips"] <= 0.002 * found.table["judged"]).all()
    wrong = found.frames.groupby("technique")["misclassified"]
    assert ((wrong.max() - wrong.min()) <= 0.02 * wrong.max() + 2).all()


def test_only_points_whose_truth_stays_are_judged(robots):
    p = sl.technique("uniform").parameterize(robots, robots.camera, robots.light, resolution=2048)
    walk = [robots, pushed(robots, (0.4, 0, 0.2))]
    found = sl.aliasing.temporal(walk, robots.camera, robots.light, {"s": Standing(p)}, resolution=2048, **HOW)
    still = sl.aliasing.temporal([robots] * 2, robots.camera, robots.light, {"s": Standing(p)}, resolution=2048, **HOW)
    row, as_before = found.table.iloc[0], still.table.iloc[0]
    # Shadows wander over the floor: those points are left out, and of the others few flip.
    assert 0.5 * as_before["judged"] < row["judged"] < 0.99 * as_before["judged"]
    assert row["flip_share"] < 0.03
    g = sl.Renderer("cpu").gbuffer(robots, robots.camera, size=SIZE)
    first, second = (
        _core.shadows_at(of, points, robots.light)
        for of, points in zip(walk, (g, _core.moved_gbuffer(g, *walk)), strict=True)
    )
    changed = (first != second) & (first >= 0) & (second >= 0)
    assert changed.sum() > 50


def test_truth_at_points_is_that_of_their_pixels(robots):
    g = sl.Renderer("cpu").gbuffer(robots, robots.camera, size=SIZE)
    for light in (
        robots.light,
        sl.PointLight((0, 6, 0), range=30),
        sl.SpotLight((0, 8, 0), (0, -1, 0.1), cone_angle=1.0, range=20),
    ):
        at = _core.shadows_at(robots, g, light)
        through = sl.trace.shadow_mask(robots, robots.camera, light, size=SIZE)
        decided = (at >= 0) & (through >= 0)
        assert decided.sum() > 5000
        assert (at != through)[decided].mean() < 2e-3
        assert 100 < (at == 1)[decided].sum() < decided.sum() - 100


def test_dropped_faces_do_not_shift_the_truth():
    # Row 0 is dropped: triangle 0 of the mesh is row 1.
    vertices = [[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4], [np.nan] * 3, [-1, 1, -1], [1, 1, -1], [0, 1, 1]]
    with pytest.warns(sl.errors.ShadowlabWarning):
        scene = sl.Scene.from_arrays(np.array(vertices, float), [[0, 1, 4], [0, 2, 1], [0, 3, 2], [5, 7, 6]])
    camera = sl.Camera.look_at((0, 6, 6), (0, 0, 0), aspect=16 / 9, near=1, far=30)
    light = sl.DirectionalLight((0.3, -1, 0.2))
    g = sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE)
    at, through = _core.shadows_at(scene, g, light), sl.trace.shadow_mask(scene, camera, light, size=SIZE)
    decided = (at >= 0) & (through >= 0)
    assert (at != through)[decided].mean() < 5e-3
    assert (at[decided] == 0).sum() > 50


def test_every_frame_is_of_its_own_scene(robots):
    walk = [pushed(robots, (0.3 * i, 0, 0)) for i in range(3)]
    found = sl.aliasing.temporal(walk, robots.camera, robots.light, ["uniform"], resolution=128, **HOW)
    alone = [
        sl.evaluate(sl.View(of, robots.camera, robots.light, size=SIZE), "uniform", resolution=128, renderer="cpu")
        for of in walk
    ]
    assert found.frames["misclassified"].tolist() == [run.row()["misclassified"] for run in alone]
    held = sl.aliasing.temporal(
        walk, robots.camera, robots.light, {"held": sl.TemporalFit("uniform:fit=shadow")}, resolution=128, **HOW
    )
    assert held.frames["reason"].tolist() == ["first", "the scene changed", "the scene changed"]
