"""Scenes from files of any kind that can be loaded, from their bytes, and from archives of them."""

from __future__ import annotations

import os
from dataclasses import fields
from typing import TYPE_CHECKING, BinaryIO, TextIO

import numpy as np
from numpy.typing import NDArray

from ..errors import ArgumentError, LoadError, SceneError, ShadowlabError
from ..text import shown
from ..text.progress import steps_of_wait
from .axes import Y_UP_FROM_X_UP, Y_UP_FROM_Z_UP, up_axis
from .formats.archives import ARCHIVES, PACKED
from .formats.limits import Limits
from .formats.readers import READERS, gathered_file, kinds
from .formats.sources import given_source
from .formats.units import metres_per_unit
from .scenes import Scene

if TYPE_CHECKING:
    from ..types import Up
    from .gathered import Gathered


def load_scene(
    source: str | os.PathLike[str] | bytes | bytearray | memoryview | BinaryIO | TextIO,
    *,
    up: Up | None = None,
    unit: float | str | None = None,
    kind: str | None = None,
    limits: Limits = Limits(),  # noqa: B008 - immutable
) -> Scene:
    """A scene from a file: glb, gltf, ply, obj, stl, off, 3mf, dae and what else trimesh loads, or an archive of them.

    Instances stay instances. Polygons become triangles, concave ones by ear clipping. Files are taken as coming from
    anybody: only files in the given one's folder are read, nothing is written, and `limits` bounds what is read.

    Parameters
    ----------
    source : path, bytes, or open file
        The file; or its bytes, as `bytes`, `bytearray` or `memoryview`, with `kind`; or a binary or text file that is
        open, which is read from where it stands and is known by `kind` or by the ending of its `name`. Archives are
        zip, tar, tar.gz, tgz and tar.bz2; all meshes in one become one scene. A file.obj.gz or .obj.bz2 is one mesh.
    up : {"y", "z"}, optional
        The file's up axis. "z" turns the scene so that y is up: (x, y, z) becomes (x, z, -y). `Scene.world_from_source`
        keeps the turn; `turned` applies it to the points and directions that belong to the file. Where it is not
        given, a COLLADA file's own axis counts, and "y" for others.
    unit : float or str, optional
        Metres per unit of the file, or "mm", "cm", "m", "km", "in", "ft", "um", or the names of 3MF; the scene is in
        metres then. Where it is not given, the unit that a COLLADA or 3MF file states counts (millimetres in a 3MF
        file without one), and other files are not scaled. ``unit=1`` scales nothing.
    kind : str, optional
        The ending that says how to read the file, such as "obj"; that of the path or name where it is not given.
    limits : Limits
        What is read at most.

    Returns
    -------
    Scene
        With `taken`, the axis and unit that it was loaded with where a file or an argument said them.

    Raises
    ------
    ArgumentError
        For what is no source, a closed file, another `up`, `unit` or `kind`, and bytes without a kind.
    LoadError
        The file is missing, of an unknown kind, broken, beyond a limit, refers outside its folder, or holds no mesh.
    SceneError
        No triangle is left, or a face points at a vertex that does not exist.

    Warns
    -----
    ShadowlabWarning
        For what is left out: faces without three distinct or finite vertices, lines and points, curves and surfaces,
        items that are not to be printed, files of an archive that cannot be read, blended materials,
        extensions of glTF that may change geometry. For cameras without an aspect ratio, which get one.

    References
    ----------
    docs/gltf.md has what is read of glTF.
    """
    if up is not None:
        up_axis(up)
    metres = metres_per_unit(unit)
    ending = _ending(kind)
    if not isinstance(limits, Limits):
        raise ArgumentError(f"limits: expected sl.Limits, got {shown(limits)}; try limits=sl.Limits(size=10**9)")
    given = given_source(source, ending, limits)
    with steps_of_wait(2) as step:
        step("reading")
        found = gathered_file(given)
        step("making the scene")
        try:
            scene = Scene(*found.arrays())._with(found.cameras, found.lights)
        except SceneError as e:
            raise SceneError(f"{given.name}: {e}") from e
        except ArgumentError as e:
            raise LoadError(
                f"{given.name}: expected a mesh that can be drawn, got another ({e}); check the file"
            ) from e
        scene = _in_metres(given.name, scene, found, up, metres)
    found.warn(stacklevel=3)
    if isinstance(source, (str, os.PathLike)):
        scene.source = given.name
        scene.recipe = f"sl.load_scene({given.name!r}{_keywords(up, unit, kind, limits)})"
    else:
        scene.source = getattr(source, "name", "") if isinstance(getattr(source, "name", ""), str) else ""
        scene.recipe = ""
    return scene


def _ending(kind: object) -> str | None:
    if kind is None:
        return None
    ending = kind.lower().lstrip(".") if isinstance(kind, str) else ""
    if ending in READERS or ending in ARCHIVES or ending in PACKED or ending in kinds():
        return ending
    raise ArgumentError(
        f"kind: expected the ending of a file that can be loaded ({', '.join(kinds())}), got {shown(kind)}"
    )


def _in_metres(name: str, scene: Scene, found: Gathered, up: Up | None, metres: float | None) -> Scene:
    """The scene with y up and in metres, as far as the file or the arguments say what it was in."""
    axis = up or found.up or "y"
    matrix: NDArray[np.float64] = {"x": Y_UP_FROM_X_UP, "y": np.eye(4), "z": Y_UP_FROM_Z_UP}[axis].copy()
    scale = found.unit if metres is None else metres
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise LoadError(f"{name}: expected a unit of finite metres above 0, got {scale:g}; unit=... says another")
    matrix[:3] *= 1.0 if scale is None else scale
    if not np.array_equal(matrix, np.eye(4)):
        try:
            scene = scene.transformed(matrix)
        except ShadowlabError as e:
            raise LoadError(f"{name}: expected a scene that can be scaled by {scale:g} m per unit ({e})") from e
    said = [f"{axis} up"] if up or found.up else []
    said += [f"{scale:g} m per unit"] if scale is not None else []
    scene.taken = ", ".join(said)
    return scene


def _keywords(up: Up | None, unit: float | str | None, kind: str | None, limits: Limits) -> str:
    """The keywords of a recipe, without those that were not given."""
    plain = Limits()
    changed = {one.name: getattr(limits, one.name) for one in fields(limits)}
    own = ", ".join(f"{key}={value!r}" for key, value in changed.items() if value != getattr(plain, key))
    words = [f", {key}={value!r}" for key, value in (("up", up), ("unit", unit), ("kind", kind)) if value is not None]
    return "".join([*words, f", limits=sl.Limits({own})" if own else ""])
