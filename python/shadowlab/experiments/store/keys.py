"""Keys of runs: digests of everything that a row depends on, the same in every process and on every machine.

Names are no part of a key: a row whose view, technique or scene only has another name is found again. Whoever puts kept
rows into a table of its own gives it the names that it has there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ... import _core
from ...errors import ArgumentError
from ...scene.view import View, checked_view
from ...techniques.kinds import is_parameterization
from ...techniques.labels import full_name_of, resolved
from ...techniques.variant import reading
from ...text import shown
from ...text.arrays import checked_items
from ...text.checked import a_flag, a_text
from ...text.checks import check_bias, check_filter, checked_blend, checked_stored, whole
from ...travel import Value, checksum
from ...types import Filter, Item
from ..phases import checked_phases

#: Version of all that makes the numbers of a row: techniques, fits, renderers, lookups, truth and metrics. Raised with
#: every change that gives another number for the same run; rows of other versions are then made anew. CONTRIBUTING.md
#: says when, and a test holds the numbers of all techniques against those of this version.
ALGORITHMS = 1
OF_METRICS = ("names of metrics", "try ['misclassified']")
#: Within one another, lists of what a key is made of.
DEEPEST = 32


def run_key(
    view: View,
    item: Item,
    *,
    resolution: int,
    metrics: Sequence[str],
    bias: _core.Bias | None,
    filter: Filter,
    blend: float,
    stored: _core.Stored | str | None,
    backend: str,
    phases: int = 1,
    timing: bool = False,
) -> str:
    """The key of a run: what `evaluate` would measure with these arguments.

    Parameters
    ----------
    view : View
        Its scene counts by `Scene.content_hash`; its label does not count.
    item : Technique, Preset or Parameterization
        A technique counts by its name and all settings, matrices by their bits. Of a class from elsewhere the name of
        the class counts, but not its code: give it a setting that changes with the code.
    resolution, bias, filter, blend, stored, phases, timing
        As of `evaluate`.
    metrics : sequence of str
        As of `evaluate`, in any order; others stand for functions of the caller, with what changes when they do.
    backend : str
        What drew it: "cpu", or a device with its adapter.

    Returns
    -------
    str
        32 hexadecimal digits.

    Raises
    ------
    ArgumentError
        For arguments that `evaluate` refuses, and settings that are no plain values.
    UnknownNameError
        For a technique, filter or part of `stored` that does not exist.

    Examples
    --------
    >>> import shadowlab as sl
    >>> from shadowlab.experiments.store.keys import run_key
    >>> scene = sl.library.scene("robots")
    >>> how = dict(resolution=256, metrics=["misclassified"], bias=None, filter="nearest", blend=0.0, stored=None)
    >>> views = [sl.View(scene, scene.camera, scene.light, label=label) for label in ("noon", "twelve")]
    >>> one, other = [run_key(view, sl.technique("lispsm"), **how, backend="cpu") for view in views]
    >>> one == other, len(one)
    (True, 32)
    """
    seen, made_by = checked_view(view), resolved(item, "item")
    check_bias(bias)
    check_filter(filter)
    read = reading(made_by, bias, filter, checked_blend(blend), checked_stored(stored))
    pixels = (seen.scene.content_hash, seen.camera, seen.light, seen.size)
    names = sorted({a_text("metrics", name) for name in checked_items("metrics", metrics, *OF_METRICS)})
    counted = (whole("resolution", resolution), names, checked_phases(phases))
    return key_of_parts(
        *pixels, technique_parts(made_by), *counted, tuple(read), a_text("backend", backend), a_flag("timing", timing)
    )


def technique_parts(item: Item) -> tuple[object, ...]:
    """What the rows of a technique depend on: matrices by their bits, others by name, settings and foreign class."""
    if is_parameterization(item):
        return ("matrices", item)
    kind = type(item)
    own = kind.__module__.partition(".")[0] == __name__.partition(".")[0]
    return (full_name_of(item), dict(item.settings), "" if own else f"{kind.__module__}.{kind.__qualname__}")


def key_of_parts(*parts: object) -> str:
    """The digest of values by their content, and of the version of the algorithms; 32 hexadecimal digits.

    Raises
    ------
    ArgumentError
        For values that are neither plain nor of this package.
    """
    return checksum(_plain((ALGORITHMS, *parts), 0)).hex()


def _plain(value: object, depth: int) -> Any:
    """The value as what `checksum` reads whole: mappings sorted by name, values of this package by their fields."""
    if depth > DEEPEST:
        raise ArgumentError(f"item: expected settings at most {DEEPEST} deep, got deeper ones; give plain values")
    if value is None or isinstance(value, (bool, int, float, str, bytes)):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value
    if isinstance(value, (tuple, list)):
        return tuple(_plain(one, depth + 1) for one in value)
    if isinstance(value, Mapping):
        return tuple(sorted((str(name), _plain(one, depth + 1)) for name, one in value.items()))
    if isinstance(value, Value):
        cls, version, state, _ = value.__reduce__()[1]
        return (cls.__name__, version, _plain(state, depth + 1))
    try:
        reduced = value.__reduce__()
    except Exception:  # noqa: BLE001 - objects of callers may raise whatever they like
        reduced = ""
    if isinstance(reduced, tuple) and reduced[0] is _core.restore:
        return tuple(reduced[1])
    raise ArgumentError(f"item: expected settings that are plain values, got {shown(value)}; give numbers and texts")
