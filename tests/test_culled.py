"""Casters that are not drawn: masks and maps stay, counts add up, and pictures say which."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing import Casters, CullRule
from shadowlab.errors import ArgumentError, UnknownNameError

SIZE = (160, 90)


def _of(view: sl.View) -> tuple[Any, Any, Any]:
    return view.scene, view.camera, view.light


@pytest.fixture(scope="module")
def forest() -> sl.library.LibraryScene:
    return sl.library.scene("forest", trees=600)


@pytest.fixture(scope="module")
def view(forest: sl.library.LibraryScene) -> sl.View:
    return sl.View(forest, forest.camera, forest.light, size=SIZE)


@pytest.fixture(scope="module")
def renderer() -> sl.Renderer:
    return sl.Renderer("cpu")


@pytest.mark.parametrize("name", ["uniform", "lispsm", "z_partition:count=3", "log_psm"])
def test_masks_and_maps_stay(view: sl.View, renderer: sl.Renderer, name: str) -> None:
    p = sl.technique(name).parameterize(*_of(view), resolution=256)
    whole = renderer.shadow_map(view.scene, p, cull="none")
    np.testing.assert_array_equal(whole, renderer.shadow_map(view.scene, p))
    looks = (view.camera, view.light, p)
    mask = renderer.shadow_mask(view.scene, *looks, size=SIZE, cull="none")
    np.testing.assert_array_equal(mask, renderer.shadow_mask(view.scene, *looks, size=SIZE, cull="seen"))
    gbuffer = view.gbuffer(renderer)
    seen = renderer.seen_map(view.scene, gbuffer, *looks)
    assert np.asarray(seen).shape == whole.shape
    assert (seen >= whole).all(), "what is left out lets farther casters show"
    np.testing.assert_array_equal(mask, sl.aliasing.look_up(seen, gbuffer, *looks))


def test_counts_add_up(view: sl.View, renderer: sl.Renderer) -> None:
    scene, gbuffer = view.scene, view.gbuffer(renderer)
    p = sl.technique("z_partition:count=2").parameterize(scene, view.camera, view.light, resolution=256)
    picture = {"gbuffer": gbuffer, "camera": view.camera, "light": view.light}
    found = {cull: renderer.casters(scene, p, cull=cull, **picture) for cull in ("none", "volume", "seen")}
    for casters in found.values():
        assert isinstance(casters, Casters)
        assert casters.maps == 2
        assert casters.rules.shape == (2, scene.instance_count)
        assert (casters.instances.sum(axis=1) == scene.instance_count).all()
        assert (casters.triangles.sum(axis=1) == scene.triangle_count).all()
        for rule in CullRule:
            np.testing.assert_array_equal((casters.rules == rule).sum(axis=1), casters.instances[:, rule])
        table = casters.table
        assert (table[["drawn", "outside", "unseen", "behind"]].sum(axis=1) == table["instances"]).all()
        assert casters.drawn + casters.culled == 2 * scene.instance_count
    drawn = [found[cull].drawn for cull in ("none", "volume", "seen")]
    assert drawn[0] == 2 * scene.instance_count > drawn[1] > drawn[2] > 0
    assert found["seen"].instances.sum(axis=0)[CullRule.UNSEEN] > 10
    assert "instances" in repr(found["seen"])


def test_evaluate_counts_the_same_wrong_pixels(view: sl.View) -> None:
    assert sl._core.looking_pays(view.scene, SIZE)
    alone = sl.evaluate(view, "lispsm", 256, metrics=["misclassified"], renderer="cpu")
    caused = sl.evaluate(view, "lispsm", 256, metrics=["misclassified", "causes"], renderer="cpu")
    assert alone.numbers["misclassified"] == caused.numbers["misclassified"] > 0
    np.testing.assert_array_equal(alone.mask, caused.mask)
    # Maps that are shown are whole, whichever were drawn for the mask.
    np.testing.assert_array_equal(alone.maps, caused.maps)
    p = alone.parameterization
    np.testing.assert_array_equal(alone.maps, sl.Renderer("cpu").shadow_map(view.scene, p, resolution=256, cull="none"))


def test_what_is_seen_takes_a_picture(view: sl.View, renderer: sl.Renderer) -> None:
    p = sl.technique("uniform:range=body,fit=exact").parameterize(view.scene, view.camera, view.light, resolution=64)
    with pytest.raises(ArgumentError, match=r"cull.*picture"):
        renderer.shadow_map(view.scene, p, cull="seen")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="gbuffer"):
        renderer.casters(view.scene, p, cull="seen")
    with pytest.raises(ArgumentError, match="light"):
        renderer.casters(view.scene, p, cull="seen", gbuffer=view.gbuffer(renderer), camera=view.camera)
    with pytest.raises(UnknownNameError, match="volume"):
        renderer.shadow_mask(view.scene, view.camera, view.light, p, size=8, cull="all")  # type: ignore[arg-type]


def test_the_picture_of_culled_casters_names_the_rules(view: sl.View) -> None:
    import matplotlib as mpl
    from matplotlib.collections import PolyCollection

    mpl.use("Agg")

    ax = sl.plot.culled(view, "lispsm", resolution=256, title="forest")
    boxes = [c for c in ax.collections if isinstance(c, PolyCollection)]
    samples = view.samples(renderer="cpu")
    p = sl.technique("lispsm").parameterize(*_of(view), samples=samples, resolution=256)
    found = sl.Renderer("cpu").casters(
        view.scene, p, resolution=256, cull="seen", gbuffer=view.gbuffer("cpu"), camera=view.camera, light=view.light,
    )  # fmt: skip
    counts = {str(c.get_label()).split(":")[0]: len(c.get_paths()) for c in boxes}
    assert counts == {rule.name.lower(): int(found.instances[0, rule]) for rule in CullRule}
    assert ax.get_title() == "forest"
    with pytest.raises(ArgumentError, match="map"):
        sl.plot.culled(view, "lispsm", resolution=64, map=1)


def test_the_picture_has_the_casters_of_mixed_cascades(view: sl.View, renderer: sl.Renderer) -> None:
    from matplotlib.collections import PolyCollection

    text = "z_partition:count=3,overlap=0.5"
    plain, mixed = (sl.evaluate(view, f"{text}{mix}", 256, metrics=(), renderer=renderer) for mix in ("", ",mix=0.5"))
    assert mixed.blend == 0.5
    how: dict[str, Any] = {"gbuffer": view.gbuffer(renderer), "camera": view.camera, "light": view.light}
    drawn = {}
    for run in (plain, mixed):
        looks = {"bias": run.bias, "filter": run.filter, "blend": run.blend, "stored": run.stored}
        found = renderer.casters(view.scene, run.parameterization, resolution=256, cull="seen", **how, **looks)
        drawn[run.blend] = int(found.instances[1, CullRule.DRAWN])
    assert drawn[0.5] > drawn[0.0]
    for technique, blend in ((f"{text},mix=0.5", 0.0), (text, 0.5)):
        ax = sl.plot.culled(view, technique, resolution=256, map=1, renderer=renderer, blend=blend)
        labels = [str(c.get_label()) for c in ax.collections if isinstance(c, PolyCollection)]
        assert f"drawn: {drawn[0.5]:,}" in labels


def test_a_library_scene_is_that_of_its_parts(forest: sl.library.LibraryScene) -> None:
    again = sl.Scene(forest.meshes, forest.mesh_index, forest.transforms)
    assert again == forest
    np.testing.assert_array_equal(again.bounds, forest.bounds)
