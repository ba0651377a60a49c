"""The view on the command line: scene, camera and light, the same for every command that takes them.

Vectors and points are in the axes of the file. What is not given is chosen to fit the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..errors import ArgumentError
from ..scene.source import NAMED_CAMERA, NAMED_LIGHT, OF_NAMED_CAMERAS
from ..text import parse_pair, parse_vector
from .brought import camera_named, light_name, named_camera, named_light
from .command import Options

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from .._core import Camera
    from ..scene.scenes import Scene
    from ..scene.source import Source
    from ..types import Light


def load_part(options: Options) -> Scene:
    """The scene of the library or of a file, without a floor."""
    from ..scene import library
    from ..scene.files import load_scene

    if not options.scene.startswith("@"):
        return load_scene(options.scene, up=options.up)
    if options.up not in (None, "y"):
        raise ArgumentError("up: scenes of the library have y up; leave --up away")
    return library.scene_of_spec(options.scene)


def load_view(
    options: Options, size: tuple[int, int] | None, part: Scene | None = None
) -> tuple[Scene, Camera, Light, Source]:
    """Scene, camera, light and where they came from.

    Without a size the camera of a library scene keeps its aspect, and the pictures of others are 16:9. `part` is the
    scene where it has been loaded.
    """
    from ..reports.reproduce import own_numbers
    from ..scene import library
    from ..scene.default_view import WIDE_ASPECT, default_viewpoint
    from ..scene.source import Source
    from ..text.checks import VIEWS, picture_size

    given = given_vectors(options)
    part = load_part(options) if part is None else part
    own = part if isinstance(part, library.LibraryScene) and options.view is None else None
    of_file = None if options.camera is None else camera_named(options, part)
    brought = of_file if of_file is not None else own.camera if own is not None else None
    # The aspect is that of the picture, so that its pixels are square.
    width, height = size or picture_size(WIDE_ASPECT if brought is None else brought.aspect)
    aspect = width / height
    whole = part.with_ground() if options.ground else part
    vectors = ("eye", "target", "light", "light-position")
    texts = {name: getattr(options, name.replace("-", "_")) for name in vectors}
    as_given = {name: ",".join(text.replace(",", " ").split()) for name, text in texts.items() if text is not None}
    if light_name(options.light) is not None:
        as_given[NAMED_LIGHT] = options.light
        del as_given["light"]
    aimed = bool({"eye", "target"} & as_given.keys())
    taken = "own"
    if own is not None:
        camera: Camera = own.camera
        light: Light = own.light
    else:
        # The floor is twelve times as wide as the object: the picture is of the object.
        chosen = default_viewpoint(whole, aspect=aspect, focus=part, view=options.view or VIEWS[0])
        camera, light = chosen.camera(aspect), chosen.sun
        taken = chosen.name
        # In the numbers that it was made of, so that its texts make the same view.
        words = {"eye": chosen.eye, "target": chosen.target, "light": chosen.light}
        if aimed:
            del words["target"]
        if {"light", "light-position", NAMED_LIGHT} & as_given.keys():
            del words["light"]
        as_given = {name: own_numbers(vector, options.up or "y") for name, vector in words.items()} | as_given
    if of_file is not None:
        lens = {name: getattr(options, name.replace("-", "_")) for name in OF_NAMED_CAMERAS}
        as_given = {name: text for name, text in as_given.items() if name not in ("eye", "target")}
        as_given[NAMED_CAMERA] = options.camera
        as_given |= {name: str(value) for name, value in lens.items() if value is not None}
    extra = (*(("--up", options.up) if options.up else ()), *(("--ground",) if options.ground else ()))
    source = replace(
        Source.of_scene(whole),
        arguments=(options.scene, *extra),
        up=options.up or "y",
        given=tuple(as_given.items()),
        view="" if aimed or of_file is not None else taken,
    )
    if of_file is not None:
        taken_camera = named_camera(options, part, aspect)
    else:
        taken_camera = chosen_camera(options, given, camera, whole, aspect)
    return whole, taken_camera, chosen_light(options, given, light, whole), source


def view_text(camera: Camera, lights: Sequence[Light], size: tuple[int, int], source: Source) -> str:
    """Which view was taken, and the options that repeat it."""
    import shlex

    from ..reports.reproduce import view_arguments
    from ..text.checks import VIEWS

    others = " or ".join(f"--view {name}" for name in VIEWS if name != source.view)
    named = {
        "": "as given, the rest chosen for the scene",
        "own": f"that of the scene; {others} for another",
    }
    what = named.get(source.view, f"{source.view}, chosen for the scene; {others} for another")
    return f"View: {what}. These options repeat it:\n  {shlex.join(view_arguments(camera, lights, size, source))}"


def given_vectors(options: Options) -> dict[str, npt.NDArray[np.float64]]:
    """Eye, target and light as given, in the world's axes."""
    from ..scene.axes import turned

    names = [name for name in ("eye", "target", "light", "light_position") if getattr(options, name) is not None]
    if light_name(options.light) is not None:
        names.remove("light")
    vectors = {name: parse_vector(getattr(options, name), name.replace("_", "-")) for name in names}
    if "light" in vectors and not any(vectors["light"]):
        raise ArgumentError(f"light: expected a direction, got {options.light!r}; give the way the light travels")
    return {name: turned(vector, up=options.up or "y") for name, vector in vectors.items()}


def chosen_camera(
    options: Options, given: dict[str, npt.NDArray[np.float64]], fitting: Camera, scene: Scene, aspect: float
) -> Camera:
    """The fitting camera with everything that was given in its place."""
    import numpy as np

    from .._core import Camera
    from ..scene.framing import INSIDE_DEPTH_RATIO, fitting_depths

    eye = given.get("eye", fitting.eye)
    middle = np.asarray(scene.bounds).mean(axis=0) if "eye" in given else fitting.eye + fitting.far * fitting.forward
    target = given.get("target", middle)
    near, far = fitting.near, fitting.far
    ahead = np.asarray(target) - np.asarray(eye)
    length = float(np.linalg.norm(ahead))
    if given.keys() & {"eye", "target"} and np.isfinite(length) and length > 0:
        near, far = fitting_depths(scene, eye, ahead / length)
    if options.far is not None:
        far = options.far
        # A far plane before the fitting near plane still leaves a picture; one that is no distance is said as it is.
        near = min(near, far / INSIDE_DEPTH_RATIO) if 0 < far < np.inf else near
    near = near if options.near is None else options.near
    if options.fov_deg is not None and not 0 < options.fov_deg < 180:
        raise ArgumentError(f"fov-deg: expected degrees above 0 and below 180, got {options.fov_deg:g}; try 50")
    if options.fov_deg is not None and options.ortho_height is not None:
        raise ArgumentError(
            "ortho-height: expected none beside --fov-deg, got both; an orthographic camera has no angle"
        )
    fov_y = fitting.fov_y if options.fov_deg is None else float(np.radians(options.fov_deg))
    shift = (0.0, 0.0) if options.shift is None else parse_pair(options.shift, "shift")
    aimed = bool(given.keys() & {"eye", "target"})
    # Straight down or up there is no horizon to level: another up is chosen, with a warning.
    up = None if aimed else fitting.up
    if options.ortho_height is not None:
        ahead_of_eye = target if aimed else fitting.eye + fitting.forward
        height = options.ortho_height
        if not 0 < height < np.inf:
            raise ArgumentError(f"ortho-height: expected a finite length above 0, got {height:g}; give world units")
        return Camera.orthographic(eye, ahead_of_eye, up, height=height, aspect=aspect, near=near, far=far, shift=shift)
    if not aimed:
        return fitting.replace(fov_y=fov_y, aspect=aspect, near=near, far=far, shift=shift)
    return Camera.look_at(eye, target, up=up, fov_y=fov_y, aspect=aspect, near=near, far=far, shift=shift)


def chosen_light(options: Options, given: dict[str, npt.NDArray[np.float64]], fitting: Light, scene: Scene) -> Light:
    """The light that was given or named, or the fitting one: a point light at a position, a spot with a cone."""
    import numpy as np

    from .._core import DirectionalLight, PointLight, SpotLight

    named = named_light(options, scene)
    if named is not None:
        return named
    if "light_position" not in given:
        for name, value in (("range", options.range), ("cone-deg", options.cone_deg)):
            if value is not None:
                raise ArgumentError(f"{name}: expected a light with a place, got none; give --light-position x,y,z")
        return DirectionalLight(given["light"]) if "light" in given else fitting
    position = np.asarray(given["light_position"], dtype=np.float64)
    bounds = np.asarray(scene.bounds)
    # The farthest corner of the scene's box.
    with np.errstate(over="ignore"):
        reach = float(np.linalg.norm(np.abs(bounds - position).max(axis=0))) if options.range is None else options.range
    if options.range is None and not np.isfinite(reach):
        raise ArgumentError(
            f"light-position: expected a place from which a light can reach the scene, got {options.light_position}; "
            "move it nearer, or give --range"
        )
    if options.cone_deg is None:
        if "light" in given:
            raise ArgumentError(
                "light: expected no direction of a point light, which shines everywhere, got one; "
                "--cone-deg makes it a spot"
            )
        return PointLight(position, range=reach)
    if not 0 < options.cone_deg < 180:
        raise ArgumentError(f"cone-deg: expected degrees above 0 and below 180, got {options.cone_deg:g}; try 60")
    direction = given.get("light", bounds.mean(axis=0) - position)
    return SpotLight(position, direction, cone_angle=float(np.radians(options.cone_deg)), range=reach)
