"""How to get a run or a row of an advice again: the Python that does it, and the command line where it can say it.

Numbers are written with all their digits, so that what is run again is what was run.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import Bias
from ..errors import ArgumentError, ShadowlabError
from ..experiments.candidates import Candidate
from ..experiments.memory import memory_text
from ..experiments.views import LabelledView
from ..techniques.labels import is_parameterization
from ..techniques.registry import technique_of
from ..text import format_bias, format_spec, format_value, shown

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Bias, Camera, Parameterization, Partition
    from ..experiments.advise import Advice
    from ..experiments.compare import Study
    from ..experiments.run import Run
    from ..scene.source import Source
    from ..types import Light


def numbers(values: npt.ArrayLike) -> str:
    """Floats with all their digits, between commas."""
    return ", ".join(repr(float(v) + 0.0) for v in np.asarray(values, dtype=np.float64).ravel())


def camera_target(camera: Camera) -> np.ndarray:
    """A point in the middle of the view, at the far plane, where rounding of the sum turns the view least."""
    target: np.ndarray = np.asarray(camera.eye) + camera.far * np.asarray(camera.forward)
    return target


def camera_python(camera: Camera) -> str:
    """A line that makes the camera."""
    return (
        f"camera = sl.Camera.look_at(({numbers(camera.eye)}), ({numbers(camera_target(camera))}),\n"
        f"    up=({numbers(camera.up)}),\n"
        f"    fov_y={camera.fov_y!r}, aspect={camera.aspect!r}, near={camera.near!r}, far={camera.far!r})"
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


def post_warp(part: Partition) -> tuple[str, float, float] | None:
    """What follows the matrix of a map, as `Parameterization.from_matrix` takes it."""
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
    parts = f"world={bias.world!r}, texels={bias.texels!r}, ndc={bias.ndc!r}, slope={bias.slope!r}"
    return f"sl.Bias({parts}, slope_limit={limit})"


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
        f"    bias={bias_python(study.bias)}, filter={study.filter!r}, truth={study.truth is not None})\n"
        "print(study)"
    )


def command_line(study: Study, runs: Sequence[Run]) -> str | None:
    """The command that computes these runs again; None where it cannot say what the study was."""
    source, camera = study.source, study.camera
    level = abs(float(np.asarray(camera.right)[1])) <= 4 * np.finfo(np.float64).eps  # a rolled camera has no option
    sayable = source.arguments and level and study.truth is not None
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
    if study.bias != Bias():
        words += ["--bias", format_bias(study.bias)]
    if source.out:
        # Some of the runs again: beside the report of all of them, not over it.
        words += ["--out", source.out if len(runs) == len(study.runs) else str(Path(source.out) / "again")]
    return shlex.join(words)


def view_arguments(camera: Camera, lights: Sequence[Light], size: tuple[int, int], source: Source) -> list[str]:
    """The command line's options that make a camera, one or several lights, and the size of the picture.

    Vectors that were given stand as they were given.
    """
    words = [
        f"--eye={own_numbers(camera.eye, source.up)}",
        f"--target={own_numbers(camera_target(camera), source.up)}",
        *("--fov-deg", format_value(float(np.degrees(camera.fov_y)))),
        *("--near", format_value(camera.near), "--far", format_value(camera.far)),
    ]
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


def snippet_of(advice: Advice, row: object) -> str:
    """The Python that computes a row of the table, a row of the runs, or a choice again.

    Raises
    ------
    ArgumentError
        For something that is no such row, or one without a number.
    """
    candidate, memory, label = row_key(advice, row)
    views = [view for view in advice.counted if label is None or view.label == label]
    of = [o for o in advice.outcomes if (o.candidate, o.memory) == (candidate, memory)]
    of = [o for o in of if o.view.label in {view.label for view in views}]
    if not of or any(o.error is None for o in of):
        reason = next((o.failure for o in of if o.failure), "nothing was measured")
        raise ArgumentError(f"row: expected one with a number, got one that failed: {reason}")
    chosen = next(one for one in advice.candidates if one.label == candidate)
    return advice_snippet(advice, chosen, int(of[0].resolution or 0), views)


def row_key(advice: Advice, row: object) -> tuple[str, int, str | None]:
    """Candidate, budget and view (None for all) of what stands for a row."""
    hint = "expected a row of .table or .runs, its position in .table, or a choice"
    if isinstance(row, (int, np.integer)) and not isinstance(row, (bool, np.bool_)):
        ranking = advice.standings
        if not 0 <= row < len(ranking):
            raise ArgumentError(f"row: expected a position from 0 to {len(ranking) - 1}, got {row}")
        return ranking[row].candidate, ranking[row].memory, None
    get: Any = row.get if hasattr(row, "get") else lambda name: getattr(row, name, None)
    try:
        key = str(get("candidate") or get("technique")), int(get("memory")), get("view")
    except (TypeError, ValueError):
        raise ArgumentError(f"row: {hint}, got {shown(row)}") from None
    if key not in {(o.candidate, o.memory, v) for o in advice.outcomes for v in (None, o.view.label)}:
        raise ArgumentError(f"row: {hint}, got {key[0]!r} at {memory_text(key[1])}, which this advice does not have")
    return key


def advice_snippet(advice: Advice, candidate: Candidate, resolution: int, views: Sequence[LabelledView]) -> str:
    """A script that computes the error of a candidate at a resolution in views, and prints it."""
    of_errors = "errors." in advice.measure.python
    lines = ["import numpy as np"] * candidate.given + [
        "import shadowlab as sl",
        "",
        advice.source.python,
        f"renderer = sl.Renderer({advice.backend!r})",
        "views = {}",
    ]
    for view in views:
        lines += [camera_python(view.camera), light_python(view.light)]
        lines.append(f"views[{view.label!r}] = camera, light, {view.size}")
    if is_parameterization(candidate.item):
        lines += [f"p = {given_python(candidate.item)}"]
    else:
        lines.append(f"technique = sl.technique({candidate.text!r})")
    lines += ["found = {}", "for label, (camera, light, size) in views.items():"]
    samples = ", samples=gbuffer" if getattr(candidate.item, "needs_samples", False) else ""
    body = []
    if samples or not of_errors:
        body.append("gbuffer = renderer.gbuffer(scene, camera, size=size)")
    if not candidate.given:
        body.append(f"p = technique.parameterize(scene, camera, light, resolution={resolution}{samples})")
    if of_errors:
        body += [
            f"mask = renderer.shadow_mask(scene, camera, light, p, resolution={resolution}, size=size,",
            f"    bias={bias_python(advice.bias)}, filter={advice.filter!r})",
            "errors = sl.aliasing.misclassified(mask, sl.trace.shadow_mask(scene, camera, light, size=size))",
        ]
    else:
        body.append(f"summary = sl.aliasing.footprint(gbuffer, camera, light, p, resolution={resolution}).summary()")
    body.append(f"found[label] = {advice.measure.python}")
    lines += [f"    {line}" for line in body]
    lines += ["error_mean, error_worst = sum(found.values()) / len(found), max(found.values())"]
    lines += ["print(found, error_mean, error_worst)"]
    return "\n".join(lines) + "\n"
