"""The techniques of a sweep: what a row names, with the settings that it gives them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from ... import _core
from ...errors import ArgumentError, ShadowlabError
from ...techniques.kinds import is_parameterization
from ...techniques.labels import full_name_of, name_of, resolved
from ...techniques.registry import technique
from ...techniques.variant import READ_SETTINGS, Variant, variant
from ...text import bias_text, format_value, parse_spec, pieces, settings_text, shown
from ..store.row_text import of_64_bits
from ..views import apart
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


def labels_of(given: Iterable[Named]) -> dict[object, str]:
    """The names of techniques in tables, by `id_of` their values and the labels that they have; no two the same.

    Raises
    ------
    ArgumentError
        For something that is no technique.
    """
    found: dict[object, str] = {}
    values: dict[object, object] = {}
    for named in given:
        key: object = (id_of(named.value), named.label)
        if key not in found:
            text = shown(named.value) if isinstance(named.value, str) and not named.value.strip() else named.value
            found[key] = named.label or (text if isinstance(text, str) else name_of(resolved(text, "technique")))
            values[key] = named.value
    of_labels: dict[str, list[object]] = {}
    for key, label in found.items():
        of_labels.setdefault(label, []).append(key)
    for label, keys in of_labels.items():
        if len(keys) > 1:
            texts = [f"{label} ({text})" if text else label for text in settings_apart([values[key] for key in keys])]
            found |= dict(zip(keys, apart(texts), strict=True))
    return found


def settings_apart(values: Sequence[object]) -> list[str]:
    """The settings of techniques in which these differ, as texts; empty for texts, which say what they have."""
    settings = [settings_of(value) for value in values]
    differ = {
        name for one in settings for name in one if len({repr(other.get(name)) for other in settings if other}) > 1
    }
    return [
        "" if isinstance(value, str) else settings_text({name: one[name] for name in one if name in differ})
        for value, one in zip(values, settings, strict=True)
    ]


def settings_of(value: object) -> dict[str, object]:
    """The settings of a technique; none of a text that makes none."""
    try:
        return dict(getattr(resolved(value, "technique"), "settings", {}))
    except ShadowlabError:
        return {}


def id_of(value: object) -> tuple[str, object]:
    """What tells a value from others: itself where it has a hash, 1 and 1.0 and True apart; else the object."""
    # What callers give may raise anything: lists within one another, thousands deep, do.
    with contextlib.suppress(Exception):
        hash(value)
        return type(value).__name__, value
    with contextlib.suppress(Exception):
        if isinstance(value, (list, tuple)):
            return type(value).__name__, repr(value)
    return "", id(value)


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
        return of_64_bits(found) if isinstance(found, int) else found
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
        return bias_text(value)
    return name_of(cast("Item", value)) if hasattr(value, "name") else shown(value)
