"""One candidate in one view with one budget: the maps that fit, what they get wrong, and the row of it.

The number of maps may depend on the view, and in principle on their resolution. The memory is what an application sets
aside once, so the resolution is that at which the maps of the view that needs most fit: all views are parameterized
first, and again at the resolution found, until none needs more maps.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from .. import aliasing
from ..aliasing.causes import CAUSES
from ..conventions.doubts import CHECK_MATRIX, notes_on
from ..errors import ArgumentError, ShadowlabError
from ..techniques.labels import is_parameterization, labelled
from ..techniques.registry import technique_of
from ..text import format_spec
from .measures import Measure
from .memory import side_of, taken, too_small
from .views import View

T = TypeVar("T")

# What is parameterized with to learn the number of maps.
FIRST_TEXELS = 1024
COLUMNS = (
    "candidate", "technique", "memory", "view", "camera", "light", "light_angle", "light_elevation", "maps",
    "resolution", "bytes", "error", "misclassified", "share", "false_shadow", "false_light", "compared", "undecided",
    *CAUSES.values(), "major_max", "major_p95", "major_mean", "undersampled", "perspective_max", "storage_factor",
    "measured", "outside", "fit_us", "map_ms", "mask_ms", "notes", "failure",
)  # fmt: skip
COUNTS = (
    "memory", "maps", "resolution", "bytes", "misclassified", "false_shadow", "false_light", "compared", "undecided",
    *CAUSES.values(), "measured", "outside",
)  # fmt: skip
TEXTS = ("candidate", "technique", "view", "camera", "light", "notes", "failure")


@dataclass(frozen=True, eq=False)
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
    item: Any = field(repr=False)

    @property
    def given(self) -> bool:
        """Whether it is matrices made for one view, not a technique that makes them."""
        return is_parameterization(self.item)

    @property
    def parameterization(self) -> Any:
        """The matrices of one that is given."""
        return self.item if self.given else None

    @property
    def technique(self) -> str:
        """The name of the technique behind it."""
        return str(self.item.technique if self.given else self.item.name)

    @property
    def settings(self) -> Mapping[str, Any]:
        """All its settings."""
        return dict(self.item.settings)

    def parameterize(self, scene: Any, seen: Seen, resolution: int) -> Any:
        """Its maps in a view."""
        if self.given:
            return self.item
        samples = {"samples": seen.gbuffer} if getattr(self.item, "needs_samples", False) else {}
        return self.item.parameterize(scene, seen.view.camera, seen.view.light, resolution=resolution, **samples)


@dataclass(frozen=True, eq=False)
class Seen:
    """A view with what the camera sees and the traced truth."""

    view: View
    gbuffer: Any
    truth: np.ndarray

    @property
    def filled(self) -> float:
        """The share of the pixels that show anything."""
        return float(np.mean(np.asarray(self.gbuffer.triangle) >= 0))


@dataclass(frozen=True, eq=False)
class Draw:
    """How all are drawn."""

    scene: Any
    renderer: Any
    bias: Any
    filter: str
    measure: Measure


@dataclass(frozen=True, eq=False)
class Outcome:
    """A candidate in a view with a budget; numbers are None where nothing was measured, `failure` says why."""

    candidate: str
    technique: str
    text: str
    memory: int
    view: View
    maps: int | None = None
    resolution: int | None = None
    error: float | None = None
    variance: float = 0.0
    numbers: Mapping[str, Any] = field(default_factory=dict)
    notes: str = ""
    failure: str = ""

    def row(self) -> dict[str, Any]:
        """The row of `Advice.runs`."""
        size = None if self.maps is None or self.resolution is None else taken(self.maps, self.resolution)
        view = self.view
        return {
            **dict.fromkeys(COLUMNS),
            "candidate": self.candidate, "technique": self.text, "memory": self.memory, "view": view.label,
            "camera": view.camera_label, "light": view.light_label, "light_angle": view.light_angle,
            "light_elevation": view.light_elevation, "maps": self.maps, "resolution": self.resolution, "bytes": size,
            "error": self.error, **self.numbers, "notes": self.notes, "failure": self.failure,
        }  # fmt: skip


def candidates_of(techniques: Any, views: Sequence[View]) -> list[Candidate]:
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
    found = [Candidate(label, text_of(label, item), item) for label, item in labelled(techniques, single)]
    for one in found:
        if one.given and len(views) > 1:
            raise ArgumentError(
                f"techniques: {one.label!r} is matrices made for one view, there are {len(views)}; give a technique, "
                "or one camera and one light"
            )
    return found


def text_of(label: str, item: Any) -> str:
    """What makes a technique again: its label where that does, else all its settings; of matrices always the label."""
    if is_parameterization(item):
        return label
    name = f"preset:{item.name}" if hasattr(item, "engine") else str(item.name)
    again, _ = attempt(lambda: technique_of(label))
    same = again is item or (
        again is not None and not is_parameterization(again)
        and (again.name, dict(again.settings)) == (item.name, dict(item.settings))
    )  # fmt: skip
    return label if same else format_spec(name, dict(item.settings))


def default_techniques(kinds: Mapping[str, Any]) -> list[str]:
    """What is ranked where nobody says: uniform, the warps that engines ship, and depth splits of both."""
    from .. import _core

    warp = "lispsm:near=optimal"
    splits = [f"z_partition:count={n}" for n in (2, 3, 4)]
    names = ["uniform", "lispsm", warp, "tsm", *splits, *(f"{one},inner=({warp})" for one in splits)]
    lights = {spec["name"]: set(spec["lights"]) for spec in _core.technique_specs()}
    return [name for name in names if set(kinds) <= lights[name.partition(":")[0]]]


def run_candidate(
    draw: Draw, candidate: Candidate, views: Sequence[Seen], budgets: Sequence[int], step: Callable[[str], None]
) -> list[Outcome]:
    """All budgets and views of a candidate. An error of ours becomes a `failure`."""

    def fit(seen: Seen, side: int) -> tuple[Any, str]:
        return attempt(lambda: candidate.parameterize(draw.scene, seen, side))

    first = [fit(seen, FIRST_TEXELS) for seen in views]
    outcomes = []
    for memory in budgets:
        maps = max((len(p.matrices) for p, _ in first if p is not None), default=0)
        side = side_of(memory, maps) if maps else 0
        made = first
        while side:
            made = [fit(seen, side) for seen in views]
            most = max((len(p.matrices) for p, _ in made if p is not None), default=maps)
            if most <= maps:
                break
            maps, side = most, side_of(memory, most)
        for seen, (p, failure) in zip(views, made, strict=True):
            step(f"{candidate.label}, {seen.view.label}")
            blank = Outcome(candidate.label, candidate.technique, candidate.text, memory, seen.view)
            if p is None:
                outcomes.append(replace(blank, failure=failure))
            elif not side:
                outcomes.append(replace(blank, maps=maps, failure=too_small(memory, maps)))
            else:
                outcomes.append(
                    run_view(draw, candidate, seen, p, replace(blank, maps=len(p.matrices), resolution=side))
                )
    return outcomes


def attempt(make: Callable[[], T]) -> tuple[T | None, str]:
    """What a call gives, or None and why it fails."""
    try:
        return make(), ""
    except ShadowlabError as error:
        return None, str(error)


def run_view(draw: Draw, candidate: Candidate, seen: Seen, p: Any, blank: Outcome) -> Outcome:
    """The outcome with what these maps give in a view."""
    view, side = seen.view, blank.resolution or 0
    notes = [*p.notes]
    looks = (seen.gbuffer, view.camera, view.light, p)
    how = {"bias": draw.bias, "filter": draw.filter}
    numbers: dict[str, Any] = {}
    try:
        if candidate.given:
            doubts = notes_on(p.matrices, view.light, seen.gbuffer, [part.post_warp_terms for part in p.partitions])
            notes += [f"{CHECK_MATRIX}{'; '.join(doubts)}"] if doubts else []
        else:
            _, fit_ms = timed(lambda: candidate.parameterize(draw.scene, seen, side))
            numbers["fit_us"] = 1e3 * fit_ms
        images, numbers["map_ms"] = timed(lambda: draw.renderer.shadow_map(draw.scene, p, resolution=side))
        mask, numbers["mask_ms"] = timed(
            lambda: draw.renderer.shadow_mask(
                draw.scene, view.camera, view.light, p, resolution=side, size=view.size, **how
            )
        )
        errors = aliasing.misclassified(mask, seen.truth)
        why = aliasing.causes(
            draw.scene, view.camera, view.light, p, mask, seen.truth, gbuffer=seen.gbuffer, maps=images, **how
        )
        footprint = aliasing.footprint(*looks, resolution=side)
        summary = footprint.summary(bands=1)
    except ShadowlabError as failure:
        return replace(blank, notes="; ".join(notes), failure=str(failure))
    numbers |= {
        "misclassified": int(errors.count), "share": float(errors.fraction) if errors.compared else None,
        "false_shadow": int(errors.false_shadow), "false_light": int(errors.false_light),
        "compared": int(errors.compared), "undecided": int(errors.undecided), **why.counts,
        "major_max": summary.max, "major_p95": (summary.percentiles or {}).get(95), "major_mean": summary.mean,
        "undersampled": summary.undersampled, "perspective_max": summary.perspective_max,
        "storage_factor": summary.storage_factor, "measured": summary.measured,
        "outside": footprint.counts()["held by no map"],
    }  # fmt: skip
    error = draw.measure.of(errors, summary)
    variance = 0.0 if error is None else draw.measure.variance(error, numbers.get(draw.measure.population, 0))
    return replace(blank, error=error, variance=variance, numbers=numbers, notes="; ".join(notes))


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """What a call gives and its milliseconds, once."""
    start = time.perf_counter()
    result = call()
    return result, 1e3 * (time.perf_counter() - start)
