"""What stands for a technique in arguments: names, objects, matrices and dicts of them, each with its label."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

from ..errors import ArgumentError, ShadowlabError
from ..text import format_spec, settings_text
from ..text.arrays import checked_items
from ..text.checked import a_text
from .kinds import is_parameterization, makes_maps

if TYPE_CHECKING:
    from ..types import Item, Light, TechniqueArgument, Techniques


def labelled(techniques: Techniques | None, light: Light | None = None) -> list[tuple[str, Item]]:
    """(label, Technique or Parameterization) of all entries, in order; "all" is all that serve the light.

    Raises
    ------
    ArgumentError
        For nothing, two entries under one label, or something that is no technique.
    """
    if isinstance(techniques, str) or is_parameterization(techniques) or makes_maps(techniques):
        techniques = [cast("TechniqueArgument", techniques)]
    expected, fix = "names, Technique or Parameterization objects", 'try ["uniform", "lispsm"]'
    if isinstance(techniques, Mapping):
        entries = [(a_text("techniques", label), resolved(item)) for label, item in techniques.items()]
    else:
        from .registry import with_all

        items = with_all(checked_items("techniques", techniques, expected, fix), light)
        named = [(item if isinstance(item, str) else None, resolved(item)) for item in items]
        names = [name_of(item) for _, item in named]
        entries = [
            (text or (name if names.count(name) == 1 else f"{name} ({settings_text(item.settings)})"), item)
            for (text, item), name in zip(named, names, strict=True)
        ]
    if not entries:
        raise ArgumentError('techniques: expected at least one, got none; try ["uniform", "lispsm"]')
    labels = [label for label, _ in entries]
    for label in labels:
        if labels.count(label) > 1:
            raise ArgumentError(
                f"techniques: {label!r} comes twice; give a dict of label: technique to tell them apart"
            )
    return entries


def resolved(item: object, name: str = "techniques") -> Item:
    """The Technique or Parameterization that an entry means; `name` is that of the argument it is given in."""
    if isinstance(item, str):
        from .registry import technique_of

        return technique_of(item)
    if is_parameterization(item) or makes_maps(item):
        return cast("Item", item)
    raise ArgumentError(
        f"{name}: expected a name, a Technique or a Parameterization, got {type(item).__name__}; "
        "sl.Parameterization.from_matrix(m) takes a matrix of your own"
    )


def name_of(item: Item) -> str:
    """The name of a technique, of a preset, or of the technique that made a parameterization."""
    return str(item.technique if is_parameterization(item) else item.name)


def full_name_of(item: Item) -> str:
    """The same with "preset:" before an engine's."""
    return f"preset:{name_of(item)}" if hasattr(item, "engine") else name_of(item)


def spec_of(label: str, item: Item) -> str:
    """The text that makes a technique again: its label where that does, else with all its settings.

    Of matrices always the label.
    """
    from .registry import technique_of

    if is_parameterization(item):
        return label
    name = full_name_of(item)
    try:
        again = technique_of(label)
    except ShadowlabError:
        again = None
    same = again is item or (
        again is not None and not is_parameterization(again)
        and (again.name, dict(again.settings)) == (item.name, dict(item.settings))
    )  # fmt: skip
    return label if same else format_spec(name, dict(item.settings))
