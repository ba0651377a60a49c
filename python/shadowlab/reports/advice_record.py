"""An advice as data and as files, and its table for a notebook."""

from __future__ import annotations

import io
import platform
from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from ..techniques.kinds import is_parameterization
from ..text import BIAS
from .reproduce_advice import snippet_of, whole_advice
from .study_record import camera_record, light_record, now, versions
from .terminal import ADVICE_HEADS, advice_cells

if TYPE_CHECKING:
    from ..experiments.advice import Advice


def advice_html(advice: Advice) -> str:
    """The verdict and the table for a notebook."""
    head = "".join(f"<th>{escape(name)}</th>" for name in ADVICE_HEADS)
    rows = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in advice_cells(one, advice.measure))}</tr>"
        for one in advice.standings
    )
    title = f"{advice.measure.title}, {advice.over} of {len(advice.views)} view{'s' * (len(advice.views) > 1)}"
    return (
        f"<p>{escape(advice.verdict)}</p><table><caption>{escape(title)}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def advice_data(advice: Advice) -> dict[str, Any]:
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
        "blend": advice.blend,
        "stored": str(advice.stored),
        "views": [
            {**{name: getattr(view, name) for name in names}, "counted": view in advice.counted,
             "filled": advice.filled[view.label], "camera": camera_record(view.camera),
             "light": light_record(view.light)}
            for view in advice.views
        ],
        "candidates": [
            {"label": one.label, "technique": one.text, "name": one.technique, "settings": one.settings,
             **({"matrices": np.asarray(one.item.matrices)} if is_parameterization(one.item) else {})}
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
        "phases": advice.phases,
        "gains": [
            {"memory": one.memory, "best": one.best.candidate, "baseline": one.baseline.candidate,
             "relation": one.relation, "drawn": list(one.drawn)}
            for one in advice.gains
        ],
        "unjudged": advice.unjudged,
        "untried": [asdict(one) for one in advice.untried],
        "reproduce": whole_advice(advice),
        "verdict": advice.verdict,
    }  # fmt: skip


def figure_png(advice: Advice) -> bytes:
    """The figure as a PNG, whatever backend matplotlib has."""
    import matplotlib.pyplot as plt

    figure, file = advice.figure(), io.BytesIO()
    try:
        figure.savefig(file, format="png", dpi=150)
    finally:
        plt.close(figure)
    return file.getvalue()
