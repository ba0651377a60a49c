"""Calls that a type checker must take, with what each of them returns; tests/test_types.py runs mypy over them.

Nothing here is executed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from typing_extensions import assert_type

import shadowlab as sl
from shadowlab import types
from shadowlab.experiments.by_run import ByRun

Floats64 = npt.NDArray[np.float64]


def scenes() -> None:
    scene = sl.library.scene("forest", seed=3, trees=40)
    assert_type(scene.camera, sl.Camera)
    assert_type(scene.light, sl.DirectionalLight | sl.SpotLight | sl.PointLight)
    assert_type(sl.load_scene("model.glb", up="z"), sl.Scene)
    assert_type(sl.load_scene(b"v 0 0 0", kind="obj", unit="mm", limits=sl.Limits(size=1000)), sl.Scene)
    assert_type(sl.Scene.from_arrays(np.zeros((3, 3)), [[0, 1, 2]]) + scene, sl.Scene)
    assert_type(scene.with_ground(up="y").bounds, Floats64)
    assert_type(sl.turned((0, 0, 1), up="z"), Floats64)
    assert_type(sl.default_views(scene), tuple[sl.View, ...])
    camera, light = sl.default_view(scene, aspect=16 / 9, view="above")
    assert_type(camera, sl.Camera)
    assert_type(light, sl.DirectionalLight)
    assert_type(camera.fov_y, float)
    assert_type(light.kind, Literal["directional"])
    assert_type(sl.library.names(), list[str])
    assert_type(sl.library.table(), pd.DataFrame)


def cameras_and_lights() -> None:
    camera = sl.Camera.look_at((0, 2, 5), [0, 0, 0], up=np.array([0.0, 1, 0]), fov_y=1.0, near=0.1, far=100)
    assert_type(camera.depth([[0, 0, 0]]), Floats64)
    plan = sl.Camera.orthographic((0, 9, 0), (0, 0, 0), (0, 0, -1), height=20, near=-1, far=20, shift=(0, 0.5))
    assert_type(plan.replace(height=10.0, shift=(0, 0)), sl.Camera)
    assert_type(plan.is_orthographic, bool)
    assert_type(plan.shift, tuple[float, float])
    assert_type(plan.corners(2), Floats64)
    assert_type(plan.rays([(0.5, 0.5)], (64, 36)), tuple[Floats64, Floats64])
    lights: list[types.Light] = [
        sl.DirectionalLight((0.3, -1, 0.1)),
        sl.SpotLight((0, 5, 0), (0, -1, 0), cone_angle=1.0, range=20),
        sl.PointLight((0, 5, 0), range=20),
    ]
    for light in lights:
        if light.kind == "directional":
            assert_type(light, sl.DirectionalLight)
        elif light.kind == "spot":
            assert_type(light.cone_angle, float)


def techniques(scene: sl.Scene, camera: sl.Camera, light: sl.DirectionalLight) -> None:
    technique = sl.technique("lispsm", near="optimal")
    assert_type(technique, types.TechniqueLike)
    p = technique.parameterize(scene, camera, light, resolution=512)
    assert_type(p, sl.Parameterization)
    assert_type(p.matrices, Floats64)
    assert_type(p.partitions[0].eye_depth, tuple[float, float])
    assert_type(p.selection, Literal["depth", "containment"])
    assert_type(sl.technique(p), sl.Parameterization)
    assert_type(sl.technique(sl.preset("filament")), sl.Preset)
    assert_type(sl.technique("matrix", file="mine.npy", convention="opengl"), sl.Parameterization)
    assert_type(sl.Technique("z_partition", count=3, inner=["uniform", sl.Technique("lispsm")]), sl.Technique)
    assert_type(sl.technique("z_partition", distances=[1.0, 5.0], stable=True).settings["stable"], Any)
    assert_type(sl.techniques(), pd.DataFrame)
    assert_type(sl.preset("bevy").parameterize(scene, camera, light), sl.Parameterization)
    assert_type(sl.Parameterization.from_matrix(np.eye(4), convention=sl.Convention.opengl()), sl.Parameterization)


def conventions() -> None:
    convention = sl.Convention(vectors="row", axes="x,-z,y", tile=[(0, 0, 0.5, 1), (0.5, 0, 0.5, 1)])
    assert_type(convention.to_ours(np.eye(4)), Floats64)
    found = sl.diagnose(np.eye(4), convention.from_ours(np.eye(4)), resolution=2048)
    assert_type(found.convention, sl.Convention)
    assert_type(found.differences, tuple[str, ...])


def renders(scene: sl.Scene, camera: sl.Camera, light: sl.PointLight, p: sl.Parameterization) -> None:
    renderer = sl.Renderer("cpu")
    assert_type(renderer.backend, Literal["cpu", "gpu"])
    gbuffer = renderer.gbuffer(scene, camera, size=(320, 180))
    assert_type(gbuffer.depth, npt.NDArray[np.float32])
    maps = renderer.shadow_map(scene, p, resolution=[512, 256])
    mask = renderer.shadow_mask(scene, camera, light, p, size=64, bias=sl.Bias(world=0.01), filter="bilinear")
    truth = sl.trace.shadow_mask(scene, camera, light, size=64)
    assert_type(truth, npt.NDArray[np.int8])
    assert_type(sl.aliasing.misclassified(mask, truth).fraction, float)
    footprint = sl.aliasing.footprint(gbuffer, camera, light, np.eye(4), resolution=512)
    assert_type(footprint.measured, npt.NDArray[np.bool_])
    assert_type(footprint.summary(bands=[1, 10, 100]).max, float | None)
    assert_type(sl.aliasing.usage(gbuffer, camera, light, p, filter="nearest").unused, float)
    found = sl.aliasing.causes(scene, camera, light, p, mask, truth, gbuffer=gbuffer, maps=maps)
    assert_type(found.counts["acne"], int)


class Engine:
    """Somebody's own renderer: it needs no base class."""

    backend = "engine"
    adapter = "none"

    def gbuffer(self, scene: types.SceneLike, camera: sl.Camera, *, size: types.Size) -> sl.GBuffer:
        return sl.Renderer("cpu").gbuffer(scene, camera, size=size)

    def shadow_map(
        self, scene: types.SceneLike, parameterization: types.Maps, *, resolution: types.Size | None = None
    ) -> npt.NDArray[np.float32]:
        return sl.Renderer("cpu").shadow_map(scene, parameterization, resolution=resolution)

    def shadow_mask(
        self,
        scene: types.SceneLike,
        camera: sl.Camera,
        light: types.Light,
        parameterization: types.Maps,
        *,
        size: types.Size,
        resolution: types.Size | None = None,
        bias: sl.Bias | None = None,
        filter: types.Filter = "nearest",
    ) -> types.Mask:
        return sl.Renderer("cpu").shadow_mask(scene, camera, light, parameterization, size=size, filter=filter)


def experiments(scene: sl.Scene, camera: sl.Camera, light: sl.SpotLight) -> None:
    view = sl.View(scene, camera, light, size=None, label="noon")
    assert_type(view.size, tuple[int, int])
    assert_type(view.light, types.Light | tuple[types.Light, ...])
    assert_type(view.truth(), types.TruthImage | Any)
    _first, _second = sl.View(scene, camera, [light, light], (64, 64)).truth()
    why = sl.explain_pixel(view, "lispsm", 3, 4, resolution=256, bias=sl.Bias(world=0.1), filter="bilinear")
    assert_type(why, sl.PixelExplanation)
    assert_type(why.figure(), Figure)
    assert_type(why.edge_px, float | None)
    assert_type(why.x, int)
    run = sl.evaluate(view, "lispsm", 256, metrics=["misclassified", "usage"], renderer=Engine())
    if run.mask is not None and run.errors is not None:
        assert_type(run.mask, types.Mask | Any)
        assert_type(run.errors.count, int | Any)
    assert_type(run.row(), dict[str, Any])
    study = sl.compare(scene, camera, light, {"mine": np_technique(), "all": "all"}, renderer="auto", resolution=[256])
    assert_type(study, sl.Study)
    assert_type(study.table, pd.DataFrame)
    assert_type(study.masks, ByRun[npt.NDArray[np.float32]])
    assert_type(study.masks["mine", 256], npt.NDArray[np.float32])
    assert_type(study.causes["mine"].acne, int)
    assert_type(study.footprint("mine"), sl.aliasing.Footprint)
    assert_type(study.light, types.Light)
    assert_type(study.figure(), Figure)
    advice = sl.advise(
        scene, [camera], {"noon": light}, memory=["1 MiB", 2**22], error="p95", over="worst", techniques=["uniform"]
    )
    assert_type(advice, sl.Advice)
    assert_type(sl.advise(scene, camera, light, predict=foretold, drawn=3), sl.Advice)
    assert_type(advice.best.technique, types.TechniqueLike | sl.Parameterization)
    assert_type(advice.reproduce(advice.table.iloc[0]), str)
    angles = sl.aliasing.over_light_angle(scene, camera, range(0, 90, 10), "uniform", renderer="cpu")
    assert_type(angles.crossovers("share"), pd.DataFrame)
    assert_type(sl.aliasing.temporal(scene, [camera, camera], light).summary, pd.DataFrame)
    moved = scene.with_transforms([0], scene.transforms[:1])
    assert_type(moved, sl.Scene)
    assert_type(sl.aliasing.temporal([scene, moved], camera, [light, light]), sl.aliasing.Temporal)
    held = sl.TemporalFit("lispsm", slack=1.1)
    assert_type(held.parameterize(scene, camera, light, resolution=(64, 128)), sl.Parameterization)
    assert_type(sl.aliasing.temporal(scene, [camera, camera], light, {"held": held}).frames, pd.DataFrame)
    assert_type(sl.aliasing.light_at_angle(camera, 45), sl.DirectionalLight)
    assert_type(sl.report().works, bool)
    assert_type(sl.Study.load("report/"), sl.Study)
    assert_type(sl.Advice.load(Path("advice"), scene=scene), sl.Advice)
    with sl.Store("runs.sqlite", journal="delete") as store:
        store.put("a", {"technique": "lispsm", "misclassified": 1, "share": 0.5, "notes": None}, done=False)
        assert_type(store.missing(["a"]), list[str])
        assert_type(store.rows(iter(["a"]))["a"]["share"], bool | int | float | str | None)
    assert_type(sl.read_store("runs.sqlite", where="maps > 1"), pd.DataFrame)


def sweeps(scene: sl.Scene, light: types.Light, store: sl.Store) -> None:
    space = {"scene": [scene, "@robots"], "light": {"sun": light}, "technique": "lispsm", "lispsm.near": [1, 2]}
    assert_type(sl.sweep(space, size=(64, 36), store=store, workers=2, metrics=["misclassified", wide]), pd.DataFrame)
    assert_type(sl.sweep(sl.random(space, 10, seed=1), store="runs.sqlite", metrics=wide, timeout=60), pd.DataFrame)


def wide(run: sl.Run) -> dict[str, float]:
    return {"width": float(run.view.size[0])}


def foretold(view: sl.View, technique: types.Item, *, resolution: int) -> float:
    return float(resolution * len(view.label))


def np_technique() -> sl.Preset:
    return sl.preset("godot")


def plots(gbuffer: sl.GBuffer, camera: sl.Camera, light: sl.SpotLight, p: sl.Parameterization, ax: Axes) -> None:
    footprint = sl.aliasing.footprint(gbuffer, camera, light, p)
    assert_type(sl.plot.error_map(footprint, ax, gbuffer=gbuffer, light=light), Axes)
    assert_type(sl.plot.error_histogram({"a": footprint, "b": footprint.summary()}, quantity="minor"), Axes)
    assert_type(sl.plot.lattice(gbuffer, camera, light, p, every=8, resolution=(512, 256)), Axes)
    assert_type(sl.plot.error_along_view({"a": ([1, 2], [0.1, 0.2])}, near=1, far=2), Axes)
    assert_type(sl.plot.warped_view(p, camera, map=0), Axes)
    runs = sl.read_store("runs.sqlite")
    assert_type(sl.plot.lines(runs, "resolution", "wrong", None, ax), Axes)
    assert_type(sl.plot.heatmap(runs, "light", "technique", "wrong", title="wrong"), Axes)
    assert_type(sl.plot.pareto(runs, cost="memory", error="wrong"), Axes)
