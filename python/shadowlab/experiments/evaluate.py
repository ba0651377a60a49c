"""One technique at one resolution in one view: the only evaluator.

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

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, cast

from .. import _core
from ..conventions.doubts import doubt_about
from ..errors import ShadowlabError, UnsupportedError
from ..scene.view import View, checked_view, light_of
from ..techniques.kinds import is_parameterization
from ..techniques.labels import name_of, resolved
from ..techniques.variant import reading
from ..text.checked import a_flag, a_text, has_all
from ..text.checks import check_bias, check_filter, checked_blend, checked_stored, renderer_of, whole
from .columns import COLUMNS
from .drawing import Drawing
from .timing import best_of, median_us

if TYPE_CHECKING:
    from ..types import Cull, Filter, Item, RendererArgument, RendererLike, TechniqueArgument, TechniqueLike

from .metrics import DRAWN, HELD_AGAINST_TRUTH, METRICS, Metric, checked_metrics
from .phases import checked_phases
from .run import Run


def evaluate(
    view: View,
    technique: TechniqueArgument,
    resolution: int = 1024,
    *,
    metrics: Sequence[Metric] = METRICS,
    renderer: RendererArgument = None,
    filter: Filter = "nearest",
    bias: _core.Bias | None = None,
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
    timing: bool = False,
    label: str | None = None,
    phases: int = 1,
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
        One of `sl.filters()`, with its settings.
    bias : Bias, optional
        ``Bias()`` where none is given.
    blend : float
        The last share of each map's range over which the next map's light is mixed in, as of `Renderer.shadow_mask`.
        Causes of wrong pixels are those of the map that makes them wrong.
    stored : Stored or str, optional
        What the maps store; the nearest depth as it is where none is given. What a technique says itself of `bias`,
        `filter`, `mix` and `stored`, such as "lispsm:stored=back", goes before all four arguments: they are for
        techniques that say nothing.
    timing : bool
        Whether to repeat what is timed: the median of many fits, the shortest of several draws and look-ups. Without
        it the times are those of one call each, which scatter.
    label : str, optional
        Its name in tables; the technique's own where none is given.
    phases : int
        Shifts of the texels, each by less than a texel, over which wrong pixels are counted; see `Run.over_phases`.
        1 counts those of the map as fitted alone.

    Returns
    -------
    Run
        What the technique cannot do with this scene or light is its `failure`. Of several lights, counts and times
        add up, lengths are those of the worst light, and `parts` has the run of each.

    Raises
    ------
    ArgumentError
        For arguments of another type, a resolution or phases that are not a whole number above 0, and several phases
        without a metric that holds the mask against the truth.
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
    checked_view(view), a_flag("timing", timing)
    if label is not None:
        a_text("label", label)
    item = resolved(technique, "technique")
    check_filter(filter)
    check_bias(bias)
    made_label = label if label is not None else technique if isinstance(technique, str) else name_of(item)
    how = (item, whole("resolution", resolution), checked_metrics(metrics), renderer_of(renderer))
    lookup = reading(item, bias, filter, checked_blend(blend), checked_stored(stored))
    checked_phases(phases)
    if isinstance(view.light, tuple) and HELD_AGAINST_TRUTH & set(how[2]):
        # Traced together they share the rays from the eye. Where that fails, each run says why.
        with suppress(ShadowlabError):
            view.truth()
    runs = [_measured(one, made_label, *how, *lookup, timing) for one in view.views]
    run = runs[0] if not isinstance(view.light, tuple) else _together(view, runs)
    return run if phases == 1 else run.over_phases(phases)


def fitted(item: Item, view: View, resolution: int, renderer: RendererLike) -> _core.Parameterization:
    """The matrices of a technique in a view; those that are given stay."""
    return _fitted(item, view, resolution, samples_for(item, view, renderer))


def samples_for(item: Item, view: View, renderer: RendererLike) -> _core.Samples | None:
    """The pixels that are compared, made once for a view; None for techniques that do not look at receivers."""
    if is_parameterization(item) or not getattr(item, "needs_samples", False):
        return None
    return cast("_core.Samples", view.samples(renderer=renderer))


def _fitted(item: Item, view: View, resolution: int, samples: _core.Samples | None) -> _core.Parameterization:
    if is_parameterization(item):
        return item
    # What holds maps carries none from view to view.
    holder: Any = item
    fresh = cast("TechniqueLike", holder.fresh() if has_all(item, "fresh") else item)
    seen = {} if samples is None else {"samples": samples}
    return fresh.parameterize(view.scene, view.camera, light_of(view), resolution=resolution, **seen)


def _measured(
    view: View, label: str, item: Item, resolution: int, metrics: tuple[Metric, ...], renderer: RendererLike,
    bias: _core.Bias, filter: Filter, blend: float, stored: _core.Stored, timing: bool,
) -> Run:  # fmt: skip
    """The run of a view with one light; an error of ours becomes its `failure`."""
    head = (view, label, item, resolution, metrics, bias, filter, renderer.backend, renderer.adapter)
    known: dict[str, Any] = {"blend": blend, "stored": stored}
    try:
        numbers: dict[str, float | None] = {}
        samples = samples_for(item, view, renderer)
        if samples is not None:
            numbers["samples_ms"] = view.samples_ms(renderer)
        p, fit_us = median_us(lambda: _fitted(item, view, resolution, samples), timing)
        known["parameterization"] = p
        if samples is not None:
            numbers["outside_shadow"] = samples.outside(p)[1]
        if is_parameterization(item):
            known["doubt"] = doubt_about(p.matrices, light_of(view), view.gbuffer(renderer), p.partitions)
        else:
            numbers["fit_us"] = fit_us
        drawing = Drawing(view, renderer, p, resolution, bias, filter, blend, stored)
        if DRAWN & set(metrics):
            view.gbuffer(renderer)  # likewise
            # Causes are probed in whole maps; of others nothing but the mask is read.
            cull: Cull = "volume" if "causes" in metrics else "seen"
            numbers["map_ms"] = best_of(lambda: drawing.draw(cull), timing)
            numbers["lookup_ms"] = best_of(drawing.look_up, timing)
        if HELD_AGAINST_TRUTH & set(metrics):
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
        return Run(*head, **known, failure=str(error), failure_type=type(error).__name__, refusal=refusal)
    run = Run(*head, **known, summary=summary, values=tuple(numbers.items()))
    object.__setattr__(run, "_drawing", drawing)
    return run


def _together(view: View, runs: Sequence[Run]) -> Run:
    """The run of several lights."""
    first = runs[0]
    failure = "; ".join(f"{run.view.label}: {run.failure}" for run in runs if run.failure)
    kinds = dict.fromkeys(run.failure_type for run in runs if run.failure)
    numbers: dict[str, float | None] = {}
    for name in dict.fromkeys(name for run in runs for name in run.numbers):
        values = [value for run in runs if (value := run.numbers.get(name)) is not None]
        how = COLUMNS[name].over_lights
        if values and how in ("sum", "max"):
            numbers[name] = sum(values) if how == "sum" else max(values)
    if compared := numbers.get("compared"):
        numbers["share"] = (numbers["misclassified"] or 0) / compared
    head = (first.item, first.resolution, first.metrics, first.bias, first.filter, first.backend, first.adapter)
    found = () if failure else tuple(numbers.items())
    return Run(
        view,
        first.label,
        *head,
        values=found,
        failure=failure,
        failure_type=", ".join(kinds),
        parts=tuple(runs),
        blend=first.blend,
        stored=first.stored,
    )
