"""The techniques of a sweep: what a row names, with the settings that it gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from ... import _core
from ...errors import ArgumentError
from ...techniques.kinds import is_parameterization
from ...techniques.labels import full_name_of, name_of, resolved
from ...techniques.registry import technique
from ...techniques.variant import READ_SETTINGS, Variant, variant
from ...text import format_value, parse_spec, pieces, shown
from .space import EVERY, KEYS, Named, RawRow, settings_of_techniques

if TYPE_CHECKING:
    from ...types import Item, TechniqueLike

#: What stands for a setting in a table: plain values as they are, others as their texts.
SettingCell = bool | int | float | str


def owner_of(named: Named) -> str:
    """The technique that settings are given for: its name, "preset:NAME" of an engine's.

    Raises
    ------
    ArgumentError
        For something that is no technique, and a text that does not read.
    """
    if not isinstance(named.value, str):
        return full_name_of(resolved(named.value, "technique"))
    text = named.value.strip()
    if text.partition(":")[0] == "preset":
        return f"preset:{(pieces(text.partition(':')[2], ',') or [''])[0]}"
    return parse_spec(text, "technique")[0]


def label_of(named: Named) -> str:
    """Its name in tables."""
    if named.label is not None:
        return named.label
    return named.value if isinstance(named.value, str) else name_of(resolved(named.value, "technique"))


def settings_in(row: RawRow, owner: str) -> tuple[dict[str, object], list[str]]:
    """The settings by name that a technique gets from a row, and the keys that are not for it."""
    own = settings_of_techniques().get(owner, READ_SETTINGS)
    settings: dict[str, object] = {}
    dropped = []
    for key, named in row.items():
        if key in KEYS:
            continue
        of, _, name = key.rpartition(".")
        if of not in (owner, EVERY) or name not in own:
            dropped.append(key)
        elif name in settings:
            raise ArgumentError(f"space: {owner}.{name} and {EVERY}.{name} both give {name}; remove one")
        else:
            settings[name] = named.value
    return settings, dropped


def check_given_once(named: Named, settings: Mapping[str, object]) -> None:
    """Raises where the text of a technique has a setting that the row gives, too.

    Raises
    ------
    ArgumentError
    """
    if isinstance(named.value, str) and settings and not named.value.startswith("preset:"):
        name, given = parse_spec(named.value, "technique")
        for twice in given.keys() & settings.keys():
            raise ArgumentError(
                f"space: technique {shown(named.value)} has {twice}, and so has the key {name}.{twice}; remove one"
            )


def item_of(named: Named, settings: Mapping[str, Any]) -> Item:
    """The technique of a row.

    Raises
    ------
    ArgumentError, UnknownNameError, LoadError
        As `sl.technique`.
    """
    if isinstance(named.value, str):
        return technique(named.value, **settings)
    item = resolved(named.value, "technique")
    if not settings:
        return item
    return with_settings(item, settings)


def with_settings(item: Item, settings: Mapping[str, Any]) -> Item:
    """A technique with other settings, the rest as it is."""
    read = {name: value for name, value in settings.items() if name in READ_SETTINGS}
    own = {name: value for name, value in settings.items() if name not in READ_SETTINGS}
    if isinstance(item, Variant):
        again = variant(item.technique, read)
        kept = again if isinstance(again, Variant) else Variant(item.technique)
        inner = cast("TechniqueLike", with_settings(item.technique, own))
        parts = {name: getattr(kept, name) if name in read else getattr(item, name) for name in READ_SETTINGS}
        return replace(kept, technique=inner, **parts)
    if own and isinstance(item, _core.Technique):
        item = _core.Technique(item.name, **{**item.settings, **own})
    elif own:
        raise ArgumentError(f"space: {name_of(item)} takes no settings, got {', '.join(own)}; remove them")
    if read and is_parameterization(item):
        raise ArgumentError(f"space: matrices take no settings, got {', '.join(read)}; remove them")
    return variant(item, read)


def cell_of(value: object) -> SettingCell:
    """What a table shows of the value of a setting; of one that cannot be written out, what errors show."""
    try:
        found = _cell_of(value)
        # What a column of whole numbers holds, and a store.
        return float(found) if isinstance(found, int) and not -(2**63) <= found < 2**63 else found
    except Exception:  # noqa: BLE001 - what callers give may raise whatever it likes
        return shown(value)


def _cell_of(value: object) -> SettingCell:
    if hasattr(value, "item") and hasattr(value, "dtype") and getattr(value, "ndim", None) == 0:
        value = cast("Any", value).item()
    if isinstance(value, (bool, int, float, str)):
        return value
    if hasattr(value, "tolist"):
        value = cast("Any", value).tolist()
    if isinstance(value, (list, tuple)):
        return format_value(tuple(cell_of(one) for one in value))
    if isinstance(value, _core.Stored):
        return str(value)
    if isinstance(value, _core.Bias):
        from ...text import bias_text

        return bias_text(value)
    return name_of(cast("Item", value)) if hasattr(value, "name") else shown(value)
