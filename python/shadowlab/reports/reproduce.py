"""How to get a run again: the Python that does it, and the command line where it can say it.

Numbers are written with all their digits, so that what is run again is what was run.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._core import Bias, Stored
from ..errors import ShadowlabError
from ..scene.source import NAMED_CAMERA, NAMED_LIGHT, OF_NAMED_CAMERAS
from ..techniques.kinds import is_parameterization
from ..techniques.registry import technique_of
from ..techniques.variant import MapReading
from ..text import BIAS, format_bias, format_spec, format_value

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Bias, Camera, Parameterization, Partition
    from ..experiments.run import Run
    from ..experiments.study import Study
    from ..scene.source import Source
    from ..types import Light


def numbers(values: npt.ArrayLike) -> str:
    """Floats with all their digits, between commas."""
    return ", ".join(repr(float(v) + 0.0) for v in np.asarray(values, dtype=np.float64).ravel())


def camera_target(camera: Camera) -> np.ndarray:
    """A point straight ahead, at the far plane where that is before the eye: rounding turns the view least."""
    # Parallel rays may begin and end behind the eye, and an infinite far plane is no place.
    last = camera.far if np.isfinite(camera.far) else 1e3 * camera.near
    ahead = max(last, -camera.near, camera.height) if camera.is_orthographic else last
    target: np.ndarray = np.asarray(camera.eye) + ahead * np.asarray(camera.forward)
    return target


def camera_python(camera: Camera) -> str:
    """A line that makes the camera."""
    made, lens = ("orthographic", "height") if camera.is_orthographic else ("look_at", "fov_y")
    far = repr(camera.far) if np.isfinite(camera.far) else 'float("inf")'
    shift = f", shift={camera.shift}" if any(camera.shift) else ""
    return (
        f"camera = sl.Camera.{made}(({numbers(camera.eye)}), ({numbers(camera_target(camera))}),\n"
        f"    up=({numbers(camera.up)}),\n"
        f"    {lens}={getattr(camera, lens)!r}, aspect={camera.aspect!r}, near={camera.near!r}, far={far}{shift})"
    )


def light_python(light: Light) -> str:
    """A line that makes the light."""
    if light.kind == "directional":
        return f"light = sl.DirectionalLight(({numbers(light.direction)}))"
    if light.kind == "spot":
        return (
            f"light = sl.SpotLight(({numbers(light.position)}), ({numbers(light.direction)}),\n"
            f"    cone_angle={light.cone_angle!r}, range={light.range!r})"
        )
    return f"light = sl.PointLight(({numbers(light.position)}), range={light.range!r})"


def technique_python(run: Run) -> str:
    """An expression that makes the technique of a run, every setting spelled out."""
    if is_parameterization(run.item):
        return given_python(run.item)
    keywords = "".join(f", {key}={value!r}" for key, value in run.settings.items())
    return f"sl.technique({run.technique!r}{keywords})"


def given_python(p: Parameterization) -> str:
    """An expression that makes a parameterization of somebody else's matrices, with what it knows beside them."""
    blocks = [",\n        ".join(f"[{numbers(row)}]" for row in m) for m in np.asarray(p.matrices)]
    parts, more = p.partitions, ""
    if any(part.post_warp != "none" for part in parts):
        more += f",\n        post_warp={[post_warp(part) for part in parts]!r}"
    if any(len(part.region) for part in parts):
        more += f",\n        regions={[np.asarray(part.region).tolist() for part in parts]!r}"
    if len(blocks) == 1 and parts[0].eye_depth == (0.0, np.inf):
        return f"sl.Parameterization.from_matrix(np.array([\n        {blocks[0]}]){more})"
    stack = ",\n        ".join(f"[{block}]" for block in blocks)
    depths = ", ".join(f"({part.eye_depth[0]!r}, {far_python(part.eye_depth[1])})" for part in parts)
    return (
        f"sl.Parameterization.from_matrix(np.array([\n        {stack}]),\n"
        f"        eye_depth=[{depths}], selection={p.selection!r}{more})"
    )


def post_warp(part: Partition) -> tuple[object, ...] | None:
    """What follows the matrix of a map, as `Parameterization.from_matrix` takes it, in numbers and lists."""
    if part.post_warp_knots is not None:
        return (part.post_warp, *(knots.tolist() for knots in part.post_warp_knots))
    terms = part.post_warp_terms
    return (part.post_warp, terms["scale"], terms["offset"]) if terms else None


def far_python(depth: float) -> str:
    """An expression that makes a depth, which may be infinite."""
    return repr(depth) if np.isfinite(depth) else "float('inf')"


def technique_text(run: Run) -> str | None:
    """The command line's text of a run's technique; None for a matrix that is in no file."""
    if not run.given:
        return format_spec(run.technique, run.settings)
    if not run.label.startswith("matrix:"):
        return None
    try:
        again = technique_of(run.label)
    except ShadowlabError:
        return None
    p = run.item
    if not (is_parameterization(p) and is_parameterization(again)):
        return None
    same = np.array_equal(again.matrices, p.matrices) and again.selection == p.selection
    same = same and all(
        (a.eye_depth, post_warp(a)) == (b.eye_depth, post_warp(b)) and np.array_equal(a.region, b.region)
        for a, b in zip(again.partitions, p.partitions, strict=True)
    )
    return run.label if same else None


def light_arguments(light: Light, up: str) -> list[str]:
    """The command line's options that make a light, a word each."""
    words = []
    if light.kind != "point":
        words.append(f"--light={own_numbers(light.direction, up)}")
    if light.kind != "directional":
        words.append(f"--light-position={own_numbers(light.position, up)}")
        words.append(f"--range={format_value(light.range)}")
    if light.kind == "spot":
        words.append(f"--cone-deg={format_value(float(np.degrees(light.cone_angle)))}")
    return words


def own_numbers(vector: npt.ArrayLike, up: str) -> str:
    """A world vector for the command line, in the axes of the file."""
    return numbers(in_file_axes(vector, up)).replace(" ", "")


def bias_python(bias: Bias) -> str:
    """An expression that makes the bias."""
    limit = "float('inf')" if np.isinf(bias.slope_limit) else repr(bias.slope_limit)
    parts = (f"{name}={limit if name == 'slope_limit' else repr(getattr(bias, name))}" for name in BIAS)
    return f"sl.Bias({', '.join(parts)})"


def reading_python(read: MapReading) -> str:
    """Keyword arguments that say how maps are read."""
    blend = f", blend={read.blend!r}" if read.blend else ""
    stored = "" if read.stored == Stored() else f", stored={str(read.stored)!r}"
    return f"bias={bias_python(read.bias)}, filter={read.filter!r}{blend}{stored}"


def python_snippet(study: Study, runs: Sequence[Run]) -> str:
    """A script that computes these runs again."""
    techniques = dict.fromkeys((run.label, technique_python(run)) for run in runs)
    entries = "".join(f"    {label!r}: {made},\n" for label, made in techniques)
    resolutions = sorted({run.resolution for run in runs})
    resolution = resolutions[0] if len(resolutions) == 1 else resolutions
    numpy_line = "import numpy as np\n" if any(run.given for run in runs) else ""
    return (
        f"{numpy_line}import shadowlab as sl\n\n"
        f"{study.source.python}\n{camera_python(study.camera)}\n{light_python(study.light)}\n"
        f"study = sl.compare(scene, camera, light, {{\n{entries}}},\n"
        f"    resolution={resolution}, size={study.size}, renderer=sl.Renderer({study.backend!r}),\n"
        f"    {reading_python(study.read)},\n"
        f"    truth={study.truth is not None})\n"
        "print(study)"
    )


def command_line(study: Study, runs: Sequence[Run]) -> str | None:
    """The command that computes these runs again; None where it cannot say what the study was."""
    source, camera = study.source, study.camera
    level = abs(float(np.asarray(camera.right)[1])) <= 4 * np.finfo(np.float64).eps  # a rolled camera has no option
    sayable = source.arguments and (level or NAMED_CAMERA in dict(source.given)) and study.truth is not None
    aspect = study.size[0] / study.size[1]
    square = abs(camera.aspect - aspect) <= 4 * np.finfo(np.float64).eps * aspect
    specs = dict.fromkeys(technique_text(run) for run in runs)
    if not (sayable and square) or None in specs:
        return None

    words = ["shadowlab", "compare", *source.arguments]
    for spec in specs:
        words += ["--technique", str(spec)]
    words += view_arguments(camera, [study.light], study.size, source)
    words += ["--resolution", ",".join(str(r) for r in sorted({run.resolution for run in runs}))]
    words += ["--backend", study.backend]
    if study.filter != "nearest":
        words += ["--filter", study.filter]
    if study.blend:
        words += ["--blend", repr(study.blend)]
    if study.stored != Stored():
        words += ["--stored", str(study.stored)]
    if study.bias != Bias():
        words += ["--bias", format_bias(study.bias)]
    if source.out:
        # Some of the runs again: beside the report of all of them, not over it.
        words += ["--out", source.out if len(runs) == len(study.runs) else str(Path(source.out) / "again")]
    return shlex.join(words)


def camera_arguments(camera: Camera, up: str) -> list[str]:
    """The command line's options that make a camera."""
    lens = (
        ("--ortho-height", format_value(camera.height))
        if camera.is_orthographic
        else ("--fov-deg", format_value(float(np.degrees(camera.fov_y))))
    )
    return [
        f"--eye={own_numbers(camera.eye, up)}",
        f"--target={own_numbers(camera_target(camera), up)}",
        *lens,
        # Beside the name: a depth of an orthographic camera may be negative.
        *((f"--near={format_value(camera.near)}",) if camera.near < 0 else ("--near", format_value(camera.near))),
        *((f"--far={format_value(camera.far)}",) if camera.far < 0 else ("--far", format_value(camera.far))),
        *((f"--shift={numbers(camera.shift).replace(' ', '')}",) if any(camera.shift) else ()),
    ]


def view_arguments(camera: Camera, lights: Sequence[Light], size: tuple[int, int], source: Source) -> list[str]:
    """The command line's options that make a camera, one or several lights, and the size of the picture.

    Vectors that were given stand as they were given, cameras and lights of the file by their names.
    """
    given = dict(source.given)
    if NAMED_CAMERA in given:
        words = [f"--camera={given[NAMED_CAMERA]}"]
        words += [f"--{name}={given[name]}" for name in OF_NAMED_CAMERAS if name in given]
    else:
        words = camera_arguments(camera, source.up)
    names = [text for name, text in source.given if name == NAMED_LIGHT]
    if len(names) == len(lights):
        words += [f"--light={name}" for name in names]
    else:
        # Spots of one lamp share their position.
        words += dict.fromkeys(word for light in lights for word in light_arguments(light, source.up))
    as_given = {f"--{name}": text for name, text in source.given if name != "light" or len(lights) == 1}
    heads = [word.partition("=")[0] for word in words]
    words = [f"{head}={as_given[head]}" if head in as_given else word for head, word in zip(heads, words, strict=True)]
    return [*words, "--size", f"{size[0]}x{size[1]}"]


def in_file_axes(vector: npt.ArrayLike, up: str) -> np.ndarray:
    """A world vector in the axes of its file, which the command line speaks; a z-up file was turned when loaded."""
    x, y, z = np.asarray(vector, dtype=np.float64)
    return np.array([x, -z, y] if up == "z" else [x, y, z])
