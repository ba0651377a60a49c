"""The techniques by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from . import _core
from .errors import ArgumentError
from .specs import parse_spec

# The text that stands for every technique with its defaults.
ALL = "all"

if TYPE_CHECKING:
    import pandas as pd


def technique(name: str, **params: Any) -> _core.Technique:
    """The technique of that name with its parameters.

    Parameters
    ----------
    name : str
        As `techniques()` lists it; "lispsm:near=optimal" brings parameters with it.
    **params
        As `techniques()` lists them. A list of numbers is a tuple, list or array; techniques within a technique are
        their names, texts, objects, or a list of these.

    Raises
    ------
    UnknownNameError
        No such technique or parameter; the message lists the valid ones.
    ArgumentError
        A value outside its range.
    """
    if isinstance(name, str) and ":" in name:
        text = name
        name, given = parse_spec(text, "technique")
        for twice in given.keys() & params.keys():
            raise ArgumentError(f"technique {text!r}: {twice} is given twice; give it once")
        params = {**given, **params}
    return _core.Technique(name, **params)


def technique_of(text: str) -> Any:
    """What a text names: the technique of `name:param=value,...`, an engine's of `preset:NAME`, a file's matrices.

    Raises
    ------
    UnknownNameError, ArgumentError
        As `technique`.
    LoadError
        For a file of matrices that cannot be read.
    """
    kind, _, rest = text.strip().partition(":")
    if kind == "preset":
        from .engines import preset

        return preset(rest.strip())
    name, params = parse_spec(text, "technique")
    if name == "matrix":
        from .matrix_files import matrix_technique

        return matrix_technique(text, params)
    return technique(name, **params)


def with_all(items: Iterable[Any]) -> list[Any]:
    """The items, the text "all" replaced by the names of all techniques."""
    names = [spec["name"] for spec in _core.technique_specs()]
    return [one for item in items for one in (names if isinstance(item, str) and item == ALL else [item])]


def techniques() -> pd.DataFrame:
    """One row a parameter of a technique: name, title, source, lights, parameter, unit, default, range, doc."""
    import pandas as pd

    columns = ["name", "title", "source", "lights", "parameter", "unit", "default", "range", "doc"]
    rows = []
    for spec in _core.technique_specs():
        head = {k: spec[k] for k in ("name", "title", "source")} | {"lights": ", ".join(spec["lights"])}
        for p in spec["params"] or [dict.fromkeys(("name", "unit", "default", "range", "doc"), "")]:
            rows.append(head | {"parameter": p["name"]} | {k: p[k] for k in ("unit", "default", "range", "doc")})
    return pd.DataFrame(rows, columns=columns)
