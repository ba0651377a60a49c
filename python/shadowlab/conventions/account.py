"""What is said about two matrices: a diagnosis in words, and how much it explains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .lights import angle_between, same_light
from .pair import SAME_DEPTH, Explanation, Pair
from .search import NO_PLACES, OPPOSITE

# Entries of single precision, multiplied a few times, stand a few 2^-24 apart.
SAME_SCALE = 1e-6
# Depths of theirs by slope and start of ours, where a change of the range was made once too often.
BIASED_ONCE = "depths biased by 0.5 z + 0.5 though they are in [0, 1] without: OpenGL's bias on another range"
DEPTH_MISTAKES = {
    (0.5, 0.5): BIASED_ONCE,
    (0.25, 0.75): "depths biased by 0.5 z + 0.5 twice",
    (4.0, -3.0): "depths turned into [-1, 1] by 2 z - 1 twice",
}


@dataclass(frozen=True)
class Account:
    """An explanation of what sets theirs apart from ours, all of it in words.

    `rank` orders accounts by places and then by depths, the better one lower. Places: 0 where nothing is left over of
    depths either, 1 where a convention or a mistake explains them, 2 for another crop, 3 for another map of one light,
    4 otherwise. Depths: 0 where they are the same, 1 or 2 for a mistake, whose words are `depths`, 3 otherwise.
    """

    pair: Pair
    found: Explanation
    differences: tuple[str, ...]
    rank: tuple[int, int]
    depths: str = ""


def account_of(pair: Pair, found: Explanation) -> Account:
    """An explanation in words: what it names, a factor of the matrix, other depths, or what no convention explains."""
    differences = [*found.differences, *scale_of(found, pair)]
    mistaken = depth_mistake(found, pair)
    if mistaken:
        differences.append(mistaken)
    elif is_other_depth(found):
        differences.append(f"depths differ by up to {found.depth:.3g} of the range: other near and far planes")
    if pair.who == "mine":
        # Words are about theirs unless they say otherwise.
        named = ("mine ", "maps ", "a world ")
        differences = [words if words.startswith(named) else f"mine: {words}" for words in differences]
    if is_same(found):
        places = 0
    elif found.whole or found.mistaken or OPPOSITE in found.differences:
        places = 1
    elif found.named:
        places = 2
    else:
        places = 3 if same_light(pair, found.convention) else 4
    if not (is_same(found) or found.named):
        differences.append(real_difference(found, pair))
    depths = 0 if found.depth <= SAME_DEPTH else 3 if not mistaken else 2 if mistaken == BIASED_ONCE else 1
    return Account(pair, found, tuple(differences), (places, depths), mistaken)


def better_of(first: Account, second: Account) -> Account:
    """The better account, or the first; with a mistake in depths that says as much from the other side."""
    best, other = (first, second) if first.rank <= second.rank else (second, first)
    as_likely = bool(best.depths) or (best is second and is_same(best.found))
    if other.depths and as_likely and max(best.rank[0], other.rank[0]) <= 1:
        *rest, last = best.differences
        return replace(best, differences=(*rest, f"{last}, or {other.pair.who}: {other.depths}"))
    return best


def is_same(found: Explanation) -> bool:
    """Whether an explanation leaves nothing over."""
    return found.whole and found.depth <= SAME_DEPTH


def scale_of(found: Explanation, pair: Pair) -> tuple[str, ...]:
    """A constant factor of the whole matrix, which no map shows."""
    if not found.whole:
        return ()
    # Rows of places alone: depths may have a range of their own.
    mine = pair.ours[:, [0, 1, 3]]
    other = found.convention.to_ours(pair.theirs)[:, [0, 1, 3]]
    factors = np.sum(mine * other, axis=(1, 2)) / np.sum(mine * mine, axis=(1, 2))
    if np.all(np.abs(factors - 1.0) <= SAME_SCALE):
        return ()
    texts = " and ".join(dict.fromkeys(f"{factor:.6g}" for factor in factors))
    if factors.min() < 0:
        return (f"scaled by {texts}: the same map, but w is negative, so that hardware clips all of it",)
    return (f"scaled by {texts}, which no map shows",)


def is_other_depth(found: Explanation) -> bool:
    """Whether depths differ where places do not, by more than their direction."""
    return found.depth > SAME_DEPTH and found.crop and OPPOSITE not in found.differences


def depth_mistake(found: Explanation, pair: Pair) -> str:
    """The words for a change of the range of depths that was made once too often; none where there was none."""
    if is_other_depth(found):
        q = pair.project(found.convention.changed(**NO_PLACES).to_ours(pair.theirs))
        mine = 1.0 - pair.ndc[:, 2] if found.convention.reversed_z else pair.ndc[:, 2]
        for (slope, start), words in DEPTH_MISTAKES.items():
            # The check fails for infinite q too.
            if np.abs(q[:, 2] - (slope * mine + start)).max() <= SAME_DEPTH:
                return words
    return ""


def real_difference(found: Explanation, pair: Pair) -> str:
    """A difference that no convention explains."""
    finite = np.isfinite(found.texels)
    behind = f"some points of {pair.whose} lie behind its centre"
    apart = f"up to {texels_text(found.texels)} apart" if finite else behind
    if same_light(pair, found.convention):
        return f"another warp or crop of the same light: {apart}"
    angle = angle_between(pair)
    turned = "" if angle is None else f"; the directions are {angle:.3g}° apart"
    return f"another light: {apart}{turned}"


def texels_text(texels: float) -> str:
    """A number of texels, three digits where it has fewer than four before the point."""
    return f"{texels:,.0f} texels" if texels >= 100 else f"{texels:.3g} texels"
