"""What the tests of plots share: footprints and views by hand, tables, axes that pyplot knows nothing of."""

from __future__ import annotations

import types

import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import shadowlab as sl
from shadowlab.aliasing import Footprint, closed_form

VIEW = {"near": 1.0, "far": 100.0}
Z = np.geomspace(1, 100, 33)
CURVES = {t: (Z, closed_form.dp_ds(Z, technique=t, **VIEW)) for t in ("uniform", "psm", "lispsm")}

DRIFT = pd.DataFrame(
    {"technique": ["a"] * 3 + ["b"] * 3, "frame": [0, 1, 2] * 2, "drift_rms": [0.1, 0.2, 0.3, 0.0, 0.0, 0.0],
     "drift_max": [0.2, 0.3, 0.5, 0.0, 0.0, 0.0], "flips": [10, 20, 30, 0, 0, 0]}
)  # fmt: skip
FRAMES = pd.DataFrame(
    {"technique": ["a"] * 4 + ["b"] * 4, "frame": [0, 1, 2, 3] * 2, "misclassified": [30, 31, 32, 33, 40, 41, 42, 43],
     "refit": [True] * 5 + [False, True, False]}
)  # fmt: skip
CAUSES = pd.DataFrame(
    {"technique": ["uniform", "lispsm"], "acne": [10, 0], "edge": [300, 40], "leak": [5, 2], "missing": [0, 8]}
)

ROBOTS = sl.library.scene("robots")
LISPSM = sl.technique("lispsm").parameterize(ROBOTS, ROBOTS.camera, ROBOTS.light, resolution=128)
SEEN = sl.Renderer("cpu").gbuffer(ROBOTS, ROBOTS.camera, size=(64, 36))
RIGHT = np.ones((6, 8), np.int8)


def footprint(major, codes=None, depth=None):
    """A footprint of one map whose texels are round."""
    major = np.asarray(major, np.float32)
    codes = np.zeros(major.shape, np.int16) if codes is None else np.asarray(codes, np.int16)
    major = np.where(codes >= 0, major, np.nan).astype(np.float32)
    depth = np.broadcast_to(np.float32(5) if depth is None else depth, major.shape).astype(np.float32)
    jacobian = np.where(np.eye(2, dtype=bool), major[..., None, None], np.float32(0))
    pair = np.stack([major, major], axis=-1)
    ones = np.where(codes >= 0, 1, np.nan).astype(np.float32)
    return Footprint(jacobian, major, major * major, pair, ones, codes, depth, (64, 64), codes.shape[::-1], 1)


def view(height=6, width=8):
    """A floor."""
    normal = np.zeros((height, width, 3), np.float32)
    normal[..., 1] = 1.0
    triangle = np.zeros((height, width), np.int32)
    return types.SimpleNamespace(triangle=triangle, normal=normal, position=np.zeros((height, width, 3)))


SUN = sl.DirectionalLight((0.0, -1.0, 0.0))


def lone_axes():
    """Axes of 600 x 400 pixels."""
    figure = Figure(figsize=(6, 4), layout="constrained")
    FigureCanvasAgg(figure)
    return figure.subplots()


def image(shape=(20, 30), measured=True, seed=0):
    """A footprint whose error falls with depth, and that has all kinds of pixels."""
    rng = np.random.default_rng(seed)
    depth = np.geomspace(1, 50, shape[0])[:, None] * np.ones(shape[1])
    codes = rng.choice([0, 0, 0, -1, -2, -3], size=shape) if measured else np.full(shape, -2)
    return footprint(20 / depth * rng.uniform(0.7, 1.4, shape), codes, depth)


def texts(ax):
    return [t.get_text() for t in ax.texts]


def heights(stairs):
    return stairs.get_data()[0]


def legend(ax):
    return [t.get_text() for t in ax.get_legend().get_texts()]


def angle_table(techniques=12, angles=(10, 30, 50, 90)):
    rows = [
        {"technique": f"t{i}", "angle_deg": a, "texel_p95": (i + 1) * (1 + a / 100)}
        for i in range(techniques)
        for a in angles
    ]
    return pd.DataFrame(rows)
