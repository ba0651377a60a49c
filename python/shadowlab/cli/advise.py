"""The command `shadowlab advise`: which technique at equal memory, over several lights."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from ..errors import ArgumentError
from ..scene.source import NAMED_LIGHT
from .brought import brought_text, light_name
from .command import Command, Option, Options
from .options import (
    check_once,
    directory_option,
    lookup_given,
    lookup_options,
    scene_argument,
    size_given,
    technique_option,
    view_options,
    writable_directory,
)
from .view import chosen_light, given_vectors, load_view, view_text

if TYPE_CHECKING:
    from .._core import Camera, DirectionalLight
    from ..scene.scenes import Scene
    from ..scene.source import Source
    from ..types import Light


def advise_command(options: Options) -> int:
    """Ranks techniques at equal memory over lights, and writes a report, tables, and advice.json with all numbers."""
    from .._core import Renderer
    from ..experiments.advise import advise
    from ..experiments.measures import measure_of, over_of
    from ..experiments.memory import DEFAULT_MEMORY, budgets_of
    from ..reports.terminal import advice_table
    from ..techniques.registry import ALL, technique_of
    from ..text.checks import picture_size

    budgets = budgets_of([text for words in options.memory or [DEFAULT_MEMORY] for text in words.split(",")])
    measure_of(options.error), over_of(options.over)
    for spec in options.technique or ():
        if spec != ALL:
            technique_of(spec)
    check_once("technique", options.technique or ())
    elevations = None if options.lights is None else parse_elevations(options.lights)
    size = size_given(options)
    read = lookup_given(options)
    scene, camera, lights, source = load_views(options, size, elevations)
    size = size or picture_size(camera.aspect)
    renderer = Renderer(options.backend)
    directory = writable_directory(options.out)
    advice = advise(
        scene,
        camera,
        lights,
        memory=budgets,
        techniques=options.technique,
        error=options.error,
        over=options.over,
        size=size,
        renderer=renderer,
        **read,
        source=replace(source, out=options.out),
    )
    if all(one.failure for one in advice.outcomes):
        raise ArgumentError(advice.outcomes[0].failure)
    path = advice.save(directory)
    print(
        f"{source.name} on {advice.backend} ({advice.adapter}), {size[0]} x {size[1]} pixels, by {advice.measure.title}"
    )
    print(f"{view_text(camera, lights, size, source)}{brought_text(scene, source)}\n")
    print(advice_table(advice.standings, advice.measure))
    print(f"\n{advice.verdict}\n\nReport: {path}")
    return 0


def load_views(
    options: Options, size: tuple[int, int] | None, elevations: list[float] | None
) -> tuple[Scene, Camera, list[Light], Source]:
    """Scene, camera, lights and where the scene came from."""
    directions = options.light or []
    if elevations is not None and (directions or options.light_position is not None):
        raise ArgumentError("lights: expected elevations or --light, got both; leave one away")
    check_once("light", directions)
    if options.light_position is not None and len(directions) > 1 and options.cone_deg is None:
        raise ArgumentError("light: expected no direction of a point light, got several; --cone-deg makes them spots")
    first = options.with_(light=directions[0] if directions else None)
    scene, camera, light, source = load_view(first, size)
    names = [light_name(direction) for direction in directions]
    if any(names):
        if not all(names):
            raise ArgumentError("light: expected names or directions, got both; give all of one kind")
        more_names = tuple((NAMED_LIGHT, name) for name in names[1:] if name is not None)
        source = replace(source, given=source.given + more_names)
    if elevations is not None:
        # Their directions are not the one that fits the scene.
        source = replace(source, given=tuple(one for one in source.given if one[0] != "light"))
        return scene, camera, [elevated(light, camera, angle) for angle in elevations], source
    more = [options.with_(light=direction) for direction in directions[1:]]
    others = [chosen_light(one, given_vectors(one), light, scene) for one in more]
    return scene, camera, [light, *others], source


def parse_elevations(text: str) -> list[float]:
    """Angles in radians of `10,35,70` degrees.

    Raises
    ------
    ArgumentError
        For anything but numbers from 0 to 90, or one that comes twice.
    """
    wrong = f"lights: expected elevations from 0 to 90 degrees, such as 10,35,70, got {text!r}"
    try:
        angles = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise ArgumentError(wrong) from None
    if not angles or not all(0 <= angle <= 90 for angle in angles):
        raise ArgumentError(wrong)
    if len(set(angles)) < len(angles):
        raise ArgumentError(f"lights: an elevation comes twice in {text!r}; give each once")
    return [math.radians(angle) for angle in angles]


def elevated(light: Light, camera: Camera, elevation: float) -> DirectionalLight:
    """A directional light of this elevation in radians, and the azimuth of another; from the side of one overhead."""
    import numpy as np

    from .._core import DirectionalLight

    direction = np.asarray(getattr(light, "direction", (0.0, -1.0, 0.0)), np.float64)
    level = direction * (1.0, 0.0, 1.0)
    length = float(np.linalg.norm(level))
    # A light that stands overhead to within rounding has no azimuth.
    if length <= np.sqrt(np.finfo(np.float64).eps):
        level = np.asarray(camera.right, np.float64) * (1.0, 0.0, 1.0)
        length = float(np.linalg.norm(level)) or 1.0
    return DirectionalLight(math.cos(elevation) * level / length - (0.0, math.sin(elevation), 0.0))


_LIGHTS = "Lights; one that fits the scene where none is given"
ADVISE = Command(
    "advise",
    advise_command,
    [
        scene_argument(),
        Option("--memory", multiple=True, metavar="SIZE[,SIZE...]", help="such as 4MiB or 4MiB,16MiB (default: 4MiB)"),
        technique_option(
            'repeat for several; "all" for every technique that serves the light; preset:NAME for what an engine '
            "ships (default: every technique that serves the lights, with its settings that matter)"
        ),
        Option(
            "--error",
            default="misclassified",
            metavar="NAME",
            help="what is ranked by: misclassified, worst (one pixel decides it: p95 is the one to use), p95, mean, "
            "undersampled, perspective (default: misclassified)",
        ),
        Option("--over", default="mean", metavar="mean|worst", help="how views are put together (default: mean)"),
        *lookup_options(),
        directory_option("advice", "report.html, advice.csv, advice.json and the rest"),
        Option(
            "--light",
            section=_LIGHTS,
            multiple=True,
            metavar="DX,DY,DZ|NAME",
            help="the way a directional light or the middle of a spot travels, or a light of the file, by its name; "
            "repeat for several",
        ),
        Option(
            "--lights",
            "--lights-deg",
            "lights",
            section=_LIGHTS,
            metavar="DEG[,DEG...]",
            help="elevations of a directional light, degrees from 0 to 90, in the azimuth of the one that fits the "
            "scene",
        ),
        *view_options(),
    ],
)
