"""An advice as text, as data and as the Python that computes its rows again."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ..experiments.candidates import Candidate
from ..experiments.measures import Measure
from ..experiments.memory import UNUSED_FROM, memory_text
from ..experiments.ranking import Standing
from ..experiments.views import LabelledView
from ..text import BIAS, plain, shown
from .reproduce import bias_python, camera_python, given_python, light_python
from .study_record import camera_record, light_record, now, versions

HEADS = ("memory", "rank", "candidate", "maps", "taken", "mean", "worst", "of best", "of uniform")
# Letters of a failure that the table shows; all of it is in the verdict and the data.
LONGEST_FAILURE = 60


def cells(one: Standing, measure: Measure) -> tuple[str, ...]:
    """A row of the table as people read it; a dash where nothing was measured."""
    size = (
        "–" if one.resolution is None else f"{one.maps} × {one.resolution}²" if one.maps != 1 else f"{one.resolution}²"
    )
    row = one.row()
    taken = (
        "–"
        if row["bytes"] is None
        else f"{row['bytes'] / 2**20:,.2f} MiB"
        if row["bytes"] >= 0.995 * 2**20
        else f"{row['bytes'] / 2**10:,.4g} KiB"
    )
    if (one.unused or 0.0) > UNUSED_FROM:
        taken += f" ({100 * (1 - (one.unused or 0.0)):.0f} %)"
    head = (memory_text(one.memory), "–" if one.rank is None else str(one.rank), one.candidate, size, taken)
    if one.mean is None or one.worst is None:
        short = one.failure if len(one.failure) <= LONGEST_FAILURE else f"{one.failure[:LONGEST_FAILURE]}…"
        return (*head, "–", "–", "–", f"failed: {short}")
    ratios = (
        "–" if r is None else "∞" if math.isinf(r) else f"{r:.2f}" if r < 9.95 else f"{r:,.0f}"
        for r in (one.ratio_to_best, one.ratio_to_uniform)
    )
    return (*head, measure.text(one.mean), measure.text(one.worst), *ratios)


def text_table(advice: Any) -> str:
    """The table as aligned text; a failure stands at the end of its line."""
    standings = advice.standings
    lines = [HEADS, *(cells(one, advice.measure) for one in standings)]
    # The last column is as wide as its ratios; a failure may be longer.
    whole = [HEADS, *(line for one, line in zip(standings, lines[1:], strict=True) if one.mean is not None)]
    widths = [max(len(line[i]) for line in (lines if i < len(HEADS) - 1 else whole)) for i in range(len(HEADS))]
    text = [
        "  ".join(
            cell.ljust(w) if i in (0, 2) else cell.rjust(w)
            for i, (cell, w) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    ]
    return "\n".join([text[0], "-" * len(text[0]), *(line.rstrip() for line in text[1:])])


def notebook_html(advice: Any) -> str:
    """The verdict and the table for a notebook."""
    head = "".join(f"<th>{escape(name)}</th>" for name in HEADS)
    rows = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells(one, advice.measure))}</tr>"
        for one in advice.standings
    )
    title = f"{advice.measure.title}, {advice.over} of {len(advice.views)} view{'s' * (len(advice.views) > 1)}"
    return (
        f"<p>{escape(advice.verdict)}</p><table><caption>{escape(title)}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def snippet_of(advice: Any, row: Any) -> str:
    """The Python that computes a row of the table, a row of the runs, or a choice again.

    Raises
    ------
    ArgumentError
        For something that is no such row, or one without a number.
    """
    candidate, memory, label = key_of(advice, row)
    views = [view for view in advice.counted if label is None or view.label == label]
    of = [o for o in advice.outcomes if (o.candidate, o.memory) == (candidate, memory)]
    of = [o for o in of if o.view.label in {view.label for view in views}]
    if not of or any(o.error is None for o in of):
        reason = next((o.failure for o in of if o.failure), "nothing was measured")
        raise ArgumentError(f"row: expected one with a number, got one that failed: {reason}")
    chosen = next(one for one in advice.candidates if one.label == candidate)
    return snippet(advice, chosen, int(of[0].resolution or 0), views)


def key_of(advice: Any, row: Any) -> tuple[str, int, str | None]:
    """Candidate, budget and view (None for all) of what stands for a row."""
    hint = "expected a row of .table or .runs, its position in .table, or a choice"
    if isinstance(row, (int, np.integer)) and not isinstance(row, (bool, np.bool_)):
        ranking = advice.standings
        if not 0 <= row < len(ranking):
            raise ArgumentError(f"row: expected a position from 0 to {len(ranking) - 1}, got {row}")
        return ranking[row].candidate, ranking[row].memory, None
    get: Any = row.get if hasattr(row, "get") else lambda name: getattr(row, name, None)
    try:
        key = str(get("candidate") or get("technique")), int(get("memory")), get("view")
    except (TypeError, ValueError):
        raise ArgumentError(f"row: {hint}, got {shown(row)}") from None
    if key not in {(o.candidate, o.memory, v) for o in advice.outcomes for v in (None, o.view.label)}:
        raise ArgumentError(f"row: {hint}, got {key[0]!r} at {memory_text(key[1])}, which this advice does not have")
    return key


def snippet(advice: Any, candidate: Candidate, resolution: int, views: Sequence[LabelledView]) -> str:
    """A script that computes the error of a candidate at a resolution in views, and prints it."""
    of_errors = "errors." in advice.measure.python
    lines = ["import numpy as np"] * candidate.given + [
        "import shadowlab as sl",
        "",
        advice.source.python,
        f"renderer = sl.Renderer({advice.backend!r})",
        "views = {}",
    ]
    for view in views:
        lines += [camera_python(view.camera), light_python(view.light)]
        lines.append(f"views[{view.label!r}] = camera, light, {view.size}")
    if candidate.given:
        lines += [f"p = {given_python(candidate.item)}"]
    else:
        lines.append(f"technique = sl.technique({candidate.text!r})")
    lines += ["found = {}", "for label, (camera, light, size) in views.items():"]
    samples = ", samples=gbuffer" if getattr(candidate.item, "needs_samples", False) else ""
    body = []
    if samples or not of_errors:
        body.append("gbuffer = renderer.gbuffer(scene, camera, size=size)")
    if not candidate.given:
        body.append(f"p = technique.parameterize(scene, camera, light, resolution={resolution}{samples})")
    if of_errors:
        body += [
            f"mask = renderer.shadow_mask(scene, camera, light, p, resolution={resolution}, size=size,",
            f"    bias={bias_python(advice.bias)}, filter={advice.filter!r})",
            "errors = sl.aliasing.misclassified(mask, sl.trace.shadow_mask(scene, camera, light, size=size))",
        ]
    else:
        body.append(f"summary = sl.aliasing.footprint(gbuffer, camera, light, p, resolution={resolution}).summary()")
    body.append(f"found[label] = {advice.measure.python}")
    lines += [f"    {line}" for line in body]
    lines += ["error_mean, error_worst = sum(found.values()) / len(found), max(found.values())"]
    lines += ["print(found, error_mean, error_worst)"]
    return "\n".join(lines) + "\n"


def as_data(advice: Any) -> dict[str, Any]:
    """The whole advice as data: every number, and the Python behind every row."""
    scene, measure = advice.scene, advice.measure
    runs = advice.runs.astype(object).where(advice.runs.notna(), None).to_dict("records")
    names = ("label", "camera_label", "light_label", "light_angle", "light_elevation", "size")
    return {
        "created": now(),
        "versions": versions(),
        "platform": platform.platform(),
        "renderer": {"backend": advice.backend, "adapter": advice.adapter},
        "scene": {
            "source": advice.source.name, "python": advice.source.python, "triangles": scene.triangle_count,
            "instances": scene.instance_count, "bounds": np.asarray(scene.bounds),
        },
        "measure": {name: getattr(measure, name) for name in ("name", "title", "unit", "direction", "doc", "python")},
        "over": advice.over,
        "memory": list(advice.budgets),
        "bias": {name: getattr(advice.bias, name) for name in BIAS},
        "filter": advice.filter,
        "views": [
            {**{name: getattr(view, name) for name in names}, "counted": view in advice.counted,
             "filled": advice.filled[view.label], "camera": camera_record(view.camera),
             "light": light_record(view.light)}
            for view in advice.views
        ],
        "candidates": [
            {"label": one.label, "technique": one.text, "name": one.technique, "settings": one.settings,
             **({"matrices": np.asarray(one.item.matrices)} if one.given else {})}
            for one in advice.candidates
        ],
        "table": [
            {**one.row(), "reproduce": snippet_of(advice, i) if one.error is not None else None}
            for i, one in enumerate(advice.standings)
        ],
        "runs": [
            {**row, "reproduce": snippet_of(advice, row) if row["error"] is not None else None} for row in runs
        ],
        "switches": advice.switches.to_dict("records"),
        "verdict": advice.verdict,
    }  # fmt: skip


def save(advice: Any, directory: Path) -> Path:
    """Writes the tables, the data and the figure into a directory, which is made; the path of advice.json.

    Raises
    ------
    ArgumentError
        Where it cannot be made or written.
    """
    text = json.dumps(plain(as_data(advice)), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    path = directory / "advice.json"
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for name, table in (("advice", advice.table), ("runs", advice.runs), ("switches", advice.switches)):
            table.to_csv(directory / f"{name}.csv", index=False)
        draw(advice, directory / "advice.png")
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise ArgumentError(f"directory: cannot write to {str(directory)!r} ({reason}); choose another") from error
    return path


def draw(advice: Any, path: Path) -> None:
    """The figure as a PNG, whatever backend matplotlib has."""
    import matplotlib.pyplot as plt

    figure = advice.figure()
    try:
        figure.savefig(path, dpi=150)
    finally:
        plt.close(figure)
