"""Primitives of glTF meshes as vertices and triangles: lists, strips and fans, with indices and without."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from .accessors import Accessors, dequantised
from .draco import Decoded, decoded_primitive
from .items import JsonObject

LIST, STRIP, FAN = 4, 5, 6
OTHERS = {0: "points", 1: "lines", 2: "a line loop", 3: "a line strip"}


@dataclass(frozen=True, eq=False)
class Primitive:
    """A primitive with its geometry at rest.

    Attributes
    ----------
    item : JsonObject
    label : str
        Its mesh, and which of several primitives it is.
    vertices : (V, 3) float
    faces : (M, 3) integer
        In the order of the file.
    decoded : Decoded, optional
        What was compressed with it.
    """

    item: JsonObject
    label: str
    vertices: NDArray[Any]
    faces: NDArray[Any]
    decoded: Decoded | None

    def attribute(self, name: str, accessors: Accessors, *types: str) -> NDArray[Any] | None:
        """The attribute (V, width) of a name, dequantised; None where there is none.

        Raises
        ------
        LoadError
            Where it cannot be read, or has not one element per vertex.
        """
        raw = self.raw_attribute(name, accessors, *types)
        return None if raw is None else dequantised(*raw)

    def raw_attribute(self, name: str, accessors: Accessors, *types: str) -> tuple[NDArray[Any], bool] | None:
        """The attribute (V, width) of a name as it is stored, and whether its integers are normalised."""
        attributes = self.item.needed("attributes")
        if name not in attributes.value:
            return None
        layout = accessors.layout(attributes, name, types)
        if self.decoded is not None and name in self.decoded.attributes:
            return self.decoded.attributes[name], layout.normalized
        values = accessors.raw(attributes, name, *types)[1]
        if len(values) != len(self.vertices):
            raise attributes.broken(
                f"{name}: expected {len(self.vertices)} elements, one per vertex of {self.label}, got {len(values)}"
            )
        return values, layout.normalized


def primitive_of(item: JsonObject, label: str, accessors: Accessors) -> Primitive | str:
    """The geometry of a primitive; why it has none, where it is left out.

    Parameters
    ----------
    item : JsonObject
        The primitive.
    label : str
        Its name for errors and warnings.
    accessors : Accessors

    Raises
    ------
    LoadError
        For what cannot be read.
    SceneError
        For indices that restart a strip.
    """
    mode = item.whole("mode", LIST)
    if mode in OTHERS:
        return OTHERS[mode]
    if mode not in (LIST, STRIP, FAN):
        raise item.wrong("mode", "0 to 6")
    attributes = item.needed("attributes")
    if "POSITION" not in attributes.value:
        return "no positions"
    decoded = decoded_primitive(item, accessors)
    if isinstance(decoded, str):
        accessors.document.notes.append(f"left out {label}, whose data is compressed by {decoded}")
        return "compressed"
    layout = accessors.layout(attributes, "POSITION", ("VEC3",))
    if decoded is not None and "POSITION" in decoded.attributes:
        vertices = dequantised(decoded.attributes["POSITION"], layout.normalized)
    else:
        vertices = accessors.floats(attributes, "POSITION", "VEC3")
    if decoded is not None:
        faces = decoded.faces
    else:
        indexed = "indices" in item.value
        order = accessors.indices(item, "indices") if indexed else np.arange(len(vertices), dtype=np.uint32)
        if indexed and mode != LIST:
            check_no_restart(order, item, label)
        faces = triangles_of(order, mode)
        left = len(order) % 3
        if mode == LIST and left:
            accessors.document.notes.append(
                f"left out the last {left} of the vertices of {label}: three make a triangle"
            )
    return Primitive(item, label, vertices, faces, decoded)


def triangles_of(order: NDArray[Any], mode: int) -> NDArray[Any]:
    """The triangles (M, 3) of vertices in order, as glTF 2.0 ("Meshes", "Overview") numbers them.

    Degenerate triangles of strips stay, so that row i is triangle i of the file.
    """
    count = len(order)
    if mode == LIST:
        return order[: count - count % 3].reshape(-1, 3)
    if count < 3:
        return np.empty((0, 3), order.dtype)
    if mode == FAN:
        return np.column_stack([order[1:-1], order[2:], np.broadcast_to(order[:1], (count - 2,))])
    faces = np.column_stack([order[:-2], order[1:-1], order[2:]])
    # Every other triangle runs the other way round, so that all show the same side.
    faces[1::2, 1:] = faces[1::2, :0:-1].copy()
    return faces


def check_no_restart(order: NDArray[Any], item: JsonObject, label: str) -> None:
    """Raises for an index that would begin a new strip.

    Raises
    ------
    SceneError
    """
    highest = np.iinfo(order.dtype).max
    if len(order) and int(order.max()) == highest:
        raise SceneError(
            f"{item.file}: {label}: expected indices of vertices, got {highest}, which restarts a strip in other "
            "formats and is forbidden in glTF; export the strips as primitives of their own"
        )


def check_range(faces: NDArray[Any], count: int, label: str, file: str) -> None:
    """Raises for an index of no vertex.

    Raises
    ------
    SceneError
    """
    if faces.size and int(faces.max()) >= count:
        face = int(np.argmax((faces >= count).any(axis=1)))
        raise SceneError(
            f"{file}: {label}: expected indices below its {count} vertices, got {int(faces[face].max())} in triangle "
            f"{face}; export the file again"
        )
