"""The views of a sweep: scenes, cameras and lights from the values of its rows, each made once."""

from __future__ import annotations

import os
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, cast

from ... import _core
from ...errors import ArgumentError, UnknownNameError
from ...scene import library
from ...scene.default_view import WIDE_ASPECT, default_views
from ...scene.files import load_scene
from ...scene.light_way import light_way
from ...scene.scenes import Scene
from ...scene.source import Source
from ...scene.view import View
from ...text import parse_vector, shown
from ...text.checked import one_or_more_lights
from ...text.checks import VIEWS, check_camera, check_scene, picture_of
from ...text.specs import LONGEST_PICTURE
from ..views import LabelledView, apart, light_label
from .space import Named, RawRow, is_direction

if TYPE_CHECKING:
    from ...types import Light, Size

T = TypeVar("T")

#: The camera or the light that a scene of the library brings.
OWN = "own"


def views_of_rows(rows: Iterable[RawRow], size: Size | None) -> tuple[list[LabelledView], list[str], list[int]]:
    """The views of all rows, the labels of their scenes, and which of them each row is in.

    Raises
    ------
    ArgumentError, UnknownNameError, LoadError
        For scenes, cameras and lights that are none.
    """
    makers = _Makers(size)
    places: dict[tuple[int, Hashable, Hashable], int] = {}
    of_rows: list[int] = []
    parts: list[tuple[int, tuple[str, _core.Camera], tuple[str, Light | tuple[Light, ...]]]] = []
    for row in rows:
        scene = makers.scene(row["scene"])
        camera = makers.camera(scene, row.get("camera"))
        light = makers.light(scene, row.get("light"), camera[0])
        # A label is of what it names: the same camera under two names is two views.
        key = (scene, camera, light)
        if key not in places:
            places[key] = len(parts)
            parts.append(key)
        of_rows.append(places[key])
    return *makers.views(parts), of_rows


class _Makers:
    """What makes scenes, cameras and lights of values, each once."""

    def __init__(self, size: Size | None):
        # Only a size that is left out depends on the camera.
        self.size = None if size is None else picture_of(size, cast("_core.Camera", None))
        if self.size is not None and max(self.size) > LONGEST_PICTURE:
            raise ArgumentError(
                f"size: expected at most {LONGEST_PICTURE} pixels a side, got {shown(size)}; no run could be drawn"
            )
        self.scenes: list[Scene] = []
        self.labels: list[str | None] = []
        self._places: dict[Hashable, int] = {}
        self._chosen: dict[int, Mapping[str, View]] = {}

    def scene(self, named: Named) -> int:
        """The place of a scene among all."""
        value = named.value
        if not isinstance(value, (_core.Scene, str, os.PathLike)):
            check_scene(value)
        text = None if isinstance(value, _core.Scene) else os.fspath(cast("str", value))
        key = (text or id(value), named.label)
        if key not in self._places:
            made = cast("Scene", value) if text is None else scene_of_text(text)
            self._places[key] = len(self.scenes)
            self.scenes.append(made)
            self.labels.append(named.label)
        return self._places[key]

    def camera(self, place: int, named: Named | None) -> tuple[str, _core.Camera]:
        """A camera and its label; empty where it has none."""
        value = self._default(place) if named is None else named.value
        if isinstance(value, _core.Camera):
            return ("" if named is None else named.label or ""), value
        if not isinstance(value, str):
            check_camera(value)
        name = cast("str", value)
        of_scene = getattr(self.scenes[place], "cameras", {})
        found = self._named("camera", place, name, of_scene)
        label = "" if named is None else named.label or ""
        return label or name, found.camera if isinstance(found, View) else found

    def light(self, place: int, named: Named | None, camera: str) -> tuple[str, Light | tuple[Light, ...]]:
        """A light or several, and the label; empty where it has none."""
        # The light that goes with a chosen camera.
        value = named.value if named is not None else camera if camera in VIEWS else self._default(place)
        label = "" if named is None else named.label or ""
        if is_direction(value):
            return label, _core.DirectionalLight(cast("Any", value))
        if not isinstance(value, str):
            return label, one_or_more_lights("light", value)
        lights = getattr(self.scenes[place], "lights", {})
        if value not in lights and value not in (OWN, *VIEWS) and "," in value:
            return label or value, _core.DirectionalLight(parse_vector(value, "light"))
        found = self._named("light", place, value, lights)
        return label or value, found.light if isinstance(found, View) else found

    def views(
        self, parts: list[tuple[int, tuple[str, _core.Camera], tuple[str, Light | tuple[Light, ...]]]]
    ) -> tuple[list[LabelledView], list[str]]:
        """The views with labels that tell them apart, and the labels of their scenes."""
        scenes = apart([label or name_in_table(scene) for label, scene in zip(self.labels, self.scenes, strict=True)])
        cameras = [(scene, camera) for scene, camera, _ in parts]
        lights = [(scene, light) for scene, _, light in parts]
        bare_cameras = list(dict.fromkeys(camera for _, camera in cameras if not camera[0]))
        alone = len(set(cameras)) == 1
        of_camera = labels_in_scenes(
            cameras, ["camera" if alone else f"camera {i + 1}" for i in range(len(bare_cameras))]
        )
        first = {light: scene for scene, light in reversed(lights) if not light[0]}
        bare_lights = dict.fromkeys(light for _, light in lights if not light[0])
        of_light = labels_in_scenes(lights, [self._light_label(first[light], light[1]) for light in bare_lights])
        found, labels = [], []
        for scene, camera, light in parts:
            names = of_camera[scene, camera], of_light[scene, light]
            label = ", ".join(dict.fromkeys(names))
            view = View(self.scenes[scene], camera[1], light[1], picture_of(self.size, camera[1]), label)
            found.append(LabelledView(view, *names))
            labels.append(scenes[scene])
        return found, labels

    def _light_label(self, place: int, light: Light | tuple[Light, ...]) -> str:
        """What a light without a label is called."""
        if isinstance(light, tuple):
            return f"{len(light)} lights"
        return light_label(light_way(self.scenes[place], light), light, None)

    def _default(self, place: int) -> str:
        return OWN if isinstance(self.scenes[place], library.LibraryScene) else VIEWS[0]

    def _named(self, what: str, place: int, name: str, of_scene: Mapping[str, Any]) -> Any:
        """What a scene calls so, what it brings from the library, or the view that is chosen for it."""
        scene = self.scenes[place]
        if name in of_scene:
            return of_scene[name]
        if name == OWN and isinstance(scene, library.LibraryScene):
            return getattr(scene, what)
        if name in VIEWS:
            return self._chosen_views(place)[name]
        own = [OWN] if isinstance(scene, library.LibraryScene) else []
        listed = ", ".join([*of_scene, *own, *VIEWS])
        raise UnknownNameError(
            f"{what}: unknown {what} {shown(name)} of {Source.of_scene(scene).name}; expected one of {listed}"
        )

    def _chosen_views(self, place: int) -> Mapping[str, View]:
        if place not in self._chosen:
            aspect = WIDE_ASPECT if self.size is None else self.size[0] / self.size[1]
            self._chosen[place] = {view.label: view for view in default_views(self.scenes[place], aspect=aspect)}
        return self._chosen[place]


def name_in_table(scene: Scene) -> str:
    """What a scene is called; letters of file names that no text has are written out."""
    return Source.of_scene(scene).name.encode("utf-8", "backslashreplace").decode()


def labels_in_scenes(
    values: Sequence[tuple[int, tuple[str, T]]], of_bare: Sequence[str]
) -> dict[tuple[int, tuple[str, T]], str]:
    """A label of each (scene, (label or empty, value)), no two the same in a scene.

    Values without a label get those of `of_bare`, in their order, in all scenes alike.
    """
    bare = dict(zip(dict.fromkeys(one for _, one in values if not one[0]), apart(list(of_bare)), strict=True))
    found: dict[tuple[int, tuple[str, T]], str] = {}
    of_scenes: dict[int, list[tuple[str, T]]] = {}
    for scene, one in dict.fromkeys(values):
        of_scenes.setdefault(scene, []).append(one)
    for scene, here in of_scenes.items():
        names = apart([one[0] or bare[one] for one in here])
        found |= {(scene, one): name for one, name in zip(here, names, strict=True)}
    return found


def scene_of_text(text: str) -> Scene:
    """The scene of the library, "@name:parameter=value", or the file.

    Raises
    ------
    ArgumentError, UnknownNameError, LoadError
        As `sl.library.scene` and `sl.load_scene`.
    """
    if text.startswith("@"):
        return library.scene_of_spec(text)
    return load_scene(text)
