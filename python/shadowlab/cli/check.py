"""The command `shadowlab check`: a gate for an engine's continuous integration."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ..errors import ArgumentError
from ..text import counted
from .check_config import checks_of
from .check_run import BoundOutcome, Scenes, bound_outcomes
from .command import Argument, Command, Option, Options
from .config import read_config
from .options import writable_file

if TYPE_CHECKING:
    from pathlib import Path

BOUND_BROKEN = 1
OUTCOME_HEADS = ("check", "technique", "resolution", "column", "value", "bound", "outcome")


def check_command(options: Options) -> int:
    """Holds techniques, or matrices of an engine, against bounds: wrong pixels, size of texels, drift, any column.

    BOUNDS.toml says which views, techniques and bounds; docs/check.md has its keys, and a workflow for GitHub. Paths in
    it are relative to the folder that the command runs in. Exit status 0 where all bounds hold, 1 where one is broken.
    """
    from .._core import Renderer
    from ..text.progress import steps_of_call

    checks = checks_of(read_config(options.bounds))
    file = None if options.junit is None else writable_file("junit", options.junit)
    scenes, renderer_of = Scenes(), functools.cache(Renderer)
    outcomes: list[BoundOutcome] = []
    with steps_of_call(len(checks), None) as step:
        for check in checks:
            step(check.name)
            outcomes += bound_outcomes(check, scenes, renderer_of)
    print(outcome_table(outcomes))
    broken = [one for one in outcomes if not one.holds]
    for one in broken:
        print(f"{one.check}, {one.technique} at {one.resolution}²: {one.complaint}")
    bounds = counted(len(outcomes), "bound")
    print(f"\n{len(broken)} of {bounds} broken" if broken else f"\nAll of {bounds} hold")
    if file is not None:
        write_junit(file, options.bounds, outcomes)
        print(f"JUnit: {file}")
    return BOUND_BROKEN if broken else 0


def outcome_table(outcomes: Sequence[BoundOutcome]) -> str:
    """A line for each bound on each technique."""
    from ..reports.terminal import aligned

    rows = [
        (
            one.check,
            one.technique,
            f"{one.resolution}²",
            one.bound.column,
            one.value_text,
            one.bound.text,
            "holds" if one.holds else "failed" if one.failure else "BROKEN",
        )
        for one in outcomes
    ]
    return aligned(OUTCOME_HEADS, rows, left=(0, 1, 3, 5, 6))


def write_junit(file: Path, config: str, outcomes: Sequence[BoundOutcome]) -> None:
    """The outcomes as JUnit's XML: a suite for each check, a case for each bound on each technique.

    Raises
    ------
    ArgumentError
        Where the file cannot be written.
    """
    from ..reports.junit import Case, junit_xml

    suites: dict[str, list[Case]] = {}
    for one in outcomes:
        name = f"{one.bound.column} {one.bound.text}"
        group = f"{one.technique} at {one.resolution}"
        told = ("", one.complaint) if one.value is None else (one.complaint, "")
        suites.setdefault(one.check, []).append(Case(name, group, one.seconds, *told))
    try:
        file.write_bytes(junit_xml(f"shadowlab check {config}", suites))
    except OSError as error:
        raise ArgumentError(f"junit: cannot write {str(file)!r} ({error.strerror or error})") from error


CHECK = Command(
    "check",
    check_command,
    [
        Argument("bounds", metavar="BOUNDS.toml", type=click.Path(), help="views, techniques and bounds"),
        Option("--junit", metavar="FILE", type=click.Path(), help="write the outcome there as JUnit's XML"),
    ],
)
