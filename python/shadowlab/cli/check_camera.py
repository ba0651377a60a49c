"""The camera of an engine in a check, from its view and projection matrices, one pair or one per frame of a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .check_path import FRAME_NUMBER, CameraPath, texts_of_frames
from .config import Table
from .config_view import holder

if TYPE_CHECKING:
    from .._core import Camera

EXAMPLE_CAMERA = '{ view = "view.npy", projection = "projection.npy", convention = "opengl" }'
# What matrices of a camera say themselves.
SAID_BY_MATRICES = ("view", "eye", "target", "fov-deg", "ortho-height", "shift", "near", "far")


@dataclass(frozen=True)
class CameraFiles:
    """Files with the matrices of a camera.

    Attributes
    ----------
    view, projection : str
        Their names, with {frame} where the number of the frame stands.
    convention : str or None
    table : Table
        Where they stand in the configuration.
    """

    view: str
    projection: str
    convention: str | None
    table: Table

    def cameras(self, path: CameraPath | None) -> list[Camera]:
        """The cameras of the frames; one without a path.

        Raises
        ------
        ArgumentError
            For files that cannot be read, and matrices that are no camera, with file and line.
        """
        from .._core import Camera
        from ..conventions.files import read

        count = 1 if path is None else path.frames
        names = [texts_of_frames(name, path) for name in (self.view, self.projection)]
        views, projections = (found * count if len(found) == 1 else found for found in names)
        with self.table.naming(None):
            return [
                Camera.from_matrices(read(Path(view))["matrix"], read(Path(projection))["matrix"], self.convention)
                for view, projection in zip(views, projections, strict=True)
            ]


def camera_of_config(tables: Sequence[Table], path: CameraPath | None) -> CameraFiles | None:
    """The files of the first table that has a camera, where that is a table; None where it is none, or a name.

    Raises
    ------
    ArgumentError
        For keys beside it that the matrices say, and for a path on which it stands still.
    """
    holding = holder(tables, "camera")
    if holding is None or not isinstance(holding.get("camera"), dict):
        return None
    table = holding.table("camera", EXAMPLE_CAMERA)
    assert table is not None
    table.only(("view", "projection", "convention"))
    view, projection = (table.text(key, "the name of a file of a matrix") for key in ("view", "projection"))
    if view is None or projection is None:
        raise table.wrong(None, f"expected view and projection, got one of them; try {EXAMPLE_CAMERA}")
    for key in SAID_BY_MATRICES:
        of_key = holder(tables, key)
        if of_key is not None:
            raise of_key.wrong(key, "expected none beside the matrices of a camera, which say it, got one; remove it")
    if path is not None and (any(path.step) or path.turn):
        raise table.wrong(None, "expected a path without step and turn-deg beside matrices of each frame; remove them")
    if path is not None and FRAME_NUMBER not in view:
        fix = 'write view = "view{frame}.npy"'
        raise table.wrong("view", f"expected {{frame}} in the name beside a path, got {view!r}; {fix}")
    return CameraFiles(view, projection, table.text("convention", "a convention such as opengl"), table)
