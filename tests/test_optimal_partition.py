"""Scene-optimal partitions: fewer wrong pixels than one map and than cascades of the same memory, under every light."""

from __future__ import annotations

import math

import numpy as np
import pytest

import shadowlab as sl

SCENES = ("courtyard", "robots", "dueling", "forest")
SIDE = 512


@pytest.fixture(scope="module")
def views():
    found = []
    for name in SCENES:
        scene = sl.library.scene(name, **({"trees": 300} if name == "forest" else {}))
        found.append(sl.View(scene, scene.camera.replace(aspect=1.0), scene.light, size=(256, 256), label=name))
    return found


def maps_of(view, technique, side=SIDE):
    return sl.technique(technique).parameterize(
        view.scene, view.camera, view.lights[0], resolution=side, samples=view.samples(renderer="cpu")
    )


def wrong(view, technique):
    """Wrong pixels of maps that take the memory of one of `SIDE` texels."""
    count = len(maps_of(view, technique).partitions)
    run = sl.evaluate(view, technique, round(SIDE / math.sqrt(count)), metrics=["misclassified"], renderer="cpu")
    assert not run.failure
    return run.row()["misclassified"]


def test_it_has_fewer_wrong_pixels_than_one_map_and_than_cascades_of_the_same_memory(views):
    names = ("optimal_partition", "optimal_partition:count=2", "scene_optimal", "z_partition:count=2,inner=lispsm",
             "z_partition:count=4,inner=lispsm", "uniform:turn=rectangle")  # fmt: skip
    total = {name: sum(wrong(view, name) for view in views) for name in names}
    for own in names[:2]:
        for other in names[2:]:
            assert total[own] < total[other], (own, other, total)
    assert total["uniform:turn=rectangle"] > 2.3 * total["optimal_partition:count=2"]


def test_auto_takes_a_count_that_depends_on_the_view(views):
    counts = [len(maps_of(view, "optimal_partition").partitions) for view in views]
    assert all(1 <= count <= 4 for count in counts)
    assert len(set(counts)) > 1, counts
    assert maps_of(views[0], "optimal_partition:count=3").settings["count"] == 3


@pytest.mark.parametrize("kind", ["spot", "point"])
def test_placed_lights_have_such_maps_too(kind):
    scene = sl.library.scene("robots")
    place = np.asarray(scene.camera.eye) + 6.0 * np.asarray(scene.camera.forward) + (2.0, 6.0, 1.0)
    lamp = (
        sl.SpotLight(place, (-0.2, -1, 0.1), cone_angle=1.6, range=60)
        if kind == "spot"
        else sl.PointLight(place, range=60)
    )
    view = sl.View(scene, scene.camera.replace(aspect=1.0), lamp, size=(128, 128))
    p = maps_of(view, "optimal_partition:count=2", 256)
    assert view.samples(renderer="cpu").outside(p)[1] == 0
    assert wrong(view, "optimal_partition:count=2") <= 1.1 * wrong(view, "uniform") + 3


def test_where_depths_are_alike_there_are_fewer_maps_and_a_note():
    # A wall across the view, and a plate that shades a part of it.
    parts = []
    for half, depth in ((10.0, -10.0), (0.5, -8.0)):
        corners = [(-half, -half, depth), (half, -half, depth), (half, half, depth), (-half, half, depth)]
        parts.append((np.array(corners), np.array([(0, 1, 2), (0, 2, 3)])))
    (wall, faces), (plate, _) = parts
    scene = sl.Scene.from_arrays(np.concatenate([wall, plate]), np.concatenate([faces, faces + 4]))
    camera = sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=1.0, aspect=1.0, near=0.1, far=50)
    view = sl.View(scene, camera, sl.DirectionalLight((0.3, -0.2, -1)), size=(96, 96))
    p = maps_of(view, "optimal_partition:count=8", 256)
    assert 1 <= len(p.partitions) < 8
    (note,) = (note for note in p.notes if note.kind == "fewer_maps")
    assert f"{len(p.partitions)} maps of 8" in str(note)


@pytest.mark.parametrize(("text", "said"), [("count=0", "1 to 8"), ("count=9", "1 to 8"), ("count=1.5", "whole"),
                                            ("count=many", "auto"), ("objective=flips", "edge")])  # fmt: skip
def test_what_is_no_setting_is_said(text, said):
    with pytest.raises(sl.errors.ArgumentError, match=said):
        sl.technique(f"optimal_partition:{text}")
