"""Differences of shadow matrices by name: every convention and pairs of them, crops, turns, and real ones in texels."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from conftest import imported

import shadowlab as sl
from shadowlab.conventions.pair import SAME_TEXELS
from shadowlab.conventions.points import box_corners, common_corners, frustum_corners
from shadowlab.errors import ArgumentError

C = sl.Convention
SCENES = ("robots", "forest", "courtyard")
# What sets a convention apart, one change each, with the words that tell it.
CHANGES = {
    "transposed": {"vectors": "row"},
    "z in [-1, 1]": {"z_range": (-1, 1)},
    "reversed z": {"reversed_z": True},
    "texture bias": {"xy_range": (0, 1)},
    "x points left": {"x": "left"},
    "y points down": {"y": "down"},
    "left-handed world with axes (x, y, -z)": {"handedness": "left"},
    "right-handed world with axes (x, -z, y)": {"axes": ("x", "-z", "y")},
}
PAIRS = [
    (a, b)
    for a, b in itertools.combinations(CHANGES, 2)
    if not {"axes", "handedness"} <= (CHANGES[a].keys() | CHANGES[b].keys())
    and {a, b} != {"reversed z", "x points left"}  # as an opposite light is written
]


@pytest.fixture(scope="module", params=list(itertools.product(SCENES, ("uniform", "lispsm"))), ids="-".join)
def case(request):
    """A scene and a map of it."""
    name, technique = request.param
    scene = sl.library.scene(name)
    return scene, sl.technique(technique).parameterize(scene, scene.camera, scene.light)


@pytest.mark.parametrize("words", [(a,) for a in CHANGES] + PAIRS, ids=" and ".join)
def test_every_convention_and_every_pair_is_named(case, words):
    scene, p = case
    convention = C().changed(**{k: v for word in words for k, v in CHANGES[word].items()})
    for view in ({}, {"camera": scene.camera, "scene": scene}):
        found = sl.diagnose(p, p.to(convention), **view)
        assert found.same, found
        assert found.convention == convention, found
        assert len(found.differences) == len(words)
        for word in words:
            assert any(word in text for text in found.differences), found
        assert found.texels <= SAME_TEXELS


@pytest.mark.parametrize("name", C.PRESETS)
def test_presets_are_named_in_single_precision_and_scaled(case, name):
    _, p = case
    found = sl.diagnose(p.matrix, p.to(name).astype(np.float32))
    assert (found.same, found.convention) == (True, C.of(name)), found
    found = sl.diagnose(p, 2.5 * p.to(name))
    assert (found.same, found.convention) == (True, C.of(name)), found
    assert found.differences[-1] == "scaled by 2.5, which no map shows"


def test_equal_matrices_have_no_difference(case):
    _, p = case
    found = sl.diagnose(p, p)
    assert found == sl.Diagnosis(True, C(), (), 0.0, 0.0)
    assert str(found) == "the matrices are equal"
    assert "0 texels apart" in repr(found)


def test_a_negative_factor_is_told(case):
    _, p = case
    found = sl.diagnose(p, -p.to("opengl"))
    assert found.same
    assert "scaled by -1: the same map, but w is negative" in found.differences[-1]


@pytest.mark.parametrize("tile", [(0, 0.5, 0.5, 0.5), (1 / 3, 2 / 3, 1 / 3, 1 / 3), (0.75, 0, 0.25, 1)])
@pytest.mark.parametrize("base", ["opengl_bias", "direct3d_texture", "unity"])
def test_a_tile_of_an_atlas_is_named(case, tile, base):
    _, p = case
    convention = C.of(base).changed(tile=tile)
    found = sl.diagnose(p, p.to(convention))
    assert found.same, found
    assert np.allclose(found.convention.tile, tile)
    assert found.convention.changed(tile=tile) == convention
    assert "a tile of an atlas: " in str(found)


def test_maps_of_an_atlas_each_have_their_tile(case):
    _, p = case
    stack = np.array([p.matrix, np.diag([0.5, 0.5, 1, 1]) @ p.matrix, np.diag([0.2, 0.2, 1, 1]) @ p.matrix])
    atlas = C.opengl_bias().in_atlas(3)
    found = sl.diagnose(stack, atlas.from_ours(stack))
    assert found.same, found
    np.testing.assert_allclose(found.convention.tiles, atlas.tiles)


@pytest.mark.parametrize("texels", [0.1, 1.0, 3.0, 50.0])
@pytest.mark.parametrize("name", ["webgpu", "opengl", "unity"])
@pytest.mark.parametrize("resolution", [256, 1024])
def test_a_shift_is_told_in_texels(case, texels, name, resolution):
    scene, p = case
    shift = np.eye(4)
    shift[1, 3] = texels * 2 / resolution
    for view in ({}, {"camera": scene.camera, "scene": scene}):
        found = sl.diagnose(p, C.of(name).from_ours(shift @ p.matrix), resolution=resolution, **view)
        assert not found.same
        assert found.convention == C.of(name)
        assert found.texels == pytest.approx(texels, rel=1e-6)
        assert found.differences[-1] == f"another crop: y shifted by {texels:.3g} texels"


def test_a_shift_below_what_hardware_sees_is_none(case):
    _, p = case
    shift = np.eye(4)
    shift[0, 3] = 0.5 * SAME_TEXELS * 2 / 1024
    assert sl.diagnose(p, shift @ p.matrix).same
    shift[0, 3] = 2 * SAME_TEXELS * 2 / 1024
    assert not sl.diagnose(p, shift @ p.matrix).same


def test_another_size_is_a_scale(case):
    _, p = case
    found = sl.diagnose(p, C.opengl().from_ours(np.diag([0.9, 0.95, 1, 1]) @ p.matrix))
    assert found.differences == ("z in [-1, 1]", "another crop: x scaled by 0.9, y scaled by 0.95")
    assert found.texels == pytest.approx(0.1 * 512, rel=1e-6)


@pytest.mark.parametrize("degrees", [90.0, 30.0, -120.0])
def test_a_turn_is_told_with_its_angle(case, degrees):
    _, p = case
    a = np.radians(degrees)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]
    found = sl.diagnose(p, C.direct3d().from_ours(turn @ p.matrix))
    assert not found.same
    assert f"turned by {degrees:.4g}° in its plane" in str(found)
    assert found.convention == C.direct3d()
    shear = np.eye(4)
    shear[0, 1] = 0.3
    assert "turned or sheared in its plane" in str(sl.diagnose(p, shear @ p.matrix))


def test_other_depths_are_no_other_places(case):
    _, p = case
    found = sl.diagnose(p, np.diag([1, 1, 0.9, 1]) @ p.matrix)
    assert not found.same
    assert found.texels <= SAME_TEXELS
    assert found.depth == pytest.approx(0.1)
    assert found.differences == ("depths differ by up to 0.1 of the range: other near and far planes",)


def test_another_warp_and_another_light_are_told_apart():
    scene = sl.library.scene("robots")
    make = {name: sl.technique(name).parameterize(scene, scene.camera, scene.light) for name in ("uniform", "lispsm")}
    view = {"camera": scene.camera, "scene": scene}
    found = sl.diagnose(make["uniform"], make["lispsm"].to("direct3d"), **view)
    assert not found.same
    assert "another warp or crop of the same light: up to " in str(found)
    # By hand: where the frustum's corners inside of the scene's box land in both.
    corners = common_corners(
        frustum_corners(scene.camera, scene.camera.near, scene.camera.far), box_corners(scene.bounds)
    )
    places = [np.asarray(make[name].partitions[0].project(corners)[0])[:, :2] for name in make]
    inside = np.abs(places[0]).max(axis=1) <= 1 + 2 / 1024
    assert found.texels == pytest.approx(np.abs(places[1] - places[0])[inside].max() * 512, rel=1e-9)
    light = sl.DirectionalLight(np.add(scene.light.direction, [0.05, 0, 0]))
    other = sl.technique("uniform").parameterize(scene, scene.camera, light)
    found = sl.diagnose(make["uniform"], other, **view)
    assert "another light: up to " in str(found)
    assert not found.same


def test_common_corners_span_what_two_boxes_share():
    first, second = box_corners([(0, 0, 0), (2, 2, 2)]), box_corners([(1, -1, 0.5), (3, 1, 5)])
    shared = common_corners(first, second)
    np.testing.assert_allclose(shared.min(axis=0), [1, 0, 0.5])
    np.testing.assert_allclose(shared.max(axis=0), [2, 1, 2])
    assert common_corners(first, first + 5).shape == (0, 3)
    np.testing.assert_allclose(common_corners(first, box_corners([(-1, -1, -1), (9, 9, 9)])).max(axis=0), [2, 2, 2])


def test_a_camera_that_sees_nothing_of_the_map_leaves_the_unit_cube():
    scene = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light)
    away = sl.Camera.look_at((1e3, 1e3, 1e3), (2e3, 2e3, 2e3), near=1, far=10)
    assert sl.diagnose(p, p.to("vulkan"), camera=away).convention == C.vulkan()


@pytest.mark.parametrize(
    "bad",
    [
        np.eye(3),
        np.full((4, 4), np.nan),
        np.zeros((4, 4)),
        np.diag([1.0, 1, 0, 1]),
        "matrix",
        None,
        np.zeros((0, 4, 4)),
    ],
    ids=["shape", "nan", "zero", "singular", "word", "none", "empty"],
)
@pytest.mark.parametrize("side", ["mine", "theirs"])
def test_garbage_is_told(bad, side):
    good = np.eye(4)
    arguments = {"mine": good, "theirs": good, side: bad}
    with pytest.raises(ArgumentError, match=f"^{side}: expected") as raised:
        sl.diagnose(**arguments)
    assert "\n" not in str(raised.value)


def test_wrong_arguments_are_told():
    m = np.eye(4)
    with pytest.raises(ArgumentError, match=r"theirs: expected as many matrices as mine \(1\), got 2"):
        sl.diagnose(m, np.array([m, m]))
    with pytest.raises(ArgumentError, match="camera: expected a Camera, got str"):
        sl.diagnose(m, m, camera="mine")
    with pytest.raises(ArgumentError, match="scene: expected a Scene, got int"):
        sl.diagnose(m, m, scene=3)
    with pytest.raises(ArgumentError, match="resolution: expected a whole number"):
        sl.diagnose(m, m, resolution=0)


def test_random_matrices_have_an_answer():
    rng = np.random.default_rng(7)
    for _ in range(50):
        found = sl.diagnose(rng.standard_normal((4, 4)), rng.standard_normal((4, 4)))
        assert not found.same
        assert found.differences


def test_a_camera_of_pyrender_is_ours_with_another_depth_range():
    imported("OpenGL")
    pyrender_camera = imported("pyrender.camera")
    ours = sl.Camera.look_at((1, 2, 3), (0, 0.5, 0), fov_y=0.9, aspect=1.5, near=0.2, far=40)
    theirs = pyrender_camera.PerspectiveCamera(yfov=0.9, aspectRatio=1.5, znear=0.2, zfar=40.0).get_projection_matrix()
    found = sl.diagnose(ours.clip_from_world, theirs @ ours.view, camera=ours)
    assert found.same, found
    assert found.convention == C.opengl()
    assert found.differences == ("z in [-1, 1]",)
