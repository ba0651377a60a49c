"""Rectilinear maps: fewer wrong pixels than the homography they start from, and values like any other."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError
from shadowlab.reports.study_arrays import padded_knots

SCENES = ("courtyard", "robots", "ceiling", "skylight", "dueling")


@pytest.fixture(scope="module")
def views():
    found = []
    for name in SCENES:
        scene = sl.library.scene(name)
        found.append(sl.View(scene, scene.camera.replace(aspect=1.0), scene.light, size=(256, 256), label=name))
    return found


def made(view, technique="rectilinear", resolution=512):
    return sl.technique(technique).parameterize(
        view.scene, view.camera, view.lights[0], resolution=resolution, samples=view.samples()
    )


def wrong(view, technique, resolution=512):
    run = sl.evaluate(view, technique, resolution, metrics=["misclassified"], renderer="cpu")
    assert not run.failure
    return run.row()["misclassified"]


@pytest.mark.parametrize("base", ["scene_optimal", "lispsm", "uniform"])
def test_it_has_fewer_wrong_pixels_than_its_base(views, base):
    own = base if base != "uniform" else "uniform:fit=shadow"
    counts = [(wrong(view, f"rectilinear:base={base}"), wrong(view, own)) for view in views]
    warped, plain = np.sum(counts, axis=0)
    assert warped < 0.9 * plain
    for of_view in counts:
        assert of_view[0] <= 1.1 * of_view[1] + 3


def test_normal_makes_more_than_twice_as_many_more_mistakes_than_it(views):
    normal, own = (sum(wrong(view, text) for view in views) for text in ("uniform:turn=rectangle", "rectilinear"))
    assert normal > 2.5 * own


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
    p = made(view)
    assert any(part.post_warp == "rectilinear" for part in p.partitions)
    assert wrong(view, "rectilinear") <= 1.05 * wrong(view, "scene_optimal") + 3


@pytest.mark.parametrize("scheme", ["z_partition:count=2,inner=", "face_partition:inner="])
def test_inside_of_partitions(views, scheme):
    p = made(views[0], f"{scheme}rectilinear")
    assert any(part.post_warp == "rectilinear" for part in p.partitions)
    assert {part.technique for part in p.partitions} == {"rectilinear"}
    assert wrong(views[0], f"{scheme}rectilinear") < wrong(views[0], f"{scheme}uniform")


def test_knots_are_those_that_points_are_moved_by(views):
    for view in views:
        (part,) = made(view).partitions
        g = view.gbuffer("cpu")
        points = np.asarray(g.position)[np.asarray(g.triangle) >= 0][::97]
        ndc, w = part.project(points)
        clip = np.column_stack([points, np.ones(len(points))]) @ part.matrix.T
        before = clip[:, :2] / clip[:, 3:]
        np.testing.assert_allclose(w, clip[:, 3], rtol=1e-12)
        for axis, knots in enumerate(part.post_warp_knots):
            assert (np.diff(knots, axis=0) > 0).all()
            np.testing.assert_array_equal(knots[[0, -1]], [(-1, -1), (1, 1)])
            inside = np.abs(before[:, axis]) <= 1
            after = np.interp(before[inside, axis], *knots.T)
            np.testing.assert_allclose(ndc[inside, axis], after, rtol=0, atol=1e-12)


def test_the_width_across_edges_is_that_of_the_warped_texels(views):
    for view in views:
        samples, p = view.samples(renderer="cpu"), made(view, "rectilinear:cap=32,floor=0.1")
        assert np.isclose(samples.edge_width(p), p.values["edge_width"], rtol=1e-6)
        assert p.values["edge_width"] < 0.97 * p.values["edge_width_even"]


def test_such_maps_are_equal_by_content_and_travel(views):
    p, other = made(views[1]), made(views[1], "rectilinear:floor=0.25")
    for twin in (made(views[1]), copy.deepcopy(p), pickle.loads(pickle.dumps(p))):
        assert twin == p
        assert hash(twin) == hash(p)
        np.testing.assert_array_equal(twin.partitions[0].post_warp_knots[1], p.partitions[0].post_warp_knots[1])
    assert p != other
    even = [(-1, -1), (1, 1)]
    one, changed = (
        sl.Parameterization.from_matrix(np.eye(4), post_warp=[("rectilinear", [(-1, -1), (at, 0), (1, 1)], even)])
        for at in (0.1, 0.2)
    )
    assert one != changed
    assert hash(one) != hash(changed)
    assert 'base="scene_optimal"' in repr(p)


def test_texel_coordinates_and_sizes_are_those_of_the_warped_map(views):
    for view in views[:2]:
        p, (light,) = made(view), view.lights
        g = view.gbuffer("cpu")
        texel, which = sl.aliasing.texel_coordinates(g, view.camera, light, p, resolution=512)
        ndc, _ = p.partitions[0].project(np.asarray(g.position)[which >= 0])
        expected = (0.5 + 0.5 * ndc[:, :2] * (1, -1)) * 512
        # Positions of a G-buffer are single precision relative to the scene.
        np.testing.assert_allclose(texel[which >= 0], expected, atol=0.05)
        lattice = sl.plot.lattice(g, view.camera, light, p, resolution=512, every=16)
        assert lattice is not None


def test_arrays_of_a_study_have_the_knots(views, tmp_path):
    view = views[1]
    names = ["rectilinear", "z_partition:count=2,inner=rectilinear/lispsm", "lispsm"]
    study = sl.compare(
        view.scene, view.camera, view.lights[0], names, resolution=64, size=(64, 64), renderer="cpu", progress=False
    )
    arrays = np.load(study.save_arrays(tmp_path / "study.npz"))
    knots = study.runs[0].parameterization.partitions[0].post_warp_knots
    np.testing.assert_array_equal(arrays["run_0_post_warp_x"], knots[0][None])
    assert np.isnan(arrays["run_1_post_warp_y"][1]).all()
    assert not np.isnan(arrays["run_1_post_warp_y"][0]).any()
    assert "run_2_post_warp_x" not in arrays
    assert padded_knots(study.runs[2].parameterization.partitions, 0) is None


def test_what_cannot_express_it_refuses_by_name(views):
    p = made(views[1])
    with pytest.raises(ArgumentError, match="x to the right and y up"):
        p.to("direct3d_texture")
    with pytest.raises(ArgumentError, match="post-warp"):
        sl.diagnose(p, p)
    with pytest.raises(ArgumentError, match=r"base: expected .* without fit"):
        sl.technique("rectilinear:base=(lispsm:fit=seen)")
    with pytest.raises(ArgumentError, match="fit: expected one of shadow, seen"):
        sl.technique("rectilinear:fit=exact")
