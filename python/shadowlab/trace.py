"""Truth by ray casting: knows no parameterization and no map."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from . import _core
from .text.checked import a_flag

__all__ = ["Truth", "first_hit", "occluded", "shadow_mask"]


class Truth(IntEnum):
    """What rays say of a pixel, in the arrays of `shadow_mask`."""

    LIT = 1
    SHADOW = 0  # facing away from the light counts as shadow, edge-on included
    UNDECIDED = -1  # the answer changes when rays move by what single precision resolves
    NOTHING = -2  # no surface


def shadow_mask(
    scene: _core.Scene,
    camera: _core.Camera,
    light: _core.DirectionalLight | _core.SpotLight | _core.PointLight,
    *,
    size: int | tuple[int, int],
    progress: bool = False,
) -> npt.NDArray[np.int8]:
    """The exact shadows of a view.

    A surface is lit where it faces the light and nothing meets the open segment between them. A light nearer to a
    surface than single precision resolves in the scene (half of its extent times 2^-22) stands on it, and that surface
    shades nothing from it. docs/conventions.md has the definitions.

    The acceleration structure is built at the first call and stays with the scene.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight
    size : int or (int, int)
        Pixels: a side, or width and height.
    progress : bool
        Show a progress bar.

    Returns
    -------
    (H, W) int8
        1 lit; 0 in shadow (also what faces away from the light, edge-on included); -1 undecided: the answer changes
        when rays move by what single precision resolves; -2 nothing there. `Truth` names them.
    """
    if not a_flag("progress", progress):
        return _core.trace_shadow_mask(scene, camera, light, size=size)
    from tqdm.auto import tqdm

    with tqdm(desc="truth", unit="step", leave=False) as bar:

        def report(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        return _core.trace_shadow_mask(scene, camera, light, size=size, progress=report)


def first_hit(
    scene: _core.Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """The first triangle on each ray ``origin + t * direction``, t > 0.

    Parameters
    ----------
    scene : Scene
    origins, directions : (N, 3) array_like
        World units; directions of any length above 0.

    Returns
    -------
    t : (N,) float64
        Infinity where nothing is hit.
    triangle, instance : (N,) int32
        Row of the mesh's face array and index of the instance; -1 where nothing is hit. Of triangles that are met
        together (equal or coplanar, up to the rounding of double precision) the lowest instance, then the lowest row.

    Raises
    ------
    ArgumentError
        For another shape, or a ray that is not finite or has no direction.
    """
    return _core.first_hit(scene, origins, directions)


def occluded(
    scene: _core.Scene, origins: npt.ArrayLike, directions: npt.ArrayLike, t_max: npt.ArrayLike | None = None
) -> npt.NDArray[np.bool_]:
    """Whether anything lies on each ray at 0 < t < t_max.

    Parameters
    ----------
    scene : Scene
    origins, directions : (N, 3) array_like
    t_max : float or (N,) array_like, optional
        In units of each direction; no limit where none is given.

    Returns
    -------
    (N,) bool
    """
    return _core.occluded(scene, origins, directions, t_max)
