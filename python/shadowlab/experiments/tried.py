"""What an advice tries where nobody says, and what it leaves untried and why."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from .. import _core

#: Why a technique was not drawn: it does not serve a light, it was not asked for, another one that is tried makes the
#: same map, or it was predicted to be worse.
WhyUntried = Literal["light", "not_asked", "same", "predicted"]

#: Techniques whose map is that of another, which serves all of their views and more: only the other is tried.
TWINS: Mapping[str, str] = MappingProxyType({"log": "log_psm"})

#: The settings of techniques that matter: the crop without a warp, the warp as papers place it beside the one that is
#: placed by samples, and depth splits by both schemes with and without a warp in each. Other techniques have their
#: defaults.
SETTINGS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "uniform": ("uniform", "uniform:fit=shadow", "uniform:turn=rectangle,fit=shadow"),
    "lispsm": ("lispsm", "lispsm:fit=seen", "lispsm:near=delta-z,range=body,fit=exact"),
    "log_psm": ("log_psm", "log_psm:warp=lispsm"),
    "z_partition": tuple(
        f"z_partition:count={count}{splits},inner=({inner})"
        for splits in ("", ",splits=equal-log")
        for inner in ("uniform:fit=shadow", "lispsm")
        for count in (2, 3, 4)
    ),
})  # fmt: skip


@dataclass(frozen=True)
class Untried:
    """A technique or candidate that an advice did not draw, so that nothing is said of it.

    Attributes
    ----------
    technique : str
        Its name, as `sl.techniques()` lists it; of one that was predicted to be worse, its label.
    cause : str
        "light" (it does not serve all kinds of light), "not_asked" (other techniques were named), "same" (another one
        that was tried makes its map), or "predicted" (it was predicted to be worse than those drawn).
    lights : tuple of str
        The kinds of light that it does not serve.
    memory : int or None
        The budget with which it was predicted to be worse, bytes; None for all.
    predicted : float or None
        Wrong pixels that were predicted, summed over the views.
    twin : str
        The technique that makes the same map; empty for another cause.
    """

    technique: str
    cause: WhyUntried
    lights: tuple[str, ...] = ()
    memory: int | None = None
    predicted: float | None = None
    twin: str = ""


def default_techniques(kinds: Collection[str]) -> list[str]:
    """What is ranked where nobody says: all techniques that serve these lights, with their settings that matter."""
    names = [spec["name"] for spec in _core.technique_specs() if set(kinds) <= set(spec["lights"])]
    return [text for name in names if TWINS.get(name) not in names for text in SETTINGS.get(name, (name,))]


def untried_of(tried: Iterable[str], kinds: Collection[str]) -> list[Untried]:
    """The techniques of the registry that are not among the names tried, and why."""
    names = set(tried)
    found = []
    for spec in _core.technique_specs():
        if spec["name"] not in names:
            unserved = tuple(sorted(set(kinds) - set(spec["lights"])))
            twin = TWINS.get(spec["name"], "")
            if unserved or twin not in names:
                found.append(Untried(spec["name"], "light" if unserved else "not_asked", unserved))
            else:
                found.append(Untried(spec["name"], "same", twin=twin))
    return found
