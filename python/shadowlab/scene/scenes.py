"""Scenes: meshes and instances, from any file trimesh loads, from trimesh objects or from arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from .. import _core
from ..errors import ArgumentError, ShadowlabError
from ..text import shown
from ..text.arrays import checked_array
from ..text.checked import a_length, a_number
from ..travel import check_version, checksum, damaged
from .alpha_test import AlphaTest
from .axes import up_axis, up_keyword
from .foreign import gathered, to_trimesh
from .foreign_views import cameras_of, lights_of
from .gathered import warn_left_out, warn_notes
from .placed import moved_camera, moved_light, unique

if TYPE_CHECKING:
    import trimesh
    from typing_extensions import Self

    from ..types import Light, Up


#: Full side of the default ground in largest extents of the scene: so wide that no ordinary view sees its edge.
_GROUND_SIDE = 12.0


#: No cameras or lights. Shared by all scenes without, so it cannot be written to.
NONE: Mapping[str, Any] = MappingProxyType({})

#: Of what is pickled.
STATE_VERSION = 1

#: Instances that are moved between two looks at whether to go on.
_INSTANCES_AT_ONCE = 1 << 17

#: A recipe is there to be read and run: it names this many matrices of one move, and has this many characters.
_RECIPE_MATRICES, _RECIPE_LENGTH = 8, 4000

T = TypeVar("T")

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
        How the source's coordinates were turned and scaled; the identity unless a file or `load_scene` said so.
    taken : str
        The up axis and the unit that a file was taken to have, such as "z up, 0.01 m per unit"; "" where neither the
        file nor an argument said any.
    recipe : str
        The Python that makes it again (``sl`` is shadowlab), or "" where arrays went into it.
    cameras, lights : mapping of str to Camera, and to DirectionalLight, SpotLight or PointLight
        Those that the source brought, by name.

    Notes
    -----
    Scenes are equal where their content is: `==`, `hash` and `content_hash` look at meshes and instances alone. The
    attributes above do not count, but pickles and copies carry them.
    """

    source: str = ""
    recipe: str = ""
    taken: str = ""
    world_from_source: npt.NDArray[np.float64] = _AS_GIVEN
    cameras: Mapping[str, _core.Camera] = NONE
    lights: Mapping[str, Light] = NONE

    @classmethod
    def from_arrays(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike, *, alpha: AlphaTest | None = None) -> Scene:
        """A scene of one mesh.

        Parameters
        ----------
        vertices : (N, 3) array_like of float
            Positions, world units. Faces with a vertex that is not finite are dropped and counted in a warning.
        faces : (M, 3) array_like of int
            Rows of `vertices`.
        alpha : AlphaTest, optional
            Which points of the triangles exist, with texture coordinates for each of `vertices`; all, by default.

        Raises
        ------
        ArgumentError
            For another shape or type.
        SceneError
            For an index out of range, or where no triangle is left.
        """
        mesh = _core.Mesh(vertices, faces, alpha=alpha)
        warn_left_out(mesh.dropped_faces, [], stacklevel=3)
        return cls([mesh], [0], np.eye(4)[None])

    @classmethod
    def from_trimesh(cls, source: Any) -> Scene:
        """A scene from another program's: trimesh, pyrender, or anything with vertices and faces.

        Geometry that nodes share stays shared. Coordinates are taken as they are, in the other program's unit and in
        its world, which is right-handed in both. Objects are known by their attributes; no program is imported.

        Parameters
        ----------
        source : trimesh.Trimesh, trimesh.Scene, pyrender.Mesh, pyrender.Scene, or object with `vertices` and `faces`
            Perspective cameras and lights of a pyrender scene, and the camera that was set in a trimesh scene, become
            `cameras` and `lights`. Materials whose ``alphaMode`` is ``"MASK"`` become alpha tests. The cone of a spot
            is twice its `outerConeAngle`; a light without a range gets one that reaches the whole scene.

        Raises
        ------
        ArgumentError
            For anything else.
        SceneError
            Where no triangle is left, or for an index out of range.

        Warns
        -----
        ShadowlabWarning
            For what is left out: faces that are not finite, alpha tests without texture coordinates, points and lines,
            cameras and lights in mirrored or sheared frames. For a camera without an aspect ratio, which gets one.

        Examples
        --------
        >>> import shadowlab as sl, trimesh
        >>> sl.Scene.from_trimesh(trimesh.creation.box((1, 2, 3))).triangle_count
        12
        """
        found = gathered(source)
        made = cls(*found.arrays())
        cameras, notes = cameras_of(source)
        lights, others = lights_of(source, made.bounds)
        warn_notes(notes + others, stacklevel=3)
        return made._with(cameras, lights)

    def to_trimesh(self) -> trimesh.Scene:
        """The scene as a `trimesh.Scene`, with one geometry per mesh and one node per instance.

        Returns
        -------
        trimesh.Scene
            In the same coordinates. `from_trimesh` makes an equal scene of it, unless faces had been dropped, whose
            rows are not kept. To that end vertices carry their stored form (`vertex_attributes`), which counts as long
            as it agrees with `vertices`. Cameras, lights and alpha tests stay here.

        Warns
        -----
        ShadowlabWarning
            Where meshes have alpha tests, which are left out.

        Examples
        --------
        >>> import shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> sl.Scene.from_trimesh(scene.to_trimesh()) == scene
        True
        """
        return to_trimesh(self)

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
        axis = up_axis(up)
        extent = float((high - low).max())
        height = float(low[axis]) if height is None else a_number("height", height)
        # A single point has no extent; any floor will do.
        size = _GROUND_SIDE * (extent or 1.0) if size is None else a_length("size", size)
        across = [i for i in range(3) if i != axis]
        corners = np.zeros((4, 3))
        corners[:, axis] = height
        corners[:, across] = ((low + high) / 2)[across] + size / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        # Counter-clockwise as seen from above.
        faces = [[0, 2, 1], [0, 3, 2]] if axis == 1 else [[0, 1, 2], [0, 2, 3]]
        try:
            grounded = self + Scene.from_arrays(corners, faces)
        except ShadowlabError as error:
            raise ArgumentError(
                f"height, size: expected a floor that fits beside the scene, got {height:g} and {size:g} ({error}); "
                "leave them out for one that does"
            ) from error
        if self.recipe:
            grounded.recipe = f"{self.recipe}.with_ground({height!r}, {size!r}{up_keyword(up)})"
        return grounded

    def transformed(self, matrix: npt.ArrayLike) -> Scene:
        """The scene moved by an affine map.

        Parameters
        ----------
        matrix : (4, 4) array_like
            Acts on column vectors; the last row is 0, 0, 0, 1. `cameras` and `lights` move with the scene.

        Warns
        -----
        ShadowlabWarning
            For cameras and placed lights where the map mirrors, shears or scales unevenly: they are left out.
        """
        m: npt.NDArray[np.float64] = checked_array("matrix", matrix, shape=(4, 4))
        if not np.isfinite(m).all() or m[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
            raise ArgumentError(f"matrix: expected a finite affine map, last row 0, 0, 0, 1, got {shown(m.tolist())}")
        transforms = self.transforms
        for first in range(0, len(transforms), _INSTANCES_AT_ONCE):
            transforms[first : first + _INSTANCES_AT_ONCE] = m @ transforms[first : first + _INSTANCES_AT_ONCE]
        moved = Scene(self.meshes, self.mesh_index, transforms)
        moved.source, moved.taken = self.source, self.taken
        moved.world_from_source = m @ self.world_from_source
        moved.recipe = f"{self.recipe}.transformed({m.tolist()})" if self.recipe else ""
        left_out: list[str] = []
        cameras = _moved("camera", self.cameras, moved_camera, m, left_out)
        lights = _moved("light", self.lights, moved_light, m, left_out)
        warn_notes(left_out, stacklevel=3)
        return moved._with(cameras, lights)

    def with_transforms(self, indices: npt.ArrayLike, matrices: npt.ArrayLike) -> Self:
        """The scene with some of its instances in other places.

        Geometry is shared, not copied: meshes, alpha tests, what renderers hold of them on a device, and the ray
        tracer's hierarchies of meshes. The hierarchy over the instances is refitted, or built anew where refitting
        would make it slow. Maps and masks are those of a scene made anew, bit for bit; truths too, but for a few pixels
        of scenes a hundred or more times as large as what is seen, which one of the two calls undecided.

        Parameters
        ----------
        indices : (K,) array_like of int
            Which instances, each once: rows of `transforms`, from 0. The others stay.
        matrices : (K, 4, 4) array_like of float
            World from mesh, one for each of them: what `transforms` then holds. Affine maps that act on column vectors,
            last row 0, 0, 0, 1; a scene takes maps that mirror, shear or flatten, too.

        Returns
        -------
        Scene
            Of the same class. `source`, `cameras`, `lights` and the other attributes stay as they are. `recipe` names
            the move where few instances move, and is "" otherwise.

        Raises
        ------
        ArgumentError
            For another shape or type, an index out of range or given twice, and a matrix that is not affine and finite
            or takes the scene out of the range of 64-bit floats.

        Examples
        --------
        >>> import numpy as np, shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> step = scene.transforms[[3]]
        >>> step[0, :3, 3] += (0.1, 0.0, 0.0)
        >>> moved = scene.with_transforms([3], step)
        >>> moved == scene, moved.with_transforms([3], scene.transforms[[3]]) == scene
        (False, True)
        """
        index: npt.NDArray[np.int64] = checked_array("indices", indices, np.int64, (None,))
        if isinstance(matrices, (list, tuple)) and not matrices:
            matrices = np.empty((0, 4, 4))
        places: npt.NDArray[np.float64] = checked_array("matrices", matrices, shape=(None, 4, 4))
        made = type(self).__new__(type(self), super().with_transforms(index, places))
        made.__dict__.update(self.__dict__)
        if self.recipe:
            few = len(index) <= _RECIPE_MATRICES
            recipe = f"{self.recipe}.with_transforms({index.tolist()}, {places.tolist()})" if few else ""
            made.recipe = recipe if len(recipe) <= _RECIPE_LENGTH else ""
        return made

    def __add__(self, other: object) -> Scene:
        if not isinstance(other, _core.Scene):
            return NotImplemented
        joined = Scene.__new__(Scene, super().__add__(other))
        joined.source, joined.taken, joined.world_from_source = self.source, self.taken, self.world_from_source
        recipes = self.recipe, getattr(other, "recipe", "")
        joined.recipe = f"({recipes[0]} + {recipes[1]})" if all(recipes) else ""
        cameras = _joined(self.cameras, getattr(other, "cameras", NONE))
        return joined._with(cameras, _joined(self.lights, getattr(other, "lights", NONE)))

    def _with(self, cameras: Mapping[str, _core.Camera], lights: Mapping[str, Light]) -> Scene:
        """The same object with cameras and lights, if there are any."""
        if cameras:
            self.cameras = cameras
        if lights:
            self.lights = lights
        return self

    def __copy__(self) -> Self:
        made = type(self).__new__(type(self), self)
        made.__dict__.update(self.__dict__)
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        # Geometry cannot change, so both share it.
        made = type(self).__new__(type(self), self)
        memo[id(self)] = made
        made.__dict__.update(deepcopy(self.__dict__, memo))
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        attributes = dict(self.__dict__)
        geometry = super().__reduce__()[1]
        return restored_scene, (type(self), STATE_VERSION, geometry, attributes, checksum(attributes))

    def __repr__(self) -> str:
        (x0, y0, z0), (x1, y1, z1) = self.bounds
        name = f"{self.source!r}, " if self.source else ""
        name += f"taken as {self.taken}, " if self.taken else ""
        return (
            f"Scene({name}{self.triangle_count:,} triangles, {self.instance_count:,} instances of {self.mesh_count:,} "
            f"meshes, bounds ({x0:.6g}, {y0:.6g}, {z0:.6g}) to ({x1:.6g}, {y1:.6g}, {z1:.6g}))"
        )

    def _repr_html_(self) -> str:
        from html import escape

        low, high = ([f"{v:.6g}" for v in corner] for corner in self.bounds)
        rows = [
            ("source", escape(self.source) or "arrays"),
            *([("taken as", escape(self.taken))] if self.taken else []),
            ("triangles", f"{self.triangle_count:,}"),
            ("instances", f"{self.instance_count:,} of {self.mesh_count:,} meshes"),
            ("bounds", f"({', '.join(low)}) to ({', '.join(high)})"),
        ]
        body = "".join(f"<tr><th style='text-align:left'>{k}</th><td>{v}</td></tr>" for k, v in rows)
        return f"<table>{body}</table>"


def _moved(
    kind: str, things: Mapping[str, T], move: Callable[[T, Any], T], matrix: Any, left_out: list[str]
) -> Mapping[str, T]:
    """Cameras or lights moved with their scene."""
    made = {}
    for name, thing in things.items():
        try:
            made[name] = move(thing, matrix)
        except ArgumentError as e:
            left_out.append(f"left out {kind} {name!r}: {e}")
    return made


def _joined(first: Mapping[str, T], second: Mapping[str, T]) -> Mapping[str, T]:
    """Cameras or lights of both scenes; a name that is taken gets a number."""
    made = dict(first)
    for name, thing in second.items():
        made[unique(name, made)] = thing
    return made


def restored_scene(*parts: Any) -> Scene:
    """The scene of a class, a version, its geometry's state, its attributes and their checksum.

    Raises
    ------
    StateError
        For a state that is damaged, or that a newer version wrote.
    """
    cls = parts[0] if parts else None
    if not (isinstance(cls, type) and issubclass(cls, Scene) and len(parts) == 5):
        raise damaged("Scene", "its class is missing")
    version, state, attributes, digest = parts[1:]
    check_version(cls.__name__, version, STATE_VERSION)
    if not isinstance(attributes, dict) or checksum(attributes) != digest or not isinstance(state, tuple):
        raise damaged(cls.__name__, "its checksum is another")
    geometry = _core.restore(*state)
    if not isinstance(geometry, _core.Scene):
        raise damaged(cls.__name__, f"it holds a {type(geometry).__name__}")
    made = cls.__new__(cls, geometry)
    made.__dict__.update(attributes)
    return made
