"""The maps of a run in the page: as the light sees them, which of them each pixel asks, and their numbers."""

from __future__ import annotations

import math
from functools import partial
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ...experiments.run import done
from ...pictures.maps import chosen_picture, layer_picture, map_colour, reduced
from ...text import share_text
from .parts import css_rgb, figure, head_cell, picture, swatch, table_html

if TYPE_CHECKING:
    from ..._core import Camera
    from ...experiments.run import Run
    from ...experiments.study import Study
    from .album import Album

# Widest picture of a map in the page, texels; larger maps are reduced and keep their nearest depths.
MAP_SIDE = 1024


def map_figure(camera: Camera, run: Run, name: str, stem: str, album: Album) -> str:
    """The map or maps as the light sees them, with the camera frustum."""
    maps, p = done(run.maps), done(run.parameterization)
    layers = maps if maps.ndim == 3 else maps[None]
    several = len(layers) > 1
    made = []
    for i, layer in enumerate(layers):
        which = f", part {i + 1}" if several else ""
        covered = share_text(float(np.mean(layer < 1.0)))
        text = f"Shadow map of {name}{which} as the light sees it, with the camera frustum; {covered} of it covered"
        file = f"{stem}_map{f'_{i + 1}' if several else ''}.png"
        small = reduced(layer, MAP_SIDE)
        source = album.add(partial(layer_picture, small, p, camera, MAP_SIDE, i), file)
        height, width = small.shape
        made.append(picture(source, text, width / height))
    covered = share_text(float(np.mean(maps < 1.0)))
    frustum = "the part of the camera frustum that a map serves" if several else "the camera frustum"
    caption = f"<b>From the light</b>, near is pale; {frustum} in orange. {covered} of the texels hold a caster."
    return figure(f'<div class="layers">{"".join(made)}</div>' if several else made[0], caption, 1.0)


def chosen_figure(study: Study, run: Run, name: str, stem: str, album: Album) -> str:
    """The eye view in the colours of the maps that its pixels ask."""
    chosen, mask = done(run.chosen), done(run.mask)
    source = album.add(partial(chosen_picture, study.gbuffer, study.light, mask, chosen), f"{stem}_chosen.png")
    seen = int((np.asarray(study.gbuffer.triangle) >= 0).sum())
    shares = [int((chosen == i).sum()) / max(1, seen) for i in range(len(done(run.maps)))]
    keys = "".join(
        f"{swatch(css_rgb(map_colour(i)))}map {i + 1}: {share_text(share)} " for i, share in enumerate(shares)
    )
    caption = f'<b>The map that each pixel asks</b>; grey asks none.<br><span class="key">{keys}</span>'
    text = f"Eye view of {name} in the colours of the maps that its pixels ask"
    return figure(picture(source, text, study.camera.aspect), caption, study.camera.aspect)


def map_table(run: Run, camera: Camera) -> str:
    """The numbers of every map: camera depths, what made it, intermediate values. Nothing for a map without any."""
    parts = done(run.parameterization).partitions
    if not any(part.values for part in parts) and len(parts) == 1:
        return ""
    lines = []
    for i, part in enumerate(parts):
        near, far = part.eye_depth
        last = camera.far if math.isfinite(camera.far) else parts[-1].eye_depth[1]
        depths = "all" if near <= camera.near and far >= last else f"{near:.4g} to {far:.4g}"
        values = ", ".join(f"{escape(key)} {value:.6g}" for key, value in part.values.items()) or "–"
        head = f"{swatch(css_rgb(map_colour(i)))}{i + 1}" if len(parts) > 1 else "1"
        cells = "".join(f"<td>{cell}</td>" for cell in (escape(part.technique), depths, values))
        lines.append(f'<tr><td><span class="key">{head}</span></td>{cells}</tr>')
    body = table_html(list(map(head_cell, ("map", "technique", "camera depths", "values"))), lines)
    return f"<details><summary>Numbers of the map{'s' if len(parts) > 1 else ''}</summary>{body}</details>"
