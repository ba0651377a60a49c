"""The worst errors of maps where receivers fill the frustum, over the angle between light and view.

Source: the storage factor of Lloyd, Tuft, Yoon, Manocha 2006 [lloyd2006] and Lloyd, Govindaraju, Quammen, Molnar,
Manocha 2008 [lloyd2008], for
light at any angle (theory.md E.2); measured from finished maps, so that a formula is judged by what it makes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core import Technique
from ..aliasing.beam_texels import BeamTexels, beam_texels
from ..aliasing.footprint import footprint_at, halfway_normals, sides_of
from ..aliasing.frustum_body import outline
from ..errors import ShadowlabError
from ..techniques.kinds import is_parameterization
from ..techniques.labels import labelled
from ..techniques.variant import Variant
from ..text.checks import whole
from .columns import table
from .frustum_scene import frustum_scene
from .light_angles import LightAngles, lights_at

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera, Parameterization, Scene
    from ..types import Floats, Item, Light, Size, Techniques

# From the borders of depth splits, as a share of the depth: outlasts the rounding of points.
WITHIN = 1e-9


def frustum_over_light_angle(
    camera: Camera,
    angles_deg: npt.ArrayLike | Iterable[float],
    techniques: Techniques = ("uniform", "lispsm"),
    *,
    azimuth_deg: float = 0.0,
    resolution: int = 1024,
    size: Size = 1024,
    steps: int = 16,
) -> LightAngles:
    """The worst perspective errors where receivers fill the frustum, over the angle between light and view.

    Measured from the Jacobians of the finished maps on surfaces that halve the angle between eye and light, where
    perspective acts alone, over the outline of the frustum (of each depth split its part). Nothing is rendered.

    Parameters
    ----------
    camera : Camera
    angles_deg, techniques, azimuth_deg
        As in `over_light_angle`.
    resolution : int
        Texels along each side of every map.
    size : int or (int, int)
        Pixels of the image: a side, or width and height.
    steps : int
        As in `frustum_body.outline`. The worst is at a corner wherever the error rises or falls along the edges.

    Returns
    -------
    LightAngles
        Of each technique and angle: maps; m_s, m_s_sheared, m_t, the largest `height`, `along` and `across` of
        `BeamTexels` (px); storage_factor and storage_factor_sheared, those of `BeamTexels`; storage_factor_image, the
        same of `Footprint.perspective_ts`, lengths on the image's plane, which stretches what is off its centre.

    Raises
    ------
    ArgumentError
        For angles outside 0 to 180 or that come twice, an angle at which the view holds a ray against the light, and
        arguments of another type.
    UnknownNameError
        For a technique that does not exist.

    Examples
    --------
    >>> import shadowlab as sl
    >>> camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=1.047, near=1, far=1000)
    >>> found = frustum_over_light_angle(camera, [90, 20])
    >>> found.relative("storage_factor_sheared").round(3)["lispsm"].tolist()
    [0.001, 4.396]
    """
    lights = lights_at(camera, angles_deg, azimuth_deg)
    scene, side, picture = frustum_scene(camera), whole("resolution", resolution), sides_of("size", size)
    entries = labelled(techniques, next(iter(lights.values())))
    rows = []
    for angle, light in lights.items():
        for label, item in entries:
            row: dict[str, Any] = {"technique": label, "angle_deg": angle, "failure": ""}
            try:
                p = given_or_fitted(item, scene, camera, light, side)
                points = outlines(p, camera, steps)
                texels = beam_texels(points, camera, light, p, size=picture, resolution=side)
                normals = halfway_normals(points, camera, light)
                e = footprint_at(points, normals, camera, light, p, size=picture, resolution=side)
                notes = "; ".join(map(str, p.notes))
                row |= {"maps": e.maps, "notes": notes, **worst_of_outline(texels, e.perspective_ts)}
            except ShadowlabError as error:
                row["failure"] = str(error)
            rows.append(row)
    return LightAngles(table("frustum_over_light_angle", rows))


def given_or_fitted(item: Item, scene: Scene, camera: Camera, light: Light, side: int) -> Parameterization:
    """The maps of the body of the frustum, in which nothing is seen."""
    if is_parameterization(item):
        return item
    by_body = item.by_body() if isinstance(item, (Technique, Variant)) else item
    return by_body.parameterize(scene, camera, light, resolution=side)


def outlines(p: Parameterization, camera: Camera, steps: int) -> NDArray[np.float64]:
    """The outline (N, 3) of the frustum; where depth tells which map serves, that of each map's part."""
    parts = p.partitions
    if len(parts) == 1 or p.selection != "depth":
        return outline(camera, steps=steps)
    ends = [part.eye_depth for part in parts]
    found: NDArray[np.float64] = np.concatenate(
        [outline(camera, near=near * (1 + WITHIN), far=far * (1 - WITHIN), steps=steps) for near, far in ends]
    )
    return found


def worst_of_outline(texels: BeamTexels, perspective_ts: Floats) -> dict[str, float]:
    """The numbers of a row: of texels across the beam, and of the same in the image (N, 2).

    Raises
    ------
    ShadowlabError
        Where a map does not hold what it is for.
    """
    missing = int(np.count_nonzero(texels.map < 0))
    if missing:
        raise ShadowlabError(f"{missing} of {texels.map.size} points of the frustum's outline are held by no map")
    of_map = [perspective_ts[texels.map == k] for k in range(texels.maps)]
    in_image = sum(float(lengths.max(axis=0).prod()) for lengths in of_map if len(lengths))
    return {
        "m_s": float(texels.height.max()),
        "m_s_sheared": float(texels.along.max()),
        "m_t": float(texels.across.max()),
        "storage_factor": texels.storage_factor,
        "storage_factor_sheared": texels.storage_factor_sheared,
        "storage_factor_image": in_image * texels.texels_per_pixels,
    }
