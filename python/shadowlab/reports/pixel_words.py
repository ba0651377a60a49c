"""The explanation of a pixel in sentences: the most important line first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..aliasing.causes import MEANINGS
from ..aliasing.codes import LIT_FROM
from ..text import digits, listed, px_text
from .pixel_place_words import depth, depth_text, met_text, point_text, triangle_text
from .pixel_stored_words import held_line, stored_line, too_near_text
from .words import factor

if TYPE_CHECKING:
    from ..aliasing.pixel_surface import PixelSurface
    from ..experiments.pixel_explanation import PixelBlend, PixelExplanation
    from ..experiments.pixel_trials import PixelTrial
    from ..types import Light

# What a wrong pixel is, after the pixel's name.
WRONG = {
    "false shadow": "is wrong: the map shades it, and rays say that it is lit",
    "false light": "is wrong: the map lights it, and rays say that it is in shadow",
}
RIGHT_TEXTS = {"lit": "is right: lit by the map and by rays", "shadow": "is right: in shadow by the map and by rays"}
# What the numbers of a step are, in the order of the chain.
CHAIN_STEPS = ("light_ray", "warped", "clip", "ndc")
STEP_NAMES = {"light_ray": "light ray", "warped": "warped ray", "clip": "clip", "ndc": "NDC"}
# Texels that are listed one by one: those of a lookup of 3 x 3.
MOST_VOTES = 9


def explanation_text(found: PixelExplanation) -> str:
    """The explanation on lines."""
    lines = [first_line(found)]
    if found.surface is None:
        return lines[0]
    lines += [cause_line(found)] if found.cause is not None else []
    lines += mend_lines(found)
    lines += ["", surface_line(found, found.surface), truth_line(found), map_line(found)]
    lines += texel_lines(found)
    return "\n".join(line for line in lines if line is not None)


def first_line(found: PixelExplanation) -> str:
    """What is wrong or right."""
    run = found.run
    maps = f"{found.maps} × " if found.maps > 1 else ""
    of = f"Pixel ({found.x}, {found.y}) of {found.technique} at {maps}{run.resolution}²"
    if found.surface is None:
        seen = "" if found.truth == "nothing" else ", and rays meet one, so that it counts as no error"
        return f"{of} shows no surface{seen}."
    if found.truth == "nothing":
        return f"{of} counts as no error: it shows a surface, and rays meet none."
    if found.verdict in WRONG:
        return f"{of} {WRONG[found.verdict]}. Cause: {found.cause}."
    if found.truth == "undecided":
        said = "lights" if (found.light or 0.0) >= LIT_FROM else "shades"
        return (
            f"{of} counts as no error: the map {said} it, and its truth is undecided, since it changes where rays move "
            "by what single precision resolves."
        )
    return f"{of} {RIGHT_TEXTS[found.truth]}."


def cause_line(found: PixelExplanation) -> str:
    """The cause as a sentence with its numbers."""
    cause, short = found.cause, None if found.comparison is None else found.comparison.shortfall
    assert cause is not None
    if cause == "edge":
        moved = found.edge_px
        by = " elsewhere" if moved is None or not math.isfinite(moved) else f" {px_text(moved)} from where it belongs"
        return f"A silhouette lies between the pixel and its texel's centre: the shadow's edge is drawn{by}."
    if cause == "acne":
        what = "" if short is None or short <= 0 else f" It would take {digits(short)} more towards the light."
        return f"{acne_text(found)}{what}"
    if cause == "leak":
        moved = None if found.comparison is None else found.comparison.bias_world
        by = "" if moved is None else f" by {digits(moved)}"
        spare = 0.0 if short is None else -short
        what = f"With {digits(spare)} less it would be dark." if spare > 0 else "Without bias it would be dark."
        past = "its caster" if found.run.stored.surface == "front" else "what the map stores of its caster"
        return f"The bias carries the receiver{by} towards the light, past {past}. {what}"
    if cause == "missing" and found.map is None:
        return "No map holds the receiver, and what no map holds is lit."
    if cause == "missing" and found.blocker is not None and found.blocker_depth is None:
        return "The caster lies behind the centre of the map's projection, which cuts it off."
    if cause == "missing" and found.blocker_depth is not None and not 0 <= found.blocker_depth < 1:
        return f"The caster lies outside of the map's depths, at NDC depth {digits(found.blocker_depth)}."
    if cause == "missing":
        return too_near_text(found) or (
            "The map does not hold the caster: its shadow passes between the centres of the texels."
        )
    if found.run.stored.surface in ("second", "midpoint", "dual"):
        # Two surfaces in one place: which of them is the second depends on rounding, in a map and for a ray.
        return f"Surfaces lie on one another in the texel, or the map itself is wrong: {MEANINGS[cause]}."
    return f"The map itself is wrong: {MEANINGS[cause]}."


def acne_text(found: PixelExplanation) -> str:
    """Which surface shades a lit one that belongs to it."""
    held, short = found.held, None if found.comparison is None else found.comparison.shortfall
    stored = found.run.stored
    if held is not None and stored.format != "f32" and short is not None and 0 < short <= held.step:
        return (
            f"The surface shadows itself: depths are rounded to {stored.format}, by steps of {digits(held.step)} here, "
            "and the bias does not cover that."
        )
    own = {
        "back": "The surface is shaded by its own far side, which the map stores",
        "second": "The surface is shaded by the surface behind it, which the map stores",
        "midpoint": "The surface is shaded by the middle between it and the surface behind it, which the map stores",
        "dual": "The surface is shaded by its own depth, moved away from the light as far as the map does",
    }
    if stored.surface in own:
        return f"{own[stored.surface]}: the bias does not cover what that depth changes within the texel."
    return "The surface shadows itself: the bias does not cover what its depth changes within the texel."


def mend_lines(found: PixelExplanation) -> list[str]:
    """What makes the pixel right, and what does not."""
    if not found.trials:
        return []
    lines = []
    for trial in found.mends:
        lines.append(f"  {trial.text}: {trial_outcome(trial)}")
    head = "Right with" if lines else "Nothing that was tried makes it right."
    without = [trial.text for trial in found.trials if not trial.is_right and not trial.failure and not trial.part]
    parts = [trial.part for trial in found.trials if not trial.is_right and trial.part]
    tail = [f"Still wrong with {listed(without)}."] if without else []
    tail += [f"No change of the bias's {listed(parts)} alone mends it."] if parts else []
    tail += [f"Not tried: {trial.text} ({trial.failure})." for trial in found.trials if trial.failure]
    return [f"{head}:" if lines else head, *lines, *tail]


def trial_outcome(trial: PixelTrial) -> str:
    """What a trial makes of the picture and of the pixels around."""
    wrong, before = trial.wrong or 0, trial.wrong_before
    picture = f"{before:,} wrong pixels become {wrong:,}"
    if before and factor(wrong / before) != "1":
        picture += f" ({factor(wrong / before)} times)"
    return f"{picture}; within 16 px {trial.mended:,} become right and {trial.broken:,} wrong"


def surface_line(found: PixelExplanation, surface: PixelSurface) -> str:
    """What the pixel sees, and how it stands to the light."""
    angle = math.degrees(math.acos(min(1.0, max(-1.0, surface.light_cosine))))
    light: Light = found.run.view.lights[0]
    stands = (
        f"the light is {angle:.1f}° from its normal"
        if surface.faces_light
        else f"it faces away from the light ({angle:.1f}° from its normal)"
        if surface.light_cosine <= 0
        else f"it is beyond the reach of the {light.kind} light"
    )
    return (
        f"Surface: {triangle_text(surface.instance, surface.triangle)} at {point_text(surface.point)}, "
        f"{digits(surface.eye_depth)} deep in the view; {stands}."
    )


def truth_line(found: PixelExplanation) -> str:
    """What truth's ray says."""
    if found.surface is None or not found.surface.faces_light:
        return "Truth: in shadow by definition, so that it counts as no error in any map."
    if found.blocker is not None:
        return f"Truth: {found.truth}; the ray to the light meets {met_text(found.blocker)}."
    if found.truth == "lit":
        return "Truth: lit; nothing is on the way to the light."
    return f"Truth: {found.truth}; the ray to the light grazes an edge."


def map_line(found: PixelExplanation) -> str:
    """Which map serves the pixel, and why."""
    if found.map is None:
        none = {
            "outside": "none holds the point, and what no map holds is lit.",
            "averted": "none is asked where no light can arrive.",
        }
        return f"Map: {none.get(found.reason, 'none is asked.')}"
    told = stored_line(found.run.stored)
    tail = "" if told is None else f" {told}"
    if found.reason == "only":
        return f"Map: the only one.{tail}"
    if found.blend is not None:
        return f"Map: {blend_text(found.blend)} Explained here: {found.map + 1} of {found.maps}.{tail}"
    near, far = found.eye_depth or (0.0, math.inf)
    why = {
        "depth": f"the first whose depths, {digits(near)} to {digits(far)}, reach the point",
        "later": "maps before it reach this depth and do not hold the point",
        "containment": "the first that holds the point",
    }[found.reason]
    return f"Map: {found.map + 1} of {found.maps}, {why}.{tail}"


def blend_text(blend: PixelBlend) -> str:
    """How two maps blend at the pixel."""
    parts = [
        f"{index + 1} with a share of {share:.3g}, by which the pixel is {light:.3g} lit"
        for index, share, light in zip(blend.maps, blend.shares, blend.lights, strict=True)
    ]
    return f"{' and '.join(parts)}."


def texel_lines(found: PixelExplanation) -> list[str]:
    """The chain, the texel, what it stores, and the comparison."""
    chain, texel, held, comparison = found.chain, found.texel, found.held, found.comparison
    if chain is None or texel is None or held is None or comparison is None:
        return []
    lines = []
    for name in CHAIN_STEPS:
        value = getattr(chain, name)
        if value is not None:
            lines.append(f"  {STEP_NAMES[name]:<10} {point_text(value)}")
    size = "" if texel.size_px is None else f"; {' x '.join(map(digits, texel.size_px))} px in the picture"
    across = " x ".join(map(digits, texel.size_world))
    lines.append(
        f"Texel: column {texel.column}, row {texel.row}, the point at {point_text(chain.place)}{size}; {across} in the "
        "world, across the ray."
    )
    lines.append(held_line(found, held))
    if comparison.unbiased is None:
        return [*lines, "Comparison: lit without one, since the point lies before the near plane."]
    if comparison.reference is None:
        return [
            *lines,
            "Comparison: lit without one, since the bias carries the point past the light or the near plane.",
        ]
    parts = [f"{part.name} {depth_text(part.ndc)} ({digits(part.world)})" for part in comparison.parts]
    lowered = depth_text(comparison.unbiased - comparison.reference)
    bias = f"; bias {lowered} ({digits(comparison.bias_world)} towards the light)" if parts else ""
    of = f"; each alone: {', '.join(parts)}" if len(parts) > 1 else ""
    said = "lit" if comparison.light >= LIT_FROM else "in shadow"
    unbiased = f"{depth(comparison.unbiased)} without bias" if parts else "without any bias"
    lines.append(f"Comparison: reference {depth(comparison.reference)}, {unbiased}{bias}{of}.")
    votes = [
        f"({read.column}, {read.row}) {depth(read.held.depth)} {'lit' if read.is_lit else 'dark'}, "
        f"weight {read.weight:.3g}"
        for read in comparison.reads
    ]
    if len(votes) > MOST_VOTES:
        lit = sum(read.is_lit for read in comparison.reads)
        lines.append(
            f"Verdict: {said}; {lit} of the {len(votes)} texels that are read are lit, "
            f"{comparison.light:.3g} by weight."
        )
    else:
        lines.append(f"Verdict: {said}" + (f"; {'; '.join(votes)}." if len(votes) > 1 else "."))
    return lines
