"""The maps of a run and what is read from them: each array made when it is asked for, and kept while there is room."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..aliasing.causes import Causes, depths_of
from ..aliasing.footprint import NO_MAP, UNMEASURED, Footprint, footprint_of
from ..aliasing.usage import Usage, usage
from ..scene.kept import Kept
from ..scene.view import light_of
from ..text.checked import has_all
from .phases import shifted

if TYPE_CHECKING:
    from ..aliasing.summary import Summary
    from ..scene.view import View
    from ..types import Cull, Filter, Light, Maps, RendererLike

T = TypeVar("T")

# Arrays of the runs that were used last: some twenty maps of 2048 x 2048 texels with their pictures.
KEPT = Kept(1 << 30)
_numbers = itertools.count()


def drawn_as(stored: _core.Stored) -> dict[str, _core.Stored]:
    """What `shadow_map` is given for maps that store this: nothing of the plain depth, which any renderer draws."""
    return {} if stored == _core.Stored() else {"stored": stored}


def footprint_bytes(footprint: Footprint) -> int:
    """What the arrays of a footprint take."""
    arrays = (footprint.jacobian, footprint.perspective_ts)
    planes = (footprint.major, footprint.perspective, footprint.projection, footprint.depth, footprint.map)
    return sum(array.nbytes for array in (*arrays, *planes))


class Drawing:
    """The maps that a renderer draws for a view, and everything that is measured from them.

    Parameters
    ----------
    view : View
        With one light.
    renderer : Renderer
    parameterization : Parameterization
    resolution : int
        Texels along each side of the maps.
    bias : Bias
    filter : str
    blend : float
    stored : Stored
    """

    def __init__(
        self, view: View, renderer: RendererLike, parameterization: _core.Parameterization, resolution: int,
        bias: _core.Bias, filter: Filter, blend: float, stored: _core.Stored,
    ):  # fmt: skip
        self.view, self.renderer, self.parameterization = view, renderer, parameterization
        self.resolution, self.bias, self.filter, self.blend = resolution, bias, filter, blend
        self.stored = stored
        self._number = number = next(_numbers)
        weakref.finalize(self, KEPT.forget_soon, number)

    def draw(self, cull: Cull = "volume") -> NDArray[np.float32]:
        """The maps, drawn now: whole, or as far as the pixels look them up ("seen"), which is enough for the mask."""
        seen = cull == "seen" and self._looking_pays()
        self._forget("seen" if seen else "maps")
        return self._seen if seen else self.maps

    def look_up(self) -> NDArray[np.float32]:
        """The mask, looked up now."""
        self._forget("mask")
        return self.mask

    @property
    def maps(self) -> NDArray[np.float32]:
        """Shadow maps (H, W) or (K, H, W) float32."""
        return self._kept("maps", lambda: self._drawn(self.parameterization), lambda maps: maps.nbytes)

    @property
    def _seen(self) -> NDArray[np.float32]:
        """The maps as far as the pixels look them up."""
        return self._kept("seen", lambda: self._drawn_for_mask(self.parameterization), lambda maps: maps.nbytes)

    def _drawn(self, parameterization: _core.Parameterization) -> NDArray[np.float32]:
        """Whole maps."""
        how = drawn_as(self.stored)
        return self.renderer.shadow_map(self.view.scene, parameterization, resolution=self.resolution, **how)

    def _drawn_for_mask(self, parameterization: _core.Parameterization) -> NDArray[np.float32]:
        """Maps of which nothing but the mask is read."""
        if not self._looking_pays():
            return self._drawn(parameterization)
        draws: Any = self.renderer
        looks = (self.gbuffer, self.view.camera, light_of(self.view), parameterization)
        how = {"bias": self.bias, "filter": self.filter, "blend": self.blend, "stored": self.stored}
        return cast("NDArray[np.float32]", draws.seen_map(self.view.scene, *looks, resolution=self.resolution, **how))

    @property
    def mask(self) -> NDArray[np.float32]:
        """Light that arrives (H, W) float32."""
        return self._looked_up()[0]

    @property
    def chosen(self) -> NDArray[np.int16]:
        """Map that each pixel looks up (H, W) int16."""
        return self._looked_up()[1]

    @property
    def errors(self) -> _core.Misclassified:
        """Where the mask and the truth disagree."""
        return self._kept(
            "errors", lambda: _core.misclassified(self.mask, self.view.truth()), lambda errors: errors.image.nbytes
        )

    @property
    def causes(self) -> Causes:
        """Why the wrong pixels are wrong."""

        def make() -> Causes:
            image, distance = self._caused()
            depth = depths_of(self.gbuffer, self.view.camera)
            return Causes(image, distance, depth, int(self.errors.undecided))

        return self._kept("causes of all", make, lambda found: found.depth.nbytes)

    @property
    def footprint(self) -> Footprint:
        """Size of a texel at every pixel."""
        return self._kept("footprint", lambda: footprint_of(*self._looks, resolution=self.resolution), footprint_bytes)

    @property
    def usage(self) -> Usage:
        """How often each texel is read, computed anew."""
        return usage(*self._looks, resolution=self.resolution, filter=self.filter)

    def count_at(self, dx: float, dy: float) -> int:
        """The wrong pixels where the texels are shifted by parts of a texel along x and y; nothing of it is kept."""
        if dx == dy == 0:
            return int(self.errors.count)
        moved = shifted(self.parameterization, dx, dy, self.resolution)
        maps = self._drawn_for_mask(moved)
        looks = (self.gbuffer, self.view.camera, light_of(self.view), moved)
        mask, _ = _core.look_up(maps, *looks, bias=self.bias, filter=self.filter, blend=self.blend, stored=self.stored)
        return int(_core.misclassified(mask, self.view.truth()).count)

    def wrong_pixels(self) -> dict[str, float | None]:
        """The counts of wrong pixels, by columns."""
        errors = self.errors
        return {
            "misclassified": int(errors.count),
            "false_shadow": int(errors.false_shadow),
            "false_light": int(errors.false_light),
            "share": float(errors.fraction) if errors.compared else None,
            "compared": int(errors.compared),
            "undecided": int(errors.undecided),
            "unmatched": int(errors.unmatched),
        }

    def cause_counts(self) -> dict[str, float | None]:
        """The wrong pixels by cause, and how far edges moved, by columns."""
        image, distance = self._caused()
        causes = Causes(image, distance, np.empty(0), 0)
        moved = causes.edge_distance
        counts: dict[str, float | None] = {name: count for name, count in causes.counts.items()}  # noqa: C416  # other keys
        return counts | {"edge_px": None if moved is None else moved["mean"]}

    def texels(self) -> tuple[Summary, dict[str, float | None]]:
        """The summary of the footprints, and its numbers by columns."""
        summary = self.footprint.summary()
        numbers: dict[str, float | None] = {"measured": summary.measured, "outside": summary.counts[UNMEASURED[NO_MAP]]}
        if summary.percentiles is not None:
            numbers |= {f"texel_p{k}": summary.percentiles[k] for k in (50, 95, 99)}
            numbers |= {"texel_mean": summary.mean, "texel_max": summary.max}
            numbers |= {k: getattr(summary, k) for k in ("undersampled", "perspective_max", "storage_factor")}
        return summary, numbers

    @property
    def gbuffer(self) -> _core.GBuffer:
        """What the camera sees, as the renderer drew it."""
        return self.view.gbuffer(self.renderer)

    @property
    def _looks(self) -> tuple[_core.GBuffer, _core.Camera, Light, Maps]:
        return self.gbuffer, self.view.camera, light_of(self.view), self.parameterization

    def _looked_up(self) -> tuple[NDArray[np.float32], NDArray[np.int16]]:
        return self._kept(
            "mask",
            lambda: _core.look_up(
                self._seen if self._has_seen() else self.maps,
                *self._looks,
                bias=self.bias,
                filter=self.filter,
                blend=self.blend,
                stored=self.stored,
            ),
            lambda found: found[0].nbytes + found[1].nbytes,
        )

    def _caused(self) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
        def make() -> tuple[NDArray[np.int8], NDArray[np.float32]]:
            view = self.view
            return _core.causes(
                view.scene, view.camera, light_of(view), self.parameterization, self.errors.image,
                gbuffer=self.gbuffer, maps=self.maps, bias=self.bias, filter=self.filter, blend=self.blend,
                stored=self.stored,
            )  # fmt: skip

        return self._kept("causes", make, lambda found: found[0].nbytes + found[1].nbytes)

    def _kept(self, name: str, make: Callable[[], T], size: Callable[[T], int]) -> T:
        return KEPT.get(self._number, name, make, size)

    def _looking_pays(self) -> bool:
        """Whether maps of what pixels see are drawn sooner than whole ones, and the renderer draws such."""
        return _core.looking_pays(self.view.scene, self.view.size) and has_all(self.renderer, "seen_map")

    def _has_seen(self) -> bool:
        """Whether maps are there of which nothing but the mask is read, and no whole ones."""
        return KEPT.holds(self._number, "seen") and not KEPT.holds(self._number, "maps")

    def _forget(self, name: str) -> None:
        KEPT.forget(self._number, name)
