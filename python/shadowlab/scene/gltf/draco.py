"""Primitives compressed by KHR_draco_mesh_compression, decoded by the package DracoPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .accessors import Accessors
from .extensions import DRACO, HOW, installed
from .items import JsonObject


@dataclass(frozen=True, eq=False)
class Decoded:
    """A decoded primitive: triangles (M, 3), and attributes (V, width) by name as they are stored."""

    faces: NDArray[Any]
    attributes: dict[str, NDArray[Any]]


def decoded_primitive(primitive: JsonObject, accessors: Accessors) -> Decoded | str | None:
    """What the compressed data of a primitive says.

    Parameters
    ----------
    primitive : JsonObject
    accessors : Accessors

    Returns
    -------
    Decoded, str or None
        None where the primitive has no compressed data, or has others beside it; why it cannot be decoded, where no
        decoder is installed and the file does not require one.

    Raises
    ------
    LoadError
        For data that cannot be decoded, or that is not what the accessors say.
    """
    packed = primitive.extension(DRACO)
    if packed is None:
        return None
    attributes = primitive.needed("attributes")
    required = DRACO in accessors.document.required
    plain = "POSITION" in attributes.value and accessors.has_data(attributes, "POSITION")
    if not required and plain:
        return None
    if not installed("DracoPy"):
        return f"{DRACO}, {HOW}"
    return _decoded(packed, attributes, accessors)


def _decoded(packed: JsonObject, attributes: JsonObject, accessors: Accessors) -> Decoded:
    import DracoPy

    document = accessors.document
    view = accessors.buffers.view(packed.index("bufferView", len(document.views), "buffer views"))
    names = packed.needed("attributes")
    layouts = {
        name: accessors.layout(attributes, name, ("SCALAR", "VEC2", "VEC3", "VEC4"))
        for name in names.value
        if name in attributes.value
    }
    for layout in layouts.values():
        document.expand(layout.count * layout.element)
    try:
        mesh = DracoPy.decode(bytes(view.data))
    except MemoryError:
        raise
    except Exception as e:
        raise packed.broken(f"expected data of Draco, could not decode it ({type(e).__name__}: {e})") from e
    faces = getattr(mesh, "faces", None)
    if faces is None:
        raise packed.broken("expected a mesh in the data of Draco, got a point cloud")
    found = {}
    stored = {int(one["unique_id"]): np.asarray(one["data"]) for one in mesh.attributes}
    for name, layout in layouts.items():
        identity = names.whole(name)
        if identity not in stored:
            raise names.wrong(name, f"the identity of an attribute in the data of Draco ({sorted(stored)})")
        data = stored[identity]
        if data.shape != (layout.count, layout.width):
            raise names.broken(
                f"{name}: expected {layout.count} elements of {layout.width} components, as its accessor says, got "
                f"{' x '.join(map(str, data.shape))} from the data of Draco"
            )
        found[name] = data
    return Decoded(np.asarray(faces).reshape(-1, 3), found)
