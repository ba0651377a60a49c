"""Names that a shell completes: scenes of the library, techniques with their parameters, filters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .. import _core

if TYPE_CHECKING:
    import click
    from click.shell_completion import CompletionItem


def scene_names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """The scenes of the library after @, else files."""
    from click.shell_completion import CompletionItem

    from ..scene import library

    if not incomplete.startswith("@"):
        return [CompletionItem(incomplete, type="file")]
    return _begun(incomplete, [f"@{name}" for name in library.names()])


def technique_names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """The techniques and presets; after a colon or a comma the parameters of a technique."""
    from ..techniques.presets import PRESETS
    from ..techniques.variant import READ_SETTINGS

    specs = {spec["name"]: spec for spec in _core.technique_specs()}
    name, colon, _ = incomplete.partition(":")
    if colon and name in specs:
        head = incomplete[: max(incomplete.rfind(":"), incomplete.rfind(",")) + 1]
        params = [*(one["name"] for one in specs[name]["params"]), *READ_SETTINGS]
        return _begun(incomplete, [f"{head}{param}=" for param in params])
    return _begun(incomplete, [*specs, "all", "matrix:file=", *(f"preset:{one.name}" for one in PRESETS)])


def filter_names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """The filters."""
    return _begun(incomplete, [name for name, *_ in _core.filter_kinds()])


def _begun(incomplete: str, names: Iterable[str]) -> list[CompletionItem]:
    from click.shell_completion import CompletionItem

    return [CompletionItem(name) for name in names if name.startswith(incomplete)]
