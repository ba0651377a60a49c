"""Which candidates an advice draws: all of them, or those that a prediction puts first.

```
    candidates, budgets                 plans: the largest maps that fit
      |  predict(view, technique)       wrong pixels without drawing, optional
      v
    the first `drawn`, and uniform      drawn, held against the truth, ranked
      |
      v
    the rest                            `Advice.untried`: nothing is said of them but the prediction
```
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, Protocol

from ..errors import ArgumentError, ShadowlabError
from ..text import shown
from ..text.checks import whole
from .candidates import BudgetPlan
from .predict import predict as ours
from .thresholds import BASELINE
from .tried import Untried
from .views import LabelledView

if TYPE_CHECKING:
    from .._core import Bias
    from ..scene.view import View
    from ..types import Item, RendererLike

# Candidates that are drawn with each budget, beside uniform, where all are predicted. Chosen because predictions are
# told apart from counts by tens of per cent, within which there are rarely more.
MOST_DRAWN = 8


class Predict(Protocol):
    """What foretells the wrong pixels of a technique in a view without drawing a map."""

    def __call__(self, view: View, technique: Item, *, resolution: int) -> float:
        """Wrong pixels; what raises an error of ours is drawn, so that its failure is told."""
        ...


def chosen_predict(
    predict: Predict | Literal["auto"] | None, renderer: RendererLike, bias: Bias, *, screens: bool
) -> Predict | None:
    """The prediction that is asked; "auto" is ours, with the bias of the maps, where candidates are screened."""
    if not isinstance(predict, str):
        return predict
    if predict != "auto":
        raise ArgumentError(f'predict: expected a function, "auto" or None, got {shown(predict)}')

    def foretold(view: View, technique: Item, *, resolution: int) -> float:
        return float(ours(view, technique, resolution, bias=bias, renderer=renderer))

    return foretold if screens else None


def checked_predict(predict: Predict | None, drawn: object) -> int:
    """How many are drawn.

    Raises
    ------
    ArgumentError
        For a prediction that cannot be called, and a number that is not a whole one above 0.
    """
    if predict is not None and not callable(predict):
        raise ArgumentError(
            f"predict: expected a function of (view, technique, *, resolution), got {shown(predict)}; None draws all"
        )
    return whole("drawn", drawn)


def shortlisted(
    plans: Sequence[BudgetPlan],
    views: Sequence[LabelledView],
    predict: Predict | None,
    drawn: int,
    step: Callable[[str], None],
) -> tuple[list[BudgetPlan], list[Untried]]:
    """The plans that are drawn, in their order, and the others with what was predicted of them.

    Where there is a prediction `step` is called with the name of each plan's.
    """
    if predict is None:
        return list(plans), []
    kept: set[int] = set()
    left: dict[int, Untried] = {}
    for memory in dict.fromkeys(plan.memory for plan in plans):
        known: list[tuple[float, int]] = []
        for i, plan in enumerate(plans):
            if plan.memory == memory:
                step(f"prediction of {plan.candidate.label}")
                uniform = plan.candidate.technique == BASELINE
                wrong = None if uniform else predicted(plan, views, predict)
                if wrong is None:
                    kept.add(i)
                else:
                    known.append((wrong, i))
        known.sort()
        kept |= {i for _, i in known[:drawn]}
        left |= {i: Untried(plans[i].candidate.label, "predicted", (), memory, n) for n, i in known[drawn:]}
    return [plan for i, plan in enumerate(plans) if i in kept], [left[i] for i in sorted(left)]


def predicted(plan: BudgetPlan, views: Sequence[LabelledView], predict: Predict) -> float | None:
    """The predicted wrong pixels of a plan over all views; None where there is no map, or no prediction."""
    if not plan.side or any(failure for _, failure in plan.of_views):
        return None
    try:
        return sum(float(predict(one.view, plan.candidate.item, resolution=plan.side)) for one in views)
    except ShadowlabError:
        return None
