"""glTF files written by hand: JSON and bytes, one accessor after the other."""

from __future__ import annotations

import base64
import json
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import shadowlab as sl
from shadowlab.errors import ShadowlabWarning

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
#: A triangle in x, y.
TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


class Gltf:
    """A document that grows; every method returns the index of what it added."""

    def __init__(self, **top: Any):
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, **top}
        self.data = bytearray()

    def add(self, kind: str, **fields: Any) -> int:
        self.json.setdefault(kind, []).append(fields)
        return len(self.json[kind]) - 1

    def view(self, data: bytes, **fields: Any) -> int:
        self.data += bytes(-len(self.data) % 4)
        offset = len(self.data)
        self.data += data
        return self.add("bufferViews", buffer=0, byteOffset=offset, byteLength=len(data), **fields)

    def accessor(self, values: Any, kind: str = "f4", **fields: Any) -> int:
        """An accessor of its own view; `bufferView=None` leaves that out."""
        array = np.array(values, "<" + kind)
        if "bufferView" not in fields:
            fields["bufferView"] = self.view(array.tobytes())
        elif fields["bufferView"] is None:
            del fields["bufferView"]
        width = 1 if array.ndim == 1 else array.shape[1]
        fields = {"count": len(array), "type": TYPES[width], "componentType": COMPONENTS[kind], **fields}
        return self.add("accessors", **fields)

    def sparse(self, rows: Any, values: Any, row_kind: str = "u2", kind: str = "f4") -> dict[str, Any]:
        """The field `sparse` of an accessor."""
        indices = {
            "bufferView": self.view(np.array(rows, "<" + row_kind).tobytes()),
            "componentType": COMPONENTS[row_kind],
        }
        return {
            "count": len(rows),
            "indices": indices,
            "values": {"bufferView": self.view(np.array(values, "<" + kind).tobytes())},
        }

    def mesh(self, positions: Any = TRIANGLE, indices: Any = None, *, kind: str = "u2", **fields: Any) -> int:
        """A mesh of one primitive; positions as an accessor's index or as values."""
        at = positions if isinstance(positions, int) else self.accessor(positions)
        primitive = {"attributes": {"POSITION": at, **fields.pop("attributes", {})}}
        if indices is not None:
            primitive["indices"] = indices if isinstance(indices, int) else self.accessor(indices, kind)
        of_mesh = {name: fields.pop(name) for name in ("name", "weights") if name in fields}
        return self.add("meshes", primitives=[{**primitive, **fields}], **of_mesh)

    def node(self, **fields: Any) -> int:
        return self.add("nodes", **fields)

    def scene(self, *nodes: int) -> Gltf:
        self.add("scenes", nodes=list(nodes))
        self.json["scene"] = 0
        return self

    def document(self) -> dict[str, Any]:
        if self.data and "buffers" not in self.json:
            self.json["buffers"] = [{"byteLength": len(self.data)}]
        return self.json

    def glb(self, *extra: tuple[int, bytes]) -> bytes:
        return glb_of(json.dumps(self.document()).encode(), bytes(self.data), *extra)

    def text(self) -> bytes:
        """The text with its buffer in a data URI."""
        document = self.document()
        if self.data:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
            document = {**document, "buffers": [{"byteLength": len(self.data), "uri": uri}, *document["buffers"][1:]]}
        return json.dumps(document).encode()


def glb_of(text: bytes, data: bytes, *extra: tuple[int, bytes]) -> bytes:
    """A binary file of JSON, bytes, and chunks of other types."""
    body = b""
    for kind, chunk in ((0x4E4F534A, text), *([(0x004E4942, data)] if data else []), *extra):
        chunk += (b" " if kind == 0x4E4F534A else b"\0") * (-len(chunk) % 4)
        body += struct.pack("<II", len(chunk), kind) + chunk
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def loaded(folder: Path, content: Gltf | bytes, name: str = "scene.glb") -> sl.Scene:
    """The scene of a file; a warning is an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return sl.load_scene(written(folder, content, name))


def told(folder: Path, content: Gltf | bytes, name: str = "scene.glb") -> tuple[sl.Scene, str]:
    """The scene of a file, and the text of all warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = sl.load_scene(written(folder, content, name))
    assert all(issubclass(one.category, ShadowlabWarning) for one in caught)
    assert all(one.filename == __file__ for one in caught), "a warning points at whoever loads"
    return scene, "\n".join(str(one.message) for one in caught)


def written(folder: Path, content: Gltf | bytes, name: str = "scene.glb") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.glb())
    return path


def corners(scene: sl.Scene) -> np.ndarray:
    """(F, 3, 3): the corners of all triangles in world space."""
    vertices, faces = scene.to_arrays()
    return vertices[faces]
