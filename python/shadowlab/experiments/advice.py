"""The result of `advise`: candidates at equal memory, ranked over views, and what that comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from .._core import Stored
from ..errors import UnknownNameError, UnsupportedError
from ..scene.source import Source
from ..techniques.variant import MapReading
from ..text import shown
from ..text.checked import a_path, a_text
from ..text.checks import renderer_of
from ..text.progress import checked_progress
from ..travel import Value
from .candidates import Candidate, Outcome
from .choice import Choice, Gain, choice_of, gains
from .columns import table
from .counts import WrongPixels, most_unjudged
from .measures import Measure, Over
from .memory import bytes_of, memory_text
from .phases import PHASES
from .ranking import Standing, counted_views, standings, switches
from .tried import Untried
from .views import LabelledView

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from .._core import Bias, GBuffer, Scene
    from ..scene.view import View
    from ..types import Filter, RendererLike


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
    bias: Bias
    filter: Filter
    backend: str
    adapter: str
    filled: Mapping[str, float]
    source: Source
    untried: tuple[Untried, ...] = ()
    phases: int = PHASES
    renderer: RendererLike | None = field(default=None, repr=False, compare=False)
    blend: float = 0.0
    stored: Stored = field(default_factory=Stored)

    STATE_VERSION: ClassVar[int] = 2

    @property
    def scene(self) -> Scene:
        """The scene of all views."""
        return self.views[0].view.scene

    @property
    def read(self) -> MapReading:
        """How the maps of techniques were read that do not say it themselves."""
        return MapReading(self.bias, self.filter, self.blend, self.stored)

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
        if view is not None:
            self._view(view)
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
        return self._view(view).gbuffer(renderer_of(self.backend if self.renderer is None else self.renderer))

    def _view(self, label: str) -> View:
        """The view of a label.

        Raises
        ------
        ArgumentError, UnknownNameError
            For what is no text, and a label that no view has.
        """
        found = [one.view for one in self.views if one.label == a_text("view", label)]
        if not found:
            names = ", ".join(repr(one.label) for one in self.views)
            raise UnknownNameError(f"view: unknown view {shown(label)}; expected one of {names}")
        return found[0]

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

    def save(self, directory: str | Path, *, progress: bool | None = None) -> Path:
        """Writes report.html (stands alone), advice.csv, runs.csv, switches.csv, advice.json and advice.png.

        A progress bar shows on terminals and in notebooks unless `progress` is off.

        Returns
        -------
        Path
            Of report.html.

        Raises
        ------
        ArgumentError
            Where the directory cannot be made or written.
        LoadError
            Of a loaded one, where its scene cannot be made again.
        """
        from ..reports.html.advice import save_advice

        return save_advice(self, a_path("directory", directory), checked_progress(progress))

    @classmethod
    def load(cls, path: str | Path, *, scene: Scene | None = None) -> Advice:
        """The advice that `save` wrote; as of `Study.load`.

        Parameters
        ----------
        path : path
            The directory, or its advice.json.
        scene : Scene, optional
            The scene of the advice, for one that has no recipe, or whose file is elsewhere now.

        Returns
        -------
        Advice
            Equal to the one that was saved.

        Raises
        ------
        LoadError, StateError, ArgumentError
            As of `Study.load`.
        """
        from ..reports.saved import load_result

        return load_result(cls, a_path("path", path), scene)

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
