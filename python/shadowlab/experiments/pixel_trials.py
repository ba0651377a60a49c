"""What would make a wrong pixel right, tried: larger maps, each part of the bias, what maps store, other techniques."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from .. import _core
from ..aliasing.bias_parts import BIAS_LIMITS, BIAS_PARTS, MOST_OF_PART, with_part
from ..aliasing.codes import Difference
from ..aliasing.pixel_comparison import look_up_near
from ..errors import ShadowlabError, ShadowlabWarning
from ..scene.view import light_of
from ..techniques.labels import spec_of
from ..techniques.variant import Variant
from ..text import format_value
from ..travel import Value
from .drawing import drawn_as
from .evaluate import evaluate
from .run import done

if TYPE_CHECKING:
    from ..types import RendererLike, ShadowMaps
    from .run import Run

TrialKind = Literal["resolution", "bias", "stored", "technique"]
# The longest side of a map, and texels of all maps together, that are drawn to find one that mends: 256 MiB.
LONGEST_MAP = 8192
MOST_TRIED_TEXELS = LONGEST_MAP**2
# Techniques that a pixel is tried with, one of each kind: no warp, a warp, several maps, uneven maps.
OTHER_TECHNIQUES = (
    "uniform:fit=shadow", "lispsm", "plane_optimal", "scene_optimal", "rectilinear", "z_partition:count=3,inner=lispsm",
    "optimal_partition",
)  # fmt: skip
# Pixels each way that count as neighbours: a displaced edge or a leak is mostly narrower.
NEIGHBOURS_PX = 16
# Doublings of a part of the bias before it is given up: from a thousandth of its start to a thousand times the scene.
DOUBLINGS = 40
# What maps can store.
SURFACES, SPACINGS, FINEST = ("front", "back", "second", "midpoint", "dual"), ("projective", "linear"), "f32"
# How well a change is known that mends, as a share of it, and the most halvings on the way.
PRECISION, HALVINGS = 1e-3, 40
# Digits of the change of a bias that is named.
BIAS_DIGITS = 4


@dataclass(frozen=True, eq=False)
class PixelTrial(Value):
    """One change, and what it makes of a wrong pixel and of the others.

    Attributes
    ----------
    kind : str
        "resolution", "bias", "stored" or "technique".
    text : str
        What is changed, as arguments are written: ``resolution=2048``, ``bias=world=0.02``, ``stored=back``,
        ``technique=lispsm``.
    technique : str
        The technique's text, the one explained where that is not changed, without what it says of reading its maps.
    resolution : int
    bias : Bias
        All of it, changed or not.
    stored : Stored
        What the maps store, changed or not.
    is_right : bool
        Whether the pixel is right with it.
    part : str
        Of a bias, the part that is changed; else empty.
    wrong : int or None
        Wrong pixels of the picture with it; None where there are none to count.
    wrong_before : int
        Wrong pixels of the picture without it.
    broken, mended : int
        Pixels within 16 of this one that it makes wrong, and right.
    failure : str
        Why it could not be tried; else empty.
    """

    kind: TrialKind
    text: str
    technique: str
    resolution: int
    bias: _core.Bias
    stored: _core.Stored
    is_right: bool
    part: str = ""
    wrong: int | None = None
    wrong_before: int = 0
    broken: int = 0
    mended: int = 0
    failure: str = ""


class Trials:
    """Tries changes of a run at one of its wrong pixels.

    Parameters
    ----------
    run : Run
        What is explained, held against the truth.
    renderer : Renderer
    pixel : (int, int)
        Column and row.
    """

    def __init__(self, run: Run, renderer: RendererLike, pixel: tuple[int, int]):
        self.run, self.renderer, self.pixel = run, renderer, pixel
        # Maps are read as the run says, whatever a technique's text does.
        item = run.item.technique if isinstance(run.item, Variant) else run.item
        self.text, self.item = spec_of(run.label, item), item
        self.read = run.read._asdict()
        # A renderer from elsewhere may draw the plain depth alone.
        self.others = others_of(run.stored) if isinstance(renderer, _core.Renderer) else []
        self.errors = np.asarray(done(run.errors).image)
        x, y = pixel
        self.around = (
            slice(max(0, y - NEIGHBOURS_PX), y + NEIGHBOURS_PX + 1),
            slice(max(0, x - NEIGHBOURS_PX), x + NEIGHBOURS_PX + 1),
        )

    @property
    def most(self) -> int:
        """How many trials there are at most."""
        sides = max(0, (LONGEST_MAP // self.run.resolution).bit_length() - 1)
        return len(BIAS_PARTS) + len(OTHER_TECHNIQUES) + len(self.others) + sides

    def all(self, announce: Callable[[str], None]) -> Iterator[PixelTrial]:
        """Every trial, one after the other; `announce` is called with each before it begins."""
        yield from self.resolutions(announce)
        for part in BIAS_PARTS:
            announce(f"bias {part}")
            yield self.bias(part)
        for stored in self.others:
            announce(f"stored {stored}")
            yield self.stored(stored)
        for technique in OTHER_TECHNIQUES:
            if technique not in (self.run.label, self.text):
                announce(technique)
                yield self.technique(technique)

    def resolutions(self, announce: Callable[[str], None]) -> Iterator[PixelTrial]:
        """Maps of twice the side, again and again, until the pixel is right or more would be too much work."""
        maps = len(_parameterization(self.run).partitions)
        side = 2 * self.run.resolution
        while side <= LONGEST_MAP and maps * side**2 <= MOST_TRIED_TEXELS:
            announce(f"resolution {side}")
            again = evaluate(
                self.run.view, self.item, side, metrics=("misclassified",), renderer=self.renderer,
                label=self.run.label, **self.read,
            )  # fmt: skip
            made = self._judged("resolution", f"resolution={side}", self.text, again)
            yield made
            if made.is_right or made.failure:
                return
            side *= 2

    def technique(self, text: str) -> PixelTrial:
        """Another technique at the same resolution."""
        again = evaluate(
            self.run.view, text, self.run.resolution, metrics=("misclassified",), renderer=self.renderer, **self.read
        )
        return self._judged("technique", f"technique={text}", text, again)

    def bias(self, part: str) -> PixelTrial:
        """One part of the bias, changed as little as makes the pixel right; the others stay.

        A pixel in false shadow takes more of it, one in false light less, down to 0.
        """
        x, y = self.pixel
        own = float(getattr(self.run.bias, part))
        change = self._more if self.errors[y, x] == Difference.FALSE_SHADOW else self._less
        value = change(part, own)
        bias = self.run.bias if value is None else with_part(self.run.bias, part, value)
        shown = own if value is None else value
        trial = PixelTrial(
            "bias", f"bias={part}={format_value(shown)}", self.text, self.run.resolution, bias, self.run.stored,
            value is not None, part=part, wrong_before=int(done(self.run.errors).count),
        )  # fmt: skip
        return trial if value is None else self._looked_up(trial, done(self.run.maps))

    def stored(self, stored: _core.Stored) -> PixelTrial:
        """Maps of the same matrices that store something else."""
        run = self.run
        trial = PixelTrial(
            "stored", f"stored={stored}", self.text, run.resolution, run.bias, stored, False,
            wrong_before=int(done(run.errors).count),
        )  # fmt: skip
        try:
            with warnings.catch_warnings():
                # Of open meshes, whose loss the counts show.
                warnings.simplefilter("ignore", ShadowlabWarning)
                maps = self.renderer.shadow_map(
                    run.view.scene, _parameterization(run), resolution=run.resolution, **drawn_as(stored)
                )
            return self._looked_up(trial, maps)
        except ShadowlabError as error:
            return replace(trial, failure=str(error))

    def _looked_up(self, trial: PixelTrial, maps: ShadowMaps) -> PixelTrial:
        """The trial with what it makes of the picture by a look into maps."""
        view = self.run.view
        mask, _ = _core.look_up(
            maps, view.gbuffer(self.renderer), view.camera, light_of(view), _parameterization(self.run),
            **self.read | {"bias": trial.bias, "stored": trial.stored},
        )  # fmt: skip
        return self._counted(trial, _core.misclassified(mask, view.truth()))

    def _more(self, part: str, own: float) -> float | None:
        """The least value above that of the bias that makes the pixel right, of a few digits."""
        most = MOST_OF_PART.get(part, np.inf)
        start = max(abs(own), smallest_step(part, self.run))
        low = own
        for _ in range(DOUBLINGS):
            high = min(own + start, most)
            if high == low:
                return None
            if self._is_right(part, high):
                break
            low, start = high, 2.0 * start
        else:
            return None
        return self._least(part, high, low, own)

    def _less(self, part: str, own: float) -> float | None:
        """The largest value from 0 to that of the bias that makes the pixel right, of a few digits."""
        if own <= 0 or not self._is_right(part, 0.0):
            return None
        return self._least(part, 0.0, own, own)

    def _least(self, part: str, right: float, wrong: float, own: float) -> float:
        """The least change between a value that makes the pixel right and one that does not, rounded to a few digits.

        Rounded away from what is wrong; as it is where that mends no more.
        """
        for _ in range(HALVINGS):
            if abs(right - wrong) <= PRECISION * abs(right - own):
                break
            middle = 0.5 * (right + wrong)
            right, wrong = (middle, wrong) if self._is_right(part, middle) else (right, middle)
        if right in (0.0, own):
            return right
        digits = BIAS_DIGITS - 1 - int(np.floor(np.log10(abs(right - own))))
        unit = 10.0**-digits
        steps = np.ceil(right / unit) if right > wrong else np.floor(right / unit)
        rounded = round(float(steps * unit), max(digits, 0))
        return rounded if rounded != wrong and self._is_right(part, rounded) else right

    def _is_right(self, part: str, value: float) -> bool:
        """Whether the pixel is right where a part of the bias has a value, by a look into the maps that are there."""
        view = self.run.view
        light = look_up_near(
            done(self.run.maps), view.gbuffer(self.renderer), view.camera, light_of(view), _parameterization(self.run),
            self.pixel, (1, 1), with_part(self.run.bias, part, value), self.run.filter, self.run.blend, self.run.stored,
        )  # fmt: skip
        x, y = self.pixel
        truth = np.asarray(view.truth())[y : y + 1, x : x + 1]
        return bool(_core.misclassified(light, truth).image[0, 0] == Difference.AGREE)

    def _judged(self, kind: TrialKind, text: str, technique: str, again: Run) -> PixelTrial:
        """The trial of another run."""
        trial = PixelTrial(
            kind, text, technique, again.resolution, again.bias, again.stored, False,
            wrong_before=int(done(self.run.errors).count), failure=again.failure,
        )  # fmt: skip
        return trial if again.failure else self._counted(trial, done(again.errors))

    def _counted(self, trial: PixelTrial, errors: _core.Misclassified) -> PixelTrial:
        """The trial with what it makes of the pixel, of those around and of the picture."""
        x, y = self.pixel
        image = np.asarray(errors.image)
        before, after = self.errors[self.around], image[self.around]
        return replace(
            trial,
            is_right=bool(image[y, x] == Difference.AGREE),
            wrong=int(errors.count),
            broken=int(np.count_nonzero((before == Difference.AGREE) & (after > Difference.AGREE))),
            mended=int(np.count_nonzero((before > Difference.AGREE) & (after == Difference.AGREE))),
        )


def others_of(stored: _core.Stored) -> list[_core.Stored]:
    """What else maps can store: each other surface, the other spacing, and single precision in place of less."""

    def but(**changes: str) -> _core.Stored:
        kept = {name: getattr(stored, name) for name in ("surface", "spacing", "format", "limit")}
        return _core.Stored(**kept | changes)

    found = [but(surface=surface) for surface in SURFACES if surface != stored.surface]
    found += [but(spacing=spacing) for spacing in SPACINGS if spacing != stored.spacing]
    return found + ([but(format=FINEST)] if stored.format != FINEST else [])


def smallest_step(part: str, run: Run) -> float:
    """Where a search begins for a part of the bias that is 0: a millionth of the scene, or of what it counts."""
    if part in BIAS_LIMITS or part != "world":
        return 1e-6
    return 1e-6 * float(np.ptp(np.asarray(run.view.scene.bounds), axis=0).max())


def _parameterization(run: Run) -> _core.Parameterization:
    return done(run.parameterization)
