"""What readers gather of a scene: meshes, their places, and what was left out."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError, SceneError, ShadowlabWarning
from .alpha_test import AlphaTest
from .placed import unique

if TYPE_CHECKING:
    from ..types import Light


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


def _unusable(vertices: Any, faces: Any) -> bool:
    """Whether no face has all of its vertices finite; what else may be wrong with them is an error of the mesh."""
    points, indices = np.asarray(vertices), np.asarray(faces)
    if points.ndim != 2 or points.dtype.kind not in "fiu" or indices.ndim != 2 or indices.dtype.kind not in "iu":
        return False
    if indices.size and not (indices.min() >= 0 and indices.max() < len(points)):
        return False
    if bool(np.isfinite(points).all()):
        return not indices.size
    finite = np.logical_and.reduce(np.isfinite(points), axis=1)
    return not bool(finite[indices].all(axis=1).any())


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
