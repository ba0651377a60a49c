"""Truth by ray casting: knows no parameterization and no map."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from enum import IntEnum
from typing import overload

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import ArgumentError, ShadowlabWarning
from .text.checked import A_CAMERA, A_SCENE, a_count, a_flag, checked, one_or_more_lights, optional
from .text.checks import picture_of
from .text.progress import steps_of_call
from .types import Light, Size

__all__ = ["Truth", "first_hit", "occluded", "shadow_mask", "soft_shadow_mask"]

# Rays along each side of a pixel: 4,096 of them know its average to better than one in a hundred.
MOST_RAYS = 64
# From this share of the visible pixels on, what is undecided is said: differences between techniques are of this size.
MUCH_UNDECIDED = 0.01


class Truth(IntEnum):
    """What rays say of a pixel, in the arrays of `shadow_mask`."""

    LIT = 1
    SHADOW = 0  # facing away from the light counts as shadow, edge-on included
    UNDECIDED = -1  # the answer changes when rays move by what single precision resolves
    NOTHING = -2  # no surface


@overload
def shadow_mask(
    scene: _core.Scene, camera: _core.Camera, light: Light, *, size: Size, progress: bool | None = None
) -> npt.NDArray[np.int8]: ...


@overload
def shadow_mask(
    scene: _core.Scene, camera: _core.Camera, light: Iterable[Light], *, size: Size, progress: bool | None = None
) -> tuple[npt.NDArray[np.int8], ...]: ...


def shadow_mask(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light | Iterable[Light],
    *,
    size: Size,
    progress: bool | None = None,
) -> npt.NDArray[np.int8] | tuple[npt.NDArray[np.int8], ...]:
    """The exact shadows of a view.

    A surface is lit where it faces the light and nothing meets the open segment between them. A light nearer to a
    surface than single precision resolves in the scene (half of its extent times 2^-22) stands on it, and that surface
    shades nothing from it. docs/conventions.md has the definitions.

    The acceleration structure is built at the first call and stays with the scene.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight, or sequence of them
        Several lights share the rays from the eye.
    size : int or (int, int)
        Pixels: a side, or width and height.
    progress : bool, optional
        Whether to show a progress bar once it takes longer than a second. On terminals and in notebooks where nothing
        is given; True shows it wherever standard error goes.

    Returns
    -------
    (H, W) int8, or tuple of them
        1 lit; 0 in shadow (also what faces away from the light, edge-on included); -1 undecided: the answer changes
        when rays move by what single precision resolves; -2 nothing there. `Truth` names them. One per light where
        `light` is a sequence.

    Raises
    ------
    ArgumentError
        For arguments of another type or out of range, and no light.

    Warns
    -----
    ShadowlabWarning
        Where one in a hundred of the visible pixels or more is undecided.
    """
    lights = one_or_more_lights("light", light)
    with steps_of_call(1, progress) as step:
        step("truth")
        if isinstance(lights, tuple):
            masks = tuple(_core.trace_shadow_masks(scene, camera, lights, size=size))
        else:
            masks = (_core.trace_shadow_mask(scene, camera, lights, size=size),)
    _warn_of_undecided(scene, masks)
    return masks if isinstance(lights, tuple) else masks[0]


def _warn_of_undecided(scene: _core.Scene, masks: Iterable[npt.NDArray[np.int8]]) -> None:
    """Says how much the worst of the masks leaves undecided, if that is much, to the caller of a public function."""
    worst = 0.0
    for mask in masks:
        visible = int(np.count_nonzero(mask != Truth.NOTHING))
        worst = max(worst, int(np.count_nonzero(mask == Truth.UNDECIDED)) / max(visible, 1))
    if worst < MUCH_UNDECIDED:
        return
    low, high = scene.bounds
    across = float((high - low).max())
    resolved = across / 2 * 2.0**-22
    warnings.warn(
        f"{worst:.0%} of the visible pixels are undecided: their answer changes when rays move by about "
        f"{resolved:.2g} units, what single precision resolves in a scene {across:.3g} units across; leave out "
        "instances far from all others, and surfaces that lie on others",
        ShadowlabWarning,
        stacklevel=3,
    )


@overload
def soft_shadow_mask(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light,
    *,
    size: Size,
    samples: int = 4,
    progress: bool | None = None,
) -> npt.NDArray[np.float32]: ...


@overload
def soft_shadow_mask(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Iterable[Light],
    *,
    size: Size,
    samples: int = 4,
    progress: bool | None = None,
) -> tuple[npt.NDArray[np.float32], ...]: ...


@checked(
    scene=A_SCENE, camera=A_CAMERA, light=one_or_more_lights, samples=a_count(1, MOST_RAYS), progress=optional(a_flag)
)
def soft_shadow_mask(
    scene: _core.Scene,
    camera: _core.Camera,
    light: Light | Iterable[Light],
    *,
    size: Size,
    samples: int = 4,
    progress: bool | None = None,
) -> npt.NDArray[np.float32] | tuple[npt.NDArray[np.float32], ...]:
    """The exact shadows of a view averaged over the area of each pixel: what a filtered mask aims at.

    A pixel is divided into `samples` x `samples` equal squares, and the middle of each gets a ray of the eye and one of
    the light, as `shadow_mask` traces them. The value is the number of lit rays by that of rays that are lit or in
    shadow. Rays that see no surface do not count, so that the background neither darkens nor lights a silhouette, and
    rays that are undecided do not either. All surfaces that a pixel shows count alike.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight, or sequence of them
        Several lights share the rays from the eye.
    size : int or (int, int)
        Pixels: a side, or width and height.
    samples : int
        Rays along each side of a pixel, 1 to 64. A straight edge along the pixel's sides is off by at most half of
        ``1 / samples``; 1 is `shadow_mask`.
    progress : bool, optional
        Whether to show a progress bar once it takes longer than a second. On terminals and in notebooks where nothing
        is given; True shows it wherever standard error goes.

    Returns
    -------
    (H, W) float32, or tuple of them
        1 lit, 0 in shadow, between them where both are in the pixel, NaN where no ray sees a surface or all that do are
        undecided. One per light where `light` is a sequence.

    Raises
    ------
    ArgumentError
        For arguments of another type or out of range.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> soft = sl.trace.soft_shadow_mask(scene, scene.camera, scene.light, size=(160, 90))
    >>> soft.shape, bool(((soft > 0) & (soft < 1)).any())
    ((90, 160), True)
    """
    if size is None:
        raise ArgumentError("size: expected a side or (width, height) in pixels, got None; try (640, 360)")
    width, height = picture_of(size, camera)
    # `checked` has made a tuple of several.
    lights = light if isinstance(light, tuple) else (light,)
    lit: list[npt.NDArray[np.int32] | int] = [0] * len(lights)
    decided = list(lit)
    # One picture per place within the pixel, from a camera that is shifted by it: memory does not grow with the rays.
    offsets = ((np.arange(samples) + 0.5) / samples - 0.5) * 2.0
    right, up = camera.shift
    with steps_of_call(samples**2, progress) as step:
        for down in offsets:
            for along in offsets:
                step("soft truth")
                moved = camera.replace(shift=(right + along / width, up - down / height))
                truths = _core.trace_shadow_masks(scene, moved, lights, size=(width, height))
                # Pixels come from here, so that a size that the renderer refuses allocates nothing.
                for i, truth in enumerate(truths):
                    lit[i] = lit[i] + (truth == Truth.LIT).astype(np.int32)
                    decided[i] = decided[i] + (truth >= Truth.SHADOW).astype(np.int32)
    shares = []
    for lit_rays, rays in zip(lit, decided, strict=True):
        share: npt.NDArray[np.float32] = np.full((height, width), np.nan, np.float32)
        np.divide(lit_rays, rays, out=share, where=np.asarray(rays) > 0, casting="same_kind")
        shares.append(share)
    return tuple(shares) if isinstance(light, tuple) else shares[0]


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
