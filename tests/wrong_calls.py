"""Calls that a type checker must refuse: each line with `# wrong:` is one, and what follows is part of what mypy says.

tests/test_types.py runs mypy over them and holds the lines and the words against its errors. Nothing here is executed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

import shadowlab as sl
from shadowlab import types


def of_the_package(table: pd.DataFrame) -> None:
    sl.advize(table)  # wrong: Module has no attribute "advize"
    sl.aliasing.foot_print  # wrong: Module has no attribute "foot_print"
    sl.library.scene("forest", trees="many")  # wrong: Argument "trees" to "scene" has incompatible type "str"
    sl.library.scene(Path("forest"))  # wrong: incompatible type "Path"; expected "str"
    sl.load_scene("model.glb", "z")  # wrong: Too many positional arguments
    sl.load_scene("model.glb", up="x")  # wrong: expected "Literal['y', 'z'] | None"
    sl.load_scene(3)  # wrong: Argument 1 to "load_scene" has incompatible type "int"
    sl.load_scene("model.glb", limits=10)  # wrong: expected "Limits"
    sl.turned((0, 0, 1))  # wrong: Missing named argument "up"
    sl.Scene.from_arrays(np.zeros((3, 3)))  # wrong: Missing positional argument "faces"
    sl.preset(3)  # wrong: expected "str"
    print(sl.techniques().nmae + 1, sl.report().work)  # wrong: "Report" has no attribute "work"


def of_views(scene: sl.Scene, camera: sl.Camera, light: sl.DirectionalLight, point: sl.PointLight) -> None:
    sl.Camera.look_at((0, 0, 5), (0, 0, 0), (0, 1, 0))  # wrong: Too many positional arguments
    sl.Camera.look_at((0, 0, 5), (0, 0, 0), fov=60)  # wrong: Unexpected keyword argument "fov"
    sl.Camera.look_at((0, 0, 5), (0, 0, 0), near="0.1")  # wrong: expected "float"
    camera.fov_y = 1.0  # wrong: Property "fov_y" defined in "Camera" is read-only
    camera.depth(light)  # wrong: incompatible type "DirectionalLight"
    sl.SpotLight((0, 5, 0), (0, -1, 0), range=20)  # wrong: Missing named argument "cone_angle"
    sl.PointLight((0, 5, 0), 20)  # wrong: Too many positional arguments
    point.direction  # wrong: "PointLight" has no attribute "direction"
    sl.default_view("model.glb")  # wrong: incompatible type "str"; expected "Scene"
    sl.default_view(scene, view="below")  # wrong: incompatible type "Literal['below']"
    sl.default_view(scene, 1.5)  # wrong: Too many positional arguments
    sl.View(scene, light, camera)  # wrong: incompatible type "DirectionalLight"; expected "Camera"
    sl.View(scene, camera, "noon")  # wrong: Argument 3 to "View" has incompatible type "str"
    sl.View(scene, camera, light, size="1280x720")  # wrong: Argument "size" to "View" has incompatible type "str"
    sl.View(scene, camera, light).size.height  # wrong: "tuple[int, int]" has no attribute "height"


def of_techniques(scene: sl.Scene, camera: sl.Camera, light: types.Light, p: sl.Parameterization) -> None:
    sl.technique(3)  # wrong: No overload variant of "technique" matches argument type "int"
    sl.technique("matrix", path="mine.npy", file="mine.npy").matrices  # wrong: has no attribute "matrices"
    sl.technique("lispsm").matrices  # wrong: "TechniqueLike" has no attribute "matrices"
    sl.technique("lispsm").parameterize(scene, light, camera)  # wrong: incompatible type "Camera"
    sl.technique("lispsm").parameterize(scene, camera, light, 512)  # wrong: Too many positional arguments
    sl.technique("lispsm").parameterise(scene, camera, light)  # wrong: has no attribute "parameterise"
    sl.Technique("lispsm", near=camera)  # wrong: Argument "near" to "Technique" has incompatible type "Camera"
    sl.Parameterization.from_matrix(np.eye(4), selection="nearest")  # wrong: expected "Literal['depth', 'containment']"
    sl.Parameterization.from_matrix(np.eye(4), "opengl")  # wrong: Too many positional arguments
    sl.Parameterization.from_matrix(np.eye(4), convention=4)  # wrong: Argument "convention" to "from_matrix"
    p.to(None)  # wrong: Argument 1 to "to" of "Parameterization" has incompatible type "None"
    p.partitions[0].eye_depth[2]  # wrong: Tuple index out of range
    sl.Convention("row")  # wrong: Too many positional arguments
    sl.Convention(vectors="rows")  # wrong: expected "Literal['column', 'row']"
    sl.Convention(y="right")  # wrong: expected "Literal['up', 'down']"
    sl.diagnose(p, np.eye(4), camera=scene)  # wrong: incompatible type "Scene"; expected "Camera | None"
    sl.diagnose("mine.npy", p)  # wrong: Argument 1 to "diagnose" has incompatible type "str"
    sl.diagnose(np.eye(4))  # wrong: Missing positional argument "theirs"


def of_renderers(scene: sl.Scene, camera: sl.Camera, light: types.Light, p: sl.Parameterization) -> None:
    renderer = sl.Renderer("vulkan")  # wrong: expected "Literal['cpu', 'gpu', 'auto']"
    renderer.gbuffer(scene, camera, (320, 180))  # wrong: Too many positional arguments
    renderer.gbuffer("@forest", camera, size=64)  # wrong: incompatible type "str"; expected "Scene"
    renderer.gbuffer(scene, camera, size=64.5)  # wrong: Argument "size" to "gbuffer"
    renderer.shadow_map(scene, "lispsm")  # wrong: Argument 2 to "shadow_map" of "Renderer" has incompatible type "str"
    renderer.shadow_map(scene, p, 64)  # wrong: Too many positional arguments
    renderer.shadow_mask(scene, camera, "sun", p, size=64)  # wrong: Argument 3 to "shadow_mask"
    renderer.shadow_mask(scene, camera, light, p, size=64, filter=3)  # wrong: Argument "filter" to "shadow_mask"
    renderer.shadow_mask(scene, camera, light, p, size=64, bias=0.01)  # wrong: expected "Bias | None"
    renderer.shadow_mask(scene, camera, light, p)  # wrong: Missing named argument "size"
    sl.Bias(0.01)  # wrong: Too many positional arguments
    sl.Bias(worlds=0.01)  # wrong: Unexpected keyword argument "worlds"
    sl.trace.shadow_mask(scene, camera, None, size=64)  # wrong: No overload variant of "shadow_mask"
    sl.trace.shadow_mask(scene, camera, light, size=64).lit  # wrong: has no attribute "lit"


def of_errors(scene: sl.Scene, camera: sl.Camera, light: types.Light, g: sl.GBuffer, p: sl.Parameterization) -> None:
    sl.aliasing.footprint(scene, camera, light, p)  # wrong: incompatible type "Scene"; expected "GBuffer"
    sl.aliasing.footprint(g, camera, light, p, 512)  # wrong: Too many positional arguments
    sl.aliasing.footprint(g, camera, light, p).majors  # wrong: "Footprint" has no attribute "majors"
    sl.aliasing.footprint(g, camera, light, p).summary(bands={"near": 1})  # wrong: Argument "bands" to "summary"
    sl.aliasing.usage(g, camera, light, p, filter=None)  # wrong: Argument "filter" to "usage"
    sl.aliasing.look_up(g, g, camera, light, p)  # wrong: Argument 1 to "look_up" has incompatible type "GBuffer"
    sl.aliasing.causes(scene, camera, light, p, [0], [0], gbuffer=g)  # wrong: Missing named argument "maps"
    sl.aliasing.misclassified([[0]], [[0]]).counts  # wrong: "Misclassified" has no attribute "counts"
    sl.aliasing.light_at_angle(light, 30)  # wrong: expected "Camera"
    sl.aliasing.temporal(scene, [light], light)  # wrong: expected "Camera"
    scene.with_transforms("all", None)  # wrong: Argument 2 to "with_transforms"
    sl.TemporalFit(3)  # wrong: Argument 1 to "TemporalFit" has incompatible type "int"
    sl.aliasing.over_light_angle(scene, camera, [30], 5)  # wrong: Argument 4 to "over_light_angle"


def of_experiments(scene: sl.Scene, camera: sl.Camera, light: types.Light, view: sl.View) -> None:
    sl.evaluate(scene, "lispsm")  # wrong: incompatible type "Scene"; expected "View"
    sl.evaluate(view, "lispsm", "1024")  # wrong: Argument 3 to "evaluate" has incompatible type "str"
    sl.evaluate(view, "lispsm", metrics=["misclasified"])  # wrong: expected "Literal['mask', 'misclassified'
    sl.evaluate(view, "lispsm", renderer="vulkan")  # wrong: Argument "renderer" to "evaluate"
    sl.evaluate(view, "lispsm").mask.shape  # wrong: Item "None" of
    sl.explain_pixel(view, "lispsm", 3)  # wrong: Missing positional argument "y" in call to "explain_pixel"
    sl.explain_pixel(view, "lispsm", 3, 4.5)  # wrong: Argument 4 to "explain_pixel" has incompatible type "float"
    sl.explain_pixel(scene, "lispsm", 3, 4)  # wrong: incompatible type "Scene"; expected "View"
    sl.evaluate(view, ["lispsm"])  # wrong: Argument 2 to "evaluate" has incompatible type "list[str]"
    sl.compare(scene, light, camera)  # wrong: incompatible type "Camera"
    sl.compare(scene, camera, light, ["lispsm"], 512)  # wrong: Too many positional arguments
    sl.compare(scene, camera, light, {"mine": None})  # wrong: Dict entry 0 has incompatible type "str": "None"
    sl.compare(scene, camera, light, resolutions=[512])  # wrong: Unexpected keyword argument "resolutions"
    sl.compare(scene, camera, light, renderer=object())  # wrong: incompatible type "object"
    sl.compare(scene, camera, light).tabel  # wrong: "Study" has no attribute "tabel"
    sl.compare(scene, camera, light).truth.shape  # wrong: Item "None" of
    sl.compare(scene, camera, light).masks[256]  # wrong: Invalid index type "int"
    sl.compare(scene, camera, light).save(directory=3)  # wrong: Argument "directory" to "save" of "Study"
    sl.advise(scene, camera, light, memory=None)  # wrong: Argument "memory" to "advise"
    sl.advise(scene, camera, light, memory="1 MiB", over="sum")  # wrong: expected "Literal['mean', 'worst']"
    sl.advise(scene, camera, light, memory="1 MiB", error="acne")  # wrong: Argument "error" to "advise"
    sl.advise(scene, {"a": light}, light, memory=1)  # wrong: expected "str": "Camera"
    sl.advise(scene, camera, light, memory=1).best_for("noon")  # wrong: Too many positional arguments


def of_sweeps(space: dict[str, object]) -> None:
    sl.sweep("@robots")  # wrong: Argument 1 to "sweep"
    sl.sweep(space, metrics=["misclassifed"])  # wrong: incompatible type
    sl.sweep(space, store=3)  # wrong: Argument "store" to "sweep"
    sl.sweep(space, workers="two")  # wrong: Argument "workers" to "sweep"
    sl.random(space, "10", seed=1)  # wrong: Argument 2 to "random"


def of_plots(camera: sl.Camera, light: types.Light, g: sl.GBuffer, p: sl.Parameterization) -> None:
    e = sl.aliasing.footprint(g, camera, light, p)
    sl.plot.error_map(p)  # wrong: incompatible type "Parameterization"; expected "Footprint"
    sl.plot.error_map(e, "title")  # wrong: incompatible type "str"; expected "Axes | None"
    sl.plot.error_histogram(e, quantity="size")  # wrong: Argument "quantity" to "error_histogram"
    sl.plot.error_along_view({"a": [1, 2, 3]}, near=1, far=2)  # wrong: incompatible type "str": "list[int]"
    sl.plot.lattice(g, camera, light, p, light)  # wrong: expected "Axes | None"
    sl.plot.warped_view(p, light)  # wrong: expected "Camera"
    sl.plot.study_figure(e)  # wrong: incompatible type "Footprint"; expected "Study"
    sl.plot.error_map(e).figures  # wrong: "Axes" has no attribute "figures"
    sl.plot.eye_view(g, "sun", np.zeros((2, 2)))  # wrong: Argument 2 to "eye_view" has incompatible type "str"
    sl.plot.lines(sl.Store("runs.sqlite"), "x", "y")  # wrong: incompatible type "Store"; expected "DataFrame"
    sl.Store("runs.sqlite", journal="none")  # wrong: Argument "journal" to "Store" has incompatible type
    sl.Store("runs.sqlite").put("a", {"share": [1]})  # wrong: Dict entry 0 has incompatible type "str": "list[int]"
