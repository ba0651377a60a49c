"""A technique at a resolution in a view: what was measured, and the row of a table that it gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from .. import _core
from ..errors import ArgumentError
from ..scene.view import View
from ..techniques.kinds import is_parameterization
from ..techniques.labels import full_name_of, spec_of
from ..techniques.variant import MapReading
from ..text import settings_text
from ..text.checks import renderer_of
from ..travel import Value
from .drawing import Drawing
from .memory import BYTES_PER_TEXEL
from .metrics import HELD_AGAINST_TRUTH, MEASURED, Metric
from .phases import PHASES, Scatter, checked_phases, scatter_of

T = TypeVar("T")

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .._core import Misclassified
    from ..aliasing.causes import Causes
    from ..aliasing.footprint import Footprint
    from ..aliasing.summary import Summary
    from ..aliasing.usage import Usage
    from ..types import Filter, Item, Mask, PerLight, ShadowMaps


@dataclass(frozen=True, eq=False, repr=False)
class Run(Value):
    """A technique at a resolution in a view: its matrices, what was measured, and the reason where it failed.

    Numbers are held; arrays are made when they are asked for, kept while there is room, and drawn again after that.

    Attributes
    ----------
    view : View
    label : str
        The technique's name in tables.
    item : Technique, Preset or Parameterization
        What was evaluated.
    resolution : int
        Texels along each side of the maps.
    metrics : tuple of str
        What was measured.
    bias, filter
        As the pixels were looked up.
    backend, adapter : str
        Of the renderer.
    parameterization : Parameterization or None
        None where the technique failed to make it, and of several lights.
    summary : Summary or None
        Of the footprints of texels, with the metric "texels".
    values : tuple of (str, number)
        What was measured, by the names of columns; see `numbers`.
    doubt : Note or None
        What speaks against a matrix from elsewhere.
    failure : str
        Why there are no numbers; empty where there are.
    failure_type : str
        Name of the class of the error that is the failure; empty where there is none.
    refusal : str
        Of a technique that refuses the light or the view, the failure without its name; else empty.
    parts : tuple of Run
        Of a view with several lights, the run of each.
    blend : float
        As the pixels were looked up.
    stored : Stored
        What the maps store.
    """

    view: View
    label: str
    item: Item
    resolution: int
    metrics: tuple[Metric, ...]
    bias: _core.Bias
    filter: Filter
    backend: str
    adapter: str
    parameterization: _core.Parameterization | None = None
    summary: Summary | None = None
    values: tuple[tuple[str, float | None], ...] = ()
    doubt: _core.Note | None = None
    failure: str = ""
    failure_type: str = ""
    refusal: str = ""
    parts: tuple[Run, ...] = ()
    blend: float = 0.0
    stored: _core.Stored = field(default_factory=_core.Stored)
    _drawing: Drawing | None = field(default=None, init=False, compare=False)

    STATE_VERSION: ClassVar[int] = 2

    @property
    def given(self) -> bool:
        """Whether it is matrices from elsewhere, not made by a technique."""
        return is_parameterization(self.item)

    @property
    def technique(self) -> str:
        """Name of the technique; "preset:NAME" of an engine's."""
        return full_name_of(self.item)

    @property
    def settings(self) -> Mapping[str, Any]:
        """All settings of the technique."""
        return dict(self.item.settings)

    @property
    def read(self) -> MapReading:
        """How its maps are read."""
        return MapReading(self.bias, self.filter, self.blend, self.stored)

    @property
    def several(self) -> bool:
        """Whether there are several maps."""
        return self.parameterization is not None and len(self.parameterization.partitions) > 1

    @property
    def numbers(self) -> dict[str, float | None]:
        """What was measured, by the names of columns."""
        return dict(self.values)

    @property
    def notes(self) -> tuple[_core.Note, ...]:
        """What the technique could not do as asked, and what speaks against a given matrix.

        Of several lights, their maps are counted one after the other.
        """
        if self.parts:
            return _notes_of_parts(self.parts)
        own = () if self.parameterization is None else self.parameterization.notes
        return own if self.doubt is None else (*own, self.doubt)

    @property
    def gbuffer(self) -> PerLight[_core.GBuffer] | None:
        """What the camera sees, as the run's renderer drew it; None of a run that failed."""
        return self._of(lambda drawing: drawing.gbuffer)

    @property
    def maps(self) -> PerLight[ShadowMaps] | None:
        """Shadow maps (H, W) or (K, H, W) float32; None of a run that failed."""
        return self._of(lambda drawing: drawing.maps)

    @property
    def mask(self) -> PerLight[Mask] | None:
        """Light that arrives (H, W) float32; None of a run that failed."""
        return self._of(lambda drawing: drawing.mask)

    @property
    def chosen(self) -> PerLight[NDArray[np.int16]] | None:
        """Map that each pixel looks up (H, W) int16, -1 for none; None of a single map and of a run that failed."""
        return self._of(lambda drawing: drawing.chosen if self.several else None)

    @property
    def judged(self) -> bool:
        """Whether it was held against the truth."""
        return not self.failure and bool(HELD_AGAINST_TRUTH & set(self.metrics))

    @property
    def errors(self) -> PerLight[Misclassified] | None:
        """Where the mask and the truth disagree; None of a run that was not held against the truth."""
        return self._of(lambda drawing: drawing.errors) if self.judged else None

    @property
    def difference(self) -> PerLight[NDArray[np.int8]] | None:
        """Difference from the truth (H, W) int8: 0 agree, 1 false shadow, 2 false light, -1 not compared; or None."""
        return self._of(lambda drawing: drawing.errors.image) if self.judged else None

    @property
    def causes(self) -> PerLight[Causes] | None:
        """Why the wrong pixels are wrong; None where that was not asked for."""
        return self._of(lambda drawing: drawing.causes) if "causes" in self.metrics else None

    @property
    def footprint(self) -> PerLight[Footprint] | None:
        """Size of a texel at every pixel; None of a run that failed."""
        return self._of(lambda drawing: drawing.footprint)

    @property
    def usage(self) -> PerLight[Usage] | None:
        """How often each texel is read; None of a run that failed."""
        return self._of(lambda drawing: drawing.usage)

    def over_phases(self, phases: int = PHASES) -> Run:
        """The run with the noise of its wrong pixels: the maps drawn and looked up again, shifted by parts of a texel.

        Parameters
        ----------
        phases : int
            Shifts over which wrong pixels are counted, the map as fitted among them.

        Returns
        -------
        Run
            With the columns "phases", "misclassified_mean" and "misclassified_sd"; all else as it was. A run that
            failed stays as it is.

        Raises
        ------
        ArgumentError
            For less than two shifts, and a run that was not held against the truth.

        Examples
        --------
        >>> import shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
        >>> run = sl.evaluate(view, "lispsm", 256, metrics=["misclassified"], renderer="cpu")
        >>> shifted = run.over_phases(4)
        >>> shifted.numbers["phases"], shifted.numbers["misclassified"] == run.numbers["misclassified"]
        (4, True)
        """
        checked_phases(phases, least=2)
        if self.failure:
            return self
        if not self.judged:
            raise ArgumentError(
                'phases: expected a run held against the truth; evaluate with metrics=["misclassified"]'
            )
        counts = [scatter_of(part._drawn().count_at, phases).counts for part in self.parts or (self,)]
        # Of several lights the maps of all are shifted alike.
        columns = Scatter(tuple(map(sum, zip(*counts, strict=True)))).columns
        made = replace(self, values=tuple((self.numbers | columns).items()))
        object.__setattr__(made, "_drawing", self._drawing)
        return made

    def row(self) -> dict[str, Any]:
        """The row of a table, by the names of `columns.COLUMNS`; None where nothing was measured."""
        p, view = self.parameterization, self.view
        maps = sum(len(q.matrices) for part in self.parts or (self,) if (q := part.parameterization) is not None)
        known = bool(self.parts) or p is not None
        return {
            "scene": view.scene_name,
            "view": view.label,
            "light_angle": view.light_angle,
            "light_elevation": view.light_elevation,
            "technique": self.label,
            "spec": spec_of(self.label, self.item),
            "settings": settings_text(self.settings),
            "resolution": self.resolution,
            "maps": maps if known else None,
            "bytes": BYTES_PER_TEXEL * maps * self.resolution**2 if known else None,
            **dict.fromkeys(MEASURED),
            **self.numbers,
            "notes": "; ".join(map(str, self.notes)),
            "failure": self.failure,
        }

    def _of(self, what: Callable[[Drawing], T]) -> PerLight[T] | None:
        if self.parts:
            return tuple(part._of(what) for part in self.parts)
        return None if self.failure or self.parameterization is None else what(self._drawn())

    def _drawn(self) -> Drawing:
        if self._drawing is None:
            if self.adapter == ELSEWHERE:
                raise ArgumentError(
                    f"run: its pictures were drawn by a renderer of another kind ({self.backend}), which did not come "
                    "along; evaluate again with that renderer"
                )
            p = cast("_core.Parameterization", self.parameterization)
            looked_up = self.resolution, self.bias, self.filter, self.blend, self.stored
            drawing = Drawing(self.view, renderer_of(self.backend), p, *looked_up)
            object.__setattr__(self, "_drawing", drawing)
        return cast("Drawing", self._drawing)

    def __reduce__(self) -> tuple[Any, ...]:
        ours = self._drawing is None or isinstance(self._drawing.renderer, _core.Renderer)
        return super().__reduce__() if ours else replace(self, adapter=ELSEWHERE).__reduce__()

    def __repr__(self) -> str:
        head = f"Run({self.label} at {self.resolution}²"
        if self.failure:
            return f"{head}, failed: {self.failure})"
        wrong = self.numbers.get("misclassified")
        return f"{head}{'' if wrong is None else f', {wrong:,} wrong pixels'})"


# The adapter of a run whose renderer is not of this package and stayed in another process.
ELSEWHERE = "elsewhere"


def done(value: T | None) -> T:
    """What a run has that succeeded.

    Raises
    ------
    ArgumentError
        Where there is none: of a run that failed, or was not held against the truth.
    """
    if value is None:
        raise ArgumentError("run: expected one that succeeded, got one that failed; its `failure` says why")
    return value


def _notes_of_parts(parts: Sequence[Run]) -> tuple[_core.Note, ...]:
    """The notes of the runs of several lights: each with its maps among those of all lights."""
    found: dict[_core.Note, list[int]] = {}
    total = 0
    for part in parts:
        maps = 0 if part.parameterization is None else len(part.parameterization.partitions)
        for note in part.notes:
            own = range(maps) if note.maps is None else note.maps
            found.setdefault(note.about(None), []).extend(total + k for k in own)
        total += maps
    return tuple(note.about(maps if len(maps) < total else None) for note, maps in found.items())
