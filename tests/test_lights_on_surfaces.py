"""Lights that touch geometry: truth against Embree, and maps of both renderers against truth."""

from __future__ import annotations

import numpy as np
import pytest
from peers.rays import pixel_rays, single_precision_lift

import shadowlab as sl

SIZE = (160, 120)
# As for the library's scenes: pixels at edges.
UNDECIDED_SHARE = 1e-3
# Embree ends its rays this much before the light, which stands on a surface: parts of the way.
BEFORE_LIGHT = 1e-4
# Pixels that the two may answer differently: those whose rays pass an edge within single precision, or cross a surface
# beside the light in the last part of the way.
DIFFERING_SHARE = 1e-3
# Wrong pixels of a map of 1024 texels in this room, which lie at edges of shadows.
WRONG_SHARE = 0.02

PLACES = {
    "in the middle of the ceiling": (0.3, 3, 0.2),
    "a hair below the ceiling": (0.3, 3 - 4e-9, 0.2),
    "a hair above the ceiling": (0.3, 3 + 4e-9, 0.2),
    "on an edge of the ceiling": (2, 3, -0.4),
    "in a corner of the ceiling": (-2, 3, 2),
    "on the floor": (-1.1, 0, 0.7),
    "on a wall": (2, 1.3, 0.1),
    "on the table": (0.1, 1.1, 0.1),
    "in the table's plane, beside it": (-1.5, 1.1, 0.2),
    "at a corner of the chest": (0.9, 0.9, 0.8),
    "inside of the chest": (1.2, 0.4, 1.2),
}


def room(scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a room 4 x 3 x 4 in size with a table and a chest, times a scale."""

    def box(low, high):
        p = [np.where([i & 1, i >> 1 & 1, i >> 2], high, low) for i in range(8)]
        sides = [[0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 3, 2], [4, 5, 7, 6]]
        return [[p[i] for i in side] for side in sides]

    table = [(-0.7, 1.1, -0.6), (0.8, 1.1, -0.6), (0.8, 1.1, 0.5), (-0.7, 1.1, 0.5)]
    quads = [*box((-2, 0, -2), (2, 3, 2)), table, *box((0.9, 0, 0.8), (1.5, 0.9, 1.6))]
    vertices = np.array(quads, dtype=np.float64).reshape(-1, 3) * scale
    faces = [(4 * k + a, 4 * k + b, 4 * k + c) for k in range(len(quads)) for a, b, c in ((0, 1, 2), (0, 2, 3))]
    return vertices, np.array(faces)


def view(place: str, scale: float):
    """The room, a camera in it, and a point light at a place."""
    vertices, faces = room(scale)
    eye, target = np.array([-1.7, 2.5, -1.6]) * scale, np.array([1.0, 0.2, 1.0]) * scale
    camera = sl.Camera.look_at(eye, target, fov_y=1.5, aspect=4 / 3, near=0.01 * scale, far=20 * scale)
    light = sl.PointLight(tuple(np.array(PLACES[place]) * scale), range=50 * scale)
    return vertices, faces, camera, light


@pytest.mark.parametrize("scale", [1.0, 0.9, 1e-6])
@pytest.mark.parametrize("place", PLACES)
def test_truth_is_what_embree_says(embreex_peer, place, scale):
    vertices, faces, camera, light = view(place, scale)
    truth = sl.trace.shadow_mask(sl.Scene.from_arrays(vertices, faces), camera, light, size=SIZE).ravel()
    # Embree has lengths of its own that it takes for nothing: it gets the room at its own size.
    embree = embreex_peer.EmbreexScene(vertices / scale, faces)
    origins, directions = pixel_rays(camera, SIZE)
    t, triangle = embree.first_hit(*embree.rounded(origins / scale, directions))
    hit = triangle >= 0
    corner = (vertices / scale - embree.origin)[faces[triangle[hit]]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal *= -np.sign(np.einsum("ij,ij->i", normal, directions[hit]))[:, None]
    points = origins[hit] / scale - embree.origin + t[hit, None].astype(np.float64) * directions[hit]
    points -= normal * np.einsum("ij,ij->i", normal, points - corner[:, 0])[:, None]
    towards = np.asarray(light.position) / scale - embree.origin - points
    cosine = np.einsum("ij,ij->i", normal, towards) / np.linalg.norm(towards, axis=1)
    lifted = points + 4 * single_precision_lift(embree.vertices_local) * normal
    ends = np.full(len(points), 1 - BEFORE_LIGHT, np.float32)
    blocked = embree.occluded(lifted.astype(np.float32), towards.astype(np.float32), ends)
    theirs = np.full(truth.shape, -2)
    # What the light is in the plane of is edge-on to it.
    theirs[hit] = ~blocked & (cosine > 1e-6)
    assert (truth == -1).sum() <= UNDECIDED_SHARE * truth.size
    differs = (truth != theirs) & (truth != -1)
    assert differs.sum() <= DIFFERING_SHARE * truth.size
    assert (truth == 0).sum() > 500


@pytest.mark.parametrize("place", PLACES)
def test_maps_show_what_truth_says(renderer, place):
    vertices, faces, camera, light = view(place, 0.9)
    scene = sl.Scene.from_arrays(vertices, faces)
    truth = sl.trace.shadow_mask(scene, camera, light, size=SIZE)
    gbuffer = renderer.gbuffer(scene, camera, size=SIZE)
    for technique in ("uniform", "lispsm"):
        p = sl.technique(technique).parameterize(scene, camera, light, resolution=1024)
        mask = renderer.shadow_mask(scene, camera, light, p, size=SIZE)
        errors = sl.aliasing.misclassified(mask, truth)
        assert errors.count <= WRONG_SHARE * truth.size, f"{technique}: {errors}"
        maps = renderer.shadow_map(scene, p)
        found = sl.aliasing.causes(scene, camera, light, p, mask, truth, gbuffer=gbuffer, maps=maps)
        assert found.missing + found.other <= max(3, 0.1 * errors.count), f"{technique}: {found}"


@pytest.mark.parametrize("off", [0.0, 1e-9])
def test_a_spot_flush_with_a_wall_lights_the_room(renderer, off):
    vertices, faces, camera, _ = view("on a wall", 0.9)
    scene = sl.Scene.from_arrays(vertices, faces)
    light = sl.SpotLight((1.8 - off, 1.2, 0.1), (-1, 0, 0), cone_angle=2.5, range=50)
    truth = sl.trace.shadow_mask(scene, camera, light, size=SIZE)
    assert (truth == -1).sum() <= UNDECIDED_SHARE * truth.size
    assert (truth == 1).sum() > 1000
    p = sl.technique("uniform").parameterize(scene, camera, light, resolution=1024)
    errors = sl.aliasing.misclassified(renderer.shadow_mask(scene, camera, light, p, size=SIZE), truth)
    assert errors.count <= WRONG_SHARE * truth.size, errors
