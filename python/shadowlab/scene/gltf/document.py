"""A glTF document: JSON text or the chunks of a binary file, its version and extensions checked before all else."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NoReturn

from ...errors import LoadError
from ..formats.given import Given
from ..formats.limits import check_limit
from .extensions import checked_extensions
from .items import FIX, JsonObject, brief

MAGIC = b"glTF"
BINARY_VERSION = 2
JSON_CHUNK, BIN_CHUNK = 0x4E4F534A, 0x004E4942
LONGEST_VERSION = 20
# The newest minor version of glTF 2 that is known; a file may demand a newer one by its minVersion.
NEWEST_MINOR = 0
# Bytes that a file may expand to, whatever its size; beyond, `Limits.ratio` counts. Chosen well below any memory.
FREE_BYTES = 64 << 20


@dataclass(eq=False)
class Document:
    """A document and the state of its reading.

    Attributes
    ----------
    given : Given
    top : JsonObject
        The document's JSON.
    binary : memoryview, optional
        The binary chunk.
    required : frozenset of str
        Extensions that it requires.
    notes : list of str
        What is said of the file in warnings.
    """

    given: Given
    top: JsonObject
    binary: memoryview | None
    required: frozenset[str] = frozenset()
    notes: list[str] = field(default_factory=list)
    size: int = 0
    expanded: int = 0
    _primitives: dict[int, list[JsonObject]] = field(default_factory=dict)

    @cached_property
    def nodes(self) -> list[JsonObject]:
        """All nodes."""
        return self.top.items("nodes")

    @cached_property
    def meshes(self) -> list[JsonObject]:
        """All meshes."""
        return self.top.items("meshes")

    def primitives(self, mesh: int) -> list[JsonObject]:
        """The primitives of a mesh."""
        if mesh not in self._primitives:
            self._primitives[mesh] = self.meshes[mesh].items("primitives")
        return self._primitives[mesh]

    @cached_property
    def accessors(self) -> list[JsonObject]:
        """All accessors."""
        return self.top.items("accessors")

    @cached_property
    def views(self) -> list[JsonObject]:
        """All buffer views."""
        return self.top.items("bufferViews")

    @cached_property
    def buffers(self) -> list[JsonObject]:
        """All buffers."""
        return self.top.items("buffers")

    @cached_property
    def skins(self) -> list[JsonObject]:
        """All skins."""
        return self.top.items("skins")

    @cached_property
    def materials(self) -> list[JsonObject]:
        """All materials."""
        return self.top.items("materials")

    @cached_property
    def textures(self) -> list[JsonObject]:
        """All textures."""
        return self.top.items("textures")

    @cached_property
    def images(self) -> list[JsonObject]:
        """All images."""
        return self.top.items("images")

    @cached_property
    def samplers(self) -> list[JsonObject]:
        """All samplers of textures."""
        return self.top.items("samplers")

    def expand(self, asked: int) -> None:
        """Counts bytes that are made of fewer bytes of the file.

        Raises
        ------
        LoadError
            Where they are more than the limits allow.
        """
        self.expanded += asked
        if self.expanded > FREE_BYTES:
            ratio = self.expanded / max(self.size, 1)
            check_limit(
                self.given.limits,
                self.given.name,
                "ratio",
                round(ratio, 1),
                "bytes in memory for each byte of the file",
            )


def document_of(given: Given) -> Document:
    """The document of a file, its version and extensions checked.

    Raises
    ------
    LoadError
        For data that is no glTF 2 document, or that requires extensions that are not read.
    """
    data = given.data
    if data[:4] == MAGIC:
        text, binary = chunks_of(given.name, data)
    else:
        text, binary = memoryview(data), None
    plain = bytes(text)
    # Each takes many times its few letters.
    check_limit(given.limits, given.name, "objects", plain.count(b"{") + plain.count(b"["), "objects and lists")
    top = JsonObject(given.name, "", parsed(given.name, plain))
    check_asset_version(top)
    required, missed = checked_extensions(top)
    found = Document(given, top, binary, required, size=len(data))
    if missed:
        found.notes.append(
            f"passed over extension{'s' if len(missed) > 1 else ''} {', '.join(missed)}: geometry may differ"
        )
    return found


def chunks_of(name: str, data: bytes) -> tuple[memoryview, memoryview | None]:
    """JSON text and binary chunk of a binary file; other chunks are passed over.

    Raises
    ------
    LoadError
        For another version of the container, or lengths that its bytes do not have.
    """
    if len(data) < 12:
        broken(name, f"a header of 12 bytes, got a file of {len(data)}")
    version, length = struct.unpack_from("<II", data, 4)
    if version != BINARY_VERSION:
        broken(name, f"version {BINARY_VERSION} of the binary container, got {version}")
    if length > len(data):
        broken(name, f"the {length:,} bytes that its header names, got {len(data):,}: it is truncated")
    view, text, binary, at = memoryview(data)[:length], None, None, 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > length:
            broken(name, f"a chunk of {size:,} bytes at byte {at}, got {length - at - 8:,} up to its end")
        body = view[at + 8 : at + 8 + size]
        if text is None:
            if kind != JSON_CHUNK:
                broken(name, f"JSON in its first chunk, got a chunk of type {kind:#010x}")
            text = body
        elif kind == BIN_CHUNK and binary is None:
            binary = body
        at += 8 + size
    if text is None:
        broken(name, "a chunk of JSON, got none")
    return text, binary


def parsed(name: str, text: bytes) -> dict[str, Any]:
    """The JSON object of a text.

    Raises
    ------
    LoadError
        For what is no JSON object in UTF-8.
    """

    def refuse(constant: str) -> NoReturn:
        raise ValueError(f"{constant} is no JSON number")

    try:
        # Trailing zeros are the padding of careless writers.
        plain = text.rstrip(b"\0").decode("utf-8-sig")
        # Python is asked about every object: nothing else interrupts the parser.
        found = json.loads(plain, parse_constant=refuse, object_hook=_same)
    except RecursionError:
        broken(name, "JSON of a document, got values nested too deeply")
    except ValueError as e:
        broken(name, f"JSON in UTF-8, could not read it ({e})", e)
    if not isinstance(found, dict):
        broken(name, f"a JSON object, got {brief(found)}")
    return found


def _same(value: dict[str, Any]) -> dict[str, Any]:
    return value


def check_asset_version(top: JsonObject) -> None:
    """Raises for a document of another version than glTF 2.

    Raises
    ------
    LoadError
    """
    asset = top.item("asset")
    if asset is None:
        raise top.broken("asset: expected an object with the version of glTF, got none", f"{FIX} as glTF 2.0")
    for key in ("minVersion", "version"):
        if key == "minVersion" and key not in asset.value:
            continue
        # Longer ones are no versions, and take long to become numbers.
        parts = asset.text(key).split(".") if len(asset.text(key)) < LONGEST_VERSION else []
        good = len(parts) == 2 and all(part.isascii() and part.isdigit() for part in parts) and int(parts[0]) == 2
        if not good or (key == "minVersion" and int(parts[1]) > NEWEST_MINOR):
            wanted = "2.0" if key == "minVersion" else "2.0, or another minor version"
            raise asset.wrong(key, wanted, f"{FIX} as glTF 2.0")


def broken(name: str, expected: str, cause: Exception | None = None) -> NoReturn:
    """Raises for a file whose structure is wrong."""
    raise LoadError(f"{name}: expected {expected}; {FIX}") from cause
