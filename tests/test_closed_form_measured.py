"""Closed forms against the maps they speak of: central differences of where finished maps put the centre ray."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from closed_form_support import close

import shadowlab as sl
from shadowlab.aliasing import closed_form as cf

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")

# Chosen between its square, the error of a difference, and the rounding of s, which stands still where F is 1e6.
STEP = 2e-4
DIFFERENCES = 1e-6


def huge_box(size):
    """A box that holds every frustum of a camera at the origin with this far depth and a right angle of view."""
    corners = size * np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
    quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]]
    return sl.Scene.from_arrays(corners, [f for a, b, c, d in quads for f in ([a, b, c], [a, c, d])])


class Measured:
    """A finished map of a view whose whole frustum is seen, light at an angle in the plane of view and up."""

    def __init__(self, technique, theta, params, *, near, far, fov_y, aspect=1.0):
        self.camera = sl.Camera.look_at(
            (0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=fov_y, aspect=aspect, near=near, far=far
        )
        self.light = np.array([0, -np.sin(theta), -np.cos(theta)])
        self.tan_phi, self.aspect = np.tan(fov_y / 2), aspect
        scene = huge_box(3 * far)
        of = sl.technique(technique, **params).by_body()
        self.map = of.parameterize(scene, self.camera, sl.DirectionalLight(self.light))
        assert not self.map.notes, self.map.notes
        self.inset = 1 - 2 * self.map.border_texels / self.map.resolution

    def slope(self, z, direction, partition=0):
        """How fast s and t grow from the centre ray's points at these depths (N,) along a direction: (N,) each."""
        points = np.outer(z, (0, 0, -1.0))
        part = self.map.partitions[partition]
        # A share of the depth, or of the distance over which w doubles where that is less.
        w, gradient = part.project(points)[1], np.linalg.norm(part.matrix[3, :3])
        reach = np.minimum(z, np.abs(w) / gradient) if gradient > 0 else np.asarray(z, float)
        h = STEP * reach[:, None]
        steps = h * np.asarray(direction)
        ndc = (part.project(points + steps)[0] - part.project(points - steps)[0]) / (2 * h)
        return ndc[:, 1] / (2 * self.inset), ndc[:, 0] / (2 * self.inset)

    def F(self, z, partition=0):
        """1 / (z tan φ) dz/ds."""
        return 1 / (z * self.tan_phi * self.slope(z, (0, 0, -1), partition)[0])

    def G(self, z):
        """1 / (z tan φx) dx/dt."""
        return 1 / (z * self.tan_phi * self.aspect * np.abs(self.slope(z, (1, 0, 0))[1]))

    def on_surface(self, z, normal):
        """How far the image moves, NDC, as s runs over the map, for a normal in the plane of light and view."""
        along = np.cross(normal, (1.0, 0, 0))
        h = STEP * z

        def image(p):
            clip = self.camera.clip_from_world @ np.append(p, 1)
            return clip[1] / clip[3]

        p = np.array([0, 0, -z])
        moved = (image(p + h * along) - image(p - h * along)) / (2 * h)
        return abs(moved / self.slope(np.array([z]), along)[0][0])


VIEWS = (
    {"near": 1.0, "far": 100.0, "fov_y": np.pi / 3},
    {"near": 0.2, "far": 7.0, "fov_y": 0.5},
    {"near": 3.0, "far": 3000.0, "fov_y": 1.5},
)
REAL = {
    "gmnpr": ("gmnpr", {}),
    "glpr": ("glpr", {}),
    "lispsm": ("lispsm", {"near": "basic"}),
    "lispsm-delta-z": ("lispsm", {}),
    "uniform": ("uniform", {}),
}


def depths(view, count=7):
    """Depths over the view, a little within it, since differences take points on both sides."""
    return np.geomspace(view["near"] * 1.001, view["far"] * 0.999, count)


@pytest.mark.parametrize("view", VIEWS, ids=lambda v: f"{v['far'] / v['near']:g}")
@pytest.mark.parametrize("technique", REAL)
def test_f_and_g_are_those_of_the_matrices(technique, view):
    name, params = REAL[technique]
    half = np.degrees(view["fov_y"] / 2)
    for degrees in (0.5 * half, 0.97 * half, 1.05 * half, 40, 55, 72, 90, 112, 180 - 0.6 * half):
        theta = np.radians(degrees)
        m, z = Measured(name, theta, params, aspect=1.3, **view), depths(view)
        at = {"theta": theta, **view}
        at["lam"] = cf.warp_lambda(**at, technique=technique)
        # The uniform map has no axis of its own, but turns to the view as warps do.
        close(m.F(z), cf.F(z, **at), DIFFERENCES)
        close(m.G(z), cf.G(z, **at), DIFFERENCES)
        if technique not in ("uniform",):
            close(m.map.values["lambda"], at["lam"], 1e-8)


@pytest.mark.parametrize("lam", [0.003, 0.02, 0.3, 3.0, 1e3])
def test_any_lambda_is_that_of_the_matrices(lam):
    view, before = VIEWS[0], 0
    for degrees in (10, 28, 33, 45, 60, 90, 140):
        theta = np.radians(degrees)
        m, z = Measured("gmnpr", theta, {"lambda": lam}, **view), depths(view)
        at = {"theta": theta, "lam": lam, **view}
        close(m.F(z), cf.F(z, **at), DIFFERENCES)
        close(m.G(z), cf.G(z, **at), DIFFERENCES)
        before += cf.phi_offset(**at) < 0
    # A reference point before the eye: the near corners are the widest.
    assert (before > 0) == (lam == 0.003)


@pytest.mark.parametrize("warp", ["glpr", "gmnpr", "lispsm"])
def test_logarithmic_errors_are_those_of_the_maps(warp):
    view = VIEWS[0]
    for degrees in (12, 25, 31, 36, 50, 70, 90, 130):
        theta = np.radians(degrees)
        m, z = Measured("log_psm", theta, {"warp": warp}, **view), depths(view)
        clear = min(degrees, 180 - degrees) >= 30
        technique = {"glpr": "glpr" if clear else "gmnpr", "lispsm": "lispsm-delta-z"}.get(warp, warp)
        at = {"theta": theta, **view}
        at["lam"] = cf.warp_lambda(**at, technique=technique)
        close(m.F(z), cf.F_log(z, **at), DIFFERENCES)
        close(m.G(z), cf.G(z, **at), DIFFERENCES)


@pytest.mark.parametrize("view", VIEWS, ids=lambda v: f"{v['far'] / v['near']:g}")
def test_the_ideal_case_is_that_of_the_matrices(view):
    near_plane, z = view["near"] * np.tan(view["fov_y"] / 2), depths(view)
    given = {"near": view["near"], "far": view["far"]}
    distance = 1.7 * view["near"]
    for technique, n, name, params in [
        ("uniform", None, "uniform", {}),
        ("psm", None, "psm", {"slide": 0.0, "range": "camera"}),
        ("lispsm", None, "lispsm", {"near": "basic"}),
        ("lispsm", None, "lispsm", {}),
        ("lispsm", distance, "lispsm", {"near": distance}),
        ("log", None, "log", {}),
        ("log", None, "log_psm", {}),
    ]:
        m = Measured(name, np.pi / 2, params, **view)
        # F is of an image two high, dp/ds of a near plane one high.
        close(m.F(z) * near_plane, cf.dp_ds(z, **given, technique=technique, n=n) + 0 * z, DIFFERENCES)
        close(m.G(z) / 2, cf.dp_dt(z, **given, technique=technique, n=n), DIFFERENCES)


@pytest.mark.parametrize(("technique", "inner"), [("uniform", "uniform"), ("lispsm", "lispsm:near=basic")])
def test_splits_are_those_of_the_matrices(technique, inner):
    view = VIEWS[0]
    given = {"near": view["near"], "far": view["far"]}
    for scheme in ("uniform", "logarithmic", "practical"):
        params = {"count": 4, "splits": scheme, "range": "camera", "inner": f"({inner})"}
        m = Measured("z_partition", np.pi / 2, params, **view)
        ends = cf.splits(**given, count=4, scheme=scheme)
        for i, (begin, end) in enumerate(itertools.pairwise(ends)):
            close(m.map.partitions[i].eye_depth, (begin, end))
            z = depths({"near": begin, "far": end})
            ours = cf.dp_ds_in_split(z, **given, split_near=begin, split_far=end, technique=technique)
            close(m.F(z, partition=i) * m.tan_phi * view["near"], ours, DIFFERENCES)


@pytest.mark.parametrize("degrees", [20, 35, 60, 90, 120])
def test_errors_on_surfaces_are_those_of_the_matrices(degrees):
    theta, view = np.radians(degrees), VIEWS[0]
    m = Measured("gmnpr", theta, {}, **view)
    lam = cf.warp_lambda(theta, **view)
    seen = 0
    for turn in np.radians(np.arange(5, 360, 20)):
        normal = np.array([0, np.sin(turn), np.cos(turn)])
        cos_alpha, cos_beta = normal[2], -normal @ m.light
        if cos_alpha <= 0 or cos_beta <= 0.01:
            continue
        seen += 1
        for z in (2.0, 30.0):
            error = cf.F(z, theta=theta, lam=lam, **view)
            ours = cf.dp_ds_on_surface(error, theta, cos_alpha=cos_alpha, cos_beta=cos_beta)
            close(ours, m.on_surface(z, normal), 10 * DIFFERENCES)
    assert seen >= 2
