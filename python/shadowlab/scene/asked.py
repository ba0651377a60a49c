"""Attributes of other programs' objects: whatever they raise when asked becomes one of our errors."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import ArgumentError, ShadowlabError


@contextmanager
def asking(what: str) -> Iterator[None]:
    """Turns whatever is raised inside into an `ArgumentError` of `source`, but for errors of ours.

    Parameters
    ----------
    what : str
        What is read from the object, for the message.
    """
    try:
        yield
    except ShadowlabError:
        raise
    except Exception as e:  # properties of other programs raise what they like
        raise ArgumentError(
            f"source: expected {what} that can be read, got {said(e)}; mend the object, or use Scene.from_arrays"
        ) from e


def said(error: Exception) -> str:
    """The name of an error with its message, if that can be had."""
    name = type(error).__name__
    try:
        text = str(error)
    except Exception:  # noqa: BLE001 - see above
        text = ""
    return f"{name}: {text[:200]}" if text else name
