"""Maps that are held while the camera moves, so that shadows do not shimmer: the state around a technique.

A technique is a pure function: its maps follow every step of the camera, and with them the lattice of texels. Here maps
are made with slack and kept while they serve, as an engine would keep them (theory.md 10.6).

```
  samples of the frame -> do the kept maps hold them?          no -> made anew
                          are they about as good as new ones?  no -> made anew
                          yes -> the same maps, bit for bit
```

Source: Chong, Gortler 2007 [chong2007] for the hysteresis. Departures: maps have slack from the start, and what is
compared is the capped width of texels across the edges of visible shadows (theory.md (10.8), (10.11)).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..text import shown
from ..text.checks import check_camera, check_light, check_scene, pair, whole
from ..travel import Value
from .registry import technique as named
from .variant import READ_SETTINGS, Variant

if TYPE_CHECKING:
    from ..types import Light, Size

#: Factor by which maps are larger than what their samples span, and times that kept maps may be as coarse as new ones.
#: docs/temporal.md says how they were chosen.
SLACK, GAIN = 1.08, 1.15


@dataclass(frozen=True, eq=False)
class HeldMaps(Value):
    """The maps that are kept, and what they were made for."""

    parameterization: _core.Parameterization
    scene: str
    light: Light
    resolution: tuple[int, ...]

    def unlike(self, scene: str, light: Light, resolution: tuple[int, ...]) -> str:
        """What differs from what they were made for; empty where nothing does."""
        if scene != self.scene:
            return "the scene changed"
        if light != self.light:
            return "the light moved"
        return "" if resolution == self.resolution else "another resolution"


@dataclass(frozen=True, eq=False)
class History(Value):
    """What a fit remembers."""

    kept: HeldMaps | None = None
    frames: int = 0
    fits: int = 0
    reason: str = ""
    cost: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class TemporalFit(Value):
    """A technique whose maps are held along a camera's path, so that shadows do not shimmer.

    A call of `parameterize` returns the maps of the call before, bit for bit, while they hold every sample that counts
    and their texels are about as good as those of new maps. A camera that stands still never gets another map. One
    `TemporalFit` serves one light and one camera at a time; it stands for a technique in `sl.aliasing.temporal`.
    What it remembers counts for equality and travels in pickles.

    Parameters
    ----------
    technique : Technique or str
        What makes the maps: any technique that fits each of its maps to samples (``fit="shadow"`` or ``fit="seen"``).
    slack : float
        Factor by which a map is larger, along each side, than what its samples span in it, 1 to 2. It replaces the
        technique's own `slack`.
    gain : float
        Kept maps are given up where the mean capped width of their texels across the edges of visible shadows
        (`Samples.edge_width`) is more than this times that of new maps; at least 1. ``math.inf`` keeps them as long as
        they hold the samples.

    Attributes
    ----------
    parameterization : Parameterization or None
        The maps that are kept; None before the first call.
    kept : bool
        Whether the last call returned the maps of the one before.
    reason : str
        Why the last call made new maps: "first", "the scene changed", "the light moved", "another resolution", "samples
        left the maps: 12", or "cost 1.21 times a fresh fit's". Empty where it kept them.
    cost : float or None
        Width of the kept maps' texels by that of new ones at the last call; None where none were made to compare.
    frames, fits : int
        Calls, and how many of them made new maps.

    Raises
    ------
    ArgumentError
        For a technique that does not fit each of its maps to samples, and numbers out of range.
    UnknownNameError
        For a technique that does not exist.

    References
    ----------
    docs/theory.md 10.6; Chong, Gortler 2007 [chong2007].

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> fit = sl.TemporalFit("scene_optimal", slack=1.1, gain=1.15)
    >>> first = fit.parameterize(scene, scene.camera, scene.light, resolution=512)
    >>> fit.reason
    'first'
    >>> fit.parameterize(scene, scene.camera, scene.light, resolution=512) == first, fit.kept, fit.fits
    (True, True, 1)
    """

    technique: _core.Technique = field(default="scene_optimal")  # type: ignore[assignment]  # a text is resolved
    slack: float = SLACK
    gain: float = GAIN
    _history: History = field(default=History(), init=False)

    if TYPE_CHECKING:
        # What may be given is more than what is kept.
        def __init__(
            self, technique: _core.Technique | str = "scene_optimal", slack: float = SLACK, gain: float = GAIN
        ) -> None: ...

    def __post_init__(self) -> None:
        numbers = {name: number_of(name, getattr(self, name)) for name in ("slack", "gain")}
        if not numbers["gain"] >= 1:
            raise ArgumentError(f"gain: expected a number, 1 or more, got {shown(self.gain)}; 1.15 is the default")
        given: object = self.technique
        made = named(given) if isinstance(given, str) else given
        if isinstance(made, Variant):
            read = [name for name in READ_SETTINGS if name in made.settings]
            raise ArgumentError(
                f"technique: expected one that says nothing of how its maps are read, got {', '.join(read)} in "
                f"{shown(given if isinstance(given, str) else made)}; a TemporalFit makes matrices: give that to what "
                "draws and reads the maps"
            )
        if not isinstance(made, _core.Technique):
            raise ArgumentError(
                f"technique: expected a Technique or its name, got {shown(made)}; maps that are given and presets are "
                "not fitted to samples"
            )
        object.__setattr__(self, "technique", made.with_slack(numbers["slack"]))
        for name, value in numbers.items():
            object.__setattr__(self, name, value)

    @property
    def name(self) -> str:
        """Its name in tables."""
        return "temporal_fit"

    @property
    def settings(self) -> Mapping[str, Any]:
        """The technique as text, slack and gain."""
        return {"technique": self.technique.text, "slack": self.slack, "gain": self.gain}

    @property
    def needs_samples(self) -> bool:
        """It always looks at what the camera sees."""
        return True

    @property
    def needs_shadows(self) -> bool:
        """And at which of that is in shadow."""
        return True

    @property
    def parameterization(self) -> _core.Parameterization | None:
        """The maps that are kept."""
        return None if self._history.kept is None else self._history.kept.parameterization

    @property
    def kept(self) -> bool:
        """Whether the last call returned the maps of the one before."""
        return self._history.frames > 0 and not self._history.reason

    @property
    def reason(self) -> str:
        """Why the last call made new maps; empty where it kept them."""
        return self._history.reason

    @property
    def cost(self) -> float | None:
        """Width of the kept maps' texels by that of new ones at the last call."""
        return self._history.cost

    @property
    def frames(self) -> int:
        """Calls so far."""
        return self._history.frames

    @property
    def fits(self) -> int:
        """Calls that made new maps."""
        return self._history.fits

    def reset(self) -> None:
        """Forgets the maps and the counts."""
        object.__setattr__(self, "_history", History())

    def fresh(self) -> TemporalFit:
        """One with the same settings that has made no maps yet."""
        return TemporalFit(self.technique, self.slack, self.gain)

    def parameterize(
        self,
        scene: _core.Scene,
        camera: _core.Camera,
        light: Light,
        *,
        resolution: Size = 1024,
        samples: _core.Samples | _core.GBuffer | None = None,
    ) -> _core.Parameterization:
        """The maps for the next frame: those of the frame before where they serve, else new ones.

        Parameters
        ----------
        scene : Scene
        camera : Camera
        light : DirectionalLight, SpotLight or PointLight
        resolution : int or (int, int)
            Texels along the sides of each map.
        samples : Samples or GBuffer, optional
            What the camera sees, as of `Technique.parameterize`; samples must have the shadow states of the light. A
            picture of about 128 by 128 pixels is drawn where none is given.

        Returns
        -------
        Parameterization

        Raises
        ------
        UnsupportedError
            The technique does not serve this kind of light, or new maps for this view. The maps and counts stay as they
            were.
        ArgumentError
            An argument of the wrong type or outside its range, or samples without the shadow states of the light.
        """
        check_scene(scene)
        check_camera(camera)
        check_light(light)
        seen = samples_of(scene, camera, light, samples)
        single = isinstance(resolution, (int, np.integer))
        width, height = (resolution, resolution) if single else pair("resolution", resolution)
        sides = whole("resolution", width), whole("resolution", height)
        before, made_for = self._history, (scene.content_hash, light, sides)

        def make() -> _core.Parameterization:
            return self.technique.parameterize(scene, camera, light, resolution=resolution, samples=seen)

        kept, cost, new = before.kept, None, None
        reason = "first" if kept is None else kept.unlike(*made_for)
        if kept is not None and not reason:
            reason, cost, new = self._judged(kept.parameterization, seen, make)
        if kept is None or reason:
            kept = HeldMaps(make() if new is None else new, *made_for)
        after = History(kept, before.frames + 1, before.fits + bool(reason), reason, cost)
        object.__setattr__(self, "_history", after)
        return kept.parameterization

    def _judged(
        self, kept: _core.Parameterization, seen: _core.Samples, make: Callable[[], _core.Parameterization]
    ) -> tuple[str, float | None, _core.Parameterization | None]:
        """Why the kept maps do not serve, and their width by that of new maps with these, where they were made."""
        holds = cast('Literal["shadow", "seen"]', self.technique.holds)  # others were refused
        if missed := seen.missed(kept, holds):
            return f"samples left the maps: {missed}", None, None
        width = seen.edge_width(kept)
        if width == 0 or self.gain == math.inf:
            return "", None, None  # without an edge in the picture nothing can be gained
        new = make()
        cost = width / seen.edge_width(new)
        if cost <= self.gain:  # (10.11)
            return "", cost, new
        return f"cost {cost:.2f} times a fresh fit's", cost, new

    def __repr__(self) -> str:
        head = f"TemporalFit({self.technique.text!r}, slack={self.slack:g}, gain={self.gain:g}"
        return f"{head}: {self.fits} fits in {self.frames} frames)"


def samples_of(scene: _core.Scene, camera: _core.Camera, light: Light, samples: object) -> _core.Samples:
    """The samples with the shadow states of a light: those given, of the picture given, or of one drawn.

    Raises
    ------
    ArgumentError
        For samples of another light, and something else.
    """
    if samples is None or isinstance(samples, _core.GBuffer):
        return _core.drawn_samples(scene, camera, light, samples)
    if not isinstance(samples, _core.Samples):
        raise ArgumentError(
            f"samples: expected Samples or a GBuffer, got {type(samples).__name__}; view.samples() makes them"
        )
    if samples.light != light:
        raise ArgumentError(
            f"samples: expected those with the shadow states of {light!r}, got those of {samples.light!r}; make the "
            "samples for this light"
        )
    return samples


def number_of(name: str, value: object) -> float:
    """The value as a float.

    Raises
    ------
    ArgumentError
        For something else, and NaN.
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentError(f"{name}: expected a number, got {shown(value)}; leave it out for the default")
    try:
        number = float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
    if math.isnan(number):
        raise ArgumentError(f"{name}: expected a number, got NaN; leave it out for the default")
    return number
