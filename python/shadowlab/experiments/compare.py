"""Techniques side by side on one scene, camera and light, against traced truth.

The truth and the eye view are computed once; each technique and resolution gives one row of the table. A technique that
cannot serve the scene or the light leaves its reason in its row and the others alone.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ..scene.source import Source
from ..techniques.labels import labelled as labelled
from ..techniques.labels import resolved as resolved
from ..text import shown
from .arguments import check_types, renderer_of, resolutions_of, size_of
from .run import COLUMNS, COUNTS, NUMBERS, ByRun, Draw, Run, run_one
from .tables import Steps, text_table


@dataclass(frozen=True, eq=False, repr=False)
class Study:
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
    scene: Any = field(repr=False)
    camera: Any
    light: Any
    size: tuple[int, int]
    bias: Any
    filter: str
    backend: str
    adapter: str
    gbuffer: Any = field(repr=False)
    truth: np.ndarray | None = field(repr=False)
    truth_ms: float | None
    source: Any

    @property
    def table(self) -> Any:
        """The numbers, one row a run."""
        import pandas as pd

        table = pd.DataFrame([run.row() for run in self.runs], columns=list(COLUMNS))
        return table.astype({**dict.fromkeys(COUNTS, "Int64"), **dict.fromkeys(NUMBERS, "float64")})

    @property
    def masks(self) -> ByRun:
        """Shadow masks (H, W) float32."""
        return ByRun({(r.label, r.resolution): r.mask for r in self.runs if r.mask is not None})

    @property
    def maps(self) -> ByRun:
        """Shadow maps (H, W) or (K, H, W) float32."""
        return ByRun({(r.label, r.resolution): r.maps for r in self.runs if r.maps is not None})

    @property
    def differences(self) -> ByRun:
        """Differences from the truth (H, W) int8."""
        return ByRun({(r.label, r.resolution): r.errors.image for r in self.runs if r.errors is not None})

    @property
    def chosen(self) -> ByRun:
        """The map that each pixel asks (H, W) int16, of runs with several maps."""
        return ByRun({(r.label, r.resolution): r.chosen for r in self.runs if r.chosen is not None})

    @property
    def causes(self) -> ByRun:
        """Why wrong pixels are wrong."""
        return ByRun({(r.label, r.resolution): r.causes for r in self.runs if r.causes is not None})

    @property
    def summaries(self) -> ByRun:
        """How large a texel is in the image, as numbers."""
        return ByRun({(r.label, r.resolution): r.summary for r in self.runs if r.summary is not None})

    def footprint(self, label: str, resolution: int | None = None) -> Any:
        """How large a texel of a run is at every pixel: `aliasing.Footprint`, computed anew.

        Parameters
        ----------
        label : str
            As in the table.
        resolution : int, optional
            Needed where the study has several.

        Raises
        ------
        KeyError
            For a run that is not there or has failed; the message lists those that are.
        """
        from ..aliasing.footprint import footprint_of

        run = self._measured(label, resolution)
        return footprint_of(self.gbuffer, self.camera, self.light, run.parameterization, run.resolution)

    def _measured(self, label: str, resolution: int | None) -> Run:
        runs = ByRun({(r.label, r.resolution): r for r in self.runs if r.summary is not None})
        run: Run = runs[label if resolution is None else (label, resolution)]
        return run

    def usage(self, label: str, resolution: int | None = None) -> Any:
        """How often each texel of a run is read: `aliasing.Usage`, computed anew; arguments as of `footprint`."""
        from .. import aliasing

        run = self._measured(label, resolution)
        seen = (self.gbuffer, self.camera, self.light, run.parameterization)
        return aliasing.usage(*seen, resolution=run.resolution, filter=self.filter)

    @property
    def verdict(self) -> str:
        """What the table says."""
        from ..reports.study_verdict import verdict

        seen = float(np.mean(np.asarray(self.gbuffer.triangle) >= 0))
        return verdict(self.table, {run.label: run.technique for run in self.runs}, seen=seen)

    def figure(self) -> Any:
        """A matplotlib figure, a row a run: the eye view, the difference from the truth, the map of the light."""
        from .. import plot

        return plot.study_figure(self)

    def save(self, directory: str | Path, *, progress: bool = True) -> Path:
        """Writes report.html (stands alone), results.csv, results.json and the pictures; returns the report's path.

        A progress bar shows on terminals and in notebooks unless `progress` is off.

        Raises
        ------
        ArgumentError
            Where the directory cannot be made or written.
        """
        from ..reports.html.page import save

        if not isinstance(directory, (str, os.PathLike)):
            raise ArgumentError(f'directory: expected a path, got {shown(directory)}; try "report"')
        return save(self, Path(directory), progress)

    def _repr_html_(self) -> str:
        from ..reports.html.page import notebook_html

        return notebook_html(self)

    def __repr__(self) -> str:
        width, height = self.size
        head = f"Study of {len(self.runs)} runs at {width} x {height} on {self.backend}"
        return f"{head}\n{text_table(self.table)}\n{self.verdict}"


def compare(
    scene: Any,
    camera: Any,
    light: Any,
    techniques: Any = ("uniform", "lispsm"),
    *,
    resolution: int | Sequence[int] = 1024,
    size: tuple[int, int] | None = None,
    renderer: Any = None,
    bias: Any = None,
    filter: str = "nearest",
    truth: bool = True,
    progress: bool = True,
    source: Any = None,
) -> Study:
    """The shadows of several techniques against traced truth, as a table with pictures.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight
    techniques : sequence or dict
        Names ("lispsm", "lispsm:near=basic", "preset:filament", "all" for every technique that serves the light,
        "matrix:file=mine.npy,convention=opengl"),
        Technique objects or Parameterization objects; a dict gives each its label.
    resolution : int or sequence of int
        Texels along each side of the maps.
    size : (int, int), optional
        Width and height of the eye view in pixels. About 1024 * 1024 pixels of the camera's aspect where none is
        given: 1024 x 1024 for an aspect of 1, 1360 x 765 for 16:9. Another aspect than the camera's stretches the
        picture, and warns from 1 % on.
    renderer : Renderer or str, optional
        "cpu", "gpu" or "auto" for the renderer of that name; "auto" where none is given.
    bias : Bias, optional
        ``Bias()`` where none is given.
    filter : str
        "nearest" or "pcf2x2".
    truth : bool
        Whether to trace the truth; without it no errors are counted.
    progress : bool
        Whether to show a progress bar, on terminals and in notebooks.
    source : Source, optional
        Where the scene came from, for the report; see `shadowlab.Source`.

    Returns
    -------
    Study

    Raises
    ------
    ArgumentError
        For a scene, camera, light, bias or renderer of another type, a size or resolution that is not a whole number
        above 0, a resolution or label that comes twice, or nothing to compare. All before any work.
    UnknownNameError
        For a technique, filter or renderer that does not exist. What a technique cannot do with this scene or light is
        told in its row.
    """
    from .._core import Bias

    check_types(scene, camera, light, bias, filter)
    resolutions = resolutions_of(resolution)
    width, height = size_of(size, camera)
    if not isinstance(truth, (bool, np.bool_)):
        raise ArgumentError(f"truth: expected True or False, got {shown(truth)}; without it no errors are counted")
    entries = labelled(techniques, light)
    renderer = renderer_of(renderer)
    bias = Bias() if bias is None else bias
    with Steps(2 + len(entries) * len(resolutions), progress) as step:
        step("eye view")
        gbuffer = renderer.gbuffer(scene, camera, size=(width, height))
        step("truth")
        traced, truth_ms = traced_truth(scene, camera, light, (width, height)) if truth else (None, None)
        runs = []
        for label, item in entries:
            for texels in resolutions:
                step(f"{label} {texels}²")
                draw = Draw(scene, camera, light, renderer, (width, height), bias, filter, gbuffer, traced)
                runs.append(run_one(draw, label, item, texels))
    return Study(
        tuple(runs), scene, camera, light, (width, height), bias, filter, renderer.backend, renderer.adapter, gbuffer,
        traced, truth_ms, source or Source.of_scene(scene),
    )  # fmt: skip


def traced_truth(scene: Any, camera: Any, light: Any, size: tuple[int, int]) -> tuple[np.ndarray, float]:
    """The truth and the milliseconds it took."""
    from .. import trace

    start = time.perf_counter()
    mask = trace.shadow_mask(scene, camera, light, size=size)
    return mask, 1e3 * (time.perf_counter() - start)
