"""One technique at one resolution in one view: the only evaluator, and the row of a table that it gives.

```
    View, technique, resolution
      |  fit          matrices                        fit_us
      |  draw         maps                            map_ms
      |  look up      the light at every pixel        lookup_ms
      v
    metrics, those that are asked for: misclassified, causes, texels, usage
```
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast, get_args

from .. import _core
from ..aliasing.causes import CAUSES
from ..conventions.doubts import doubt_about
from ..errors import ArgumentError, ShadowlabError, UnknownNameError, UnsupportedError
from ..scene.source import Source
from ..scene.view import View, light_of
from ..techniques.labels import is_parameterization, resolved, spec_of
from ..text import settings_text, shown
from ..text.checks import check_bias, check_filter, renderer_of, whole
from .columns import COLUMNS
from .drawing import Drawing
from .memory import BYTES_PER_TEXEL
from .timing import best_of, median_us

T = TypeVar("T")

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .._core import Misclassified
    from ..aliasing.causes import Causes
    from ..aliasing.footprint import Footprint
    from ..aliasing.summary import Summary
    from ..aliasing.usage import Usage
    from ..types import Filter, Item, Mask, PerLight, RendererArgument, RendererLike, ShadowMaps, TechniqueArgument

Metric = Literal["mask", "misclassified", "causes", "texels", "usage"]
#: What is measured where nobody says. "mask" draws and looks up without holding the result against the truth.
METRICS: tuple[Metric, ...] = tuple(name for name in get_args(Metric) if name != "mask")
KNOWN_METRICS: tuple[Metric, ...] = get_args(Metric)
# Those that need maps.
DRAWN = frozenset({"mask", "misclassified", "causes"})


@dataclass(frozen=True, repr=False)
class Run:
    """A technique at a resolution in a view: its matrices, what was measured, and the reason where it failed.

    Numbers are held; arrays are made when they are asked for, kept while there is room, and drawn again after that.

    Attributes
    ----------
    view : View
    label : str
        The technique's name in tables.
    item : Technique, Preset or Parameterization
        What was evaluated.
    resolution : int
        Texels along each side of the maps.
    metrics : tuple of str
        What was measured.
    bias, filter
        As the pixels were looked up.
    backend, adapter : str
        Of the renderer.
    parameterization : Parameterization or None
        None where the technique failed to make it, and of several lights.
    summary : Summary or None
        Of the footprints of texels, with the metric "texels".
    values : tuple of (str, number)
        What was measured, by the names of columns; see `numbers`.
    doubt : Note or None
        What speaks against a matrix from elsewhere.
    failure : str
        Why there are no numbers; empty where there are.
    refusal : str
        Of a technique that refuses the light or the view, the failure without its name; else empty.
    parts : tuple of Run
        Of a view with several lights, the run of each.
    """

    view: View
    label: str
    item: Item
    resolution: int
    metrics: tuple[Metric, ...]
    bias: _core.Bias
    filter: Filter
    backend: str
    adapter: str
    parameterization: _core.Parameterization | None = None
    summary: Summary | None = field(default=None, compare=False)
    values: tuple[tuple[str, float | None], ...] = ()
    doubt: _core.Note | None = None
    failure: str = ""
    refusal: str = ""
    parts: tuple[Run, ...] = ()
    _drawing: Drawing | None = field(default=None, init=False, compare=False)

    @property
    def given(self) -> bool:
        """Whether it is matrices from elsewhere, not made by a technique."""
        return is_parameterization(self.item)

    @property
    def technique(self) -> str:
        """Name of the technique; "preset:NAME" of an engine's."""
        if is_parameterization(self.item):
            return str(self.item.technique)
        return f"preset:{self.item.name}" if hasattr(self.item, "engine") else str(self.item.name)

    @property
    def settings(self) -> Mapping[str, Any]:
        """All settings of the technique."""
        return dict(self.item.settings)

    @property
    def several(self) -> bool:
        """Whether there are several maps."""
        return self.parameterization is not None and len(self.parameterization.partitions) > 1

    @property
    def numbers(self) -> dict[str, float | None]:
        """What was measured, by the names of columns."""
        return dict(self.values)

    @property
    def notes(self) -> tuple[_core.Note, ...]:
        """What the technique could not do as asked, and what speaks against a given matrix.

        Of several lights, their maps are counted one after the other.
        """
        if self.parts:
            return _notes_of_parts(self.parts)
        own = () if self.parameterization is None else self.parameterization.notes
        return own if self.doubt is None else (*own, self.doubt)

    @property
    def maps(self) -> PerLight[ShadowMaps] | None:
        """Shadow maps (H, W) or (K, H, W) float32; None of a run that failed."""
        return self._of(lambda drawing: drawing.maps)

    @property
    def mask(self) -> PerLight[Mask] | None:
        """Light that arrives (H, W) float32; None of a run that failed."""
        return self._of(lambda drawing: drawing.mask)

    @property
    def chosen(self) -> PerLight[NDArray[np.int16]] | None:
        """Map that each pixel looks up (H, W) int16, -1 for none; None of a single map and of a run that failed."""
        return self._of(lambda drawing: drawing.chosen if self.several else None)

    @property
    def judged(self) -> bool:
        """Whether it was held against the truth."""
        return not self.failure and bool({"misclassified", "causes"} & set(self.metrics))

    @property
    def errors(self) -> PerLight[Misclassified] | None:
        """Where the mask and the truth disagree; None of a run that was not held against the truth."""
        return self._of(lambda drawing: drawing.errors) if self.judged else None

    @property
    def difference(self) -> PerLight[NDArray[np.int8]] | None:
        """Difference from the truth (H, W) int8: 0 agree, 1 false shadow, 2 false light, -1 not compared; or None."""
        return self._of(lambda drawing: drawing.errors.image) if self.judged else None

    @property
    def causes(self) -> PerLight[Causes] | None:
        """Why the wrong pixels are wrong; None where that was not asked for."""
        return self._of(lambda drawing: drawing.causes) if "causes" in self.metrics else None

    @property
    def footprint(self) -> PerLight[Footprint] | None:
        """Size of a texel at every pixel; None of a run that failed."""
        return self._of(lambda drawing: drawing.footprint)

    @property
    def usage(self) -> PerLight[Usage] | None:
        """How often each texel is read; None of a run that failed."""
        return self._of(lambda drawing: drawing.usage)

    def row(self) -> dict[str, Any]:
        """The row of a table, by the names of `columns.COLUMNS`; None where nothing was measured."""
        p, view = self.parameterization, self.view
        maps = sum(len(q.matrices) for part in self.parts or (self,) if (q := part.parameterization) is not None)
        known = bool(self.parts) or p is not None
        return {
            "scene": Source.of_scene(view.scene).name,
            "view": view.label,
            "light_angle": view.light_angle,
            "light_elevation": view.light_elevation,
            "technique": self.label,
            "spec": spec_of(self.label, self.item),
            "settings": settings_text(self.settings),
            "resolution": self.resolution,
            "maps": maps if known else None,
            "bytes": BYTES_PER_TEXEL * maps * self.resolution**2 if known else None,
            **dict.fromkeys(MEASURED),
            **self.numbers,
            "notes": "; ".join(map(str, self.notes)),
            "failure": self.failure,
        }

    def _of(self, what: Callable[[Drawing], T]) -> PerLight[T] | None:
        if self.parts:
            return tuple(part._of(what) for part in self.parts)
        return None if self.failure or self.parameterization is None else what(self._drawn())

    def _drawn(self) -> Drawing:
        if self._drawing is None:
            if self.adapter == ELSEWHERE:
                raise ArgumentError(
                    f"run: its pictures were drawn by a renderer of another kind ({self.backend}), which did not come "
                    "along; evaluate again with that renderer"
                )
            p = cast("_core.Parameterization", self.parameterization)
            drawing = Drawing(self.view, renderer_of(self.backend), p, self.resolution, self.bias, self.filter)
            object.__setattr__(self, "_drawing", drawing)
        return cast("Drawing", self._drawing)

    def __getstate__(self) -> dict[str, Any]:
        ours = self._drawing is None or isinstance(self._drawing.renderer, _core.Renderer)
        return {**self.__dict__, "_drawing": None, "adapter": self.adapter if ours else ELSEWHERE}

    def __repr__(self) -> str:
        head = f"Run({self.label} at {self.resolution}²"
        if self.failure:
            return f"{head}, failed: {self.failure})"
        wrong = self.numbers.get("misclassified")
        return f"{head}{'' if wrong is None else f', {wrong:,} wrong pixels'})"


# The adapter of a run whose renderer is not of this package and stayed in another process.
ELSEWHERE = "elsewhere"
# The columns that metrics and times fill.
MEASURED = (
    "misclassified", "false_shadow", "false_light", "share", "compared", "undecided", "unmatched", *CAUSES.values(),
    "edge_px", "measured", "outside", "undersampled", "texel_mean", "texel_p50", "texel_p95", "texel_p99", "texel_max",
    "perspective_max", "storage_factor", "unused", "fit_us", "map_ms", "lookup_ms",
)  # fmt: skip


def evaluate(
    view: View,
    technique: TechniqueArgument,
    resolution: int = 1024,
    *,
    metrics: Sequence[Metric] = METRICS,
    renderer: RendererArgument = None,
    filter: Filter = "nearest",
    bias: _core.Bias | None = None,
    timing: bool = False,
    label: str | None = None,
) -> Run:
    """A technique at a resolution in a view, measured: the unit of work of every experiment.

    Parameters
    ----------
    view : View
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it. Of a technique that looks at receivers, the pixels of the view are the samples.
    resolution : int
        Texels along each side of the maps.
    metrics : sequence of str
        What to measure, and nothing else: "misclassified" (wrong pixels against the traced truth), "causes" (why they
        are wrong), "texels" (size of texels in the picture), "usage" (texels that no pixel reads), "mask" (draw and
        look up only, for the times). None of them makes the matrices only.
    renderer : Renderer or str, optional
        "cpu", "gpu" or "auto" for the renderer of that name; the best there is where none is given.
    filter : str
        "nearest" or "pcf2x2".
    bias : Bias, optional
        ``Bias()`` where none is given.
    timing : bool
        Whether to repeat what is timed: the median of many fits, the shortest of several draws and look-ups. Without
        it the times are those of one call each, which scatter.
    label : str, optional
        Its name in tables; the technique's own where none is given.

    Returns
    -------
    Run
        What the technique cannot do with this scene or light is its `failure`. Of several lights, counts and times
        add up, lengths are those of the worst light, and `parts` has the run of each.

    Raises
    ------
    ArgumentError
        For arguments of another type, and a resolution that is not a whole number above 0.
    UnknownNameError
        For a technique, metric, filter or renderer that does not exist.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> run = sl.evaluate(view, "lispsm", 256, metrics=["misclassified"], renderer="cpu")
    >>> run.row()["misclassified"] == run.errors.count
    True
    """
    if not isinstance(view, View):
        raise ArgumentError(
            f"view: expected a View, got {type(view).__name__}; sl.View(scene, camera, light) makes one"
        )
    item = resolved(technique)
    check_filter(filter)
    check_bias(bias)
    made_label = label if label is not None else technique if isinstance(technique, str) else name_of(item)
    how = (item, whole("resolution", resolution), checked_metrics(metrics), renderer_of(renderer))
    lookup = (_core.Bias() if bias is None else bias, filter)
    runs = [_measured(one, made_label, *how, *lookup, timing) for one in view.views]
    return runs[0] if not isinstance(view.light, tuple) else _together(view, runs)


def done(value: T | None) -> T:
    """What a run has that succeeded.

    Raises
    ------
    ArgumentError
        Where there is none: of a run that failed, or was not held against the truth.
    """
    if value is None:
        raise ArgumentError("run: expected one that succeeded, got one that failed; its `failure` says why")
    return value


def name_of(item: Item) -> str:
    """The name of a technique that is no text."""
    return str(item.technique if is_parameterization(item) else item.name)


def checked_metrics(metrics: object) -> tuple[Metric, ...]:
    """The metrics, each once, in their order.

    Raises
    ------
    ArgumentError
        For something that is no list of names.
    UnknownNameError
        For a metric that does not exist.
    """
    listed = ", ".join(KNOWN_METRICS)
    if isinstance(metrics, str) or not isinstance(metrics, Sequence):
        raise ArgumentError(f"metrics: expected several of {listed}, got {shown(metrics)}; try ['misclassified']")
    for name in metrics:
        if name not in KNOWN_METRICS:
            raise UnknownNameError(f"metrics: unknown metric {shown(name)}; expected some of {listed}")
    return tuple(name for name in KNOWN_METRICS if name in metrics)


def fitted(item: Item, view: View, resolution: int, renderer: RendererLike) -> _core.Parameterization:
    """The matrices of a technique in a view; those that are given stay."""
    if is_parameterization(item):
        return item
    # The very pixels that are compared, for techniques that look at receivers.
    samples = {"samples": view.gbuffer(renderer)} if getattr(item, "needs_samples", False) else {}
    return item.parameterize(view.scene, view.camera, light_of(view), resolution=resolution, **samples)


def _measured(
    view: View, label: str, item: Item, resolution: int, metrics: tuple[Metric, ...], renderer: RendererLike,
    bias: _core.Bias, filter: Filter, timing: bool,
) -> Run:  # fmt: skip
    """The run of a view with one light; an error of ours becomes its `failure`."""
    head = (view, label, item, resolution, metrics, bias, filter, renderer.backend, renderer.adapter)
    known: dict[str, Any] = {}
    try:
        numbers: dict[str, float | None] = {}
        p, fit_us = median_us(lambda: fitted(item, view, resolution, renderer), timing)
        known["parameterization"] = p
        if is_parameterization(item):
            warps = [part.post_warp_terms for part in p.partitions]
            known["doubt"] = doubt_about(p.matrices, light_of(view), view.gbuffer(renderer), warps)
        else:
            numbers["fit_us"] = fit_us
        drawing = Drawing(view, renderer, p, resolution, bias, filter)
        if DRAWN & set(metrics):
            view.gbuffer(renderer)  # of the view and made once, so no part of the times
            numbers["map_ms"] = best_of(drawing.draw, timing)
            numbers["lookup_ms"] = best_of(drawing.look_up, timing)
        if "misclassified" in metrics or "causes" in metrics:
            numbers |= drawing.wrong_pixels()
        if "causes" in metrics:
            numbers |= drawing.cause_counts()
        summary = None
        if "texels" in metrics:
            summary, texels = drawing.texels()
            numbers |= texels
        if "usage" in metrics:
            numbers["unused"] = drawing.usage.unused
    except ShadowlabError as error:
        refusal = error.reason if isinstance(error, UnsupportedError) else ""
        return Run(*head, **known, failure=str(error), refusal=refusal)
    run = Run(*head, **known, summary=summary, values=tuple(numbers.items()))
    object.__setattr__(run, "_drawing", drawing)
    return run


def _notes_of_parts(parts: Sequence[Run]) -> tuple[_core.Note, ...]:
    """The notes of the runs of several lights: each with its maps among those of all lights."""
    found: dict[_core.Note, list[int]] = {}
    total = 0
    for part in parts:
        maps = 0 if part.parameterization is None else len(part.parameterization.partitions)
        for note in part.notes:
            own = range(maps) if note.maps is None else note.maps
            found.setdefault(note.about(None), []).extend(total + k for k in own)
        total += maps
    return tuple(note.about(maps if len(maps) < total else None) for note, maps in found.items())


def _together(view: View, runs: Sequence[Run]) -> Run:
    """The run of several lights."""
    first = runs[0]
    failure = "; ".join(f"{run.view.label}: {run.failure}" for run in runs if run.failure)
    numbers: dict[str, float | None] = {}
    for name in dict.fromkeys(name for run in runs for name in run.numbers):
        values = [value for run in runs if (value := run.numbers.get(name)) is not None]
        how = COLUMNS[name].over_lights
        if values and how:
            numbers[name] = sum(values) if how == "sum" else max(values)
    if compared := numbers.get("compared"):
        numbers["share"] = (numbers["misclassified"] or 0) / compared
    head = (first.item, first.resolution, first.metrics, first.bias, first.filter, first.backend, first.adapter)
    found = () if failure else tuple(numbers.items())
    return Run(view, first.label, *head, values=found, failure=failure, parts=tuple(runs))
