"""Distances along the light: of texels against single and traced rays, of planes against the projection of steps."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing.light_distance import LightDistance
from shadowlab.aliasing.map_rays import MapRays

SIDE = 96
MAPS = [
    ("uniform", "none"), ("lispsm", "none"), ("log_psm", "log"), ("rectilinear", "rectilinear"),
    ("z_partition:count=3,inner=lispsm", "none"),
]  # fmt: skip


# A logarithm under a placed light is a uniform map of this view.
CASES = [(*one, kind) for one in MAPS for kind in ("directional", "spot", "point")]
CASES = [one for one in CASES if one[1] != "log" or one[2] == "directional"]


def view_of(kind: str = "directional") -> sl.View:
    scene = sl.library.scene("robots")
    middle = np.asarray(scene.bounds).mean(axis=0)
    at = middle + np.array([4.0, 12.0, 3.0])
    light = {
        "directional": scene.light,
        "spot": sl.SpotLight(at, middle - at, cone_angle=1.5, range=200),
        "point": sl.PointLight(at, range=200),
    }[kind]
    return sl.View(scene, scene.camera, light, size=(160, 90))


def distances(view: sl.View, technique: str) -> tuple[sl.Parameterization, list[LightDistance], np.ndarray]:
    p = sl.evaluate(view, technique, SIDE, metrics=[], renderer="cpu").parameterization
    maps = sl.Renderer("cpu").shadow_map(view.scene, p, resolution=SIDE).reshape(-1, SIDE, SIDE)
    origin = view.gbuffer("cpu").origin
    return p, [LightDistance(part, view.light, origin, (SIDE, SIDE)) for part in p.partitions], maps


def before(along: LightDistance) -> np.ndarray:
    """A point that a map has before it: of a placed light along the map's own axis."""
    light, axis = along.light, along.partition.matrix[3, :3]
    if isinstance(light, sl.DirectionalLight):
        return np.zeros(3)
    return np.asarray(light.position) + 10 * axis / np.linalg.norm(axis) - along.origin


@pytest.mark.parametrize(("technique", "post_warp", "kind"), CASES)
def test_texels_are_where_single_rays_meet_their_depth(technique, post_warp, kind):
    view = view_of(kind)
    p, found, maps = distances(view, technique)
    assert post_warp in {part.post_warp for part in p.partitions}
    rng, checked = np.random.default_rng(1), 0
    for along, depths in zip(found, maps, strict=True):
        got = along.of_texels(depths, 0)
        assert np.array_equal(np.isinf(got), depths >= 1)
        # A band of rows is the same rows.
        assert np.array_equal(along.of_texels(depths[40:50], 40), got[40:50])
        rays = MapRays(along.partition, view.light, along.origin, (SIDE, SIDE), 1e3)
        rows, columns = np.nonzero(depths < 1)
        for k in rng.integers(0, len(rows), 12) if len(rows) else ():
            place = np.array([columns[k] + 0.5, rows[k] + 0.5])
            seen = before(along)
            start = rays.on_plane(place, seen, rays.to_light(seen))
            to_light = rays.to_light(start)
            point = start + rays.height(start, float(depths[rows[k], columns[k]])) * to_light
            assert got[rows[k], columns[k]] == pytest.approx(float(along.of_points(point)), rel=1e-6, abs=1e-6)
            checked += 1
    assert checked >= 12


@pytest.mark.parametrize("kind", ["directional", "spot", "point"])
def test_texels_are_as_far_as_traced_surfaces(kind):
    """The stored surface is the first that a ray from the light through the texel's centre meets."""
    view = view_of(kind)
    _, found, maps = distances(view, "lispsm")
    rng = np.random.default_rng(2)
    for along, depths in zip(found, maps, strict=True):
        got = along.of_texels(depths, 0)
        rows, columns = np.nonzero(depths < 1)
        if not len(rows):
            continue
        picked = rng.integers(0, len(rows), 60)
        rays = MapRays(along.partition, view.light, along.origin, (SIDE, SIDE), 1e3)
        seen = before(along)
        starts, ways = [], []
        for k in picked:
            at = rays.on_plane(np.array([columns[k] + 0.5, rows[k] + 0.5]), seen, rays.to_light(seen))
            way = -rays.to_light(at)
            starts.append(at + along.origin - 200 * way if kind == "directional" else np.asarray(view.light.position))
            ways.append(way)
        t = sl.trace.first_hit(view.scene, np.array(starts), np.array(ways))[0]
        traced = along.of_points(np.array(starts) + t[:, None] * np.array(ways) - along.origin)
        # Rasterisers round vertices to 1/256 of a texel, so that at silhouettes the ray meets something else.
        near = np.abs(got[rows[picked], columns[picked]] - traced) < 0.02
        assert near.mean() > 0.85


@pytest.mark.parametrize(("technique", "post_warp", "kind"), CASES)
def test_a_step_moves_by_a_texel_along_its_plane(technique, post_warp, kind):
    view = view_of(kind)
    gbuffer = view.gbuffer("cpu")
    p, found, _ = distances(view, technique)
    places, chosen = sl.aliasing.texel_coordinates(gbuffer, view.camera, view.light, p, resolution=SIDE)
    right: list[np.ndarray] = []
    for k, along in enumerate(found):
        of = np.argwhere(chosen == k)[::37]
        if not len(of):
            continue
        at = tuple(of.T)
        points, normals = gbuffer.position_relative[at].astype(float), gbuffer.normal[at].astype(float)
        steps = along.texel_steps(points, normals)
        assert np.abs(np.einsum("nij,nj->ni", steps, normals)).max() < 1e-9 * np.abs(steps).max()
        for i, expected in enumerate(((1.0, 0.0), (0.0, 1.0))):
            # A thousandth of a texel, so that the map is linear about it; both ways, so that its curve cancels.
            h = 1e-3
            ends = [along.partition.project(points + along.origin + sign * h * steps[:, i])[0] for sign in (-1, 1)]
            moved = (ends[1] - ends[0])[:, :2] / (2 * h) * (0.5 * SIDE, -0.5 * SIDE)
            # Over a knot of an uneven map the two sides differ.
            right.append(np.abs(moved - expected).max(axis=1) < 1e-3)
        assert np.isfinite(places[at]).all()
    assert np.concatenate(right).mean() > (0.97 if post_warp == "rectilinear" else 0.999)


def test_no_step_on_planes_that_the_light_sees_edge_on():
    view = view_of()
    _, (along,), _ = distances(view, "uniform")
    edge_on = np.cross(np.asarray(view.light.direction), (0.3, 1.0, -0.2))
    steps = along.texel_steps(np.zeros((1, 3)), edge_on[None] * 0.0)
    assert (steps == 0).all()


def test_distances_of_points():
    view = view_of("spot")
    _, (along, *_), _ = distances(view, "uniform")
    points = np.random.default_rng(0).normal(size=(50, 3))
    exact = np.linalg.norm(points + along.origin - np.asarray(view.light.position), axis=1)
    assert along.of_points(points) == pytest.approx(exact)
    assert along.directions(points) * exact[:, None] == pytest.approx(
        points + along.origin - np.asarray(view.light.position)
    )
    _, (along,), _ = distances(view_of(), "uniform")
    assert along.of_points(points) == pytest.approx(points @ np.asarray(view_of().light.direction))
    assert along.directions(points).shape == (50, 3)
