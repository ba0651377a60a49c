"""A study as data: results.json, and the facts that the page lists. Strict JSON: no NaN, no infinity."""

from __future__ import annotations

import contextlib
import datetime
import math
import platform
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..text import BIAS, plain
from .reproduce import command_line, python_snippet

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._core import Camera
    from ..experiments.run import Run
    from ..experiments.study import Study
    from ..types import Light

PACKAGES = ("shadowlab", "numpy", "pandas", "trimesh", "matplotlib")


def now() -> str:
    """The time in UTC, to the second."""
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC")


def versions() -> dict[str, str]:
    """Versions of this package, of Python and of what the numbers pass through."""
    return dict(_versions())


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    """The same; found once."""
    known = [(name, version) for name in PACKAGES if (version := recorded_version(name)) is not None]
    return (*known, ("Python", platform.python_version()))


def recorded_version(package: str) -> str | None:
    """The version of an installed package; None of one that is not there.

    By the name of the folder that installers leave where they can be read; `importlib.metadata` reads the file in it,
    and loads a parser of mails for that.
    """
    for place in sys.path:
        with contextlib.suppress(OSError):
            for folder in Path(place or ".").glob(f"{package}-*.dist-info"):
                return folder.stem.removeprefix(f"{package}-")
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def camera_record(camera: Camera) -> dict[str, Any]:
    """A camera as data."""
    vectors = ("eye", "right", "up", "forward")
    numbers = ("fov_y", "aspect", "near", "far")
    record = {name: plain(np.asarray(getattr(camera, name))) for name in vectors}
    record |= {name: plain(float(getattr(camera, name))) for name in numbers}
    record |= {"height": camera.height} if camera.is_orthographic else {}
    return record | ({"shift": list(camera.shift)} if any(camera.shift) else {})


def lens_text(camera: Camera) -> str:
    """How much of the world a camera sees, for people."""
    high = f"{camera.height:.4g} high" if camera.is_orthographic else f"{math.degrees(camera.fov_y):.4g}° high"
    kind = "orthographic, " if camera.is_orthographic else ""
    x, y = camera.shift
    return f"{kind}{high}, aspect {camera.aspect:.4g}" + (f", shifted by {x:.4g}, {y:.4g}" if x or y else "")


def light_record(light: Light) -> dict[str, Any]:
    """A light as data."""
    names = ("position", "direction", "cone_angle", "range")
    return {"kind": light.kind, **{n: plain(np.asarray(getattr(light, n))) for n in names if hasattr(light, n)}}


def run_record(run: Run) -> dict[str, Any]:
    """A run as data: its row, and everything that its technique made."""
    record = {**run.row(), "technique": run.technique, "label": run.label, "settings": dict(run.settings)}
    record["notes"] = [str(note) for note in run.notes]
    p = run.parameterization
    if p is not None:
        record["matrices"] = np.asarray(p.matrices)
        record["values"] = dict(p.values)
        record["selection"] = p.selection
        record["partitions"] = [
            {
                "technique": part.technique,
                "eye_depth": list(part.eye_depth),
                "post_warp": {
                    "kind": part.post_warp,
                    **part.post_warp_terms,
                    **dict(zip("xy", part.post_warp_knots or (), strict=False)),
                },
                "values": dict(part.values),
            }
            for part in p.partitions
        ]
    if run.summary is not None:
        record["texels"] = run.summary.to_dict()
    if run.causes is not None:
        record["causes"] = {
            **run.causes.counts,
            "edge_distance_px": run.causes.edge_distance,
            "bands": run.causes.depth_rows(),
        }
    return record


def study_data(study: Study, pictures: Sequence[str] = ()) -> dict[str, Any]:
    """The whole study as data, with the names of its pictures."""
    scene, bias = study.scene, study.bias
    return {
        "created": now(),
        "versions": versions(),
        "platform": platform.platform(),
        "renderer": {"backend": study.backend, "adapter": study.adapter},
        "scene": {
            "source": study.source.name,
            "python": study.source.python,
            "triangles": scene.triangle_count,
            "instances": scene.instance_count,
            "bounds": np.asarray(scene.bounds),
        },
        "camera": camera_record(study.camera),
        "light": light_record(study.light),
        "size": list(study.size),
        "bias": {name: getattr(bias, name) for name in BIAS},
        "filter": study.filter,
        "blend": study.blend,
        "stored": str(study.stored),
        "truth_ms": study.truth_ms,
        "runs": [run_record(run) for run in study.runs],
        "verdict": study.verdict,
        "reproduce": {"python": python_snippet(study, study.runs), "command": command_line(study, study.runs)},
        "pictures": list(pictures),
    }


def facts(study: Study) -> list[tuple[str, str]]:
    """What was run, as names and texts for people."""
    camera, light, scene = study.camera, study.light, study.scene
    low, high = np.asarray(scene.bounds)
    lines = [
        ("scene", f"{study.source.name}: {scene.triangle_count:,} triangles, {scene.instance_count:,} instances"),
        ("bounds", f"{vector(low)} to {vector(high)}"),
        ("eye", f"{vector(camera.eye)}, looking along {vector(camera.forward)}"),
        ("view", lens_text(camera)),
        ("depth range", f"{camera.near:.4g} to {camera.far:.4g}"),
        ("light", light_text(light)),
        (
            "bias",
            ", ".join(f"{name} {getattr(study.bias, name):g}" for name in BIAS),
        ),
        ("lookup", study.lookup),
        ("renderer", f"{study.backend}: {study.adapter}"),
    ]
    aspect = study.size[0] / study.size[1]
    if abs(camera.aspect / aspect - 1) > 1e-3:  # a thousandth is below a pixel in any picture shown
        lines.append(("pixels", f"not square: {study.size[0]} × {study.size[1]} for an aspect of {camera.aspect:.4g}"))
    if study.truth_ms is not None:
        lines.append(("truth", f"traced in {study.truth_ms:,.0f} ms"))
    return lines


def light_text(light: Light) -> str:
    """A light in words."""
    if light.kind == "directional":
        return f"directional, travelling along {vector(light.direction)}"
    if light.kind == "spot":
        angle = math.degrees(light.cone_angle)
        place = f"spot at {vector(light.position)} towards {vector(light.direction)}"
        return f"{place}, {angle:.4g}° wide, range {light.range:.4g}"
    return f"{light.kind} at {vector(light.position)}, range {light.range:.4g}"


def vector(v: npt.ArrayLike) -> str:
    """A vector with four digits."""
    return f"({', '.join(f'{float(x):.4g}' for x in np.asarray(v, dtype=np.float64))})"
