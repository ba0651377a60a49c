"""What `shadowlab check` is asked to hold: views, techniques or matrices, and bounds on columns, from a configuration.

What stands at the top of the document holds for every `[[check]]` that does not say otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..experiments.columns import COLUMNS, TABLES
from ..experiments.metrics import FILLED, KNOWN_METRICS, MEASURED, Metric
from ..techniques.registry import ALL, technique_of
from ..text import shown
from .check_camera import CameraFiles, camera_of_config
from .check_path import EXAMPLE_PATH, CameraPath, path_of_config, texts_of_frames
from .command import Options
from .config import Table
from .config_view import KEYS_OF_VIEW, holder, view_of_config

DEFAULT_RESOLUTION = 1024
CHECK_KEYS = ("name", *KEYS_OF_VIEW, "technique", "resolution", "phases", "path", "bounds")
EXAMPLE_BOUND = "share = { max = 0.02 }"
# Columns of one view that bounds may be set on, and those of a camera path.
VIEW_COLUMNS = ("maps", "bytes", *MEASURED)
PATH_COLUMNS = tuple(
    name for name in TABLES["temporal"] if COLUMNS[name].dtype in ("float64", "Int64") and name != "frame"
)


@dataclass(frozen=True)
class Bound:
    """A bound on a column.

    Attributes
    ----------
    column : str
    least, most : float or None
        None where there is no bound on that side.
    """

    column: str
    least: float | None
    most: float | None

    @property
    def text(self) -> str:
        """The bound in words, with the column's unit."""
        sides = [("at least", self.least), ("at most", self.most)]
        return " and ".join(f"{word} {self.said(value)}" for word, value in sides if value is not None)

    def said(self, value: float) -> str:
        """A value of the column with its unit."""
        unit = COLUMNS[self.column].unit
        return f"{100 * value:.6g} %" if unit == "share" else f"{value:.6g} {unit}".rstrip()

    def holds(self, value: float) -> bool:
        """Whether a value is within the bound."""
        return (self.least is None or value >= self.least) and (self.most is None or value <= self.most)


@dataclass(frozen=True)
class Gate:
    """Techniques in one view, and what must hold of each.

    Attributes
    ----------
    name : str
    options : Options
        The view and how maps are read, as the command line gives them.
    techniques : dict of str to str
        Their texts by their labels.
    resolution, phases : int
    bounds : tuple of Bound
    path : CameraPath or None
    camera : CameraFiles or None
        Where the view has that of an engine's matrices.
    table : Table
        Where it stands in the configuration.
    """

    name: str
    options: Options
    techniques: dict[str, str]
    resolution: int
    phases: int
    bounds: tuple[Bound, ...]
    path: CameraPath | None
    camera: CameraFiles | None
    table: Table

    @property
    def metrics(self) -> tuple[Metric, ...]:
        """What has to be measured for the bounds."""
        bounded = {bound.column for bound in self.bounds}
        return tuple(metric for metric in KNOWN_METRICS if bounded & set(FILLED[metric]))


def checks_of(top: Table) -> list[Gate]:
    """The checks of a configuration; the document itself is one where it has no `[[check]]`.

    Raises
    ------
    ArgumentError
        For a key that does not exist, a value that does not fit, or a check without techniques or bounds.
    """
    top.only((*CHECK_KEYS, "check"))
    tables = top.tables("check")
    for table in tables:
        table.only(CHECK_KEYS)
    if tables and "name" in top:
        raise top.wrong("name", "expected no name at the top beside [[check]], got one; name each check")
    checks = [one_check([table, top], i) for i, table in enumerate(tables, 1)] or [one_check([top], 1)]
    names = [check.name for check in checks]
    for check in checks:
        if names.count(check.name) > 1:
            raise check.table.wrong("name", f"expected a name of its own, got {check.name!r} twice")
    return checks


def one_check(tables: Sequence[Table], number: int) -> Gate:
    """A check of the first table; what it does not say the others say."""
    own = tables[0]
    options = view_of_config(tables)
    of_resolution, of_phases = (holder(tables, key) or own for key in ("resolution", "phases"))
    path = path_of_config(tables)
    camera = camera_of_config(tables, path)
    if path is not None and camera is None and not (any(path.step) or path.turn):
        of_path = holder(tables, "path") or own
        raise of_path.wrong("path", f"expected a camera that moves, got no step and no turn-deg; try {EXAMPLE_PATH}")
    phases = of_phases.whole("phases", 1)
    techniques = techniques_of(tables, path)
    bounds = bounds_of(tables, path, phases)
    scene = options.scene if options.scene.startswith("@") else Path(options.scene).name
    label = f"{scene}, {number}" if own.place else scene
    return Gate(
        own.text("name", "a name", label) or label,
        options,
        techniques,
        of_resolution.whole("resolution", DEFAULT_RESOLUTION),
        phases,
        bounds,
        path,
        camera,
        own,
    )


def techniques_of(tables: Sequence[Table], path: CameraPath | None) -> dict[str, str]:
    """The texts of the techniques by their labels; where none are given a text is its own label."""
    table = holder(tables, "technique")
    expected = 'a technique such as "lispsm" or "matrix:file=mine.npy,convention=opengl", or a list of them'
    if table is None:
        raise tables[0].wrong("technique", f"expected {expected}, got none")
    of_labels = table.table("technique", "") if isinstance(table.get("technique"), dict) else None
    if of_labels is not None:
        found = {label: (of_labels, label, of_labels.text(label, expected) or "") for label in of_labels.values}
    else:
        texts = table.texts("technique", expected) or []
        found = {text: (table, "technique", text) for text in texts}
        for text in texts:
            if texts.count(text) > 1:
                raise table.wrong("technique", f"{text!r} comes twice; give it once")
    if not found:
        raise table.wrong("technique", f"expected {expected}, got none")
    for where, key, text in found.values():
        if text == ALL:
            raise where.wrong(key, 'expected techniques by their names, got "all"; list those that must hold')
        with where.naming(key):
            for one in texts_of_frames(text, path):
                technique_of(one)
    return {label: text for label, (_, _, text) in found.items()}


def bounds_of(tables: Sequence[Table], path: CameraPath | None, phases: int) -> tuple[Bound, ...]:
    """The bounds; those of the first table go before those of the others for the same column."""
    found: dict[str, Bound] = {}
    for table in tables:
        of_bounds = table.table("bounds", "{ share = { max = 0.02 } }")
        if of_bounds is None:
            continue
        of_bounds.only((*VIEW_COLUMNS, *PATH_COLUMNS))
        for column in of_bounds.values:
            bound = bound_of(of_bounds, column)
            found.setdefault(bound.column, bound)
            if bound.column in PATH_COLUMNS and path is None:
                raise of_bounds.wrong(column, f"expected a camera path beside it, got none; add path = {EXAMPLE_PATH}")
            if bound.column in ("misclassified_mean", "misclassified_sd", "phases") and phases < 2:
                raise of_bounds.wrong(column, "expected phases of 2 or more beside it; add phases = 8")
    own = tables[0]
    along = sorted(set(found) & set(PATH_COLUMNS))
    if "path" in own and not along:
        raise own.wrong(
            "path", f"expected a bound on one of {', '.join(PATH_COLUMNS)} beside it, got none; remove the path"
        )
    for key in ("stored", "blend"):
        of_key = holder(tables, key)
        if along and of_key is not None:
            fix = 'say it in the technique, "lispsm:stored=back,mix=0.1"'
            raise of_key.wrong(key, f"expected none beside a bound on {along[0]}, got one; {fix}")
    if not found:
        raise own.wrong("bounds", f"expected at least one bound, got none; try {EXAMPLE_BOUND}")
    return tuple(found.values())


def bound_of(table: Table, column: str) -> Bound:
    """The bound on a column."""
    sides = table.table(column, "{ max = 0.02 }")
    assert sides is not None
    sides.only(("max", "min"))
    least, most = (sides.number(side, "a number") for side in ("min", "max"))
    if least is None and most is None:
        raise table.wrong(column, "expected max or min, got neither; try { max = 0.02 }")
    for side, value in (("min", least), ("max", most)):
        if value is not None and not math.isfinite(value):
            raise sides.wrong(side, f"expected a finite number, got {shown(value)}; remove a bound that always holds")
    if least is not None and most is not None and least > most:
        raise table.wrong(column, f"expected min up to max, got {least:g} above {most:g}")
    return Bound(column.replace("-", "_"), least, most)
