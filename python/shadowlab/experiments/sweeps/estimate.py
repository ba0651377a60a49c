"""How long a sweep will take, and the memory of a process: weights of all runs, scaled by a few that are timed."""

from __future__ import annotations

import time
from dataclasses import dataclass

from ...errors import ArgumentError
from ...scene.view import GBUFFER_BYTES_PER_PIXEL
from ...text.checked import a_count, instance
from ..memory import taken
from .plan import Plan, cost_of, cost_of_view
from .work import Request, Task, answer_to, prepare

# Of Python with numpy and pandas, and of a scene in the core: vertices, faces and the hierarchy of rays.
PROCESS_BYTES, TRIANGLE_BYTES = 120 << 20, 120
# Of a run: mask, chosen map, difference; of texels in the picture 14 numbers in f32 more.
RUN_BYTES_PER_PIXEL = 60
MOST_TIMED = 1000
A_PLAN = instance(Plan, "a Plan", "plan_of(space) makes one")


@dataclass(frozen=True)
class Estimate:
    """What a sweep is thought to take, in this process.

    Attributes
    ----------
    seconds : float or None
        Of all runs, those that were timed among them; None where none was timed.
    bytes : int
        Most memory of a process.
    timed : int
        How many runs were timed.
    """

    seconds: float | None
    bytes: int
    timed: int


def estimate(plan: Plan, timed: int = 3) -> Estimate:
    """Seconds and bytes of a sweep, by timing a few of its runs.

    Parameters
    ----------
    plan : Plan
    timed : int
        Runs that are timed, spread from the one thought to be the quickest to the slowest; 0 for none.

    Returns
    -------
    Estimate

    Raises
    ------
    ArgumentError
        For something that is no plan, and a number out of range.

    Examples
    --------
    >>> from shadowlab.experiments.sweeps.estimate import estimate
    >>> from shadowlab.experiments.sweeps.plan import plan_of
    >>> plan = plan_of({"scene": "@robots", "technique": ["uniform", "lispsm"]}, size=(160, 90), renderer="cpu")
    >>> estimate(plan).timed
    2
    """
    A_PLAN("plan", plan)
    count = a_count(0, MOST_TIMED)("timed", timed)
    runs = [(row.view, row.request) for row in plan.rows if row.request is not None]
    costs = [cost_of(plan.views[view], request, plan.metrics) for view, request in runs]
    views = sorted({view for view, _ in runs})
    of_views = {view: cost_of_view(plan.views[view]) for view in views}
    chosen = spread(costs, count)
    seconds: float | None = None if runs else 0.0
    if chosen:
        task = Task(plan.metrics, plan.functions, plan.renderer)
        run_s, run_cost, view_s, view_cost = 0.0, 0.0, 0.0, 0.0
        for view in dict.fromkeys(runs[i][0] for i in chosen):
            start = time.perf_counter()
            for request in (runs[i][1] for i in chosen if runs[i][0] == view):
                prepare(plan.views[view].view, task, request)
            view_s, view_cost = view_s + time.perf_counter() - start, view_cost + of_views[view]
        for i in chosen:
            view, request = runs[i]
            start = time.perf_counter()
            answer_to(plan.views[view].view, request, task)
            run_s, run_cost = run_s + time.perf_counter() - start, run_cost + costs[i]
        seconds = sum(costs) * run_s / run_cost + sum(of_views.values()) * view_s / view_cost
    return Estimate(seconds, bytes_of_plan(plan, [request for _, request in runs]), len(chosen))


def spread(costs: list[float], count: int) -> list[int]:
    """So many places of the costs, evenly from the least to the largest."""
    order = sorted(range(len(costs)), key=costs.__getitem__)
    if len(order) <= count:
        return order
    if count == 1:
        return [order[len(order) // 2]]
    return [order[round(i * (len(order) - 1) / (count - 1))] for i in range(count)]


def bytes_of_plan(plan: Plan, requests: list[Request]) -> int:
    """Most memory of a process: the scenes, the pictures of a view, and the maps of a run."""
    scenes = {id(view.view.scene): view.view.scene.triangle_count for view in plan.views}
    pixels = max((view.size[0] * view.size[1] for view in plan.views), default=0)
    lights = max((len(view.view.lights) for view in plan.views), default=1)
    maps = max((bytes_of_maps(request) for request in requests), default=0)
    each = pixels * (GBUFFER_BYTES_PER_PIXEL + lights * RUN_BYTES_PER_PIXEL)
    return PROCESS_BYTES + TRIANGLE_BYTES * sum(scenes.values()) + each + lights * maps


def bytes_of_maps(request: Request) -> int:
    """What the maps of a run take; of several in a technique, as many as its settings say."""
    if request.memory is not None:
        return request.memory
    if request.resolution is None:
        raise ArgumentError("request: expected a resolution or a memory, got neither")
    count = request.item.settings.get("count", 1)
    return taken(count if isinstance(count, int) else 1, request.resolution)
