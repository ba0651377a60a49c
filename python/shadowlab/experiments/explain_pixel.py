"""Why one pixel is wrong, or right: from the surface that it sees to the texel that it is compared with.

```
    pixel -> surface -> truth: what the ray to the light meets
                |
                +----> map -> light ray -> warp -> fit -> NDC -> texel -> what it stores, and whose triangle that is
                                                                  |
                            reference depth, each part of the bias -> verdict, its cause, and what would mend it
```
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .. import _core
from ..aliasing.causes import CAUSES
from ..aliasing.codes import LIT_FROM, Cause, Difference, NoTexel
from ..aliasing.footprint import footprint_at
from ..aliasing.map_rays import MapRays
from ..aliasing.pixel_comparison import Compared, PixelComparison, TexelRead, bias_parts, carried, compared_at, is_map
from ..aliasing.pixel_held import Held, held_by
from ..aliasing.pixel_surface import Met, PixelSurface, met_on_the_way, pixel_surface
from ..aliasing.pixel_texel import map_chain, pixel_texel
from ..errors import UnsupportedError
from ..scene.kept import Kept
from ..scene.view import View, checked_view, identity_of, light_of
from ..techniques.labels import name_of, resolved, spec_of
from ..techniques.variant import MapReading
from ..text.checked import a_count, a_flag
from ..text.checks import check_bias, check_filter, checked_blend, checked_stored, renderer_of, whole
from ..text.progress import checked_progress, steps_of_call
from ..trace import Truth
from .evaluate import evaluate
from .pixel_explanation import MapReason, PixelBlend, PixelExplanation, PixelVerdict, TruthName
from .pixel_trials import Trials
from .run import done

if TYPE_CHECKING:
    from ..types import Filter, Light, RendererArgument, RendererLike, ShadowMaps, TechniqueArgument
    from .run import Run

TRUTHS: dict[Truth, TruthName] = {
    Truth.LIT: "lit", Truth.SHADOW: "shadow", Truth.UNDECIDED: "undecided", Truth.NOTHING: "nothing",
}  # fmt: skip
VERDICTS: dict[Difference, PixelVerdict] = {
    Difference.AGREE: "right", Difference.FALSE_SHADOW: "false shadow", Difference.FALSE_LIGHT: "false light",
    Difference.NOT_COMPARED: "not compared",
}  # fmt: skip
WITHOUT_MAP: dict[int, MapReason] = {
    NoTexel.NO_MAP: "outside", NoTexel.AVERTED: "averted", NoTexel.NOTHING: "nothing",
}  # fmt: skip
# Runs that were explained last, so that the next pixel of one draws nothing again.
RUNS = Kept(4)


def explain_pixel(
    view: View,
    technique: TechniqueArgument,
    x: int,
    y: int,
    *,
    resolution: int = 1024,
    renderer: RendererArgument = None,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
    trials: bool = True,
    progress: bool | None = None,
) -> PixelExplanation:
    """Why a pixel is wrong, or right, and what would mend it.

    Parameters
    ----------
    view : View
        With one light.
    technique : str, Technique, Preset or Parameterization
        As of `evaluate`.
    x, y : int
        Column and row of the pixel, from 0 at the upper left.
    resolution : int
        Texels along each side of the maps.
    renderer : Renderer or str, optional
        As of `evaluate`.
    bias : Bias, optional
        ``Bias()`` where none is given.
    filter : str
        One of `sl.filters()`.
    blend : float
        As of `evaluate`. Where two maps blend, the explanation is of the one that makes the pixel wrong.
    stored : Stored or str, optional
        What the maps store; the nearest depth as it is where none is given.
    trials : bool
        Whether to try what would make a wrong pixel right: maps of twice the side and more, up to 8192² texels in
        all; each part of the bias alone; another surface, spacing or format of what maps store; other techniques at
        the same resolution. Takes as long as drawing those maps.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.

    Returns
    -------
    PixelExplanation
        The maps are kept, so that the next pixel of the same view and technique is explained without drawing.

    Raises
    ------
    ArgumentError
        For arguments of another type, a pixel outside of the picture, a view with several lights, and a share to blend
        over that is not from 0 to 1.
    UnsupportedError
        For a technique that cannot serve this scene or light.
    UnknownNameError
        For a technique, filter or renderer that does not exist, or a surface, spacing or format to store.

    Examples
    --------
    >>> import numpy as np
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> run = sl.evaluate(view, "uniform", 256, renderer="cpu")
    >>> y, x = np.argwhere(run.errors.image > 0)[0]
    >>> found = sl.explain_pixel(view, "uniform", x, y, resolution=256, renderer="cpu", trials=False)
    >>> found.verdict == {1: "false shadow", 2: "false light"}[run.errors.image[y, x]]
    True
    """
    light = light_of(checked_view(view))
    width, height = view.size
    x, y = a_count(0, width - 1)("x", x), a_count(0, height - 1)("y", y)
    resolution = whole("resolution", resolution)
    check_bias(bias)
    check_filter(filter)
    a_flag("trials", trials), checked_progress(progress)
    draw = renderer_of(renderer)
    read = MapReading(_core.Bias() if bias is None else bias, filter, checked_blend(blend), checked_stored(stored))
    run = _run(view, technique, resolution, draw, read)
    found = _explained(run, draw, light, (x, y))
    if not (trials and found["verdict"] in ("false shadow", "false light")):
        return PixelExplanation(**found)
    tried = Trials(run, draw, (x, y))
    with steps_of_call(tried.most, progress) as announce:
        return PixelExplanation(**found, trials=tuple(tried.all(announce)))


def _run(view: View, technique: TechniqueArgument, resolution: int, renderer: RendererLike, read: MapReading) -> Run:
    """The run of the whole picture, kept."""
    item = resolved(technique, "technique")
    label = technique if isinstance(technique, str) else name_of(item)

    def make() -> Run:
        return evaluate(
            view, item, resolution, metrics=("misclassified", "causes"), renderer=renderer, label=label,
            **read._asdict(),
        )  # fmt: skip

    key = (cast("Hashable", item), label, resolution, *read, *identity_of(renderer))
    # A renderer from elsewhere is kept with its run, so that its identity stays its own.
    run, _ = RUNS.get(view, key, lambda: (make(), renderer), lambda _: 1)
    if run.failure:
        raise UnsupportedError(f"technique: {run.failure}")
    return run


def _explained(run: Run, renderer: RendererLike, light: Light, pixel: tuple[int, int]) -> dict[str, Any]:
    """The fields of an explanation, trials aside."""
    view, p, (x, y) = run.view, done(run.parameterization), pixel
    gbuffer, drawn, caused = view.gbuffer(renderer), done(run.maps), done(run.causes)
    maps = drawn if drawn.ndim == 3 else drawn[None]
    code = Cause(int(caused.image[y, x]))
    moved = float(caused.distance[y, x])
    mask = float(done(run.mask)[y, x])
    compared, blend = _compared(run, light, gbuffer, maps, pixel)
    index = compared.map
    surface = pixel_surface(gbuffer, view.camera, light, pixel, index not in (NoTexel.AVERTED, NoTexel.NOTHING))
    found: dict[str, Any] = {
        "run": run, "x": x, "y": y, "technique": spec_of(run.label, run.item),
        "truth": TRUTHS[Truth(int(np.asarray(view.truth())[y, x]))],
        "light": None if np.isnan(mask) else mask,
        "verdict": VERDICTS[Difference(int(done(run.errors).image[y, x]))],
        "cause": CAUSES.get(code), "edge_px": moved if code == Cause.EDGE else None,
        "surface": surface, "blocker": None, "map": None, "maps": len(p.partitions),
        "blocker_depth": None,
        "blend": blend, "reason": WITHOUT_MAP.get(index, "only"), "eye_depth": None, "chain": None, "texel": None,
        "held": None, "comparison": None,
    }  # fmt: skip
    if surface is None:
        return found
    if surface.faces_light and found["truth"] != "lit":
        found["blocker"] = met_on_the_way(view.scene, view.camera, light, surface, pixel, view.size)
    if not is_map(index):
        return found
    return found | _in_map(run, light, gbuffer, maps, surface, found["blocker"], pixel, compared)


def _compared(
    run: Run, light: Light, gbuffer: _core.GBuffer, maps: ShadowMaps, pixel: tuple[int, int]
) -> tuple[Compared, PixelBlend | None]:
    """What a pixel is compared with; where two maps blend, in the one that makes it wrong, and how they blend."""
    view, p = run.view, done(run.parameterization)

    def of(asked: int | None) -> Compared:
        read = (run.resolution, run.bias, run.filter, run.stored)
        return compared_at(gbuffer, view.camera, light, p, pixel, *read, asked)

    def lit(compared: Compared) -> float:
        layer, taps = maps[compared.map], compared.taps
        share = sum(weight for i, j, weight, at in taps if at is None or float(layer[j, i]) >= at)
        return float(np.float32(share))

    own = of(None)
    if not run.blend or not is_map(own.map):
        return own, None
    next_map, share = _core.blended(gbuffer, view.camera, light, p, np.array([pixel]), run.blend)
    if next_map[0] < 0:
        return own, None
    other = of(int(next_map[0]))
    lights = lit(own), lit(other)
    blend = PixelBlend((own.map, other.map), (1.0 - float(share[0]), float(share[0])), lights)
    difference = Difference(int(done(run.errors).image[pixel[1], pixel[0]]))
    is_right = {Difference.FALSE_SHADOW: lights[0] >= LIT_FROM, Difference.FALSE_LIGHT: lights[0] < LIT_FROM}
    return (other if is_right.get(difference, False) else own), blend


def _in_map(
    run: Run, light: Light, gbuffer: _core.GBuffer, maps: ShadowMaps, surface: PixelSurface, blocker: Met | None,
    pixel: tuple[int, int], compared: Compared,
) -> dict[str, Any]:  # fmt: skip
    """The fields of an explanation that are about the map that serves the pixel."""
    index, reference = compared.map, compared.reference
    view, p = run.view, done(run.parameterization)
    part = p.partitions[index]
    layer = maps[index]
    size = (run.resolution, run.resolution)
    reach = float(np.linalg.norm(np.ptp(np.asarray(view.scene.bounds), axis=0)))
    origin = np.asarray(gbuffer.origin, np.float64)
    rays = MapRays(part, light, origin, size, reach, run.stored, _core.depth_rows(p, origin, run.stored)[index])
    chain = map_chain(rays, surface)
    column, row = (min(max(int(np.floor(at)), 0), n - 1) for at, n in zip(chain.place, size, strict=True))
    extent = footprint_at(
        surface.point[None], surface.normal[None], view.camera, light, p, size=view.size, resolution=run.resolution
    )
    texel = pixel_texel(rays, surface, view.camera, view.size, index, (column, row), extent)
    known: dict[tuple[int, int], Held] = {}

    def held(i: int, j: int) -> Held:
        if (i, j) not in known:
            known[i, j] = held_by(view.scene, rays, surface, (i, j), float(layer[j, i]))
        return known[i, j]

    unbiased, parts = bias_parts(gbuffer, view.camera, light, p, pixel, index, rays, surface, run.bias, run.filter)
    reads = []
    for i, j, weight, at_texel in compared.taps:
        stored = held(i, j)
        reads.append(TexelRead(i, j, weight, at_texel, at_texel is None or stored.depth >= at_texel, stored))
    moved = 0.0 if unbiased is None or reference is None else carried(rays, surface, unbiased, reference)
    arrives = sum(read.weight for read in reads if read.is_lit)
    stored = held(column, row)
    short = None if reference is None or stored.is_empty else carried(rays, surface, reference, stored.depth)
    return {
        "map": index, "reason": _reason(p, index, surface.eye_depth), "eye_depth": part.eye_depth, "chain": chain,
        "texel": texel, "held": stored,
        "comparison": PixelComparison(unbiased, reference, moved, short, parts, tuple(reads), arrives),
        "blocker_depth": None if blocker is None else rays.z(blocker.point - rays.origin),
    }  # fmt: skip


def _reason(p: _core.Parameterization, index: int, depth: float) -> MapReason:
    """How a receiver at a camera depth finds its map."""
    if len(p.partitions) == 1:
        return "only"
    if p.selection == "containment":
        return "containment"
    last = p.partitions[-1].eye_depth[1]
    ends = [part.eye_depth[1] for part in p.partitions]
    first = next((k for k, end in enumerate(ends) if depth <= end or end >= last), len(ends) - 1)
    return "depth" if index == first else "later"
