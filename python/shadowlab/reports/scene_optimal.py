"""The scene-optimal experiment as text, Markdown and files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..experiments.scene_optimal_table import FIGURES, NORMAL, OPTIMAL, SceneOptimalTable, served
from ..experiments.scene_optimal_views import CAMERAS, SPOTS, SUNS
from ..experiments.thresholds import ABOUT_EQUAL
from ..text.progress import steps_of_call
from .terminal import aligned
from .words import rows_of

if TYPE_CHECKING:
    import pandas as pd

# Of 100 dots an inch, for pictures of about 1000 pixels.
FIGURE_DPI = 100
HEADS = ("technique", "size", "wrong", "normal", "more", "wrong (map)", "normal (map)", "more (map)", "wins", "by 1.1")


def terminal_text(result: SceneOptimalTable) -> str:
    """The sums of every size, then of all sizes together where there are several."""
    several = len(set(result.table["single_side"])) > 1
    cells = [total_cells(row) for row in (*rows_of(result.totals), *(rows_of(result.in_sum) if several else ()))]
    failed = failures(result)
    lines = [aligned(HEADS, cells, left=(0,)), *failed]
    return "\n".join(lines)


def total_cells(row: Any) -> list[str]:
    """A row of `totals` as people read it."""
    import pandas as pd

    def percent(name: str) -> str:
        return "–" if pd.isna(row[name]) else f"{row[name]:+.1f} %"

    return [
        str(row["technique"]),
        "all" if pd.isna(row["single_side"]) else f"{row['single_side']}²",
        f"{row['misclassified']:,}", f"{row['misclassified_normal']:,}", percent("percent_more"),
        f"{row['misclassified_by_map']:,}", f"{row['misclassified_normal_by_map']:,}", percent("percent_more_by_map"),
        f"{row['wins']} of {row['configurations']}", f"{row['clear_wins']} of {row['configurations']}",
    ]  # fmt: skip


def failures(result: SceneOptimalTable) -> list[str]:
    """A line for each technique that did not serve all views."""
    failed = result.table[result.table["failure"] != ""]
    lines = []
    for technique, of in failed.groupby("technique", sort=False):
        views = f"{of['view'].nunique()} of {result.table['view'].nunique()} views"
        lines.append(f"{technique}: no map in {views}: {of['failure'].iloc[0]}")
    return lines


def paper_markdown(result: SceneOptimalTable, technique: str = OPTIMAL) -> str:
    """The paper's table: resolution, both counts, and how many percent more the normal map has; by truth and by map."""
    head = ["Resolution", "Optimal", "Normal", "Percent More", "Optimal (map)", "Normal (map)", "Percent More (map)"]
    rows = [
        [cells[1].replace("²", f"x{cells[1][:-1]}"), *cells[2:8]]
        for row in rows_of(result.totals)
        if row["technique"] == technique and (cells := total_cells(row))
    ]
    return markdown_table(head, rows, right=range(1, 7))


def totals_markdown(result: SceneOptimalTable) -> str:
    """How many percent more mistakes the normal map makes: a row per technique, a column per size, then all sizes."""
    totals, in_sum = result.totals, result.in_sum
    sides = list(dict.fromkeys(totals["single_side"]))
    head = ["technique", *(f"{side}²" for side in sides), "all sizes", "all sizes, by map", "wins", "by 1.1"]
    rows = []
    for row in rows_of(in_sum):
        of = totals[totals["technique"] == row["technique"]].set_index("single_side")["percent_more"]
        cells = total_cells(row)
        by_size = ("–" if np.isnan(of[side]) else f"{of[side]:+.0f} %" for side in sides)
        rows.append([f"`{row['technique']}`", *by_size, cells[4], cells[7], *cells[8:]])
    return markdown_table(head, rows, right=range(1, len(head)))


def ratios_markdown(result: SceneOptimalTable) -> str:
    """How many times the wrong pixels of a technique the normal map has: a row per view, a column per technique."""
    names = [name for name in result.techniques if name != NORMAL]
    ratios = {name: result.ratios(name) for name in names}
    counts = served(result.table)
    normal = counts[counts["technique"] == NORMAL].groupby("view", sort=False)["misclassified"].sum()
    rows = []
    for view, wrong in normal.items():
        values = [ratios[name].get(view, np.nan) for name in names]
        best = np.nanmax(values)
        cells = ["–" if np.isnan(v) else f"**{v:.2f}**" if v == best else f"{v:.2f}" for v in values]
        rows.append([str(view), f"{wrong:,}", *cells])
    head = ["view", "normal, wrong pixels", *(f"`{name}`" for name in names)]
    return markdown_table(head, rows, right=range(1, len(head)))


def configurations_markdown() -> str:
    """The 28 configurations: their cameras, their suns and their spots."""
    cameras = [[name, places(eye), places(to), f"{fov:g}°"] for name, (eye, to, fov) in CAMERAS.items()]
    suns = [[name, f"{azimuth:g}°", f"{elevation:g}°"] for name, (azimuth, elevation) in SUNS.items()]
    spots = [[name, places(at), places(to), f"{cone:g}°"] for name, (at, to, cone) in SPOTS.items()]
    tables = (
        markdown_table(["camera", "eye, m", "looks at, m", "field of view"], cameras),
        markdown_table(["sun", "azimuth, from +z towards +x", "elevation"], suns, right=(1, 2)),
        markdown_table(["spot", "position, m", "looks at, m", "cone"], spots),
    )
    return "\n\n".join(tables)


def as_good(result: SceneOptimalTable, technique: str = OPTIMAL) -> pd.DataFrame:
    """The views where another technique has about as few wrong pixels as this one, or fewer.

    Returns
    -------
    DataFrame
        view, technique (the other one), ratio (its wrong pixels by this one's).
    """
    import pandas as pd

    mine = dict(result.ratios(technique).items())
    rows = [
        {"view": view, "technique": name, "ratio": mine[view] / value}
        for name in result.techniques
        if name not in (technique, NORMAL)
        for view, value in result.ratios(name).items()
        if view in mine and value > 0 and mine[view] / value <= ABOUT_EQUAL
    ]
    return pd.DataFrame(rows, columns=["view", "technique", "ratio"])


def save(result: SceneOptimalTable, directory: Path, progress: bool | None) -> Path:
    """Writes runs.csv, totals.csv, views.csv, results.json, table.md and the figures; the directory."""
    directory.mkdir(parents=True, exist_ok=True)
    result.table.to_csv(directory / "runs.csv", index=False)
    result.totals.to_csv(directory / "totals.csv", index=False)
    result.views.to_csv(directory / "views.csv", index=False)
    text = json.dumps(as_data(result), indent=1, allow_nan=False)
    (directory / "results.json").write_text(text + "\n", encoding="utf-8")
    (directory / "table.md").write_text(page_of(result), encoding="utf-8")
    with steps_of_call(len(FIGURES), progress) as step:
        for name in FIGURES:
            step(f"figure {name}")
            result.figure(name).savefig(directory / f"{name}.png", dpi=FIGURE_DPI)
    return directory


def page_of(result: SceneOptimalTable) -> str:
    """The tables as one Markdown text."""
    parts = [totals_markdown(result), ratios_markdown(result)]
    if OPTIMAL in result.techniques:
        parts.insert(0, paper_markdown(result))
    return "\n\n".join([*parts, *(f"- {line}" for line in failures(result))]) + "\n"


def as_data(result: SceneOptimalTable) -> dict[str, Any]:
    """Everything as numbers and texts for JSON; None where nothing was measured."""
    tables = {"totals": result.totals, "in_sum": result.in_sum, "views": result.views, "runs": result.table}
    plain = {name: json.loads(of.to_json(orient="records", double_precision=15)) for name, of in tables.items()}
    return {"reference": result.reference, "backend": result.backend, "adapter": result.adapter, **plain}


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int] = ()) -> str:
    """A Markdown table; columns in `right` are flush right."""
    rule = ["---:" if i in right else "---" for i in range(len(head))]
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, rule, *rows))


def places(point: Sequence[float]) -> str:
    """A point as people read it."""
    return ", ".join(f"{x:g}" for x in point)
