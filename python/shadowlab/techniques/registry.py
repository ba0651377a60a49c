"""The techniques by name."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast, overload

from .. import _core
from ..errors import ArgumentError, ShadowlabWarning
from ..text import parse_spec, pieces, shown
from .kinds import is_parameterization, makes_maps
from .variant import READ_SETTINGS, variant

# The text that stands for every technique with its defaults.
ALL = "all"

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from ..types import ConventionLike, Item, Light, Setting, TechniqueArgument, TechniqueLike

T = TypeVar("T", bound="Item")
A = TypeVar("A", bound="TechniqueArgument")


@overload
def technique(name: T) -> T: ...
@overload
def technique(  # type: ignore[overload-overlap]  # the one text of which the kind is known
    name: Literal["matrix"],
    *,
    file: str | os.PathLike[str],
    convention: ConventionLike | str | None = None,
    resolution: int = 1024,
    eye_depth: npt.ArrayLike | None = None,
    selection: Literal["depth", "containment"] = "depth",
) -> _core.Parameterization: ...
@overload
def technique(name: str, **params: Setting) -> TechniqueLike: ...
def technique(name: Item | str, **params: object) -> Item:
    """The technique of that name with its parameters.

    Parameters
    ----------
    name : str
        As `techniques()` lists it; "lispsm:near=optimal" brings parameters with it. "preset:NAME" is what an engine
        ships, as `presets()` lists it, and "matrix:file=F,convention=C" the parameterization in that file. A technique,
        preset or parameterization is itself.
    **params
        As `techniques()` lists them. A list of numbers is a tuple, list or array; techniques within a technique are
        their names, texts, objects, or a list of these. `bias`, `filter`, `mix` and `stored`, with every technique and
        preset, say what its maps store and how they are read, before what an experiment says for all:
        "lispsm:bias=(slope=1,texels=0.5),filter=pcf:size=3,stored=(back:spacing=linear,format=unorm16)". `mix` is what
        experiments call `blend`: "z_partition:count=3,overlap=0.2,mix=0.2".

    Raises
    ------
    UnknownNameError
        No such technique or parameter; the message lists the valid ones.
    ArgumentError
        A value outside its range; parameters of what has none.
    LoadError
        For a file of matrices that cannot be read.
    """
    if not isinstance(name, str):
        if is_parameterization(name) or makes_maps(name):
            own, read = read_apart(params)
            return variant(without(own, repr(name), name), read)
        raise ArgumentError(
            f'name: expected the name of a technique such as "lispsm", or one, got {shown(name)}; see sl.techniques()'
        )
    text = name.strip()
    kind, _, rest = text.partition(":")
    if kind == "preset":
        from .presets import preset

        shipped, *more = pieces(rest, ",") or [rest.strip()]
        given = parse_spec(f"preset:{','.join(more)}", "preset")[1] if more else {}
        own, read = read_apart(with_beside(text, given, params))
        return variant(without(own, text, preset(shipped)), read)
    name, given = parse_spec(text, "technique")
    own, read = read_apart(with_beside(text, given, params))
    if name == "matrix":
        from ..conventions.files import matrix_technique

        return variant(matrix_technique(text, own), read)
    return variant(_core.Technique(name, **cast("dict[str, Any]", with_new_words(name, own))), read)


def with_beside(text: str, given: Mapping[str, object], params: Mapping[str, object]) -> dict[str, object]:
    """The parameters of a text and those beside it."""
    for twice in given.keys() & params.keys():
        raise ArgumentError(f"technique {shown(text)}: {twice} is given twice; give it once")
    return {**given, **params}


def read_apart(params: Mapping[str, object]) -> tuple[dict[str, object], dict[str, object]]:
    """The parameters of a technique, and those of reading its maps."""
    read = {name: value for name, value in params.items() if name in READ_SETTINGS}
    return {name: value for name, value in params.items() if name not in READ_SETTINGS}, read


def with_new_words(name: str, params: Mapping[str, object]) -> dict[str, object]:
    """The parameters; a word that was renamed is replaced, with a warning."""
    found = dict(params)
    for technique, param, old, new in _core.renamed_words():
        if technique == name and isinstance(found.get(param), str) and found.get(param) == old:
            found[param] = new
            warnings.warn(
                f"technique {name!r}: {param}={old} is called {param}={new} now; write that",
                ShadowlabWarning,
                stacklevel=3,
            )
    return found


def without(params: Mapping[str, object], what: str, made: T) -> T:
    """What was made, unless it was to have parameters."""
    if params:
        raise ArgumentError(f"technique {shown(what)}: expected no parameters, got {', '.join(params)}; remove them")
    return made


def technique_of(text: str) -> Item:
    """What a text names: the technique of `name:param=value,...`, an engine's of `preset:NAME`, a file's matrices.

    Raises
    ------
    UnknownNameError, ArgumentError, LoadError
        As `technique`.
    """
    return technique(text)


def with_all(items: Iterable[A], light: Light | None = None) -> list[A | str]:
    """The items, the text "all" replaced by the names of all techniques that serve the light, if one is given.

    A name beside "all" is there once, and stays where it serves no such light. Warns of what is left out.
    """
    items = list(items)
    if not any(isinstance(item, str) and item == ALL for item in items):
        return [*items]
    specs = _core.technique_specs()
    kind = None if light is None else light.kind
    left_out = [s["name"] for s in specs if kind is not None and kind not in s["lights"] and s["name"] not in items]
    if left_out:
        warnings.warn(f"left out, they serve no {kind} light: {', '.join(left_out)}", ShadowlabWarning, stacklevel=4)
    names = [s["name"] for s in specs if s["name"] not in left_out]
    found: list[A | str] = []
    for item in items:
        for one in names if isinstance(item, str) and item == ALL else [item]:
            if not (isinstance(one, str) and one in names and one in found):
                found.append(one)
    return found


def techniques() -> pd.DataFrame:
    """One row a parameter of a technique: name, title, source, lights, parameter, unit, default, range, doc."""
    import pandas as pd

    columns = ["name", "title", "source", "lights", "parameter", "unit", "default", "range", "doc"]
    return pd.DataFrame(parameter_rows(), columns=columns)


def parameter_rows() -> list[dict[str, str]]:
    """The rows of `techniques` as dicts, made without pandas."""
    rows = []
    for spec in _core.technique_specs():
        head = {k: spec[k] for k in ("name", "title", "source")} | {"lights": ", ".join(spec["lights"])}
        for p in spec["params"] or [dict.fromkeys(("name", "unit", "default", "range", "doc"), "")]:
            rows.append(head | {"parameter": p["name"]} | {k: p[k] for k in ("unit", "default", "range", "doc")})
    return rows
