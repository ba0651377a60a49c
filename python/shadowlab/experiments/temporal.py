"""What frames that differ do to a shadow: how far texels drift on surfaces, and which shadows flip.

A shadow shimmers where the map's texels move over the receivers: a receiver's place in the lattice, the fraction of
its texel coordinates, changes from frame to frame. Snapping (theory.md 1.4) moves maps by whole texels, so that it does
not; a `TemporalFit` holds them while they serve (theory.md 10.6). What that costs is counted beside it: wrong pixels.

```
  frame i     | . |   |      a receiver at 0.3 of its texel
  frame i+1   |   |.  |      moved by whole texels and 0.2 more: a drift of 0.2
```
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from html import escape
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ShadowlabError
from ..scene.source import Source
from ..scene.view import View
from ..techniques.labels import labelled
from ..techniques.temporal_fit import TemporalFit
from ..text.checks import renderer_of, whole
from ..text.progress import checked_progress, steps_of_call
from ..travel import Value
from .arguments import check_types, size_of
from .columns import table
from .evaluate import evaluate
from .frame_pair import FramePair
from .frames import check_instances, checked_frames
from .run import Run

if TYPE_CHECKING:
    import pandas as pd

    from .._core import Bias, Camera, Scene
    from ..types import Filter, Item, Light, RendererArgument, Techniques


@dataclass(frozen=True, eq=False, repr=False)
class Temporal(Value):
    """What maps do along a path: steps from frame to frame in `table`, frames in `frames`, one row per technique each.

    Attributes
    ----------
    table : DataFrame
        technique, frame (the first of the two that the row compares); of the `receivers` that look up the same map in
        both frames: drift_mean, drift_rms, drift_max (texels a frame), scale (the factor by which the length of a
        texel changes, the geometric mean of the factor or its inverse; 1 where it does not). Of all that face the
        light and lie in both frustums: moving (share on instances that move), switched (share that asks another map),
        lost (share that one of the frames has in no map, where it is lit whatever stands before it), judged (how many
        have the same truth in both frames), flips (how many of those change their shadow all the same), flip_share.
        failure says why a row has no numbers.
    frames : DataFrame
        technique, frame; refit (whether the maps are others than those of the frame before; true of the first), reason
        (why a `TemporalFit` made new ones), maps, and the wrong pixels of the frame by the columns of `sl.compare`.
    """

    table: pd.DataFrame
    frames: pd.DataFrame

    STATE_VERSION = 2

    @property
    def summary(self) -> pd.DataFrame:
        """One row per technique: means over the path, the largest drift, wrong pixels per frame, changes of maps."""
        rows = self.table[self.table["failure"] == ""]
        grouped = rows.groupby("technique", sort=False)
        found = grouped[["drift_mean", "drift_rms", "scale", "switched", "lost", "flip_share"]].mean()
        found.insert(2, "drift_max", grouped["drift_max"].max())
        frames = self.frames[self.frames["failure"] == ""].groupby("technique", sort=False)
        found["misclassified"] = frames["misclassified"].mean().astype("float64")
        found["refits"] = frames["refit"].sum().astype("Int64")
        means: pd.DataFrame = found.reset_index()
        return means

    def __repr__(self) -> str:
        return f"Temporal\n{self.summary.to_string(index=False, float_format=lambda v: f'{v:.4g}')}"

    def _repr_html_(self) -> str:
        failures = {f for f in self.table["failure"] if f}
        tail = "".join(f"<p>{escape(f)}</p>" for f in sorted(failures))
        return f"{self.summary.to_html(index=False, border=0, float_format=lambda v: f'{v:.4g}')}{tail}"


def temporal(
    scene: Scene | Iterable[Scene],
    cameras: Camera | Iterable[Camera],
    light: Light | Iterable[Light],
    techniques: Techniques = ("uniform", "uniform:stable=true"),
    *,
    resolution: int = 1024,
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    progress: bool | None = None,
) -> Temporal:
    """How shadows shimmer from frame to frame: drift of the texel lattice, and flips of shadows that do not change.

    Receivers are the surface points that the pixels of a frame see. For each step both maps, of this frame and of the
    next, are asked at the same points of the surfaces, those that lie in both frustums. A point of an instance that
    moves goes with it: it keeps its place in the frame of the instance's mesh. Where nothing but the camera moves, what
    changes between the two is the map alone.

    Parameters
    ----------
    scene : Scene, or sequence of Scene
        One for all frames, or one per frame: the same instances in other places, as `Scene.with_transforms` makes them.
    cameras : Camera, or sequence of Camera
        One for all frames, or the path, one per frame.
    light : light, or sequence of lights
        One for all frames, or one per frame.
    techniques : sequence or dict
        As for `sl.compare`; a dict gives each its label. A fresh copy of a `TemporalFit` holds its maps along the path;
        what the given one remembers stays as it was.
    resolution : int
        Texels along each side of the maps.
    size : (int, int), optional
        Pixels of the view, whose surfaces are the receivers; about 256 x 256 pixels of the camera's aspect where none
        is given.
    renderer, bias, filter
        As for `sl.compare`.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.

    Returns
    -------
    Temporal

    Notes
    -----
    Flips are judged at points whose truth, traced at the point itself, is the same in both frames; where scene or light
    move, points whose shadow really changes are left out. Drift is the way of a point over the map, so a point of
    an object that moves drifts over a map that stands still: `moving` is the share of such points. Points of an
    instance that is flattened and moves are left out.

    Raises
    ------
    ArgumentError
        For less than two frames, sequences of different lengths, scenes that differ in more than the places of their
        instances, or arguments of another type.
    UnknownNameError
        For a technique, filter or renderer that does not exist.

    References
    ----------
    Valient, "Stable rendering of cascaded shadow maps", ShaderX6, 2008 [valient2008] (snapping to whole texels).

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> path = [scene.camera.replace(eye=scene.camera.eye + 0.02 * i) for i in range(3)]
    >>> how = {"each frame": "scene_optimal", "held": sl.TemporalFit("scene_optimal")}
    >>> found = sl.aliasing.temporal(
    ...     scene, path, scene.light, how, resolution=256, size=(160, 90), renderer="cpu", progress=False
    ... )
    >>> found.summary.set_index("technique")["refits"].to_dict()
    {'each frame': 3, 'held': 1}

    A robot that walks, before a camera that stands still:

    >>> steps = [scene.transforms[:1] + np.pad([[0.05 * i]], ((0, 3), (3, 0))) for i in range(3)]
    >>> walk = [scene.with_transforms([0], step) for step in steps]
    >>> found = sl.aliasing.temporal(
    ...     walk, scene.camera, scene.light, ["uniform"], resolution=256, size=(160, 90), renderer="cpu", progress=False
    ... )
    >>> len(found.table), bool((found.table["moving"] > 0).all())
    (2, True)
    """
    checked_progress(progress)
    scenes, path, lights = checked_frames(scene, cameras, light)
    for of_scene, camera, of_light in zip(scenes, path, lights, strict=True):
        check_types(of_scene, camera, of_light, bias, filter)
    check_instances(scenes)
    texels = whole("resolution", resolution)
    picture = size_of(size, path[0]) if size is not None else small_size(path[0])
    entries = [
        (label, Holding(item.fresh()) if isinstance(item, TemporalFit) else item)
        for label, item in labelled(techniques, lights[0])
    ]
    draw = renderer_of(renderer)
    name = Source.of_scene(scenes[0]).name
    views = [View(of, camera, by, picture) for of, camera, by in zip(scenes, path, lights, strict=True)]
    rows: list[dict[str, Any]] = []
    frames: list[dict[str, Any]] = []
    drawn: dict[str, Run] = {}  # what each label has drawn for the last frame
    measure = partial(evaluate, metrics=("misclassified",), renderer=draw, bias=bias, filter=filter)

    def frame_of(number: int, label: str, item: Item) -> Run:
        run, before = measure(views[number], item, texels, label=label), drawn.get(label)
        drawn[label] = run
        frames.append({"scene": name, "frame": number, **frame_row(run, before)})
        return run

    with steps_of_call(len(path) - 1, progress) as step:
        for i, (before, after) in enumerate(pairwise(views)):
            step(f"frame {i}")
            pair = FramePair(before, after, draw)
            for label, item in entries:
                first = drawn.get(label) or frame_of(0, label, item)
                second = frame_of(i + 1, label, item)
                row = {"scene": name, "technique": label, "frame": i, "failure": first.failure or second.failure}
                try:
                    rows.append(row if row["failure"] else {**row, **pair.compared((first, second))})
                except ShadowlabError as error:
                    rows.append({**row, "failure": str(error)})
    frames.sort(key=lambda row: row["frame"])
    return Temporal(table("temporal", rows), table("temporal.frames", frames))


def frame_row(run: Run, before: Run | None) -> dict[str, Any]:
    """The row of a frame, after the run of the frame before."""
    p, last = run.parameterization, None if before is None else before.parameterization
    row: dict[str, Any] = {**run.row(), "refit": None, "reason": ""}
    if p is not None and not run.failure:
        row["refit"] = last is None or not np.array_equal(p.matrices, last.matrices)
        row["reason"] = run.item.reason if isinstance(run.item, Holding) else ""
    return row


class Holding:
    """A `TemporalFit` that goes on from frame to frame, as a technique that is evaluated."""

    def __init__(self, fit: TemporalFit):
        self.fit = fit
        self.name, self.settings = fit.name, fit.settings
        self.needs_samples, self.needs_shadows = fit.needs_samples, fit.needs_shadows
        self.parameterize = fit.parameterize

    @property
    def reason(self) -> str:
        """Why the last frame has new maps."""
        return self.fit.reason


def small_size(camera: Camera) -> tuple[int, int]:
    """The view whose pixels are the receivers, where nobody chose one: enough for a share to a thousandth."""
    from ..text.checks import picture_size

    return picture_size(camera.aspect, 256 * 256)
