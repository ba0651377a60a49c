"""Conventions: each is one invertible linear map, there and back; the presets are what their programs multiply."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import shadowlab as sl
from shadowlab.conventions.fields import all_axes
from shadowlab.errors import ArgumentError, UnknownNameError

# A round trip rounds each entry a few times; entries of a tile's rows carry the rounding of its offset, magnified by
# what the tile is smaller than that offset.
ROUND_TRIP = 1e-15

BIAS = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])
OPENGL_FROM_OURS = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1]])

shares = st.integers(1, 8).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n - 1)))
tiles = st.tuples(shares, shares).map(lambda s: (s[0][1] / s[0][0], s[1][1] / s[1][0], 1 / s[0][0], 1 / s[1][0]))
conventions = st.builds(
    sl.Convention,
    vectors=st.sampled_from(["column", "row"]),
    z_range=st.sampled_from([(0, 1), (-1, 1), (0.25, 8.0)]),
    reversed_z=st.booleans(),
    xy_range=st.sampled_from([(-1, 1), (0, 1)]),
    x=st.sampled_from(["right", "left"]),
    y=st.sampled_from(["up", "down"]),
    axes=st.sampled_from(all_axes()),
    tile=tiles,
)
matrices = st.lists(st.floats(-1e3, 1e3), min_size=16, max_size=16).map(lambda v: np.array(v).reshape(4, 4))


def magnified(convention, matrix):
    """What the largest entry of a matrix weighs after the steps of a round trip."""
    moved = convention.map_from_ndc
    scales = np.abs(moved[:, range(3), range(3)])
    return np.abs(matrix).max() * (1 + (1 + np.abs(moved[:, :3, 3])) / scales).max()


@given(conventions, matrices)
def test_there_and_back_is_the_same(convention, matrix):
    far = ROUND_TRIP * magnified(convention, matrix)
    assert np.abs(convention.to_ours(convention.from_ours(matrix)) - matrix).max() <= far
    stack = np.array([matrix, 2 * matrix])
    np.testing.assert_array_equal(convention.from_ours(stack)[0], convention.from_ours(matrix))
    theirs = convention.from_ours(convention.to_ours(matrix))
    assert np.abs(theirs - matrix).max() <= far * max(1, np.abs(convention.map_from_ndc).max())


@given(conventions)
def test_the_text_of_a_convention_is_read_back(convention):
    assert sl.Convention.of(str(convention)) == convention
    assert eval(repr(convention), {"Convention": sl.Convention}) == convention
    assert sl.Convention.of(convention) is convention
    assert hash(convention) == hash(dataclasses.replace(convention))


@given(conventions, st.tuples(*[st.floats(-5, 5)] * 3))
def test_a_point_lands_where_the_fields_say(convention, p_world):
    rng = np.random.default_rng(3)
    ours = np.eye(4) + 0.1 * rng.standard_normal((4, 4))
    ours[3] = 0, 0, 0, 1
    ndc = (ours @ [*p_world, 1])[:3]
    theirs = convention.from_ours(ours)
    p_their_world = convention.world_from_their_world.T @ [*p_world, 1]
    got = p_their_world @ theirs if convention.vectors == "row" else theirs @ p_their_world
    u, v, width, height = convention.tile
    x = (ndc[0] if convention.x == "right" else -ndc[0]) / 2 + 0.5
    y = (ndc[1] if convention.y == "up" else -ndc[1]) / 2 + 0.5
    z = 1 - ndc[2] if convention.reversed_z else ndc[2]
    low, high = convention.xy_range
    near, far = convention.z_range
    expected = [low + (high - low) * (u + width * x), low + (high - low) * (v + height * y), near + (far - near) * z, 1]
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12)


def test_presets_are_what_their_programs_multiply():
    m = np.asarray(sl.technique("lispsm").parameterize(*view()).matrix)
    c = sl.Convention
    np.testing.assert_array_equal(c.webgpu().from_ours(m), m)
    np.testing.assert_array_equal(c.metal().from_ours(m), m)
    np.testing.assert_array_equal(c.opengl().from_ours(m), OPENGL_FROM_OURS @ m)
    np.testing.assert_allclose(c.opengl_bias().from_ours(m), BIAS @ OPENGL_FROM_OURS @ m, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(c.direct3d().from_ours(m), m.T)
    np.testing.assert_array_equal(c.vulkan().from_ours(m), np.diag([1, -1, 1, 1]) @ m)
    flipped = np.diag([1.0, -1, 1, 1])
    np.testing.assert_allclose(
        c.direct3d_texture().from_ours(m), (BIAS @ OPENGL_FROM_OURS @ flipped @ m).T, rtol=0, atol=1e-15
    )
    # As ShadowUtils.GetShadowTransform: the z row of an OpenGL projection negated, then scale and bias.
    negated = np.diag([1.0, 1, -1, 1])
    unity = BIAS @ negated @ OPENGL_FROM_OURS @ m @ np.diag([1.0, 1, -1, 1])
    np.testing.assert_allclose(c.unity().from_ours(m), unity, rtol=0, atol=1e-15)
    for name in c.PRESETS:
        assert isinstance(c.of(name), c)
    assert c.of("reversed-z") == c(reversed_z=True)


def view():
    scene = sl.library.scene("robots")
    return scene, scene.camera, scene.light


def test_axes_and_handedness_say_the_same():
    c = sl.Convention
    assert c(axes="x,-z,y").handedness == "right"
    assert c(handedness="left").axes == ("x", "y", "-z")
    assert c(axes=("x", "-z", "y")).changed(handedness="left").axes == ("x", "y", "-z")
    assert c(handedness="left").changed(axes=("x", "-z", "y")).handedness == "right"
    # z up: what is up there, is up here.
    np.testing.assert_array_equal(c(axes=("x", "-z", "y")).world_from_their_world @ [0, 0, 1, 1], [0, 1, 0, 1])
    assert len(all_axes()) == len(set(all_axes())) == 48
    assert all_axes()[0] == ("x", "y", "z")


def test_maps_in_an_atlas_have_their_own_tiles():
    c = sl.Convention.opengl_bias().in_atlas(2, 2)
    stack = np.tile(np.eye(4), (4, 1, 1))
    theirs = c.from_ours(stack)
    corners = theirs @ np.array([-1.0, -1, 0, 1])
    np.testing.assert_allclose(corners[:, :2], [(0, 0), (0.5, 0), (0, 0.5), (0.5, 0.5)])
    np.testing.assert_allclose(c.to_ours(theirs), stack)
    with pytest.raises(ArgumentError, match=r"as many as maps \(3\), got 4"):
        c.from_ours(stack[:3])


BAD = {
    "vectors": "diagonal", "x": "up", "y": "right", "reversed_z": "yes", "z_range": (1, 0), "xy_range": (0, np.inf),
    "axes": ("x", "y", "y"), "handedness": "both", "tile": (0.5, 0, 0.6, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_field_is_named(name):
    with pytest.raises(ArgumentError, match=f"^{name}: expected .*got .*; ") as raised:
        sl.Convention(**{name: BAD[name]})
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "value", [np.eye(3), np.full((4, 4), np.nan), np.zeros((0, 4, 4)), "matrix", None, 1j * np.eye(4), [[1, 2], [3]]]
)
@pytest.mark.parametrize("way", ["from_ours", "to_ours"])
def test_what_is_no_matrix_is_refused(value, way):
    with pytest.raises(ArgumentError, match=r"^matrix: expected"):
        getattr(sl.Convention.opengl(), way)(value)


def test_unknown_names_list_the_valid_ones():
    with pytest.raises(UnknownNameError, match=r"unknown name 'glide'; expected one of webgpu, metal, opengl"):
        sl.Convention.of("glide")
    with pytest.raises(UnknownNameError, match=r"unknown field 'zrange'; expected some of vectors, z_range"):
        sl.Convention.of("opengl:zrange=3")
    with pytest.raises(ArgumentError, match="convention: expected a Convention or the name of one, got int"):
        sl.Convention.of(3)
    with pytest.raises(ArgumentError, match="handedness: expected 'right'"):
        sl.Convention(axes=("x", "-z", "y"), handedness="left")
    for bad in (0, 2.5, "2"):
        with pytest.raises(ArgumentError, match="columns: expected a whole number"):
            sl.Convention().in_atlas(bad)
