"""What the light sees: a map after the warp, and the world before it with the map's lattice on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core, pictures
from ..aliasing.footprint import as_maps
from ..errors import ArgumentError
from ..pictures.errors import rgb
from ..pictures.light_plane import LightPlane
from ..pictures.maps import frustum_in, map_colour, served_depths
from ..text import shown
from ..text.arrays import checked_array
from ..text.checked import A_CAMERA, a_light, a_text, checked, optional
from ..text.checks import renderer_of
from ..text.specs import LONGEST_PICTURE
from .arguments import count_of
from .axes import MOST_NAMED, _axes, legend_beside

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

    from ..types import Light, Maps, RendererArgument, Size

# Lines along a side where no step is given.
LINES_ALONG = 16
# Pixels along the longer side of the picture before the warp.
SIDE = 900
FRUSTUM = np.array(pictures.FRUSTUM_RGB) / 255


@checked(camera=A_CAMERA, title=a_text)
def warped_view(
    parameterization: Maps,
    camera: _core.Camera,
    ax: Axes | None = None,
    *,
    map: int = 0,
    depth: npt.ArrayLike | None = None,
    every: int | None = None,
    resolution: Size | None = None,
    title: str = "",
) -> Axes:
    """Axes with the light's view after the warp, in NDC: the map, its texel lattice, and the camera frustum in it.

    Parameters
    ----------
    parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    camera : Camera
    ax : matplotlib axes, optional
        Made where none are given.
    map : int
        Which of several maps.
    depth : (H, W) or (K, H, W) array_like, optional
        The shadow map, or all of them, to draw beneath.
    every : int, optional
        Texels from one line to the next; a sixteenth of the wider side where none is given.
    resolution : int or (int, int), optional
        Texels of the map; those of `depth` or else the parameterization's own where none is given.
    title : str

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ArgumentError
        For a map that there is not, and a depth map of another shape.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    >>> ax = sl.plot.warped_view(p, s.camera, depth=sl.Renderer("cpu").shadow_map(s, p))
    """
    part, _, given = _chosen(parameterization, map, resolution)
    picture = None if depth is None else _depth_of(depth, map)
    width, height = given if resolution is not None or picture is None else picture.shape[::-1]
    step = max(1, max(width, height) // LINES_ALONG) if every is None else count_of(every, "every", most=1 << 30)
    ax = _axes(ax)
    if picture is not None:
        relief = pictures.relief(pictures.reduced(picture, 1024))
        ax.imshow(relief, extent=(-1, 1, -1, 1), interpolation="antialiased")
    xs, ys = _lines(width, step), -_lines(height, step)
    lattice = np.array([[[x, -1], [x, 1]] for x in xs] + [[[-1, y], [1, y]] for y in ys])
    colour = "white" if picture is not None else "#8A8A8A"
    _segments(ax, lattice, colors=[colour], linewidths=0.6, alpha=0.55)
    served = served_depths(part, camera)
    frustum = frustum_in(part, camera, served)
    _draw_frustum(ax, frustum)
    ticks = [-1.0, -0.5, 0.0, 0.5, 1.0]
    ax.set(
        xlim=(-1, 1), ylim=(-1, 1), aspect=height / width, xticks=ticks, yticks=ticks, title=title,
        xlabel=f"x of the map, NDC; a line every {step} of {width} texels", ylabel="y of the map, NDC",
    )  # fmt: skip
    return ax


@checked(camera=A_CAMERA, light=optional(a_light), title=a_text)
def light_view(
    parameterization: Maps,
    camera: _core.Camera,
    scene: _core.Scene | npt.ArrayLike,
    ax: Axes | None = None,
    *,
    light: Light | None = None,
    map: int | None = 0,
    every: int | None = None,
    resolution: Size | None = None,
    renderer: RendererArgument = None,
    title: str = "",
) -> Axes:
    """Axes with the light's view before the warp, and the texel lattice mapped back onto it.

    Cells of the lattice are equal in the map; where they crowd, the map has texels to spend. Each line is exact: it is
    the image of a line of the map under the inverse homography.

    Parameters
    ----------
    parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    camera : Camera
    scene : Scene or (2, 3) array_like
        What the light sees, drawn beneath; or only its bounds, world units.
    ax : matplotlib axes, optional
        Made where none are given.
    light : DirectionalLight, SpotLight or PointLight, optional
        The one of the parameterization; that of a library scene where none is given.
    map : int, optional
        Which of several maps; all of them, each in its colour, where it is None.
    every : int, optional
        Texels from one line to the next; a sixteenth of the wider side where none is given.
    resolution : int or (int, int), optional
        Texels of the map; the parameterization's own where none is given.
    renderer : Renderer, optional
        Who draws the scene; the processor where none is given.
    title : str

    Returns
    -------
    matplotlib axes
        Across the light of a sun world units from the eye: y is along the view, x to the right as the light sees it.
        Tangents of the angle from the light's axis for a spot, and from the middle of the map for a point light.

    Raises
    ------
    ArgumentError
        For a map that there is not, a light that is needed, all maps of a point light, a map that is singular across
        the light, and bounds that are not finite.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("robots")
    >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    >>> ax = sl.plot.light_view(p, s.camera, s)
    """
    light = getattr(scene, "light", None) if light is None and isinstance(scene, _core.Scene) else light
    if light is None:
        raise ArgumentError("light: expected the light of the parameterization, got none; give light=")
    if map is None and getattr(light, "kind", None) == "point":
        raise ArgumentError(
            "map: expected one map of a point light, whose maps look different ways, got None; choose one"
        )
    part, parts, (width, height) = _chosen(parameterization, 0 if map is None else map, resolution)
    step = max(1, max(width, height) // LINES_ALONG) if every is None else count_of(every, "every", most=1 << 30)
    plane = LightPlane.of(light, camera, part)
    chosen = list(enumerate(parts)) if map is None else [(map, part)]
    bounds = _bounds(scene)
    xs, ys = _lines(width, step), -_lines(height, step)
    lines = [plane.lattice(p, [-1.0, *xs, 1.0], [-1.0, *ys, 1.0]) for _, p in chosen]
    x, y = _window(lines, plane, bounds)
    ax = _axes(ax)
    # Limits first, so that nothing that is drawn moves them.
    ax.set(xlim=x, ylim=y, aspect="equal", autoscale_on=False)
    if isinstance(scene, _core.Scene):
        _ground(ax, plane, scene, bounds, light, renderer)
    else:
        _segments(ax, plane.box(bounds), colors=["#9A9A9A"], linewidths=0.8)
    for (index, _), segments in zip(chosen, lines, strict=True):
        colour = np.array(map_colour(index)) / 255 if len(chosen) > 1 else "#0072B2"
        _segments(ax, segments, colors=[colour], linewidths=0.9, alpha=0.9)
    frustum = plane.frustum(camera, served_depths(part, camera) if map is not None else None)
    _draw_frustum(ax, frustum)
    _mark_eye(ax, plane, camera)
    _name_maps(ax, len(chosen))
    unit = "world units" if plane.directional else "tangent"
    ax.set(
        xlabel=f"across the light and the view, {unit}; a line every {step} of {width} texels",
        ylabel=f"across the light, along the view, {unit}", title=title,
    )  # fmt: skip
    return ax


def _chosen(
    parameterization: Maps, index: int, resolution: Size | None
) -> tuple[_core.Partition, list[_core.Partition], tuple[int, int]]:
    """A map, all maps, and the texels of each."""
    p, texels = as_maps(parameterization, resolution)
    if min(texels) < 1:
        raise ArgumentError(f"resolution: expected at least one texel a side, got {shown(resolution)}")
    if max(texels) > LONGEST_PICTURE:
        raise ArgumentError(f"resolution: expected at most {LONGEST_PICTURE} texels a side, got {shown(resolution)}")
    parts = list(p.partitions)
    return chosen_part(parts, index), parts, texels


def chosen_part(parts: list[_core.Partition], index: int) -> _core.Partition:
    """The map of an index, checked."""
    if isinstance(index, bool) or not isinstance(index, (int, np.integer)) or not 0 <= index < len(parts):
        raise ArgumentError(f"map: expected one from 0 to {len(parts) - 1}, got {shown(index)}; there are {len(parts)}")
    return parts[index]


def _depth_of(depth: npt.ArrayLike, index: int) -> NDArray[np.float32]:
    """The shadow map (H, W) that is meant."""
    maps: NDArray[np.float32] = checked_array("depth", depth, np.float32)
    if maps.ndim == 3 and index < len(maps):
        maps = maps[index]
    if maps.ndim != 2 or maps.size == 0:
        raise ArgumentError(
            f"depth: expected a shadow map (H, W), or all (K, H, W), got shape {np.shape(depth)}; "
            "Renderer.shadow_map(...) makes them"
        )
    return maps


def _lines(texels: int, step: int) -> NDArray[np.float64]:
    """NDC of every step-th line between texels, from the left or top, the edges left out."""
    return np.arange(step, texels, step, dtype=np.float64) * (2.0 / texels) - 1.0


def _segments(ax: Axes, segments: NDArray[np.float64], **style: Any) -> None:
    """Lines on axes that leave the limits as they are."""
    from matplotlib.collections import LineCollection

    ax.add_collection(LineCollection(list(segments), capstyle="round", **style), autolim=False)


def _draw_frustum(ax: Axes, segments: NDArray[np.float64]) -> None:
    """The frustum's edges, with a dark casing that shows them on any ground."""
    _segments(ax, segments, colors=["#202020"], linewidths=2.6)
    _segments(ax, segments, colors=[FRUSTUM], linewidths=1.4)


def _name_maps(ax: Axes, count: int) -> None:
    """A legend of the maps' colours, where there are several."""
    from matplotlib.lines import Line2D

    named = min(count, MOST_NAMED)
    handles = [Line2D([], [], color=rgb(map_colour(i)), linewidth=1.8, label=f"map {i}") for i in range(named)]
    if count > 1:
        legend_beside(ax, handles, fontsize="small", handlelength=1.5)


def _bounds(scene: _core.Scene | npt.ArrayLike) -> NDArray[np.float64]:
    """The bounds (2, 3) of a scene, or those that are given."""
    bounds: NDArray[np.float64] = checked_array("scene", scene.bounds if isinstance(scene, _core.Scene) else scene)
    if bounds.shape != (2, 3) or not np.isfinite(bounds).all() or (bounds[0] > bounds[1]).any():
        raise ArgumentError(f"scene: expected a Scene, or finite bounds (2, 3), lowest first, got {shown(scene)}")
    return bounds


def _window(
    lines: list[NDArray[np.float64]], plane: LightPlane, bounds: NDArray[np.float64]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of x and y around all lines; around the bounds where a line goes to the horizon."""
    places = np.concatenate(lines).reshape(-1, 2)
    box = plane.box(bounds).reshape(-1, 2)
    if len(places) and len(box):
        reach = float(np.ptp(box, axis=0).max())
        near = np.abs(places - box.mean(axis=0)).max() < 4.0 * reach
        places = places if near or not plane.directional else box
    if not len(places):
        places = box if len(box) else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = places.min(axis=0), places.max(axis=0)
    if plane.directional and (np.maximum(low, -high) <= 0.3 * (high - low)).all():
        # The eye, from which places count, where it is not far off.
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    slack = 0.04 * float((high - low).max()) or 1.0
    return (float(low[0] - slack), float(high[0] + slack)), (float(low[1] - slack), float(high[1] + slack))


def _ground(
    ax: Axes,
    plane: LightPlane,
    scene: _core.Scene,
    bounds: npt.ArrayLike,
    light: Light,
    renderer: RendererArgument,
) -> None:
    """The scene as the light sees it, pale, within the limits of axes."""
    x, y = ax.get_xlim(), ax.get_ylim()
    scale = SIDE / max(x[1] - x[0], y[1] - y[0])
    size = tuple(max(1, round(scale * (high - low))) for low, high in (x, y))
    matrix = plane.clip_from_world(x, y, bounds, float(getattr(light, "range", 1.0)))
    seen = renderer_of("cpu" if renderer is None else renderer).shadow_map(
        scene, _core.Parameterization.from_matrix(matrix), resolution=size
    )
    relief = pictures.relief(seen).astype(np.float32)
    pale = np.where((seen < 1.0)[..., None], 255.0 - 0.55 * (255.0 - relief), 250.0)
    ax.imshow(np.rint(pale).astype(np.uint8), extent=(*x, *y), interpolation="antialiased", aspect="equal", zorder=0.5)


def _mark_eye(ax: Axes, plane: LightPlane, camera: _core.Camera) -> None:
    """A dot where the eye is, if the light sees it within the axes; parallel rays come from no point."""
    if camera.is_orthographic:
        return
    x, y, w = plane.project(np.asarray(camera.eye)[None])[0]
    if not w > 0:
        return
    ax.plot([x / w], [y / w], "o", color="#202020", markersize=5, markeredgecolor="white", zorder=4, clip_on=True)
    ax.annotate(
        "eye", (x / w, y / w), xytext=(6, -9), textcoords="offset points", fontsize="small", annotation_clip=True,
        bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.8}, zorder=4,
    )  # fmt: skip
