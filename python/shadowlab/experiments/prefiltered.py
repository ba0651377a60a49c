"""Prefiltered shadow maps at equal memory: what variance, exponential and moment maps leak, and what they save.

The maps are drawn once per size of a texel, stored in each format, blurred by a box and looked up; beside them stand
depths, compared at the nearest texel and over the same box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..aliasing.codes import LIT_FROM
from ..aliasing.prefiltered_formats import PREFILTERED_FORMATS
from ..aliasing.soft_error import soft_error
from ..scene.view import checked_view, light_of
from ..techniques.labels import name_of, resolved
from ..text.checked import a_word
from ..text.checks import renderer_of
from ..text.progress import checked_progress, steps_of_call
from ..trace import Truth, soft_shadow_mask
from ..travel import Value
from .evaluate import fitted
from .memory import memory_text
from .prefiltered_arguments import (
    budget_of,
    checked_formats,
    checked_kernel,
    checked_reduction,
    grouped,
    largest_maps,
    texel_bytes,
)
from .prefiltered_looks import PrefilteredLooks

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from ..scene.view import View
    from ..types import Mask, RendererArgument, TechniqueArgument, TruthImage


@dataclass(frozen=True, eq=False, repr=False)
class PrefilteredMaps(Value):
    """Prefiltered formats and depths in one view, in numbers and as masks.

    Attributes
    ----------
    table : DataFrame
        A row per format:

        - format; texel_bytes; maps; resolution, texels along each side; bytes, of all maps together
        - misclassified, false_shadow, false_light: pixels that are wrong at one half, as of `aliasing.misclassified`
        - covered: pixels in shadow that no comparison of the kernel lights
        - leaks: those of them with half of the light or more; bleeding: their light on average, None of no pixel
        - soft_error, too_dark, too_light: against the area average of truth, as of `aliasing.soft_error`
        - lookups: texture reads of a pixel, of which those of prefiltered formats are weighted between four texels;
          blur_reads: texels that are read to blur one
    masks : (F, H, W) float32
        The light of each row.
    leaking : (F, H, W) bool
        The pixels of `leaks` of each row.
    view : View
    label : str
        The technique.
    kernel : int
        Side of the box, texels.
    reduction : float
        Share of the light that is cut off variance and moment maps.
    memory : int or None
        The budget in bytes; None where all formats have the same resolution.
    """

    table: pd.DataFrame
    masks: NDArray[np.float32]
    leaking: NDArray[np.bool_]
    view: View
    label: str
    kernel: int
    reduction: float
    memory: int | None

    @property
    def verdict(self) -> str:
        """The answer in sentences."""
        of = "at equal resolution" if self.memory is None else f"in {memory_text(self.memory)}"
        best, soft = self._least("misclassified"), self._least("soft_error")
        said = [
            f"{self.label} {of}, kernel {self.kernel}: {best['format']} has the fewest wrong pixels, "
            f"{best['misclassified']:,} with {best['resolution']}² texels, and {soft['format']} the least soft error, "
            f"{soft['soft_error']:.4f}."
        ]
        rows = [row for _, row in self.table.iterrows()]
        pcf = next((row for row in rows if row["format"] == "depth:pcf"), None)
        others = [row for row in rows if row["format"] in PREFILTERED_FORMATS]
        if pcf is not None and others:
            least = min(others, key=lambda row: row["misclassified"])
            said.append(
                f"{least['format']}, the best prefiltered format, has {least['misclassified']:,} wrong pixels with one "
                f"filtered lookup; depth:pcf has {pcf['misclassified']:,} with {pcf['lookups']} "
                "comparisons."
            )
        leaks = [f"{row['format']} {row['leaks']:,}" for row in others if row["leaks"]]
        if others:
            said.append(f"Leaks inside shadow: {', '.join(leaks)}." if leaks else "None leaks inside shadow.")
        return " ".join(said)

    def mask(self, format: str) -> Mask:
        """The light (H, W) that a format lets through.

        Raises
        ------
        UnknownNameError
            For a format that is not in the table.
        ArgumentError
            For something that is no text.
        """
        names = list(self.table["format"])
        found: Mask = self.masks[names.index(a_word(names, "take one of the table's")("format", format))]
        return found

    def figure(self) -> Figure:
        """The wrong pixels and the leaks of each format; see `plot.prefiltered_figure`."""
        from ..plot.prefiltered import prefiltered_figure

        return prefiltered_figure(self)

    def _least(self, column: str) -> pd.Series[Any]:
        """The row with the least of a column; of equal ones the first."""
        return self.table.iloc[int(self.table[column].to_numpy().argmin())]

    def __str__(self) -> str:
        return self.verdict

    def _repr_html_(self) -> str:
        return f"<p>{escape(self.verdict)}</p>{self.table.to_html(index=False, border=0, float_format='{:.4g}'.format)}"

    def __repr__(self) -> str:
        best = self._least("misclassified")
        budget = "equal resolution" if self.memory is None else memory_text(self.memory)
        return (
            f"PrefilteredMaps({self.label}, {budget}, kernel {self.kernel}, {len(self.table)} formats; fewest wrong: "
            f"{best['format']}, {best['misclassified']:,} px)"
        )


def prefiltered_maps(
    view: View,
    technique: TechniqueArgument = "lispsm",
    *,
    memory: int | str | None = None,
    resolution: int | None = None,
    kernel: int = 5,
    formats: Sequence[str] | None = None,
    reduction: float = 0.0,
    renderer: RendererArgument = None,
    progress: bool | None = None,
) -> PrefilteredMaps:
    """Variance, exponential and moment shadow maps beside depths with comparisons, in one view at equal memory.

    The formats store depths that are linear along the light, over the range of each map. They are blurred by a box of
    texels and read with bilinear weights; "depth:pcf" averages comparisons over the same kernel, most of its bias that
    of the receiver's plane, and "depth:nearest" is one comparison with the default bias.

    A leak is light at a pixel in shadow that no comparison of the kernel lights, in a map of the same resolution. So it
    comes from what the format stores, not from its resolution.

    Parameters
    ----------
    view : View
        With one light, of any kind.
    technique : str, Technique, Preset or Parameterization
        As `sl.technique` takes it; of one map or several, with a post-warp or without.
    memory : int or str, optional
        Bytes of the maps that are looked up, such as "4 MiB", which it is where nothing is given; at most 256 MiB. Each
        format gets the largest square maps that fit.
    resolution : int, optional
        Texels along each side for all formats instead of a budget.
    kernel : int
        Side of the box, texels: odd, 1 to 31.
    formats : sequence of str, optional
        "depth:nearest", "depth:pcf", "variance:f16", "variance:unorm16", "variance:f32", "exponential:f16",
        "exponential:f32", "moment:unorm16", "moment:f32"; all of them where none are given.
    reduction : float
        Light of variance and moment maps below this share becomes 0, and the rest is stretched to 0 to 1: fewer leaks,
        and darker penumbrae. 0 to below 1.
    renderer : Renderer or str, optional
        What draws the maps.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.

    Returns
    -------
    PrefilteredMaps

    Raises
    ------
    ArgumentError
        For arguments of another type or out of range, and a budget that the maps do not fit into.
    UnknownNameError
        For a technique, format, unit or renderer that does not exist.
    UnsupportedError
        What the technique cannot do with this view or light.

    References
    ----------
    theory.md 19; docs/prefiltered.md.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    >>> found = sl.prefiltered_maps(view, memory="256 KiB", renderer="cpu", progress=False)
    >>> found.table.query("format == 'depth:pcf'").leaks.item()
    0
    """
    checked_view(view), checked_progress(progress)
    light = light_of(view)
    item = resolved(technique, "technique")
    budget, side = budget_of(memory, resolution)
    box, names, cut = checked_kernel(kernel), checked_formats(formats), checked_reduction(reduction)
    draw = renderer_of(renderer)
    found: dict[str, tuple[dict[str, object], Mask, NDArray[np.bool_]]] = {}
    with steps_of_call(len(names) + 1, progress) as step:
        step("truth")
        truth = view.truth()
        soft = soft_shadow_mask(view.scene, view.camera, light, size=view.size)
        for of_texel, group in grouped(names).items():
            step(group[0])
            if budget is None:
                assert side is not None, "one of both is given"
                texels, maps = side, fitted(item, view, side, draw)
            else:
                texels, maps = largest_maps(item, view, draw, budget, of_texel)
            looks = PrefilteredLooks(view, maps, texels, draw, box)
            for i, name in enumerate(group):
                if i:
                    step(name)
                mask = _mask_of(looks, name, cut)
                covered = looks.covered & (truth == Truth.SHADOW)
                leaking = covered & (mask >= LIT_FROM)
                count = len(maps.partitions)
                row = _row(name, count, texels, box) | _judged(mask, truth, soft) | _leaks(mask, covered, leaking)
                found[name] = row, mask, leaking
    label = technique if isinstance(technique, str) else name_of(item)
    rows, masks, leaking_of = zip(*(found[name] for name in names), strict=True)
    return PrefilteredMaps(_table(rows), np.stack(masks), np.stack(leaking_of), view, label, box, cut, budget)


def _mask_of(looks: PrefilteredLooks, name: str, reduction: float) -> Mask:
    if name in PREFILTERED_FORMATS:
        return looks.mask(PREFILTERED_FORMATS[name], reduction)
    return looks.pcf if name == "depth:pcf" else looks.nearest


def _row(name: str, maps: int, side: int, kernel: int) -> dict[str, object]:
    """What is known of a format before it is looked up."""
    is_prefiltered, size = name in PREFILTERED_FORMATS, texel_bytes(name)
    return {
        "format": name, "texel_bytes": size, "maps": maps, "resolution": side, "bytes": maps * side**2 * size,
        "lookups": (kernel + 1) ** 2 if name == "depth:pcf" else 1,
        "blur_reads": 2 * kernel if is_prefiltered else 0,
    }  # fmt: skip


def _judged(mask: Mask, truth: TruthImage, soft: Mask) -> dict[str, object]:
    wrong, error = _core.misclassified(mask, truth), soft_error(mask, soft)
    return {
        "misclassified": int(wrong.count), "false_shadow": int(wrong.false_shadow),
        "false_light": int(wrong.false_light), "soft_error": error.mean, "too_dark": error.too_dark,
        "too_light": error.too_light,
    }  # fmt: skip


def _leaks(mask: Mask, covered: NDArray[np.bool_], leaking: NDArray[np.bool_]) -> dict[str, object]:
    count = int(np.count_nonzero(covered))
    return {
        "covered": count, "leaks": int(np.count_nonzero(leaking)),
        "bleeding": float(mask[covered].mean(dtype=np.float64)) if count else None,
    }  # fmt: skip


def _table(rows: Sequence[dict[str, object]]) -> pd.DataFrame:
    import pandas as pd

    columns = [
        "format", "texel_bytes", "maps", "resolution", "bytes", "misclassified", "false_shadow", "false_light",
        "covered", "leaks", "bleeding", "soft_error", "too_dark", "too_light", "lookups", "blur_reads",
    ]  # fmt: skip
    return pd.DataFrame(list(rows), columns=columns)
