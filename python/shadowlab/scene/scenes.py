"""Scenes: meshes and instances, from any file trimesh loads, from trimesh objects or from arrays."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import numpy.typing as npt

from .. import _core
from ..checks import UP_AXES
from ..errors import ArgumentError, LoadError, SceneError, ShadowlabWarning
from ..text import shown

if TYPE_CHECKING:
    import trimesh

    from ..types import Up


#: Turns z-up coordinates (x, y, z) into y-up ones (x, z, -y): a rotation, so handedness stays.
_Y_UP_FROM_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])

#: Full side of the default ground in largest extents of the scene: so wide that no ordinary view sees its edge.
_GROUND_SIDE = 12.0


_AS_GIVEN = np.eye(4)
_AS_GIVEN.flags.writeable = False  # shared by all scenes that were not turned


class Scene(_core.Scene):
    """Meshes and their instances. Immutable.

    Make one with `load_scene`, `Scene.from_trimesh`, `Scene.from_arrays` or `library.scene`.

    Attributes
    ----------
    source : str
        Where it came from: a path, "@name" of a library scene, or "" for arrays.
    world_from_source : (4, 4) float64
        How the source's coordinates were turned; the identity unless it was loaded with ``up="z"``.
    recipe : str
        The Python that makes it again (``sl`` is shadowlab), or "" where arrays went into it.
    """

    source: str = ""
    recipe: str = ""
    world_from_source: npt.NDArray[np.float64] = _AS_GIVEN

    @classmethod
    def from_arrays(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Scene:
        """A scene of one mesh.

        Parameters
        ----------
        vertices : (N, 3) array_like of float
            Positions, world units. Faces with a vertex that is not finite are dropped and counted in a warning.
        faces : (M, 3) array_like of int
            Rows of `vertices`.

        Raises
        ------
        ArgumentError
            For another shape or type.
        SceneError
            For an index out of range, or where no triangle is left.
        """
        mesh = _core.Mesh(vertices, faces)
        _warn_dropped(mesh.dropped_faces, [])
        return cls([mesh], [0], np.eye(4)[None])

    @classmethod
    def from_trimesh(cls, source: trimesh.Trimesh | trimesh.Scene) -> Scene:
        """A scene from a trimesh mesh or scene graph; geometry that nodes share stays shared.

        Parameters
        ----------
        source : trimesh.Trimesh or trimesh.Scene

        Raises
        ------
        ArgumentError
            For anything else.
        SceneError
            Where no triangle is left, or for an index out of range.
        """
        import trimesh

        if isinstance(source, trimesh.Trimesh):
            return cls.from_arrays(source.vertices, source.faces)
        if not isinstance(source, trimesh.Scene):
            raise ArgumentError(
                f"source: expected a trimesh.Trimesh or trimesh.Scene, got {type(source).__name__}; "
                "load it with trimesh, or use Scene.from_arrays"
            )
        meshes: dict[str, _core.Mesh] = {}
        left_out: list[str] = []
        dropped = 0
        for name, geometry in source.geometry.items():
            if not isinstance(geometry, trimesh.Trimesh):
                left_out.append(f"{name} ({type(geometry).__name__})")
                continue
            finite = np.isfinite(np.asarray(geometry.vertices)).all(axis=1)
            inside = _indices_in_range(geometry)
            if inside and not finite[np.asarray(geometry.faces)].all(axis=1).any():
                left_out.append(f"{name} (no usable triangle)")
                dropped += len(geometry.faces)
                continue
            meshes[name] = _core.Mesh(geometry.vertices, geometry.faces)
            dropped += meshes[name].dropped_faces
        order = {name: i for i, name in enumerate(meshes)}
        index: list[int] = []
        transforms: list[npt.NDArray[np.float64]] = []
        for node in source.graph.nodes_geometry:
            transform, name = source.graph.get(node)
            if name in order:
                index.append(order[name])
                transforms.append(transform)
        _warn_dropped(dropped, left_out)
        if not index:
            what = f"left out: {', '.join(left_out)}" if left_out else "the scene graph places no mesh"
            raise SceneError(
                f"the scene has no usable triangle: {what}; give at least one triangle with finite vertices"
            )
        return cls(list(meshes.values()), index, np.asarray(transforms, dtype=np.float64))

    def with_ground(self, height: float | None = None, size: float | None = None, *, up: Up = "y") -> Scene:
        """The scene with a square horizontal floor under it.

        Parameters
        ----------
        height : float, optional
            Position along the up axis; the lowest point of the scene where none is given.
        size : float, optional
            Full side; 12 times the largest extent of the scene where none is given.
        up : {"y", "z"}
            The scene's up axis.

        Raises
        ------
        ArgumentError
            For a height that is not finite or a size that is not above 0.
        """
        low, high = self.bounds
        axis = _up_axis(up)
        extent = float((high - low).max())
        height = float(low[axis]) if height is None else float(height)
        # A single point has no extent; any floor will do.
        size = _GROUND_SIDE * (extent or 1.0) if size is None else float(size)
        if not np.isfinite(height):
            raise ArgumentError(f"height: expected a finite number, got {height}; give the floor's position")
        if not (np.isfinite(size) and size > 0):
            raise ArgumentError(f"size: expected a finite length above 0, got {size}; give the floor's full side")
        across = [i for i in range(3) if i != axis]
        corners = np.zeros((4, 3))
        corners[:, axis] = height
        corners[:, across] = ((low + high) / 2)[across] + size / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        # Counter-clockwise as seen from above.
        faces = [[0, 2, 1], [0, 3, 2]] if axis == 1 else [[0, 1, 2], [0, 2, 3]]
        grounded = self + Scene.from_arrays(corners, faces)
        if self.recipe:
            grounded.recipe = f"{self.recipe}.with_ground({height!r}, {size!r}{_up_keyword(up)})"
        return grounded

    def transformed(self, matrix: npt.ArrayLike) -> Scene:
        """The scene moved by an affine map.

        Parameters
        ----------
        matrix : (4, 4) array_like
            Acts on column vectors; the last row is 0, 0, 0, 1.
        """
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape != (4, 4):
            raise ArgumentError(f"matrix: expected shape (4, 4), got {m.shape}; give one affine map")
        moved = type(self)._assemble(self.meshes, self.mesh_index, m @ self.transforms)
        moved.source, moved.world_from_source = self.source, m @ self.world_from_source
        moved.recipe = f"{self.recipe}.transformed({m.tolist()})" if self.recipe else ""
        return moved

    def __add__(self, other: object) -> Scene:
        if not isinstance(other, _core.Scene):
            return NotImplemented
        index = np.concatenate([self.mesh_index, other.mesh_index + self.mesh_count])
        transforms = np.concatenate([self.transforms, other.transforms])
        joined = Scene._assemble(self.meshes + other.meshes, index, transforms)
        joined.source, joined.world_from_source = self.source, self.world_from_source
        recipes = self.recipe, getattr(other, "recipe", "")
        joined.recipe = f"({recipes[0]} + {recipes[1]})" if all(recipes) else ""
        return joined

    @staticmethod
    def _assemble(meshes: Sequence[_core.Mesh], index: npt.ArrayLike, transforms: npt.ArrayLike) -> Scene:
        return Scene(meshes, index, transforms)

    def __repr__(self) -> str:
        (x0, y0, z0), (x1, y1, z1) = self.bounds
        name = f"{self.source!r}, " if self.source else ""
        return (
            f"Scene({name}{self.triangle_count:,} triangles, {self.instance_count:,} instances of {self.mesh_count:,} "
            f"meshes, bounds ({x0:.6g}, {y0:.6g}, {z0:.6g}) to ({x1:.6g}, {y1:.6g}, {z1:.6g}))"
        )

    def _repr_html_(self) -> str:
        from html import escape

        low, high = ([f"{v:.6g}" for v in corner] for corner in self.bounds)
        rows = [
            ("source", escape(self.source) or "arrays"),
            ("triangles", f"{self.triangle_count:,}"),
            ("instances", f"{self.instance_count:,} of {self.mesh_count:,} meshes"),
            ("bounds", f"({', '.join(low)}) to ({', '.join(high)})"),
        ]
        body = "".join(f"<tr><th style='text-align:left'>{k}</th><td>{v}</td></tr>" for k, v in rows)
        return f"<table>{body}</table>"


def load_scene(path: str | os.PathLike[str], *, up: Up = "y") -> Scene:
    """A scene from any file trimesh loads (glb, gltf, ply, obj, stl, off, 3mf...); instances stay instances.

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
    """
    axis = _up_axis(up)
    if not isinstance(path, (str, os.PathLike)):
        raise ArgumentError(f'path: expected the path of a mesh file, got {shown(path)}; try "scene.glb"')
    path = Path(path)
    if not path.exists():
        raise LoadError(f"{path}: expected a mesh file, found nothing there; check the path")
    if path.is_dir():
        raise LoadError(f"{path}: expected a mesh file, found a directory; name a file in it")
    import trimesh

    known = trimesh.available_formats()
    kind = path.suffix.lower().lstrip(".")
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
    scene = Scene.from_trimesh(loaded)
    if axis == 2:
        scene = scene.transformed(_Y_UP_FROM_Z_UP)
    scene.source = str(path)
    scene.recipe = f"sl.load_scene({str(path)!r}{_up_keyword(up)})"
    return scene


def turned(vectors: npt.ArrayLike, *, up: Up) -> npt.NDArray[np.float64]:
    """Points or directions of a file with this up axis, in the y-up coordinates of the loaded scene.

    Parameters
    ----------
    vectors : (..., 3) array_like
    up : {"y", "z"}
        The file's up axis, as given to `load_scene`.
    """
    v = np.array(vectors, dtype=np.float64)
    return np.einsum("ij,...j->...i", _Y_UP_FROM_Z_UP[:3, :3], v) if _up_axis(up) == 2 else v


def _up_axis(up: str) -> int:
    if up not in UP_AXES:
        raise ArgumentError(f"up: expected 'y' or 'z', got {up!r}; name the axis that points up")
    return 1 if up == "y" else 2


def _up_keyword(up: Up) -> str:
    return f", up={up!r}" if up != "y" else ""


def _indices_in_range(geometry: trimesh.Trimesh) -> bool:
    faces = np.asarray(geometry.faces)
    return faces.size == 0 or (faces.min() >= 0 and faces.max() < len(geometry.vertices))


def _warn_dropped(faces: int, left_out: list[str]) -> None:
    parts = []
    if faces:
        parts.append(f"{faces} face{'s' if faces > 1 else ''} with vertices that are not finite")
    if left_out:
        shown = ", ".join(left_out[:5]) + (", ..." if len(left_out) > 5 else "")
        parts.append(f"{len(left_out)} geometr{'ies' if len(left_out) > 1 else 'y'} without triangles: {shown}")
    if parts:
        warnings.warn(f"left out: {' and '.join(parts)}", ShadowlabWarning, stacklevel=3)


def _broken(path: Path, why: str, cause: Exception | None) -> NoReturn:
    raise LoadError(f"{path}: expected a readable mesh, could not load it ({why}); check the file") from cause
