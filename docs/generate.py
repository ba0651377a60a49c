"""Writes the tables between the markers of README.md from the registries: python docs/generate.py [--check].

With --check nothing is written, and the exit status is 1 where a table is out of date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import shadowlab as sl

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"


def markdown(header: list[str], rows: list[list[str]]) -> str:
    """A table; a bar in a cell is escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def techniques() -> str:
    """One row a technique: what it is, where it comes from, its parameters with default and range."""
    rows = []
    for name, group in sl.techniques().groupby("name", sort=False):
        first = group.iloc[0]
        parameters = [
            f"`{p.parameter}={p.default}`{f' {p.unit}' if p.unit else ''} ({p.range}): {p.doc}"
            for p in group.itertuples()
            if p.parameter
        ]
        rows.append([f"`{name}`", first["title"], first["source"], first["lights"], "<br>".join(parameters) or "none"])
    return markdown(["name", "title", "source", "lights", "parameters: default (range)"], rows)


def library() -> str:
    """One row a scene: how large it is, and what it is there for."""
    rows = []
    for entry in sl.library.table().itertuples():
        scene = sl.library.scene(entry.name)
        size = f"{scene.triangle_count:,} in {scene.instance_count:,}"
        rows.append([f"`@{entry.name}`", entry.title, size, entry.shows])
    return markdown(["name", "title", "triangles in instances", "shows"], rows)


TABLES = {"techniques": techniques, "library": library}


def generated(text: str) -> str:
    """The text with every table made anew."""
    for name, table in TABLES.items():
        pattern = re.compile(f"(<!-- {name}:begin -->\n).*?(<!-- {name}:end -->)", re.DOTALL)
        if len(pattern.findall(text)) != 1:
            raise SystemExit(f"README.md: expected one pair of markers <!-- {name}:begin --> and <!-- {name}:end -->")
        made = table()
        text = pattern.sub(lambda match, made=made: f"{match[1]}{made}\n{match[2]}", text)
    return text


def main(arguments: list[str]) -> int:
    """Writes or checks; the exit status."""
    before = README.read_text(encoding="utf-8")
    after = generated(before)
    if arguments == ["--check"]:
        if before != after:
            print("README.md: a table is out of date; run: make docs", file=sys.stderr)
        return int(before != after)
    README.write_text(after, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
