"""A sweep in this process: one run after the other, over the threads of the core."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .work import Answer, Group, Task, answer_to, prepare


def run_here(
    groups: Sequence[Group], task: Task, add: Callable[[Answer], None], step: Callable[[str], None] = lambda _: None
) -> None:
    """Adds the answer of every run; `step` is called before each with what it is."""
    for i, group in enumerate(groups):
        for request in group.requests:
            step(f"{group.view.label}, {request.label}")
            prepare(group.view, task, request)
            add(answer_to(group.view, request, task))
        if i + 1 < len(groups):
            # Pictures of views that are done would only take room.
            group.view.clear()
