"""shadowlab's side of every row."""

from __future__ import annotations

import tempfile

import numpy as np
from inputs import LIGHT, bench_scene, camera
from worker import Work, of_map

import shadowlab as sl

ABOUT = f"shadowlab {sl.__version__}"


def _scene() -> sl.Scene:
    return sl.Scene.from_arrays(*bench_scene())


def _light() -> sl.DirectionalLight:
    return sl.DirectionalLight(LIGHT)


def shadow_map(side: int, backend: str = "cpu", technique: str = "lispsm", scene: str = "") -> Work:
    """One map of the bench scene, or of a scene of the library (`forest:trees=10000`) seen by its camera, to numpy."""
    made = _named(scene) if scene else _scene()
    eye, light = (made.camera, made.light) if scene else (camera(), _light())
    renderer = sl.Renderer(backend=backend)
    p = sl.technique(technique).parameterize(made, eye, light, resolution=side)
    depth = renderer.shadow_map(made, p, resolution=side)
    return Work(lambda: renderer.shadow_map(made, p, resolution=side), ABOUT, of_map(depth))


def _named(text: str) -> sl.Scene:
    name, _, settings = text.partition(":")
    options = dict(part.split("=") for part in settings.split(",") if part)
    return sl.library.scene(name, **{key: int(value) for key, value in options.items()})


def shadow_mask(side: int, size: int, filter: str = "nearest", technique: str = "lispsm") -> Work:
    """The look-up of every pixel in one map: G-buffer and map are there."""
    scene, eye, light, renderer = _scene(), camera(), _light(), sl.Renderer("cpu")
    p = sl.technique(technique).parameterize(scene, eye, light, resolution=side)
    maps, g = renderer.shadow_map(scene, p, resolution=side), renderer.gbuffer(scene, eye, size=(size, size))
    return Work(lambda: sl.aliasing.look_up(maps, g, eye, light, p, filter=filter), ABOUT)


def footprint(side: int, size: int) -> Work:
    """The size of a texel at every pixel: the own yardstick of the look-up."""
    scene, eye, light = _scene(), camera(), _light()
    p = sl.technique("lispsm").parameterize(scene, eye, light, resolution=side)
    g = sl.Renderer("cpu").gbuffer(scene, eye, size=(size, size))
    return Work(lambda: sl.aliasing.footprint(g, eye, light, p, resolution=side), ABOUT)


def rays(data: str) -> Work:
    """First hits of primary rays and occlusion of shadow rays."""
    with np.load(data) as arrays:
        given = {name: np.asarray(arrays[name], np.float64) for name in arrays.files if name != "faces"}
        scene = sl.Scene.from_arrays(given["vertices"], arrays["faces"])
    reach = np.full(len(given["shadow_origins"]), 1e3)

    def run() -> tuple[int, int]:
        hit = sl.trace.first_hit(scene, given["origins"], given["directions"])[1]
        blocked = sl.trace.occluded(scene, given["shadow_origins"], given["shadow_directions"], reach)
        return int((hit >= 0).sum()), int(blocked.sum())

    hits, blocked = run()
    return Work(run, ABOUT, {"hits": hits, "blocked": blocked})


def truth(size: int) -> Work:
    """The truth of every pixel: its rays made and traced."""
    scene, eye, light = _scene(), camera(), _light()
    return Work(lambda: sl.trace.shadow_mask(scene, eye, light, size=size), ABOUT)


def build(data: str) -> Work:
    """The hierarchy of a scene that is there, made by its first ray."""
    with np.load(data) as arrays:
        vertices, faces = arrays["vertices"].astype(np.float64), arrays["faces"]
    origin, direction = np.array([[0.0, 50.0, 0.0]]), np.array([[0.0, -1.0, 0.0]])
    return Work(
        lambda scene: sl.trace.first_hit(scene, origin, direction),
        ABOUT,
        prepare=lambda: sl.Scene.from_arrays(vertices, faces),
    )


def fit(calls: int, technique: str = "lispsm:near=basic,range=body,fit=exact", scene: str = "") -> Work:
    """`calls` matrices from Python."""
    made = _named(scene) if scene else _scene()
    eye, light = (made.camera, made.light) if scene else (camera(), _light())
    one = sl.technique(technique)

    def run() -> None:
        for _ in range(calls):
            one.parameterize(made, eye, light, resolution=1024)

    return Work(run, ABOUT)


def cascades(count: int, side: int) -> Work:
    """Maps of a z partition, or one map for a count of 1."""
    scene, eye, light, renderer = _scene(), camera(), _light(), sl.Renderer("cpu")
    technique = sl.technique("uniform" if count == 1 else f"z_partition:count={count}")
    p = technique.parameterize(scene, eye, light, resolution=side)
    return Work(lambda: renderer.shadow_map(scene, p, resolution=side), ABOUT)


def compare(pictures: bool) -> Work:
    """`sl.compare` of two techniques, saved with all its pictures or only asked for its table."""
    scene, eye, light = _scene(), camera(), _light()

    def run() -> None:
        study = sl.compare(scene, eye, light, ["uniform", "lispsm"], resolution=1024, size=(1024, 1024), renderer="cpu")
        if pictures:
            with tempfile.TemporaryDirectory() as folder:
                study.save(folder)
        else:
            _ = study.table

    return Work(run, ABOUT)


def _around(count: int) -> list[sl.DirectionalLight]:
    turns = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return [sl.DirectionalLight((np.cos(a), -1.2, np.sin(a))) for a in turns]


def states(count: int, size: int) -> Work:
    """The shadow states of one light or many of the courtyard: G-buffer, maps and look-ups, anew each time."""
    scene, renderer, all_lights = sl.library.scene("courtyard"), sl.Renderer("cpu"), _around(count)
    one = sl.technique("lispsm")
    maps = [one.parameterize(scene, scene.camera, light, resolution=1024) for light in all_lights]
    return Work(lambda: renderer.shadow_states(scene, scene.camera, all_lights, maps, size=(size, size)), ABOUT)


def lights(count: int, size: int) -> Work:
    """What one light or many cost in the courtyard: hierarchy, G-buffer, truth, maps and masks of all, made anew."""
    all_lights = _around(count)
    renderer = sl.Renderer("cpu")

    def prepare() -> sl.View:
        scene = sl.library.scene("courtyard")
        view = sl.View(scene, scene.camera, all_lights if count > 1 else all_lights[0], (size, size))
        view.clear()
        return view

    def run(view: sl.View) -> None:
        sl.evaluate(view, "lispsm", resolution=1024, renderer=renderer, metrics=("misclassified",))

    return Work(run, ABOUT, prepare=prepare)
