"""The command `shadowlab doctor`: what is here, what is missing, and how to get it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .options import Commands


def doctor_options(commands: Commands, shared: ArgumentParser) -> None:
    """Adds the command to the others."""
    doctor = commands.add_parser(
        "doctor",
        parents=[shared],
        help="what is here, what is missing, and how to get it",
        description=doctor_command.__doc__,
    )
    doctor.set_defaults(run=doctor_command)


def doctor_command(_: Namespace) -> int:
    """Says what works here, what is missing, and the command that brings it. Exit status 0 where the core works."""
    from ..doctor import report

    found = report()
    print(found)
    return 0 if found.works else 1
