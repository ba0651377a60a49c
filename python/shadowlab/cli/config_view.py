"""Scene, camera, light and how maps are read, in a configuration: the keys are the options of the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import click

from ..text import bias_of, parse_pair, parse_size, parse_vector, shown
from ..text.checks import check_filter, checked_blend, checked_stored
from .brought import light_name
from .command import Option, Options
from .config import Table
from .options import light_option, lookup_options, view_options

# Options with a check of their own beside that of `load_view`, which cannot say on which line they stand.
CHECKS: dict[str, Callable[[Any], object]] = {
    "size": parse_size,
    "eye": lambda text: parse_vector(text, "eye"),
    "target": lambda text: parse_vector(text, "target"),
    "light": lambda text: None if light_name(text) is not None else parse_vector(text, "light"),
    "light_position": lambda text: parse_vector(text, "light-position"),
    "shift": lambda text: parse_pair(text, "shift"),
    "bias": bias_of,
    "filter": check_filter,
    "blend": checked_blend,
    "stored": checked_stored,
}


def view_parameters() -> list[Option]:
    """The options that a configuration takes as keys."""
    return [*view_options(), light_option(), *lookup_options()]


def option_key(option: Option) -> str:
    """The key of an option: its name without the dashes before it."""
    return option.opts[0].lstrip("-")


#: The keys of a view, the scene first.
KEYS_OF_VIEW = ("scene", *(option_key(option) for option in view_parameters()))


def holder(tables: Sequence[Table], key: str) -> Table | None:
    """The first of the tables that has a key."""
    return next((table for table in tables if key in table), None)


def view_of_config(tables: Sequence[Table]) -> Options:
    """The options of a view, each from the first table that has its key, as the command line gives them.

    Raises
    ------
    ArgumentError
        For a value that does not fit, with file, line and key.
    """
    found: dict[str, Any] = {}
    of_scene = holder(tables, "scene")
    if of_scene is None:
        raise tables[0].wrong(None, 'expected a key scene, got none; try scene = "@robots" or scene = "city.glb"')
    found["scene"] = of_scene.text("scene", 'a scene of the library such as "@robots", or a mesh file')
    for option in view_parameters():
        name = str(option.name)
        table = holder(tables, option_key(option))
        found[name] = option.default if option.name in ("backend", "filter", "blend") else None
        # A table there are the matrices of a camera, which are no option of the command line.
        if table is not None and not (name == "camera" and isinstance(table.get(name), dict)):
            found[name] = value_of(table, option)
        elif option.is_flag:
            found[name] = False
    return Options(**found)


def value_of(table: Table, option: Option) -> Any:
    """The value of an option as the command line would give it."""
    key, name = option_key(option), str(option.name)
    value = table.get(key)
    if option.is_flag:
        if not isinstance(value, bool):
            raise table.wrong(key, f"expected true or false, got {shown(value)}")
        return value
    numbers = value if isinstance(value, list) else [value]
    if all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in numbers) and numbers:
        text = ",".join(map(repr, numbers))
    elif isinstance(value, str):
        text = value
    else:
        raise table.wrong(key, f"expected a text, a number or a list of numbers, got {shown(value)}")
    try:
        given = option.type.convert(text, option, None)
    except click.UsageError as error:
        raise table.wrong(key, error.message.rstrip(".")) from None
    if name in CHECKS:
        with table.naming(key):
            CHECKS[name](given)
    return given
