r"""A cut through a receiver in the plane of its normal and the ray to the light: what is compared at a pixel.

 \        \  light                 Across: along the receiver's plane. Up: its normal, in world units at one scale.
  \    ----x  stored               Each line of equal depth in the map is straight, since NDC depth is a quotient of
---\--------\-------- reference    affine functions: what is stored on the light's side of the reference shades.
    o  bias  \
_____\________\______ receiver
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..aliasing.codes import LIT_FROM
from ..experiments.run import done
from ..text import digits
from .axes import SOFT, say

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..experiments.pixel_explanation import PixelExplanation
    from ..types import Vector

# What light meets before what is stored.
CUT_FIRST = "#56B4E9"
# Of the pixel, its texel, what is stored, what truth's ray meets and what is compared: apart for all colour vision.
CUT_PIXEL, CUT_TEXEL, CUT_STORED, CUT_BLOCKER, CUT_REFERENCE = "#000000", "#E69F00", "#009E73", "#CC79A7", "#0072B2"
# What is higher than so many texels or biases is drawn at the edge with its distance.
TALLEST = 8.0
# Gaps that are none to the eye, in parts of the longest thing.
ON_PLANE = 2e-3
# Width of the picture in units of what is in it.
CUT_MARGIN = 1.35
# Width by height of what fits above the receiver's plane.
HIGH_FOR_WIDE = 1.5
LABEL: dict[str, Any] = {
    "fontsize": "small", "textcoords": "offset points",
    "bbox": {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.8},
}  # fmt: skip


@dataclass(frozen=True)
class Cut:
    """The plane of a receiver's normal and its ray: `across` along the receiver, `up` its normal, from its point."""

    point: Vector
    across: Vector
    up: Vector

    def of(self, p_world: Vector) -> Vector:
        """(2,): across and up of a world point, what stands out of the plane left out."""
        away = p_world - self.point
        return np.array([away @ self.across, away @ self.up])


def cut_view(found: PixelExplanation, ax: Axes) -> Axes:
    """The cut through the receiver on axes."""
    ax.set(title="cut along the ray and the normal", xticks=[], yticks=[])
    surface, texel, held, comparison = found.surface, found.texel, found.held, found.comparison
    if surface is None or texel is None or held is None or comparison is None:
        say(ax, "no light can arrive" if found.reason == "averted" else "no map is asked")
        return ax
    cut = plane_of(surface.point, surface.normal, surface.to_light)
    ray = np.array([surface.to_light @ cut.across, surface.to_light @ cut.up])
    side = max(texel.size_world) / max(ray[1], 0.05)
    moved = abs(comparison.bias_world)
    unit = max(0.6 * side, moved, 1e-30)
    centre = None if texel.centre is None else np.array([cut.of(texel.centre)[0], 0.0])
    stored = None if centre is None or held.gap is None else centre + held.gap * ray
    blocker = None if found.blocker is None else found.blocker.distance * ray
    met = [] if centre is None else [(name, centre + gap * ray) for name, gap in met_gaps(found)]
    seen = [np.zeros(2), comparison.bias_world * ray, centre, stored, blocker, *(at for _, at in met)]
    window(ax, [at for at in seen if at is not None and np.linalg.norm(at) <= TALLEST * unit], unit)
    (left, right), low = ax.get_xlim(), ax.get_ylim()[0]
    reach = 0.5 * (right - left)
    ax.axhspan(low, 0.0, color="#E9E6E0", zorder=0)
    ax.axhline(0.0, color=CUT_PIXEL, linewidth=2.0, zorder=2)
    ax.annotate(
        "receiver's plane", (left, 0.0), xytext=(4, -11), color=SOFT, fontsize="small", textcoords="offset points"
    )
    if texel.corners is not None:
        extent = np.array([cut.of(corner)[0] for corner in texel.corners])
        ax.plot([extent.min(), extent.max()], [0, 0], color=CUT_TEXEL, linewidth=6, solid_capstyle="butt", zorder=2.5)
        middle = float(np.clip(extent.mean(), left + 0.2 * reach, right - 0.2 * reach))
        ax.annotate("the texel", (middle, 0.0), xytext=(0, -22), ha="center", color=CUT_TEXEL, **LABEL)
    draw_ray(ax, np.zeros(2), ray, reach, CUT_PIXEL, "-")
    if centre is not None:
        draw_ray(ax, centre, ray, reach, CUT_TEXEL, (0, (5, 3)))
    draw_reference(found, ax, cut, reach)
    if moved > 0:
        end = comparison.bias_world * ray
        arrow = {"arrowstyle": "<->", "color": CUT_REFERENCE, "linewidth": 1.8}
        ax.annotate("", (end[0], end[1]), (0, 0), arrowprops=arrow, zorder=4)
        mark(ax, 0.5 * end, f"bias {digits(comparison.bias_world)}", CUT_REFERENCE, (-6, 4), "right")
    ax.plot(0, 0, "o", color=CUT_PIXEL, markeredgecolor="white", markersize=7, zorder=5)
    for name, at in met:
        put(ax, at, "v", name, CUT_FIRST, below=True)
    if stored is not None and held.gap is not None:
        side = "before" if held.gap >= 0 else "behind"
        far = "on the plane" if abs(held.gap) < ON_PLANE * unit else f"{digits(abs(held.gap))} {side} the plane"
        put(ax, stored, "s", f"stored, {far}", CUT_STORED)
    elif held.is_empty:
        corner: dict[str, Any] = {"xycoords": "axes fraction", "xytext": (-6, -14), "ha": "right"}
        ax.annotate("the texel stores no caster", (1, 1), color=CUT_STORED, **corner, **LABEL)
    if found.blocker is not None and blocker is not None:
        put(ax, blocker, "D", f"blocker, {digits(found.blocker.distance)} away", CUT_BLOCKER, below=True)
    said = "lit" if comparison.light >= LIT_FROM else "in shadow"
    ax.set_xlabel(f"the map says {said}, rays say {found.truth}; scale bar in world units", fontsize="small")
    scale_bar(ax)
    return ax


def met_gaps(found: PixelExplanation) -> list[tuple[str, float]]:
    """What light meets on the ray of the texel's centre that is not itself stored: name and gap."""
    held, surface = found.held, found.run.stored.surface
    if held is None or held.first_gap is None or surface == "front":
        return []
    gaps = [("first surface", held.first_gap)]
    if len(held.surfaces) > 1:
        first, second = (met.distance for met in held.surfaces)
        gaps.append(("second surface", held.first_gap - (second - first)))
    own = held.gap if len(held.surfaces) == 1 and surface != "dual" else None
    # An averted face that is met first is what is stored.
    return [(name, gap) for name, gap in gaps if own is None or abs(gap - own) > ON_PLANE * max(abs(gap), abs(own))]


def plane_of(point: Vector, normal: Vector, to_light: Vector) -> Cut:
    """The cut through a point; light from straight above cuts along any direction of the receiver."""
    across = to_light - (to_light @ normal) * normal
    if np.linalg.norm(across) < 1e-6:
        across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    # The light comes from the left.
    return Cut(point, -across / np.linalg.norm(across), normal)


def draw_ray(ax: Axes, foot: Vector, ray: Vector, reach: float, colour: str, line: Any) -> None:
    """A ray of light that ends on the receiver's plane or behind it."""
    ends = np.array([foot - 0.4 * reach * ray, foot + 4.0 * reach * ray])
    ax.plot(*ends.T, color=colour, linewidth=1.2, linestyle=line, zorder=3)


def draw_reference(found: PixelExplanation, ax: Axes, cut: Cut, reach: float) -> None:
    """The line of the reference depth, above which what is stored shades, and that of the depth without bias."""
    comparison = found.comparison
    if comparison is None or comparison.reference is None or comparison.unbiased is None or found.map is None:
        return
    origin = np.asarray(done(found.run.gbuffer).origin, np.float64)
    rows = _core.depth_rows(done(found.run.parameterization), origin, found.run.stored)[found.map]
    for depth, colour, line, name in (
        (comparison.unbiased, SOFT, (0, (2, 2)), "depth of the receiver without bias"),
        (comparison.reference, CUT_REFERENCE, (0, (6, 2)), "reference depth: what is stored on its blue side shades"),
    ):  # fmt: skip
        plane = rows[0] - depth * rows[1]
        x, y = np.meshgrid(ax.get_xlim(), ax.get_ylim())
        here = plane[:3] @ (cut.point - origin) + plane[3]
        # Affine, so that four corners say all of it; below 0 nearer to the light.
        nearer = here + (plane[:3] @ cut.across) * x + (plane[:3] @ cut.up) * y
        low = float(nearer.min())
        if low >= 0 or float(nearer.max()) <= 0:
            continue
        if colour == CUT_REFERENCE:
            ax.contourf(x, y, nearer, levels=[low, 0.0], colors=[CUT_REFERENCE], alpha=0.10, zorder=1)
        ax.contour(x, y, nearer, levels=[0.0], colors=[colour], linewidths=1.5, linestyles=[line], zorder=2.8)
        ax.plot([], [], color=colour, linewidth=1.5, linestyle=line, label=name)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), frameon=False, fontsize="small")


def mark(ax: Axes, at: Vector, words: str, colour: str, shift: tuple[int, int], ha: str) -> None:
    """Words beside a place."""
    ax.annotate(words, (at[0], at[1]), xytext=shift, ha=ha, color=colour, zorder=6, **LABEL)


def window(ax: Axes, seen: list[Vector], unit: float) -> None:
    """Limits around places, at one scale, with a part of the receiver below its plane."""
    low, high = np.min(seen, axis=0), np.max(seen, axis=0)
    width = max(float(high[0] - low[0]), HIGH_FOR_WIDE * float(high[1] - low[1]), 1.5 * unit) * CUT_MARGIN
    middle = 0.5 * float(low[0] + high[0])
    below = min(float(low[1]) - 0.08 * width, -0.16 * width)
    limits = {"xlim": (middle - 0.5 * width, middle + 0.5 * width), "ylim": (below, below + 0.85 * width)}
    ax.set(**limits, aspect="equal", autoscale_on=False)


def put(ax: Axes, at: Vector, marker: str, words: str, colour: str, *, below: bool = False) -> None:
    """A marker with words above or below it; at the edge of the axes, with an arrow, where it lies beyond."""
    low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
    room = 0.06 * (high - low)
    place = np.clip(at, low + room, high - room)
    right = place[0] > 0.5 * (low[0] + high[0])
    across, ha = (-9, "right") if right else (9, "left")
    shift = (across, -12 if below else 5)
    mark(ax, place, words, colour, shift, ha)
    if (at > low).all() and (at < high).all():
        ax.plot(*at, marker, color=colour, markeredgecolor="white", markersize=9, zorder=5)
        return
    way = (at - place) / np.linalg.norm(at - place)
    arrow = {"arrowstyle": "->", "color": colour, "linewidth": 2.0}
    tip = place + 0.9 * float(room.min()) * way
    ax.annotate("", (tip[0], tip[1]), (place[0], place[1]), arrowprops=arrow, zorder=5)


def scale_bar(ax: Axes) -> None:
    """A bar of a round length at the lower right."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    exponent = np.floor(np.log10(0.3 * (right - left)))
    length = float(max(m * 10**exponent for m in (1.0, 2.0, 5.0) if m * 10**exponent <= 0.3 * (right - left)))
    x, y = right - 0.04 * (right - left), low + 0.04 * (high - low)
    ax.plot([x - length, x], [y, y], color=SOFT, linewidth=3, solid_capstyle="butt")
    where: dict[str, Any] = {"xytext": (0, 4), "ha": "center", "textcoords": "offset points"}
    ax.annotate(digits(length), (x - 0.5 * length, y), color=SOFT, fontsize="small", **where)
