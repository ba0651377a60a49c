"""The experiment of the scene-optimized shadow maps: wrong pixels of techniques at equal memory in 28 configurations.

Source: Chong, Gortler 2007 [chong2007], section 5: pictures of 1024 x 1024 pixels, maps of 750 to 2000 texels a side,
and how many percent more mistakes the normal map makes. Departures: the scene and the configurations are ours (theirs
were not published, see `scene_optimal_views`); truth is traced, and their truth, a normal map of 3700 x 3700 texels,
stands beside it; more techniques are counted, and techniques with K maps have maps of N / sqrt(K) texels a side.

```
    configuration:  G-buffer (of the camera), truth, samples, reference map      made once, shared by
        size N, technique:  fit -> draw -> look up -> count twice                 all sizes and techniques
```
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .. import _core
from ..aliasing.codes import LIT_FROM
from ..errors import ArgumentError, ShadowlabError, UnknownNameError
from ..techniques.kinds import is_parameterization
from ..techniques.labels import labelled, spec_of
from ..text import reason_of, shown
from ..text.arrays import checked_items
from ..text.checked import a_count, a_path
from ..text.checks import check_bias, renderer_of, whole
from ..text.progress import checked_progress, steps_of_call
from ..text.specs import LONGEST_PICTURE
from ..trace import Truth
from .columns import table
from .evaluate import evaluate, fitted
from .memory import BYTES_PER_TEXEL, side_of
from .scene_optimal_table import NORMAL, SceneOptimalTable
from .scene_optimal_views import configurations
from .store.keys import key_of_parts, technique_parts
from .store.store import Store
from .views import LabelledView

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..scene.view import View
    from ..types import Item, RendererArgument, RendererLike, Techniques

#: Texels along each side of a single map, as in the paper.
SIZES = (750, 1000, 1250, 1500, 1750, 2000)
QUICK_SIZES = (1000,)
#: What is counted where nobody says, by the texts that make them; the normal map is the first.
TECHNIQUES = (
    NORMAL, "uniform", "lispsm", "gmnpr", "tsm", "plane_optimal", "scene_optimal:search=published", "scene_optimal",
    "z_partition:count=4,inner=lispsm", "optimal_partition:count=2", "rectilinear",
)  # fmt: skip
QUICK_TECHNIQUES = (
    NORMAL, "scene_optimal:search=published", "scene_optimal", "optimal_partition:count=2", "rectilinear"
)  # fmt: skip
#: Texels along each side of the map that the paper takes for the truth.
REFERENCE_SIDE = 3700
# Bytes of truths that are made at once, one a pixel: 32 pictures of 1024 x 1024, a small part of what views keep.
TRACED_BYTES = 1 << 25
ROWS_FILE = "runs.sqlite"


def scene_optimal_experiment(
    techniques: Techniques = TECHNIQUES,
    *,
    sizes: Iterable[int] = SIZES,
    views: Sequence[LabelledView] | None = None,
    renderer: RendererArgument = None,
    bias: _core.Bias | None = None,
    reference: int = REFERENCE_SIDE,
    out: str | Path | None = None,
    progress: bool | None = None,
) -> SceneOptimalTable:
    """Wrong pixels of techniques at equal memory in many views, against traced truth and against a large normal map.

    Parameters
    ----------
    techniques : sequence or dict
        As for `sl.compare`. The paper's normal map, "uniform:turn=rectangle", is counted in any case.
    sizes : iterable of int
        Texels along each side of a single map. A technique with K maps gets maps of at most size / sqrt(K).
    views : sequence of LabelledView, optional
        Where it is counted; the 28 of `scene_optimal_views.configurations` where none are given.
    renderer : Renderer or str, optional
        As of `sl.compare`.
    bias : Bias, optional
        ``Bias()`` where none is given.
    reference : int
        Texels along each side of the normal map that the paper takes for the truth.
    out : path, optional
        A directory. Rows are kept in a store there, ``runs.sqlite``, as they are counted, and not counted again where
        they are there for the same settings.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.

    Returns
    -------
    SceneOptimalTable
        What a technique cannot do with a light is the `failure` of its row.

    Raises
    ------
    ArgumentError
        For sizes that are no whole numbers above 0 or come twice, matrices instead of techniques, no views, and views
        that share a label.
    UnknownNameError
        For a technique or renderer that does not exist.
    StoreError
        For a file in `out` that is no store, or cannot be read or written.

    References
    ----------
    Chong, Gortler, "Scene Optimized Shadow Mapping", Harvard technical report TR-07-07, 2007 [chong2007].

    Examples
    --------
    >>> import shadowlab as sl
    >>> from shadowlab.experiments import scene_optimal_views
    >>> scene = sl.library.scene("statues", facets=12, leaves=20)
    >>> views = scene_optimal_views.configurations(96, scene)[:1]
    >>> found = sl.scene_optimal_experiment(
    ...     ["scene_optimal"], sizes=[64], views=views, reference=256, renderer="cpu", progress=False
    ... )
    >>> list(found.table["technique"])
    ['uniform:turn=rectangle', 'scene_optimal']
    """
    how = _How(renderer_of(renderer), check_bias_or_default(bias), a_count(1, LONGEST_PICTURE)("reference", reference))
    sides = checked_sizes(sizes)
    seen = checked_views(configurations() if views is None else views)
    entries = with_normal(techniques)
    checked_progress(progress)
    out = None if out is None else a_path("out", out)
    if out is not None:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ArgumentError(f"out: expected a directory, cannot make {str(out)!r} ({reason_of(error)})") from None
    wanted = [
        _Count(view, label, item, side, how.key(view, item, side))
        for view in seen
        for side in sides
        for label, item in entries
    ]
    with ExitStack() as stack:
        store = None if out is None else stack.enter_context(Store(out / ROWS_FILE))
        rows = _done_rows(store, [one.key for one in wanted])
        step = stack.enter_context(steps_of_call(len(wanted), progress))
        counting, traced = None, list[LabelledView]()
        for one in wanted:
            step(f"{one.view.label}, {one.label} {one.side}²")
            if counting is None or counting.view is not one.view:
                counting = _Counting(how, one.view)
            if one.key not in rows:
                if one.view not in traced:
                    traced += _traced_together(one.view, [other.view for other in wanted if other.key not in rows])
                rows[one.key] = counting.row(one.label, one.item, one.side)
                if store is not None:
                    store.put(one.key, rows[one.key])
        found = table("scene_optimal", [rows[one.key] | one.names for one in wanted])
    return SceneOptimalTable(found, how.reference, how.renderer.backend, how.renderer.adapter)


def _traced_together(first: LabelledView, others: Iterable[LabelledView]) -> list[LabelledView]:
    """The views whose truths are traced now: the first, and others of its picture, which share the rays of its eye."""
    view = first.view
    of = [other for other in dict.fromkeys(others) if _picture_of(other.view) == _picture_of(view)]
    together = of[: max(1, TRACED_BYTES // (view.size[0] * view.size[1]))]
    # Where they fail together, the row of each says why.
    with suppress(ShadowlabError):
        replace(view, light=tuple(light for one in together for light in one.view.lights)).truth()
    return together


def _picture_of(view: View) -> tuple[object, ...]:
    """What the rays from the eye depend on."""
    return view.scene.content_hash, view.camera, view.size


def _done_rows(store: Store | None, keys: Sequence[str]) -> dict[str, dict[str, Any]]:
    """The rows of these keys that are done, by key."""
    if store is None:
        return {}
    missing = set(store.missing(keys))
    return dict(store.rows([key for key in keys if key not in missing]))


def chosen_views(names: Sequence[str], views: Sequence[LabelledView]) -> list[LabelledView]:
    """The views of these labels; a camera's or a light's name alone means all of it.

    Raises
    ------
    UnknownNameError
        For a name that no view has.
    """
    found: list[LabelledView] = []
    for name in names:
        of = [view for view in views if name in (view.label, view.camera_label, view.light_label)]
        if not of:
            cameras = dict.fromkeys(view.camera_label for view in views)
            lights = dict.fromkeys(view.light_label for view in views)
            raise UnknownNameError(
                f"configurations: unknown {shown(name)}; expected a camera ({', '.join(cameras)}), a light "
                f'({", ".join(lights)}) or both such as "{views[0].label}"'
            )
        found += [view for view in of if view not in found]
    return found


def with_normal(techniques: Techniques) -> list[tuple[str, Item]]:
    """(label, technique) of all, the normal map first."""
    entries = labelled(techniques)
    for label, item in entries:
        if is_parameterization(item):
            raise ArgumentError(f"techniques: {label!r} is matrices of one view; give the technique that makes them")
    return entries if NORMAL in dict(entries) else labelled([NORMAL]) + entries


def checked_sizes(sizes: object) -> list[int]:
    """The sizes, none twice.

    Raises
    ------
    ArgumentError
    """
    given = checked_items("sizes", sizes, "several whole numbers of texels", "try [750, 2000]")
    found = [whole("sizes", one) for one in given]
    if not found or len(set(found)) < len(found):
        raise ArgumentError(f"sizes: expected at least one, each once, got {shown(found)}; try [750, 2000]")
    return found


def checked_views(views: Sequence[LabelledView]) -> list[LabelledView]:
    """The views, whose labels differ.

    Raises
    ------
    ArgumentError
    """
    found = checked_items("views", views, "several LabelledView objects", "try scene_optimal_views")
    for one in found:
        if not isinstance(one, LabelledView):
            raise ArgumentError(
                f"views: expected LabelledView objects, got {type(one).__name__}; try scene_optimal_views"
            )
    if not found or len({one.label for one in found}) < len(found):
        raise ArgumentError(f"views: expected at least one, labels once each, got {[one.label for one in found]}")
    return found


def check_bias_or_default(bias: object) -> _core.Bias:
    """The bias; the default one where none is given."""
    check_bias(bias)
    return _core.Bias() if bias is None else cast("_core.Bias", bias)


@dataclass(frozen=True)
class _How:
    """How all views are counted."""

    renderer: RendererLike
    bias: _core.Bias
    reference: int

    def key(self, view: LabelledView, item: Item, side: int) -> str:
        """The key of a row."""
        drawn = (self.renderer.backend, self.renderer.adapter, self.bias, self.reference)
        what = (view.view.scene.content_hash, view.camera, view.light, view.size)
        return key_of_parts("scene_optimal", *what, *drawn, technique_parts(item), side)


@dataclass(frozen=True)
class _Count:
    """A row that there is to be."""

    view: LabelledView
    label: str
    item: Item
    side: int
    key: str

    @property
    def names(self) -> dict[str, Any]:
        """What the row calls its view and technique; a kept one may be of another table."""
        view = self.view
        names = {"view": view.label, "camera": view.camera_label, "light": view.light_label}
        return names | {"technique": self.label, "spec": spec_of(self.label, self.item)}


class _Counting:
    """One view: what all techniques and sizes share in it, and the rows."""

    def __init__(self, how: _How, view: LabelledView):
        self.how, self.view = how, view
        self._reference: NDArray[np.int8] | None = None
        self._counts: dict[str, int] = {}

    def row(self, label: str, item: Item, side: int) -> dict[str, Any]:
        """The row of a technique in the memory of one map of so many texels a side."""
        view, memory = self.view, BYTES_PER_TEXEL * side * side
        own = side_of(memory, self._maps(label, item)) or side
        run = evaluate(
            view.view, item, own, metrics=["misclassified"], renderer=self.how.renderer, bias=self.how.bias, label=label
        )
        row = run.row() | {"memory": memory, "single_side": side}
        if run.failure:
            return row
        by_map = _core.misclassified(cast("NDArray[np.float32]", run.mask), self.reference)
        return row | {"misclassified_by_map": int(by_map.count), "compared_by_map": int(by_map.compared)}

    def _maps(self, label: str, item: Item) -> int:
        """The number of maps in this view; 1 where there are none, as `evaluate` finds again and says."""
        if label not in self._counts:
            count = 1
            if "count" in item.settings or "inner" in item.settings:
                try:
                    count = len(fitted(item, self.view.view, self.how.reference, self.how.renderer).matrices)
                except ShadowlabError:
                    count = 1
            self._counts[label] = count
        return self._counts[label]

    @property
    def reference(self) -> NDArray[np.int8]:
        """What the paper takes for the truth (H, W) int8, of the kind of `View.truth`."""
        if self._reference is None:
            run = evaluate(
                self.view.view, NORMAL, self.how.reference, metrics=["mask"], renderer=self.how.renderer,
                bias=self.how.bias,
            )  # fmt: skip
            if run.failure:
                raise ArgumentError(f"views: {self.view.label!r} has no normal map to compare with: {run.failure}")
            mask = np.asarray(run.mask)
            lit = np.where(mask >= LIT_FROM, Truth.LIT, Truth.SHADOW)
            self._reference = np.where(np.isnan(mask), Truth.NOTHING, lit).astype(np.int8)
        return self._reference
