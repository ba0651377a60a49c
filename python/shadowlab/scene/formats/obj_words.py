"""Statements of Wavefront OBJ files by the words that they begin with.

Source: Wavefront, Advanced Visualizer manual, appendix B1, "Object files (.obj)", version 3.0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .words import Bytes

#: Kinds of lines; those below `KEPT_KINDS` are kept.
VERTEX, VERTEX_TEXTURE, VERTEX_NORMAL, FACE, MATERIAL, LIBRARY, BARE = range(7)
KEPT_KINDS = BARE + 1
BLANK, STROKE, FREE_FORM, SILENT, UNKNOWN = range(KEPT_KINDS, KEPT_KINDS + 5)

#: Words by the kind of their lines.
_STATEMENTS = {
    STROKE: b"l p",
    FREE_FORM: b"curv curv2 surf bzp bsp cdc cdp",
    MATERIAL: b"usemtl",
    LIBRARY: b"mtllib",
    # Statements that need numbers, and have none: those with numbers are known by the blank after the word.
    BARE: b"v vt vn f",
    SILENT: b"o g s mg usemap maplib bevel c_interp d_interp lod shadow_obj trace_obj vp deg cstype bmat step ctech "
    b"stech parm trim hole scrv sp end con res csh call",
}
#: Letters of a word that are looked at: as many as the longest one has, and one more.
_LOOKED_AT = 12
_KNOWN = {word: kind for kind, words in _STATEMENTS.items() for word in words.split()}


def kinds_of(raw: Bytes, first: NDArray[np.int64]) -> NDArray[np.int8]:
    """The kinds of lines.

    Parameters
    ----------
    raw : (N,) uint8
        The text, which ends in a newline.
    first : (L,) int64
        The first letter of each line.
    """
    last = len(raw) - 1
    a, b, c = raw[first], raw[np.minimum(first + 1, last)], raw[np.minimum(first + 2, last)]
    gap_b, gap_c = (b == 32) | (b == 9), (c == 32) | (c == 9)
    kinds = np.full(len(first), UNKNOWN, np.int8)
    kinds[a == 10] = BLANK
    v = a == ord("v")
    kinds[v & gap_b] = VERTEX
    kinds[v & (b == ord("t")) & gap_c] = VERTEX_TEXTURE
    kinds[v & (b == ord("n")) & gap_c] = VERTEX_NORMAL
    kinds[(a == ord("f")) & gap_b] = FACE
    others = np.flatnonzero(kinds == UNKNOWN)
    if len(others):
        kinds[others] = _by_word(raw, first[others])
    return kinds


def _by_word(raw: Bytes, first: NDArray[np.int64]) -> NDArray[np.int8]:
    """The kinds of lines by all letters of their first word."""
    letters = raw[np.minimum(first[:, None] + np.arange(_LOOKED_AT), len(raw) - 1)]
    letters[np.logical_or.accumulate((letters == 32) | ((letters > 8) & (letters < 14)), axis=1)] = 0
    # A word is two numbers, of eight letters and of four.
    head, tail = letters[:, :8].copy().view("<u8")[:, 0], letters[:, 8:].copy().view("<u4")[:, 0]
    kinds = np.full(len(first), UNKNOWN, np.int8)
    for word, kind in _KNOWN.items():
        padded = word.ljust(_LOOKED_AT, b"\0")
        same = head == int.from_bytes(padded[:8], "little")
        if same.any():
            same &= tail == int.from_bytes(padded[8:], "little")
            kinds[same] = kind
    return kinds
