"""Where a scene came from, and how to get it again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from .. import _core
from ..text.checked import A_SCENE
from ..travel import Value

#: In `Source.given`: the name of the file's camera that was taken, and that of each of its lights.
NAMED_CAMERA, NAMED_LIGHT = "camera", "light-name"
#: What else may be given beside a camera's name, by the command line's options.
OF_NAMED_CAMERAS = ("fov-deg", "ortho-height", "shift", "near", "far")
UNKNOWN_SCENE = "scene = ...  # the scene of this study"


@dataclass(frozen=True, eq=False)
class Source(Value):
    """Where a scene came from: a name for people, a line of Python, and the command line's arguments, if it has any.

    `out` is the directory that the command line wrote its report to, `given` the vectors as they were given there (a
    camera keeps no target, and a direction not its length) and the names of cameras and lights of the file. `view` says
    where camera and light came from: the name of one of the `default_views`, "own" for those that the scene brings, or
    "" for those that were given.
    """

    name: str
    python: str = UNKNOWN_SCENE
    arguments: tuple[str, ...] = ()
    up: str = "y"
    out: str = ""
    given: tuple[tuple[str, str], ...] = ()
    view: str = ""

    STATE_VERSION: ClassVar[int] = 2

    @classmethod
    def of_scene(cls, scene: _core.Scene) -> Source:
        """What a scene knows of itself: a file as it is, a scene of the library, or only its size."""
        A_SCENE("scene", scene)
        origin, recipe = getattr(scene, "source", ""), getattr(scene, "recipe", "")
        name = Path(origin).name if origin and not origin.startswith("@") else origin.removeprefix("@")
        python = f"scene = {recipe}" if recipe else UNKNOWN_SCENE
        arguments: tuple[str, ...] = ()
        of_library = origin.startswith("@") and recipe.startswith("sl.library.scene(") and recipe.count("(") == 1
        if of_library or (origin and recipe == f"sl.load_scene({origin!r})"):
            arguments = (origin,)
        return cls(name or f"{scene.triangle_count:,} triangles", python, arguments)
