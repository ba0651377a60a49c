"""Instances of a node's mesh: EXT_mesh_gpu_instancing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..formats.limits import check_limit
from .accessors import WIDTHS, Accessors
from .extensions import INSTANCING
from .graph import TRANSFORM_BYTES, transforms_of, unit_quaternions
from .items import JsonObject

#: The attributes that place instances, with their types and what stands for a missing one. Others are an application's.
PLACING = {
    "TRANSLATION": ("VEC3", (0.0, 0.0, 0.0)),
    "ROTATION": ("VEC4", (0.0, 0.0, 0.0, 1.0)),
    "SCALE": ("VEC3", (1.0,) * 3),
}


def instances_of(node: JsonObject, accessors: Accessors) -> NDArray[np.float64] | None:
    """Node from instance (K, 4, 4); None for a node without the extension.

    Raises
    ------
    LoadError
        For attributes of different lengths, none at all, or more instances than the limits allow.
    """
    extension = node.extension(INSTANCING)
    if extension is None:
        return None
    attributes = extension.needed("attributes")
    # Those of an application count, too: they say how many there are.
    counts = {name: accessors.layout(attributes, name, tuple(WIDTHS)).count for name in attributes.value}
    if len(set(counts.values())) != 1:
        told = ", ".join(f"{name} {count}" for name, count in counts.items()) or "none"
        raise attributes.broken(f"expected attributes with one element per instance, got {told}")
    count = next(iter(counts.values()))
    limits = accessors.document.given.limits
    check_limit(limits, node.file, "instances", count, f"instances at {node.place}")
    accessors.document.expand(count * TRANSFORM_BYTES)
    parts = []
    for name, (kind, default) in PLACING.items():
        if name in attributes.value:
            parts.append(accessors.floats(attributes, name, kind).astype(np.float64))
        else:
            parts.append(np.broadcast_to(np.array(default), (count, len(default))))
    if not all(np.isfinite(part).all() for part in parts):
        raise attributes.broken("expected finite numbers, got others")
    unit, wrong = unit_quaternions(parts[1])
    if wrong:
        zero = int((~parts[1].any(axis=1)).sum())
        accessors.document.notes.append(
            f"{len(wrong)} of {count} instances at {node.place} have rotations that are no unit quaternions: "
            f"their directions are taken{f', and none for {zero} of zeros' if zero else ''}"
        )
    return transforms_of(parts[0], unit, parts[2])
