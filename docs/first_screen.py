"""Writes what README.md shows first: a command on somebody's file, and its answer as it was printed.

    python docs/first_screen.py kenney_city.glb

The file is a city of models by Kenney (CC0), which is no part of the project: `make docs` leaves this block as it is.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

from shadowlab import cli

README = Path(__file__).resolve().parents[1] / "README.md"
WORDS = ("advise", "city.glb", "--memory", "4MiB", "--backend", "cpu")
BLOCK = re.compile(r"(<!-- first:begin -->\n).*?(<!-- first:end -->)", re.DOTALL)


def answer(city: Path) -> str:
    """What the command prints for a file, and the command."""
    words = WORDS[: WORDS.index("--backend")]  # the renderer that every machine has prints the same everywhere
    printed = io.StringIO()
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(city, Path(folder) / "city.glb")
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(printed):
                status = cli.main(WORDS)
        finally:
            os.chdir(before)
    if status:
        raise SystemExit(status)
    # How many threads this machine has is of no interest.
    text = re.sub(r" on cpu \(.*?\),", " on cpu,", printed.getvalue(), count=1)
    return f"```\n$ shadowlab {' '.join(words)}\n{text.rstrip()}\n```\n"


def written(text: str, city: Path) -> str:
    """The text of README.md with the answer for a file between its markers."""
    if len(BLOCK.findall(text)) != 1:
        raise SystemExit("README.md: expected one pair of markers <!-- first:begin --> and <!-- first:end -->")
    made = answer(city)
    return BLOCK.sub(lambda match: f"{match[1]}{made}{match[2]}", text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("first_screen.py: expected one argument, the mesh file of the city")
    README.write_text(written(README.read_text(encoding="utf-8"), Path(sys.argv[1])), encoding="utf-8")
