"""Results and objects that calls are made with and on, each made once; pictures, maps and scenes as small as can be."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import travel_support

import shadowlab as sl

SIZE = (16, 9)


@functools.cache
def world() -> SimpleNamespace:
    """A scene, a view of it, and all that is made of them."""
    floor = [[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]]
    table = [[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]]
    vertices, faces = np.array(floor + table, float), np.array([[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]])
    scene = sl.Scene.from_arrays(vertices, faces)
    camera = sl.Camera.look_at((0, 4, 9), (0, 0, 0), aspect=16 / 9, near=1, far=30)
    light = sl.DirectionalLight((0.3, -1, 0.2))
    renderer = sl.Renderer("cpu")
    p = sl.technique("uniform").parameterize(scene, camera, light, resolution=16)
    gbuffer = renderer.gbuffer(scene, camera, size=SIZE)
    mask = renderer.shadow_mask(scene, camera, light, p, size=SIZE)
    truth = sl.trace.shadow_mask(scene, camera, light, size=SIZE)
    footprint = sl.aliasing.footprint(gbuffer, camera, light, p)
    view = sl.View(scene, camera, light, size=SIZE)
    maps = renderer.shadow_map(scene, p)
    found = sl.aliasing.causes(scene, camera, light, p, mask, truth, gbuffer=gbuffer, maps=maps)
    samples = view.samples(renderer=renderer)
    seen = np.asarray(gbuffer.position)[np.asarray(gbuffer.triangle) >= 0][:4]
    return SimpleNamespace(**locals())


@functools.cache
def study() -> Any:
    w = world()
    return sl.compare(
        w.scene, w.camera, w.light, ["uniform", "lispsm"], resolution=16, size=SIZE, renderer=w.renderer, progress=False
    )


@functools.cache
def advice() -> Any:
    w = world()
    return sl.advise(
        w.scene, w.camera, w.light, techniques=["uniform"], memory=1 << 12, size=SIZE, renderer=w.renderer, phases=1,
        progress=False,
    )  # fmt: skip


@functools.cache
def angles() -> Any:
    w = world()
    return sl.aliasing.over_light_angle(
        w.scene, w.camera, [40.0, 60.0], ["uniform", "lispsm"], resolution=16, size=SIZE, renderer=w.renderer,
        progress=False,
    )  # fmt: skip


@functools.cache
def temporal() -> Any:
    w = world()
    cameras = [w.camera, w.camera.replace(eye=w.camera.eye + 0.1)]
    return sl.aliasing.temporal(
        w.scene, cameras, w.light, ["uniform"], resolution=16, size=SIZE, renderer=w.renderer, progress=False
    )


@functools.cache
def sweep_table() -> Any:
    w = world()
    space = {
        "scene": w.scene,
        "camera": w.camera,
        "light": w.light,
        "technique": ["uniform", "lispsm"],
        "resolution": 16,
    }
    return sl.sweep(space, size=SIZE, renderer=w.renderer, progress=False)


@functools.cache
def optimal() -> Any:
    w = world()
    return sl.scene_optimal_experiment(
        ["uniform:turn=rectangle", "uniform"], sizes=(16,), views=advice().views, reference=16, renderer=w.renderer,
        progress=False,
    )  # fmt: skip


@functools.cache
def explained() -> Any:
    w = world()
    return sl.explain_pixel(w.view, "uniform", 8, 6, resolution=16, renderer=w.renderer, trials=False)


@functools.cache
def searched() -> Any:
    """Maps of a technique that searches."""
    w = world()
    return sl.technique("scene_optimal:search=published").parameterize(w.scene, w.camera, w.light, resolution=16)


@functools.cache
def folder() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes with the process."""
    return tempfile.TemporaryDirectory()


@functools.cache
def saved(of: Callable[[], Any]) -> str:
    """The folder of a saved result."""
    path = Path(folder().name) / of.__name__
    return str(of().save(path).parent)


@functools.cache
def store() -> sl.Store:
    """A store with a row."""
    made = sl.Store(f"{folder().name}/runs.sqlite")
    made.put("a", {"maps": 1})
    return made


@functools.cache
def model() -> str:
    """The path of a small file."""
    path = Path(folder().name) / "model.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return str(path)


@functools.cache
def example(name: str) -> Any:
    """An object of a class."""
    made = {"Study": study, "Advice": advice, "LightAngles": angles, "Temporal": temporal}
    return made[name]() if name in made else travel_support.examples(name)[0]
