"""One technique at one resolution: how it is run, measured and timed, and the row of the table that it gives."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from ..aliasing.causes import CAUSES, causes_of, depths_of
from ..aliasing.footprint import footprint_of
from ..conventions.doubts import CHECK_MATRIX, notes_on
from ..errors import ShadowlabError
from ..techniques.labels import is_parameterization as is_parameterization
from ..text import settings_text

T = TypeVar("T")

COLUMNS = (
    "technique", "settings", "resolution", "maps", "misclassified", "false_shadow", "false_light", "share", "compared",
    "undecided", "unmatched", *CAUSES.values(), "edge_px", "undersampled", "error_mean", "error_p95",
    "error_max", "perspective_max", "storage_factor", "unused", "fit_us", "render_ms", "mask_ms", "notes", "failure",
)  # fmt: skip
COUNTS = (
    "resolution", "maps", "misclassified", "false_shadow", "false_light", "compared", "undecided", "unmatched",
    *CAUSES.values(),
)  # fmt: skip
NUMBERS = (
    "share", "edge_px", "undersampled", "error_mean", "error_p95", "error_max", "perspective_max", "storage_factor",
    "unused", "fit_us", "render_ms", "mask_ms",
)  # fmt: skip

# A fit takes microseconds: this many repeats, or as many as fit into the budget, give a steady median.
FIT_REPEATS = 200
FIT_BUDGET_S = 0.1
# The best of a few runs is what the machine can do; slow maps are drawn once.
RENDER_REPEATS = 3
RENDER_BUDGET_S = 1.0


@dataclass(frozen=True, eq=False)
class Run:
    """One technique at one resolution: a row of the table with its pictures. What failed holds None and the reason."""

    label: str
    technique: str
    settings: Mapping[str, Any]
    resolution: int
    given: bool  # a matrix from elsewhere, not made by a technique of ours
    parameterization: Any = None
    maps: np.ndarray | None = None
    mask: np.ndarray | None = None
    chosen: np.ndarray | None = None  # which of several maps each pixel asks
    errors: Any = None
    causes: Any = None  # why the wrong pixels are wrong
    summary: Any = None  # of the footprint of a texel at every pixel
    unused: float | None = None  # share of the texels that no pixel reads
    fit_us: float | None = None
    render_ms: float | None = None
    mask_ms: float | None = None
    doubts: tuple[str, ...] = ()  # what speaks against a matrix from elsewhere
    failure: str = ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What the technique did where it could not do as told, and what speaks against a given matrix."""
        own = () if self.parameterization is None else tuple(self.parameterization.notes)
        return (*own, f"{CHECK_MATRIX}{'; '.join(self.doubts)}") if self.doubts else own

    def row(self) -> dict[str, Any]:
        """The row of the table; None where nothing was measured."""
        errors, causes, summary = self.errors, self.causes, self.summary
        moved = None if causes is None else causes.edge_distance
        measured = summary is not None and summary.measured > 0
        return {
            "technique": self.label,
            "settings": settings_text(self.settings),
            "resolution": self.resolution,
            "maps": None if self.parameterization is None else len(self.parameterization.matrices),
            "misclassified": None if errors is None else int(errors.count),
            "false_shadow": None if errors is None else int(errors.false_shadow),
            "false_light": None if errors is None else int(errors.false_light),
            "share": None if errors is None else float(errors.fraction),
            "compared": None if errors is None else int(errors.compared),
            "undecided": None if errors is None else int(errors.undecided),
            "unmatched": None if errors is None else int(errors.unmatched),
            **{name: None if causes is None else causes.counts[name] for name in CAUSES.values()},
            "edge_px": None if moved is None else moved["mean"],
            "undersampled": summary.undersampled if measured else None,
            "error_mean": summary.mean if measured else None,
            "error_p95": summary.percentiles[95] if measured else None,
            "error_max": summary.max if measured else None,
            "perspective_max": summary.perspective_max if measured else None,
            "storage_factor": summary.storage_factor if measured else None,
            "unused": self.unused,
            "fit_us": self.fit_us,
            "render_ms": self.render_ms,
            "mask_ms": self.mask_ms,
            "notes": "; ".join(self.notes),
            "failure": self.failure,
        }


class ByRun(Mapping[Any, Any]):
    """What the runs that succeeded have, by (label, resolution), or by label alone in a study of one resolution."""

    def __init__(self, arrays: Mapping[tuple[str, int], Any]):
        self._arrays = dict(arrays)

    def __getitem__(self, key: Any) -> Any:
        found = [key] if key in self._arrays else [k for k in self._arrays if k[0] == key]
        if len(found) != 1:
            keys = ", ".join(map(repr, self._arrays)) or "none"
            raise KeyError(f"{key!r}: expected one of {keys}")
        return self._arrays[found[0]]

    def __iter__(self) -> Iterator[tuple[str, int]]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        def short(value: Any) -> str:
            return f"{value.shape} {value.dtype}" if isinstance(value, np.ndarray) else repr(value)

        return f"{{{', '.join(f'{k!r}: {short(v)}' for k, v in self._arrays.items())}}}"


@dataclass(frozen=True, eq=False)
class Draw:
    """What all runs of a study share."""

    scene: Any
    camera: Any
    light: Any
    renderer: Any
    size: tuple[int, int]
    bias: Any
    filter: str
    gbuffer: Any
    truth: np.ndarray | None

    @cached_property
    def depth(self) -> np.ndarray:
        """Depths along the view (H, W), world units."""
        return depths_of(self.gbuffer, self.camera)


def run_one(draw: Draw, label: str, item: Any, resolution: int) -> Run:
    """One row of the study; an error of ours becomes its `failure`."""
    from .. import aliasing

    given = is_parameterization(item)
    name = item.technique if given else f"preset:{item.name}" if hasattr(item, "engine") else item.name
    settings = dict(item.settings)
    known: dict[str, Any] = {}
    try:
        if given:
            known["parameterization"] = p = item
            warps = [part.post_warp_terms for part in p.partitions]
            known["doubts"] = tuple(notes_on(p.matrices, draw.light, draw.gbuffer, warps))
        else:
            # The very pixels that are compared, for techniques that look at receivers.
            samples = {"samples": draw.gbuffer} if getattr(item, "needs_samples", False) else {}

            def fit() -> Any:
                return item.parameterize(draw.scene, draw.camera, draw.light, resolution=resolution, **samples)

            known["parameterization"] = p = fit()
            known["fit_us"] = median_fit_us(fit)
        known["maps"], known["render_ms"] = best_of(
            lambda: draw.renderer.shadow_map(draw.scene, p, resolution=resolution)
        )
        known["mask"], known["mask_ms"] = best_of(
            lambda: draw.renderer.shadow_mask(
                draw.scene, draw.camera, draw.light, p,
                resolution=resolution, size=draw.size, bias=draw.bias, filter=draw.filter,
            )
        )  # fmt: skip
        if len(p.matrices) > 1 and hasattr(draw.renderer, "chosen_map"):
            known["chosen"] = draw.renderer.chosen_map(
                draw.scene, draw.camera, draw.light, p, resolution=resolution, size=draw.size
            )
        if draw.truth is not None:
            known["errors"] = errors = aliasing.misclassified(known["mask"], draw.truth)
            known["causes"] = causes_of(
                draw.scene, draw.camera, draw.light, p, errors, draw.truth, draw.gbuffer, known["maps"], draw.bias,
                draw.filter, draw.depth,
            )  # fmt: skip
        seen = (draw.gbuffer, draw.camera, draw.light, p)
        known["summary"] = footprint_of(*seen, resolution).summary()
        known["unused"] = aliasing.usage(*seen, resolution=resolution, filter=draw.filter).unused
    except ShadowlabError as error:
        kept = {key: known[key] for key in ("parameterization", "doubts") if key in known}
        return Run(label, name, settings, resolution, given, **kept, failure=str(error))
    return Run(label, name, settings, resolution, given, **known)


def median_fit_us(fit: Callable[[], Any]) -> float:
    """The median time of a call, in microseconds."""
    durations: list[float] = []
    end = time.perf_counter() + FIT_BUDGET_S
    while len(durations) < FIT_REPEATS and (not durations or time.perf_counter() < end):
        start = time.perf_counter()
        fit()
        durations.append(time.perf_counter() - start)
    return 1e6 * statistics.median(durations)


def best_of(draw: Callable[[], T]) -> tuple[T, float]:
    """What a call returns and its shortest time, in milliseconds."""
    best, spent, result = float("inf"), 0.0, None
    for _ in range(RENDER_REPEATS):
        start = time.perf_counter()
        result = draw()
        elapsed = time.perf_counter() - start
        best, spent = min(best, elapsed), spent + elapsed
        if spent > RENDER_BUDGET_S:
            break
    return result, 1e3 * best  # type: ignore[return-value]
