"""The node graph of a glTF document: parents, world transforms, the active scene, and what is invisible.

No function here calls itself, so chains of nodes may be of any length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .document import Document
from .extensions import VISIBILITY

#: Of a transform in memory.
TRANSFORM_BYTES = 128
# How far a quaternion's length may be from 1 before it is said: normalised bytes have steps of 1/127.
UNIT_TOLERANCE = 0.02
# Of the area between axes whose largest entry is 1: products of rotations leave a few units in the last place.
AREA_ROUNDING = 64 * float(np.finfo(np.float64).eps)
# How far the last row of a matrix may be from that of an affine map: rounding of single precision.
AFFINE_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Graph:
    """The nodes of a document as a forest.

    Attributes
    ----------
    document : Document
    parent : list of int
        -1 for roots.
    children : list of list of int
    levels : list of list of int
        Nodes by their depth.
    """

    document: Document
    parent: list[int]
    children: list[list[int]]
    levels: list[list[int]]

    @cached_property
    def world(self) -> NDArray[np.float64]:
        """(N, 4, 4) float64: world from node."""
        world = local_transforms(self.document)
        for level in self.levels[1:]:
            parents = [self.parent[i] for i in level]
            world[level] = world[parents] @ world[level]
        return world

    def active(self) -> list[int]:
        """The nodes of the active scene: parents before children, the last root and the last child first.

        Raises
        ------
        LoadError
            For a scene that does not exist, or with a node that is a child of another.
        """
        found, stack = [], list(dict.fromkeys(self._roots()))
        while stack:
            node = stack.pop()
            found.append(node)
            stack.extend(self.children[node])
        return found

    def _roots(self) -> list[int]:
        top = self.document.top
        scenes = top.items("scenes")
        if not scenes:
            if "scene" in top.value:
                top.index("scene", 0, "scenes")
            return self.levels[0] if self.levels else []
        scene = scenes[top.index("scene", len(scenes), "scenes") if "scene" in top.value else 0]
        roots = scene.indices("nodes", len(self.parent), "nodes")
        for root in roots:
            if self.parent[root] >= 0:
                raise scene.broken(
                    f"nodes: expected roots, got {self.document.nodes[root].place}, a child of "
                    f"{self.document.nodes[self.parent[root]].place}"
                )
        return roots

    def invisible(self) -> set[int]:
        """The nodes that KHR_node_visibility hides, with all below them."""
        hidden: set[int] = set()
        if not any("extensions" in node.value for node in self.document.nodes):
            return hidden
        for level in self.levels:
            for index in level:
                own = self.document.nodes[index].extension(VISIBILITY)
                if self.parent[index] in hidden or (own is not None and not own.flag("visible", True)):
                    hidden.add(index)
        return hidden


def graph_of(document: Document) -> Graph:
    """The node graph of a document.

    Raises
    ------
    LoadError
        For a node with two parents, or that is its own ancestor.
    """
    nodes = document.nodes
    parent = [-1] * len(nodes)
    children = [node.indices("children", len(nodes), "nodes") if "children" in node.value else [] for node in nodes]
    for index, below in enumerate(children):
        for child in below:
            if parent[child] >= 0:
                raise nodes[child].broken(
                    f"expected one parent, got {nodes[parent[child]].place} and {nodes[index].place}"
                )
            parent[child] = index
    levels = [[i for i, above in enumerate(parent) if above < 0]]
    while levels[-1]:
        levels.append([child for i in levels[-1] for child in children[i]])
    levels.pop()
    reached = {i for level in levels for i in level}
    if len(reached) < len(nodes):
        lost = next(i for i in range(len(nodes)) if i not in reached)
        raise nodes[lost].broken("expected a tree of nodes, got one that is below itself")
    return Graph(document, parent, children, levels)


def local_transforms(document: Document) -> NDArray[np.float64]:
    """(N, 4, 4) float64: parent from node, by a matrix or by translation, rotation and scale.

    Raises
    ------
    LoadError
        For numbers that are none, or a matrix that is not affine.
    """
    nodes = document.nodes
    made = np.tile(np.eye(4), (len(nodes), 1, 1))
    placed: list[int] = []
    given: dict[int, NDArray[np.float64]] = {}
    translation, rotation, scale = (
        np.zeros((len(nodes), 3)),
        np.tile([0.0, 0, 0, 1], (len(nodes), 1)),
        np.ones((len(nodes), 3)),
    )
    for i, node in enumerate(nodes):
        matrix = node.numbers("matrix", 16) if "matrix" in node.value else None
        if matrix is not None:
            given[i] = matrix
            if not node.value.keys().isdisjoint(("translation", "rotation", "scale")):
                document.notes.append(f"{node.place} has a matrix beside translation, rotation or scale: it is taken")
            continue
        for key, into in (("translation", translation), ("rotation", rotation), ("scale", scale)):
            if key in node.value:
                into[i] = node.numbers(key, into.shape[1])
                placed.append(i)
    if given:
        made[list(given)] = affine(list(given), np.array(list(given.values())), document)
    rows = sorted(set(placed))
    if rows:
        unit, wrong = unit_quaternions(rotation[rows])
        for row in wrong:
            node = nodes[rows[row]]
            document.notes.append(
                f"{node.place} has a rotation {rotation[rows[row]].tolist()} that is no unit quaternion: "
                f"{'none' if not rotation[rows[row]].any() else 'its direction'} is taken"
            )
        made[rows] = transforms_of(translation[rows], unit, scale[rows])
    return made


def affine(nodes: list[int], numbers: NDArray[np.float64], document: Document) -> NDArray[np.float64]:
    """The matrices (K, 4, 4) of nodes from their 16 numbers each, which go down the columns."""
    made = numbers.reshape(-1, 4, 4).swapaxes(1, 2)
    wrong = np.flatnonzero(np.abs(made[:, 3] - (0, 0, 0, 1)).max(axis=1) > AFFINE_TOLERANCE)
    if len(wrong):
        row = made[wrong[0], 3].tolist()
        raise document.nodes[nodes[wrong[0]]].broken(
            f"matrix: expected 0, 0, 0, 1 as numbers 4, 8, 12 and 16, got {row}"
        )
    made[:, 3] = 0, 0, 0, 1
    return made


def collapsed(transforms: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,): which transforms (N, 4, 4) leave a line or a point of space, so that nothing placed by them has an area."""
    largest = np.abs(transforms[:, :3, :3]).max(axis=1)
    columns = np.moveaxis(transforms[:, :3, :3] / np.where(largest > 0, largest, 1.0)[:, None, :], 2, 0)
    areas = [np.abs(np.cross(columns[i], columns[i - 1])).max(axis=1) for i in range(3)]
    found: NDArray[np.bool_] = np.max(areas, axis=0) <= AREA_ROUNDING
    return found


def unit_quaternions(quaternions: NDArray[np.float64]) -> tuple[NDArray[np.float64], list[int]]:
    """Quaternions (N, 4) of length 1, the identity for zero ones; and which were far from it."""
    largest = np.abs(quaternions).max(axis=1, keepdims=True)
    # Scaled first: squares of tiny and huge numbers leave the range of float64.
    scaled = np.where(largest > 0, quaternions / np.where(largest > 0, largest, 1.0), (0.0, 0, 0, 1))
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    far = np.abs(length * largest - 1.0) > UNIT_TOLERANCE
    return scaled / length, np.flatnonzero(far[:, 0]).tolist()


def transforms_of(
    translation: NDArray[np.float64], rotation: NDArray[np.float64], scale: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 4, 4): translation (N, 3) times rotation (N, 4, unit quaternions x, y, z, w) times scale (N, 3)."""
    x, y, z, w = rotation.T
    made = np.zeros((len(rotation), 4, 4))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    made[:, :3, :3] = np.moveaxis(turn, 2, 0) * scale[:, None, :]
    made[:, :3, 3] = translation
    made[:, 3, 3] = 1.0
    return made
