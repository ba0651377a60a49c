"""Scene-optimal maps: fewer wrong pixels than the maps they compete with, under every light, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl

SCENES = ("courtyard", "robots", "ceiling", "dueling")


@pytest.fixture(scope="module")
def views():
    found = []
    for name in SCENES:
        scene = sl.library.scene(name)
        found.append(sl.View(scene, scene.camera.replace(aspect=1.0), scene.light, size=(256, 256), label=name))
    return found


def wrong(view, technique, resolution=512):
    run = sl.evaluate(view, technique, resolution, metrics=["misclassified"], renderer="cpu")
    assert not run.failure
    return run.row()["misclassified"]


def test_it_has_fewer_wrong_pixels_than_the_normal_map_and_the_best_warp_of_one_family(views):
    counts = {
        name: [wrong(view, name) for view in views]
        for name in ("scene_optimal", "scene_optimal:search=published", "lispsm", "uniform:turn=rectangle")
    }
    total = {name: sum(of) for name, of in counts.items()}
    assert total["scene_optimal"] < total["lispsm"] < total["uniform:turn=rectangle"]
    assert total["scene_optimal"] < total["scene_optimal:search=published"] < total["uniform:turn=rectangle"]
    # Normal makes so many more mistakes.
    assert total["uniform:turn=rectangle"] > 2.0 * total["scene_optimal"]
    for own, normal in zip(counts["scene_optimal"], counts["uniform:turn=rectangle"], strict=True):
        assert own <= 1.05 * normal + 3


@pytest.mark.parametrize("objective", ["edge", "l1", "l2", "area"])
def test_no_objective_is_worse_than_that_of_the_uniform_map(views, objective):
    for view in views:
        for cap in ("none", "8"):
            t = sl.technique(f"scene_optimal:objective={objective},cap={cap}")
            p = t.parameterize(view.scene, view.camera, view.lights[0], resolution=512, samples=view.samples())
            assert p.values["error"] <= p.values["error_uniform"]


def test_both_searches_tell_the_error_of_the_uniform_map_in_the_same_measure(views):
    for view in views:
        published, full = (
            sl.technique(text).parameterize(
                view.scene, view.camera, view.lights[0], resolution=512, samples=view.samples()
            )
            for text in ("scene_optimal:search=published", "scene_optimal:objective=l2")
        )
        assert 0 < published.values["error"] < np.inf
        assert np.isclose(full.values["error_uniform"], published.values["error_uniform"], rtol=1e-12)


def made(view, technique):
    """Its map for the view's own samples."""
    return sl.technique(technique).parameterize(
        view.scene, view.camera, view.lights[0], resolution=512, samples=view.samples(renderer="cpu")
    )


@pytest.mark.parametrize("objective", ["edge", "l1", "l2", "area"])
def test_what_the_search_makes_small_is_a_sum_over_texels_in_the_image(views, objective):
    for view in views:
        samples, p = view.samples(renderer="cpu"), made(view, f"scene_optimal:objective={objective},cap=none")
        texels = sl.aliasing.footprint_at(
            samples.positions, samples.normals, view.camera, view.lights[0], p, size=view.size
        ).jacobian
        normals = samples.edge_normals.astype(float)
        counts = {
            "edge": lambda g, n=normals: np.abs(np.einsum("ni,nij->nj", n, g)).sum(axis=1),
            "l1": lambda g: np.linalg.svd(g, compute_uv=False)[:, 0],
            "l2": lambda g: (g**2).sum(axis=(1, 2)),
            "area": lambda g: np.abs(np.linalg.det(g)),
        }[objective](np.asarray(texels))
        # Two ways to the same double precision.
        assert np.isclose(np.average(counts, weights=samples.weights), p.values["error"], rtol=1e-9)


def test_no_known_map_has_less_error(views):
    known = ("lispsm", "plane_optimal:fallback=uniform", "uniform:turn=rectangle,fit=shadow", "uniform:fit=shadow",
             "scene_optimal:search=published")  # fmt: skip
    for view in views:
        # Widths of `edge_width` count up to 32 pixels.
        p = made(view, "scene_optimal:cap=32")
        samples, error = view.samples(renderer="cpu"), p.values["error"]
        assert np.isclose(samples.edge_width(p), error, rtol=1e-9)
        for technique in known:
            assert error <= samples.edge_width(made(view, technique)) * (1 + 1e-9), technique


def test_the_walk_over_flips_foretells_no_more_of_them(views):
    for view in views:
        p = made(view, "scene_optimal:objective=flips")
        assert 0 < p.values["error"] <= p.values["error_uniform"] < 1
        foretold = [float(sl.predict(view, name, 512, renderer="cpu")) for name in
                    ("scene_optimal:objective=flips", "scene_optimal")]  # fmt: skip
        # Of other receivers, and on one surface.
        assert foretold[0] < 1.1 * foretold[1]


def test_the_same_samples_give_the_same_map(views):
    view = views[1]
    one, two = (
        sl.technique("scene_optimal").parameterize(
            view.scene, view.camera, view.lights[0], resolution=512, samples=view.samples()
        )
        for _ in range(2)
    )
    assert one == two


@pytest.mark.parametrize("light", ["spot", "point"])
def test_placed_lights_have_such_maps_too(light):
    scene = sl.library.scene("robots")
    place = np.asarray(scene.camera.eye) + 6.0 * np.asarray(scene.camera.forward) + (2.0, 6.0, 1.0)
    lamp = (
        sl.SpotLight(place, (-0.2, -1, 0.1), cone_angle=1.6, range=60)
        if light == "spot"
        else sl.PointLight(place, range=60)
    )
    view = sl.View(scene, scene.camera.replace(aspect=1.0), lamp, size=(256, 256))
    assert wrong(view, "scene_optimal") <= 1.05 * wrong(view, "uniform") + 3


def test_inside_of_partitions(views):
    view = views[0]
    assert wrong(view, "z_partition:count=2,inner=scene_optimal") < wrong(view, "z_partition:count=2")


@pytest.mark.parametrize("count", [0, 1, 2])
def test_fewer_than_three_samples_are_an_error_that_says_what_was_visible(views, count):
    view = views[1]
    at, up = np.array([(0.0, 0.0, 0.0), (0.5, 0.0, 0.5)])[:count], np.array([(0.0, 1.0, 0.0)] * 2)[:count]
    samples = sl.Samples.from_arrays(
        at.reshape(-1, 3), up.reshape(-1, 3), view.camera, view.lights[0], shadows=np.zeros(count, np.int8)
    )
    with pytest.raises(sl.errors.UnsupportedError, match=rf"fewer than three visible points are known \({count}\)"):
        sl.technique("scene_optimal").parameterize(view.scene, view.camera, view.lights[0], samples=samples)


def test_a_cap_that_is_none_and_words_that_do_not_exist():
    assert sl.technique("scene_optimal:cap=none").settings["cap"] == "none"
    for text in ("scene_optimal:cap=0", "scene_optimal:objective=edges", "scene_optimal:fit=exact"):
        with pytest.raises(sl.errors.ArgumentError):
            sl.technique(text)
