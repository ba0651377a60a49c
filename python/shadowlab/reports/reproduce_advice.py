"""How to get an advice or a row of it again: the Python that does it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..experiments.candidates import Candidate, Outcome
from ..experiments.memory import memory_text
from ..experiments.views import LabelledView
from ..techniques.kinds import is_parameterization
from ..techniques.variant import reading
from ..text import shown
from ..text.checked import has_all
from .reproduce import camera_python, given_python, light_python, reading_python

if TYPE_CHECKING:
    from ..experiments.advice import Advice

# How the errors of the views become those of a row.
SUMMED = (
    "error_mean, error_worst = sum(found.values()) / len(found), max(found.values())",
    "print(found, error_mean, error_worst)",
)


def whole_advice(advice: Advice) -> str:
    """A script that computes the whole advice again, of the candidates that were drawn, every setting spelled out."""
    drawn = {one.candidate for one in advice.outcomes}
    candidates = [one for one in advice.candidates if one.label in drawn]
    lines = ["import numpy as np"] * any(one.given for one in candidates)
    lines += ["import shadowlab as sl", "", advice.source.python, "cameras, lights = {}, {}"]
    for name, camera in {view.camera_label: view.camera for view in advice.views}.items():
        lines += [camera_python(camera), f"cameras[{name!r}] = camera"]
    for name, light in {view.light_label: view.light for view in advice.views}.items():
        lines += [light_python(light), f"lights[{name!r}] = light"]
    lines.append("advice = sl.advise(scene, cameras, lights, techniques={")
    for one in candidates:
        p = one.parameterization
        lines.append(f"    {one.label!r}: {given_python(p) if p is not None else f'sl.technique({one.text!r})'},")
    sizes = {view.size for view in advice.views}
    size = f" size={next(iter(sizes))}," if len(sizes) == 1 else ""
    lines += [
        f"}}, memory={list(advice.budgets)}, error={advice.measure.name!r}, over={advice.over!r},{size}",
        f"    renderer=sl.Renderer({advice.backend!r}),",
        f"    {reading_python(advice.read)}, phases={advice.phases})",
        "print(advice)",
    ]
    return "\n".join(lines) + "\n"


def measured_phases(of: Sequence[Outcome]) -> int:
    """The shifts of the texels over which the errors are means; 1 where they are those of the maps as fitted."""
    return max(int((one.numbers.get("phases") or 1) if one.sd is not None else 1) for one in of)


def snippet_of(advice: Advice, row: object) -> str:
    """The Python that computes a row of the table, a row of the runs, or a choice again.

    Raises
    ------
    ArgumentError
        For something that is no such row, or one without a number.
    """
    candidate, memory, label = row_key(advice, row)
    views = [view for view in advice.counted if label is None or view.label == label]
    of = [o for o in advice.outcomes if (o.candidate, o.memory) == (candidate, memory)]
    of = [o for o in of if o.view.label in {view.label for view in views}]
    if not of or any(o.error is None for o in of):
        reason = next((o.failure for o in of if o.failure), "nothing was measured")
        raise ArgumentError(f"row: expected one with a number, got one that failed: {reason}")
    chosen = next(one for one in advice.candidates if one.label == candidate)
    shifted = measured_phases(of)
    return advice_snippet(advice, chosen, int(of[0].resolution or 0), views, shifted)


def row_key(advice: Advice, row: object) -> tuple[str, int, str | None]:
    """Candidate, budget and view (None for all) of what stands for a row."""
    hint = "expected a row of .table or .runs, its position in .table, or a choice"
    if isinstance(row, (int, np.integer)) and not isinstance(row, (bool, np.bool_)):
        ranking = advice.standings
        if not 0 <= row < len(ranking):
            raise ArgumentError(f"row: expected a position from 0 to {len(ranking) - 1}, got {shown(row)}")
        return ranking[row].candidate, ranking[row].memory, None
    of: Any = row
    get: Any = of.get if has_all(row, "get") else lambda name: getattr(row, name, None)
    try:
        key = str(get("candidate") or get("technique")), int(get("memory")), get("view")
        if not (key[2] is None or isinstance(key[2], str)):
            raise TypeError("view is no text")
    except Exception:  # noqa: BLE001 - what callers give may raise whatever it likes
        raise ArgumentError(f"row: {hint}, got {shown(row)}") from None
    if key not in {(o.candidate, o.memory, v) for o in advice.outcomes for v in (None, o.view.label)}:
        raise ArgumentError(f"row: {hint}, got {key[0]!r} at {memory_text(key[1])}, which this advice does not have")
    return key


def advice_snippet(
    advice: Advice, candidate: Candidate, resolution: int, views: Sequence[LabelledView], phases: int
) -> str:
    """A script that computes the error of a candidate at a resolution in views, and prints it.

    With several `phases` the error is the mean over so many shifts of the texels.
    """
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
    if is_parameterization(candidate.item):
        lines += [f"p = {given_python(candidate.item)}"]
    else:
        lines.append(f"technique = sl.technique({candidate.text!r})")
    lines += ["found = {}", "for label, (camera, light, size) in views.items():"]
    samples = ", samples=samples" if getattr(candidate.item, "needs_samples", False) else ""
    body: list[str] = []
    if phases > 1:
        made = "p" if candidate.given else "technique"
        lines += [
            f"    run = sl.evaluate(sl.View(scene, camera, light, size), {made}, {resolution},",
            '        metrics=["misclassified"], renderer=renderer,',
            f"        {reading_python(advice.read)}, phases={phases})",
            '    found[label] = run.numbers["misclassified_mean"] / run.numbers["compared"]',
        ]
        return "\n".join([*lines, *SUMMED]) + "\n"
    if not of_errors:
        body.append("gbuffer = renderer.gbuffer(scene, camera, size=size)")
    if samples and not candidate.given:
        body.append("samples = sl.View(scene, camera, light, size).samples(renderer=renderer)")
    if not candidate.given:
        body.append(f"p = technique.parameterize(scene, camera, light, resolution={resolution}{samples})")
    if of_errors:
        body += [
            f"mask = renderer.shadow_mask(scene, camera, light, p, resolution={resolution}, size=size,",
            f"    {reading_python(reading(candidate.item, *advice.read))})",
            "errors = sl.aliasing.misclassified(mask, sl.trace.shadow_mask(scene, camera, light, size=size))",
        ]
    else:
        body.append(f"summary = sl.aliasing.footprint(gbuffer, camera, light, p, resolution={resolution}).summary()")
    body.append(f"found[label] = {advice.measure.python}")
    lines += [f"    {line}" for line in body]
    return "\n".join([*lines, *SUMMED]) + "\n"
