"""The lattice of a map on a plane across the light, and on the receivers of the eye view: where the map says it is."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError
from shadowlab.pictures import lattice as lattice_pictures
from shadowlab.pictures.light_plane import LightPlane, visible

pytestmark = pytest.mark.filterwarnings("error")

# Of float64 through a map and back; a warp of a long view loses some digits.
EXACT = 1e-8
SPOT = sl.SpotLight((0.0, 6.0, 6.0), (0.1, -1.0, -0.5), cone_angle=1.2, range=40.0)
POINT = sl.PointLight((0.0, 3.0, 4.0), range=40.0)


@pytest.fixture(scope="module")
def robots():
    return sl.library.scene("robots")


def maps_of(robots, technique, light=None):
    light = light or robots.light
    return sl.technique(technique).parameterize(robots, robots.camera, light, resolution=256), light


CASES = [
    ("uniform", None), ("lispsm", None), ("psm", None), ("tsm", None), ("log_psm", None), ("z_partition", None),
    ("rectilinear", None), ("rectilinear", SPOT), ("lispsm", SPOT), ("uniform", SPOT), ("uniform", POINT),
    ("lispsm", POINT),
]  # fmt: skip


@pytest.mark.parametrize(("technique", "light"), CASES)
def test_lines_mapped_back_lie_where_the_map_has_them(robots, technique, light):
    p, light = maps_of(robots, technique, light)
    for part in p.partitions:
        plane = LightPlane.of(light, robots.camera, part)
        for axis, at in ((0, -0.5), (0, 0.875), (1, -0.875), (1, 0.25)):
            segments = plane.lattice(part, [at] if axis == 0 else [], [] if axis == 0 else [at])
            assert len(segments) == 1
            # Points between both ends, and others of the same rays of light.
            places = segments[0, 0] + np.linspace(0, 1, 9)[:, None] * (segments[0, 1] - segments[0, 0])
            points = np.column_stack([places, np.ones(9)]) @ plane.to_world[:3].T
            ways = plane.forward if plane.directional else points - light.position
            for t in (-0.5, 0.0, 3.0):
                ndc, w = part.project(points + t * ways)
                assert (w > 0).all()
                np.testing.assert_allclose(ndc[:, axis], at, atol=EXACT)
            ends = np.sort(part.project(points[[0, -1]])[0][:, 1 - axis])
            np.testing.assert_allclose(ends, [-1, 1], atol=EXACT)


@pytest.mark.parametrize(("technique", "light"), CASES)
def test_plane_and_world_are_inverse(robots, technique, light):
    p, light = maps_of(robots, technique, light)
    plane = LightPlane.of(light, robots.camera, p.partitions[-1])
    np.testing.assert_allclose(plane.from_world @ plane.to_world, np.eye(3), atol=1e-12)
    # Right-handed as the light sees it: x right, y up, looking along the light.
    right, up = plane.to_world[:3, 0], plane.to_world[:3, 1]
    np.testing.assert_allclose(np.cross(right, up), -plane.forward, atol=1e-12)
    assert up @ robots.camera.forward > 0


def test_a_light_along_the_view_takes_the_up_of_the_image():
    camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0))
    plane = LightPlane.of(sl.DirectionalLight((0, 0, -1)), camera)
    np.testing.assert_allclose(plane.project([[0.0, 2.0, -9.0], [3.0, 0.0, 5.0]]), [[0, 2, 1], [3, 0, 1]], atol=1e-12)


def test_the_view_before_the_warp_has_depths_within_the_unit(robots):
    for light in (robots.light, SPOT):
        plane = LightPlane.of(light, robots.camera)
        matrix = plane.clip_from_world((-2.0, 3.0), (-1.0, 4.0), robots.bounds, 40.0)
        point = SPOT.position + 5.0 * SPOT.direction
        clip = matrix @ np.append(point, 1.0)
        assert (robots.bounds[0] < point).all()
        assert 0 < clip[2] / clip[3] < 1
        x, y, w = plane.project(point[None])[0]
        np.testing.assert_allclose(clip[:2] / clip[3], [(x / w - 0.5) / 2.5, (y / w - 1.5) / 2.5], atol=1e-12)


def test_segments_end_this_side_of_the_horizon():
    # From ahead to behind: cut where w is a thousandth.
    cut = visible(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, -1.0]))
    np.testing.assert_allclose(cut, [[0, 0], [499.5, 0]])
    assert visible(np.array([0.0, 0, 0]), np.array([1.0, 0, -1])) is None
    assert visible(np.array([1.0, 2, -2]), np.array([1.0, 0, -1])) is None
    np.testing.assert_allclose(visible(np.array([1.0, 2, 1]), np.array([4.0, 0, 2])), [[1, 2], [2, 0]])


def test_a_map_that_the_light_does_not_fit_says_so(robots):
    # A map that looks along z, and a light along x: all points of a ray of light have different places.
    plane = LightPlane.of(robots.light, robots.camera)
    p = sl.Parameterization.from_matrix(np.eye(4)).partitions[0]
    assert len(plane.lattice(p, [0.0], [0.0])) == 2
    flat = sl.DirectionalLight((1.0, 0.0, 0.0))
    with pytest.raises(ArgumentError, match="singular across the light"):
        LightPlane.of(flat, robots.camera).lattice(p, [0.0], [])
    with pytest.raises(ArgumentError, match="light: expected"):
        LightPlane.of("sun", robots.camera)


@pytest.fixture(scope="module")
def seen(robots):
    return sl.Renderer("cpu").gbuffer(robots, robots.camera, size=(320, 180))


def covered(robots, seen, p, every, width_px=1.3):
    args = (seen, robots.camera, robots.light, p)
    lengths = sl.aliasing.footprint(*args)
    texel, which = sl.aliasing.texel_coordinates(*args)
    return lattice_pictures.coverage(texel, lengths, every, width_px), texel, which, lengths


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "log_psm", "rectilinear", "z_partition"])
def test_lines_lie_where_texel_coordinates_pass_a_multiple(robots, seen, technique):
    p, _ = maps_of(robots, sl.technique(technique).by_body())
    # Where texels are small beside shadows' edges so many lines would be too dense to be drawn.
    every = 64 if technique == "rectilinear" else 16
    cover, texel, which, lengths = covered(robots, seen, p, every)
    assert (cover[which < 0] == 0).all()
    assert (cover >= 0).all()
    assert (cover <= 1).all()
    # Neighbours on one triangle, between which the cell changes, and where lines are far apart: one of both is drawn.
    same = which[:, 1:] >= 0
    for what in (seen.triangle, seen.instance, which):
        same = same & (what[:, 1:] == what[:, :-1])
    for axis, across in ((0, lengths.m_s), (1, lengths.m_t)):
        wide = every * lengths.area / across > 2 * lattice_pictures.APART_PX
        cell = np.floor(np.nan_to_num(texel[..., axis]) / every)
        passes = same & (cell[:, 1:] != cell[:, :-1]) & wide[:, 1:] & wide[:, :-1]
        assert passes.sum() > 25
        assert (np.maximum(cover[:, 1:], cover[:, :-1])[passes] > 0.4).all()
    # In the middle of wide cells nothing is drawn.
    middle = which >= 0
    for axis, across in ((0, lengths.m_s), (1, lengths.m_t)):
        step = lengths.area / across
        place = np.nan_to_num(texel[..., axis]) / every
        middle &= np.abs(place - np.rint(place)) * every * np.nan_to_num(step) > 2.0
        middle &= np.nan_to_num(every * step) > lattice_pictures.APART_PX
    assert middle.sum() > 500
    assert (cover[middle] == 0).all()


def test_dense_lines_become_a_tint(robots, seen):
    p, _ = maps_of(robots, "uniform")
    fine = sl.technique("uniform").parameterize(robots, robots.camera, robots.light, resolution=1 << 14)
    cover, _, which, _ = covered(robots, seen, fine, 1)
    far = np.zeros_like(which, bool)
    far[70:75] = which[70:75] >= 0
    assert far.any()
    np.testing.assert_allclose(np.median(cover[far]), lattice_pictures.TINT, atol=0.02)
    assert covered(robots, seen, p, 10**6)[0].max() >= 0  # one cell: no line, and no error


def test_the_lattice_is_a_picture_in_the_colours_of_maps(robots, seen):
    p, _ = maps_of(robots, "z_partition")
    args = (seen, robots.camera, robots.light, p)
    picture = lattice_pictures.lattice_picture(*args)
    assert picture.shape == (180, 320, 3)
    shaded = lattice_pictures.lattice_picture(*args, mask=np.zeros((180, 320), np.float32))
    assert shaded.astype(int).sum() < picture.astype(int).sum()
    assert (lattice_pictures.lattice_picture(*args, every=8) != picture).any()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"every": 0}, "every: expected a whole number"),
        ({"every": 2.5}, "every: expected a whole number"),
        ({"width_px": -1.0}, "width_px: expected a finite number above 0"),
        ({"mask": np.ones((3, 3))}, r"mask: expected shape \(180, 320\)"),
    ],
)
def test_wrong_lattices_say_what_was_expected(robots, seen, given, says):
    p, light = maps_of(robots, "uniform")
    with pytest.raises(ArgumentError, match=says):
        lattice_pictures.lattice_picture(seen, robots.camera, light, p, **given)
