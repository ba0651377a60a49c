"""The techniques by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _core

if TYPE_CHECKING:
    import pandas as pd


def technique(name: str, **params: Any) -> _core.Technique:
    """The technique of that name with its parameters.

    Parameters
    ----------
    name : str
        As `techniques()` lists it.
    **params
        As `techniques()` lists them.

    Raises
    ------
    UnknownNameError
        No such technique or parameter; the message lists the valid ones.
    ArgumentError
        A value outside its range.
    """
    return _core.Technique(name, **params)


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
