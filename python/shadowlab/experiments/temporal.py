"""What a moving camera does to a shadow: how far texels drift on surfaces that stand still, and which flip.

A shadow shimmers where the map's texels move over the receivers: a receiver's place in the lattice, the fraction of
its texel coordinates, changes from frame to frame. Snapping (theory.md 1.4) moves maps by whole texels, so that it does
not; a `TemporalFit` holds them while they serve (theory.md 10.6). What that costs is counted beside it: wrong pixels.

```
  frame i     | . |   |      a receiver at 0.3 of its texel
  frame i+1   |   |.  |      moved by whole texels and 0.2 more: a drift of 0.2
```
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from html import escape
from itertools import pairwise
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ..aliasing.footprint import NO_MAP
from ..aliasing.usage import look_up, texel_coordinates
from ..errors import ArgumentError, ShadowlabError
from ..scene.source import Source
from ..scene.view import LIGHTS, View, light_of
from ..techniques.labels import labelled
from ..techniques.temporal_fit import TemporalFit
from ..text import shown
from ..text.arrays import checked_items
from ..text.checked import a_flag
from ..text.checks import renderer_of, whole
from ..text.progress import Steps
from ..trace import Truth
from ..travel import Value
from .arguments import check_types, size_of
from .columns import table
from .evaluate import evaluate
from .run import Run

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from .._core import Bias, Camera, Parameterization, Scene
    from ..types import Filter, Item, Light, RendererArgument, RendererLike, ShadowMaps, Techniques


# Where receivers lie anywhere in the lattice of the next frame, whatever they did in this one: the mean distance of a
# point of a square of side 1 from its centre, and its root mean square.
RANDOM_DRIFT_MEAN, RANDOM_DRIFT_RMS = 0.3825978582, 0.4082482905


@dataclass(frozen=True, eq=False, repr=False)
class Temporal(Value):
    """What maps do along a path: steps from frame to frame in `table`, frames in `frames`, one row per technique each.

    Attributes
    ----------
    table : DataFrame
        technique, frame (the first of the two that the row compares); of the `receivers` that look up the same map in
        both frames: drift_mean, drift_rms, drift_max (texels a frame), scale (the factor by which the length of a
        texel changes, the geometric mean of the factor or its inverse; 1 where it does not). Of all that face the
        light and lie in both frustums: switched (share that asks another map), lost (share that one of the frames has
        in no map, where it is lit whatever stands before it), judged (how many have the same truth in both frames),
        flips (how many of those change their shadow all the same), flip_share. failure says why a row has no numbers.
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
    scene: Scene,
    cameras: Iterable[Camera],
    light: Light | Iterable[Light],
    techniques: Techniques = ("uniform", "uniform:stable=true"),
    *,
    resolution: int = 1024,
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    progress: bool = True,
) -> Temporal:
    """How shadows shimmer along a camera path: drift of the texel lattice, and flips of shadows that stand still.

    Receivers are the surface points that the pixels of a frame see. For each step both maps, of this frame and of the
    next, are asked at the very same points, those that both cameras see, so what changes is the map alone.

    Parameters
    ----------
    scene : Scene
    cameras : sequence of Camera
        The path, at least two.
    light : light, or sequence of lights
        One for the whole path, or one a camera. Under a light that moves, receivers whose truth changes are left out.
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
    progress : bool
        Whether to show a progress bar, on terminals and in notebooks.

    Returns
    -------
    Temporal

    Raises
    ------
    ArgumentError
        For less than two cameras, another number of lights than cameras, or arguments of another type.
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
    """
    a_flag("progress", progress)
    path = checked_path(cameras)
    lights = checked_lights(light, len(path))
    for camera, of in zip(path, lights, strict=True):
        check_types(scene, camera, of, bias, filter)
    texels = whole("resolution", resolution)
    picture = size_of(size, path[0]) if size is not None else small_size(path[0])
    entries = [
        (label, Holding(item.fresh()) if isinstance(item, TemporalFit) else item)
        for label, item in labelled(techniques, lights[0])
    ]
    draw = renderer_of(renderer)
    name = Source.of_scene(scene).name
    views = [View(scene, camera, of, picture) for camera, of in zip(path, lights, strict=True)]
    rows: list[dict[str, Any]] = []
    frames: list[dict[str, Any]] = []
    drawn: dict[str, Run] = {}  # what each label has drawn for the last frame
    measure = partial(evaluate, metrics=("misclassified",), renderer=draw, bias=bias, filter=filter)

    def frame_of(number: int, label: str, item: Item) -> Run:
        run, before = measure(views[number], item, texels, label=label), drawn.get(label)
        drawn[label] = run
        frames.append({"scene": name, "frame": number, **frame_row(run, before)})
        return run

    with Steps(len(path) - 1, progress) as step:
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


class FramePair:
    """Two frames of a path: the receivers of the first, and what the maps of both make of them."""

    def __init__(self, before: View, after: View, renderer: RendererLike):
        self.frames = (before, after)
        self.gbuffer = before.gbuffer(renderer)
        self.seen = (np.asarray(self.gbuffer.triangle) >= 0) & seen_by(after.camera, self.gbuffer.position)
        self.steady = self.seen
        if before.light != after.light:
            first, second = before.truth(), replace(before, light=after.light).truth()
            self.steady = self.seen & (first == second) & (first >= Truth.SHADOW)

    def compared(self, runs: tuple[Run, Run]) -> dict[str, Any]:
        """A row of the table."""
        texels, which, masks = [], [], []
        for view, run in zip(self.frames, runs, strict=True):
            looks = (self.gbuffer, view.camera, light_of(view), cast("Parameterization", run.parameterization))
            texel, chosen = texel_coordinates(*looks, resolution=run.resolution)
            read = {"bias": run.bias, "filter": run.filter, "blend": run.blend, "stored": run.stored}
            masks.append(look_up(cast("ShadowMaps", run.maps), *looks, **read))  # type: ignore[arg-type]
            texels.append(texel)
            which.append(chosen)
        facing = self.seen & (which[0] >= NO_MAP) & (which[1] >= NO_MAP)
        held = facing & (which[0] >= 0) & (which[1] >= 0)
        same = held & (which[0] == which[1])
        # Held by no map in either frame a receiver is lit in both: nothing is judged by it.
        judged = self.steady & facing & ((which[0] >= 0) | (which[1] >= 0))
        flips = int(np.count_nonzero(((masks[0] >= 0.5) != (masks[1] >= 0.5)) & judged))
        count = int(np.count_nonzero(facing))
        row: dict[str, Any] = {"receivers": int(np.count_nonzero(same)), "judged": int(np.count_nonzero(judged))}
        row["flips"] = flips
        row["flip_share"] = flips / row["judged"] if row["judged"] else None
        if count:
            row["switched"] = int(np.count_nonzero(held & ~same)) / count
            row["lost"] = int(np.count_nonzero(facing & ~held)) / count
        if row["receivers"]:
            row |= drift_of(texels[0][same], texels[1][same])
            row["scale"] = scale_change(texels, np.where(same, which[0], -1))
        return row


def drift_of(first: NDArray[np.float64], second: NDArray[np.float64]) -> dict[str, float]:
    """How far receivers have moved in the lattice: the part of their way that is no whole number of texels.

    Parameters
    ----------
    first, second : (N, 2) float64
        Their texel coordinates in two frames.

    Returns
    -------
    dict
        drift_mean, drift_rms, drift_max: lengths, texels; at most the square root of one half.
    """
    way = second - first
    drift = np.linalg.norm(way - np.rint(way), axis=-1)
    rms = float(np.sqrt(np.mean(np.square(drift))))
    return {"drift_mean": float(drift.mean()), "drift_rms": rms, "drift_max": float(drift.max())}


def scale_change(texels: list[NDArray[np.float64]], which: NDArray[np.int16]) -> float | None:
    """By how much the distance of neighbouring receivers of one map, told in texels, changes: a factor of 1 or more.

    Parameters
    ----------
    texels : two (H, W, 2) float64
        Their texel coordinates in two frames.
    which : (H, W) int
        The map that both frames ask, -1 where they ask none or not the same.
    """
    factors = []
    for axis in (0, 1):
        pairs = (which >= 0) & (which == np.roll(which, -1, axis))
        pairs[(-1,) if axis == 0 else (slice(None), -1)] = False
        ways = [np.linalg.norm(np.roll(t, -1, axis)[pairs] - t[pairs], axis=-1) for t in texels]
        apart = (ways[0] > 0) & (ways[1] > 0)
        factors.append(np.abs(np.log(ways[1][apart] / ways[0][apart])))
    logs = np.concatenate(factors)
    return float(np.exp(logs.mean())) if logs.size else None


def seen_by(camera: Camera, points: npt.ArrayLike) -> NDArray[np.bool_]:
    """Which points (..., 3) lie in a camera's frustum."""
    clip = np.asarray(points) @ np.asarray(camera.clip_from_world)[:, :3].T + np.asarray(camera.clip_from_world)[:, 3]
    w = clip[..., 3:]
    depth, w = clip[..., 2], w[..., 0]
    inside: NDArray[np.bool_] = (
        (np.abs(clip[..., :2]) <= w[..., None]).all(axis=-1) & (depth >= 0) & (depth <= w) & (w > 0)
    )
    return inside


def checked_path(cameras: object) -> list[Camera]:
    """The cameras of a path, at least two."""
    fix = "make some with sl.Camera.look_at(eye, target)"
    path = [] if isinstance(cameras, Mapping) else checked_items("cameras", cameras, "at least two cameras", fix)
    if len(path) < 2:
        raise ArgumentError(
            f"cameras: expected at least two cameras, got {shown(cameras)}; make some with "
            "sl.Camera.look_at(eye, target)"
        )
    return path


def checked_lights(light: Light | Iterable[Light], count: int) -> list[Light]:
    """One light a camera."""
    if isinstance(light, LIGHTS):
        return [light] * count
    lights = checked_items("light", light, f"one light, or {count}, one a camera", "sl.DirectionalLight makes one")
    if len(lights) != count:
        raise ArgumentError(
            f"light: expected one light, or {count}, one a camera, got {len(lights)}; give as many as cameras"
        )
    return lights


def small_size(camera: Camera) -> tuple[int, int]:
    """The view whose pixels are the receivers, where nobody chose one: enough for a share to a thousandth."""
    from ..text.checks import picture_size

    return picture_size(camera.aspect, 256 * 256)
