"""Scenes of other programs: of trimesh and pyrender, and of anything with vertices and faces; and back to trimesh.

Known by their attributes, so that no program is imported to look at its objects. Coordinates are taken as they are: a
right-handed world with y up in pyrender and glTF, as here; any unit.

| object | attributes | what is taken |
| --- | --- | --- |
| trimesh.Scene | geometry, graph | meshes, shared where nodes share them; the camera that was set, if one was |
| pyrender.Scene | mesh_nodes, get_pose | the same, with its instances; cameras, except intrinsic ones; all lights |
| pyrender.Mesh | primitives | meshes with their instances |
| other meshes | vertices, faces | one mesh |
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError, SceneError, ShadowlabError, ShadowlabWarning
from ..text.checked import has_all
from .alpha_test import AlphaTest
from .asked import asking, said
from .foreign_alpha import alpha_of_primitive, alpha_of_trimesh
from .placed import camera_at, farthest, unique

if TYPE_CHECKING:
    import trimesh

    from ..types import Light

# Where a mesh of ours leaves its stored form in trimesh: an attribute of vertices, and the frame in the metadata.
LOCAL, FRAME_KEY = "shadowlab_local", "shadowlab_frame"
# Primitives of triangles, as OpenGL and glTF number modes.
TRIANGLES = 4
# Room beyond the scene for what has no end, as a share of its distance.
SPARE = 0.05
# Of a camera that takes its viewport's shape: what `Camera.look_at` takes.
ASPECT = 16 / 9

T = TypeVar("T")


@dataclass(eq=False)
class Gathered:
    """What a scene of another program is made of, and what was left out of it."""

    meshes: dict[Any, _core.Mesh] = field(default_factory=dict)
    index: list[Any] = field(default_factory=list)
    transforms: list[NDArray[np.float64]] = field(default_factory=list)
    #: Names of what has no triangle.
    empty: list[str] = field(default_factory=list)
    #: Faces that were left out, by geometry.
    dropped: list[int] = field(default_factory=list)
    #: Faces with fewer than three distinct corners in a row, which were left out.
    degenerate: int = 0
    #: What else was left out.
    left_out: list[str] = field(default_factory=list)
    #: What there is to say beside.
    notes: list[str] = field(default_factory=list)
    #: The axis that points up, and metres per unit, where a file says so.
    up: str | None = None
    unit: float | None = None
    #: That the file brought, by name.
    cameras: dict[str, _core.Camera] = field(default_factory=dict)
    lights: dict[str, Light] = field(default_factory=dict)

    def join(self, other: Gathered, name: str) -> None:
        """Adds all of another, of that name."""
        self.meshes.update({(name, key): mesh for key, mesh in other.meshes.items()})
        self.index += [(name, key) for key in other.index]
        self.transforms += other.transforms
        self.empty += other.empty
        self.dropped += other.dropped
        self.degenerate += other.degenerate
        self.left_out += other.left_out
        self.notes += other.notes
        for key, camera in other.cameras.items():
            self.cameras[unique(key, self.cameras)] = camera
        for key, light in other.lights.items():
            self.lights[unique(key, self.lights)] = light

    def warn(self, *, stacklevel: int) -> None:
        """Warns of what was left out, and gives the notes."""
        warn_left_out(sum(self.dropped), self.empty, self._others(), stacklevel=stacklevel + 1)
        warn_notes(self.notes, stacklevel=stacklevel + 1)

    def _others(self) -> list[str]:
        """What else was left out."""
        faces = "faces" if self.degenerate > 1 else "face"
        counted = [f"{self.degenerate:,} {faces} with fewer than three distinct vertices"] if self.degenerate else []
        return [*self.left_out, *counted]

    def add(
        self, key: Any, name: str, vertices: Any, faces: Any, made: Any = None, alpha: AlphaTest | None = None
    ) -> None:
        """Adds a mesh under a key, with its alpha test if it has one, unless it has no usable triangle."""
        if made is None and _unusable(vertices, faces):
            self.empty.append(f"{name} (no usable triangle)")
            self.dropped.append(len(faces))
            return
        self.meshes[key] = _core.Mesh(vertices, faces, alpha=alpha) if made is None else made
        self.dropped.append(self.meshes[key].dropped_faces)

    def place(self, key: Any, transform: Any) -> None:
        """Places a mesh by one transform (4, 4) or several (K, 4, 4), if there is one under the key.

        Raises
        ------
        ArgumentError
            For what is no matrix of numbers.
        """
        if key in self.meshes:
            matrices = np.asarray(transform, np.float64)
            if matrices.ndim not in (2, 3) or matrices.shape[-2:] != (4, 4):
                shape = matrices.shape
                raise ArgumentError(f"source: expected transforms of shape (4, 4), got {shape}; give affine maps")
            matrices = matrices.reshape(-1, 4, 4)
            self.index.extend([key] * len(matrices))
            self.transforms.append(matrices)

    def arrays(self) -> tuple[list[_core.Mesh], list[int], NDArray[np.float64]]:
        """What a scene is made of.

        Raises
        ------
        SceneError
            Where nothing is placed.
        """
        if not self.index:
            reasons = ", ".join([*self.empty, *self._others(), *self.notes])
            what = f"left out: {reasons}" if reasons else "the scene graph places no mesh"
            raise SceneError(
                f"the scene has no usable triangle: {what}; give at least one triangle with finite vertices"
            )
        order = {key: i for i, key in enumerate(self.meshes)}
        return list(self.meshes.values()), [order[key] for key in self.index], np.concatenate(self.transforms)


def gathered(source: Any) -> Gathered:
    """The meshes of another program's object and their places, its cameras and lights; warns of what was left out.

    Raises
    ------
    ArgumentError
        For something else.
    SceneError
        For an index out of range.
    """
    found = collected(source)
    found.warn(stacklevel=4)
    return found


def collected(source: Any) -> Gathered:
    """What `gathered` gives, without its warnings."""
    with asking("an object with geometry"):
        return _collected(source)


def _collected(source: Any) -> Gathered:
    found = Gathered()
    if is_graph(source):
        _of_trimesh_scene(source, found)
    elif is_pyrender_scene(source):
        for node, pose in _in_order(source, source.mesh_nodes):
            _of_pyrender_mesh(node.mesh, node.name or "a mesh", pose, found)
    elif has_all(source, "primitives"):
        _of_pyrender_mesh(source, getattr(source, "name", None) or "the mesh", np.eye(4), found)
    elif has_all(source, "vertices", "faces"):
        # A mesh alone: what is wrong with it is an error, and nothing to leave out.
        mesh = mesh_of(source, alpha_of_trimesh(source, found.notes, "the mesh"))
        found.meshes[0] = mesh
        found.dropped.append(mesh.dropped_faces)
        found.place(0, np.eye(4))
    else:
        raise ArgumentError(
            "source: expected a trimesh.Trimesh or trimesh.Scene, a pyrender scene or mesh, or an object with vertices "
            f"and faces, got {type(source).__name__}; load it with trimesh, or use Scene.from_arrays"
        )
    return found


def is_graph(source: Any) -> bool:
    """Whether it is a trimesh scene."""
    return has_all(source, "geometry", "graph") and isinstance(source.geometry, Mapping)


def is_pyrender_scene(source: Any) -> bool:
    """Whether it is a pyrender scene."""
    return has_all(source, "mesh_nodes", "get_pose") and isinstance(source.mesh_nodes, (set, list, tuple))


def mesh_of(geometry: Any, alpha: AlphaTest | None = None) -> _core.Mesh:
    """The mesh of vertices and faces; the very one that `to_trimesh` wrote where neither was changed since."""
    if alpha is not None:
        return _core.Mesh(geometry.vertices, geometry.faces, alpha=alpha)
    attributes, metadata = getattr(geometry, "vertex_attributes", None), getattr(geometry, "metadata", None)
    if (
        isinstance(attributes, Mapping)
        and isinstance(metadata, Mapping)
        and LOCAL in attributes
        and FRAME_KEY in metadata
    ):
        try:
            scale, *center = metadata[FRAME_KEY]
            mesh = _core.Mesh.from_local(attributes[LOCAL], geometry.faces, float(scale), center)
        except (ShadowlabError, TypeError, ValueError):
            pass  # changed since: its vertices and faces are what counts
        else:
            if np.array_equal(mesh.vertices, geometry.vertices):
                return mesh
    return _core.Mesh(geometry.vertices, geometry.faces)


def _unusable(vertices: Any, faces: Any) -> bool:
    """Whether no face has all of its vertices finite; what else may be wrong with them is an error of the mesh."""
    points, indices = np.asarray(vertices), np.asarray(faces)
    if points.ndim != 2 or points.dtype.kind not in "fiu" or indices.ndim != 2 or indices.dtype.kind not in "iu":
        return False
    if indices.size and not (indices.min() >= 0 and indices.max() < len(points)):
        return False
    finite = np.logical_and.reduce(np.isfinite(points), axis=1)
    if finite.all():
        return not indices.size
    return not bool(finite[indices].all(axis=1).any())


def _of_trimesh_scene(source: Any, found: Gathered) -> None:
    known = set()
    for name, geometry in source.geometry.items():
        known.add(name)
        try:
            if not (hasattr(geometry, "vertices") and hasattr(geometry, "faces")):
                found.empty.append(f"{name} ({type(geometry).__name__})")
                continue
            alpha = alpha_of_trimesh(geometry, found.notes, name)
            own = alpha is None and LOCAL in getattr(geometry, "vertex_attributes", ())
            found.add(name, name, geometry.vertices, geometry.faces, mesh_of(geometry) if own else None, alpha)
        except ShadowlabError:
            raise
        except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
            found.empty.append(f"{name} ({said(e)})")
    for node in source.graph.nodes_geometry:
        transform, name = source.graph.get(node)
        if name in known:
            found.place(name, transform)
        else:
            found.left_out.append(f"node {node!r}, whose geometry {name!r} does not exist")


def _of_pyrender_mesh(mesh: Any, name: str, pose: NDArray[np.float64], found: Gathered) -> None:
    for primitive in mesh.primitives:
        key = id(primitive)
        if key not in found.meshes:
            if getattr(primitive, "mode", TRIANGLES) not in (TRIANGLES, None):
                found.empty.append(f"{name} (a primitive of another kind than triangles)")
                continue
            positions, indices = primitive.positions, primitive.indices
            # Without indices three vertices in a row are a face.
            faces = np.arange(len(positions)) if indices is None else _whole(np.asarray(indices))
            alpha = alpha_of_primitive(primitive, found.notes, name)
            found.add(key, name, positions, faces.reshape(-1, 3), alpha=alpha)
        for instance in [np.eye(4)] if primitive.poses is None else primitive.poses:
            found.place(key, pose @ np.asarray(instance, np.float64))


def _whole(indices: NDArray[Any]) -> NDArray[Any]:
    """Indices as whole numbers; pyrender keeps them as floats."""
    whole = indices.dtype.kind == "f" and bool((np.floor(indices) == indices).all())
    return indices.astype(np.int64) if whole else indices


def cameras_of(source: Any) -> tuple[dict[str, _core.Camera], list[str]]:
    """The cameras of a scene by name, and what there is to say of the others."""
    found: dict[str, _core.Camera] = {}
    notes: list[str] = []
    for name, camera, pose in _asked(_cameras(source), "camera", notes):
        label = f"camera {name!r}"
        try:
            settings = _lens(camera, label, notes)
            found[unique(name, found)] = camera_at(pose, **settings)
        except ArgumentError as e:
            notes.append(f"left out {label}: {e}")
        except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
            notes.append(f"left out {label}: {said(e)}")
    return found, notes


def _cameras(source: Any) -> Iterator[tuple[str, Any, NDArray[np.float64]]]:
    if is_pyrender_scene(source):
        for i, (node, pose) in enumerate(_in_order(source, source.camera_nodes)):
            yield node.name or node.camera.name or f"camera {i + 1}", node.camera, pose
    elif getattr(source, "has_camera", False):
        # Asked for only where one was set: trimesh would make one.
        yield source.camera.name or "camera", source.camera, np.asarray(source.camera_transform, np.float64)


def _asked(things: Iterator[T], kind: str, notes: list[str]) -> Iterator[T]:
    """The same, up to where the other program fails."""
    try:
        yield from things
    except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
        notes.append(f"left out a {kind}: {said(e)}")


def _lens(theirs: Any, label: str, notes: list[str]) -> dict[str, float]:
    """Field of view or height, aspect, near and far of another program's camera."""
    if hasattr(theirs, "yfov"):
        aspect, far = theirs.aspectRatio, theirs.zfar
        if aspect is None:
            aspect = ASPECT
            notes.append(f"{label} has no aspect ratio: 16:9 is taken; camera.replace(aspect=...) changes it")
        far = math.inf if far is None else far
        return {"fov_y": float(theirs.yfov), "aspect": float(aspect), "near": float(theirs.znear), "far": float(far)}
    if hasattr(theirs, "fov") and hasattr(theirs, "z_far"):
        across, up = np.tan(0.5 * np.radians(np.asarray(theirs.fov, np.float64)))
        near, far = float(theirs.z_near), float(theirs.z_far)
        return {"fov_y": 2 * float(np.arctan(up)), "aspect": float(across / up), "near": near, "far": far}
    if hasattr(theirs, "xmag"):
        # Half the width and half the height.
        across, up = float(theirs.xmag), float(theirs.ymag)
        return {"height": 2 * up, "aspect": across / up, "near": float(theirs.znear), "far": float(theirs.zfar)}
    raise ArgumentError(
        f"{type(theirs).__name__} does not say how wide its picture is; sl.Camera.from_matrices takes its matrices"
    )


def lights_of(source: Any, bounds: NDArray[np.float64]) -> tuple[dict[str, Light], list[str]]:
    """The lights of a pyrender scene by name, and what there is to say of the others; other scenes have none."""
    found: dict[str, Light] = {}
    notes: list[str] = []
    for i, (node, pose) in enumerate(_asked(_lights(source), "light", notes)):
        name = node.name or node.light.name or f"light {i + 1}"
        try:
            made = _light(node.light, pose, bounds)
            found[unique(name, found)] = made
        except ArgumentError as e:
            notes.append(f"left out light {name!r}: {e}")
        except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
            notes.append(f"left out light {name!r}: {said(e)}")
    return found, notes


def _lights(source: Any) -> Iterator[tuple[Any, NDArray[np.float64]]]:
    if is_pyrender_scene(source):
        yield from _in_order(source, source.light_nodes)


def _light(theirs: Any, pose: NDArray[np.float64], bounds: NDArray[np.float64]) -> Light:
    way, position = -pose[:3, 2], pose[:3, 3]
    if not hasattr(theirs, "range"):
        return _core.DirectionalLight(way)
    # Light without a range has no end; one that reaches all of the scene is the same for it. A point has no extent.
    whole = (1 + SPARE) * farthest(bounds, position) or 1.0
    reach = whole if theirs.range is None else float(theirs.range)
    if hasattr(theirs, "outerConeAngle"):
        # Theirs is from the axis to the edge, ours from edge to edge.
        return _core.SpotLight(position, way, cone_angle=2 * float(theirs.outerConeAngle), range=reach)
    return _core.PointLight(position, range=reach)


def _in_order(theirs: Any, nodes: Any) -> list[tuple[Any, NDArray[np.float64]]]:
    """Nodes with their poses, in an order that follows from them: pyrender keeps them in sets."""

    def key(placed: tuple[Any, NDArray[np.float64]]) -> Any:
        node, pose = placed
        arrays = [np.ascontiguousarray(p.positions) for p in getattr(node.mesh, "primitives", ())]
        numbers = {name: value for name, value in vars(node.camera or node.light or node).items() if np.isscalar(value)}
        digests = [hashlib.blake2b(array.tobytes()).hexdigest() for array in arrays]
        return str(node.name or ""), pose.ravel().tolist(), digests, repr(sorted(numbers.items()))

    return sorted(((node, np.asarray(theirs.get_pose(node), np.float64)) for node in nodes), key=key)


def to_trimesh(scene: _core.Scene) -> trimesh.Scene:
    """The scene as trimesh has it; see `Scene.to_trimesh`."""
    import trimesh

    tested = sum(mesh.alpha is not None for mesh in scene.meshes)
    if tested:
        warn_notes([f"left out the alpha tests of {tested} of {scene.mesh_count} meshes"], stacklevel=4)
    made = trimesh.Scene()
    graph: Any = made.graph
    names = [f"mesh {i}" for i in range(scene.mesh_count)]
    for name, mesh in zip(names, scene.meshes, strict=True):
        scale, center = mesh.frame
        made.geometry[name] = trimesh.Trimesh(
            mesh.vertices,
            mesh.faces,
            process=False,
            validate=False,
            vertex_attributes={LOCAL: mesh.positions_local},
            metadata={FRAME_KEY: [scale, *map(float, center)]},
        )
    for i, (index, transform) in enumerate(zip(scene.mesh_index, scene.transforms, strict=True)):
        graph.update(frame_to=f"instance {i}", matrix=transform, geometry=names[index])
    return made


def warn_left_out(faces: int, empty: list[str], others: Sequence[str] = (), *, stacklevel: int) -> None:
    """Warns of faces, geometries and others that were left out, if any were."""
    parts = []
    if faces:
        parts.append(f"{faces} face{'s' if faces > 1 else ''} with vertices that are not finite")
    if empty:
        shown = ", ".join(empty[:5]) + (", ..." if len(empty) > 5 else "")
        parts.append(f"{len(empty)} geometr{'ies' if len(empty) > 1 else 'y'} without triangles: {shown}")
    parts += others
    if parts:
        warnings.warn(f"left out: {' and '.join(parts)}", ShadowlabWarning, stacklevel=stacklevel)


def warn_notes(notes: list[str], *, stacklevel: int) -> None:
    """Warns of cameras and lights that were left out or completed, if any were."""
    if notes:
        warnings.warn("; ".join(notes), ShadowlabWarning, stacklevel=stacklevel)
