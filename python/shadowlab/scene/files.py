"""Scenes from files: glTF by our own reader, and whatever trimesh loads."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..errors import ArgumentError, LoadError
from ..text import shown
from .axes import Y_UP_FROM_Z_UP, up_axis, up_keyword
from .foreign import Gathered, warn_left_out, warn_notes
from .formats.given import Given
from .formats.limits import Limits
from .gltf.reader import read_gltf
from .scenes import Scene

if TYPE_CHECKING:
    from ..types import Up


def load_scene(path: str | os.PathLike[str], *, up: Up = "y") -> Scene:
    """A scene from glTF (glb, gltf) or any file trimesh loads (ply, obj, stl, off, 3mf...); instances stay instances.

    Parameters
    ----------
    path : path
        The file.
    up : {"y", "z"}
        The file's up axis. "z" turns the scene so that y is up: (x, y, z) becomes (x, z, -y). `Scene.world_from_source`
        keeps the turn; `turned` applies it to the points and directions that belong to the file.

    Raises
    ------
    ArgumentError
        For what is no path.
    LoadError
        The file is missing, of an unknown kind, broken, or holds no mesh.
    SceneError
        No triangle is left, or a face points at a vertex that does not exist.

    Warns
    -----
    ShadowlabWarning
        For what is left out or completed: faces that are not finite, points and lines, cameras without a far plane,
        extensions of glTF that may change geometry, alpha-tested materials.

    References
    ----------
    Khronos Group, "glTF 2.0 Specification", version 2.0.1, 2021; docs/gltf.md has what is read of it.
    """
    up_axis(up)
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentError(f'path: expected the path of a mesh file, got {shown(path)}; try "scene.glb"')
    path = Path(path)
    if not path.exists():
        raise LoadError(f"{path}: expected a mesh file, found nothing there; check the path")
    if path.is_dir():
        raise LoadError(f"{path}: expected a mesh file, found a directory; name a file in it")
    kind = path.suffix.lower().lstrip(".")
    if kind in ("gltf", "glb"):
        return _named(_scene_of(read_gltf(Given.of_file(path, kind, Limits()))), path, up)
    import trimesh

    known = trimesh.available_formats()
    if kind not in known:
        listed = ", ".join(sorted(known))
        raise LoadError(f"{path}: expected a file of a kind that trimesh loads ({listed}), got {kind or 'no ending'!r}")
    try:
        # process=False: no merging, no reordering, so face numbers stay the file's.
        loaded = trimesh.load_scene(str(path), process=False)
    except Exception as e:  # noqa: BLE001 - each of trimesh's loaders raises what its own parser raises
        _broken(path, f"{type(e).__name__}: {e}", e)
    if not loaded.geometry:
        _broken(path, "no geometry in it", None)
    return _named(Scene.from_trimesh(loaded), path, up)


def _scene_of(found: Gathered) -> Scene:
    """The scene of what a reader found, with its warnings."""
    made = Scene(*found.arrays())
    warn_left_out(sum(found.dropped), found.empty, stacklevel=4)
    warn_notes(found.notes, stacklevel=4)
    if found.cameras:
        made.cameras = found.cameras
    if found.lights:
        made.lights = found.lights
    return made


def _named(scene: Scene, path: Path, up: Up) -> Scene:
    """The scene of a file, turned so that y is up, with its source and recipe."""
    if up_axis(up) == 2:
        scene = scene.transformed(Y_UP_FROM_Z_UP)
    scene.source = str(path)
    scene.recipe = f"sl.load_scene({str(path)!r}{up_keyword(up)})"
    return scene


def _broken(path: Path, why: str, cause: Exception | None) -> NoReturn:
    raise LoadError(f"{path}: expected a readable mesh, could not load it ({why}); check the file") from cause
