"""The result of `compare`: the runs of techniques side by side, and what they come to."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..conventions.doubts import doubts_in
from ..errors import UnknownNameError
from ..scene.source import Source
from ..scene.view import View, light_of
from ..techniques.variant import MapReading
from ..text.checked import a_path, a_text
from ..text.checks import renderer_of, whole
from ..text.progress import checked_progress
from ..travel import Value
from .by_run import ByRun
from .columns import table
from .counts import Comparison, WrongPixels, against_uniform, most_unjudged, relation
from .records import records
from .run import Run

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from ..aliasing.causes import Causes
    from ..aliasing.footprint import Footprint
    from ..aliasing.summary import Summary
    from ..aliasing.usage import Usage
    from ..types import Filter, Light, Mask, RendererLike, ShadowMaps


@dataclass(frozen=True, eq=False, repr=False)
class Study(Value):
    """The result of `compare`: a table, pictures, and what they say.

    Attributes
    ----------
    table : DataFrame
        One row a technique and resolution; `failure` says why a row has no numbers.
    truth : (H, W) int8 or None
        1 lit, 0 in shadow, -1 undecided, -2 nothing.
    masks, maps, differences : mapping
        Per run, by (label, resolution), or by label alone where the study has one resolution: the shadow mask (H, W)
        float32, the shadow map (H, W) or (K, H, W) float32, and the difference from the truth (H, W) int8 (0 agree,
        1 false shadow, 2 false light, -1 not compared).
    chosen : mapping
        Of runs with several maps: which of them each pixel asks (H, W) int16; -1 for none.
    causes : mapping
        Of runs held against the truth: why each wrong pixel is wrong, `aliasing.Causes`.
    summaries : mapping
        How large a texel is in the image, `aliasing.Summary`; `footprint` gives the image behind it.
    verdict : str
        What the table says, in plain English.
    """

    runs: tuple[Run, ...]
    view: View = field(repr=False)
    bias: _core.Bias
    filter: Filter
    backend: str
    adapter: str
    source: Source
    traced: bool = True
    renderer: RendererLike | None = field(default=None, repr=False, compare=False)
    blend: float = 0.0
    stored: _core.Stored = field(default_factory=_core.Stored)

    @property
    def read(self) -> MapReading:
        """How the maps of techniques were read that do not say it themselves."""
        return MapReading(self.bias, self.filter, self.blend, self.stored)

    @property
    def lookup(self) -> str:
        """How the maps were read: the filter, over which share of their ranges maps blend, and what they store."""
        return self.read.lookup

    @property
    def scene(self) -> _core.Scene:
        """The scene."""
        return self.view.scene

    @property
    def camera(self) -> _core.Camera:
        """The camera."""
        return self.view.camera

    @property
    def light(self) -> Light:
        """The light."""
        return light_of(self.view)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the eye view, pixels."""
        return self.view.size

    @property
    def gbuffer(self) -> _core.GBuffer:
        """What the camera sees."""
        return self.view.gbuffer(self._draw)

    @property
    def truth(self) -> NDArray[np.int8] | None:
        """The traced truth (H, W) int8; None of a study without it."""
        return self.view.truth() if self.traced else None

    @cached_property
    def truth_ms(self) -> float | None:
        """Milliseconds that tracing the truth took; None of a study without it."""
        return self.view.truth_ms if self.traced else None

    @property
    def table(self) -> pd.DataFrame:
        """The numbers, one row per run."""
        return self._table.copy()

    @cached_property
    def _table(self) -> pd.DataFrame:
        return table("compare", self._rows)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The rows of the table as dicts of plain values, None where nothing was measured; made without pandas."""
        return [dict(row) for row in self._rows]

    @cached_property
    def _rows(self) -> list[dict[str, Any]]:
        return records("compare", [run.row() | {"scene": self.source.name} for run in self.runs])

    @property
    def masks(self) -> ByRun[Mask]:
        """Shadow masks (H, W) float32."""
        return self._by_run("mask")

    @property
    def maps(self) -> ByRun[ShadowMaps]:
        """Shadow maps (H, W) or (K, H, W) float32."""
        return self._by_run("maps")

    @property
    def differences(self) -> ByRun[NDArray[np.int8]]:
        """Differences from the truth (H, W) int8."""
        return ByRun([run for run in self._done if run.judged], "difference")

    @property
    def chosen(self) -> ByRun[NDArray[np.int16]]:
        """The map that each pixel asks (H, W) int16, of runs with several maps."""
        return ByRun([run for run in self._done if run.several], "chosen")

    @property
    def causes(self) -> ByRun[Causes]:
        """Why wrong pixels are wrong."""
        return ByRun([run for run in self._done if "causes" in run.metrics], "causes")

    @property
    def summaries(self) -> ByRun[Summary]:
        """Size of a texel in the image, as numbers."""
        return ByRun([run for run in self._done if run.summary is not None], "summary")

    def footprint(self, label: str, resolution: int | None = None) -> Footprint:
        """Size of a texel of a run at every pixel.

        Parameters
        ----------
        label : str
            As in the table.
        resolution : int, optional
            Needed where the study has several.

        Raises
        ------
        UnknownNameError
            For a run that is not there or has failed; the message lists those that are.
        ArgumentError
            For a label that is no text, and a resolution that is no whole number above 0.
        """
        found: Footprint = self._run(label, resolution).footprint  # type: ignore[assignment]
        return found

    def usage(self, label: str, resolution: int | None = None) -> Usage:
        """How often each texel of a run is read; arguments as of `footprint`."""
        found: Usage = self._run(label, resolution).usage  # type: ignore[assignment]
        return found

    @property
    def _draw(self) -> RendererLike:
        return renderer_of(self.backend if self.renderer is None else self.renderer)

    @property
    def _done(self) -> list[Run]:
        return [run for run in self.runs if not run.failure]

    def _by_run(self, what: str) -> ByRun[Any]:
        return ByRun(self._done, what)

    def _run(self, label: str, resolution: int | None) -> Run:
        a_text("label", label)
        if resolution is not None:
            whole("resolution", resolution)
        try:
            run: Run = self._by_run("run")[label if resolution is None else (label, resolution)]
        except KeyError as error:
            raise UnknownNameError(f"label, resolution: no run of {error.args[0]}") from None
        return run

    @property
    def verdict(self) -> str:
        """What the table says."""
        return " ".join(self.sentences)

    @property
    def best(self) -> tuple[Run, ...]:
        """The run with the fewest wrong pixels, then those that have about as many; none where no truth was traced."""
        judged = [(WrongPixels.of(run.numbers), run) for run in self._judged]
        if not judged:
            return ()
        least, first = min(judged, key=lambda one: (one[0].count, one[1].resolution))
        near = [run for wrong, run in judged if run is not first and relation(wrong, least) == "about_equal"]
        return (first, *near)

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Every technique beside uniform at equal resolution and equal texels, with the noise of both counts."""
        rows = [run.row() for run in self._judged]
        pairs = against_uniform(rows, {run.label: run.technique for run in self.runs})
        return tuple(one for of in pairs.values() for one in of)

    @property
    def unjudged(self) -> float:
        """Largest share, over the runs, of visible pixels that are undecided or not compared."""
        return most_unjudged(WrongPixels.of(run.numbers) for run in self._judged)

    @property
    def _judged(self) -> list[Run]:
        """The runs that a verdict ranks."""
        return [run for run in self._done if "compared" in run.numbers and not doubts_in(run.notes)]

    @property
    def sentences(self) -> list[str]:
        """The sentences of the verdict, the most important one first."""
        return list(self._sentences)

    @cached_property
    def _sentences(self) -> tuple[str, ...]:
        from ..reports.study_verdict import Remarks, sentences

        seen = self.view.filled(self._draw)
        remarks = [Remarks(run.notes, run.refusal) for run in self.runs]
        found = sentences(self._rows, {run.label: run.technique for run in self.runs}, remarks=remarks, seen=seen)
        return tuple(found)

    def figure(self) -> Figure:
        """A matplotlib figure, a row a run: the eye view, the difference from the truth, the map of the light."""
        from .. import plot

        return plot.study_figure(self)

    def save(self, directory: str | Path, *, progress: bool | None = None) -> Path:
        """Writes report.html (stands alone), results.csv, results.json and the pictures; returns the report's path.

        A progress bar shows on terminals and in notebooks unless `progress` is off.

        Raises
        ------
        ArgumentError
            Where the directory cannot be made or written.
        LoadError
            Of a loaded one, where its scene cannot be made again.
        """
        from ..reports.html.page import save_study

        return save_study(self, a_path("directory", directory), checked_progress(progress))

    @classmethod
    def load(cls, path: str | Path, *, scene: _core.Scene | None = None) -> Study:
        """The study that `save` wrote.

        Its numbers, settings and matrices are there at once. Pictures are drawn again where they are asked for, in the
        scene as its recipe makes it: a file as it was, or a scene of the library.

        Parameters
        ----------
        path : path
            The directory, or its results.json.
        scene : Scene, optional
            The scene of the study, for one that has no recipe, or whose file is elsewhere now.

        Returns
        -------
        Study
            Equal to the one that was saved.

        Raises
        ------
        LoadError
            Where there is no results.json of a study. Of the study, where a picture is asked for and the scene can not
            be made again, or has changed.
        StateError
            For a file that was changed since, or that a newer version wrote.
        ArgumentError
            For something that is no path, and a scene of another content.

        Examples
        --------
        >>> import tempfile, shadowlab as sl
        >>> scene, folder = sl.library.scene("robots"), tempfile.TemporaryDirectory()
        >>> study = sl.compare(scene, scene.camera, scene.light, ["uniform", "lispsm"], resolution=64, size=(64, 36),
        ...     renderer="cpu", progress=False)
        >>> report = study.save(folder.name, progress=False)
        >>> sl.Study.load(folder.name) == study
        True
        """
        from ..reports.saved import load_result

        return load_result(cls, a_path("path", path), scene)

    def save_arrays(self, path: str | Path) -> Path:
        """Writes the G-buffer, the truth, and the matrices, maps and masks of every run into one .npz file.

        Parameters
        ----------
        path : path
            The file, by the name that is given; its directory must be there.

        Returns
        -------
        Path

        Raises
        ------
        ArgumentError
            Where it cannot be written.

        Notes
        -----
        `numpy.load` reads it without pickle. docs/arrays.md lists the keys.
        """
        from ..reports.study_arrays import save_study_arrays

        return save_study_arrays(self, a_path("path", path))

    def _repr_html_(self) -> str:
        from ..reports.html.page import study_html

        return study_html(self)

    def __repr__(self) -> str:
        from ..reports.terminal import study_table

        width, height = self.size
        head = f"Study of {len(self.runs)} runs at {width} x {height} on {self.backend}"
        return f"{head}\n{study_table(self._rows)}\n{self.verdict}"
