"""The noise of wrong pixels: maps shifted by parts of a texel, and the mean and deviation of their counts."""

from __future__ import annotations

import doctest
import statistics

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError
from shadowlab.experiments import run as run_module
from shadowlab.experiments.phases import PHASES, Scatter, shifted, shifts

SIZE = (160, 90)
# Rounding of a matrix in f64, where coordinates are of the size of a map.
ROUNDING_TEXELS = 1e-7


@pytest.fixture(scope="module")
def view():
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=SIZE)


def test_shifts_begin_with_none_are_small_and_fill_the_square():
    found = shifts(64)
    assert found[0] == (0.0, 0.0)
    assert shifts(PHASES) == found[:PHASES]
    assert all(-0.5 <= d < 0.5 for pair in found for d in pair)
    # Evenly: modulo one texel no two are closer than half of what squares of equal area would be apart.
    for count in (2, 3, 8, 16, 64):
        points = np.array(found[:count])
        apart = np.abs(points[:, None] - points[None])
        apart = np.minimum(apart, 1 - apart)
        distances = np.hypot(*apart.T)[np.triu_indices(count, 1)]
        assert distances.min() > 0.5 / np.sqrt(count)


@pytest.mark.parametrize(
    "name",
    ["uniform", "lispsm", "log", "log_psm", "rectilinear", "z_partition:count=3", "face_partition", "plane_optimal"],
)
def test_a_shift_moves_every_receiver_by_as_many_texels_and_none_changes_nothing(view, name):
    resolution, (dx, dy) = 128, (0.375, -0.25)
    gbuffer = view.gbuffer("cpu")
    p = sl.technique(name).parameterize(view.scene, view.camera, view.light, resolution=resolution)
    looks = (gbuffer, view.camera, view.light)
    before, chosen = sl._core.texel_coordinates(*looks, p, resolution=resolution)
    after, again = sl._core.texel_coordinates(*looks, shifted(p, dx, dy, resolution), resolution=resolution)
    inside = (chosen >= 0) & (again == chosen)
    assert inside.sum() > 0.9 * (chosen >= 0).sum() > 0
    # Rows of texels are counted from the top, y goes up.
    moved = (after - before)[inside]
    np.testing.assert_allclose(moved, np.broadcast_to((dx, -dy), moved.shape), atol=ROUNDING_TEXELS * resolution)
    same = shifted(p, 0.0, 0.0, resolution)
    renderer = sl.Renderer("cpu")
    maps = [renderer.shadow_map(view.scene, q, resolution=resolution) for q in (p, same)]
    np.testing.assert_array_equal(*maps)


def test_no_receiver_leaves_the_map(view):
    """Half a texel is less than the border of the fit."""
    # Of a map that holds all receivers, so that no lit one lies at its border.
    p = sl.technique("lispsm").by_body().parameterize(view.scene, view.camera, view.light, resolution=64)
    looks = (view.gbuffer("cpu"), view.camera, view.light)
    _, before = sl._core.texel_coordinates(*looks, p, resolution=64)
    for dx, dy in [*shifts(PHASES), (0.5, 0.5), (-0.5, -0.5)]:
        _, chosen = sl._core.texel_coordinates(*looks, shifted(p, dx, dy, 64), resolution=64)
        np.testing.assert_array_equal(chosen, before)


@pytest.mark.parametrize("name", ["uniform", "z_partition:count=2"])
def test_counts_are_those_of_shifted_maps_drawn_by_hand(view, name):
    run = sl.evaluate(view, name, 96, metrics=["misclassified"], renderer="cpu", phases=4)
    renderer, counts = sl.Renderer("cpu"), []
    for dx, dy in shifts(4):
        p = shifted(run.parameterization, dx, dy, 96)
        mask = renderer.shadow_mask(view.scene, view.camera, view.light, p, resolution=96, size=SIZE)
        counts.append(int(sl.aliasing.misclassified(mask, view.truth()).count))
    assert len(set(counts)) > 1
    assert run.numbers["phases"] == 4
    assert run.numbers["misclassified"] == counts[0]
    assert run.numbers["misclassified_mean"] == pytest.approx(statistics.fmean(counts))
    assert run.numbers["misclassified_sd"] == pytest.approx(statistics.stdev(counts))
    again = sl.evaluate(view, name, 96, metrics=["misclassified"], renderer="cpu", phases=4)
    names = ("misclassified", "phases", "misclassified_mean", "misclassified_sd")
    assert [again.numbers[name] for name in names] == [run.numbers[name] for name in names]


def test_the_deviation_foretells_other_shifts(view):
    """The mean over eight shifts lies within three standard errors of that over 64, of which they are a part."""
    run = sl.evaluate(view, "uniform", 128, metrics=["misclassified"], renderer="cpu")
    few, many = run.over_phases(PHASES).numbers, run.over_phases(64).numbers
    error = few["misclassified_sd"] / PHASES**0.5
    assert error > 0
    assert abs(few["misclassified_mean"] - many["misclassified_mean"]) < 3 * error
    assert 0.4 < few["misclassified_sd"] / many["misclassified_sd"] < 2.5


def test_lights_are_shifted_together(view):
    lights = [view.light, sl.DirectionalLight((-1, -1, 0.2))]
    both = sl.View(view.scene, view.camera, lights, size=SIZE)
    run = sl.evaluate(both, "uniform", 64, metrics=["misclassified"], renderer="cpu", phases=3)
    counts = [[part._drawn().count_at(*shift) for shift in shifts(3)] for part in run.parts]
    sums = Scatter(tuple(a + b for a, b in zip(*counts, strict=True)))
    assert {name: run.numbers[name] for name in sums.columns} == sums.columns
    assert run.numbers["misclassified"] == sums.counts[0]


def test_one_count_has_no_deviation_and_a_failure_stays():
    assert Scatter((5,)).sd == 0.0
    scene = sl.library.scene("robots")
    view = sl.View(scene, scene.camera, sl.PointLight((0, 4, 0), range=30), size=(16, 9))
    failed = sl.evaluate(view, "tsm", 64, renderer="cpu", phases=8)
    assert failed.failure
    assert failed.row()["phases"] is None


@pytest.mark.parametrize("phases", [0, -1, 2.0, True, "8", None])
def test_wrong_numbers_of_phases_are_refused(view, phases):
    with pytest.raises(ArgumentError, match="phases: expected a whole number of shifts from 1 on"):
        sl.evaluate(view, "uniform", 64, phases=phases)


def test_phases_need_the_truth(view):
    run = sl.evaluate(view, "uniform", 64, metrics=["texels"], renderer="cpu")
    with pytest.raises(ArgumentError, match="phases: expected a run held against the truth"):
        run.over_phases()
    with pytest.raises(ArgumentError, match="from 2 on"):
        run.over_phases(1)


def test_the_example_of_the_documentation_holds():
    result = doctest.testmod(run_module)
    assert (result.failed, result.attempted > 0) == (0, True)
