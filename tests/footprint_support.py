"""What the tests of footprints share: how close is close, a scene and maps of it, footprints of chosen Jacobians."""

from __future__ import annotations

import numpy as np

import shadowlab as sl
from shadowlab.aliasing.footprint import Footprint

# Of float64 through a few operations; of float32 likewise.
EXACT, SINGLE = 1e-12, 1e-5
# A larger singular value that comes from a determinant: half of the digits where both are equal.
FROM_DETERMINANT = {np.dtype(np.float64): 1e-7, np.dtype(np.float32): 1e-3}

SIZE = (160, 90)
RENDERER = sl.Renderer("cpu")


def seen(name="robots"):
    """A library scene and what a camera sees of it."""
    scene = sl.library.scene(name)
    return scene, RENDERER.gbuffer(scene, scene.camera, size=SIZE)


ROBOTS, ROBOTS_SEEN = seen()


def made(text="lispsm", scene=ROBOTS, light=None, resolution=512, **params):
    """A map of a scene under its own light, or another."""
    light = scene.light if light is None else light
    return sl.technique(text, **params).by_body().parameterize(scene, scene.camera, light, resolution=resolution)


MAPS = {
    "lispsm": made(),
    "log_psm": made("log_psm"),
    "z_partition": made("z_partition", count=3),
    "uniform": made("uniform", resolution=300),
}


def of(p, resolution=None):
    """The footprint of the robots."""
    return sl.aliasing.footprint(ROBOTS_SEEN, ROBOTS.camera, ROBOTS.light, p, resolution=resolution)


def synthetic(jacobians, codes=None, depth=None, *, columns=None, maps=1, resolution=(64, 64), size=None):
    """A footprint of chosen Jacobians (N, 2, 2), on surfaces whose slope adds nothing unless the columns are others."""
    j = np.asarray(jacobians, np.float64)
    n = len(j)
    codes = np.zeros(n, np.int16) if codes is None else np.asarray(codes, np.int16)
    values = np.linalg.svd(j, compute_uv=False) if n else np.empty((0, 2))
    columns = np.hypot(j[:, 0], j[:, 1]) if columns is None else np.asarray(columns, np.float64)
    ones, depth = np.ones(n), np.arange(1.0, n + 1) if depth is None else np.asarray(depth, np.float64)
    arrays = [j.copy(), values[:, 0].copy(), values.prod(axis=1), columns.copy(), ones]
    for array in arrays:
        array[codes < 0] = np.nan
    size = (n, 1) if size is None else size
    return Footprint(*arrays, codes, depth=depth, resolution=resolution, size=size, maps=maps)
