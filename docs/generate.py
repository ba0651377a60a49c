"""Writes what the registries say: the tables between the markers of README.md, and the pages in `PAGES`.

    python docs/generate.py [--check]

With --check nothing is written, and the exit status is 1 where a file is out of date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import shadowlab as sl
from shadowlab.experiments import columns
from shadowlab.reports import study_arrays
from shadowlab.reports.result_keys import ADVICE_KEYS, STUDY_KEYS
from shadowlab.reports.saved import FORMAT_OF_RESULTS

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
TECHNIQUES = ROOT / "docs" / "techniques.md"
COLUMN_PAGE = ROOT / "docs" / "columns.md"
ARRAY_PAGE = ROOT / "docs" / "arrays.md"
RESULT_PAGE = ROOT / "docs" / "results.md"


PAGES = (README, TECHNIQUES, COLUMN_PAGE, ARRAY_PAGE, RESULT_PAGE)


def markdown(header: list[str], rows: list[list[str]]) -> str:
    """A table; a bar in a cell is escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def techniques() -> str:
    """One row a technique: what it is, where it comes from, its parameters with unit, default and range."""
    rows = []
    for name, group in sl.techniques().groupby("name", sort=False):
        first = group.iloc[0]
        parameters = [
            f"`{p.parameter}={p.default}`{f' {p.unit}' if p.unit else ''} ({p.range})"
            for p in group.itertuples()
            if p.parameter
        ]
        rows.append([f"`{name}`", first["title"], first["source"], first["lights"], "<br>".join(parameters) or "none"])
    return markdown(["name", "title", "source", "lights", "parameters: default (range)"], rows)


def technique_pages() -> str:
    """docs/techniques.md: a section a technique, its parameters with what they do; then the presets."""
    page = [
        "# Techniques",
        "",
        "What `shadowlab techniques` and `sl.techniques()` list. Every technique is focused and fitted in the same",
        "way, so a comparison shows the warp, or the division of the view, alone. Made by `python docs/generate.py`.",
        "",
    ]
    for name, group in sl.techniques().groupby("name", sort=False):
        first = group.iloc[0]
        page += [f"## {name}", "", f"{first['title']}. {first['source']}. Lights: {first['lights']}.", ""]
        rows = [
            [f"`{p.parameter}`", p.unit, f"`{p.default}`", p.range, p.doc] for p in group.itertuples() if p.parameter
        ]
        page += [markdown(["parameter", "unit", "default", "range", "what it does"], rows), ""]
    page += [
        "## Presets",
        "",
        "What engines ship, as techniques: `sl.preset(name)`, or `--technique preset:name`. The formula is the",
        "engine's; the body and the fit are the same as everywhere here.",
        "",
    ]
    rows = [[f"`{p.name}`", p.engine, f"`{p.formula}`", p.source, p.differs] for p in sl.presets().itertuples()]
    page += [markdown(["name", "engine", "formula", "source", "what the engine does otherwise"], rows), ""]
    return "\n".join(page)


def library() -> str:
    """One row a scene: how large it is, and what it is there for."""
    rows = []
    for entry in sl.library.table().itertuples():
        scene = sl.library.scene(entry.name)
        size = f"{scene.triangle_count:,} in {scene.instance_count:,}"
        rows.append([f"`@{entry.name}`", entry.title, size, entry.shows])
    return markdown(["name", "title", "triangles in instances", "shows"], rows)


def column_page() -> str:
    """docs/columns.md: every column of every table once, and the columns of each table."""
    page = [
        "# Columns",
        "",
        "Every table of every experiment takes its columns from one vocabulary, `shadowlab.experiments.columns`: a",
        "name means the same thing, in the same unit and dtype, wherever it stands. `str` is pandas' `object`; `Int64`",
        "and `boolean` hold missing values, and `float64` holds NaN for them. Made by `python docs/generate.py`.",
        "",
    ]
    for title, group in columns.GROUPS.items():
        rows = [[f"`{c.name}`", c.unit, c.dtype, c.doc, c.over_lights or "none"] for c in group]
        page += [f"## {title}", "", markdown(["column", "unit", "dtype", "meaning", "several lights"], rows), ""]
    page += ["## Tables", ""]
    page += [f"- `{name}`: {', '.join(f'`{column}`' for column in names)}" for name, names in columns.TABLES.items()]
    rows = [[f"`{old}`", f"`{new}`"] for old, new in columns.RENAMED.items()]
    page += ["", "## Names from before", "", markdown(["before", "now"], rows), ""]
    return "\n".join(page)


def array_page() -> str:
    """docs/arrays.md: what is in the file that a study's arrays are saved to."""
    page = [
        "# Arrays of a study",
        "",
        '`shadowlab compare ... --save-arrays study.npz` and `study.save_arrays("study.npz")` write one compressed',
        "file that `numpy.load` reads without pickle. Images have row 0 at the top. Made by `python docs/generate.py`.",
        "",
    ]
    texts = (
        ("The view", "H and W are the height and width of the picture.", study_arrays.VIEW_KEYS, ""),
        (
            "Each run", "Arrays of run i, counted from 0. K is the number of its maps, N the resolution.",
            study_arrays.RUN_KEYS, "run_i_",
        ),
    )  # fmt: skip
    for title, text, keys, prefix in texts:
        rows = [[f"`{prefix}{name}`", *meaning.split(": ", 1)] for name, meaning in keys.items()]
        page += [f"## {title}", "", text, "", markdown(["key", "shape and dtype", "meaning"], rows), ""]
    return "\n".join(page)


def result_page() -> str:
    """docs/results.md: what is in the files of results."""
    page = [
        "# Files of results",
        "",
        "`study.save(folder)` and `shadowlab compare --out folder` write `results.json`, `advice.save(folder)` and",
        "`shadowlab advise --out folder` write `advice.json`: strict JSON in UTF-8, without NaN. A missing number is",
        '`null`, an infinite one the text `"inf"`. `sl.Study.load(folder)` and `sl.Advice.load(folder)` read them back',
        f"as they were. This page is of format {FORMAT_OF_RESULTS}. A new key does not raise the format; one that goes",
        "or means something else does. Keys of the items of a list stand after `[]`, `*` is any name, and `COLUMN` the",
        "name of a column in [columns.md](columns.md). Made by `python docs/generate.py`.",
        "",
    ]
    for title, keys in (("results.json", STUDY_KEYS), ("advice.json", ADVICE_KEYS)):
        rows = [[f"`{name}`", *(text.split(": ", 1) if ": " in text else (text, ""))] for name, text in keys.items()]
        page += [f"## {title}", "", markdown(["key", "type", "meaning"], rows), ""]
    return "\n".join(page)


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
    before = {path: path.read_text(encoding="utf-8") if path.exists() else "" for path in PAGES}
    after = {README: generated(before[README]), TECHNIQUES: technique_pages(), COLUMN_PAGE: column_page()}
    after[ARRAY_PAGE], after[RESULT_PAGE] = array_page(), result_page()
    stale = [path for path in before if before[path] != after[path]]
    for path in stale:
        if arguments == ["--check"]:
            print(f"{path.relative_to(ROOT)} is out of date; run: make docs", file=sys.stderr)
        else:
            path.write_text(after[path], encoding="utf-8")
    return int(bool(stale) and arguments == ["--check"])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
