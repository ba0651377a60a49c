"""The plan of a sweep: every run that there will be, in the order of the table, before anything is drawn.

Names that do not exist, scenes that cannot be read and values of the wrong type are errors here. What a technique
refuses, a setting out of its range among them, is the failure of its row.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

from ... import _core
from ...errors import ShadowlabError, UnknownNameError
from ...techniques.labels import spec_of
from ...techniques.variant import MapReading, reading
from ...text import bias_of, bias_text, shown
from ...text.checks import check_bias, check_filter, checked_blend, checked_stored, renderer_of, whole
from ..columns import TABLES
from ..memory import BYTES_PER_TEXEL, bytes_of
from ..metrics import Metric
from ..store.row_text import Cell
from ..views import LabelledView
from .functions import Function, apart_from_names
from .scene_values import views_of_rows
from .space import KEYS, OF_SCENES, Named, RawRow, keys_with, one_for_each, raw_rows
from .technique_values import cell_of, check_given_once, id_of, item_of, labels_of, owner_of, settings_in
from .work import Group, Request

if TYPE_CHECKING:
    from ...types import Filter, Item, RendererArgument, RendererLike, Size

#: What is measured where nobody says.
SWEPT_METRICS: tuple[Metric, ...] = ("misclassified",)
RESOLUTION = 1024
#: After which column the settings of techniques stand, and before which those of functions.
SETTINGS_AFTER, FUNCTIONS_BEFORE = "spec", "seconds"
# Weights of what a run does, from times of evaluations on the processor: texels drawn and looked up, pixels compared
# (and measured, for each of the slower metrics), and triangles drawn.
TEXEL_COST, PIXEL_COST, TRIANGLE_COST = 1.0, 6.0, 2.0
METRIC_COST = {"mask": 0.0, "misclassified": 0.0, "causes": 2.0, "texels": 3.0, "usage": 6.0}
# What a view costs once, per pixel and per triangle: the truth and the G-buffer.
VIEW_PIXEL_COST, VIEW_TRIANGLE_COST = 60.0, 4.0


@dataclass(frozen=True, eq=False)
class Planned:
    """A row that there will be.

    Attributes
    ----------
    view : int
        Place of its view in the plan.
    request : Request or None
        None where the technique cannot be made.
    cells : dict of str to a plain value
        What is known of the row: labels, settings, and how the maps are read.
    failure : (str, str)
        Type and text of the reason why there is no request.
    note : str
        The settings that are not for its technique.
    """

    view: int
    request: Request | None
    cells: dict[str, Cell]
    failure: tuple[str, str] = ("", "")
    note: str = ""


@dataclass(frozen=True, eq=False)
class Plan:
    """Every run of a sweep, checked, and nothing drawn yet.

    Attributes
    ----------
    rows : tuple of Planned
        In the order of the table.
    views : tuple of LabelledView
        Each once, in the order of the rows.
    metrics : tuple of str
    functions : tuple of (str, callable)
        Metrics that are functions of a run.
    settings : tuple of str
        The keys of techniques' settings that there are, such as "lispsm.near".
    swept : tuple of str
        The columns that vary by what was asked for.
    notes : tuple of str
        What was left out: settings of other techniques, and rows that were there before.
    renderer : Renderer
    """

    rows: tuple[Planned, ...] = field(repr=False)
    views: tuple[LabelledView, ...] = field(repr=False)
    metrics: tuple[Metric, ...]
    functions: tuple[tuple[str, Function], ...]
    settings: tuple[str, ...]
    swept: tuple[str, ...]
    notes: tuple[str, ...]
    renderer: RendererLike = field(repr=False)

    @property
    def runs(self) -> int:
        """How many rows there will be."""
        return len(self.rows)

    @property
    def backend(self) -> str:
        """The kind of renderer."""
        return self.renderer.backend

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of the table; a function that gives a dict has those of its keys in the place of its name."""
        return columns_with(self.settings, [name for name, _ in self.functions])

    def groups(self, places: Iterable[int] | None = None) -> list[Group]:
        """The runs of these rows by their views, those that take longest first; all where none are given."""
        of_views: dict[int, list[Request]] = {}
        for place in range(self.runs) if places is None else places:
            row = self.rows[place]
            if row.request is not None:
                of_views.setdefault(row.view, []).append(row.request)
        found = [
            Group(self.views[i].view, tuple(requests), cost_of_view(self.views[i]) + sum(
                cost_of(self.views[i], request, self.metrics) for request in requests
            ))
            for i, requests in of_views.items()
        ]  # fmt: skip
        return sorted(found, key=lambda group: -group.cost)


def plan_of(
    space: object,
    *,
    size: Size | None = None,
    metrics: object = SWEPT_METRICS,
    renderer: RendererArgument = None,
) -> Plan:
    """The plan of a sweep: scenes are read and everything is checked, nothing is drawn.

    Parameters
    ----------
    space, size, metrics, renderer
        As of `sl.sweep`.

    Returns
    -------
    Plan

    Raises
    ------
    ArgumentError, UnknownNameError, LoadError
        As `sl.sweep`.

    Examples
    --------
    >>> from shadowlab.experiments.sweeps.plan import plan_of
    >>> plan = plan_of({"scene": "@robots", "technique": ["uniform", "lispsm"], "lispsm.near": [1, 2]}, size=(160, 90))
    >>> plan.runs, len(plan.views), plan.swept
    (3, 1, ('technique', 'lispsm.near'))
    """
    names, functions = apart_from_names(metrics)
    draws = renderer_of(renderer)
    raw = raw_rows(space)
    views, scenes, of_rows = views_of_rows(raw, size)
    maker = _Rows(views, scenes, labels_of(row["technique"] for row in raw))
    for row, view in zip(raw, of_rows, strict=True):
        maker.add(row, view)
    settings = tuple(dict.fromkeys(key for row in raw for key in row if key not in KEYS))
    rows = tuple(maker.rows)
    kept = tuple(key for key in settings if any(key in row.cells for row in rows))
    return Plan(
        rows, tuple(views), names, functions, kept, swept_in(rows, kept), tuple(maker.notes), draws
    )  # fmt: skip


class _Rows:
    """The rows of a plan as they come, none twice; whoever adds them holds their values, which are known by `id_of`."""

    def __init__(self, views: Sequence[LabelledView], scenes: Sequence[str], labels: Mapping[object, str]):
        # Angles of lights are worth making once: rows are many more than views.
        self.of_views = [cells_of_view(*one) for one in zip(views, scenes, strict=True)]
        self.labels = labels
        self.rows: list[Planned] = []
        self.notes: list[str] = []
        self._seen: dict[tuple[object, ...], int] = {}
        self._items: dict[tuple[object, ...], Item | tuple[str, str]] = {}

    def add(self, row: RawRow, view: int) -> None:
        """A row, unless it is there."""
        named = row["technique"]
        made = self._owner(named)
        owner = made if isinstance(made, str) else ""
        settings, dropped = settings_in(row, owner)
        for key in dropped:
            self._note(f"{key} does not apply to {owner or shown(named.value)}: left out there")
        check_given_once(named, settings)
        item: Item | tuple[str, str] = self._item(named, settings) if isinstance(made, str) else made
        resolution, memory = size_in(row)
        bias, kernel, blend, stored = read_in(row)
        same = (
            view, id_of(named.value), named.label, tuple((name, id_of(value)) for name, value in settings.items()),
            resolution, memory, bias, kernel, blend, stored,
        )  # fmt: skip
        if same in self._seen:
            if not dropped:
                self._note("rows that were there before are left out")
            return
        self._seen[same] = len(self.rows)
        label = self.labels[id_of(named.value), named.label]
        keys = {key: cell_of(one.value) for key, one in row.items() if key not in KEYS and key not in dropped}
        head: dict[str, Cell] = {**self.of_views[view], "technique": label, **keys, "memory": memory}
        if resolution is not None:
            head["resolution"] = resolution
        note = "; ".join(f"{key} does not apply" for key in dropped)
        place = len(self.rows)
        if isinstance(item, tuple):
            read = MapReading(_core.Bias() if bias is None else bias, kernel, blend, stored)
            self.rows.append(Planned(view, None, head | cells_of_reading(read), item, note))
            return
        read = reading(item, bias, kernel, blend, stored)
        head |= {"spec": spec_of(label, item), **cells_of_reading(read)}
        request = Request(place, label, item, resolution, memory, read)
        self.rows.append(Planned(view, request, head, note=note))

    def _owner(self, named: Named) -> str | tuple[str, str]:
        """The name that settings go by, or the type and text of why there is none."""
        try:
            return owner_of(named)
        except UnknownNameError:
            raise
        except ShadowlabError as error:
            if not isinstance(named.value, str):
                raise
            return type(error).__name__, str(error)

    def _item(self, named: Named, settings: dict[str, object]) -> Item | tuple[str, str]:
        """The technique, or the type and text of why there is none; the same object for the same row."""
        key = (id_of(named.value), *((name, id_of(value)) for name, value in settings.items()))
        if key not in self._items:
            try:
                self._items[key] = item_of(named, settings)
            except UnknownNameError:
                raise
            except ShadowlabError as error:
                self._items[key] = (type(error).__name__, str(error))
        return self._items[key]

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)


def size_in(row: RawRow) -> tuple[int | None, int | None]:
    """The resolution of a row, or its memory."""
    if "memory" in row:
        return None, bytes_of(row["memory"].value)
    return (whole("resolution", row["resolution"].value) if "resolution" in row else RESOLUTION), None


def read_in(row: RawRow) -> tuple[_core.Bias | None, Filter, float, _core.Stored]:
    """How the maps of a row are read, as it says it."""
    bias = row["bias"].value if "bias" in row else None
    if isinstance(bias, str):
        bias = bias_of(bias)
    check_bias(bias)
    kernel = row["filter"].value if "filter" in row else "nearest"
    check_filter(kernel)
    blend = checked_blend(row["blend"].value) if "blend" in row else 0.0
    stored = checked_stored(row["stored"].value if "stored" in row else None)
    return cast("_core.Bias | None", bias), cast("Filter", kernel), blend, stored


def cells_of_view(view: LabelledView, scene: str) -> dict[str, Cell]:
    """The cells that say which view of a scene of that label it is."""
    return {
        "scene": scene, "view": view.label, "camera": view.camera_label, "light": view.light_label,
        "light_angle": view.light_angle, "light_elevation": view.light_elevation,
    }  # fmt: skip


def cells_of_reading(read: MapReading) -> dict[str, Cell]:
    """The cells that say how maps are read."""
    return {"bias": bias_text(read.bias), "filter": read.filter, "blend": read.blend, "stored": str(read.stored)}


def swept_in(rows: Sequence[Planned], settings: Sequence[str]) -> tuple[str, ...]:
    """The columns that vary by what was asked for, in the order of the keys.

    Cameras and lights count where a scene has several: one of its own for each scene varies with the scene alone.
    """
    scenes = [id_of(row.cells.get("scene")) for row in rows]
    found = []
    for name in keys_with(settings):
        values = [id_of(row.cells.get(name)) for row in rows]
        if len(set(values)) > 1 and not (name in OF_SCENES and one_for_each(scenes, values)):
            found.append(name)
    return tuple(found)


def columns_with(settings: Sequence[str], functions: Sequence[str]) -> tuple[str, ...]:
    """The columns of a sweep with those of settings and of functions."""
    found: list[str] = []
    for name in TABLES["sweep"]:
        found += functions if name == FUNCTIONS_BEFORE else []
        found.append(name)
        found += settings if name == SETTINGS_AFTER else []
    return tuple(found)


def cost_of_view(view: LabelledView) -> float:
    """What the G-buffer and the truth of a view cost, in the unit of `cost_of`."""
    pixels = view.size[0] * view.size[1]
    return len(view.view.lights) * (VIEW_PIXEL_COST * pixels + VIEW_TRIANGLE_COST * view.view.scene.triangle_count)


def cost_of(view: LabelledView, request: Request, metrics: Sequence[str]) -> float:
    """What a run costs beside others; of no unit."""
    texels = request.resolution**2 if request.resolution is not None else (request.memory or 0) / BYTES_PER_TEXEL
    pixels = view.size[0] * view.size[1]
    slow = sum(METRIC_COST[name] for name in metrics)
    each = TEXEL_COST * texels + (PIXEL_COST + slow) * pixels + TRIANGLE_COST * view.view.scene.triangle_count
    return each * len(view.view.lights)
