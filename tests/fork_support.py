"""Work in a small view, and its answer from another process."""

from __future__ import annotations

import multiprocessing
from functools import cache

import numpy as np
import pytest

import shadowlab as sl

#: Seconds that a forked process has for work of milliseconds.
LIMIT = 10
#: Seconds that a process has that must import everything first.
LIMIT_OF_A_NEW_ONE = 120
SIZE = (48, 32)
SQUARE = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
FACES = [[0, 2, 1], [0, 3, 2]]


def made_scene():
    return sl.Scene.from_arrays(4 * SQUARE, FACES) + sl.Scene.from_arrays(SQUARE + np.array([0, 1.0, 0]), FACES)


@cache
def view():
    """A square above a floor, a camera, a light, maps: the same objects at each call, and in the child of a fork."""
    scene = made_scene()
    camera = sl.Camera.look_at((0, 3, 5), (0, 0, 0), aspect=1.5, near=1.0, far=20.0)
    light = sl.DirectionalLight((0.3, -1, 0.1))
    return scene, camera, light, sl.technique("lispsm").parameterize(scene, camera, light, resolution=64)


@cache
def renderer():
    return sl.Renderer("cpu")


def shadow_map():
    scene, _, _, p = view()
    return renderer().shadow_map(scene, p)


def gbuffer():
    scene, camera, _, _ = view()
    g = renderer().gbuffer(scene, camera, size=SIZE)
    return g.depth, g.position, g.normal, g.triangle, g.instance


def shadow_mask():
    return renderer().shadow_mask(*view(), size=SIZE)


def chosen_map():
    scene, camera, light, _ = view()
    p = sl.technique("z_partition", count=3).parameterize(scene, camera, light, resolution=64)
    return renderer().chosen_map(scene, camera, light, p, size=SIZE)


def logarithmic_map():
    scene, camera, light, _ = view()
    p = sl.technique("log").parameterize(scene, camera, light, resolution=64)
    return renderer().shadow_map(scene, p)


def truth():
    scene, camera, light, _ = view()
    return sl.trace.shadow_mask(scene, camera, light, size=SIZE)


def truth_of_a_new_scene():
    _, camera, light, _ = view()
    return sl.trace.shadow_mask(made_scene(), camera, light, size=SIZE)


def first_hit():
    origins = np.random.default_rng(1).uniform(-3, 3, (500, 3))
    return sl.trace.first_hit(view()[0], origins, np.roll(origins, 1, axis=0))


def occluded():
    origins = np.random.default_rng(2).uniform(-3, 3, (500, 3))
    return sl.trace.occluded(view()[0], origins, np.roll(origins, 1, axis=0), t_max=2.0)


def footprint():
    scene, camera, light, p = view()
    e = renderer().footprint(scene, camera, light, p, size=SIZE)
    return e.major, e.minor, e.perspective


def errors():
    scene, camera, light, p = view()
    g = renderer().gbuffer(scene, camera, size=SIZE)
    texels = sl.aliasing.footprint(g, camera, light, p)
    causes = sl.aliasing.causes(
        scene, camera, light, p, shadow_mask(), truth(), gbuffer=g, maps=renderer().shadow_map(scene, p)
    )
    return texels.major, sl.aliasing.usage(g, camera, light, p).reads, causes.image


def library_scene():
    built = sl.library.scene("robots")
    return built.bounds, built.transforms


def moved_scene():
    scene = view()[0]
    moved = scene.with_transforms([1], scene.transforms[[0]])
    return moved.bounds, moved.transforms


def open_meshes():
    # More edges than are sorted by one thread.
    side = np.arange(41)
    points = np.stack(np.meshgrid(side, [0.0], side), axis=-1).reshape(-1, 3)
    faces = np.array([[i, i + 41, i + 1] for i in range(40 * 41) if i % 41 < 40])
    scene = sl.Scene.from_arrays(points, faces)
    p = sl.technique("uniform").parameterize(scene, *view()[1:3], resolution=64)
    with pytest.warns(sl.errors.ShadowlabWarning, match="open"):
        return renderer().shadow_map(scene, p, stored="back")


def compare():
    scene, camera, light, _ = view()
    study = sl.compare(
        scene, camera, light, ["uniform", "lispsm"], resolution=64, size=SIZE, renderer="cpu", progress=False
    )
    table = study.table
    return table.select_dtypes("number").drop(columns=[c for c in table if c.endswith(("_us", "_ms"))]).to_numpy(float)


def advise():
    scene, camera, light, _ = view()
    advice = sl.advise(
        scene, camera, light, memory="16 KiB", techniques=["uniform", "lispsm"], size=SIZE, renderer="cpu",
        progress=False,
    )  # fmt: skip
    return advice.verdict


def parameterize_with_samples():
    scene, camera, light, _ = view()
    technique = sl.technique("z_partition", splits="min-max")
    assert technique.needs_samples
    g = renderer().gbuffer(scene, camera, size=SIZE)
    own = technique.parameterize(scene, camera, light, resolution=64)
    return own.matrices, technique.parameterize(scene, camera, light, resolution=64, samples=g).matrices


def named_renderer():
    return repr(renderer())


#: What works in parallel, by name; each returns what it found.
WORK = {
    work.__name__: work
    for work in (
        shadow_map, gbuffer, shadow_mask, chosen_map, logarithmic_map, truth, truth_of_a_new_scene, first_hit, occluded,
        footprint, errors, library_scene, moved_scene, open_meshes, compare, advise, parameterize_with_samples,
        named_renderer,
    )
}  # fmt: skip


def same(a, b):
    """Whether two answers are equal to the last bit."""
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
    return type(a) is type(b) and a == b


def _tell(work, sender):
    try:
        sender.send(work())
    except BaseException as error:  # noqa: BLE001 - the parent shows it
        sender.send(f"{type(error).__name__}: {error}")


def answer_of(work, method="fork", limit=LIMIT):
    """What work returns in another process, or its error as text; one that takes too long is killed and a failure."""
    context = multiprocessing.get_context(method)
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_tell, args=(work, sender))
    process.start()
    sender.close()
    try:
        if not receiver.poll(limit):
            pytest.fail(f"no answer within {limit} seconds")
        answer = receiver.recv()
        process.join(limit)
        assert process.exitcode == 0, f"the process ended with {process.exitcode}"
        return answer
    finally:
        process.kill()
        process.join()
