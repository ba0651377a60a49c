"""What the scene-optimal experiment looks at: 28 configurations of the scene "statues", and the paper's figures.

Chong and Gortler [chong2007] counted wrong pixels in 28 "typical" configurations of light and camera that they did not
publish. These are fixed ones in their place: two cameras at eye level, one on the upper terrace, one above; five suns
between 7 and 62 degrees of elevation all around, and two spots on masts. They were chosen before anything was counted,
for pictures with shadows in them. They are declared here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..scene.library import names
from ..scene.library import scene as library_scene
from ..scene.view import View
from .views import LabelledView

if TYPE_CHECKING:
    from ..scene.library import LibraryScene
    from ..types import Light

SCENE = "statues"
SIDE_PX = 1024
#: Cameras by name: eye, target (metres, y up), full vertical field of view (degrees).
CAMERAS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float], float]] = MappingProxyType({
    "walk": ((-2.3, 1.7, 28.5), (0.8, 0.9, -8.0), 55.0),
    "stairs": ((8.2, 1.7, 1.0), (-3.5, 0.9, -11.0), 60.0),
    "terrace": ((3.6, 4.1, -24.5), (-1.5, 0.4, 4.0), 58.0),
    "overview": ((24.0, 19.0, 31.0), (-1.0, 0.0, -6.0), 42.0),
})  # fmt: skip
#: Suns by name: azimuth (from +z towards +x) and elevation, degrees.
SUNS: Mapping[str, tuple[float, float]] = MappingProxyType({
    "sunrise": (75.0, 7.0),
    "morning": (110.0, 22.0),
    "noon": (20.0, 62.0),
    "afternoon": (-55.0, 38.0),
    "evening": (-160.0, 13.0),
})  # fmt: skip
#: Spots by name: position, target (metres), full angle of the cone (degrees).
SPOTS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float], float]] = MappingProxyType({
    "mast": ((15.0, 17.0, 10.0), (-1.0, 0.0, 0.0), 95.0),
    "floodlight": ((-19.0, 7.5, -2.0), (4.0, 0.5, 1.0), 100.0),
})  # fmt: skip
#: Ways of three suns that cast shadows towards the viewer of the library scene "dueling".
DUELING_WAYS = ((-0.42, -0.27, 1.0), (0.12, -0.24, 1.0), (0.55, -0.3, 1.0))
NEAR, FAR, RANGE = 0.3, 160.0, 120.0
#: The quick choice: each camera once, under a low sun, a high sun, a sun against the view and a spot.
QUICK = ("walk, morning", "stairs, noon", "terrace, evening", "overview, mast")


def camera_of(name: str) -> _core.Camera:
    """The camera of that name, for square pictures."""
    eye, target, fov_deg = CAMERAS[name]
    return _core.Camera.look_at(eye, target, fov_y=float(np.radians(fov_deg)), aspect=1.0, near=NEAR, far=FAR)


def light_named(name: str) -> Light:
    """The sun or the spot of that name."""
    if name in SUNS:
        azimuth, elevation = np.radians(SUNS[name])
        return _core.DirectionalLight.from_angles(float(azimuth), float(elevation))
    position, target, cone_deg = SPOTS[name]
    way = np.subtract(target, position)
    return _core.SpotLight(position, way, cone_angle=float(np.radians(cone_deg)), range=RANGE)


def configurations(size: int = SIDE_PX, scene: LibraryScene | None = None) -> list[LabelledView]:
    """The 28 configurations, a camera after the other; their labels are "camera, light".

    Parameters
    ----------
    size : int
        Pixels along each side of the pictures.
    scene : Scene, optional
        What is seen; the library scene "statues" with its defaults where none is given.
    """
    shown = library_scene(SCENE) if scene is None else scene
    return [
        LabelledView(View(shown, camera_of(camera), light_named(light), size, f"{camera}, {light}"), camera, light)
        for camera in CAMERAS
        for light in (*SUNS, *SPOTS)
    ]


def quick_configurations(size: int = SIDE_PX, scene: LibraryScene | None = None) -> list[LabelledView]:
    """The four configurations of the quick experiment; arguments as of `configurations`."""
    return [view for view in configurations(size, scene) if view.label in QUICK]


def other_scenes(size: int = SIDE_PX) -> list[LabelledView]:
    """The other scenes of the library, each with its own camera, in square pictures, under its own light."""
    views = []
    for name in names():
        if name != SCENE:
            shown = library_scene(name)
            view = View(shown, shown.camera.replace(aspect=1.0), shown.light, size, name)
            views.append(LabelledView(view, name, "its own"))
    return views


def paper_views(height: int = 512) -> dict[str, View]:
    """The settings of the paper's figures, by the name of the library scene.

    Three lights towards the viewer (figures 3 and 4), a skylight under two lights, and the statues.

    Parameters
    ----------
    height : int
        Pixels from top to bottom; the paper's pictures were 512 pixels high.
    """
    dueling, skylight, statues = (library_scene(name) for name in ("dueling", "skylight", SCENE))
    towards = tuple(_core.DirectionalLight(way) for way in DUELING_WAYS)
    lamps = (skylight.light, library_scene("skylight", spot=1).light)
    lights = {"dueling": (dueling, towards), "skylight": (skylight, lamps), SCENE: (statues, (statues.light,))}
    return {
        name: View(shown, shown.camera, of, (round(height * shown.camera.aspect), height), name)
        for name, (shown, of) in lights.items()
    }
