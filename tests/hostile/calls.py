"""A good call of every public callable: what the table changes, one argument at a time.

An argument gets what its name means everywhere (`MEANING`), or what it means to one callable (`OWN`). Constructors of
results get the fields of an example.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import travel_support

import shadowlab as sl
from shadowlab import _core
from shadowlab.text import BIAS

from .examples import (
    SIZE,
    advice,
    angles,
    example,
    explained,
    folder,
    model,
    optimal,
    saved,
    searched,
    store,
    study,
    sweep_table,
    temporal,
    world,
)
from .found import Callee


class Unknown(Exception):
    """An argument of which the table does not know what to give."""


def _world(name: str) -> Callable[[], Any]:
    return lambda: getattr(world(), name)


#: What arguments mean everywhere.
MEANING: dict[str, Callable[[], Any]] = {
    **{
        name: _world(name)
        for name in (
            "scene",
            "camera",
            "light",
            "vertices",
            "faces",
            "gbuffer",
            "mask",
            "truth",
            "footprint",
            "view",
            "maps",
            "samples",
            "renderer",
        )
    },
    "ax": lambda: None,
    "alpha": lambda: None,
    "angle_deg": lambda: 60.0,
    "angles_deg": lambda: [40.0, 60.0],
    "after": _world("scene"),
    "aspect": lambda: 16 / 9,
    "azimuth": lambda: 1.0,
    "azimuth_deg": lambda: 10.0,
    "backend": lambda: "cpu",
    "adapter": lambda: None,
    "bands": lambda: 2,
    "before": _world("scene"),
    "bias": lambda: sl.Bias(world=0.01),
    "bounds": lambda: world().scene.bounds,
    "cause_image": lambda: world().found,
    "center": lambda: (0.0, 0.0, 0.0),
    "changes": dict,
    "chosen": lambda: np.zeros((9, 16), np.int16),
    "cone_angle": lambda: 1.0,
    "convention": lambda: "opengl",
    "cos_alpha": lambda: 0.5,
    "cos_beta": lambda: 0.5,
    "count": lambda: 2,
    "cull": lambda: "volume",
    "depth": lambda: world().maps,
    "depths": lambda: [2.0, 8.0],
    "differences": lambda: np.zeros((9, 16), np.int8),
    "blend": lambda: 0.2,
    "direction": lambda: (0.3, -1.0, 0.2),
    "directions": lambda: [[0.0, -1.0, 0.1]],
    "edge_normals": lambda: np.ones((4, 2)) * 0.6,
    "elevation": lambda: 0.5,
    "every": lambda: 4,
    "explanation": explained,
    "eye": lambda: (0.0, 1.0, 9.0),
    "eye_depth": lambda: [(0.5, 9.0)],
    "far": lambda: 100.0,
    "filter": lambda: "nearest",
    "footprints": _world("footprint"),
    "fov_y": lambda: 1.0,
    "height": lambda: -1.0,
    "image": lambda: world().found.image,
    "images": lambda: [np.zeros((9, 16, 3), np.uint8)],
    "indices": lambda: [0],
    "label": lambda: "uniform",
    "lam": lambda: 2.0,
    "lights": lambda: [world().light],
    "map": lambda: 0,
    "matrices": lambda: np.eye(4)[None],
    "matrix": lambda: np.eye(4),
    "memory": lambda: 1 << 12,
    "metrics": lambda: ("misclassified",),
    "n": lambda: None,
    "name": lambda: "uniform",
    "near": lambda: 1.0,
    "normals": lambda: np.array([[0.0, 1.0, 0.0]] * len(world().seen)),
    "origins": lambda: [[0.0, 5.0, 0.0]],
    "other": _world("scene"),
    "parameterization": _world("p"),
    "parameterizations": lambda: [world().p],
    "params": dict,
    "partition": lambda: world().p.partitions[0],
    "phases": lambda: 1,
    "pixels": lambda: [[0.5, 0.5]],
    "picture": lambda: np.zeros((9, 16, 3), np.uint8),
    "points": _world("seen"),
    "position": lambda: (0.0, 5.0, 0.0),
    "positions": _world("seen"),
    "progress": lambda: False,
    "projection": lambda: world().camera.projection,
    "range": lambda: 20.0,
    "resolution": lambda: 16,
    "result": optimal,
    "scale": lambda: 1.0,
    "seed": lambda: 1,
    "segments": lambda: np.zeros((1, 2, 2)),
    "shadow_clip_from_world": lambda: world().p.matrix,
    "shift": lambda: (0.1, -0.1),
    "side": lambda: 4,
    "size": lambda: SIZE,
    "slack": lambda: 1.1,
    "soft": lambda: sl.trace.soft_shadow_mask(world().scene, world().camera, world().light, size=SIZE, samples=2),
    "steps": lambda: 2,
    "stored": lambda: sl.Stored("back"),
    "study": study,
    "style": dict,
    "t_max": lambda: 9.0,
    "table": lambda: study().table(),
    "target": lambda: (0.0, 0.0, 0.0),
    "technique": lambda: "uniform",
    "techniques": lambda: ["uniform"],
    "temporal": temporal,
    "theta": lambda: 0.5,
    "timing": lambda: False,
    "title": lambda: "a title",
    "up": lambda: "y",
    "value": lambda: None,
    "weights": lambda: np.ones(4),
    "width": lambda: 1,
    "width_px": lambda: 1.3,
    "xlabel": lambda: None,
    "ylabel": lambda: None,
    "z": lambda: 10.0,
}


#: The arrays of a footprint, and from which length on a texel shows.
_OF_FOOTPRINT: dict[str, Callable[[], Any]] = {
    "major": lambda: world().footprint.major, "perspective": lambda: world().footprint.perspective,
    "along_t": lambda: world().footprint.perspective_ts[..., 0],
    "along_s": lambda: world().footprint.perspective_ts[..., 1],
    "projection": lambda: world().footprint.projection, "depth": lambda: world().footprint.depth,
    "undersampled_from": lambda: 1.0,
}  # fmt: skip


#: What arguments mean to one callable, or to all methods of a class.
OWN: dict[str, dict[str, Callable[[], Any]]] = {
    "Camera.look_at": {"up": lambda: (0.0, 1.0, 0.0)},
    "Camera.orthographic": {"up": lambda: (0.0, 1.0, 0.0), "height": lambda: 4.0},
    "Camera.from_matrices": {"view": lambda: world().camera.view, "convention": lambda: None, "far": lambda: None},
    "Camera.corners": {"depth": lambda: 5.0},
    "Camera.replace": {"changes": lambda: {"eye": (0.0, 1.0, 9.0)}},
    "Convention": {
        "vectors": lambda: "column", "z_range": lambda: (0.0, 1.0), "reversed_z": lambda: False, "x": lambda: "right",
        "xy_range": lambda: (-1.0, 1.0), "y": lambda: "up", "axes": lambda: ("x", "y", "z"),
        "handedness": lambda: "right", "tile": lambda: (0.0, 0.0, 1.0, 1.0),
    },
    "Convention.of": {"value": lambda: "opengl"},
    "Convention.changed": {"changes": lambda: {"y": "down"}},
    "Convention.in_atlas": {"columns": lambda: 2, "rows": lambda: 2},
    "Bias": dict.fromkeys(BIAS, lambda: 0.1),
    "Bias.polygon_offset": {"factor": lambda: 1.0, "units": lambda: 2.0},
    "Stored": {
        "surface": lambda: "front", "spacing": lambda: "linear", "format": lambda: "f16", "limit": lambda: 1.0,
    },
    "Parameterization.from_matrix": {
        "selection": lambda: "depth", "post_warp": lambda: [None], "regions": lambda: [np.zeros((0, 4))],
        "convention": lambda: None,
    },
    "Samples.from_arrays": {"shadows": lambda: np.array([1, 0, 1, 0], np.int8)},
    "Run.over_phases": {"phases": lambda: 2},
    "Samples.from_gbuffer": {"shadows": _world("truth")},
    "_core.samples_under": {"shadows": _world("truth")},
    "Samples.missed": {"holds": lambda: "shadow"},
    "View.gaps": {"shadows": lambda: "mapped"},
    "View.samples": {"shadows": lambda: "mapped"},
    "LightPlane.clip_from_world": {"x": lambda: (-1.0, 1.0), "y": lambda: (-1.0, 1.0), "reach": lambda: 10.0},
    "LightPlane.lattice": {"xs": lambda: [-0.5, 0.5], "ys": lambda: [-0.5, 0.5]},
    "LightPlane.segments": {"ends": lambda: [(np.zeros(3), np.ones(3))]},
    "Prediction.of": {"wrong": lambda: 12.5},
    "Preset": {"choose": lambda: travel_support.chosen},
    "Technique": {"params": lambda: {"near": 0.5}, "name": lambda: "lispsm"},
    "sl.technique": {"params": lambda: {"near": 0.5}, "name": lambda: "lispsm"},
    "sl.preset": {"name": lambda: "godot"},
    "sl.library.scene": {"params": lambda: {"trees": 3}, "name": lambda: "forest"},
    "Scene": {
        "meshes": lambda: world().scene.meshes, "mesh_index": lambda: [0], "transforms": lambda: np.eye(4)[None],
    },
    "Scene.from_trimesh": {"source": lambda: world().scene.to_trimesh()},
    "Scene.with_ground": {"size": lambda: 10.0},
    "_core.Note": {
        "kind": lambda: "warp_distance_raised", "details": list, "values": lambda: {"given": 1.0, "least": 2.0},
        "maps": lambda: [0],
    },
    "_core.Note.about": {"maps": lambda: [0]},
    "_core.Mesh.from_local": {
        "positions": lambda: world().scene.meshes[0].positions_local, "faces": lambda: world().scene.meshes[0].faces,
    },
    "_core.library_build": {"name": lambda: "forest", "params": lambda: [("trees", 3.0)]},
    "_core.restore": {"parts": lambda: sl.Bias().__reduce__()[1]},
    "_core.trace_shadow_mask": {"progress": lambda: None},
    "Footprint.of_arrays": {
        "arrays": lambda: _core.footprint(world().gbuffer, world().camera, world().light, world().p),
        "depth": lambda: None, "resolution": lambda: (16, 16), "size": lambda: None,
    },
    "LightAngles.crossovers": {"y": lambda: "storage_factor", "baseline": lambda: "uniform"},
    "LightAngles.relative": {"y": lambda: "storage_factor", "baseline": lambda: "uniform"},
    "Advice.best_for": {"view": lambda: None, "memory": lambda: None},
    "Advice.gbuffer": {"view": lambda: advice().views[0].label},
    "Advice.reproduce": {"row": lambda: 0},
    "Advice.save": {"directory": lambda: Path("advice")},
    "Advice.load": {"path": lambda: saved(advice), "scene": lambda: None},
    "Study.load": {"path": lambda: saved(study), "scene": lambda: None},
    "Study.save": {"directory": lambda: Path("study")},
    "Study.save_arrays": {"path": lambda: Path("arrays.npz")},
    "Source.of_scene": {},
    "sl.load_scene": {
        "source": lambda: model(), "unit": lambda: None, "kind": lambda: "obj", "limits": lambda: sl.Limits(size=1000),
    },
    "sl.set_threads": {"n": lambda: 2},
    "sl.diagnose": {"mine": lambda: np.eye(4), "theirs": lambda: np.eye(4), "tile": lambda: None},
    "sl.explain_pixel": {"x": lambda: 8, "y": lambda: 6, "trials": lambda: False},
    "GBuffer.crop": {"x": lambda: 1, "y": lambda: 2, "width": lambda: 3, "height": lambda: 4},
    "_core.compared": {"pixels": lambda: [[8, 6]]},
    "_core.blended": {"pixels": lambda: [[8, 6]]},
    "_core.predict_wrong": {"gaps": lambda: np.zeros(world().truth.shape, np.float32)},
    "_core.depth_rows": {"origin": lambda: (0.0, 1.0, 0.0)},
    "_core.shade": {
        "normal": lambda: world().gbuffer.normal, "triangle": lambda: world().gbuffer.triangle,
        "ways": lambda: np.array([[[0.0, -1.0, 0.0]]], np.float32), "sky": lambda: np.zeros((9, 3), np.uint8),
        "material": lambda: np.full((3, 3), 0.3, np.float32), "coded": lambda: np.zeros(1 << 16, np.uint8),
    },
    "_core.face_corners": {"instance": lambda: 0, "face": lambda: 0},
    "_core.summarize": {
        "map": lambda: world().footprint.map, "maps": lambda: 1, "percentiles": lambda: [5.0, 50.0],
        "edges": lambda: [0.0, 1.0, 9.0], **_OF_FOOTPRINT,
    },
    "_core.summarize_bands": {
        "map": lambda: world().footprint.map, "limits": lambda: [1.0, 5.0, 30.0], **_OF_FOOTPRINT,
    },
    "_core.cause_counts": {"distance": lambda: world().found.distance},
    "_core.compared_depths": {"depth": lambda: world().found.depth},
    "_core.causes_by_depth": {"depth": lambda: world().found.depth, "limits": lambda: [1.0, 5.0, 30.0]},
    "sl.default_view": {"focus": lambda: None, "view": lambda: "above"},
    "sl.default_views": {"focus": lambda: None},
    "sl.advise": {
        "cameras": _world("camera"), "lights": _world("light"), "error": lambda: "misclassified",
        "over": lambda: "mean", "predict": lambda: None, "drawn": lambda: 1, "source": lambda: None,
    },
    "sl.compare": {"truth": lambda: True, "source": lambda: None},
    "sl.evaluate": {"label": lambda: None},
    "sl.predict": {"shadows": lambda: "mapped"},
    "sl.random": {"space": lambda: {"scene": "@robots", "technique": "uniform"}, "n": lambda: 2},
    "sl.sweep": {
        "space": lambda: {"scene": world().scene, "technique": "uniform", "resolution": 16}, "store": lambda: None,
        "executor": lambda: None, "workers": lambda: None, "timeout": lambda: 60.0,
    },
    "sl.to_xarray": {"table": sweep_table},
    "sl.blur": {"iterations": lambda: 3, "strength": lambda: "depth", "depth": lambda: 5.0},
    "_core.blur": {"iterations": lambda: 3, "strength": lambda: "depth", "depth": lambda: 5.0},
    "Store": {"path": lambda: f"{folder().name}/new.sqlite", "journal": lambda: None},
    "Store.put": {"key": lambda: "a", "row": lambda: {"maps": 1, "failure": ""}, "done": lambda: True},
    "Store.missing": {"keys": lambda: ["a", "b"]},
    "Store.rows": {"keys": lambda: ["a", "b"]},
    "sl.read_store": {
        "path": lambda: str(store().path), "where": lambda: "maps > 0", "old": lambda: False,
    },
    "sl.smallest_bias": {"part": lambda: "slope", "acne": lambda: 0.01},
    "sl.plot.bias_curve": {"found": lambda: example("SmallestBias")},
    "sl.prefiltered_maps": {
        "memory": lambda: None, "resolution": lambda: 16, "kernel": lambda: 3,
        "formats": lambda: ["depth:pcf", "moment:unorm16"], "reduction": lambda: 0.1,
    },
    "sl.plot.prefiltered_figure": {"found": lambda: example("PrefilteredMaps")},
    "PrefilteredMaps.mask": {"format": lambda: "depth:pcf"},
    "sl.trace.soft_shadow_mask": {"samples": lambda: 2},
    "sl.scene_optimal_experiment": {
        "techniques": lambda: ["uniform:turn=rectangle", "uniform"], "sizes": lambda: (16,),
        "views": lambda: advice().views, "out": lambda: None, "reference": lambda: 16,
    },
    "sl.turned": {"vectors": lambda: [[1.0, 2.0, 3.0]]},
    "sl.aliasing.over_light_angle": {"truth": lambda: True},
    "sl.aliasing.temporal": {"cameras": lambda: [world().camera, world().camera]},
    "sl.plot.causes": {"table": study},
    "sl.plot.drift": {"table": temporal},
    "sl.plot.error_curve": {"table": lambda: study().table},
    "sl.plot.error_over_angle": {
        "table": angles, "x": lambda: "angle_deg", "y": lambda: "texel_p95", "baseline": lambda: None,
    },
    "sl.plot.error_along_view": {
        "curves": lambda: {"a": ([1.0, 2.0], [1.0, 2.0])}, "measured": lambda: None, "ylabel": lambda: "what",
    },
    "sl.plot.error_histogram": {"quantity": lambda: "major", "by_depth": lambda: False},
    "sl.plot.error_map": {"values": lambda: None, "colorbar": lambda: True, "label": lambda: "what"},
    "sl.plot.error_picture": {"values": lambda: None},
    "sl.plot.lines": {
        "table": lambda: study().table, "x": lambda: "resolution", "y": lambda: "wrong", "hue": lambda: "technique",
    },
    "sl.plot.heatmap": {
        "table": lambda: study().table, "x": lambda: "resolution", "y": lambda: "technique", "value": lambda: "wrong",
    },
    "sl.plot.pareto": {
        "table": lambda: study().table, "cost": lambda: "memory", "error": lambda: "wrong", "hue": lambda: "technique",
    },
    "sl.plot.percent_more": {"by_map": lambda: False},
    "sl.plot.search_history": {"parameterization": searched},
    "sl.plot.cause_picture": {"cause_image": lambda: world().found.image},
    "sl.plot.pictures.densest_window": {"images": lambda: [np.zeros((9, 16), np.uint8)]},
    "sl.plot.frustum": {"style": lambda: {"color": "red"}},
    "sl.plot.difference": {"image": lambda: sl.aliasing.misclassified(world().mask, world().truth).image},
    "sl.plot.difference_view": {"image": lambda: sl.aliasing.misclassified(world().mask, world().truth).image},
    "sl.aliasing.closed_form.dp_ds_on_surface": {"F": lambda: 2.0},
    "sl.aliasing.closed_form.dp_ds_in_split": {"split_near": lambda: 5.0, "split_far": lambda: 20.0},
    "sl.aliasing.closed_form.splits": {"scheme": lambda: "logarithmic", "blend": lambda: 0.5},
    "sl.aliasing.closed_form.storage_factor": {"ratio": lambda: 10.0, "splits": lambda: 1},
    "sl.aliasing.closed_form.warp_lambda": {"technique": lambda: "gmnpr", "lambda_floor": lambda: None},
}  # fmt: skip
for _name in ("LibraryScene", "_core.Scene"):
    OWN[_name] = OWN["Scene"]


def receiver(callee: Callee) -> Any:
    """The object that a method is called on; one of its own each time, where it holds something."""
    assert callee.owner is not None
    if callee.owner is sl.TemporalFit:
        return sl.TemporalFit()
    if callee.owner is sl.Store:
        return sl.Store(store().path) if callee.name == "Store.close" else store()
    if callee.owner is sl.Scene:
        return world().scene
    if callee.owner is sl.Renderer:
        return world().renderer
    if callee.owner is sl.Samples:
        return world().samples
    if callee.owner is sl.Technique:
        return sl.technique("lispsm")
    return example(travel_support.name_of(callee.owner))


def fields(callee: Callee) -> Mapping[str, Any]:
    """The fields of an example of the class that is constructed, by name."""
    of = callee.of
    if isinstance(of, type) and of.__module__ != "shadowlab._core":
        made = getattr(of, "_fields", None)
        if made or dataclasses.is_dataclass(of):
            one = example(callee.name)
            names = made or [field.name for field in dataclasses.fields(of) if field.init]
            return {name: getattr(one, name) for name in names}
    return {}


@functools.cache
def arguments(callee: Callee) -> dict[str, Any]:
    """A good value for each argument; keywords without a name of their own are in one dictionary.

    Raises
    ------
    Unknown
        For an argument that the table does not know: add it to `MEANING` or `OWN`.
    """
    given, own = {}, OWN.get(callee.name, {})
    ready = fields(callee) if callee.name not in OWN or callee.name == "Preset" else {}
    for parameter in callee.parameters:
        name = parameter.name
        if name in own:
            given[name] = own[name]()
        elif name in ready:
            given[name] = ready[name]
        elif name in MEANING:
            given[name] = MEANING[name]()
        else:
            raise Unknown(f"{callee.name}: tests/hostile/calls.py does not know what to give for {name}")
    return given


def invoke(callee: Callee, given: Mapping[str, Any]) -> Any:
    """Calls it with these arguments by name."""
    positional, keywords = [], {}
    for parameter in callee.parameters:
        value = given[parameter.name]
        if parameter.kind is parameter.VAR_KEYWORD:
            keywords.update(value)
        elif parameter.kind is parameter.VAR_POSITIONAL:
            positional += list(value)
        elif parameter.kind is parameter.POSITIONAL_ONLY:
            positional.append(value)
        else:
            keywords[parameter.name] = value
    on = [] if callee.owner is None else [receiver(callee)]
    return callee.of(*on, *positional, **keywords)
