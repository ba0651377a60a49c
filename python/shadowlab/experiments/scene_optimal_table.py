"""What the scene-optimal experiment counted: sums beside the normal map, wins, and bounds that are checked."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ..errors import UnknownNameError
from ..text import shown
from ..travel import Value
from .columns import table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: The paper's normal map: the smallest rectangle around the part of the view frustum that the light reaches.
NORMAL = "uniform:turn=rectangle"
PUBLISHED, OPTIMAL = "scene_optimal:search=published", "scene_optimal"
#: The figures: the curves, and the settings of the paper's own figures by library scene.
CURVES = "percent_more"
FIGURES = (CURVES, "dueling", "skylight", "statues")
#: A configuration is clearly won where the normal map has so many times the wrong pixels.
CLEARLY = 1.1
#: At each size the normal map makes at least so many percent more mistakes in sum: what was counted in another scene of
#: as many triangles and 28 configurations of its own, with maps of 750 to 2000 texels a side.
BOUNDS: Mapping[str, float] = MappingProxyType(
    {PUBLISHED: 65.0, OPTIMAL: 100.0, "optimal_partition:count=2": 130.0, "rectilinear": 150.0}
)


@dataclass(frozen=True, eq=False, repr=False)
class SceneOptimalTable(Value):
    """Wrong pixels of techniques at equal memory in many views, beside those of the normal map.

    Attributes
    ----------
    table : DataFrame
        One row per view, size and technique; `failure` says why a row has no numbers.
    reference : int
        Texels along each side of the normal map that the paper takes for the truth.
    backend, adapter : str
        Of the renderer.
    """

    table: pd.DataFrame
    reference: int
    backend: str
    adapter: str

    @property
    def techniques(self) -> list[str]:
        """The labels, in order, the normal map among them."""
        return list(dict.fromkeys(self.table["technique"]))

    @property
    def served_by_all(self) -> SceneOptimalTable:
        """The same of those views alone that every technique serves, so that sums may be compared with each other."""
        failed = set(self.table["view"][self.table["failure"] != ""])
        return replace(self, table=self.table[~self.table["view"].isin(failed)].reset_index(drop=True))

    @property
    def totals(self) -> pd.DataFrame:
        """One row per size and technique other than the normal map: sums over the views that both serve."""
        return table("scene_optimal.totals", self._totals(["single_side"]))

    @property
    def in_sum(self) -> pd.DataFrame:
        """`totals` over all sizes together; `single_side` is empty."""
        return table("scene_optimal.totals", self._totals([]))

    @property
    def views(self) -> pd.DataFrame:
        """One row per view, over all sizes together: the normal map and the best of the other techniques."""
        rows = []
        for _, of in self.table.groupby("view", sort=False):
            counts = served(of).groupby("technique", sort=False)["misclassified"].sum()
            others = counts.drop(NORMAL)
            first = of.iloc[0]
            row = {name: first[name] for name in ("view", "camera", "light", "light_angle", "light_elevation")}
            row["misclassified_normal"] = int(counts[NORMAL])
            if len(others):
                best = str(others.idxmin())
                least = int(others[best])
                row |= {
                    "best": best,
                    "misclassified": least,
                    "ratio_of_best": times_as_many(int(counts[NORMAL]), least),
                }
            rows.append(row)
        return table("scene_optimal.views", rows)

    def ratios(self, technique: str) -> pd.Series[float]:
        """How many times the wrong pixels of a technique the normal map has, by view, over all sizes together."""
        ours, normal = self._pairs(technique)
        sums = ours.groupby("view", sort=False)["misclassified"].sum()
        base = normal.groupby("view", sort=False)["misclassified"].sum()
        return (base.astype(float) / sums.clip(lower=1).astype(float)).reindex(sums.index)

    def failed_bounds(self, bounds: Mapping[str, float]) -> list[str]:
        """A sentence for each bound on `percent_more` and size at which it does not hold, or if it was not counted."""
        sizes = self.totals
        sentences = []
        for technique, least in bounds.items():
            own = sizes[sizes["technique"] == technique]
            if not len(own):
                sentences.append(f"{technique}: expected to be counted, for its bound of {least:g} %")
            for side, more in zip(own["single_side"], own["percent_more"], strict=True):
                if not more >= least:
                    sentences.append(
                        f"{technique}: expected that the normal map makes at least {least:g} % more mistakes at "
                        f"{side}², got {more:.1f} %"
                    )
        return sentences

    def save(self, directory: str | os.PathLike[str], *, progress: bool | None = None) -> Path:
        """Writes tables as CSV, JSON and Markdown and the figures as PNG there; returns the directory."""
        from ..reports.scene_optimal import save

        return save(self, Path(directory), progress)

    def figure(self, name: str = CURVES) -> Figure:
        """A figure of `FIGURES`: the curves over the size of the map, or a paper's scene with its samples and maps.

        Raises
        ------
        UnknownNameError
            For another name.
        """
        from ..plot.scene_optimal import scene_optimal_figure

        if name not in FIGURES:
            raise UnknownNameError(f"figure: unknown {shown(name)}; expected one of {', '.join(FIGURES)}")
        return scene_optimal_figure(self, name)

    def __repr__(self) -> str:
        from ..reports.scene_optimal import terminal_text

        return terminal_text(self)

    def _repr_html_(self) -> str:
        page: str = self.totals.to_html(index=False, border=0, float_format=lambda v: f"{v:.1f}")
        return page

    def _pairs(self, technique: str) -> tuple[pd.DataFrame, pd.DataFrame]:
        """The rows of a technique that have numbers, and those of the normal map for the same views and sizes."""
        rows = served(self.table).set_index(["view", "single_side"])
        ours, normal = (rows[rows["technique"] == name] for name in (technique, NORMAL))
        both = ours.index.intersection(normal.index, sort=False)
        return ours.loc[both].reset_index(), normal.loc[both].reset_index()

    def _totals(self, by: Sequence[str]) -> list[dict[str, Any]]:
        rows = []
        sides = list(dict.fromkeys(self.table["single_side"])) if by else [None]
        for side in sides:
            for technique in self.techniques:
                if technique == NORMAL:
                    continue
                ours, normal = self._pairs(technique)
                if side is not None:
                    ours, normal = (part[part["single_side"] == side] for part in (ours, normal))
                row: dict[str, Any] = {
                    "single_side": side, "technique": technique, "configurations": int(ours["view"].nunique())
                }  # fmt: skip
                for count, base, percent in (
                    ("misclassified", "misclassified_normal", "percent_more"),
                    ("misclassified_by_map", "misclassified_normal_by_map", "percent_more_by_map"),
                ):
                    row[count], row[base] = int(ours[count].sum()), int(normal[count].sum())
                    more = times_as_many(row[base], row[count])
                    row[percent] = None if more is None else 100.0 * (more - 1.0)
                mine = ours.groupby("view", sort=False)["misclassified"].sum()
                base_of = normal.groupby("view", sort=False)["misclassified"].sum().reindex(mine.index)
                row["wins"] = int((base_of > mine).sum())
                row["clear_wins"] = int((base_of.astype(float) >= CLEARLY * mine.astype(float)).sum())
                rows.append(row)
        return rows


def served(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows that have numbers."""
    return rows[rows["failure"] == ""]


def times_as_many(normal: int, other: int) -> float | None:
    """How many times the wrong pixels; None where the other has none."""
    return normal / other if other else None
