"""Lights of a glTF document at their nodes: KHR_lights_punctual. Scale changes neither range nor cone."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ... import _core
from ...errors import ArgumentError
from ..foreign_views import SPARE
from ..placed import farthest, unique
from .extensions import PUNCTUAL
from .graph import Graph
from .items import JsonObject

if TYPE_CHECKING:
    from ...types import Light

Bounds = Callable[[], NDArray[np.float64]]


def lights_in(graph: Graph, nodes: list[int], bounds: Bounds, notes: list[str]) -> dict[str, Light]:
    """The lights at nodes, by name: the node's, else the light's.

    Parameters
    ----------
    graph : Graph
    nodes : list of int
        The visible ones of the active scene, in the order of the file.
    bounds : callable
        The box (2, 3) of the scene; asked for only where a light has no range.
    notes : list of str
        Gets what is left out.
    """
    found: dict[str, Light] = {}
    extension = graph.document.top.extension(PUNCTUAL)
    listed = [] if extension is None else extension.items("lights")
    for index in nodes:
        node = graph.document.nodes[index]
        at = node.extension(PUNCTUAL)
        if at is None:
            continue
        light = listed[at.index("light", len(listed), "lights")]
        name = unique(node.name or light.name or f"light {len(found) + 1}", found)
        try:
            found[name] = light_at(light, graph.world[index], bounds)
        except ArgumentError as e:
            notes.append(f"left out light {name!r}: {e}")
    return found


def light_at(light: JsonObject, pose: NDArray[np.float64], bounds: Bounds) -> Light:
    """The light of a pose, world from light: it shines along -z.

    Raises
    ------
    LoadError
        For another type, or numbers that are none.
    ArgumentError
        For settings that ours do not have, such as a cone of 180 degrees.
    """
    kind = light.text("type")
    if kind not in ("directional", "point", "spot"):
        raise light.wrong("type", "directional, point or spot")
    if not np.isfinite(pose).all():
        raise ArgumentError("its pose is not finite")
    way, position = -pose[:3, 2], pose[:3, 3]
    if kind == "directional":
        return _core.DirectionalLight(way)
    # A light without a range has no end; one that reaches all of the scene is the same for it. A point has no extent.
    reach = light.number("range") if "range" in light.value else (1 + SPARE) * farthest(bounds(), position) or 1.0
    if kind == "point":
        return _core.PointLight(position, range=reach)
    cone = light.item("spot")
    # Theirs is from the axis to the edge, ours from edge to edge.
    half = pi / 4 if cone is None else cone.number("outerConeAngle", pi / 4)
    return _core.SpotLight(position, way, cone_angle=2 * half, range=reach)
