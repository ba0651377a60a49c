"""First hits, occlusion and the truth mask against Embree, with a reason for every ray that answers differently."""

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from peers.cases import LIBRARY, SHARED, Case, case_of
from peers.rays import (
    DIFFERING_SHARE,
    pixel_rays,
    ray_meets,
    single_precision_lift,
    single_precision_reach,
    unexplained_hits,
    unexplained_occlusions,
)

import shadowlab as sl

SIZE = (512, 512)
NAMES = [*LIBRARY, *SHARED]


@dataclass(frozen=True, eq=False)
class Traced:
    """What Embree says of an image: rays in coordinates relative to the scene's middle, exactly those it traced."""

    case: Case
    embree: object
    origins: np.ndarray
    directions: np.ndarray
    t: np.ndarray
    triangle: np.ndarray
    triangles: np.ndarray
    reach: float

    @property
    def hit(self) -> np.ndarray:
        """(N,) bool: something is there."""
        return self.triangle >= 0

    @functools.cached_property
    def normals(self) -> np.ndarray:
        """(M, 3) unit normals of the triangles hit, on the eye's side; zero for triangles without area."""
        corner = self.triangles[self.triangle[self.hit]]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
        facing = np.einsum("ij,ij->i", normal, self.directions[self.hit])
        return np.where(facing[:, None] > 0, -normal, normal)

    @functools.cached_property
    def tolerance(self) -> np.ndarray:
        """(M,) how far the distances of one hit may be apart: grazing rays stretch the reach."""
        directions = self.directions[self.hit].astype(np.float64)
        facing = np.abs(np.einsum("ij,ij->i", self.normals, directions))
        return self.reach / np.maximum(facing, 1e-12)

    @functools.cached_property
    def shadow_rays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rays from the points hit to the light, rounded to float32: origins, directions, t_max."""
        # The distance in double precision: Embree's own would put the point off its triangle by its rounding.
        origins, directions = self.origins[self.hit].astype(np.float64), self.directions[self.hit].astype(np.float64)
        corner = self.triangles[self.triangle[self.hit], 0]
        facing = np.einsum("ij,ij->i", self.normals, directions)
        t = np.einsum("ij,ij->i", self.normals, corner - origins) / np.where(facing == 0, -1, facing)
        points = origins + t[:, None] * directions
        light = self.case.light
        if isinstance(light, sl.DirectionalLight):
            towards = np.broadcast_to(-np.asarray(light.direction), points.shape)
            t_max = np.full(len(points), 2 * self.case.diagonal)
        else:
            towards = np.asarray(light.position) - self.embree.origin - points
            t_max = np.ones(len(points))
        side = np.sign(np.einsum("ij,ij->i", self.normals, towards))[:, None]
        lifted = points + single_precision_lift(self.embree.vertices_local) * side * self.normals
        return lifted.astype(np.float32), np.ascontiguousarray(towards, np.float32), t_max.astype(np.float32)

    def world(self, points_local) -> np.ndarray:
        """(N, 3) world points of local ones: for the tracer that works in the world."""
        return np.asarray(points_local, np.float64) + self.embree.origin


@functools.cache
def _traced(module, case: Case) -> Traced:
    embree = module.EmbreexScene(case.vertices, case.faces)
    origins, directions = embree.rounded(*pixel_rays(case.camera, SIZE))
    t, triangle = embree.first_hit(origins, directions)
    triangles = (case.vertices - embree.origin)[case.faces]
    reach = single_precision_reach(embree.vertices_local, origins[:1])
    return Traced(case, embree, origins, directions, t, triangle, triangles, reach)


@pytest.fixture(params=NAMES)
def traced(request, embreex_peer) -> Traced:
    """A scene traced by Embree."""
    return _traced(embreex_peer, case_of(request.param, request))


def test_first_hits(traced, record_property):
    ours, triangle, instance = sl.trace.first_hit(
        traced.case.scene, traced.world(traced.origins), traced.directions.astype(np.float64)
    )
    assert traced.hit.mean() > 0.2
    assert ((triangle >= 0) == np.isfinite(ours)).all()
    assert ((instance >= 0) == np.isfinite(ours)).all()
    differs = np.isfinite(ours) != traced.hit
    both = np.flatnonzero(traced.hit & ~differs)
    apart = np.abs(ours[both] - traced.t[both]) > traced.tolerance[np.searchsorted(np.flatnonzero(traced.hit), both)]
    differs[both[apart]] = True
    at = np.flatnonzero(differs)
    record_property("differing", f"{len(at)} of {len(differs)}")
    assert len(at) <= DIFFERING_SHARE * len(differs)
    rays = traced.origins[at].astype(np.float64), traced.directions[at].astype(np.float64)
    assert unexplained_hits(*rays, ours[at], traced.t[at], traced.triangles, traced.reach) == []


def test_occlusion(traced, record_property):
    origins, directions, t_max = traced.shadow_rays
    theirs = traced.embree.occluded(origins, directions, t_max)
    ours = sl.trace.occluded(
        traced.case.scene, traced.world(origins), directions.astype(np.float64), t_max.astype(np.float64)
    )
    assert ours.dtype == bool
    # Something and not everything is in shadow.
    assert 0.005 < theirs.mean() < 0.98
    at = np.flatnonzero(ours != theirs)
    record_property("differing", f"{len(at)} of {len(ours)}")
    assert len(at) <= DIFFERING_SHARE * len(ours)
    rays = origins[at].astype(np.float64), directions[at].astype(np.float64), t_max[at].astype(np.float64)
    assert unexplained_occlusions(*rays, traced.triangles, traced.reach) == []


def test_truth_mask(traced, record_property):
    truth = sl.trace.shadow_mask(traced.case.scene, traced.case.camera, traced.case.light, size=SIZE).ravel()
    origins, directions, t_max = traced.shadow_rays
    theirs = np.full(truth.shape, -2)
    facing = np.einsum("ij,ij->i", traced.normals, directions)
    theirs[traced.hit] = ~traced.embree.occluded(origins, directions, t_max) & (facing > 0) & _reached(traced)
    undecided = truth == -1
    differs = (truth != theirs) & ~undecided
    record_property("differing", f"{differs.sum()} of {truth.size}, {undecided.sum()} undecided")
    assert differs.sum() <= DIFFERING_SHARE * truth.size
    # Undecided is an answer for what lies on an edge, not a way out.
    assert undecided.sum() <= 1e-3 * truth.size
    unexplained = [i for i in np.flatnonzero(differs) if not _pixel_on_edge(traced, i)]
    assert unexplained == []


def _reached(traced: Traced) -> np.ndarray:
    """(M,) bool: the light shines at the point hit, if nothing is between."""
    light = traced.case.light
    if isinstance(light, sl.DirectionalLight):
        return np.ones(traced.hit.sum(), bool)
    _, towards, _ = traced.shadow_rays
    distance = np.linalg.norm(towards, axis=1)
    cosine = -(towards @ np.asarray(light.direction)) / distance
    return (distance <= light.range) & (cosine >= np.cos(0.5 * light.cone_angle))


def _pixel_on_edge(traced: Traced, pixel: int) -> bool:
    """Single precision may show another triangle at the pixel, or block or free its way to the light."""
    origin, direction = traced.origins[pixel].astype(np.float64), traced.directions[pixel].astype(np.float64)
    low, high, on_edge = ray_meets(origin, direction, traced.triangles, traced.reach)
    last = high[~on_edge & (low > 0)].min(initial=np.inf)
    if (on_edge & (high > 0) & (low <= last)).any():
        return True
    # Nothing is at the pixel for certain: the answers had no right to differ.
    if not traced.hit[pixel]:
        return False
    k = np.count_nonzero(traced.hit[:pixel])
    origins, directions, t_max = traced.shadow_rays
    cosine = traced.normals[k] @ directions[k] / np.linalg.norm(directions[k])
    if abs(cosine) <= 2.0**-20:
        return True
    # The two start at points as far apart as the offsets and the errors of the hit's distance.
    reach = 8 * (traced.reach + traced.tolerance[k])
    ray = origins[k, None].astype(np.float64), directions[k, None].astype(np.float64), t_max[k, None].astype(np.float64)
    return unexplained_occlusions(*ray, traced.triangles, reach) == []
