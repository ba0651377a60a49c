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
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError, ShadowlabError
from ..text.checked import has_all
from .alpha_test import AlphaTest
from .asked import asking, said
from .foreign_alpha import alpha_of_primitive, alpha_of_trimesh
from .gathered import Gathered, warn_notes

if TYPE_CHECKING:
    import trimesh

# Where a mesh of ours leaves its stored form in trimesh: an attribute of vertices, and the frame in the metadata.
LOCAL, FRAME_KEY = "shadowlab_local", "shadowlab_frame"
# Primitives of triangles, as OpenGL and glTF number modes.
TRIANGLES = 4


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
        for node, pose in in_order(source, source.mesh_nodes):
            _of_pyrender_mesh(node.mesh, node.name or "a mesh", pose, found)
    elif has_all(source, "primitives"):
        _of_pyrender_mesh(source, getattr(source, "name", None) or "the mesh", np.eye(4), found)
    elif hasattr(source, "vertices") and hasattr(source, "faces"):
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


def in_order(theirs: Any, nodes: Any) -> list[tuple[Any, NDArray[np.float64]]]:
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
