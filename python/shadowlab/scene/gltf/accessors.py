"""Accessors of a glTF document as arrays: views of bytes, sparse values in their places, integers dequantised.

Nothing is allocated before count, stride and offsets are checked against the bytes that there are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..formats.limits import check_limit
from .buffers import Buffers, ViewBytes
from .document import Document
from .items import JsonObject

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
INDEX_COMPONENTS = (5121, 5123, 5125)
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass(frozen=True, eq=False)
class Layout:
    """What an accessor says of its elements."""

    item: JsonObject
    count: int
    width: int
    kind: np.dtype[Any]
    normalized: bool

    @property
    def element(self) -> int:
        """Bytes of an element."""
        return self.width * self.kind.itemsize


@dataclass(eq=False)
class Accessors:
    """The accessors of a document, each read at the first use and kept."""

    document: Document
    buffers: Buffers
    _arrays: dict[int, NDArray[Any]] = field(default_factory=dict)
    _numbers: dict[int, NDArray[Any]] = field(default_factory=dict)

    @classmethod
    def of(cls, document: Document) -> Accessors:
        """Those of a document."""
        return cls(document, Buffers(document))

    def layout(self, item: JsonObject, key: str, types: tuple[str, ...]) -> Layout:
        """What the accessor that `item` refers to by a key says of its elements.

        Parameters
        ----------
        item : JsonObject
            What refers to it.
        key : str
            Its field with the index.
        types : tuple of str
            The types that it may have.

        Raises
        ------
        LoadError
            For another type, or more elements than the limits allow.
        """
        accessor = self.document.accessors[item.index(key, len(self.document.accessors), "accessors")]
        kind = COMPONENTS.get(accessor.whole("componentType"))
        if kind is None:
            raise accessor.wrong("componentType", f"one of {', '.join(map(str, COMPONENTS))}")
        if accessor.text("type") not in types:
            raise accessor.wrong("type", f"{' or '.join(types)} for {item.where}.{key}")
        count = accessor.whole("count")
        limits = self.document.given.limits
        check_limit(limits, accessor.file, "elements", count, f"elements in {accessor.where}")
        normalized = accessor.flag("normalized", False) and kind != "<f4"
        return Layout(accessor, count, WIDTHS[accessor.text("type")], np.dtype(kind), normalized)

    def raw(self, item: JsonObject, key: str, *types: str) -> tuple[Layout, NDArray[Any]]:
        """The elements (count, width) of an accessor as they are stored, with its layout; not to be written to.

        Raises
        ------
        LoadError
            As `layout`, and for bytes that are not there.
        """
        layout = self.layout(item, key, types)
        index = int(item.value[key])
        if index not in self._arrays:
            self._arrays[index] = self._read(layout)
        return layout, self._arrays[index]

    def floats(self, item: JsonObject, key: str, *types: str) -> NDArray[Any]:
        """The elements (count, width) as numbers, dequantised: float32 where they are stored so, else float64.

        Raises
        ------
        LoadError
            As `raw`.
        """
        layout, values = self.raw(item, key, *types)
        if layout.kind.kind == "f":
            return values
        index = int(item.value[key])
        if index not in self._numbers:
            self.document.expand(8 * values.size)
            self._numbers[index] = dequantised(values, layout.normalized)
        return self._numbers[index]

    def indices(self, item: JsonObject, key: str) -> NDArray[Any]:
        """The unsigned integers (count,) of an accessor.

        Raises
        ------
        LoadError
            As `raw`, and for another component type.
        """
        layout, values = self.raw(item, key, "SCALAR")
        if layout.kind.kind != "u":
            raise layout.item.wrong(
                "componentType", f"one of {', '.join(map(str, INDEX_COMPONENTS))} for {item.where}.{key}"
            )
        return values[:, 0]

    def has_data(self, item: JsonObject, key: str) -> bool:
        """Whether an accessor has bytes of its own, rather than zeros or what a compression of its primitive brings."""
        accessor = self.document.accessors[item.index(key, len(self.document.accessors), "accessors")]
        return "bufferView" in accessor.value or "sparse" in accessor.value

    def _read(self, layout: Layout) -> NDArray[Any]:
        item, sparse = layout.item, layout.item.item("sparse")
        if "bufferView" in item.value:
            values = self._elements(item, layout.count, layout.width, layout.kind, strided=True)
        else:
            self.document.expand(layout.count * layout.element)
            values = np.zeros((layout.count, layout.width), layout.kind)
        return values if sparse is None else self._with_sparse(layout, values, sparse)

    def _with_sparse(self, layout: Layout, base: NDArray[Any], sparse: JsonObject) -> NDArray[Any]:
        count = sparse.whole("count", least=1)
        if count > layout.count:
            raise sparse.wrong("count", f"at most the {layout.count} elements of {layout.item.where}")
        indices, values = sparse.needed("indices"), sparse.needed("values")
        kind = indices.whole("componentType")
        if kind not in INDEX_COMPONENTS:
            raise indices.wrong("componentType", f"one of {', '.join(map(str, INDEX_COMPONENTS))}")
        rows = self._elements(indices, count, 1, np.dtype(COMPONENTS[kind]), strided=False)[:, 0]
        if int(rows.max()) >= layout.count:
            raise indices.broken(
                f"expected indices below the {layout.count} elements of {layout.item.where}, got {int(rows.max())}"
            )
        # A base without bytes is our own to write to.
        if "bufferView" in layout.item.value:
            self.document.expand(layout.count * layout.element)
            base = base.copy()
        base[rows] = self._elements(values, count, layout.width, layout.kind, strided=False)
        return base

    def _elements(
        self, item: JsonObject, count: int, width: int, kind: np.dtype[Any], *, strided: bool
    ) -> NDArray[Any]:
        """The elements in a buffer view that an object names, at its offset."""
        view = self.buffers.view(item.index("bufferView", len(self.document.views), "buffer views"))
        offset, element = item.whole("byteOffset", 0), width * kind.itemsize
        stride = checked_stride(item, view, element) if strided else element
        needed = offset + (count - 1) * stride + element if count else offset
        if needed > len(view.data):
            raise item.broken(
                f"expected {count:,} elements of {element} bytes, {stride} apart, from byte {offset:,} of its buffer "
                f"view, got one of {len(view.data):,} bytes"
            )
        found: NDArray[Any] = np.ndarray((count, width), kind, view.data, offset, (stride, kind.itemsize))
        return found


def checked_stride(item: JsonObject, view: ViewBytes, element: int) -> int:
    """The distance of elements in a view.

    Raises
    ------
    LoadError
        Where it is less than an element.
    """
    if view.stride and view.stride < element:
        raise item.broken(
            f"expected a buffer view whose byteStride is at least the {element} bytes of an element, got {view.stride}"
        )
    return view.stride or element


def dequantised(values: NDArray[Any], normalized: bool) -> NDArray[Any]:
    """Numbers from stored components (KHR_mesh_quantization): float32 stays, integers become float64."""
    if values.dtype.kind == "f":
        return values
    numbers = values.astype(np.float64)
    if normalized:
        numbers /= np.iinfo(values.dtype).max
        np.maximum(numbers, -1.0, out=numbers)
    return numbers
