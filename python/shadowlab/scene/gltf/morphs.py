"""Morph targets: displacements of vertices with the weights that a node or its mesh gives them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .accessors import Accessors
from .items import JsonObject
from .primitives import Primitive


def weights_of(node: JsonObject, mesh: JsonObject) -> tuple[float, ...]:
    """The weights of a mesh at a node: the node's own, else the mesh's. Empty where all are 0.

    Raises
    ------
    LoadError
        For weights that are no finite numbers.
    """
    if "weights" not in node.value and "weights" not in mesh.value:
        return ()
    holder = node if "weights" in node.value else mesh
    weights = holder.numbers("weights")
    return () if weights is None or not weights.any() else tuple(weights.tolist())


def morphed(primitive: Primitive, weights: tuple[float, ...], accessors: Accessors) -> NDArray[Any]:
    """The vertices (V, 3) of a primitive, moved by its targets.

    Raises
    ------
    LoadError
        For other numbers of weights than targets, or a target with another number of vertices.
    """
    targets = primitive.item.items("targets")
    if not weights:
        return primitive.vertices
    if not targets:
        accessors.document.notes.append(f"{primitive.label} has weights and no morph targets: it stays as it is")
        return primitive.vertices
    if len(weights) != len(targets):
        raise primitive.item.broken(
            f"targets: expected one per weight of {primitive.label}, which are {len(weights)}, got {len(targets)}"
        )
    made = primitive.vertices.astype(np.float64)
    for weight, target in zip(weights, targets, strict=True):
        if weight == 0 or "POSITION" not in target.value:
            continue
        moves = accessors.floats(target, "POSITION", "VEC3")
        if len(moves) != len(made):
            raise target.broken(
                f"POSITION: expected {len(made)} elements, one per vertex of {primitive.label}, got {len(moves)}"
            )
        made += weight * moves.astype(np.float64)
    return made
