"""Cameras with other settings and from matrices, and lights from angles in the sky."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError
from shadowlab.scene.light_way import elevation_of

SETTINGS = ("eye", "right", "up", "forward", "fov_y", "aspect", "near", "far")
# Roundings of f64 through a product of matrices, an inverse and a tangent.
SAME = 64 * np.finfo(np.float64).eps
CONVENTIONS = (
    *sl.Convention.PRESETS,
    "opengl:vectors=row",
    "webgpu:axes=(x,-z,y)",
    "webgpu:axes=(-y,z,x)",
    "vulkan:reversed_z=true",
    "webgpu:handedness=left",
    "webgpu:x=left,y=down",
    "opengl:tile=(0.25,0.5,0.25,0.5)",
    "webgpu:z_range=(0.5,2)",
)


def looking(**changes):
    given = {"up": (0.1, 1, 0), "fov_y": 0.9, "aspect": 1.7, "near": 0.2, "far": 80.0, **changes}
    return sl.Camera.look_at((3.0, 4.0, 5.0), (0.5, 1.0, -2.0), **given)


def close(found, expected, tolerance=SAME) -> None:
    """Asserts that two cameras are the same up to rounding."""
    for name in ("right", "up", "forward"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=0, atol=tolerance)
    np.testing.assert_allclose(found.eye, expected.eye, rtol=0, atol=tolerance * np.abs(expected.eye).max())
    for name in ("fov_y", "aspect", "near"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=tolerance)
    # The depth row cancels by that much.
    assert found.far == pytest.approx(expected.far, rel=tolerance * expected.far / expected.near)


def written(camera, convention: str):
    """View and projection of a camera as somebody else writes them."""
    c = sl.Convention.of(convention)
    view = camera.view @ c.world_from_their_world
    (map_from_ndc,) = c.map_from_ndc
    projection = map_from_ndc @ camera.projection
    return (view.T, projection.T) if c.vectors == "row" else (view, projection)


def test_replace_changes_what_is_named_alone():
    camera = looking()
    assert camera.replace() == camera
    for name, value in (("fov_y", 0.5), ("aspect", 1.0), ("near", 0.5), ("far", 20.0)):
        changed = camera.replace(**{name: value})
        assert getattr(changed, name) == value
        for other in SETTINGS:
            if other != name:
                np.testing.assert_array_equal(getattr(changed, other), getattr(camera, other))
        assert changed.replace(**{name: getattr(camera, name)}) == camera


def test_replace_moves_and_turns():
    camera = looking()
    moved = camera.replace(eye=(9, 9, 9))
    np.testing.assert_array_equal(moved.eye, [9, 9, 9])
    for axis in ("right", "up", "forward"):
        np.testing.assert_array_equal(getattr(moved, axis), getattr(camera, axis))
    aimed = camera.replace(target=(0, 0, 0), up=(0, 1, 0))
    assert aimed == sl.Camera.look_at((3, 4, 5), (0, 0, 0), fov_y=0.9, aspect=1.7, near=0.2, far=80.0)
    assert camera.replace(eye=(1, 1, 1), target=(1, 1, 0)) == camera.replace(eye=(1, 1, 1), forward=(0, 0, -7))
    np.testing.assert_allclose(camera.replace(eye=(1, 1, 1), target=(1, 1, 0)).forward, [0, 0, -1])
    rolled = camera.replace(up=camera.right)
    np.testing.assert_array_equal(rolled.forward, camera.forward)
    np.testing.assert_allclose(rolled.up, camera.right, atol=SAME)
    close(camera.replace(forward=camera.forward), camera)


@pytest.mark.parametrize(
    ("changes", "error", "match"),
    [
        (
            {"fov": 1.0},
            UnknownNameError,
            "'?\"?fov\"?'?: expected one of eye, target, forward, up, fov_y, height, aspect, near, far, shift",
        ),
        ({"position": (0, 0, 0)}, UnknownNameError, "eye"),
        ({"target": (0, 0, 0), "forward": (0, 0, 1)}, ArgumentError, "both"),
        ({"near": 100.0}, ArgumentError, "far"),
        ({"near": 0}, ArgumentError, "near"),
        ({"near": "1"}, ArgumentError, "near"),
        ({"near": None}, ArgumentError, "near"),
        ({"near": True}, ArgumentError, "near"),
        ({"far": math.nan}, ArgumentError, "far"),
        ({"fov_y": 4.0}, ArgumentError, "fov_y"),
        ({"height": 4.0}, ArgumentError, r"height.*Camera\.orthographic"),
        ({"shift": (0.0, math.nan)}, ArgumentError, "shift"),
        ({"shift": (0.0, 1e7)}, ArgumentError, "shift"),
        ({"shift": 0.5}, ArgumentError, "shift"),
        ({"aspect": -1}, ArgumentError, "aspect"),
        ({"eye": (0, 0, math.nan)}, ArgumentError, "eye"),
        ({"eye": (0, 0)}, ArgumentError, "eye"),
        ({"target": (3, 4, 5)}, ArgumentError, "target"),
        ({"forward": (0, 0, 0)}, ArgumentError, "forward"),
        ({"forward": (0, math.inf, 0)}, ArgumentError, "forward"),
        ({"up": (0, 0, 0)}, ArgumentError, "up"),
        ({"forward": (0, 1, 0), "up": (0, 2, 0)}, ArgumentError, "parallel"),
        ({"eye": None}, ArgumentError, "eye"),
    ],
)
def test_replace_refuses(changes, error, match):
    with pytest.raises(error, match=match):
        looking().replace(**changes)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_camera_comes_back_from_matrices(convention):
    for camera in (looking(), looking(far=1e6), looking(near=79.0)):
        view, projection = written(camera, convention)
        close(sl.Camera.from_matrices(view, projection, convention), camera)
        close(sl.Camera.from_matrices(view, projection, convention=sl.Convention.of(convention)), camera)


def test_matrices_of_ours_need_no_convention():
    camera = sl.library.scene("courtyard").camera
    close(sl.Camera.from_matrices(camera.view, camera.projection), camera)
    far_away = camera.replace(eye=camera.eye + np.array([5e5, 4.6e6, 120]))
    close(sl.Camera.from_matrices(far_away.view, far_away.projection), far_away)


@settings(max_examples=100, deadline=None)
@given(
    eye=st.tuples(*[st.floats(-1e6, 1e6)] * 3),
    forward=st.tuples(*[st.floats(-1, 1)] * 3),
    fov_y=st.floats(0.01, 3.1),
    aspect=st.floats(0.1, 10),
    near=st.floats(1e-3, 1e3),
    ratio=st.floats(1.01, 1e5),
    convention=st.sampled_from(CONVENTIONS),
)
def test_any_camera_comes_back(eye, forward, fov_y, aspect, near, ratio, convention):
    try:
        camera = looking().replace(eye=eye, forward=forward, up=(0.3, 1, -0.2), fov_y=fov_y, aspect=aspect)
    except ArgumentError:
        return  # along up, or no direction
    camera = camera.replace(near=near, far=near * ratio)
    # Tangents near a right angle multiply what an angle is off by.
    close(
        sl.Camera.from_matrices(*written(camera, convention), convention), camera, SAME * (1 + 1 / math.cos(fov_y / 2))
    )


def test_left_handed_view_spaces_are_read():
    """Direct3D's XMMatrixLookToLH and XMMatrixPerspectiveFovLH, written out, in a left-handed world."""
    eye, to, fov, aspect, near, far = np.array([1.0, 2.0, -3.0]), np.array([0.6, 0.0, 0.8]), 0.8, 1.5, 0.5, 40.0
    right = np.cross([0.0, 1.0, 0.0], to)
    rows = np.array([right, np.cross(to, right), to])
    view = np.eye(4)
    view[:3, :3], view[3, :3] = rows.T, -rows @ eye
    h = 1 / math.tan(fov / 2)
    projection = np.diag([h / aspect, h, far / (far - near), 0.0])
    projection[2, 3], projection[3, 2] = 1.0, -near * far / (far - near)
    found = sl.Camera.from_matrices(view, projection, "direct3d:handedness=left")
    # Their z is our -z.
    np.testing.assert_allclose(found.eye, [1, 2, 3], rtol=SAME)
    np.testing.assert_allclose(found.forward, [0.6, 0, -0.8], atol=SAME)
    np.testing.assert_allclose([found.fov_y, found.aspect, found.near, found.far], [fov, aspect, near, far], rtol=1e-12)
    with pytest.raises(ArgumentError, match=r"mirrored.*handedness"):
        sl.Camera.from_matrices(view, projection, "direct3d")


def test_single_precision_will_do():
    camera = looking()
    found = sl.Camera.from_matrices(camera.view.astype(np.float32), camera.projection.astype(np.float32))
    close(found, camera, 4 * float(np.finfo(np.float32).eps))
    assert np.linalg.norm(found.right) == pytest.approx(1, abs=SAME)


def test_projections_without_an_end_have_their_far_plane_at_infinity_or_where_it_is_given():
    camera = looking()
    for convention, z in (("webgpu", (-1.0, -0.2)), ("opengl", (-1.0, -0.4)), ("reversed_z", (0.0, 0.2))):
        view, projection = camera.view, camera.projection.copy()
        projection[2, 2:] = z
        endless = sl.Camera.from_matrices(view, projection, convention)
        assert endless.far == math.inf
        close(endless.replace(far=80.0), camera)
        assert sl.Camera.from_matrices(view, projection, convention, far=math.inf) == endless
        close(sl.Camera.from_matrices(view, projection, convention, far=80.0), camera)
        for far in (0.1, math.nan, -1.0):
            with pytest.raises(ArgumentError):
                sl.Camera.from_matrices(view, projection, convention, far=far)
        with pytest.raises(ArgumentError, match="far: expected a number"):
            sl.Camera.from_matrices(view, projection, convention, far="80")
    with pytest.raises(ArgumentError, match="leave far out"):
        sl.Camera.from_matrices(camera.view, camera.projection, far=90.0)


def _changed(matrix, row, column, value):
    found = np.array(matrix)
    found[row, column] = value
    return found


ORTHOGRAPHIC = np.diag([0.1, 0.1, -0.01, 1.0])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda v, p: (v, _changed(ORTHOGRAPHIC, 0, 2, 0.2)), "aslant"),
        (lambda v, p: (v, _changed(ORTHOGRAPHIC, 2, 2, 0.0)), "full rank"),
        (lambda v, p: (v, np.diag([-1.0, 1, 1, 1]) @ ORTHOGRAPHIC), "mirrored"),
        (lambda v, p: (v, _changed(p, 0, 3, 0.2)), "beside the view's origin"),
        (lambda v, p: (v, _changed(p, 0, 1, 0.2)), "sheared"),
        (lambda v, p: (v, _changed(p, 2, 0, 0.2)), "depend on x and y.*oblique"),
        (lambda v, p: (v, _changed(p, 0, 0, 0.0)), "full rank"),
        (lambda v, p: (v, np.zeros((4, 4))), "perspective"),
        (lambda v, p: (v, _changed(p, 1, 1, np.nan)), "NaN"),
        (lambda v, p: (v, _changed(p, 0, 0, -p[0, 0])), "mirrored"),
        (lambda v, p: (v, _changed(p, 2, 2, -0.5)), "depth range"),
        (lambda v, p: (_changed(v, 0, 3, np.inf), p), "infinity"),
        (lambda v, p: (2 * v, p), "last row"),
        (lambda v, p: (np.diag([2.0, 2, 2, 1]) @ v, p), "scaled"),
        (lambda v, p: (_changed(np.eye(4), 0, 1, 0.5) @ v, p), "sheared"),
        (lambda v, p: (v.T, p), "last row"),
        (lambda v, p: (np.diag([0.0, 0, 0, 1]), p), "scaled"),
        (lambda v, p: (v[:3], p), r"view.*\(4, 4\)"),
        (lambda v, p: (v, p[None]), r"projection.*\(4, 4\)"),
        (lambda v, p: ("view", p), "view"),
        (lambda v, p: (v, None), "projection"),
    ],
)
def test_matrices_that_are_no_camera(change, match):
    camera = looking()
    with pytest.raises(ArgumentError, match=match):
        sl.Camera.from_matrices(*change(camera.view, camera.projection))


def test_conventions_that_are_none():
    camera = looking()
    with pytest.raises(UnknownNameError, match="opengl"):
        sl.Camera.from_matrices(camera.view, camera.projection, "glide")
    with pytest.raises(ArgumentError, match="one tile"):
        sl.Camera.from_matrices(camera.view, camera.projection, sl.Convention().in_atlas(2))
    with pytest.raises(ArgumentError, match="reversed"):
        sl.Camera.from_matrices(camera.view, camera.projection, "reversed_z")


@pytest.mark.parametrize(
    ("azimuth", "elevation", "comes_from"),
    [
        (0.0, 0.0, (0, 0, 1)),
        (math.pi / 2, 0.0, (1, 0, 0)),
        (math.pi, 0.0, (0, 0, -1)),
        (-math.pi / 2, 0.0, (-1, 0, 0)),
        (5 * math.pi / 2, 0.0, (1, 0, 0)),
        (0.3, math.pi / 2, (0, 1, 0)),
        (0.3, -math.pi / 2, (0, -1, 0)),
        (math.pi / 2, math.pi / 6, (math.sqrt(0.75), 0.5, 0)),
    ],
)
def test_a_light_comes_from_its_angles(azimuth, elevation, comes_from):
    light = sl.DirectionalLight.from_angles(azimuth, elevation)
    np.testing.assert_allclose(light.direction, -np.array(comes_from), atol=4 * SAME)
    # The arc sine of elevation_of halves the digits straight overhead.
    assert elevation_of(light.direction) == pytest.approx(elevation, abs=1e-7)


@settings(max_examples=100, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-1.5, 1.5))
def test_angles_come_back_from_a_light(azimuth, elevation):
    x, y, z = -sl.DirectionalLight.from_angles(azimuth, elevation).direction
    assert math.atan2(y, math.hypot(x, z)) == pytest.approx(elevation, abs=1e-14)
    assert elevation_of(np.array([-x, -y, -z])) == pytest.approx(elevation, abs=1e-12)
    off = math.remainder(math.atan2(x, z) - azimuth, 2 * math.pi)
    assert abs(off) <= 1e-14 / math.cos(elevation)
    # A turn about the y axis, by the right-hand rule.
    turn = np.array([[math.cos(azimuth), 0, math.sin(azimuth)], [0, 1, 0], [-math.sin(azimuth), 0, math.cos(azimuth)]])
    np.testing.assert_allclose(turn @ -sl.DirectionalLight.from_angles(0, elevation).direction, [x, y, z], atol=1e-15)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "match"),
    [
        (0, 1.6, "elevation.*pi/2"),
        (0, 30, "np.radians"),
        (0, math.nan, "elevation"),
        (math.inf, 0, "azimuth"),
        (math.nan, 0, "azimuth"),
        ("north", 0, "azimuth: expected a number"),
        (0, None, "elevation: expected a number"),
        (0, True, "elevation: expected a number"),
    ],
)
def test_angles_that_are_none(azimuth, elevation, match):
    with pytest.raises(ArgumentError, match=match):
        sl.DirectionalLight.from_angles(azimuth, elevation)
