"""Which technique at which resolution, with how many splits, at equal memory: ranked over cameras and lights.

Each candidate gets the largest square maps that fit into the budget, is drawn in every view and held against traced
truth, and measured by the footprint of its texels. The numbers of every run are in `Advice.runs`, what they come to in
`Advice.table`, and `Advice.reproduce` gives the Python that computes any row of either again.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ..errors import ArgumentError, UnknownNameError, UnsupportedError
from ..scene.source import Source
from ..text import shown
from ..text.checks import renderer_of
from ..travel import Value
from .arguments import check_types, size_of
from .candidates import Candidate, Draw, Outcome, candidates_of, outcomes_of, planned
from .choice import Choice, Gain, choice_of, gains
from .columns import table
from .counts import WrongPixels, most_unjudged
from .measures import ErrorName, Measure, Over, measure_of, over_of
from .memory import DEFAULT_MEMORY, budgets_of, bytes_of, memory_text
from .noise import outcomes_with_noise
from .phases import PHASES, checked_phases
from .progress import Steps
from .ranking import Standing, counted_views, standings, switches
from .screening import MOST_DRAWN, Predict, checked_predict, chosen_predict, shortlisted
from .tried import Untried, untried_of
from .views import LabelledView, views_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from .._core import Bias, Camera, GBuffer, Scene
    from ..types import Filter, Labelled, Light, RendererArgument, RendererLike, Techniques


@dataclass(frozen=True, eq=False, repr=False)
class Advice(Value):
    """The result of `advise`: who is best at equal memory, where that switches, and the numbers behind it.

    Attributes
    ----------
    table : DataFrame
        One row per candidate and budget, best first within each budget: maps, resolution (texels), bytes,
        unused_memory (share of the memory), error_mean and error_worst over the views (in the measure's unit), the
        noise of the one ranked by (`error_sd`), the view of the worst, ratios to the best and to uniform at equal
        memory, whether it is about equal to the best, and `failure`.
    runs : DataFrame
        One row a candidate, budget and view with all numbers: the error, wrong pixels and their causes, lengths of
        texels (`texel_max`, `texel_p95`, `texel_mean`, pixels), `undersampled` (share), `storage_factor`, times of one
        run each; light_angle and light_elevation in radians. `outside` counts the pixels that no map holds.
    switches : DataFrame
        Where the winner changes, along views by light angle, or along budgets: `from` is the last one before the new
        winner is about equal to the best, `to` the first one where the old winner no longer is, and from `equal_from`
        to `equal_to` both are (NaN where `from` and `to` are neighbours). With both winners' errors at both
        (`other_from` is the error of `winner_to` at `from`).
    gains : list of Gain
        With each budget the best warp or split drawn beside uniform, and whether it has less error.
    unjudged : float
        Largest share of the visible pixels of a view that is undecided or not compared.
    untried : tuple of Untried
        The techniques of `sl.techniques()` and the candidates that were not drawn, and why.
    verdict : str
        What the tables say, in plain English.
    """

    outcomes: tuple[Outcome, ...] = field(repr=False)
    candidates: tuple[Candidate, ...]
    views: tuple[LabelledView, ...]
    budgets: tuple[int, ...]
    measure: Measure
    over: Over
    scene: Scene = field(repr=False)
    bias: Bias
    filter: Filter
    backend: str
    adapter: str
    filled: Mapping[str, float]
    source: Source
    untried: tuple[Untried, ...] = ()
    phases: int = PHASES
    renderer: RendererLike | None = field(default=None, repr=False, compare=False)

    @property
    def standings(self) -> list[Standing]:
        """The rows of the table as objects."""
        return standings(self.outcomes, self.over)

    @property
    def table(self) -> pd.DataFrame:
        """One row per candidate and budget."""
        return table("advise", [{"scene": self.source.name, **one.row()} for one in self.standings])

    @property
    def runs(self) -> pd.DataFrame:
        """One row per candidate, budget and view."""
        return table("advise.runs", [one.row() | {"scene": self.source.name} for one in self.outcomes])

    @property
    def switches(self) -> pd.DataFrame:
        """One row per change of winner."""
        return table("advise.switches", switches(self.outcomes, self.standings))

    @property
    def verdict(self) -> str:
        """What the tables say."""
        return " ".join(self.sentences)

    @property
    def sentences(self) -> list[str]:
        """The sentences of the verdict, the most important one first."""
        from ..reports.advice_verdict import advice_sentences

        ranking = self.standings
        changed = switches(self.outcomes, ranking)
        views = self.outcomes, self.measure, self.over, self.filled
        return advice_sentences(ranking, changed, *views, untried=self.untried)

    @property
    def gains(self) -> list[Gain]:
        """What warps and splits gain over uniform, with each budget."""
        return gains(self.standings)

    @property
    def unjudged(self) -> float:
        """Largest share of the visible pixels of a view that no run could compare."""
        return most_unjudged(WrongPixels.of(o.numbers) for o in self.outcomes if o.error is not None)

    @property
    def best(self) -> Choice:
        """The candidate with the least error over all views, of all budgets; of equal ones in the least memory.

        Raises
        ------
        UnsupportedError
            Where no candidate gave a number.
        """
        return self.best_for()

    def best_for(self, *, view: str | None = None, memory: int | str | None = None) -> Choice:
        """The candidate with the least error in a view, with a budget, or both.

        Parameters
        ----------
        view : str, optional
            A label of `views`; all views where none is given.
        memory : int or str, optional
            One of the budgets; any of them where none is given.

        Raises
        ------
        UnknownNameError
            For a view or budget that the advice does not have; the message lists those it has.
        UnsupportedError
            Where no candidate gave a number.
        """
        if view is not None and view not in (names := [one.label for one in self.views]):
            raise UnknownNameError(f"view: unknown view {shown(view)}; expected one of {', '.join(map(repr, names))}")
        budgets = self.budgets
        if memory is not None:
            if (wanted := bytes_of(memory)) not in budgets:
                listed = ", ".join(memory_text(one) for one in budgets)
                raise UnknownNameError(f"memory: no budget of {memory_text(wanted)}; expected one of {listed}")
            budgets = (wanted,)
        of = self.outcomes if view is None else [one for one in self.outcomes if one.view.label == view]
        found = choice_of(standings(of, self.over), self.candidates, budgets, view)
        if found is None:
            raise UnsupportedError(f"no candidate gave a number: {self.verdict}")
        return found

    @property
    def counted(self) -> list[LabelledView]:
        """The views that count: those in which something could be measured."""
        labels = counted_views(self.outcomes)
        return [view for view in self.views if view.label in labels]

    def gbuffer(self, view: str) -> GBuffer:
        """What the camera of the view of this label sees."""
        (found,) = (one.view for one in self.views if one.label == view)
        return found.gbuffer(renderer_of(self.backend if self.renderer is None else self.renderer))

    def reproduce(self, row: int | pd.Series[Any] | Mapping[str, Any] | Choice) -> str:
        """The Python that computes a row again.

        Parameters
        ----------
        row : int, Series, mapping or Choice
            A row of `table` (or its position there), a row of `runs`, or a choice.

        Raises
        ------
        ArgumentError
            For something that is no row of this advice, and rows without a number.
        """
        from ..reports.reproduce_advice import snippet_of

        return snippet_of(self, row)

    def figure(self) -> Figure:
        """A matplotlib figure: the error over the views with the least and the largest budget, and over memory."""
        from ..plot.advice import advice_figure

        return advice_figure(self)

    def save(self, directory: str | Path) -> Path:
        """Writes report.html (stands alone), advice.csv, runs.csv, switches.csv, advice.json and advice.png.

        Returns
        -------
        Path
            Of report.html.

        Raises
        ------
        ArgumentError
            Where the directory cannot be made or written.
        """
        from ..reports.html.advice import save_advice

        if not isinstance(directory, (str, os.PathLike)):
            raise ArgumentError(f'directory: expected a path, got {shown(directory)}; try "advice"')
        return save_advice(self, Path(directory))

    def _repr_html_(self) -> str:
        from ..reports.advice_record import advice_html

        return advice_html(self)

    def __repr__(self) -> str:
        from ..reports.terminal import advice_table

        head = (
            f"Advice by {self.measure.title} ({self.over} of {len(self.views)} view{'s' * (len(self.views) > 1)}): "
            f"{len(self.candidates)} candidates at {', '.join(map(memory_text, self.budgets))} on {self.backend}"
        )
        return f"{head}\n{advice_table(self.standings, self.measure)}\n{self.verdict}"


def advise(
    scene: Scene,
    cameras: Labelled[Camera],
    lights: Labelled[Light],
    *,
    memory: float | str | Iterable[float | str] = DEFAULT_MEMORY,
    techniques: Techniques | None = None,
    error: ErrorName = "misclassified",
    over: Over = "mean",
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    phases: int = PHASES,
    predict: Predict | Literal["auto"] | None = "auto",
    drawn: int = MOST_DRAWN,
    progress: bool = True,
    source: Source | None = None,
) -> Advice:
    """Which technique, at which resolution and with how many splits, is best at equal memory, and where that switches.

    Parameters
    ----------
    scene : Scene
    cameras : Camera, sequence of them, or dict
        A dict gives each its label.
    lights : DirectionalLight, SpotLight or PointLight, sequence of them, or dict
        Every camera is taken with every light. Without labels lights are called by their elevation and their angle to
        the view. Of one kind, best: lights of several kinds share the resolution of that with most maps.
    memory : int, str, or several
        Bytes of depth texels, 4 each: a number, "4 MiB" (2^20), "16 MB" (10^6). Each candidate gets the largest square
        maps of whole texels that fit in the view where it has most of them; the table has what that leaves unused.
        4 MiB where none is given: one map of 1024 x 1024 texels, the default of `compare` and `evaluate`.
    techniques : sequence or dict, optional
        As of `compare`. Every technique that serves all lights, with its settings that matter (`tried.SETTINGS`), where
        none are given: 2, 3 and 4 depth splits of uniform and of LiSPSM among them. Matrices serve a single view.
    error : str
        What is ranked by: "misclassified" (share of the compared pixels that are wrong), or of the length of a texel
        in the image "worst" (one pixel decides it: "p95" is the one to use), "p95", "mean" (pixels), "undersampled"
        (share), "perspective" (pixels).
    over : str
        How views are put together: "mean" or "worst".
    size : (int, int), optional
        Pixels of the picture, of every camera. About 1024 * 1024 of the camera's aspect where none is given.
    renderer : Renderer or str, optional
        As of `compare`.
    bias : Bias, optional
    filter : str
        "nearest" or "pcf2x2".
    phases : int
        Shifts of the texels by parts of a texel over which wrong pixels are counted, of the candidates alone between
        which the verdict has to decide; 1 for none. Their `error` is the mean. Texel lengths have no such noise.
    predict : callable, "auto" or None
        ``predict(view, technique, *, resolution)`` foretells wrong pixels without drawing. With each budget the
        `drawn` candidates that it puts first are drawn, beside uniform. "auto" is `shadowlab.predict` where no
        techniques are named and wrong pixels are ranked by; None draws all.
    drawn : int
        Candidates drawn with each budget where there is a prediction.
    progress : bool
        Whether to show a progress bar, on terminals and in notebooks.
    source : Source, optional
        Where the scene came from; see `shadowlab.Source`.

    Returns
    -------
    Advice

    Raises
    ------
    ArgumentError
        For arguments of another type, no view, no candidate, a memory that is no number or holds no map, matrices for
        several views. All before any work.
    UnknownNameError
        For an error, technique, filter, renderer or unit that does not exist. What a technique cannot do with this
        scene or a light is told in its rows.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> lights = {"noon": sl.DirectionalLight((0.1, -1, 0.1)), "evening": sl.DirectionalLight((-1, -0.2, 0.3))}
    >>> advice = sl.advise(scene, scene.camera, lights, memory="64 KiB", techniques=["uniform", "lispsm"],
    ...     size=(160, 90), renderer="cpu", progress=False)
    >>> advice.best.candidate
    'lispsm'
    """
    from .._core import Bias, Camera, DirectionalLight

    # Cameras and lights are checked one by one, with the names that they have here.
    check_types(scene, Camera.look_at((0, 0, 1), (0, 0, 0)), DirectionalLight((0, -1, 0)), bias, filter)
    measure, over = measure_of(error), over_of(over)
    checked_phases(phases)
    named = techniques is not None
    budgets = budgets_of(memory)
    views = views_of(scene, cameras, lights, lambda camera: size_of(size, camera))
    candidates = candidates_of(techniques, views)
    renderer = renderer_of(renderer)
    bias = Bias() if bias is None else bias
    draw = Draw(renderer, bias, filter, measure)
    foretell = chosen_predict(predict, renderer, screens=not named and bool(measure.population))
    drawn = checked_predict(foretell, drawn)
    plans, worse = shortlisted(planned(draw, candidates, views, budgets), views, foretell, drawn)
    with Steps(len(views) * (2 + len(plans)), progress) as step:
        outcomes, filled = outcomes_of(draw, plans, views, step)
    if measure.population:
        with Steps(len(outcomes), progress) as step:
            outcomes = outcomes_with_noise(outcomes, over, phases, step)
    untried = [*untried_of({one.technique for one in candidates}, {view.light.kind for view in views}), *worse]
    return Advice(
        tuple(outcomes), tuple(candidates), tuple(views), tuple(budgets), measure, over, scene, bias, filter,
        renderer.backend, renderer.adapter, filled,
        source or Source.of_scene(scene), tuple(untried), phases, renderer,
    )  # fmt: skip
