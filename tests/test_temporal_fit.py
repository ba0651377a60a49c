"""Held maps: the same bits while they serve, new ones where they do not, and never one that loses a shadow."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError, UnsupportedError

SIZE = (160, 90)
RESOLUTION = 256
# A map of a scheme with several, each fitted to samples.
SPLITS = "z_partition:count=2,inner=(lispsm)"


def moved(camera, ahead=0.0, aside=0.0, turn=0.0):
    """The camera a way ahead and aside, world units, and turned to the right, radians."""
    forward, right = np.asarray(camera.forward), np.asarray(camera.right)
    eye = np.asarray(camera.eye) + ahead * forward + aside * right
    return sl.Camera.look_at(
        eye, eye + np.cos(turn) * forward + np.sin(turn) * right, up=camera.up, fov_y=camera.fov_y,
        aspect=camera.aspect, near=camera.near, far=camera.far,
    )  # fmt: skip


def samples_of(scene, camera, light):
    return sl.View(scene, camera, light, size=SIZE).samples(renderer="cpu")


def step(fit, scene, camera, light, resolution=RESOLUTION):
    """The maps of the next frame, and the samples that they are for."""
    samples = samples_of(scene, camera, light)
    return fit.parameterize(scene, camera, light, resolution=resolution, samples=samples), samples


def walk(scene, steps, share):
    """Steps ahead, aside and of turning, lengths as a share of the median depth."""
    camera = scene.camera
    depth = np.asarray(sl.View(scene, camera, scene.light, size=SIZE).gbuffer("cpu").view_depth)
    way = share * float(np.median(depth[np.isfinite(depth)]))
    third = steps // 3
    for i in range(steps):
        ahead, aside, turns = min(i, third), min(max(i - third, 0), third), max(i - 2 * third, 0)
        yield moved(camera, way * ahead, way * aside, share * turns)


@pytest.fixture(scope="module")
def robots():
    return sl.library.scene("robots")


@pytest.mark.parametrize("technique", ["scene_optimal", "lispsm:fit=seen", "log", SPLITS])
def test_a_camera_that_stands_still_gets_the_same_bits(robots, technique):
    fit = sl.TemporalFit(technique)
    first, _ = step(fit, robots, robots.camera, robots.light)
    assert (fit.kept, fit.fits, fit.reason) == (False, 1, "first")
    for _ in range(3):
        again, _ = step(fit, robots, robots.camera, robots.light)
        assert again.matrices.tobytes() == first.matrices.tobytes()
        assert (fit.kept, fit.reason) == (True, "")
    assert (fit.fits, fit.frames, fit.cost) == (1, 4, 1.0)


def test_a_small_step_keeps_the_maps_and_a_large_one_does_not(robots):
    fit = sl.TemporalFit()
    first, _ = step(fit, robots, robots.camera, robots.light)
    near, samples = step(fit, robots, moved(robots.camera, turn=0.0005), robots.light)
    assert near == first
    assert fit.kept
    assert samples.missed(near) == 0
    far_camera = moved(robots.camera, turn=-0.6)
    far, samples = step(fit, robots, far_camera, robots.light)
    assert samples.missed(first) > 0
    assert fit.reason == f"samples left the maps: {samples.missed(first)}"
    assert (fit.kept, fit.fits, fit.cost) == (False, 2, None)
    # New maps are those of the technique itself.
    own = sl.technique("scene_optimal", slack=fit.slack)
    assert far == own.parameterize(robots, far_camera, robots.light, resolution=RESOLUTION, samples=samples)


@pytest.mark.parametrize("name", ["courtyard", "robots", "ceiling", "skylight", "dueling", "forest"])
@pytest.mark.parametrize("technique", ["scene_optimal", "lispsm:fit=seen", SPLITS])
def test_kept_maps_hold_what_they_must_and_are_about_as_good_as_new_ones(name, technique):
    scene = sl.library.scene(name, **({"trees": 200} if name == "forest" else {}))
    fit = sl.TemporalFit(technique, gain=1.1)
    kept = 0
    for camera in walk(scene, 9, 0.01):
        before = fit.parameterization
        p, samples = step(fit, scene, camera, scene.light)
        assert samples.missed(p, fit.technique.holds) == 0
        new = fit.technique.parameterize(scene, camera, scene.light, resolution=RESOLUTION, samples=samples)
        width, best = samples.edge_width(p), samples.edge_width(new)
        assert width <= 1.1 * best
        if fit.kept:
            assert p.matrices.tobytes() == before.matrices.tobytes()
            kept += 1
        elif fit.reason != "first":
            # A switch is for a reason: what left, or the gain that is stated.
            lost = samples.missed(before, fit.technique.holds)
            assert lost > 0 or samples.edge_width(before) > 1.1 * best
            assert fit.reason.startswith("samples left" if lost else "cost")
    assert fit.frames == 9
    assert fit.fits == 9 - kept


def test_maps_are_switched_for_the_gain_that_is_stated(robots):
    camera = moved(robots.camera, ahead=3.0)
    fits = {gain: sl.TemporalFit("scene_optimal", slack=2.0, gain=gain) for gain in (1.0, 1.05, 4.0, math.inf)}
    for gain, fit in fits.items():
        first, _ = step(fit, robots, robots.camera, robots.light)
        p, samples = step(fit, robots, camera, robots.light)
        assert samples.missed(first) == 0
        if gain == math.inf:
            assert fit.kept
            assert fit.cost is None
            continue
        new = fit.technique.parameterize(robots, camera, robots.light, resolution=RESOLUTION, samples=samples)
        cost = samples.edge_width(first) / samples.edge_width(new)
        assert fit.cost == cost > 1
        assert fit.kept == (cost <= gain)
        assert fit.reason == ("" if fit.kept else f"cost {cost:.2f} times a fresh fit's")
        assert p == (first if fit.kept else new)
    assert fits[4.0].kept
    assert not fits[1.0].kept


def test_a_light_scene_or_resolution_that_changes_makes_new_maps(robots):
    fit = sl.TemporalFit()
    step(fit, robots, robots.camera, robots.light)
    turned = sl.DirectionalLight(np.asarray(robots.light.direction) + 1e-3)
    step(fit, robots, robots.camera, turned)
    assert fit.reason == "the light moved"
    step(fit, robots, robots.camera, turned, resolution=(RESOLUTION, 2 * RESOLUTION))
    assert fit.reason == "another resolution"
    assert fit.parameterization.resolution == (RESOLUTION, 2 * RESOLUTION)
    other = robots.transformed(np.diag([1.01, 1.01, 1.01, 1.0]))
    step(fit, other, robots.camera, turned, resolution=(RESOLUTION, 2 * RESOLUTION))
    assert fit.reason == "the scene changed"
    step(fit, other, robots.camera, turned, resolution=[RESOLUTION, 2 * RESOLUTION])
    assert (fit.kept, fit.fits) == (True, 4)
    fit.reset()
    assert (fit.parameterization, fit.frames, fit.fits, fit.reason, fit.kept) == (None, 0, 0, "", False)


@pytest.mark.parametrize("kind", ["spot", "point"])
def test_placed_lights_are_held_too(robots, kind):
    low, high = np.asarray(robots.bounds)
    above = 0.5 * (low + high) + (0, 4 * (high[1] - low[1]), 0)
    light = (
        sl.PointLight(above, range=500)
        if kind == "point"
        else sl.SpotLight(above, (0.05, -1, 0.1), cone_angle=1.6, range=500)
    )
    fit = sl.TemporalFit(slack=1.2)
    first, _ = step(fit, robots, robots.camera, light)
    again, samples = step(fit, robots, moved(robots.camera, turn=0.001), light)
    assert len(first.partitions) == (6 if kind == "point" else 1)
    assert again == first
    assert samples.missed(again) == 0


def test_samples_are_drawn_where_none_are_given_and_taken_from_a_picture(robots):
    fits = [sl.TemporalFit() for _ in range(2)]
    how = (robots, robots.camera, robots.light)
    drawn = fits[0].parameterize(*how, resolution=RESOLUTION)
    assert drawn == sl.technique("scene_optimal", slack=fits[0].slack).parameterize(*how, resolution=RESOLUTION)
    picture = sl.Renderer("cpu").gbuffer(robots, robots.camera, size=SIZE)
    assert fits[1].parameterize(*how, resolution=RESOLUTION, samples=picture) == step(sl.TemporalFit(), *how)[0]
    for fit in fits:
        fit.parameterize(*how, resolution=RESOLUTION)
        assert fit.frames == 2


def test_where_no_shadow_is_seen_the_maps_stay(robots):
    fit = sl.TemporalFit()
    first, _ = step(fit, robots, robots.camera, robots.light)
    sky = sl.Camera.look_at(robots.camera.eye, np.asarray(robots.camera.eye) + np.array([0.1, 1, 0]))
    p, samples = step(fit, robots, sky, robots.light)
    assert samples.receivers == 0
    assert p == first
    assert fit.kept
    with pytest.raises(UnsupportedError, match="three visible points"):
        step(sl.TemporalFit(), robots, sky, robots.light)


@pytest.mark.parametrize("technique", ["scene_optimal", "lispsm", "log"])
def test_slack_leaves_room_on_all_sides_and_behind(robots, technique):
    samples = samples_of(robots, robots.camera, robots.light)
    low, high = np.asarray(robots.bounds)
    inside = np.c_[low + np.random.default_rng(5).random((20_000, 3)) * (high - low), np.ones(20_000)]
    spans = []
    for slack in (1.0, 1.25, 1.9):
        t = sl.technique(technique, slack=slack, margin=0)
        p = t.parameterize(robots, robots.camera, robots.light, resolution=RESOLUTION, samples=samples)
        held = np.asarray(p.matrix)
        clip = inside @ held.T
        ndc = clip[:, :3] / clip[:, 3:]
        over = (clip[:, 3] > 0) & (np.abs(ndc[:, :2]) <= 1).all(axis=1)
        assert over.sum() > 100
        # Whatever lies over a map with slack has its depth; without, what the camera does not see need not.
        assert slack == 1 or ndc[over, 2].max() <= 1
        wide = sl.technique(technique, slack=slack * 1.02, margin=0)
        wider = wide.parameterize(robots, robots.camera, robots.light, resolution=RESOLUTION, samples=samples)
        assert samples.edge_width(wider) > samples.edge_width(p)
        spans.append(samples.edge_width(p))
    # Texels are wider by the slack: a little less where the width is capped, or a search finds a better warp.
    assert 1.1 < spans[1] / spans[0] < 1.3
    assert 1.4 < spans[2] / spans[0] < 1.95


def projected(matrix, points, size):
    """Where points (N, 3) are in an image of a clip matrix, pixels or texels, y down."""
    clip = np.c_[points, np.ones(len(points))] @ np.asarray(matrix).T
    return (0.5 + clip[:, :2] / clip[:, 3:] * (0.5, -0.5)) * size


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "scene_optimal"])
def test_widths_across_edges_are_finite_differences_along_surfaces(robots, technique):
    """(10.7) and (10.8) by steps along the tangent plane, in the picture and in the map."""
    samples = samples_of(robots, robots.camera, robots.light)
    p = sl.technique(technique).parameterize(
        robots, robots.camera, robots.light, resolution=RESOLUTION, samples=samples
    )
    points, normals = np.asarray(samples.positions), np.asarray(samples.normals)
    first = np.cross(normals, np.roll(normals, 1, axis=1) + np.array([0.3, -0.2, 0.5]))
    steps = [1e-4 * v / np.linalg.norm(v, axis=1, keepdims=True) for v in (first, np.cross(normals, first))]

    def slopes(matrix, size):
        return np.stack([projected(matrix, points + v, size) - projected(matrix, points - v, size) for v in steps], -1)

    # d(pixel) / d(texel) = d(pixel) / d(step) (d(texel) / d(step))^-1
    jacobian = slopes(robots.camera.clip_from_world, SIZE) @ np.linalg.inv(slopes(p.matrix, 2 * [RESOLUTION]))
    widths = np.abs(np.einsum("ni,nij->nj", np.asarray(samples.edge_normals, float), jacobian)).sum(axis=1)
    expected = np.average(32 * (1 - np.exp(-widths / 32)), weights=samples.weights)
    assert len(widths) > 500
    assert samples.edge_width(p) == pytest.approx(expected, rel=1e-4)
    # Of maps with many texels nothing is capped: half the texels, twice the width.
    fine, finer = (samples.edge_width(p, resolution=k * RESOLUTION) for k in (32, 64))
    assert fine / finer == pytest.approx(2, rel=2e-2)


def test_an_edge_that_no_map_holds_counts_as_the_cap(robots):
    samples = samples_of(robots, robots.camera, robots.light)
    away = sl.Parameterization.from_matrix(np.diag([1e-9, 1e-9, 1, 1]) + 5 * np.eye(4, k=3), resolution=64)
    assert samples.edge_width(away) == 32
    assert samples.missed(away) > 0
    assert samples.missed(away, "seen") == samples.outside(away)[0] > samples.missed(away)
    with pytest.raises(ArgumentError, match="holds"):
        samples.missed(away, "body")


def test_what_cannot_be_held_is_refused():
    for technique in ("uniform", "lispsm:range=body,fit=exact", "uniform:stable=true", "z_partition"):
        with pytest.raises(ArgumentError, match="fit=shadow"):
            sl.TemporalFit(technique)
    matrix = sl.Parameterization.from_matrix(np.eye(4))
    for technique in (sl.preset("godot"), matrix, 3, None):
        with pytest.raises(ArgumentError, match="technique: expected a Technique or its name"):
            sl.TemporalFit(technique)
    with pytest.raises(UnknownNameError):
        sl.TemporalFit("scene_optimum")
    for slack in (0.9, 2.1, math.nan, "1.1", True, None):
        with pytest.raises(ArgumentError, match="slack"):
            sl.TemporalFit(slack=slack)
    for gain in (0.99, -math.inf, math.nan, "1", True):
        with pytest.raises(ArgumentError, match="gain"):
            sl.TemporalFit(gain=gain)


def test_bad_frames_are_refused_and_change_nothing(robots):
    fit = sl.TemporalFit()
    step(fit, robots, robots.camera, robots.light)
    before = pickle.dumps(fit)
    other = samples_of(robots, robots.camera, sl.DirectionalLight((0.2, -1, 0.1)))
    bare = sl.Samples.from_gbuffer(sl.Renderer("cpu").gbuffer(robots, robots.camera, size=SIZE), robots.camera)
    good = (robots, robots.camera, robots.light)
    for samples in (other, bare, 3):
        with pytest.raises(ArgumentError, match="samples"):
            fit.parameterize(*good, resolution=RESOLUTION, samples=samples)
    for arguments in ((3, *good[1:]), (robots, 3, robots.light), (*good[:2], 3)):
        with pytest.raises(ArgumentError):
            fit.parameterize(*arguments, resolution=RESOLUTION)
    for resolution in (0, 2, "64", (64, 64, 64)):
        with pytest.raises(ArgumentError, match="resolution"):
            fit.parameterize(*good, resolution=resolution)
    assert pickle.dumps(fit) == before


def test_what_it_remembers_travels(robots):
    fit = sl.TemporalFit("lispsm", slack=1.25, gain=1.5)
    p, _ = step(fit, robots, robots.camera, robots.light)
    again = pickle.loads(pickle.dumps(fit))
    assert again == fit
    assert hash(again) == hash(fit)
    assert step(again, robots, robots.camera, robots.light)[0] == p
    assert again.kept
    assert again != fit
    assert fit.fresh() == sl.TemporalFit("lispsm", slack=1.25, gain=1.5)
    assert repr(fit) == "TemporalFit('lispsm:slack=1.25', slack=1.25, gain=1.5: 1 fits in 1 frames)"


def test_along_a_path_held_maps_flip_less_and_cost_little(robots):
    held = sl.TemporalFit()
    found = sl.aliasing.temporal(
        robots, list(walk(robots, 10, 0.01)), robots.light,
        {"each": "scene_optimal", "held": held, "stable": "uniform:stable=true"},
        resolution=512, size=(320, 180), renderer="cpu", progress=False,
    )  # fmt: skip
    assert held.frames == 0  # a fresh copy walked
    frames = found.frames.set_index(["technique", "frame"])
    assert frames.loc[("held", 0), "reason"] == "first"
    assert (frames.loc["held", "refit"] == (frames.loc["held", "reason"] != "")).all()
    assert frames.loc["each", "refit"].all()
    assert (frames.loc["each", "reason"] == "").all()
    summary = found.summary.set_index("technique")
    assert summary.loc["each", "refits"] == 10
    assert summary.loc["held", "refits"] < 5
    flips = found.table.groupby("technique")["flips"].sum()
    assert flips["held"] < 0.5 * flips["each"]
    assert summary.loc["held", "misclassified"] < 1.2 * summary.loc["each", "misclassified"]
    # Between frames that share their maps nothing flips.
    steps = found.table[found.table["technique"] == "held"].set_index("frame")
    for frame in range(9):
        if not frames.loc[("held", frame + 1), "refit"]:
            assert steps.loc[frame, "flips"] == 0
            assert steps.loc[frame, "drift_max"] == 0


def test_wrong_pixels_of_frames_are_those_of_evaluate(robots):
    path = list(walk(robots, 3, 0.01))
    found = sl.aliasing.temporal(
        robots, path, robots.light, ["lispsm"], resolution=256, size=SIZE, renderer="cpu", progress=False
    ).frames
    for frame, camera in enumerate(path):
        run = sl.evaluate(
            sl.View(robots, camera, robots.light, size=SIZE), "lispsm", 256, metrics=["misclassified"], renderer="cpu"
        )
        assert found.loc[frame, "misclassified"] == run.row()["misclassified"]
