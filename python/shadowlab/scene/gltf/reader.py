"""glTF 2.0 files (.gltf and .glb) as meshes, places, cameras and lights.

Source: Khronos Group, "glTF 2.0 Specification", version 2.0.1 (2021), and the extensions in `extensions.py`.
What is read is the file at rest: animations are passed over. A mesh that no visible node of the active scene shows is
left out, and so is a primitive that its material discards altogether.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ... import _core
from ...errors import LoadError, SceneError
from ..alpha_test import AlphaTest
from ..formats.given import Given
from ..formats.limits import check_limit
from ..gathered import Gathered
from .accessors import Accessors
from .cameras import cameras_in
from .document import Document, document_of
from .graph import TRANSFORM_BYTES, Graph, collapsed, graph_of
from .instancing import instances_of
from .items import FIX
from .lights import lights_in
from .materials import Discarded, Materials
from .morphs import morphed, weights_of
from .primitives import Primitive, check_range, primitive_of
from .skins import joint_matrices, posed

# Where a coordinate of a placed mesh is refused: its square, and that of the scene's extent, must stay finite.
MOST_COORDINATE = 1e150
# From so many vertices for each index on, a primitive looks for the ones it uses before they are converted.
FEW_USED = 4
# Names in one warning.
MOST_NAMES = 5


class Use(NamedTuple):
    """A mesh as nodes show it: nodes that agree in all of this share it.

    Attributes
    ----------
    mesh : int
    skin : int
        -1 for none.
    weights : tuple of float
        Of its morph targets; empty where all are 0.
    """

    mesh: int
    skin: int
    weights: tuple[float, ...]


@dataclass(eq=False)
class Gathering:
    """A document while its scene is gathered."""

    document: Document
    accessors: Accessors
    graph: Graph
    materials: Materials
    found: Gathered = field(default_factory=Gathered)
    #: World from mesh at each use, in the order of the scene.
    places: list[tuple[Use, NDArray[np.float64]]] = field(default_factory=list)
    #: Primitives that joints put into world space, whatever their node's transform.
    in_world: set[tuple[Use, int]] = field(default_factory=set)
    joints: dict[int, NDArray[np.float64]] = field(default_factory=dict)


def read_gltf(given: Given) -> Gathered:
    """What a glTF file holds.

    Parameters
    ----------
    given : Given
        Text or binary, whatever its ending says.

    Raises
    ------
    LoadError
        For a file that is broken, of another version, beyond its limits, or requires an extension that is not read.
    SceneError
        For geometry that cannot be used: an index of no vertex, numbers that overflow.
    """
    try:
        # Whatever overflows, or is no number, is refused or left out where it counts.
        with np.errstate(all="ignore"):
            document = document_of(given)
            accessors = Accessors.of(document)
            reading = Gathering(document, accessors, graph_of(document), Materials(accessors))
            gather(reading)
    except MemoryError as e:
        raise LoadError(f"{given.name}: expected a file that fits into memory, got one that does not ({e})") from e
    return reading.found


def gather(reading: Gathering) -> None:
    """Meshes, places, cameras and lights of the active scene."""
    document, graph, found = reading.document, reading.graph, reading.found
    active, hidden = graph.active(), graph.invisible()
    visible = [node for node in active if node not in hidden]
    collect_places(reading, visible)
    uses = dict.fromkeys(use for use, _ in reading.places)
    for use in sorted(uses, key=lambda use: use.mesh):
        add_mesh(reading, use)
    for use, transforms in reading.places:
        for i in range(len(document.primitives(use.mesh))):
            if (use, i) in reading.in_world:
                found.place((use, i), np.eye(4))
                if len(transforms) > 1:
                    name = document.meshes[use.mesh].place
                    document.notes.append(f"{name} is skinned and instanced: its joints place it, once")
            else:
                found.place((use, i), transforms)
    box: list[NDArray[np.float64]] = []

    def bounds() -> NDArray[np.float64]:
        if not box:
            box.append(np.asarray(_core.Scene(*found.arrays()).bounds))
        return box[0]

    if found.index:
        check_extent(found, document.given.name)
        found.cameras.update(cameras_in(graph, sorted(active), document.notes))
        found.lights.update(lights_in(graph, sorted(visible), bounds, document.notes))
    if names := list(reading.materials.blended):
        shown = ", ".join(names[:MOST_NAMES]) + (", ..." if len(names) > MOST_NAMES else "")
        many = len(names) > 1
        document.notes.append(f"blended material{'s' if many else ''} {shown} {'are' if many else 'is'} opaque here")
    found.notes.extend(dict.fromkeys(document.notes))


def collect_places(reading: Gathering, nodes: list[int]) -> None:
    """Finds where meshes stand.

    Raises
    ------
    LoadError
        For more places than the limits allow.
    SceneError
        For a transform that is not finite.
    """
    document, world, limits = reading.document, reading.graph.world, reading.document.given.limits
    finite: list[bool] = np.logical_and.reduce(np.isfinite(world), axis=(1, 2)).tolist()
    flat = collapsed(world).tolist()
    total, left_out = 0, 0
    for index in nodes:
        node = document.nodes[index]
        if "mesh" not in node.value:
            continue
        mesh = node.index("mesh", len(document.meshes), "meshes")
        skin = node.index("skin", len(document.skins), "skins") if "skin" in node.value else -1
        use = Use(mesh, skin, weights_of(node, document.meshes[mesh]))
        transforms = world[index : index + 1]
        instances = instances_of(node, reading.accessors) if "extensions" in node.value else None
        if instances is not None:
            transforms = transforms @ instances
            finite[index] = bool(np.isfinite(transforms).all())
        if skin < 0:
            if not finite[index]:
                raise SceneError(
                    f"{node.file}: {node.place}: expected a finite transform, got one that overflows; {FIX}"
                )
            if flat[index] or instances is not None:
                kept = transforms[~collapsed(transforms)]
                left_out += len(transforms) - len(kept)
                transforms = kept
        placed = len(transforms) * len(document.primitives(mesh))
        total += placed
        if total > limits.instances:
            check_limit(limits, node.file, "instances", total, "placed meshes")
        document.expand(TRANSFORM_BYTES * placed)
        if len(transforms):
            reading.places.append((use, transforms))
    if left_out:
        document.notes.append(f"left out {left_out} placed mesh{'es' if left_out > 1 else ''} of scale 0, without area")


def add_mesh(reading: Gathering, use: Use) -> None:
    """Adds the primitives of a mesh as nodes show it."""
    document, accessors = reading.document, reading.accessors
    mesh = document.meshes[use.mesh]
    items = document.primitives(use.mesh)
    if not items:
        reading.found.empty.append(f"{mesh.name or f'mesh {use.mesh}'} (no primitives)")
    for i, item in enumerate(items):
        label = mesh.name or f"mesh {use.mesh}"
        label += f", primitive {i}" if len(items) > 1 else ""
        primitive = primitive_of(item, label, accessors)
        if isinstance(primitive, str):
            reading.found.empty.append(f"{label} ({primitive})")
            continue
        alpha = reading.materials.alpha_test(primitive)
        if alpha is Discarded:
            document.notes.append(f"left out {label}: its material discards all of it")
            continue
        vertices = morphed(primitive, use.weights, accessors)
        if use.skin >= 0:
            vertices = skinned(reading, use, i, primitive, vertices)
        # What a file of many views of the same bytes makes is bounded, too.
        document.expand(12 * len(primitive.faces))
        test = alpha if isinstance(alpha, AlphaTest) else None
        made = mesh_of_primitive(primitive, vertices, test)
        if made is None:
            reading.found.empty.append(f"{label} (no usable triangle)")
            reading.found.dropped.append(len(primitive.faces))
        else:
            reading.found.add((use, i), label, vertices, primitive.faces, made)


def mesh_of_primitive(primitive: Primitive, vertices: NDArray[Any], alpha: AlphaTest | None) -> _core.Mesh | None:
    """The mesh of a primitive with these vertices; None without a triangle of finite ones.

    Vertices that other primitives take are passed over; a mesh keeps the ones that its triangles use in any case.

    Raises
    ------
    SceneError
        For an index of no vertex.
    """
    faces = primitive.faces
    if alpha is None and len(vertices) > FEW_USED * faces.size:
        used, places = np.unique(faces, return_inverse=True)
        if len(used) and used[-1] < len(vertices):
            vertices, faces = vertices[used], places.reshape(-1, 3)
    try:
        return _core.Mesh(vertices, faces, alpha=alpha) if len(faces) else None
    except SceneError:
        check_range(primitive.faces, len(vertices), primitive.label, primitive.item.file)
        return None


def skinned(reading: Gathering, use: Use, i: int, primitive: Primitive, vertices: NDArray[Any]) -> NDArray[Any]:
    """The vertices as the skin of a use poses them."""
    skin = reading.document.skins[use.skin]
    if use.skin not in reading.joints:
        reading.joints[use.skin] = joint_matrices(skin, reading.graph, reading.accessors)
    made = posed(primitive, vertices, reading.joints[use.skin], reading.accessors)
    if made is None:
        reading.document.notes.append(f"{primitive.label} has no joints for its skin: it stands as its node does")
        return vertices
    reading.in_world.add((use, i))
    return made


def check_extent(found: Gathered, name: str) -> None:
    """Raises for meshes that are so far away, or so large, that lengths overflow.

    Raises
    ------
    SceneError
    """
    meshes, index, transforms = found.arrays()
    frames = [mesh.frame for mesh in meshes]
    half = np.array([np.abs(center) + scale for scale, center in frames])[index]
    reach = np.abs(transforms[:, :3, :3]) @ half[:, :, None] + np.abs(transforms[:, :3, 3:])
    if not reach.max() < MOST_COORDINATE:
        raise SceneError(
            f"{name}: expected coordinates below {MOST_COORDINATE:g}, got {reach.max():g}; scale the scene down"
        )
