"""The figures of scene-optimized maps: samples where they are, the search's steps, a row per light."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from plot_support import legend, lone_axes, texts

import shadowlab as sl
from shadowlab.errors import ArgumentError
from shadowlab.experiments import scene_optimal_views
from shadowlab.experiments.columns import TABLES, frame
from shadowlab.experiments.scene_optimal_table import NORMAL, SceneOptimalTable
from shadowlab.pictures.samples import pale_eye_view, pixels_of
from shadowlab.plot import percent_more, samples_and_maps, samples_view, search_history

mpl.use("Agg")


@pytest.fixture(scope="module")
def view():
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=(160, 90))


def test_samples_are_drawn_where_the_picture_shows_them(view):
    samples = view.samples(renderer="cpu")
    pixels = pixels_of(view.camera, view.size, samples.positions)
    g = view.gbuffer("cpu")
    column, row = np.rint(pixels).astype(int).T
    # Samples of a G-buffer are the centres of its pixels, to the rounding of f32 positions.
    assert np.abs(pixels - np.rint(pixels)).max() < 0.01
    assert np.abs(np.asarray(g.position)[row, column] - samples.positions).max() < 1e-3
    ax = samples_view(view, lone_axes(), renderer="cpu")
    drawn = sum(len(points.get_offsets()) for points in ax.collections)
    assert drawn == np.asarray(samples.edge_normals).any(axis=1).sum()
    assert ax.get_title() == f"{drawn:,} samples at the edges of shadows"
    assert ax.get_xlim() == (-0.5, 159.5)
    shadowed = ax.collections[0].get_offsets()
    states = view.truth()[np.rint(shadowed[:, 1]).astype(int), np.rint(shadowed[:, 0]).astype(int)]
    # By a map of 1024 x 1024 texels, not by rays.
    assert (states == 0).mean() > 0.8


def test_a_pale_picture_is_lighter_and_keeps_its_order(view):
    picture = pale_eye_view(view.gbuffer("cpu"), view.lights[0], view.truth())
    shaded = sl.plot.shade(view.gbuffer("cpu"), view.lights[0], sl.plot.truth_mask(view.truth()))
    assert picture.dtype == np.uint8
    assert (picture >= shaded).all()
    assert picture.min() > 120


def test_the_search_only_falls_and_ends_at_the_error_of_the_map(view):
    p = sl.technique("scene_optimal:search=published").parameterize(
        view.scene, view.camera, view.lights[0], resolution=256, samples=view.samples(renderer="cpu")
    )
    ax = search_history(p, lone_axes())
    steps = ax.lines[0].get_ydata()
    assert 1 <= len(steps) <= 4
    assert (np.diff(steps) < 0).all()
    assert steps[-1] == dict(p.values)["error"]
    assert texts(ax) == ["uniform map"]
    with pytest.raises(ArgumentError, match="whose search has a history, got lispsm"):
        search_history(sl.technique("lispsm").parameterize(view.scene, view.camera, view.lights[0]))


def test_a_row_per_light_and_a_column_per_technique(view):
    several = sl.View(view.scene, view.camera, (view.lights[0], sl.DirectionalLight((-1, -0.5, 0.2))), size=view.size)
    figure = samples_and_maps(several, [NORMAL, "scene_optimal"], resolution=64, renderer="cpu")
    assert len(figure.axes) == 2 * 3
    run = sl.evaluate(several.views[1], "scene_optimal", 64, metrics=["misclassified"], renderer="cpu")
    assert figure.axes[5].get_title().startswith("scene_optimal\n")
    assert figure.axes[5].get_title().endswith(f"{sl.text.share_text(run.errors.fraction)} wrong")
    spot = sl.SpotLight(np.add(view.camera.eye, (0, 5, 0)), (0, -1, -0.5), cone_angle=1.5, range=60)
    refused = samples_and_maps(
        sl.View(view.scene, view.camera, spot, size=view.size), ["gmnpr"], resolution=64, renderer="cpu"
    )
    assert "gmnpr" in texts(refused.axes[1])[0]


def test_curves_have_the_numbers_of_the_table():
    rows = [
        {"view": "a", "technique": t, "single_side": n, "misclassified": wrong, "misclassified_by_map": wrong // 2}
        for n in (100, 200)
        for t, wrong in ((NORMAL, 3000 // (n // 100)), ("lispsm", 2000 // (n // 100)))
    ]
    result = SceneOptimalTable(frame(TABLES["scene_optimal"], rows), 3700, "cpu", "")
    ax = percent_more(result, lone_axes())
    assert legend(ax) == ["lispsm"]
    np.testing.assert_allclose(ax.lines[0].get_ydata().astype(float), [50.0, 50.0])
    assert isinstance(result.totals, pd.DataFrame)


def test_the_paper_views_have_three_lights_then_two():
    views = scene_optimal_views.paper_views(90)
    assert [(name, len(view.lights)) for name, view in views.items()] == [
        ("dueling", 3),
        ("skylight", 2),
        ("statues", 1),
    ]
    dueling = views["dueling"]
    # Towards the viewer: against the view, within 35 degrees.
    assert all(np.degrees(np.pi - of.light_angle) < 35 for of in dueling.views)
