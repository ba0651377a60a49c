"""One view under light from many angles: where a warp pays, where it hurts, and from which angle on.

Source: the storage factor of Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 [lloyd2008] and the errors of theory.md
E.1 and E.2, over the angle between light and view that Wimmer, Scherzer, Purgathofer 2004 [wimmer2004] (section 4.4)
and Zhang, Sun, Zhao, Wang 2007 [zhang2007] derive their warps for.

```
              light at 90 degrees, azimuth 0
                 |       /  30 degrees: from behind and above
                 v      v
      eye ---------------->  view          an angle of 0 is light along the view, 180 against it
```
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError, ShadowlabError
from ..scene.source import Source
from ..scene.view import View
from ..techniques.labels import labelled
from ..text import shown
from ..text.arrays import checked_items, checked_number
from ..text.checked import a_flag, a_text
from ..text.checks import renderer_of, whole
from ..text.progress import checked_progress, steps_of_call
from ..travel import Value
from .arguments import check_types, size_of
from .columns import current, table
from .evaluate import evaluate, fitted
from .metrics import Metric

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd

    from ..types import Filter, Item, RendererArgument, RendererLike, Techniques


# Two numbers that are this close are one: a map that fell back to the uniform one differs from it by rounding.
SAME = 1e-6


# Lights that a table is made for: a hundredth of a degree apart.
MOST_ANGLES = 36_000


@dataclass(frozen=True, eq=False, repr=False)
class LightAngles(Value):
    """Errors over the angle between light and view, one row a technique and angle.

    Attributes
    ----------
    table : DataFrame
        technique, angle_deg, and the numbers of `over_light_angle` or `frustum_over_light_angle`; failure says why a
        row has none.
    """

    table: pd.DataFrame

    def relative(self, y: str = "storage_factor", *, baseline: str = "uniform") -> pd.DataFrame:
        """A number over that of another technique: a row an angle (falling), a column a technique; above 1 it is worse.

        Parameters
        ----------
        y : str
            A column of the table.
        baseline : str
            The technique that the others are divided by.

        Raises
        ------
        ArgumentError
            For a column or technique that the table does not have.

        Notes
        -----
        1 where neither has any, as of two without a wrong pixel; NaN where either has no number.
        """
        a_text("y", y), a_text("baseline", baseline)
        y = y if y in self.table.columns else current(y)
        if y not in self.table.columns or not np.issubdtype(self.table[y].to_numpy().dtype, np.number):
            numbers = ", ".join(
                c for c in self.table.columns if c not in ("technique", "angle_deg", "notes", "failure")
            )
            raise ArgumentError(f"y: expected one of {numbers}, got {shown(y)}; see the table's columns")
        order = list(dict.fromkeys(self.table["technique"]))
        if baseline not in order:
            raise ArgumentError(f"baseline: expected one of {', '.join(order)}, got {shown(baseline)}; compare it, too")
        values = self.table.set_index(["angle_deg", "technique"])[y].astype(np.float64).unstack()  # noqa: PD010
        wide: pd.DataFrame = values[order].sort_index(ascending=False)
        ratios: pd.DataFrame = wide.div(wide[baseline], axis=0)
        return ratios.mask(wide.eq(0.0) & wide[baseline].eq(0.0).to_numpy()[:, None], 1.0)

    def crossovers(self, y: str = "storage_factor", *, baseline: str = "uniform") -> pd.DataFrame:
        """From which angle on each technique pays, and how much it hurts where it does not.

        Parameters
        ----------
        y, baseline
            As in `relative`.

        Returns
        -------
        DataFrame
            technique; pays_from_deg, above which it is better than the baseline at every angle of the table, the
            logarithm of the ratio interpolated (the least angle where it always is, NaN where it is not even at the
            largest); worst, the largest ratio, and worst_at_deg; best and best_at_deg; failed, at how many angles the
            technique or the baseline has no number. Such an angle ends what pays: pays_from_deg is the angle above it.

        Raises
        ------
        ArgumentError
            As `relative`.
        """
        import pandas as pd

        wide = self.relative(y, baseline=baseline)
        rows = []
        for name in wide.columns:
            if name == baseline:
                continue
            angles, values = wide.index.to_numpy(np.float64), wide[name].to_numpy(np.float64)
            known = ~np.isnan(values)
            row = {"technique": name, "pays_from_deg": pays_from(angles, values)}
            if known.any():
                worst, best = int(np.nanargmax(values)), int(np.nanargmin(values))
                row |= {"worst": values[worst], "worst_at_deg": angles[worst]}
                row |= {"best": values[best], "best_at_deg": angles[best]}
            rows.append(row | {"failed": int(np.count_nonzero(~known))})
        numbers = ["pays_from_deg", "worst", "worst_at_deg", "best", "best_at_deg"]
        table = pd.DataFrame(rows, columns=["technique", *numbers, "failed"])
        return table.astype({**dict.fromkeys(numbers, "float64"), "failed": "int64"})

    def __repr__(self) -> str:
        return f"LightAngles\n{self.table.to_string(index=False, float_format=lambda v: f'{v:.4g}')}"

    def _repr_html_(self) -> str:
        return str(self.table.to_html(index=False, border=0, float_format=lambda v: f"{v:.4g}"))


def light_at_angle(camera: _core.Camera, angle_deg: float, *, azimuth_deg: float = 0.0) -> _core.DirectionalLight:
    """The directional light at an angle to the view.

    Parameters
    ----------
    camera : Camera
    angle_deg : float
        Between the ways of light and view, degrees, 0 to 180: 90 shines across, less from behind the viewer, more
        against.
    azimuth_deg : float
        Where the light comes from, degrees: 0 from the image's upper side, 90 from its right.

    Raises
    ------
    ArgumentError
        For no camera, or numbers outside these ranges.
    """
    if not isinstance(camera, _core.Camera):
        raise ArgumentError(f"camera: expected a Camera, got {type(camera).__name__}; sl.Camera.look_at makes one")
    angle, azimuth = (
        np.radians(finite_degrees(n, v)) for n, v in (("angle_deg", angle_deg), ("azimuth_deg", azimuth_deg))
    )
    if not 0 <= angle <= np.pi:
        raise ArgumentError(f"angle_deg: expected 0 to 180 degrees, got {shown(angle_deg)}; turn the azimuth instead")
    origin = np.cos(azimuth) * np.asarray(camera.up) + np.sin(azimuth) * np.asarray(camera.right)
    return _core.DirectionalLight(np.cos(angle) * np.asarray(camera.forward) - np.sin(angle) * origin)


def over_light_angle(
    scene: _core.Scene,
    camera: _core.Camera,
    angles_deg: npt.ArrayLike | Iterable[float],
    techniques: Techniques = ("uniform", "lispsm"),
    *,
    azimuth_deg: float = 0.0,
    resolution: int = 1024,
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: _core.Bias | None = None,
    filter: Filter = "nearest",
    truth: bool = True,
    progress: bool | None = None,
) -> LightAngles:
    """Errors and wrong pixels of what a camera sees, over the angle between light and view, at equal memory.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    angles_deg : (A,) array_like
        As in `light_at_angle`, degrees; no angle twice.
    techniques : sequence or dict
        As for `sl.compare`; a dict gives each its label.
    azimuth_deg : float
        As in `light_at_angle`.
    resolution : int
        Texels along each side of a single map. Of k maps each has 1 / sqrt(k) of that, rounded down, so that together
        they have no more; those of a Parameterization that is given, too, whatever it was made for.
    size, renderer, bias, filter, progress
        As for `sl.compare`.
    truth : bool
        Whether to trace the truth; without it no wrong pixels are counted.

    Returns
    -------
    LightAngles
        Of each technique and angle: maps; resolution (texels along the side of each); of the `measured` pixels the
        mean, p50, p95, p99 and max of `Footprint.major` (px); undersampled (share); storage_factor, as in `Summary`;
        misclassified, false_shadow, false_light (px), share (of those compared).

    Raises
    ------
    ArgumentError
        For angles outside 0 to 180 or that come twice, and arguments of another type.
    UnknownNameError
        For a technique, filter or renderer that does not exist.
    """
    a_flag("truth", truth), checked_progress(progress)
    lights = lights_at(camera, angles_deg, azimuth_deg)
    check_types(scene, camera, next(iter(lights.values())), bias, filter)
    side, picture = whole("resolution", resolution), size_of(size, camera)
    entries = labelled(techniques, next(iter(lights.values())))
    draw = renderer_of(renderer)
    metrics: tuple[Metric, ...] = ("misclassified", "texels") if truth else ("texels",)
    measure = partial(evaluate, metrics=metrics, renderer=draw, bias=bias, filter=filter)
    rows = []
    with steps_of_call(len(lights) * len(entries), progress) as step:
        for angle, light in lights.items():
            view = View(scene, camera, light, picture, f"{angle:g}°")
            for label, item in entries:
                step(f"{label} at {angle:g} degrees")
                texels, failure = side_at_equal_memory(item, view, side, draw)
                if failure:
                    rows.append({"view": view.label, "technique": label, "angle_deg": angle, "failure": failure})
                else:
                    rows.append(measure(view, item, texels, label=label).row() | {"angle_deg": angle})
    name = Source.of_scene(scene).name
    return LightAngles(table("over_light_angle", [row | {"scene": name} for row in rows]))


def pays_from(angles: NDArray[np.float64], ratios: NDArray[np.float64]) -> float:
    """The angle above which all ratios are there and below 1; angles fall, and NaN is for none."""
    ends = np.flatnonzero(np.isnan(ratios) | (ratios > 1 - SAME))
    if not len(ends):
        return float(angles[-1])
    first = int(ends[0])
    if first == 0:
        return float("nan")
    if np.isnan(ratios[first]) or ratios[first - 1] == 0:
        # Nothing to interpolate to: what is known is the angle above.
        return float(angles[first - 1])
    above, at = np.log(ratios[first - 1]), np.log(max(ratios[first], 1.0))
    return float(angles[first] + (angles[first - 1] - angles[first]) * at / (at - above))


def side_at_equal_memory(item: Item, view: View, resolution: int, renderer: RendererLike) -> tuple[int, str]:
    """Texels along each side of a technique's maps that together have no more than one map of this resolution.

    0 and the reason where it has no maps.
    """
    side, maps = resolution, 0
    try:
        while True:
            # With other texels there may be more maps.
            maps = max(maps, len(fitted(item, view, side, renderer).partitions))
            if (fits := max(1, math.isqrt(resolution * resolution // maps))) >= side:
                return side, ""
            side = fits
    except ShadowlabError as error:
        return 0, str(error)


def lights_at(
    camera: _core.Camera, angles_deg: npt.ArrayLike | Iterable[float], azimuth_deg: float
) -> dict[float, _core.DirectionalLight]:
    """The light of each angle, in order."""
    single = isinstance(angles_deg, (int, float, np.generic))
    given = [angles_deg] if single else checked_items("angles_deg", angles_deg, "angles, degrees", "try [30, 60]")
    if len(given) > MOST_ANGLES:
        raise ArgumentError(f"angles_deg: expected at most {MOST_ANGLES:,} angles, got {len(given):,}; try [30, 60]")
    angles = [finite_degrees("angles_deg", angle) for angle in given]
    if any(not 0 <= angle <= 180 for angle in angles):
        raise ArgumentError(f"angles_deg: expected 0 to 180 degrees, got {shown(angles_deg)}; turn the azimuth instead")
    if not angles or len(set(angles)) < len(angles):
        raise ArgumentError(f"angles_deg: expected angles, none twice, got {shown(angles_deg)}; try range(90, 0, -5)")
    return {angle: light_at_angle(camera, angle, azimuth_deg=azimuth_deg) for angle in angles}


def finite_degrees(name: str, value: object) -> float:
    """The value as a finite number."""
    number = checked_number(name, value, "try 45", "a finite number of degrees")
    if not np.isfinite(number):
        raise ArgumentError(f"{name}: expected a finite number of degrees, got {shown(value)}; try 45")
    return number
