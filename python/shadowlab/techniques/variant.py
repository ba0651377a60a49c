"""A technique with a way of its own to read its maps: `lispsm:bias=(slope=1,texels=0.5),filter=bilinear,mix=0.1`.

So biases, filters, blending and what maps store are compared and swept like parameters: what stands in a technique's
text goes before what the experiment says for all. `mix` is what experiments call `blend`, which is a setting of
`z_partition` in a technique's text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from .. import _core
from ..errors import ArgumentError
from ..text import bias_of, bias_text
from ..text.checked import has_all
from ..text.checks import check_bias, check_filter, checked_blend, checked_stored
from ..travel import Value

if TYPE_CHECKING:
    from ..types import Filter, Item, Light, TechniqueLike


class MapReading(NamedTuple):
    """How maps are read: the bias, the filter, the share over which cascades blend, and what maps store."""

    bias: _core.Bias
    filter: Filter
    blend: float
    stored: _core.Stored

    @property
    def lookup(self) -> str:
        """The filter, over which share of their ranges maps blend, and what they store, in words."""
        stored = "" if self.stored == _core.Stored() else f", stored {self.stored}"
        return f"{self.filter}, blend {self.blend:g}{stored}" if self.blend else f"{self.filter}{stored}"


@dataclass(frozen=True, eq=False)
class Variant(Value):
    """A technique whose maps are read in a way of their own.

    Attributes
    ----------
    technique : Technique or Preset
        What makes the maps.
    bias : Bias or None
        None leaves it to the experiment, as for `filter`.
    filter : str or None
    mix : float or None
        The share over which maps blend: `blend` of experiments.
    stored : Stored or None
    """

    technique: TechniqueLike
    bias: _core.Bias | None = None
    filter: Filter | None = None
    mix: float | None = None
    stored: _core.Stored | None = None

    @property
    def name(self) -> str:
        """That of the technique."""
        return self.technique.name

    @property
    def settings(self) -> Mapping[str, Any]:
        """All parameters of the technique, and what is said here of reading its maps, as texts and a number."""
        bias = None if self.bias is None else bias_text(self.bias)
        stored = None if self.stored is None else str(self.stored)
        own = {"bias": bias, "filter": self.filter, "mix": self.mix, "stored": stored}
        return {**self.technique.settings, **{name: value for name, value in own.items() if value is not None}}

    @property
    def needs_samples(self) -> bool:
        """Whether the technique looks at the receivers that the camera sees."""
        return bool(getattr(self.technique, "needs_samples", False))

    @property
    def needs_shadows(self) -> bool:
        """Whether it looks at which of them are in shadow."""
        return bool(getattr(self.technique, "needs_shadows", False))

    def by_body(self) -> Variant:
        """The same with maps for the receivers' body; see `Technique.by_body`."""
        holder: Any = self.technique
        return replace(self, technique=holder.by_body()) if has_all(holder, "by_body") else self

    def fresh(self) -> Variant:
        """The same without maps held from a view before."""
        holder: Any = self.technique
        return replace(self, technique=holder.fresh()) if has_all(holder, "fresh") else self

    def parameterize(
        self,
        scene: _core.Scene,
        camera: _core.Camera,
        light: Light,
        *,
        resolution: int = 1024,
        samples: _core.Samples | _core.GBuffer | None = None,
    ) -> _core.Parameterization:
        """The maps of the technique; see `Technique.parameterize`."""
        return self.technique.parameterize(scene, camera, light, resolution=resolution, samples=samples)

    def __repr__(self) -> str:
        own = {name: value for name, value in self.settings.items() if name in READ_SETTINGS}
        return f"Variant({self.technique!r}, {', '.join(f'{name}={value!r}' for name, value in own.items())})"


#: The names of what is read otherwise, in a technique's text.
READ_SETTINGS = tuple(one.name for one in fields(Variant) if one.name != "technique")


def variant(technique: Item, given: Mapping[str, object]) -> Item:
    """The technique, read as given: a bias or its text, a filter, the share over which maps blend, what maps store.

    Raises
    ------
    ArgumentError
        For a bias or filter of another type, a share to blend over that is not from 0 to 1, and for a parameterization,
        which has no parameters.
    UnknownNameError
        For a part of a bias, a filter, or a surface, spacing or format to store, that does not exist.
    """
    if not given:
        return technique
    if isinstance(technique, _core.Parameterization):
        raise ArgumentError(
            f"technique: expected no {', '.join(given)} for matrices that are given; say it to the experiment"
        )
    bias, kernel = given.get("bias"), given.get("filter")
    if isinstance(bias, str):
        bias = bias_of(bias)
    check_bias(bias)
    if kernel is not None:
        check_filter(kernel)
    mix = None if given.get("mix") is None else checked_blend(given["mix"], "mix")
    stored = None if given.get("stored") is None else checked_stored(given["stored"])
    return Variant(technique, cast("_core.Bias | None", bias), cast("Filter | None", kernel), mix, stored)


def reading(item: Item, bias: _core.Bias | None, filter: Filter, blend: float, stored: _core.Stored) -> MapReading:
    """How the maps of an item are read where an experiment says this for all."""
    own = item if isinstance(item, Variant) else None
    if own is not None and own.bias is not None:
        bias = own.bias
    kernel = filter if own is None or own.filter is None else own.filter
    share = blend if own is None or own.mix is None else own.mix
    kept = stored if own is None or own.stored is None else own.stored
    return MapReading(_core.Bias() if bias is None else bias, kernel, share, kept)
