"""Notes on matrices from elsewhere: every convention that is not ours is named, and ours draws no word."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.conventions.doubts import LARGEST_RESIDUAL, doubt_about

OPENGL_FROM_SHADOW = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1]])
REVERSED_FROM_SHADOW = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]])
SCENES = ("forest", "robots", "skylight")


@pytest.fixture(scope="module", params=SCENES)
def case(request):
    """Scene, eye view, and the matrix of a technique."""
    scene = sl.library.scene(request.param)
    gbuffer = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(64, 36))
    matrix = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light).matrix
    return scene, gbuffer, np.asarray(matrix)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_our_own_maps_are_maps(name, technique, offset):
    scene = sl.library.scene(name)
    move = np.eye(4)
    move[:3, 3] = offset, 0, -offset
    camera, eye = scene.camera, np.asarray(scene.camera.eye) + move[:3, 3]
    camera = sl.Camera.look_at(
        eye,
        eye + np.asarray(camera.forward),
        fov_y=camera.fov_y,
        aspect=camera.aspect,
        near=camera.near,
        far=camera.far,
    )
    moved = sl.Scene(scene.meshes, scene.mesh_index, move @ scene.transforms)
    p = sl.technique(technique).parameterize(moved, camera, scene.light)
    gbuffer = sl.Renderer("cpu").gbuffer(moved, camera, size=(64, 36))
    assert doubt_about(p.matrices, scene.light, gbuffer) is None


def test_single_precision_is_enough(case):
    scene, gbuffer, matrix = case
    assert doubt_about(matrix.astype(np.float32), scene.light, gbuffer) is None


def test_a_spot_has_maps_too():
    scene = sl.library.scene("robots")
    low, high = np.asarray(scene.bounds)
    middle, size = (low + high) / 2, float(np.linalg.norm(high - low))
    light = sl.SpotLight(middle + np.array([0, size, 0.3 * size]), (0, -1, -0.3), cone_angle=1.4, range=4 * size)
    p = sl.technique("uniform").parameterize(scene, scene.camera, light)
    gbuffer = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(64, 36))
    assert doubt_about(p.matrices, light, gbuffer) is None
    assert doubt_about(REVERSED_FROM_SHADOW @ p.matrix, light, gbuffer).details == ("depth_falls_away",)
    moved = sl.SpotLight(np.asarray(light.position) + 0.01 * size, light.direction, cone_angle=1.4, range=4 * size)
    assert "misses_light" in doubt_about(p.matrices, moved, gbuffer).details


def test_a_transposed_matrix_is_named(case):
    scene, gbuffer, matrix = case
    doubt = doubt_about(matrix.T, scene.light, gbuffer)
    assert doubt.details[:2] == ("misses_light", "transposed")
    assert "its transpose is one: give row-major matrices" in str(doubt)


def test_the_identity_is_no_map(case):
    scene, gbuffer, _ = case
    doubt = doubt_about(np.eye(4), scene.light, gbuffer)
    assert doubt.kind == "check_matrix"
    start = f"check the matrix: not a map of this light: its rows x, y, w miss the light by {doubt.values['miss']:.2g} "
    assert str(doubt).startswith(start)
    assert "transposed" not in doubt.details


def test_depth_conventions_are_named(case):
    scene, gbuffer, matrix = case
    told = str(doubt_about(REVERSED_FROM_SHADOW @ matrix, scene.light, gbuffer))
    assert told == "check the matrix: depth falls away from the light: reversed z?"


def test_opengl_depth_is_named_where_a_receiver_shows_it(case):
    scene, gbuffer, matrix = case
    points = np.asarray(gbuffer.position)[np.asarray(gbuffer.triangle) >= 0]
    clip = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    nearer_half = clip[:, 2] / clip[:, 3] < 0.5  # these get depths below 0
    doubt = doubt_about(OPENGL_FROM_SHADOW @ matrix, scene.light, gbuffer)
    assert (doubt is not None and "depth_below_zero" in doubt.details) == nearer_half.any()
    if doubt is not None:
        assert f"{doubt.values['share']:.2g} % of the visible surface has depths between -1 and 0" in str(doubt)
    assert nearer_half.any() or "robots" not in scene.source  # one scene at least shows it


@pytest.mark.parametrize("angle", [10 * LARGEST_RESIDUAL, 0.01, 1.0])
def test_another_light_is_noticed(case, angle):
    scene, gbuffer, matrix = case
    d = np.asarray(scene.light.direction)
    side = np.cross(d, (0.2, 0.3, 0.9))
    other = sl.DirectionalLight(np.cos(angle) * d + np.sin(angle) * side / np.linalg.norm(side))
    assert "misses_light" in doubt_about(matrix, other, gbuffer).details


def test_a_map_of_another_place_is_told(case):
    scene, gbuffer, matrix = case
    shifted = np.eye(4)
    shifted[0, 3] = 3.0
    assert doubt_about(shifted @ matrix, scene.light, gbuffer) == sl.Note("check_matrix", ["nothing_in_map"])
    assert doubt_about([matrix, shifted @ matrix], scene.light, gbuffer) is None


def test_without_receivers_nothing_is_said():
    scene = sl.library.scene("robots")
    away = sl.Camera.look_at((0, 1e3, 0), (0, 2e3, 0), up=(0, 0, 1), far=10.0)
    gbuffer = sl.Renderer("cpu").gbuffer(scene, away, size=(8, 8))
    assert doubt_about(np.eye(4), scene.light, gbuffer) is None


def test_compare_notes_it_and_leaves_it_out_of_the_ranking(case):
    scene, _, matrix = case
    wrong = sl.Parameterization.from_matrix(matrix.T)
    right = sl.Parameterization.from_matrix(matrix)
    study = sl.compare(
        scene, scene.camera, scene.light, {"uniform": "uniform", "engine": wrong, "mine": right},
        resolution=64, size=(64, 36), renderer=sl.Renderer("cpu"), progress=False,
    )  # fmt: skip
    notes = study.table.set_index("technique")["notes"]
    assert "check the matrix: not a map of this light" in notes["engine"]
    assert "check the matrix" not in notes["uniform"] + notes["mine"]
    assert "engine is left out of the ranking: not a map of this light" in study.verdict


@pytest.mark.parametrize("technique", ["log", "rectilinear"])
def test_a_post_warp_behind_a_matrix_is_no_reason_for_doubt(technique):
    scene = sl.library.scene("robots")
    gbuffer = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(64, 36))
    p = sl.technique(technique).parameterize(scene, scene.camera, scene.light, resolution=64)
    assert doubt_about(p.matrices, scene.light, gbuffer, p.partitions) is None
    # The warp moved off by five half widths of the map.
    (part,) = p.partitions
    terms, knots = part.post_warp_terms, part.post_warp_knots
    moved = ("log", terms["scale"], terms["offset"] + 5) if terms else ("rectilinear", knots[0] + (0, 5), knots[1])
    far_off = sl.Parameterization.from_matrix(p.matrix, post_warp=[moved])
    found = doubt_about(p.matrices, scene.light, gbuffer, far_off.partitions)
    assert found == sl.Note("check_matrix", ["nothing_in_map"])
