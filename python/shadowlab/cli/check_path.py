"""The camera path of a check, and matrices that an engine wrote for each of its frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..techniques.registry import technique_of
from ..text import shown
from .config import Table
from .config_view import holder

if TYPE_CHECKING:
    from .._core import Camera, Parameterization, Scene
    from ..types import Item, Light, Up

# Half an hour of a game, more than a gate may take; each frame is drawn and traced.
MOST_FRAMES = 100_000
EXAMPLE_PATH = "{ frames = 8, step = [0.02, 0, 0], turn-deg = 0.5 }"
# Where the number of a frame stands in the name of a file.
FRAME_NUMBER = "{frame"


@dataclass(frozen=True)
class CameraPath:
    """Frames of a camera that moves and turns by the same amount from each to the next.

    Attributes
    ----------
    frames : int
    step : (float, float, float)
        What it moves by, world units in the axes of the file.
    turn : float
        What it turns by around the axis that points up, radians, to the left where positive.
    """

    frames: int
    step: tuple[float, float, float]
    turn: float

    def cameras(self, camera: Camera, up: Up) -> list[Camera]:
        """The cameras of the frames, the given one first."""
        from ..scene.axes import turned

        step = np.asarray(turned(self.step, up=up))
        found = []
        for i in range(self.frames):
            sine, cosine = math.sin(i * self.turn), math.cos(i * self.turn)
            about_y = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
            moved = camera.replace(eye=camera.eye + i * step) if i and any(self.step) else camera
            found.append(moved.replace(forward=about_y @ camera.forward) if i and self.turn else moved)
        return found


def path_of_config(tables: Sequence[Table]) -> CameraPath | None:
    """The path of the first table that has one; None where none has.

    Raises
    ------
    ArgumentError
        For a path of fewer than two frames, and numbers that are not finite.
    """
    table = holder(tables, "path")
    path = None if table is None else table.table("path", EXAMPLE_PATH)
    if path is None:
        return None
    path.only(("frames", "step", "turn-deg"))
    frames = path.whole("frames", 8, 2)
    if frames > MOST_FRAMES:
        raise path.wrong("frames", f"expected at most {MOST_FRAMES:,}, got {frames:,}; bounds are held at every step")
    step = path.vector("step", "three numbers, what the camera moves by from frame to frame") or (0.0, 0.0, 0.0)
    turn = path.number("turn-deg", "degrees, what the camera turns by from frame to frame") or 0.0
    if not all(map(math.isfinite, (*step, turn))):
        raise path.wrong(None, f"expected finite numbers, got {shown((*step, turn))}")
    return CameraPath(frames, step, math.radians(turn))


def texts_of_frames(text: str, path: CameraPath | None) -> list[str]:
    """The text of a technique, or one for each frame where it has {frame} in it.

    Raises
    ------
    ArgumentError
        For {frame} without a path, or that does not read.
    """
    if FRAME_NUMBER not in text:
        return [text]
    try:
        return [text.format(frame=i) for i in range(1 if path is None else path.frames)]
    except (KeyError, IndexError, ValueError) as error:
        raise ArgumentError(
            f"technique {shown(text)}: expected {{frame}} or {{frame:04}} where the number of the frame stands; {error}"
        ) from error


class MatricesOfFrames:
    """An engine's matrices of each frame of a path, as a technique: the camera says which frame it is.

    Parameters
    ----------
    texts : sequence of str
        `matrix:file=...` of each frame.
    cameras : sequence of Camera
        Those of the frames.
    """

    name = "matrix"
    needs_samples = needs_shadows = False

    def __init__(self, texts: Sequence[str], cameras: Sequence[Camera]):
        self.items = [technique_of(text) for text in texts]
        self.cameras = list(cameras)
        self.settings: dict[str, Any] = {"frames": len(self.items)}

    def parameterize(
        self, scene: Scene, camera: Camera, light: Light, *, resolution: int = 1024, samples: object = None
    ) -> Parameterization:
        """The matrices of the frame whose camera this is."""
        from ..techniques.kinds import is_parameterization

        item = self.items[self.cameras.index(camera)]
        return item if is_parameterization(item) else item.parameterize(scene, camera, light, resolution=resolution)


def item_of_frames(text: str, cameras: Sequence[Camera], path: CameraPath | None) -> Item:
    """The technique or matrices of a text; of a text with {frame} the matrices of all frames."""
    texts = texts_of_frames(text, path)
    return technique_of(text) if texts == [text] else MatricesOfFrames(texts, cameras)
