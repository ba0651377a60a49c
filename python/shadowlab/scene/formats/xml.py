"""XML of files that nobody vouches for: no document types, thus no entities of their own, and no references."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from .words import numbers, readable

#: Levels of elements within elements; libxml2's own bound.
_DEEPEST = 256


def parsed(name: str, data: bytes) -> Any:
    """The root element of a document.

    Raises
    ------
    LoadError
        For what is no XML, for a document type (entities are declared there), and for elements nested too deep.
    """
    from lxml import etree

    # In UTF-16 every second byte is 0.
    bare = data.replace(b"\0", b"") if b"\0" in data else data
    if re.search(rb"<!DOCTYPE|<!ENTITY", bare):
        raise _document_type(name)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=True,
        remove_comments=True, remove_pis=True,
    )  # fmt: skip
    if _depth(bare) > _DEEPEST:
        raise LoadError(f"{name}: expected at most {_DEEPEST} levels of elements, got more; check the file")
    try:
        root = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError) as e:
        raise LoadError(f"{name}: expected well-formed XML, could not read it ({e}); check the file") from e
    if root.getroottree().docinfo.doctype:
        raise _document_type(name)  # in an encoding of other letters
    return root


def _document_type(name: str) -> LoadError:
    return LoadError(f"{name}: expected XML without a document type, got one; entities are not expanded: remove it")


def _depth(data: bytes) -> int:
    """At least how deep elements are nested, by counting tags."""
    raw = np.frombuffer(data, np.uint8)
    opens = np.flatnonzero(raw == ord("<"))
    if not len(opens):
        return 0
    after = raw[np.minimum(opens + 1, len(raw) - 1)]
    closes = np.flatnonzero(raw == ord(">"))
    empty = raw[np.maximum(closes - 1, 0)] == ord("/")
    steps = np.where(after == ord("/"), -1, np.where((after == ord("!")) | (after == ord("?")), 0, 1))
    places = np.concatenate([opens, closes[empty]])
    change = np.concatenate([steps, np.full(int(empty.sum()), -1)])
    return int(np.cumsum(change[np.argsort(places, kind="stable")]).max(initial=0))


def local(element: Any) -> str:
    """The name of an element without its namespace."""
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


def children(element: Any, *names: str) -> list[Any]:
    """The elements directly in another that have one of these names."""
    return [child for child in element if local(child) in names]


def child(element: Any, name: str) -> Any:
    """The first element of a name directly in another, or None."""
    return next((one for one in element if local(one) == name), None)


def floats(name: str, text: str | None, what: str, count: int | None = None) -> NDArray[np.float64]:
    """The numbers of an element or attribute.

    Raises
    ------
    LoadError
        For a word that is no number, or another count of them.
    """
    found = numbers((text or "").encode())
    words = len((text or "").split())
    if len(found) != words or (count is not None and words != count):
        wanted = "numbers" if count is None else f"{count} numbers"
        raise LoadError(f"{name}: expected {wanted} for {what}, got {readable((text or '').encode())}; check the file")
    return found


def integers(name: str, text: str | None, what: str) -> NDArray[np.int64]:
    """The whole numbers of an element; see `floats`."""
    found = numbers((text or "").encode(), np.int64)
    if len(found) != len((text or "").split()):
        raise LoadError(
            f"{name}: expected whole numbers for {what}, got {readable((text or '').encode())}; check the file"
        )
    return np.asarray(found)
