"""The nearest valid name for one that is misspelt."""

from __future__ import annotations

from collections.abc import Iterable

# Of 1 for the same word: what a slip of two letters in a word of six leaves.
ALIKE = 0.6


def nearest_name(name: str, names: Iterable[str]) -> str | None:
    """The name that is most like this one; None where none is like it."""
    from difflib import get_close_matches

    found = get_close_matches(name, list(names), 1, ALIKE)
    return found[0] if found else None


def nearest_text(name: str, names: Iterable[str]) -> str:
    """What to write for a name that does not exist: the nearest one, and all that there are."""
    known = list(names)
    near = nearest_name(name, known)
    listed = f"expected one of {', '.join(known)}"
    return listed if near is None else f"did you mean {near!r}? {listed}"
