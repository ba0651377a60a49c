"""The space of a sweep: which keys it has, and the rows that a dict of values or a list of rows comes to.

```
    {"scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near": [1, 2]}      the product: four rows
    [{"scene": "@robots", "technique": "uniform"}, ...]                                  rows as they are
```
A row is a dict of key to value here; `plan` makes views and techniques of the values, and drops the settings that a
technique does not have.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ... import _core
from ...errors import ArgumentError, UnknownNameError
from ...techniques.registry import ALL
from ...techniques.variant import READ_SETTINGS
from ...text import shown
from ...text.arrays import checked_items
from ...text.checked import a_text

#: The keys of a space beside the settings of techniques, in the order in which rows are sorted; first those of views,
#: of which a camera or a light may follow from the scene.
OF_SCENES = ("camera", "light")
OF_VIEWS = ("scene", *OF_SCENES)
KEYS = (*OF_VIEWS, "technique", "resolution", "memory", "bias", "filter", "stored", "blend")
#: Those whose values may have labels.
WITH_LABELS = (*OF_VIEWS, "technique")
#: Before the dot of a setting: all techniques that have it.
EVERY = "technique"
#: More than a table in memory is good for.
MOST_RUNS = 1_000_000
EXAMPLE_SPACE = 'try {"scene": "@robots", "technique": ["uniform", "lispsm"], "resolution": [512, 1024]}'
_LISTS = (list, tuple, range, set, frozenset)


@dataclass(frozen=True, eq=False)
class Named:
    """A value of a row as it was given, and its label if it has one."""

    value: object
    label: str | None = None


RawRow = dict[str, Named]


def raw_rows(space: object) -> list[RawRow]:
    """The rows of a space, each a value per key.

    Raises
    ------
    ArgumentError
        For a space of another kind, no rows, more than `MOST_RUNS`, or rows without a scene or a technique.
    UnknownNameError
        For a key that does not exist.
    """
    if isinstance(space, Mapping):
        rows = product_of(checked_row("space", space))
    else:
        given = checked_items("space", space, "a dict, or a list of them", EXAMPLE_SPACE)
        if len(given) > MOST_RUNS:
            raise too_many(len(given))
        rows = [single_row(f"space, row {i}", row) for i, row in enumerate(given)]
    if not rows:
        raise ArgumentError(f"space: expected at least one row, got none; {EXAMPLE_SPACE}")
    return rows


def product_of(space: Mapping[str, object]) -> list[RawRow]:
    """The rows of the full product, the first key's values outermost; errors as of `raw_rows`."""
    choices = {key: alternatives(key, space[key]) for key in sorted(space, key=rank_of)}
    for key, values in choices.items():
        if not values:
            fix = f"give one, as of {EXAMPLE_SPACE[4:]}" if key in ("scene", "technique") else "leave the key out"
            raise ArgumentError(f"space: expected at least one value for {key!r}, got none; {fix}")
    count = math.prod(map(len, choices.values()))
    if count > MOST_RUNS:
        raise too_many(count)
    return [dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values())]


def too_many(count: int) -> ArgumentError:
    """The error for a space of so many rows."""
    return ArgumentError(
        f"space: expected at most {MOST_RUNS:,} rows, got {count:,}; sl.random(space, n, seed) draws some of them"
    )


def rank_of(key: str) -> tuple[int, str]:
    """What keys are sorted by: views, techniques, their settings, and how maps are drawn and read."""
    return (KEYS.index(key) if key in KEYS else KEYS.index("technique"), "" if key in KEYS else key)


def keys_with(settings: Iterable[str]) -> list[str]:
    """All keys in their order, these settings of techniques among them."""
    return sorted([*KEYS, *settings], key=lambda key: rank_of(key)[0])


def checked_row(name: str, row: object) -> dict[str, object]:
    """A dict whose keys exist; errors as of `raw_rows`, `name` is what they call it."""
    if not isinstance(row, Mapping):
        raise ArgumentError(f"{name}: expected a dict of key to value, got {shown(row)}; {EXAMPLE_SPACE}")
    try:
        found = {key: row[key] for key in row}
    except Exception as error:  # noqa: BLE001 - mappings of callers may raise whatever they like
        raise ArgumentError(f"{name}: expected a dict of key to value, got one that raises ({error})") from None
    for key in found:
        check_key(name, key)
    if "scene" not in found:
        raise ArgumentError(f'{name}: expected a scene, got none; add "scene": "@robots", a file or a Scene')
    if "technique" not in found:
        raise ArgumentError(f'{name}: expected techniques, got none; add "technique": ["uniform", "lispsm"]')
    if "resolution" in found and "memory" in found:
        raise ArgumentError(f"{name}: expected resolution or memory, got both; the memory decides the resolution")
    return found


def check_key(name: str, key: object) -> None:
    """Raises unless it is a key of a space.

    Raises
    ------
    ArgumentError
        For something that is no text.
    UnknownNameError
        For a key, a technique or a setting that does not exist.
    """
    if not isinstance(key, str):
        raise ArgumentError(f"{name}: expected texts as keys, got {shown(key)}; {EXAMPLE_SPACE}")
    if key in KEYS:
        return
    owner, dot, setting = key.rpartition(".")
    if not dot:
        listed = ", ".join(KEYS)
        raise UnknownNameError(f"{name}: unknown key {shown(key)}; expected one of {listed}, or technique.setting")
    has = settings_after(owner)
    if has is None:
        listed = ", ".join(settings_of_techniques())
        raise UnknownNameError(
            f"{name}: unknown technique {shown(owner)} in the key {shown(key)}; expected one of {listed}, "
            f"or {EVERY!r} for all"
        )
    if setting not in has:
        raise UnknownNameError(
            f"{name}: unknown setting {shown(setting)} in the key {shown(key)}; expected one of {', '.join(has)}"
        )


@functools.cache
def settings_of_techniques() -> dict[str, tuple[str, ...]]:
    """The settings of each technique, those of reading its maps among them."""
    own = {spec["name"]: tuple(p["name"] for p in spec["params"]) for spec in _core.technique_specs()}
    return {name: (*params, *READ_SETTINGS) for name, params in own.items()}


def settings_after(owner: str) -> tuple[str, ...] | None:
    """The settings that may stand after this and a dot; None after the name of a technique that does not exist."""
    if owner.startswith("preset:"):
        return READ_SETTINGS
    known = settings_of_techniques()
    if owner == EVERY:
        return tuple(dict.fromkeys(itertools.chain.from_iterable(known.values())))
    return known.get(owner)


@functools.cache
def settings_keys() -> frozenset[str]:
    """All keys of settings, engines' presets aside."""
    owners = (*settings_of_techniques(), EVERY)
    return frozenset(f"{owner}.{name}" for owner in owners for name in settings_after(owner) or ())


def alternatives(key: str, value: object) -> list[Named]:
    """The values of a key: one, several, or several by their labels.

    Raises
    ------
    ArgumentError
        For labels where a key takes none, and for lists that cannot be gone through.
    """
    if isinstance(value, Mapping):
        return list(labelled_values(key, value))
    if key == "light" and is_direction(value):
        return [Named(value)]
    found = [Named(one) for one in items_in(key, value)]
    if key == "technique":
        names = [spec["name"] for spec in _core.technique_specs()]
        every = [[Named(name) for name in names] if isinstance(one.value, str) and one.value == ALL else [one]
                 for one in found]  # fmt: skip
        return list(itertools.chain.from_iterable(every))
    return found


def items_in(key: str, value: object) -> list[object]:
    """The items of a list, an array or a series; else the value itself as the only one."""
    if isinstance(value, np.ndarray):
        return value.tolist() if value.ndim == 1 else [value]
    series = type(value).__module__.partition(".")[0] == "pandas"
    if isinstance(value, (*_LISTS, Iterator)) or series:
        return checked_items(key, value, "a value, or several", EXAMPLE_SPACE)
    return [value]


def is_direction(value: object) -> bool:
    """Whether it is three numbers, which are one light and not three."""
    listed = value.tolist() if isinstance(value, np.ndarray) else value
    return (
        isinstance(listed, (list, tuple))
        and len(listed) == 3
        and all(isinstance(one, (int, float, np.number)) and not isinstance(one, bool) for one in listed)
    )


def single_row(name: str, row: object) -> RawRow:
    """The values of a row that is given as it is, in the order of the keys."""
    given = checked_row(name, row)
    return {key: single(name, key, given[key]) for key in sorted(given, key=rank_of)}


def single(name: str, key: str, value: object) -> Named:
    """The one value of a key in a row; a dict of one label gives it a name."""
    if not isinstance(value, Mapping):
        if isinstance(value, (list, set, frozenset, range)) and key in ("scene", "technique", "resolution", "memory"):
            raise ArgumentError(
                f"{name}: expected one value for {key!r}, got {shown(value)}; give a row to each, or one dict "
                "instead of the list for their full product"
            )
        return Named(value)
    found = list(labelled_values(key, value))
    if len(found) != 1:
        raise ArgumentError(f"{name}: expected one value for {key!r}, got {len(found)}; give a row to each")
    return found[0]


def labelled_values(key: str, value: Mapping[object, object]) -> Iterator[Named]:
    """The values of a dict of label to value."""
    if key not in WITH_LABELS:
        hint = "sl.random draws from {'min': ..., 'max': ...}" if "min" in value else "give a list of values"
        raise ArgumentError(f"space: expected values without labels for {key!r}, got a dict; {hint}")
    for label, one in value.items():
        if not isinstance(label, str) or not label.strip():
            raise ArgumentError(f"space: expected labels with letters for {key!r}, got {shown(label)}; name it")
        a_text(f"space: label of {key!r}", label)
        yield Named(one, label)


def one_for_each(scenes: Iterable[object], values: Iterable[object]) -> bool:
    """Whether each scene has one value: what a row has then follows from its scene."""
    pairs = set(zip(scenes, values, strict=True))
    return len({scene for scene, _ in pairs}) == len(pairs)
