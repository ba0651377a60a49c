"""What a texel holds in words: its number, where that is, and whose it is, for all that maps can store."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..text import digits
from .pixel_place_words import depth, triangle_text

if TYPE_CHECKING:
    from .._core import Stored
    from ..aliasing.pixel_held import Held
    from ..aliasing.pixel_surface import Met
    from ..experiments.pixel_explanation import PixelExplanation

# What maps store of each ray, after "stores".
SURFACE_TEXTS = {
    "front": "the surface nearest to the light",
    "back": "the nearest surface whose outer side is averted from the light",
    "second": "the second surface that the light meets",
    "midpoint": "the middle between the first and the second surface that the light meets",
    "dual": "the first surface, moved half way to the second",
}
# Why nothing is stored of a ray that does meet a surface.
WITHOUT = {
    "back": "and behind it none whose outer side is averted from the light",
    "second": "and nothing behind it",
    "midpoint": "and nothing behind it",
    "dual": "which is moved beyond the map's depths",
}


def stored_line(stored: Stored) -> str | None:
    """What the map stores; None of the plain depth."""
    said = [f"It stores {SURFACE_TEXTS[stored.surface]}."] if stored.surface != "front" else []
    how = ["spaced linearly along the light"] if stored.spacing != "projective" else []
    how += [f"rounded to {stored.format}"] if stored.format != "f32" else []
    said += [f"Its depths are {' and '.join(how)}."] if how else []
    return " ".join(said) or None


def held_line(found: PixelExplanation, held: Held) -> str:
    """What the texel stores, and whose that is."""
    stored = found.run.stored
    if held.is_empty:
        return f"Stored: no caster{_why_empty(found, held)}."
    where = ""
    if held.gap is not None:
        side = "before" if held.gap >= 0 else "behind"
        where = f", {digits(abs(held.gap))} {side} the receiver's plane along the ray"
    if stored.format != "f32":
        where += f", in steps of {digits(held.step)}"
    if not held.surfaces:
        return f"Stored: depth {depth(held.depth)}{where}; the ray through the texel's centre meets nothing there."
    names = [triangle_text(met.instance, met.triangle) + note(found, met) for met in held.surfaces]
    whose = {
        "front": names[0],
        "back": f"{names[0]}, seen from behind",
        "second": f"{names[0]}{_behind(found, held)}",
        "midpoint": f"half way from {' to '.join(names)}",
        "dual": f"moved from {' towards '.join(names)}",
    }[stored.surface]
    if stored.surface == "dual" and len(names) == 1:
        whose += ", behind which nothing is"
    tail = "" if held.agrees else f"; a ray from the light gives a depth {digits(held.difference)} away from that"
    return f"Stored: depth {depth(held.depth)}{where}: {whose}{tail}."


def note(found: PixelExplanation, met: Met) -> str:
    """What else a triangle is, in parentheses."""
    blocker, surface = found.blocker, found.surface
    name = (met.instance, met.triangle)
    if blocker is not None and name == (blocker.instance, blocker.triangle):
        return " (what truth's ray meets)"
    if surface is not None and name == (surface.instance, surface.triangle):
        return " (the pixel's own)"
    return " (of the pixel's own instance)" if surface is not None and met.instance == surface.instance else ""


def too_near_text(found: PixelExplanation) -> str | None:
    """Why the texel of a missing caster lights the pixel, where light meets one at its centre, too; None elsewhere."""
    held, own = found.held, found.surface
    if held is None or held.first is None or held.first_gap is None or own is None or held.first_gap <= 0.0:
        return None
    if (held.first.instance, held.first.triangle) == (own.instance, own.triangle):
        return None
    head = (
        "The map does not hold the caster: at the texel's centre, too, the light meets one, but what the map stores of"
    )
    if held.gap is None or held.gap <= 0.0:
        return f"{head} that ray does not lie above the receiver. The caster is open, or touches the receiver."
    return (
        f"{head} it lies only {digits(held.gap)} above the receiver's plane. The receiver's own depth changes more "
        "within the texel."
    )


def _behind(found: PixelExplanation, held: Held) -> str:
    first = held.first
    return "" if first is None else f", behind {triangle_text(first.instance, first.triangle)}{note(found, first)}"


def _why_empty(found: PixelExplanation, held: Held) -> str:
    """Why a texel stores no caster, where its ray meets something."""
    first, stored = held.first, found.run.stored
    if first is None:
        return "" if held.agrees else "; the ray through its centre does meet one"
    met = f"the ray through its centre meets {triangle_text(first.instance, first.triangle)}{note(found, first)}"
    if held.ray_depth is not None:
        rounded = f", whose depth {depth(held.ray_depth)} is rounded to that" if held.agrees else ""
        return f"; {met}{rounded}"
    return f"; {met}, {WITHOUT[stored.surface]}" if stored.surface in WITHOUT else f"; {met}"
