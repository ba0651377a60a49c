"""What a notebook shows of a view, a camera and the maps of a technique: small tables, and a picture of the view.

Classes of the extension call these by name. All text is escaped.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ... import pictures
from ...scene.source import Source
from ...text import format_value
from ...text.checks import picture_size
from ..study_record import lens_text, light_text, vector
from .parts import data_uri

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..._core import Camera, Parameterization, Partition
    from ...scene.view import View

# Pixels of a picture in a notebook: 480 x 270 in 16:9, drawn in a fraction of a second.
SHOWN_PIXELS = 480 * 270
# Lights and maps that are shown one by one; the number of the others is stated.
MOST_SHOWN = 4
# The style sheet of reports is not at hand in a notebook.
CELL = "padding:2px 12px 2px 0;text-align:left;vertical-align:top"
NUMBER = "padding:2px 0 2px 12px;text-align:right;font-family:monospace"


def view_html(view: View) -> str:
    """The view shaded with its traced shadows, and a table of what it is."""
    shown = view.views[:MOST_SHOWN]
    images = []
    for one in shown:
        small = replace(one, size=picture_size(view.size[0] / view.size[1], SHOWN_PIXELS))
        light = small.lights[0]
        shaded = pictures.shade(small.gbuffer(), light, pictures.truth_mask(small.truth()))
        text = escape(f"{one.label}: {light_text(light)}" if one.label else light_text(light), quote=True)
        style = f"width:{small.size[0]}px;max-width:100%;aspect-ratio:{view.camera.aspect}"
        source = data_uri(pictures.png(shaded))
        images.append(f'<img alt="The view with its shadows. {text}" style="{style}" src="{source}">')
    scene = view.scene
    lights = [("light", light_text(light)) for light in view.lights[:MOST_SHOWN]]
    rows = [
        ("label", view.label or "none"),
        ("scene", f"{Source.of_scene(scene).name}: {scene.triangle_count:,} triangles"),
        *camera_rows(view.camera),
        *lights,
        ("size", f"{view.size[0]} × {view.size[1]} pixels"),
    ]
    return f"<div>{''.join(images)}{table_of(rows)}{others('lights', len(view.lights))}</div>"


def camera_html(camera: Camera) -> str:
    """A table of what the camera is, and its matrix."""
    rows = camera_rows(camera)
    return f"<div>{table_of(rows)}<p>clip from world:</p>{matrix_html(camera.clip_from_world)}</div>"


def parameterization_html(p: Parameterization) -> str:
    """Settings, notes, and for each map its camera depths, values and matrix."""
    maps = p.partitions
    texels = f"{p.resolution}²" if isinstance(p.resolution, int) else " × ".join(map(str, p.resolution))
    count = f"{len(maps)} of {texels}" + (f", found by {p.selection}" if len(maps) > 1 else "")
    rows = [
        ("technique", p.technique),
        ("settings", settings_line(p.settings)),
        ("maps", count),
        *(("note", str(note)) for note in p.notes),
    ]
    shown = "".join(map_html(i, part, len(maps)) for i, part in enumerate(maps[:MOST_SHOWN]))
    return f"<div>{table_of(rows)}{shown}{others('maps', len(maps))}</div>"


def map_html(index: int, part: Partition, count: int) -> str:
    """One map: its camera depths, values and matrix."""
    near, far = part.eye_depth
    rows = [
        ("map", f"{index + 1} of {count}: {part.technique}"),
        ("camera depths", "all" if near <= 0 and math.isinf(far) else f"{near:.4g} to {far:.4g}"),
        ("values", ", ".join(f"{name} {value:.4g}" for name, value in part.values.items()) or "none"),
    ]
    terms = ", ".join(f"{name} {value:.4g}" for name, value in part.post_warp_terms.items())
    if part.post_warp_knots is not None:
        x, y = map(len, part.post_warp_knots)
        terms = f"{x} knots along x and {y} along y"
    rows += [("then", f"{part.post_warp}: {terms}")] if terms else []
    return f"{table_of(rows)}<p>shadow clip from world:</p>{matrix_html(part.matrix)}"


def camera_rows(camera: Camera) -> list[tuple[str, str]]:
    """A camera as names and texts."""
    return [
        ("eye", f"{vector(camera.eye)}, looking along {vector(camera.forward)}"),
        ("view", lens_text(camera)),
        ("depth range", f"{camera.near:.4g} to {camera.far:.4g}"),
    ]


def settings_line(settings: Mapping[str, object]) -> str:
    """Settings on one line, numbers as people read them."""
    texts = (f"{name}={f'{v:.6g}' if isinstance(v, float) else format_value(v)}" for name, v in settings.items())
    return ", ".join(texts) or "none"


def others(what: str, count: int) -> str:
    """How many are not shown; nothing where all are."""
    return f"<p>and {count - MOST_SHOWN} more {what}</p>" if count > MOST_SHOWN else ""


def table_of(rows: Iterable[tuple[str, str]]) -> str:
    """Names and texts, which are escaped here, as a table."""
    cells = (
        f'<tr><th style="{CELL}">{escape(name)}</th><td style="{CELL}">{escape(text)}</td></tr>' for name, text in rows
    )
    return f"<table>{''.join(cells)}</table>"


def matrix_html(matrix: npt.NDArray[np.float64]) -> str:
    """A matrix (4, 4) with four digits."""
    lines = ["".join(f'<td style="{NUMBER}">{value:.4g}</td>' for value in row) for row in matrix]
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"
