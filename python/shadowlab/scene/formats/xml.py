"""XML of files that nobody vouches for: no document types, thus no entities of their own, and no references."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from .limits import Limits, check_limit
from .words import plain_numbers, readable


def parsed_xml(name: str, data: bytes, limits: Limits) -> Any:
    """The root element of a document.

    Raises
    ------
    LoadError
        For what is no XML, for a document type (entities are declared there), for elements nested too deep, and for
        more of them than the limits allow.
    """
    from lxml import etree

    # In UTF-16 every second byte is 0.
    bare = data.replace(b"\0", b"") if b"\0" in data else data
    if b"<!DOCTYPE" in bare or b"<!ENTITY" in bare:
        raise _document_type(name)
    # Vertices and triangles of 3MF are its arrays of numbers.
    count = bare.count(b"<") - sum(map(bare.count, (b"</", b"<vertex ", b"<triangle ")))
    check_limit(limits, name, "objects", count, "elements of XML")
    # Huge trees, since arrays of numbers may be long; libxml2 still refuses more than 2,048 levels of elements.
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=True,
        remove_comments=True, remove_pis=True,
    )  # fmt: skip
    try:
        # Blank lines before the declaration are a common slip.
        root = etree.fromstring(data.lstrip(), parser)
    except (etree.XMLSyntaxError, ValueError) as e:
        raise LoadError(f"{name}: expected well-formed XML, could not read it ({e}); check the file") from e
    if root.getroottree().docinfo.doctype:
        raise _document_type(name)  # in an encoding of other letters
    return root


def _document_type(name: str) -> LoadError:
    return LoadError(f"{name}: expected XML without a document type, got one; entities are not expanded: remove it")


def local(element: Any) -> str:
    """The name of an element without its namespace."""
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


def children(element: Any, *names: str) -> list[Any]:
    """The elements directly in another that have one of these names."""
    return list(element.iterchildren(*[f"{{*}}{name}" for name in names]))


def child(element: Any, name: str) -> Any:
    """The first element of a name directly in another, or None."""
    return next(element.iterchildren(f"{{*}}{name}"), None)


def floats(name: str, text: str | None, what: str, count: int | None = None) -> NDArray[np.float64]:
    """The numbers of an element or attribute.

    Raises
    ------
    LoadError
        For a word that is no number, or another count of them.
    """
    found = plain_numbers((text or "").encode())
    words = len((text or "").split())
    if len(found) != words or (count is not None and words != count):
        wanted = "numbers" if count is None else f"{count} numbers"
        raise LoadError(f"{name}: expected {wanted} for {what}, got {readable((text or '').encode())}; check the file")
    return found


def integers(name: str, text: str | None, what: str) -> NDArray[np.int64]:
    """The whole numbers of an element; see `floats`."""
    found = plain_numbers((text or "").encode(), np.int64)
    if len(found) != len((text or "").split()):
        raise LoadError(
            f"{name}: expected whole numbers for {what}, got {readable((text or '').encode())}; check the file"
        )
    return np.asarray(found)
