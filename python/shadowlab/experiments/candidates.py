"""One candidate in one view with one budget: the maps that fit, what they get wrong, and the row of it.

The number of maps may depend on the view, and in principle on their resolution. The memory is what an application sets
aside once, so the resolution is that at which the maps of the view that needs most fit: all views are parameterized
first, and again at the resolution found, until none needs more maps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

from .. import _core
from ..errors import ArgumentError, ShadowlabError
from ..techniques.kinds import is_parameterization
from ..techniques.labels import labelled, name_of, spec_of
from .evaluate import evaluate, fitted
from .measures import Measure
from .memory import side_of, taken, too_small
from .metrics import METRICS
from .run import Run
from .tried import default_techniques
from .views import LabelledView

if TYPE_CHECKING:
    from ..techniques.variant import MapReading
    from ..types import Item, RendererLike, Techniques

T = TypeVar("T")

# What is parameterized with to learn the number of maps.
FIRST_TEXELS = 1024
# What every outcome is measured by; texels that nobody reads cost more than all else and rank nothing.
RANKED_METRICS = tuple(name for name in METRICS if name != "usage")


@dataclass(frozen=True)
class Candidate:
    """A technique that is ranked.

    Attributes
    ----------
    label : str
        Its name in tables.
    text : str
        What makes it again as `sl.technique(text)`; of matrices that are in no file only a name.
    item : Technique, Preset or Parameterization
    """

    label: str
    text: str
    item: Item = field(repr=False)

    @property
    def given(self) -> bool:
        """Whether it is matrices made for one view, not a technique that makes them."""
        return is_parameterization(self.item)

    @property
    def parameterization(self) -> _core.Parameterization | None:
        """The matrices of one that is given."""
        return self.item if is_parameterization(self.item) else None

    @property
    def technique(self) -> str:
        """The name of the technique behind it."""
        return name_of(self.item)

    @property
    def settings(self) -> Mapping[str, Any]:
        """All its settings."""
        return dict(self.item.settings)


@dataclass(frozen=True)
class Draw:
    """How all are drawn."""

    renderer: RendererLike
    read: MapReading
    measure: Measure


@dataclass(frozen=True)
class Outcome:
    """A candidate in a view with a budget; numbers are None where nothing was measured, `failure` says why.

    `error` and its `variance` are of the measure that is ranked by; `sd` is the standard deviation of the error where
    the texels shift, None where that was not counted.
    """

    candidate: str
    technique: str
    text: str
    memory: int
    view: LabelledView
    maps: int | None = None
    resolution: int | None = None
    error: float | None = None
    variance: float = 0.0
    sd: float | None = None
    numbers: Mapping[str, float | None] = field(default_factory=dict, hash=False)
    notes: tuple[_core.Note, ...] = ()
    failure: str = ""
    run: Run | None = None

    def row(self) -> dict[str, Any]:
        """The row of `Advice.runs`."""
        size = None if self.maps is None or self.resolution is None else taken(self.maps, self.resolution)
        view = self.view
        return {
            "scene": view.view.scene_name, "view": view.label, "camera": view.camera_label,
            "light": view.light_label, "light_angle": view.light_angle, "light_elevation": view.light_elevation,
            "technique": self.candidate, "spec": self.text, "memory": self.memory, "maps": self.maps,
            "resolution": self.resolution, "bytes": size, "error": self.error, "error_sd": self.sd, **self.numbers,
            "notes": "; ".join(map(str, self.notes)), "failure": self.failure,
        }  # fmt: skip


def candidates_of(techniques: Techniques | None, views: Sequence[LabelledView]) -> list[Candidate]:
    """The candidates, none twice.

    Raises
    ------
    ArgumentError
        For none, two under one label, something that is no technique, or matrices for several views.
    UnknownNameError
        For a technique that does not exist.
    """
    kinds = {view.light.kind: view.light for view in views}
    single = next(iter(kinds.values())) if len(kinds) == 1 else None
    if techniques is None:
        techniques = default_techniques(kinds)
    found = [Candidate(label, spec_of(label, item), item) for label, item in labelled(techniques, single)]
    for one in found:
        if one.given and len(views) > 1:
            raise ArgumentError(
                f"techniques: {one.label!r} is matrices made for one view, there are {len(views)}; give a technique, "
                "or one camera and one light"
            )
    return found


@dataclass(frozen=True)
class BudgetPlan:
    """A candidate with a budget: the side of its maps, and how many there are in each view or why there are none."""

    candidate: Candidate
    memory: int
    side: int
    most: int
    of_views: tuple[tuple[int, str], ...]


def planned(
    draw: Draw,
    candidates: Sequence[Candidate],
    views: Sequence[LabelledView],
    budgets: Sequence[int],
    step: Callable[[str], None],
) -> list[BudgetPlan]:
    """The plans of all candidates with all budgets; `step` is called with the name of each candidate's."""
    plans: list[BudgetPlan] = []
    for one in candidates:
        step(f"fits of {one.label}")
        plans += plans_of(draw, one, views, budgets)
    return plans


def plans_of(
    draw: Draw, candidate: Candidate, views: Sequence[LabelledView], budgets: Sequence[int]
) -> list[BudgetPlan]:
    """The largest maps of a candidate that fit into each budget in the view that needs most of them."""

    def counts(side: int) -> list[tuple[int, str]]:
        made = [attempt(lambda v=v: fitted(candidate.item, v.view, side, draw.renderer)) for v in views]  # type: ignore[misc]
        return [(0 if p is None else len(p.matrices), failure) for p, failure in made]

    first = counts(FIRST_TEXELS)
    plans = []
    for memory in budgets:
        most = max(count for count, _ in first)
        side = side_of(memory, most) if most else 0
        of_views = first
        while side:
            of_views = counts(side)
            needed = max(max(count for count, _ in of_views), 0) or most
            if needed <= most:
                break
            most, side = needed, side_of(memory, needed)
        plans.append(BudgetPlan(candidate, memory, side, most, tuple(of_views)))
    return plans


def outcomes_of(
    draw: Draw, plans: Sequence[BudgetPlan], views: Sequence[LabelledView], step: Callable[[str], None]
) -> tuple[list[Outcome], dict[str, float]]:
    """All plans in all views, in the order of the plans; and by label the share of each picture that shows a surface.

    One view after the other is evaluated, so that its G-buffer and truth are at hand for all of them.
    """
    of_view: list[list[Outcome]] = []
    filled: dict[str, float] = {}
    for i, view in enumerate(views):
        step(f"eye view, {view.label}")
        filled[view.label] = view.view.filled(draw.renderer)
        step(f"truth, {view.label}")
        view.view.truth()
        outcomes = []
        for plan in plans:
            step(f"{plan.candidate.label}, {view.label}")
            outcomes.append(outcome(draw, plan, view, *plan.of_views[i]))
        of_view.append(outcomes)
    return [outcome for of_plan in zip(*of_view, strict=True) for outcome in of_plan], filled


def outcome(draw: Draw, plan: BudgetPlan, view: LabelledView, maps: int, failure: str) -> Outcome:
    """What a candidate with a budget gives in a view. An error of ours becomes its `failure`."""
    one = plan.candidate
    blank = Outcome(one.label, one.technique, one.text, plan.memory, view)
    if failure:
        return replace(blank, failure=failure)
    if not plan.side:
        return replace(blank, maps=plan.most, failure=too_small(plan.memory, plan.most))
    run = evaluate(
        view.view, one.item, plan.side, metrics=RANKED_METRICS, renderer=draw.renderer, label=one.label,
        **draw.read._asdict(),
    )  # fmt: skip
    found = replace(blank, maps=maps, resolution=plan.side, run=run, notes=run.notes)
    if run.failure:
        return replace(found, failure=run.failure)
    error = draw.measure.of(run)
    variance = 0.0 if error is None else draw.measure.variance(error, run.numbers.get(draw.measure.population) or 0)
    return replace(found, error=error, variance=variance, numbers=run.numbers)


def attempt(make: Callable[[], T]) -> tuple[T | None, str]:
    """What a call gives, or None and why it fails."""
    try:
        return make(), ""
    except ShadowlabError as error:
        return None, str(error)
