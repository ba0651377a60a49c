"""The instances of a scene as the light sees them, each in the colour of what becomes of it in a map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..aliasing.casters import Casters, CullRule
from ..errors import ArgumentError
from ..experiments.evaluate import evaluate
from ..pictures.light_plane import LightPlane
from ..pictures.maps import served_depths
from ..scene.view import View, checked_view, light_of
from ..text.checked import a_text, a_word, checked
from ..text.checks import renderer_of
from ..types import CULLS, Cull
from .axes import _axes, legend_beside
from .light_views import chosen_part

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..types import Filter, RendererArgument, TechniqueArgument

# Of [okabe2008]; what does not matter is pale and lies beneath.
RULE_COLOURS = {
    CullRule.OUTSIDE: "#C8C8C8",
    CullRule.UNSEEN: "#E69F00",
    CullRule.BEHIND: "#CC79A7",
    CullRule.DRAWN: "#0072B2",
}
# Share of the picture from which a box, as of the ground, is drawn by its outline, for others to show.
LARGE_SHARE = 0.05
FRUSTUM_COLOUR, MAP_COLOUR = "#202020", "#009E73"
# Instances whose boxes are projected at once: 200 bytes each.
BOXES_AT_ONCE = 1 << 16


@checked(cull=a_word(CULLS, "see Renderer.shadow_mask"), title=a_text)
def culled(
    view: View,
    technique: TechniqueArgument,
    ax: Axes | None = None,
    *,
    resolution: int = 1024,
    map: int = 0,
    cull: Cull = "seen",
    renderer: RendererArgument = "cpu",
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
    title: str = "",
) -> Axes:
    """Axes with a view's instances as the light sees them, in the colours of the rules that leave them out of a map.

    Parameters
    ----------
    view : View
        With one light.
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it.
    ax : matplotlib axes, optional
        Made where none are given.
    resolution : int
        Texels along each side of the maps.
    map : int
        Which of several maps.
    cull : str
        "seen", "volume" or "none", as in `Renderer.shadow_mask`.
    renderer : Renderer or str, optional
        Who draws.
    bias, filter, blend, stored
        As the pixels look up the map; of `evaluate`.
    title : str

    Returns
    -------
    matplotlib axes
        Of a sun, world units across the light from the eye; of other lights, tangents of the angle from the axis.
        The map's outline is green, the camera's frustum black.

    Raises
    ------
    ArgumentError
        For a map that there is not, a view of several lights, and a technique that makes no map of the view.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("forest", trees=300)
    >>> view = sl.View(s, s.camera, s.light, size=(160, 90))
    >>> ax = sl.plot.culled(view, "lispsm", resolution=256)
    """
    checked_view(view)
    light, draws = light_of(view), renderer_of(renderer)
    run = evaluate(
        view, technique, resolution, metrics=(), renderer=draws, bias=bias, filter=filter, blend=blend, stored=stored
    )
    p = run.parameterization
    if p is None:
        raise ArgumentError(f"technique: expected one that makes a map of this view; {run.failure}")
    part = chosen_part(list(p.partitions), map)
    how: dict[str, Any] = {"bias": run.bias, "filter": run.filter, "blend": run.blend, "stored": run.stored}
    if cull == "seen":
        how |= {"gbuffer": view.gbuffer(draws), "camera": view.camera, "light": light}
    asks = draws if isinstance(draws, _core.Renderer) else _core.Renderer("cpu")
    found: Casters = asks.casters(view.scene, p, resolution=run.resolution, cull=cull, **how)
    plane = LightPlane.of(light, view.camera, part)
    ax = _axes(ax)
    _draw_boxes(ax, view.scene, plane, found.rules[map])
    _outline(ax, plane.lattice(part, [-1.0, 1.0], [-1.0, 1.0]), MAP_COLOUR, "map")
    _outline(ax, plane.frustum(view.camera, served_depths(part, view.camera)), FRUSTUM_COLOUR, "frustum")
    unit = "world units" if plane.directional else "tangent"
    ax.set(
        aspect="equal", title=title, xlabel=f"across the light and the view, {unit}",
        ylabel=f"across the light, along the view, {unit}",
    )  # fmt: skip
    ax.autoscale_view()
    legend_beside(ax, fontsize="small", handlelength=1.5)
    return ax


def _draw_boxes(ax: Axes, scene: _core.Scene, plane: LightPlane, rules: NDArray[np.uint8]) -> None:
    """The boxes of instances on the plane, rule by rule."""
    from matplotlib.collections import PolyCollection

    low, high = _rectangles(scene, plane)
    from matplotlib.colors import to_rgb as rgb

    known = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    area = float(np.prod(np.ptp(np.concatenate([low[known], high[known]]), axis=0))) if known.any() else 0.0
    for rule, colour in RULE_COLOURS.items():
        of_rule = known & (rules == rule)
        count = int(np.count_nonzero(rules == rule))
        (x0, y0), (x1, y1) = low[of_rule].T, high[of_rule].T
        corners = np.stack([np.stack([x, y], axis=-1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))], axis=1)
        faces = np.tile([*rgb(colour), 0.55], (len(corners), 1))
        faces[(x1 - x0) * (y1 - y0) > LARGE_SHARE * area, 3] = 0.0
        boxes = PolyCollection(
            cast("Any", corners), facecolors=faces, edgecolors=colour, linewidths=0.3, rasterized=True,
            label=f"{rule.name.lower()}: {count:,}",
        )  # fmt: skip
        ax.add_collection(boxes, autolim=True)


def _rectangles(scene: _core.Scene, plane: LightPlane) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest x and y (I, 2) of the instances' boxes on the plane; NaN of those behind the light."""
    unit = np.array([[x, y, z, 1.0] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    corners = []
    for mesh in scene.meshes:
        vertices = np.asarray(mesh.vertices)
        lowest, highest = vertices.min(axis=0), vertices.max(axis=0)
        corners.append(unit * np.append(highest - lowest, 1.0) + np.append(lowest, 0.0))
    places, index, transforms = np.array(corners), np.asarray(scene.mesh_index), np.asarray(scene.transforms)
    low, high = np.empty((len(index), 2)), np.empty((len(index), 2))
    for first in range(0, len(index), BOXES_AT_ONCE):
        some = slice(first, first + BOXES_AT_ONCE)
        world = np.einsum("nij,nkj->nki", transforms[some, :3], places[index[some]])
        x, y, w = np.moveaxis(plane.project(world.reshape(-1, 3)).reshape(len(world), 8, 3), -1, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = np.all(w > 0, axis=1)[:, np.newaxis, np.newaxis]
            at = np.where(ahead, np.stack([x / w, y / w], axis=-1), np.nan)
        low[some], high[some] = at.min(axis=1), at.max(axis=1)
    return low, high


def _outline(ax: Axes, segments: NDArray[np.float64], colour: str, label: str) -> None:
    from matplotlib.collections import LineCollection

    lines = LineCollection(cast("Any", segments), colors=[colour], linewidths=1.3, label=label, zorder=3)
    ax.add_collection(lines, autolim=True)
