"""The checks of a configuration, carried out: the value of each bounded column, and whether its bound holds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..experiments.columns import COLUMNS
from ..text import digits, is_missing, share_text
from .check_config import PATH_COLUMNS, Bound, Gate
from .check_path import item_of_frames
from .command import Options
from .options import lookup_given, size_given
from .view import load_part, load_view

if TYPE_CHECKING:
    from .._core import Camera
    from ..scene.scenes import Scene
    from ..scene.view import View
    from ..types import Item, RendererLike

# What a missing value means where nothing of its kind was found: no edge is displaced, so none is by any distance.
ZERO_WITHOUT = {"edge_px": "edge"}


@dataclass(frozen=True)
class BoundOutcome:
    """What became of one bound on one technique.

    Attributes
    ----------
    check, technique : str
    resolution : int
    bound : Bound
    value : float or None
        None where there is none.
    failure : str
        Why the technique has no numbers; empty where it has.
    seconds : float
        What measuring took, shared equally among the bounds on the technique.
    """

    check: str
    technique: str
    resolution: int
    bound: Bound
    value: float | None
    failure: str
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether the bound holds; one without a value does not."""
        return self.value is not None and self.bound.holds(self.value)

    @property
    def value_text(self) -> str:
        """The value as people read it."""
        if self.value is None:
            return "–"
        if COLUMNS[self.bound.column].unit == "share":
            return share_text(self.value)
        return f"{self.value:,.0f}" if float(self.value).is_integer() else digits(self.value)

    @property
    def complaint(self) -> str:
        """What is wrong; empty where the bound holds."""
        if self.failure:
            return self.failure
        if self.value is None:
            return f"{self.bound.column}: expected {self.bound.text}, got no value: nothing of it was seen in this view"
        return (
            "" if self.holds else f"{self.bound.column}: expected {self.bound.text}, got {self.bound.said(self.value)}"
        )


class Scenes:
    """The scenes of a configuration, each loaded once."""

    def __init__(self) -> None:
        self._loaded: dict[tuple[str, str | None], Scene] = {}

    def of(self, options: Options) -> Scene:
        """The scene of a view, without a floor."""
        key = options.scene, options.up
        if key not in self._loaded:
            self._loaded[key] = load_part(options)
        return self._loaded[key]


def bound_outcomes(check: Gate, scenes: Scenes, renderer_of: Callable[[str], RendererLike]) -> Iterator[BoundOutcome]:
    """The outcomes of a check, technique by technique; `renderer_of` gives the renderer of a backend.

    Raises
    ------
    ArgumentError
        For a scene, camera or light that cannot be used, with file and line.
    """
    from ..scene.view import View

    options, table = check.options, check.table
    with table.naming("scene" if "scene" in table else None):
        part = scenes.of(options)
    with table.naming(None):
        size = size_given(options)
        scene, camera, light, _ = load_view(options, size, part)
        if check.camera is not None:
            cameras = check.camera.cameras(check.path)
        elif check.path is not None:
            cameras = check.path.cameras(camera, options.up or "y")
        else:
            cameras = [camera]
        view = View(scene, cameras[0], light, size)
        read = lookup_given(options)
        renderer = renderer_of(options.backend)
        items = {label: item_of_frames(text, cameras, check.path) for label, text in check.techniques.items()}
    for label, item in items.items():
        begun = time.perf_counter()
        values, failure = columns_of_view(check, view, label, item, read, renderer)
        if not failure and check.path is not None and any(bound.column in PATH_COLUMNS for bound in check.bounds):
            of_path, failure = columns_of_path(check, view, cameras, label, item, read, renderer)
            values = {**of_path, **values}
        seconds = (time.perf_counter() - begun) / len(check.bounds)
        for bound in check.bounds:
            value = None if failure else value_of_bound(bound, values)
            yield BoundOutcome(check.name, label, check.resolution, bound, value, failure, seconds)


def columns_of_view(
    check: Gate, view: View, label: str, item: Item, read: Mapping[str, Any], renderer: RendererLike
) -> tuple[dict[str, Any], str]:
    """The columns of a technique in the view, and why there are none."""
    from ..experiments.evaluate import evaluate

    run = evaluate(
        view, item, check.resolution, metrics=check.metrics, renderer=renderer, label=label, phases=check.phases, **read
    )
    return run.row(), run.failure


def columns_of_path(
    check: Gate, view: View, cameras: Sequence[Camera], label: str, item: Item, read: Mapping[str, Any],
    renderer: RendererLike,
) -> tuple[dict[str, Any], str]:  # fmt: skip
    """The columns of a camera path, each with the values of all its steps, and why there are none."""
    from ..experiments.temporal import temporal

    found = temporal(
        view.scene, cameras, view.light, {label: item}, resolution=check.resolution, size=view.size, renderer=renderer,
        bias=read["bias"], filter=read["filter"],
    )  # fmt: skip
    failures = [failure for failure in found.table["failure"] if failure]
    return {name: list(found.table[name]) for name in PATH_COLUMNS}, failures[0] if failures else ""


def value_of_bound(bound: Bound, values: Mapping[str, Any]) -> float | None:
    """The value that a bound is held against, None where there is none: of a path that of the step worst for it."""
    value = values.get(bound.column)
    if value is None and bound.column in ZERO_WITHOUT and values.get(ZERO_WITHOUT[bound.column]) == 0:
        return 0.0
    steps: list[Any] = value if isinstance(value, list) else [value]
    if any(map(is_missing, steps)):
        return None
    known = [float(one) for one in steps]
    # Of a bound on both sides the step that breaks it, if one does.
    broken = [one for one in known if not bound.holds(one)]
    return (broken or [max(known) if bound.most is not None else min(known)])[0]
