"""The command `shadowlab doctor`: what is here, what is missing, and how to get it."""

from __future__ import annotations

from .command import Command, Options


def doctor_command(_: Options) -> int:
    """Says what works here, what is missing, and the command that brings it. Exit status 0 where the core works."""
    from ..doctor import report

    found = report()
    print(found)
    return 0 if found.works else 1


DOCTOR = Command("doctor", doctor_command)
