"""The vocabulary of tables: each column once, with its name, unit, dtype and meaning.

Every table of every experiment is made by `table`, so a column is called, measured and stored alike wherever it stands.
docs/columns.md is generated from here.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..aliasing.causes import CAUSES, MEANINGS
from ..errors import ShadowlabWarning

if TYPE_CHECKING:
    import pandas as pd

Dtype = Literal["str", "Int64", "float64", "boolean"]
#: How the numbers of several lights become one: counts and times add, lengths take the worst, and a share of counts is
#: that of their sums.
Together = Literal["sum", "max", "share of sums", ""]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
    unit : str
        "" for texts, counts of things that the meaning names, and numbers without a unit.
    dtype : str
        Of pandas: "str" (as `object`), "Int64" and "boolean" (with missing values), "float64" (NaN where missing).
    doc : str
        What it holds, one line.
    over_lights : str
        How the numbers of several lights become that of a view with all of them: "sum", "max", "share of sums", or ""
        for none.
    """

    name: str
    unit: str
    dtype: Dtype
    doc: str
    over_lights: Together = ""


def _text(name: str, doc: str) -> Column:
    return Column(name, "", "str", doc)


def _count(name: str, unit: str, doc: str, over_lights: Together = "sum") -> Column:
    return Column(name, unit, "Int64", doc, over_lights)


def _number(name: str, unit: str, doc: str, over_lights: Together = "max") -> Column:
    return Column(name, unit, "float64", doc, over_lights)


_OF_VIEWS = (
    _text("scene", "The scene: its file, its name in the library, or its size where it came from arrays."),
    _text("view", "Label of the view: a camera's picture under a light."),
    _text("camera", "Label of the camera."),
    _text("light", "Label of the light."),
    _number("light_angle", "rad", "Angle between the way of the light and the view, 0 to pi.", ""),
    _number("light_elevation", "rad", "Elevation of the light above the horizon, -pi/2 to pi/2.", ""),
    _number("angle_deg", "deg", "Angle between the way of the light and the view, as it was asked for.", ""),
    _count("frame", "", "Frame of a camera path, from 0; the first of the two that a row compares.", ""),
)
_OF_MAPS = (
    _text("technique", "Label of the technique."),
    _text("spec", "Text that makes the technique again: `sl.technique(text)`."),
    _text("settings", "Settings of the technique, all of them."),
    _count("resolution", "texels", "Side of each map.", ""),
    _text("bias", "Bias of the look-ups, as its text."),
    _text("filter", "Filter of the look-ups, as its text."),
    _number("blend", "share", "Last share of each map's range over which the next map's light is mixed in.", ""),
    _text("stored", "What the maps store, as its text."),
    _count("maps", "maps", "Number of maps."),
    _count("memory", "bytes", "Budget of depth texels.", ""),
    _count("single_side", "texels", "Side of the one square map that the budget holds.", ""),
    _count("bytes", "bytes", "What the maps take, 4 bytes per texel."),
    _number("unused", "share", "Texels that no visible pixel reads."),
    _number("unused_memory", "share", "Part of the budget that the maps leave unused."),
)
_OF_PIXELS = (
    _count("misclassified", "px", "Wrong pixels: false shadow plus false light."),
    _count("false_shadow", "px", "Pixels that the map calls dark and the truth calls lit."),
    _count("false_light", "px", "Pixels that the map calls lit and the truth calls dark."),
    _number("share", "share", "Wrong pixels by compared pixels.", "share of sums"),
    _count("compared", "px", "Pixels that show a surface and whose truth is decided."),
    _count("undecided", "px", "Pixels whose truth changes with the numerical offset of the ray; none is wrong."),
    _count("unmatched", "px", "Pixels in which only one of mask and truth saw a surface."),
    _count("misclassified_by_map", "px", "Wrong pixels where a normal map of many texels stands for the truth."),
    _count("compared_by_map", "px", "Pixels that show a surface, all of which that map decides."),
    _count("phases", "", "Shifts of the texels, each by less than a texel, over which wrong pixels were counted.", ""),
    _number("misclassified_mean", "px", "Mean of the wrong pixels over these shifts; runs are compared by it.", ""),
    _number("misclassified_sd", "px", "Standard deviation of the wrong pixels over these shifts: their noise.", ""),
    *(_count(name, "px", f"Wrong pixels where {MEANINGS[name]}.") for name in CAUSES.values()),
    _number("edge_px", "px", "Mean distance by which edges are displaced."),
)
_OF_TEXELS = (
    _count("measured", "px", "Pixels that look up a texel."),
    _count("outside", "px", "Pixels that face the light and that no map holds; they are lit."),
    _count("outside_shadow", "px", "Pixels in shadow, by the samples' states, that no map holds: wrong."),
    _number("undersampled", "share", "Measured pixels in which a texel is longer than a pixel."),
    _number("texel_mean", "px", "Mean over the measured pixels of the longest extent of a texel."),
    _number("texel_p50", "px", "Longest extent of a texel that half of the measured pixels do not exceed."),
    _number("texel_p95", "px", "Longest extent of a texel that 95 % of the measured pixels do not exceed."),
    _number("texel_p99", "px", "Longest extent of a texel that 99 % of the measured pixels do not exceed."),
    _number("texel_max", "px", "Largest extent of a texel of all measured pixels."),
    _number("perspective_max", "px", "Largest extent of a texel by perspective alone."),
    _number("storage_factor", "texels / px", "Texels by pixels that a map without perspective error takes.", "sum"),
    _number("m_s", "px", "Largest extent of a texel along the warp, across the beam of the eye."),
    _number("m_s_sheared", "px", "Largest extent of a texel along the warp, sheared by the light's slant."),
    _number("m_t", "px", "Largest extent of a texel across the warp."),
    _number("storage_factor_sheared", "texels / px", "`storage_factor` of the sheared extents.", "sum"),
    _number("storage_factor_image", "texels / px", "`storage_factor` of extents on the image plane.", "sum"),
)
_OF_TIME = (
    _number("samples_ms", "ms", "Time of making the samples of the view, once for all techniques.", "max"),
    _number("fit_us", "µs", "Time of making the matrices.", "sum"),
    _number("map_ms", "ms", "Time of drawing the maps.", "sum"),
    _number("lookup_ms", "ms", "Time of looking every pixel up.", "sum"),
    _number("seconds", "s", "Time of the whole run, without what all runs in its view share.", ""),
)
_OF_PATHS = (
    _count("receivers", "px", "Receivers that look up the same map in both frames."),
    _number("drift_mean", "texels", "Mean drift of the receivers in the lattice of texels."),
    _number("drift_rms", "texels", "Root mean square drift of the receivers."),
    _number("drift_max", "texels", "Largest drift of a receiver."),
    _number("scale", "", "Factor of at least 1 by which the length of a texel changes, geometric mean."),
    _number("moving", "share", "Receivers on instances that move between the frames."),
    _number("switched", "share", "Receivers that look up another map in the second frame."),
    _number("lost", "share", "Receivers that one of the frames has in no map."),
    _count("judged", "px", "Receivers whose truth is the same in both frames."),
    _count("flips", "px", "Judged receivers whose shadow changes all the same."),
    _number("flip_share", "share", "Flips by judged receivers."),
    Column("refit", "", "boolean", "Whether the maps are others than those of the frame before."),
    _text("reason", "Why a `TemporalFit` made new maps; empty where it kept them, and for other techniques."),
)
_OF_RANKINGS = (
    _number(
        "error", "of the measure", "Error by the measure ranked by; a mean over shifts of the texels if counted.", ""
    ),
    _number(
        "error_sd", "of the measure", "Standard deviation of the error ranked by where texels shift, if counted.", ""
    ),
    _count("rank", "", "Place within the budget, from 1.", ""),
    _number("error_mean", "of the measure", "Mean of the error over the views.", ""),
    _number("error_worst", "of the measure", "Largest error of a view.", ""),
    _text("worst_view", "View of the largest error."),
    _number("ratio_to_best", "", "Error by that of the best with the same budget.", ""),
    _number("ratio_to_uniform", "", "Error by that of uniform with the same budget.", ""),
    Column("about_best", "", "boolean", "Whether the error is about equal to that of the best."),
    _text("along", "What the row goes along: the light's angle to the view, its elevation, or the memory."),
    _text("from", "Last view or budget before the new winner is about equal to the best."),
    _text("to", "First view or budget where the old winner no longer is."),
    _number("at_from", "rad or bytes", "Place of `from` along the row.", ""),
    _number("at_to", "rad or bytes", "Place of `to` along the row.", ""),
    _number("equal_from", "rad or bytes", "First place at which both are about equal.", ""),
    _number("equal_to", "rad or bytes", "Last place at which both are about equal.", ""),
    _text("winner_from", "Winner up to `from`."),
    _text("winner_to", "Winner from `to` on."),
    _number("error_from", "of the measure", "Error of `winner_from` at `from`.", ""),
    _number("error_to", "of the measure", "Error of `winner_to` at `to`.", ""),
    _number("other_from", "of the measure", "Error of `winner_to` at `from`.", ""),
    _number("other_to", "of the measure", "Error of `winner_from` at `to`.", ""),
)
_OF_NORMAL = (
    _count("configurations", "", "Configurations that both the technique and the normal map serve.", ""),
    _count("misclassified_normal", "px", "Wrong pixels of the normal map in these.", ""),
    _number("percent_more", "%", "How many more wrong pixels the normal map has than the technique.", ""),
    _count("misclassified_normal_by_map", "px", "As `misclassified_normal`, by the map that stands for the truth.", ""),
    _number("percent_more_by_map", "%", "As `percent_more`, by the map that stands for the truth.", ""),
    _count("wins", "", "Configurations in which the normal map has more wrong pixels.", ""),
    _count("clear_wins", "", "Configurations in which it has at least 1.1 times as many.", ""),
    _text("best", "Technique with the fewest wrong pixels of those that were counted."),
    _number("ratio_of_best", "", "Wrong pixels of the normal map by those of the best.", ""),
)
_OF_RUNS = (
    _text("failure_type", "Name of the class of the error that is the failure, such as UnsupportedError."),
    _text("notes", "What the technique could not do as asked, and doubts about given matrices."),
    _text("failure", "Why the row has no numbers; empty where it has."),
)

#: Every column by its name, in groups: views, maps, wrong pixels, texels, times, camera paths, rankings, the
#: normal map, runs.
GROUPS: Mapping[str, tuple[Column, ...]] = MappingProxyType(
    {
        "Views": _OF_VIEWS,
        "Maps": _OF_MAPS,
        "Wrong pixels": _OF_PIXELS,
        "Size of texels in the picture": _OF_TEXELS,
        "Times": _OF_TIME,
        "Camera paths": _OF_PATHS,
        "Rankings": _OF_RANKINGS,
        "Beside the normal map": _OF_NORMAL,
        "Remarks": _OF_RUNS,
    }
)
COLUMNS: Mapping[str, Column] = MappingProxyType({c.name: c for group in GROUPS.values() for c in group})

_CAUSES = tuple(CAUSES.values())
#: Of wrong pixels, and of their noise.
OF_WRONG = ("misclassified", "false_shadow", "false_light", "share", "compared", "undecided", "unmatched")
OF_NOISE = ("phases", "misclassified_mean", "misclassified_sd")
#: The columns of each table, in their order.
TABLES: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "compare": (
        "scene", "view", "technique", "settings", "resolution", "maps", "bytes", *OF_WRONG, *OF_NOISE, *_CAUSES,
        "edge_px", "undersampled", "texel_mean", "texel_p95", "texel_max", "perspective_max", "storage_factor",
        "unused", "outside_shadow", "samples_ms", "fit_us", "map_ms", "lookup_ms", "notes", "failure",
    ),
    "advise": (
        "memory", "rank", "scene", "technique", "spec", "maps", "resolution", "bytes", "unused_memory", "error_mean",
        "error_worst", "error_sd", "worst_view", "ratio_to_best", "ratio_to_uniform", "about_best", "notes", "failure",
    ),
    "advise.runs": (
        "scene", "view", "camera", "light", "light_angle", "light_elevation", "technique", "spec", "memory", "maps",
        "resolution", "bytes", "error", "error_sd", *OF_WRONG, *OF_NOISE, *_CAUSES, "texel_max", "texel_p95",
        "texel_mean", "undersampled", "perspective_max", "storage_factor", "measured", "outside", "outside_shadow",
        "samples_ms", "fit_us", "map_ms", "lookup_ms", "notes", "failure",
    ),
    "advise.switches": (
        "along", "camera", "memory", "from", "to", "at_from", "at_to", "equal_from", "equal_to", "winner_from",
        "winner_to", "error_from", "error_to", "other_from", "other_to",
    ),
    "over_light_angle": (
        "scene", "view", "technique", "angle_deg", "maps", "resolution", "measured", "texel_mean", "texel_p50",
        "texel_p95", "texel_p99", "texel_max", "undersampled", "storage_factor", "misclassified", "false_shadow",
        "false_light", "share", "notes", "failure",
    ),
    "frustum_over_light_angle": (
        "technique", "angle_deg", "maps", "m_s", "m_s_sheared", "m_t", "storage_factor", "storage_factor_sheared",
        "storage_factor_image", "notes", "failure",
    ),
    "temporal": (
        "scene", "view", "technique", "frame", "receivers", "drift_mean", "drift_rms", "drift_max", "scale",
        "moving", "switched", "lost", "judged", "flips", "flip_share", "failure",
    ),
    "scene_optimal": (
        "scene", "view", "camera", "light", "light_angle", "light_elevation", "technique", "spec", "single_side",
        "maps", "resolution", "bytes", *OF_WRONG, "misclassified_by_map", "compared_by_map", "outside_shadow",
        "samples_ms", "fit_us", "map_ms", "lookup_ms", "notes", "failure",
    ),
    "scene_optimal.totals": (
        "single_side", "technique", "configurations", "misclassified", "misclassified_normal", "percent_more",
        "misclassified_by_map", "misclassified_normal_by_map", "percent_more_by_map", "wins", "clear_wins",
    ),
    "scene_optimal.views": (
        "view", "camera", "light", "light_angle", "light_elevation", "misclassified_normal", "best", "misclassified",
        "ratio_of_best",
    ),
    "sweep": (
        "scene", "view", "camera", "light", "light_angle", "light_elevation", "technique", "spec", "resolution",
        "memory", "bias", "filter", "blend", "stored", "maps", "bytes", *OF_WRONG, *_CAUSES, "edge_px", "measured",
        "undersampled", "texel_mean", "texel_p50", "texel_p95", "texel_p99", "texel_max", "perspective_max",
        "storage_factor", "unused", "outside", "outside_shadow", "samples_ms", "fit_us", "map_ms", "lookup_ms",
        "seconds", "notes", "failure_type", "failure",
    ),
    "temporal.frames": (
        "scene", "view", "technique", "frame", "refit", "reason", "maps", *OF_WRONG, "failure",
    ),
})  # fmt: skip

#: Names that columns had before there was one vocabulary.
RENAMED: Mapping[str, str] = MappingProxyType({
    "error_p95": "texel_p95", "error_max": "texel_max", "render_ms": "map_ms", "mask_ms": "lookup_ms",
    "major_max": "texel_max", "major_p95": "texel_p95", "major_mean": "texel_mean", "mean": "texel_mean",
    "p50": "texel_p50", "p95": "texel_p95", "p99": "texel_p99", "max": "texel_max", "candidate": "technique",
    "label": "technique",
})  # fmt: skip


def table(name: str, rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """The rows as the table of that name: its columns in order, with their dtypes."""
    return frame(TABLES[name], rows)


def frame(names: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """The rows as a table of these columns; texts that are missing are empty.

    Columns of the vocabulary have its dtypes, others that of their values: "Int64", "float64", "boolean", or `object`
    of texts and of values of several kinds.
    """
    import pandas as pd

    held = list(rows)
    values = {name: [row.get(name) for row in held] for name in names}
    return pd.DataFrame({name: _series(name, of) for name, of in values.items()}, columns=list(names))


def _series(name: str, values: list[Any]) -> pd.Series:
    """The values of a column with its dtype, integers with all their digits."""
    import pandas as pd

    there = [value for value in values if value is not None]
    sought = (COLUMNS[name].dtype,) if name in COLUMNS else ()
    kinds = (*sought, *_FITS) if there else sought
    kind = next((dtype for dtype in kinds if all(map(_FITS[dtype], there))), "object")
    if kind == "str":
        return pd.Series(["" if value is None else value for value in values], dtype="object")
    return pd.Series(values, dtype=kind)


def _whole(value: object) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


# Whether a column of a dtype holds a value as it is, in the order in which a dtype is sought.
_FITS: Mapping[Dtype, Callable[[Any], bool]] = MappingProxyType({
    "str": lambda value: isinstance(value, str),
    "boolean": lambda value: isinstance(value, (bool, np.bool_)),
    "Int64": lambda value: _whole(value) or (isinstance(value, float) and (value != value or value.is_integer())),
    "float64": lambda value: isinstance(value, (float, np.floating)) or (_whole(value) and int(float(value)) == value),
})  # fmt: skip


def with_current(rows: pd.DataFrame, wanted: Iterable[str]) -> pd.DataFrame:
    """The table with the wanted columns under the names that they have now; warns of names from before."""
    missing = [name for name in wanted if name not in rows.columns]
    old = [name for name, now in RENAMED.items() if now in missing and name in rows.columns]
    return rows.rename(columns={name: current(name) for name in old})


def current(name: str) -> str:
    """The name that a column has now; warns of one from before."""
    if name not in RENAMED:
        return name
    warnings.warn(
        f"column {name!r} is called {RENAMED[name]!r} now; the old name will not be taken any more in 0.3",
        ShadowlabWarning,
        stacklevel=3,
    )
    return RENAMED[name]
