"""Views of a scene that brings none: a camera and a light that fit it.

Three of them, by name:

along     at eye level, with the light from the side: in a place (a town, a terrain, a hall) the eye of somebody who
          stands in it and looks along its long side, before a thing one that sees it whole from a little above
above     the whole scene from above at a three-quarter angle, with the light from the side
against   as along, with the light from ahead

Their numbers are rounded to a few digits before anything is made of them, so that short texts repeat them exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .._core import Camera, DirectionalLight
from ..errors import ArgumentError
from ..text import shown
from ..text.checked import A_SCENE, a_length, a_word
from ..text.checks import VIEWS, check_scene, picture_size
from .columns import Coordinates, Surfaces
from .framing import (
    FOV_Y_RAD,
    bounds_above,
    corners_of_box,
    depth_range,
    framing_of,
    height_share,
    is_point,
    padded_bounds,
)
from .place import place_in
from .standing import Stand, best_stand, planes_of, sun_of
from .sunlight import AHEAD_ANGLES, AHEAD_RAD, SIDE_ANGLES, SIDE_RAD, side_light
from .view import View

if TYPE_CHECKING:
    from .._core import Scene
    from ..types import ViewName

#: Of pictures whose shape nobody chose.
WIDE_ASPECT = 16 / 9
# Of a picture as wide as renderers draw and one pixel high.
WIDEST_ASPECT = 16384

# How high eyes are that look at a thing or at a whole scene: from a little above, and from high above; each over things
# at least half as high as wide and over flat ones, of which more of the ground is seen from higher up.
BESIDE_RAD = (math.radians(14.0), math.radians(35.0))
ABOVE_RAD = (math.radians(27.0), math.radians(40.0))
# Steps that numbers are rounded to, as powers of ten below the distance of what is looked at: a ten-thousandth turns
# a view by less than a fifth of a pixel.
STEP_EXPONENT = -4
# Digits of a direction of light, a twentieth of a degree; digits of near and far.
LIGHT_DIGITS, PLANE_DIGITS = 3, 3


@dataclass(frozen=True)
class Viewpoint:
    """A view as the few numbers that it is made of, in world units and degrees."""

    name: str
    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    near: float
    far: float
    light: tuple[float, float, float]

    def camera(self, aspect: float) -> Camera:
        """The camera, for a picture of this aspect."""
        return Camera.look_at(
            self.eye, self.target, up=(0.0, 1.0, 0.0), fov_y=FOV_Y_RAD, aspect=aspect, near=self.near, far=self.far
        )

    @property
    def sun(self) -> DirectionalLight:
        """The light."""
        return DirectionalLight(self.light)


def default_views(scene: Scene, *, aspect: float = WIDE_ASPECT, focus: Scene | None = None) -> tuple[View, ...]:
    """The three views that are chosen for a scene, each with its camera and light, labelled with its name.

    Parameters
    ----------
    scene : Scene
        Its y axis points up. Any scale, flat or a single triangle.
    aspect : float
        Width by height of the pictures, which have about 1024 * 1024 pixels.
    focus : Scene, optional
        As of `default_view`.

    Returns
    -------
    tuple of View
        "along": at eye level, along the scene's long side, with the light from the side; "above": the whole scene from
        above, or from under the roof of a place that has one; "against": as "along", with the light from ahead. In a
        hall that is dark under such light, it comes from where it enters.

    Raises
    ------
    ArgumentError
        As `default_view`.

    Examples
    --------
    >>> import shadowlab as sl
    >>> along, above, against = sl.default_views(sl.library.scene("dueling"))
    >>> above.label, along.size, along.camera == against.camera
    ('above', (1360, 765), True)
    """
    around = surroundings_of(scene, focus, aspect)
    views = [viewpoint_in(around, name) for name in VIEWS]
    size = picture_size(around.aspect)
    return tuple(View(scene, one.camera(around.aspect), one.sun, size, one.name) for one in views)


def default_view(
    scene: Scene, *, aspect: float = WIDE_ASPECT, focus: Scene | None = None, view: ViewName = "along"
) -> tuple[Camera, DirectionalLight]:
    """A camera and a directional light that fit a scene.

    In a place, such as a town, a terrain or a hall, the camera stands at eye level: 1.7 over the ground where the
    scene's proportions suggest metres, else at a share of what stands there. A thing is seen whole.

    Parameters
    ----------
    scene : Scene
        Its y axis points up. Any scale, flat or a single triangle.
    aspect : float
        Width by height of the picture.
    focus : Scene, optional
        The part that the picture is of, such as an object without its ground; the far plane still reaches all of
        `scene`. The whole scene where none is given.
    view : {"along", "above", "against"}
        Which of the `default_views`.

    Returns
    -------
    (Camera, DirectionalLight)

    Raises
    ------
    ArgumentError
        For an aspect that is not a finite number above 0, or something else than a scene.
    UnknownNameError
        For another name of a view.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> camera, light = sl.default_view(scene, view="above")
    >>> bool(camera.eye[1] > 1), bool(light.direction[1] < 0)
    (True, True)
    """
    chosen = default_viewpoint(scene, aspect=aspect, focus=focus, view=view)
    return chosen.camera(aspect), chosen.sun


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A scene, the part of it that pictures are of, and where somebody stands in it, if anybody can.

    What of a thing is higher than `above` is seen whole.
    """

    scene: Scene
    part: Scene
    aspect: float
    surfaces: Surfaces
    above: float
    stand: Stand | None
    roofed: bool


def default_viewpoint(scene: Scene, *, aspect: float, focus: Scene | None, view: ViewName) -> Viewpoint:
    """The numbers of a view; arguments and errors as of `default_view`."""
    a_word(VIEWS, "along is at eye level")("view", view)
    return viewpoint_in(surroundings_of(scene, focus, aspect), view)


def surroundings_of(scene: Scene, focus: Scene | None, aspect: float) -> Surroundings:
    """What all views of a scene share; errors as of `default_view`."""
    check_scene(scene)
    aspect = a_length("aspect", aspect)
    if not 1 / WIDEST_ASPECT <= aspect <= WIDEST_ASPECT:
        raise ArgumentError(f"aspect: expected 1 / {WIDEST_ASPECT} to {WIDEST_ASPECT}, got {shown(aspect)}; try 16 / 9")
    if focus is not None:
        A_SCENE("focus", focus)
    part = scene if focus is None else focus
    surfaces = Surfaces(scene)
    place, above = place_in(surfaces if part is scene else Surfaces(part))
    if above > -math.inf and is_point(bounds_above(part, above), np.asarray(part.bounds)):
        above = -math.inf  # what stands on the floor has no outline: the picture is of the floor, too
    stand = None if place is None else best_stand(place, surfaces, aspect)
    return Surroundings(scene, part, aspect, surfaces, above, stand, place is not None and math.isfinite(place.room))


def viewpoint_in(around: Surroundings, view: ViewName) -> Viewpoint:
    """The numbers of a view of a scene."""
    stand, surfaces, aspect = around.stand, around.surfaces, around.aspect
    # A roof hides a place from above: the eye is then under it.
    if stand is None or (view == "above" and not around.roofed):
        return whole_view(around, view)
    sun = sun_of(stand, surfaces, aspect, AHEAD_ANGLES if view == "against" else SIDE_ANGLES)
    stand = stand.raised() if view == "above" else stand
    near, far = planes_of(stand, surfaces, aspect)
    # By the eye's height, not by the length of the place: what is nearest is about as far away as the ground.
    return rounded(view, stand.eye, stand.eye + far * stand.forward, near, far, sun.way, stand.height)


def whole_view(around: Surroundings, view: ViewName) -> Viewpoint:
    """A view that holds the part whole."""
    scene, part, above = around.scene, around.part, around.above
    bounds = bounds_above(part, above)
    high, flat = ABOVE_RAD if view == "above" else BESIDE_RAD
    found = framing_of(part, flat + (high - flat) * height_share(bounds), around.aspect, above)
    _, up, forward = found.axes
    # A floor around what is framed: the planes hold it, too.
    whole = found.outline if part is scene and above == -math.inf else corners_of_box(padded_bounds(scene))
    near, far = depth_range(whole, found.outline, found.eye, up, forward, FOV_Y_RAD)
    reach = float((found.outline.mean(axis=0) - found.eye) @ forward)
    way = side_light(forward, bounds, AHEAD_RAD if view == "against" else SIDE_RAD)
    return rounded(view, found.eye, found.eye + reach * forward, near, far, way, reach)


def rounded(
    view: str, eye: Coordinates, target: Coordinates, near: float, far: float, way: Coordinates, distance: float
) -> Viewpoint:
    """The view with numbers of few digits, by the distance of what is looked at."""
    step = exponent_of(distance) + STEP_EXPONENT
    far_step = exponent_of(float(np.linalg.norm(target - eye))) + STEP_EXPONENT
    near_step, end_step = (exponent_of(plane) + 1 - PLANE_DIGITS for plane in (near, far))
    return Viewpoint(
        view,
        rounded_point(eye, -step),
        rounded_point(target, -far_step),
        # Towards the eye and away from it, so that they hold what they held.
        round(math.floor(near / 10.0**near_step) * 10.0**near_step, -near_step),
        round(math.ceil(far / 10.0**end_step) * 10.0**end_step, -end_step),
        rounded_point(way, LIGHT_DIGITS),
    )


def exponent_of(value: float) -> int:
    """The power of ten of its first digit."""
    return math.floor(math.log10(value))


def rounded_point(point: Coordinates, digits: int) -> tuple[float, float, float]:
    """Three numbers with this many digits after the point, and no negative zero."""
    x, y, z = (round(float(v), digits) + 0.0 for v in point)
    return x, y, z
