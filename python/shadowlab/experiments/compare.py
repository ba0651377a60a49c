"""Techniques side by side on one scene, camera and light, against traced truth.

The truth and the eye view are computed once; each technique and resolution gives one row of the table. A technique that
cannot serve the scene or the light leaves its reason in its row and the others alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..scene.source import Source
from ..scene.view import View
from ..techniques.labels import labelled
from ..text import shown
from ..text.checked import a_flag
from ..text.checks import checked_blend, checked_stored, renderer_of
from ..text.progress import checked_progress, steps_of_call
from .arguments import check_types, checked_source, resolutions_of, size_of
from .evaluate import evaluate
from .metrics import HELD_AGAINST_TRUTH, METRICS, Metric, checked_metrics
from .noise import with_noise
from .phases import PHASES, checked_phases
from .study import Study

if TYPE_CHECKING:
    from ..types import Filter, Light, RendererArgument, Techniques


def compare(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light,
    techniques: Techniques = ("uniform", "lispsm"),
    *,
    resolution: int | Sequence[int] = 1024,
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
    truth: bool = True,
    metrics: Sequence[Metric] = METRICS,
    timing: bool = False,
    phases: int = PHASES,
    progress: bool | None = None,
    source: Source | None = None,
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
        One of `sl.filters()`, with its settings.
    blend : float
        As of `evaluate`.
    stored : Stored or str, optional
        As of `evaluate`; a technique's text can say its own.
    truth : bool
        Whether to trace the truth; without it no errors are counted.
    metrics, timing
        As of `evaluate`: what is measured, and whether timed calls are repeated until the times are steady.
    phases : int
        Shifts of the texels over which wrong pixels are counted, of those runs alone between which the verdict has to
        decide and whose counts are close; 1 for none. See `Run.over_phases`.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.
    source : Source, optional
        Where the scene came from, for the report; what the scene knows of itself where none is given.

    Returns
    -------
    Study

    Raises
    ------
    ArgumentError
        For a scene, camera, light, bias or renderer of another type, a size or resolution that is not a whole number
        above 0, a duplicate resolution or label, or nothing to compare. All before any work.
    UnknownNameError
        For a technique, metric, filter or renderer that does not exist. What a technique cannot do with this scene or
        light is the `failure` of its row.
    """
    check_types(scene, camera, light, bias, filter)
    blend, kept = checked_blend(blend), checked_stored(stored)
    a_flag("timing", timing), checked_progress(progress), checked_source(source)
    checked_phases(phases)
    resolutions = resolutions_of(resolution)
    width, height = size_of(size, camera)
    if not isinstance(truth, (bool, np.bool_)):
        raise ArgumentError(f"truth: expected True or False, got {shown(truth)}; without it no errors are counted")
    # Without truth the maps are drawn and looked up all the same, for their times and pictures.
    asked = checked_metrics(metrics)
    measured = checked_metrics([name for name in ("mask", *asked) if truth or name not in HELD_AGAINST_TRUTH])
    entries = labelled(techniques, light)
    draw = renderer_of(renderer)
    view = View(scene, camera, light, (width, height))
    measure = partial(
        evaluate, metrics=measured, renderer=draw, filter=filter, bias=bias, blend=blend, stored=kept, timing=timing
    )
    with steps_of_call(2 + len(entries) * len(resolutions), progress) as step:
        step("eye view")
        view.gbuffer(draw)
        step("truth")
        if truth:
            view.truth()
        runs = []
        for label, item in entries:
            for texels in resolutions:
                step(f"{label} {texels}²")
                runs.append(measure(view, item, texels, label=label))
    runs = with_noise(runs, phases, progress)
    return Study(
        tuple(runs), view, _core.Bias() if bias is None else bias, filter, draw.backend, draw.adapter,
        source or Source.of_scene(scene), bool(truth), draw, blend, kept,
    )  # fmt: skip
