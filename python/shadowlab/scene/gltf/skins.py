"""Skins: vertices posed by joints, as the nodes of the file stand (glTF 2.0, "Skins")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .accessors import Accessors, dequantised
from .graph import Graph
from .items import JsonObject
from .primitives import Primitive

# Vertices that are posed at once: what is gathered for them, 96 bytes each, stays in a cache.
BLOCK = 1 << 15
# How far the sum of a vertex's weights may be from 1 before it is said: four bytes, rounded each for itself.
SUM_TOLERANCE = 0.02
# Sets of joints and weights that are looked for: four joints each.
MOST_SETS = 64


def joint_matrices(skin: JsonObject, graph: Graph, accessors: Accessors) -> NDArray[np.float64]:
    """(J, 3, 4): world from the mesh at rest, for each joint.

    Raises
    ------
    LoadError
        For joints that do not exist, or too few inverse bind matrices.
    SceneError
        For matrices that are not finite.
    """
    joints = skin.indices("joints", len(graph.parent), "nodes")
    if not joints:
        raise skin.broken("joints: expected at least one node, got none")
    world = graph.world[joints]
    if "inverseBindMatrices" in skin.value:
        inverse = accessors.floats(skin, "inverseBindMatrices", "MAT4").astype(np.float64)
        if len(inverse) < len(joints):
            raise skin.broken(f"inverseBindMatrices: expected {len(joints)}, one per joint, got {len(inverse)}")
        # Columns one after the other, as all matrices of glTF.
        world = world @ inverse[: len(joints)].reshape(-1, 4, 4).swapaxes(1, 2)
    if not np.isfinite(world).all():
        raise SceneError(
            f"{skin.file}: {skin.place}: expected finite joint matrices, got others; export the file again"
        )
    return world[:, :3]


def posed(
    primitive: Primitive, vertices: NDArray[Any], matrices: NDArray[np.float64], accessors: Accessors
) -> NDArray[np.float64] | None:
    """The vertices (V, 3) in world space, posed by joints; None for a primitive without joints.

    Parameters
    ----------
    primitive : Primitive
    vertices : (V, 3) float
        Its vertices, moved by morph targets before.
    matrices : (J, 3, 4) float64
        As of `joint_matrices`.
    accessors : Accessors

    Raises
    ------
    LoadError
        For joints without weights.
    SceneError
        For a joint that the skin does not have.
    """
    found = influences(primitive, accessors)
    if found is None:
        return None
    joints, weights = found
    total = weights.sum(axis=1)
    none = ~(total > 0)
    if none.any():
        accessors.document.notes.append(
            f"{int(none.sum())} vertices of {primitive.label} have no weights: their first joint moves them"
        )
        weights[none, 0], total = 1.0, np.where(none, 1.0, total)
    if (np.abs(total - 1) > SUM_TOLERANCE).any():
        accessors.document.notes.append(f"weights of {primitive.label} do not add up to 1: their proportions are taken")
    weights /= total[:, None]
    wrong = (joints >= len(matrices)) & (weights > 0)
    if wrong.any():
        vertex = int(np.argmax(wrong.any(axis=1)))
        raise SceneError(
            f"{primitive.item.file}: {primitive.label}: expected joints below the {len(matrices)} of its skin, got "
            f"{int(joints[wrong].max())} at vertex {vertex}; export the file again"
        )
    joints = np.where(weights > 0, joints, 0)
    made = np.empty((len(vertices), 3))
    points = np.ones((BLOCK, 4))
    for start in range(0, len(vertices), BLOCK):
        rows = slice(start, min(start + BLOCK, len(vertices)))
        count = rows.stop - start
        points[:count, :3] = vertices[rows]
        blended = np.zeros((count, 3, 4))
        for k in range(joints.shape[1]):
            blended += weights[rows, k, None, None] * matrices[joints[rows, k]]
        made[rows] = np.einsum("nij,nj->ni", blended, points[:count])
    return made


def influences(primitive: Primitive, accessors: Accessors) -> tuple[NDArray[Any], NDArray[np.float64]] | None:
    """Joints (V, 4 K) and weights (V, 4 K) of all K sets; None where there are none."""
    joints, weights = [], []
    for i in range(MOST_SETS):
        moved = primitive.raw_attribute(f"JOINTS_{i}", accessors, "VEC4")
        raw = primitive.raw_attribute(f"WEIGHTS_{i}", accessors, "VEC4")
        if moved is None and raw is None:
            break
        if moved is None or raw is None:
            missing = "JOINTS" if moved is None else "WEIGHTS"
            raise primitive.item.broken(f"attributes: expected {missing}_{i} beside the other, found none")
        if moved[0].dtype.kind != "u":
            raise primitive.item.broken(f"JOINTS_{i}: expected unsigned integers, got others")
        # Integer weights are shares whether they are marked so or not.
        share = dequantised(raw[0], True).astype(np.float64)
        if not (np.isfinite(share).all() and (share >= 0).all()):
            raise primitive.item.broken(f"WEIGHTS_{i}: expected finite weights of at least 0, got others")
        joints.append(moved[0])
        weights.append(share)
    return (np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)) if joints else None
