"""Makes what `prefiltered.md` shows again: the printed example, its picture and the tables.

    python docs/prefiltered.py

The sentences about the tables are written by hand: read them again when numbers change.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
from pathlib import Path

import matplotlib as mpl

import shadowlab as sl

PAGE = Path(__file__).with_name("prefiltered.md")
PICTURE = PAGE.with_suffix("") / "robots.png"
DPI = 66
SIZE = (320, 180)
SCENES = ("courtyard", "robots", "ceiling", "skylight", "dueling", "forest", "statues")
BY_MEMORY = ("depth:nearest", "depth:pcf", "variance:f32", "moment:unorm16")


def view_of(name: str) -> sl.View:
    """A scene of the library as the tables show it."""
    scene = sl.library.scene(name, **({"trees": 300} if name == "forest" else {}))
    return sl.View(scene, scene.camera, scene.light, size=SIZE)


def row(name: str, values: list[int]) -> str:
    """A line of a table of counts."""
    return f"| {name} | {' | '.join(f'{value:,}' for value in values)} |"


def with_row(text: str, name: str, values: list[int]) -> str:
    """The text with this line in the table that has as many columns."""
    pattern = rf"^\| {re.escape(name)} \|(?: [\d,]+ \|){{{len(values)}}}$"
    replaced, count = re.subn(pattern, row(name, values), text, flags=re.MULTILINE)
    if count != 1:
        raise SystemExit(f"{PAGE}: expected one row {name!r} with {len(values)} numbers, got {count}")
    return replaced


def main() -> int:
    """Writes the page and its picture."""
    mpl.use("Agg")
    text = PAGE.read_text("utf-8")
    python, printed = re.search(r"```python\n(.*?)```\n\n```\n(.*?)```", text, re.DOTALL).groups()
    words, names = io.StringIO(), {"__name__": "__main__"}
    with contextlib.redirect_stdout(words):
        exec(compile(python, str(PAGE), "exec"), names)
    text = text.replace(printed, words.getvalue())
    names["figure"].savefig(PICTURE, dpi=DPI)
    sums: dict[str, list[int]] = {}
    for name in SCENES:
        table = sl.prefiltered_maps(view_of(name), memory="1 MiB", renderer="cpu", progress=False).table
        for column, rows in (("misclassified", table), ("leaks", table[2:])):
            values = [int(value) for value in rows[column]]
            text = with_row(text, name, values)
            sums[column] = [a + b for a, b in zip(sums.get(column, [0] * len(values)), values, strict=True)]
    for values in sums.values():
        text = with_row(text, "sum", values)
    for memory in ("1 MiB", "4 MiB", "16 MiB"):
        for kernel in (3, 5):
            found = sl.prefiltered_maps(
                view_of("robots"), memory=memory, kernel=kernel, formats=BY_MEMORY, renderer="cpu", progress=False
            )
            cells = " | ".join(f"{r.misclassified:,}, {r.soft_error:.4f}" for r in found.table.itertuples())
            text = re.sub(rf"^\| {memory} \| {kernel} \|.*$", f"| {memory} | {kernel} | {cells} |", text, flags=re.M)
    PAGE.write_text(text, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
