"""The eye-space blur of a shadow mask, which respects edges of depth and creases: theory.md (14.1) and (14.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..text.progress import steps_of_call

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..types import BlurStrength


def blur(
    mask: npt.ArrayLike,
    gbuffer: _core.GBuffer,
    camera: _core.Camera,
    *,
    iterations: int = 8,
    strength: BlurStrength = "depth",
    depth: float | None = None,
    progress: bool | None = None,
) -> NDArray[np.float32]:
    """A shadow mask blurred in the picture, over surfaces but not from one to another.

    Each iteration averages every pixel with its neighbours by the weights [1 2 1]/4, along rows and then along columns:
    n of them blur by ``sqrt(n / 2)`` pixels (standard deviation along each axis). Neighbours count less the further
    they lie off each other's plane, and the more their normals differ: a wall at any angle to the view is one surface,
    and nothing crosses an edge of a pixel's size or more, nor a right angle.

    Parameters
    ----------
    mask : (H, W) array_like
        From `Renderer.shadow_mask` or `aliasing.look_up`: 1 lit, 0 in shadow, NaN where nothing is.
    gbuffer : GBuffer
        What the camera sees, of the same size.
    camera : Camera
        The one of the G-buffer.
    iterations : int
        0 to 4096; 0 changes nothing.
    strength : "depth" or "even"
        "depth": as wide in the world everywhere, so that the iterations fall with the square of the depth. "even": as
        wide in the picture everywhere. With parallel rays both are the same.
    depth : float, optional
        Of "depth": up to this depth along the view, world units, all iterations are made; that of the nearest visible
        surface where none is given, which changes as the camera moves.
    progress : bool, optional
        Whether to show a progress bar once it takes longer than a second. On terminals and in notebooks where nothing
        is given; True shows it wherever standard error goes.

    Returns
    -------
    (H, W) float32
        In [0, 1]; NaN where the mask is, and where the G-buffer shows nothing.

    Raises
    ------
    ArgumentError
        For arguments of another type or out of range, and a mask of another size than the G-buffer.
    UnknownNameError
        For a strength that does not exist.

    References
    ----------
    Scherzer 2005 (robust shadow maps for large environments); docs/theory.md, (14.1) and (14.2).

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> renderer, view = sl.Renderer("cpu"), (scene, scene.camera, scene.light)
    >>> p = sl.technique("lispsm").parameterize(*view, resolution=512)
    >>> mask = renderer.shadow_mask(*view, p, size=(160, 90))
    >>> soft = sl.blur(mask, renderer.gbuffer(scene, scene.camera, size=(160, 90)), scene.camera)
    >>> bool(((soft > 0) & (soft < 1)).any())
    True
    """
    settings: dict[str, Any] = {"iterations": iterations, "strength": strength, "depth": depth}
    with steps_of_call(1, progress) as step:
        step("blur")
        return _core.blur(mask, gbuffer, camera, **settings)
