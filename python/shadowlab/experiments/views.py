r"""The views of an advice: every camera with every light, with names that tell them apart and the angle between both.

       eye                      The light angle is that between the way the light travels and the way the eye
        \  view                 looks: 0 where the light comes from behind the eye, 90 degrees from the side, 180
 light   \                      straight into it. Warps gain least at both ends, where light and view run along
--------> x  the angle          one line.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np

from .. import _core
from ..errors import ArgumentError
from ..scene.light_way import angle_to, elevation_of, light_way
from ..scene.view import View, light_of
from ..text.arrays import checked_items
from ..text.checked import KINDS_OF_LIGHTS, LIGHT_HINT, LIGHTS, a_text

T = TypeVar("T")

if TYPE_CHECKING:
    from ..types import Labelled, Light

# Angles this close, radians, are ordered by other things: half a degree, as texts round.
SAME_ANGLE = math.radians(0.5)


@dataclass(frozen=True)
class LabelledView:
    """A view of one of several cameras under one of several lights.

    Attributes
    ----------
    view : View
        Its label is of camera and light together; of the one that has several alone.
    camera_label, light_label : str
    """

    view: View
    camera_label: str
    light_label: str

    @property
    def label(self) -> str:
        """The view's label."""
        return self.view.label

    @property
    def camera(self) -> _core.Camera:
        """The view's camera."""
        return self.view.camera

    @property
    def light(self) -> Light:
        """The view's light."""
        return light_of(self.view)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, pixels."""
        return self.view.size

    @property
    def light_angle(self) -> float | None:
        """As `View.light_angle`."""
        return self.view.light_angle

    @property
    def light_elevation(self) -> float | None:
        """As `View.light_elevation`."""
        return self.view.light_elevation


def views_of(
    scene: _core.Scene,
    cameras: Labelled[_core.Camera],
    lights: Labelled[Light],
    sizes: Callable[[_core.Camera], tuple[int, int]],
) -> list[LabelledView]:
    """The product of cameras and lights, cameras first; `sizes` gives the pixels of a camera's picture.

    Raises
    ------
    ArgumentError
        For none of either, something else among them, or a label that comes twice.
    """
    of_cameras = named("cameras", cameras, _core.Camera, "a Camera", "sl.Camera.look_at makes one")
    of_lights: list[tuple[str | None, Light]] = named("lights", lights, LIGHTS, KINDS_OF_LIGHTS, LIGHT_HINT)
    single = of_cameras[0][1] if len(of_cameras) == 1 else None
    ways = [light_way(scene, light) for _, light in of_lights]
    names = [text or light_label(way, light, single) for (text, light), way in zip(of_lights, ways, strict=True)]
    views = []
    for i, (camera_name, camera) in enumerate(of_cameras):
        size = sizes(camera)
        for light_name, (given, light) in zip(apart(names), of_lights, strict=True):
            parts = [camera_name or f"camera {i + 1}"] if camera_name or len(of_cameras) > 1 else []
            parts += [light_name] if given or len(of_lights) > 1 or not parts else []
            own = camera_name or ("camera" if single is not None else f"camera {i + 1}")
            views.append(LabelledView(View(scene, camera, light, size, ", ".join(parts)), own, light_name))
    labels = [view.label for view in views]
    for label in labels:
        if labels.count(label) > 1:
            raise ArgumentError(f"cameras: with the lights' labels two views are {label!r}; give others")
    return views


def named(
    name: str, value: Labelled[T], kind: type[T] | tuple[type[T], ...], what: str, hint: str
) -> list[tuple[str | None, T]]:
    """(label or None, thing) of one thing, several, or a dict of them."""
    if isinstance(value, Mapping):
        entries: list[tuple[str | None, T]] = [(a_text(name, label), one) for label, one in value.items()]
    elif isinstance(value, kind):
        entries = [(None, value)]
    else:
        items = checked_items(name, value, f"{what}, several, or a dict of them", hint)
        entries = [(None, cast("T", one)) for one in items]
    if not entries:
        raise ArgumentError(f"{name}: expected at least one, got none; {hint}")
    for label, one in entries:
        if not isinstance(one, kind):
            where = "" if label is None else f" for {label!r}"
            raise ArgumentError(f"{name}: expected {what}{where}, got {type(one).__name__}; {hint}")
        if label is not None and not label.strip():
            raise ArgumentError(f"{name}: expected labels with letters, got {label!r}; name it")
    labels = [label for label, _ in entries if label is not None]
    for label in labels:
        if labels.count(label) > 1:
            raise ArgumentError(f"{name}: the label {label!r} comes twice; give each its own")
    return entries


def apart(names: list[str]) -> list[str]:
    """The names, with a number where one comes twice."""
    total, seen = Counter(names), Counter[str]()
    found = []
    for name in names:
        seen[name] += 1
        found.append(f"{name} ({seen[name]})" if total[name] > 1 else name)
    return found


def axis_of(views: Sequence[LabelledView]) -> str:
    """What sets views in a row apart most: the light's angle to the view, or its elevation, as the attribute's name.

    A sun that climbs beside the viewer keeps its angle to the view; one that climbs behind or ahead changes both.
    """

    def spread(name: str) -> float:
        values = [getattr(view, name) for view in views if getattr(view, name) is not None]
        return max(values) - min(values) if values else 0.0

    # By more than the rounding of angles: of equal spreads the angle to the view, which warps depend on.
    return "light_elevation" if spread("light_elevation") > spread("light_angle") + SAME_ANGLE else "light_angle"


def light_label(way: np.ndarray | None, light: Light, camera: _core.Camera | None) -> str:
    """What tells a light from others: its elevation, and its angle to the view where there is one camera."""
    kind = "light" if light.kind == "directional" else f"{light.kind} light"
    elevation = elevation_of(way)
    if elevation is None:
        return kind
    angle = None if camera is None else angle_to(way, camera)
    beside = "" if angle is None else f", {degrees(angle)} to the view"
    return f"{kind} {degrees(elevation)} up{beside}"


def degrees(angle: float) -> str:
    """An angle in whole degrees, with a digit where it is small."""
    value = math.degrees(angle)
    return f"{value + 0.0:.0f}°" if abs(value) >= 9.95 or value == round(value) else f"{value:.1f}°"
