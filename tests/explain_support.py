"""What explanations of pixels are held against: rays and comparisons in plain numpy, by the definitions of the docs.

The ray of a texel comes from the inverse of the matrix, and what it meets from Moller and Trumbore's test on every
triangle in double precision: neither the package's rays nor its tracer take part.
"""

from __future__ import annotations

import functools
import os
from dataclasses import dataclass

import numpy as np

import shadowlab as sl

# Random wrong pixels whose texels are held against independent rays.
WRONG_PIXELS = int(os.environ.get("SHADOWLAB_EXPLAINED_PIXELS", "500"))
# A rasteriser moves vertices by up to 1/256 of a texel, so that it draws at a centre what a ray meets that far away.
SNAP = 1 / 128
ABOUT = SNAP * np.array([[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]])
# Steps of the formats below 1, at most, by hand.
FORMAT_STEPS = {"f32": 2.0**-24, "f16": 2.0**-11, "unorm16": 1 / 65535, "unorm24": 1 / 16777215}
CAUSE_NAMES = {1: "acne", 2: "edge", 3: "leak", 4: "missing", 5: "other"}
# Scene, technique, texels: maps of every kind, each cause.
CASES = (
    ("robots", "uniform", 256), ("robots", "lispsm", 256), ("robots", "rectilinear", 128),
    ("robots", "z_partition:count=3,inner=lispsm", 128), ("skylight", "uniform", 256), ("skylight", "lispsm", 512),
    ("ceiling", "plane_optimal", 256), ("dueling", "log_psm", 256), ("dueling", "optimal_partition", 128),
    ("courtyard", "lispsm", 256),
)  # fmt: skip
# Two triangles that a ray meets together, relative to the length of the ray: rounding of double precision.
TOGETHER = 1e-12


@dataclass(frozen=True, eq=False)
class Triangles:
    """All triangles of a scene, relative to its middle, with their names."""

    corners: np.ndarray  # (N, 3, 3)
    instance: np.ndarray  # (N,)
    triangle: np.ndarray  # (N,)
    middle: np.ndarray

    @classmethod
    def of(cls, scene) -> Triangles:
        vertices, faces = scene.to_arrays()
        middle = np.asarray(scene.bounds).mean(axis=0)
        counts = [scene.meshes[k].triangle_count for k in scene.mesh_index]
        instance = np.repeat(np.arange(len(counts)), counts)
        triangle = np.concatenate([np.arange(n) for n in counts])
        return cls((vertices - middle)[faces], instance, triangle, middle)

    @functools.cached_property
    def spheres(self) -> tuple[np.ndarray, np.ndarray]:
        centre = self.corners.mean(axis=1)
        return centre, np.linalg.norm(self.corners - centre[:, None], axis=2).max(axis=1)

    def first(self, origin: np.ndarray, direction: np.ndarray) -> tuple[float, set[tuple[int, int]]]:
        """Parameter of the first hit with t > 0, and the triangles that are met there; infinity for none."""
        t, index = self.hits(origin, direction)
        if not len(t):
            return np.inf, set()
        met = index[t <= t[0] * (1 + TOGETHER) + TOGETHER]
        return float(t[0]), {(int(self.instance[k]), int(self.triangle[k])) for k in met}

    @functools.cached_property
    def outer(self) -> np.ndarray:
        """Normals of outer sides by the winding of the corners, as `to_arrays` has them for mirrored instances, too."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return np.cross(b - a, c - a)

    def hits(self, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Parameters of all hits with t > 0, ascending, and which triangles they are."""
        o, d = origin - self.middle, direction
        centre, radius = self.spheres
        away = centre - o
        near = np.linalg.norm(np.cross(away, d / np.linalg.norm(d)), axis=1) <= radius * (1 + 1e-9)
        index = np.flatnonzero(near)
        a, b, c = np.moveaxis(self.corners[index], 1, 0)
        e1, e2 = b - a, c - a
        p = np.cross(d, e2)
        det = np.einsum("ij,ij->i", e1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", o - a, p) / det
            q = np.cross(o - a, e1)
            v = q @ d / det
            t = np.einsum("ij,ij->i", e2, q) / det
            inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        order = np.argsort(t[inside])
        return t[inside][order], index[inside][order]


def texel_ray(matrix: np.ndarray, place: np.ndarray, resolution: int) -> tuple[np.ndarray, np.ndarray]:
    """Origin at depth 0 and direction to depth 1 of the ray of a place in a map, by the inverse of its matrix."""
    ndc = [2 * place[0] / resolution - 1, 1 - 2 * place[1] / resolution]
    back = np.linalg.inv(matrix)
    ends = [back @ np.array([*ndc, z, 1.0]) for z in (0.0, 1.0)]
    near, far = (end[:3] / end[3] for end in ends)
    return near, far - near


def ndc_of(matrix: np.ndarray, point: np.ndarray) -> np.ndarray:
    clip = matrix @ np.append(point, 1.0)
    return clip[:3] / clip[3]


def way_to(light, point):
    """The unit vector from a point to a light."""
    of_light = np.asarray(light.point)
    to_light = of_light[:3] - of_light[3] * point
    return to_light / np.linalg.norm(to_light)


def texel_size(rows, p, light, origin, resolution):
    """World size of a texel across the ray at a point relative to the origin, its longer side."""
    clip = rows[:, :3] @ p + rows[:, 3]
    grad_x, grad_y = (0.5 * resolution * (rows[i, :3] - clip[i] / clip[3] * rows[3, :3]) / clip[3] for i in (0, 1))
    to_light = way_to(light, p + origin)
    longer = max(np.linalg.norm(np.cross(grad, to_light)) for grad in (grad_x, grad_y))
    return longer / abs(np.cross(grad_x, grad_y) @ to_light)


def reference_depth(matrix, light, origin, resolution, bias, filter, point, normal):
    """Biased NDC depth (13.1) to (13.3) of a projective map, at the texel of the point; None where it is lit unseen."""
    shift = np.eye(4)
    shift[:3, 3] = origin
    rows, p = matrix @ shift, point - origin
    if bias.normal != 0.0:
        p = p + bias.normal * texel_size(rows, p, light, origin, resolution) * normal
    clip = rows[:, :3] @ p + rows[:, 3]
    if not clip[3] > 0:
        return None
    ndc = clip[:3] / clip[3]
    if not ndc[2] >= 0 or (np.abs(ndc[:2]) > 1).any():
        return None

    def gradient(row, value):
        return (row[:3] - value * rows[3, :3]) / clip[3]

    grad_x, grad_y = (s * 0.5 * resolution * gradient(rows[i], ndc[i]) for i, s in ((0, 1), (1, -1)))
    grad_z = gradient(rows[2], ndc[2])
    to_light = way_to(light, p + origin)
    cross = np.cross(grad_x, grad_y)
    across = abs(cross @ to_light)
    texel = max(np.linalg.norm(np.cross(grad, to_light)) for grad in (grad_x, grad_y)) / across

    def gain(along, of=np.abs):
        """Of depth on the plane with this normal, over a texel along each axis."""
        return np.array(
            [
                of(grad_z @ np.cross(grad_y, along) / (cross @ along)),
                of(-grad_z @ np.cross(grad_x, along) / (cross @ along)),
            ]
        )

    moved = rows[:, :3] @ (p + (bias.world + bias.texels * texel) * to_light) + rows[:, 3]
    if not moved[3] > 0:
        return None
    z = moved[2] / moved[3] - bias.ndc
    reach = bias.slope * {"nearest": 0.5, "bilinear": 1.0}[filter]
    limit = np.inf
    if np.isfinite(bias.slope_limit):
        limit = bias.slope_limit * texel * abs(grad_z @ to_light) + reach * gain(to_light).sum()
    z -= min(reach * gain(normal).sum(), limit)
    place = (0.5 + 0.5 * np.array([ndc[0], -ndc[1]])) * resolution
    change = gain(normal, np.asarray) @ (np.floor(place) + 0.5 - place)
    z += bias.plane * min(max(change, -limit), limit)
    z -= min(max(bias.factor * gain(normal).max(), -limit), limit)
    z -= bias.units * 2.0 ** (np.floor(np.log2(min(ndc[2], 1.0))) - 23)
    return min(max(z, 0.0), 1.0)


@functools.cache
def view_of(name: str, size: tuple[int, int] = (320, 180)):
    """A view of a library scene with its own camera and light."""
    scene = sl.library.scene(name)
    return sl.View(scene, scene.camera, scene.light, size=size)


@functools.cache
def run_of(name: str, technique: str, resolution: int, filter: str = "nearest"):
    return sl.evaluate(view_of(name), technique, resolution, renderer="cpu", filter=filter)


def some(image: np.ndarray, count: int, seed: int) -> list[tuple[int, int]]:
    """Columns and rows of up to so many pixels of a mask, drawn evenly."""
    rows, columns = np.nonzero(image)
    chosen = np.random.default_rng(seed).permutation(len(rows))[:count]
    return [(int(columns[k]), int(rows[k])) for k in sorted(chosen)]


def explained(view, technique, x, y, resolution, **more):
    more = {"renderer": "cpu", "trials": False} | more
    return sl.explain_pixel(view, technique, x, y, resolution=resolution, **more)
