"""Cameras of a glTF document at their nodes (glTF 2.0, "Cameras")."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ... import _core
from ...errors import ArgumentError
from ..foreign_views import ASPECT
from ..placed import ROUNDING, camera_at, unique
from .graph import Graph
from .items import JsonObject


def cameras_in(graph: Graph, nodes: list[int], notes: list[str]) -> dict[str, _core.Camera]:
    """The cameras at nodes, by name: the node's, else the camera's.

    Parameters
    ----------
    graph : Graph
    nodes : list of int
        Those of the active scene, in the order of the file.
    notes : list of str
        Gets what is completed and left out.
    """
    found: dict[str, _core.Camera] = {}
    lenses = graph.document.top.items("cameras")
    for index in nodes:
        node = graph.document.nodes[index]
        if "camera" not in node.value:
            continue
        lens = lenses[node.index("camera", len(lenses), "cameras")]
        name = unique(node.name or lens.name or f"camera {len(found) + 1}", found)
        try:
            found[name] = camera_at_node(lens, graph.world[index], f"camera {name!r}", notes)
        except ArgumentError as e:
            notes.append(f"left out camera {name!r}: {e}")
    return found


def camera_at_node(lens: JsonObject, pose: NDArray[np.float64], label: str, notes: list[str]) -> _core.Camera:
    """The camera of a lens and its pose, world from camera.

    Raises
    ------
    LoadError
        For numbers that are none.
    ArgumentError
        For a camera that cannot be one of ours.
    """
    kind = lens.text("type")
    if kind not in ("perspective", "orthographic"):
        raise lens.wrong("type", "perspective or orthographic")
    settings = lens.needed(kind)
    turned, scale = rigid_pose(pose)
    near = settings.number("znear") * scale[2]
    if kind == "orthographic":
        # Half the width and half the height.
        half = settings.number("xmag") * scale[0], settings.number("ymag") * scale[1]
        if not min(half) > 0:
            raise ArgumentError(f"xmag, ymag: expected half the picture's size, above 0, got {half[0]:g}, {half[1]:g}")
        far = settings.number("zfar") * scale[2]
        return camera_at(turned, height=2 * half[1], aspect=half[0] / half[1], near=near, far=far)
    far = settings.number("zfar") * scale[2] if "zfar" in settings.value else math.inf
    aspect = ASPECT
    if "aspectRatio" in settings.value:
        aspect = settings.number("aspectRatio")
    else:
        notes.append(f"{label} has no aspect ratio: 16:9 is taken; camera.replace(aspect=...) changes it")
    fov_y = settings.number("yfov")
    # A node that is scaled by other factors along the picture's axes stretches the picture.
    if scale[1] != scale[2]:
        if not 0 < fov_y < np.pi:
            raise ArgumentError(f"yfov: expected radians above 0 and below pi, got {fov_y:g}")
        fov_y = float(2 * np.arctan(np.tan(0.5 * fov_y) * scale[1] / scale[2]))
    return camera_at(turned, fov_y=fov_y, aspect=aspect * scale[0] / scale[1], near=near, far=far)


def rigid_pose(pose: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[float, float, float]]:
    """A pose without its scale, and the scale along its axes.

    Raises
    ------
    ArgumentError
        For a pose that mirrors, shears, flattens or is not finite.
    """
    if not np.isfinite(pose).all():
        raise ArgumentError("its pose is not finite")
    largest = np.abs(pose[:3, :3]).max()
    lengths = np.linalg.norm(pose[:3, :3] / largest, axis=0) if largest > 0 else np.zeros(3)
    if not (lengths > 0).all():
        raise ArgumentError("its pose flattens space")
    axes = pose[:3, :3] / largest / lengths
    if np.abs(axes.T @ axes - np.eye(3)).max() > ROUNDING or np.linalg.det(axes) < 0:
        raise ArgumentError("its pose mirrors or shears")
    lengths *= largest
    # Rounding of a pose is no stretch.
    if np.abs(lengths - lengths[2]).max() <= ROUNDING * lengths[2]:
        lengths[:] = np.cbrt(np.prod(lengths / largest)) * largest
    if np.abs(lengths - 1).max() <= ROUNDING:
        lengths[:] = 1.0
    made = pose.copy()
    made[:3, :3] = axes
    return made, (float(lengths[0]), float(lengths[1]), float(lengths[2]))
