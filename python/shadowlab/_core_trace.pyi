"""Rays traced by `_core`, which exports them."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from ._core_camera import Camera, GBuffer
from ._core_scene import Light, Scene
from ._core_types import Float, Size

def trace_shadow_mask(
    scene: Scene,
    camera: Camera,
    light: Light,
    *,
    size: Size,
    progress: Callable[[int, int], object] | None = None,
) -> npt.NDArray[np.int8]:
    """(H, W) int8: 1 lit, 0 in shadow, -1 undecided, -2 nothing there."""

def trace_shadow_masks(
    scene: Scene, camera: Camera, lights: Sequence[Light], *, size: Size
) -> list[npt.NDArray[np.int8]]:
    """The same for each of several lights, whose rays from the eye are traced once: a list of (H, W) int8."""

def first_hit(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[Float, npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """First hits of rays: t (N,) float64 (infinity for none), triangle (N,) int32, instance (N,) int32 (-1 for none)."""

def occluded(
    scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike, t_max: npt.ArrayLike | None = None
) -> npt.NDArray[np.bool_]:
    """Whether anything lies at 0 < t < t_max on each ray: (N,) bool."""

def trace_memory(scene: Scene) -> int:
    """Bytes of the acceleration structure (built if it is not there yet)."""

def face_corners(scene: Scene, instance: int, face: int) -> npt.NDArray[np.float64] | None:
    """The corners (3, 3) float64 of a triangle of an instance, world, which turn counter-clockwise seen from its outer side; None
    where there is no such triangle. `face` is the row of its mesh's face array, as `first_hit` gives it.
    """

def shadows_at(scene: Scene, gbuffer: GBuffer, light: Light) -> npt.NDArray[np.int8]:
    """(H, W) int8: what light does at the surface points of a G-buffer, as `trace_shadow_mask` says it of those it finds."""

def moved_gbuffer(gbuffer: GBuffer, before: Scene, after: Scene) -> GBuffer:
    """The surface points of a G-buffer of the scene `before`, moved with their instances to where these are in `after`.

    Points whose instances stay are the same bit for bit. Points of a flattened instance that moves are left out.
    """

def same_instances(before: Scene, after: Scene) -> bool:
    """Whether both scenes have the same meshes, by content, in the same instances, wherever these are."""
