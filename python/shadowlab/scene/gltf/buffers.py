"""Buffers of a glTF document and views of them: bytes from URIs and chunks, compressed views decoded."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass, field
from urllib.parse import unquote_to_bytes

from ..formats.limits import check_limit
from .document import Document
from .extensions import HOW, MESHOPT, installed
from .items import JsonObject
from .meshopt import decoded_view


@dataclass(frozen=True, eq=False)
class ViewBytes:
    """The bytes of a buffer view, and the distance of its elements if it names one (0: one after the other)."""

    data: memoryview
    stride: int


@dataclass(eq=False)
class Buffers:
    """Buffers and views of a document, each read at the first use and kept."""

    document: Document
    _buffers: dict[int, memoryview] = field(default_factory=dict)
    _views: dict[int, ViewBytes] = field(default_factory=dict)

    def view(self, index: int) -> ViewBytes:
        """The bytes of a buffer view.

        Raises
        ------
        LoadError
            For a view outside of its buffer, a buffer that is missing or shorter than it says, or a broken compression.
        """
        if index not in self._views:
            item = self.document.views[index]
            packed = item.extension(*MESHOPT)
            if packed is None or (self._optional(packed) and self._has_data(item)):
                self._views[index] = ViewBytes(self._cut(item), stride_of(item))
            else:
                self._views[index] = self._unpacked(item, packed)
        return self._views[index]

    def _optional(self, packed: JsonObject) -> bool:
        return not any(name in self.document.required and packed.where.endswith(name) for name in MESHOPT)

    def _has_data(self, view: JsonObject) -> bool:
        """Whether the buffer of a view has bytes of its own, beside compressed ones."""
        buffer = self.document.buffers[view.index("buffer", len(self.document.buffers), "buffers")]
        fallback = buffer.extension(*MESHOPT)
        if fallback is not None and fallback.flag("fallback", False) and "uri" not in buffer.value:
            return False
        return "uri" in buffer.value or (buffer.where == "buffers[0]" and self.document.binary is not None)

    def _unpacked(self, view: JsonObject, packed: JsonObject) -> ViewBytes:
        count, stride = packed.whole("count"), packed.whole("byteStride", least=1)
        length = view.whole("byteLength", least=1)
        if length != count * stride:
            raise view.wrong("byteLength", f"{count} elements of {stride} bytes, as its compression says")
        if not installed("meshoptimizer"):
            raise packed.broken("expected a decoder, since the view has no data without compression", HOW)
        limits = self.document.given.limits
        check_limit(limits, packed.file, "elements", count, f"elements in {packed.where}")
        self.document.expand(length)
        data = decoded_view(packed, bytes(self._cut(packed)), count, stride)
        return ViewBytes(memoryview(data), stride_of(view))

    def _cut(self, view: JsonObject) -> memoryview:
        """The part of a buffer that a view, or the compression of one, names."""
        buffer = self.buffer(view.index("buffer", len(self.document.buffers), "buffers"))
        offset, length = view.whole("byteOffset", 0), view.whole("byteLength", least=1)
        if offset + length > len(buffer):
            raise view.broken(
                f"expected bytes {offset:,} to {offset + length:,} of its buffer, which has {len(buffer):,}"
            )
        return buffer[offset : offset + length]

    def buffer(self, index: int) -> memoryview:
        """The bytes of a buffer.

        Raises
        ------
        LoadError
            Where it is missing, or shorter than it says.
        """
        if index not in self._buffers:
            item = self.document.buffers[index]
            length = item.whole("byteLength", least=1)
            check_limit(self.document.given.limits, item.file, "size", length, f"bytes in {item.where}")
            data = self._bytes(index, item)
            if len(data) < length:
                raise item.broken(f"expected {length:,} bytes, got {len(data):,}: it is truncated")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def _bytes(self, index: int, item: JsonObject) -> memoryview:
        if "uri" in item.value:
            return memoryview(self.at_uri(item))
        if index == 0 and self.document.binary is not None:
            return self.document.binary
        raise item.broken("expected a URI or a binary chunk with its bytes, found neither")

    def at_uri(self, item: JsonObject) -> bytes:
        """The bytes at the URI of an object: in the text itself, or in a file beside this one.

        Raises
        ------
        LoadError
            For a broken URI of data, or a file that is missing.
        """
        uri = item.text("uri")
        if uri[:5].lower() == "data:":
            return data_of(item, uri)
        data = self.document.given.beside(uri)
        self.document.size += len(data)
        return data


def stride_of(view: JsonObject) -> int:
    """The byteStride of a view; 0 where it has none."""
    if "byteStride" not in view.value:
        return 0
    stride = view.whole("byteStride", least=1)
    if stride > 252:
        raise view.wrong("byteStride", "at most 252 bytes")
    return stride


def data_of(item: JsonObject, uri: str) -> bytes:
    """The bytes in a data URI (RFC 2397), in base64 or percent-encoded.

    Raises
    ------
    LoadError
        For a broken one.
    """
    head, comma, body = uri[5:].partition(",")
    if not comma:
        raise item.broken("uri: expected a comma between the type and the bytes of a data URI, got none")
    data = unquote_to_bytes(body)
    if head.lower().replace(" ", "").split(";")[-1] != "base64":
        return data
    data = b"".join(data.split())
    try:
        return base64.b64decode(data + b"=" * (-len(data) % 4), validate=True)
    except binascii.Error as e:
        raise item.broken(f"uri: expected bytes in base64, could not read them ({e})") from e
