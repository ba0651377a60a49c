"""Why pixels are wrong: acne, displaced edges, leaks by bias, casters that the map does not hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from ..text.arrays import check_map_depths
from ..text.checks import check_filter, checked_blend, checked_stored
from ..travel import Value
from .codes import Cause
from .summary import checked_bands, even_limits

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from ..types import Filter, Light, Maps

#: Why a pixel is wrong, by its name in tables.
CauseName = Literal["acne", "edge", "leak", "missing", "other"]
# The causes by their codes in `Causes.image`, and what they mean.
CAUSES: dict[Cause, CauseName] = {Cause[name.upper()]: name for name in get_args(CauseName)}
MEANINGS: dict[CauseName, str] = {
    "acne": "a surface shadows itself, or in a crease a lit one its neighbour",
    "edge": "a silhouette is drawn where it is not",
    "leak": "without bias it would be dark: peter-panning, light through thin walls",
    "missing": "the caster is not in the map: cut off, beyond it, thinner than a texel, or without such a surface",
    "other": "the map holds what the light does not meet",
}


@dataclass(frozen=True, eq=False, repr=False)
class Causes(Value):
    """The wrong pixels of a view, each with one cause.

    Attributes
    ----------
    image : (H, W) int8
        0 right, 1 acne, 2 edge, 3 leak, 4 missing, 5 other, -1 not compared: `Cause`.
    distance : (H, W) float32
        How far a displaced edge lies from the centre of its pixel, pixels. NaN where the cause is not an edge, infinite
        where the edge lies behind the camera.
    depth : (H, W) float64
        Depth along the view, world units.
    undecided : int
        Pixels whose truth changes with the numerical offset of the ray; none of them counts as wrong.
    """

    image: NDArray[np.int8]
    distance: NDArray[np.float32]
    depth: NDArray[np.float64]
    undecided: int

    @cached_property
    def _counted(self) -> tuple[list[int], tuple[float, float, float] | None]:
        """Pixels by code from 0 on; mean, 95th percentile and largest distance of edges, if there are any."""
        return _core.cause_counts(self.image, self.distance)

    @property
    def count(self) -> int:
        """All wrong pixels."""
        return sum(self.counts.values())

    @property
    def counts(self) -> dict[CauseName, int]:
        """Wrong pixels by cause."""
        return by_name(self._counted[0])

    @property
    def acne(self) -> int:
        """Pixels that would be lit if no surface shadowed itself, and creases whose lit sides shadow each other."""
        return self.counts["acne"]

    @property
    def edge(self) -> int:
        """Pixels at silhouettes that are drawn where they are not."""
        return self.counts["edge"]

    @property
    def leak(self) -> int:
        """Lit pixels that would be dark without bias."""
        return self.counts["leak"]

    @property
    def missing(self) -> int:
        """Lit pixels whose caster is not in the map."""
        return self.counts["missing"]

    @property
    def other(self) -> int:
        """Pixels for which the map holds what the light does not meet: of a map that is wrong."""
        return self.counts["other"]

    @property
    def edge_distance(self) -> dict[str, float] | None:
        """Mean, 95th percentile and largest distance of displaced edges, pixels; None where there is none."""
        moved = self._counted[1]
        return None if moved is None else dict(zip(("mean", "p95", "max"), moved, strict=True))

    def by_depth(self, bands: int | npt.ArrayLike = 6) -> pd.DataFrame:
        """One row a band of camera depth: near, far (world units), compared, wrong, and the causes (pixels).

        Parameters
        ----------
        bands : int or (B + 1,) array_like
            As in `Footprint.summary`, over the pixels that are compared.

        Raises
        ------
        ArgumentError
            For less than one band, or limits that do not rise.
        """
        import pandas as pd

        return pd.DataFrame(self.depth_rows(bands), columns=["near", "far", "compared", "wrong", *CAUSES.values()])

    def depth_rows(self, bands: int | npt.ArrayLike = 6) -> list[dict[str, float]]:
        """The rows of `by_depth` as dicts, made without pandas.

        Parameters
        ----------
        bands : int or (B + 1,) array_like
            As of `by_depth`.

        Raises
        ------
        ArgumentError
            As `by_depth`.
        """
        limits = checked_bands(bands)
        depths = _core.compared_depths(self.image, self.depth)
        if depths is None:
            return []
        limits = even_limits(*depths, cast("int", bands)) if limits is None else limits
        rows: list[dict[str, float]] = []
        of_bands = _core.causes_by_depth(self.image, self.depth, limits=limits).tolist()
        for (near, far), counts in zip(pairwise(limits), of_bands, strict=True):
            by_cause = by_name(counts)
            whole = {"near": float(near), "far": float(far), "compared": sum(counts), "wrong": sum(by_cause.values())}
            rows.append(whole | {str(name): count for name, count in by_cause.items()})
        return rows

    def __repr__(self) -> str:
        parts = ", ".join(f"{name}={count}" for name, count in self.counts.items())
        moved = self.edge_distance
        tail = "" if moved is None else f", edges moved by {moved['mean']:.3g} px on average"
        return f"Causes({self.count} wrong: {parts}{tail}; undecided={self.undecided})"

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{self.by_depth().to_html(index=False, border=0)}"


def by_name(counts: Sequence[int]) -> dict[CauseName, int]:
    """Wrong pixels by cause, of counts by code from 0 on."""
    return {name: counts[code] for code, name in CAUSES.items()}


def causes(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light,
    parameterization: Maps,
    mask: npt.ArrayLike,
    truth: npt.ArrayLike,
    *,
    gbuffer: _core.GBuffer,
    maps: npt.ArrayLike,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: _core.Stored | str | None = None,
) -> Causes:
    """Why the pixels of a shadow mask are wrong.

    A silhouette lies between a pixel and the centre of a texel where the first surface that light meets changes by a
    jump of depth. A pixel in false shadow is *acne* where it would be lit without the dark texels to which its own
    surface continues without a silhouette, *other* where such texels hold what light does not meet there, else a
    displaced *edge*. A pixel in false light is *missing* its caster where that lies outside of the map's depths; a
    *leak* where it would be dark without bias, by texels that hold a caster; *other* where the map holds what light
    does not meet there; an edge where a texel around has its centre in the same shadow; else missing, too: its shadow
    is thinner than a texel.

    Maps that store another surface than the front have the same causes, since light and shadow end at the silhouettes
    of what light meets first. Acne is then also a surface that is shaded by what the map stores behind it, and a pixel
    is missing its caster also where the caster has no such surface above the receiver: an open mesh, a contact.
    docs/errors.md has the definitions.

    Parameters
    ----------
    scene : Scene
        Rays tell what blocks the light.
    camera, light, parameterization
        As in `footprint`.
    mask : (H, W) array_like
        From `Renderer.shadow_mask` or `look_up`.
    truth : (H, W) array_like int8
        From `sl.trace.shadow_mask`.
    gbuffer : GBuffer
        What the camera sees, of the same size.
    maps : (H, W) or (K, H, W) array_like float32
        The shadow maps that the mask was looked up in.
    bias, filter, blend, stored
        As the mask was made with. Where two maps blend, the cause is that of the map which makes the pixel wrong.

    Returns
    -------
    Causes

    Raises
    ------
    ArgumentError
        For arguments of another type, images of different sizes, and maps with what is no depth in [0, 1].
    UnknownNameError
        For a filter that does not exist, or a surface, spacing or format to store.
    """
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(
            f"camera: expected a Camera, got {type(camera).__name__}; the one that the G-buffer was rendered with"
        )
    check_filter(filter)
    if not isinstance(gbuffer, _core.GBuffer):
        raise ArgumentError(
            f"gbuffer: expected a GBuffer, got {type(gbuffer).__name__}; sl.Renderer().gbuffer(...) makes one"
        )
    check_map_depths("maps", maps)
    depth = depths_of(gbuffer, camera)
    errors = _core.misclassified(mask, truth)
    image, distance = _core.causes(
        scene, camera, light, parameterization, errors.image, gbuffer=gbuffer, maps=maps, bias=bias, filter=filter,
        blend=checked_blend(blend), stored=checked_stored(stored),
    )  # fmt: skip
    return Causes(image, distance, depth, int(errors.undecided))


def depths_of(gbuffer: _core.GBuffer, camera: _core.Camera) -> NDArray[np.float64]:
    """Depths along the view (H, W) of what a G-buffer shows, world units."""
    positions = np.asarray(gbuffer.position)
    return camera.depth(positions.reshape(-1, 3)).reshape(positions.shape[:2])
