"""Matrices from elsewhere as parameterizations and back; samples for techniques that look at what the camera sees."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError

# Two conventions there and back round each entry a few times.
ROUND_TRIP = 1e-15
PRESETS = sl.Convention.PRESETS


@pytest.fixture(scope="module")
def fitted():
    scene = sl.library.scene("robots")
    return scene, sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=256)


@pytest.mark.parametrize("name", PRESETS)
def test_export_and_import_are_each_others_inverse(fitted, name):
    _, p = fitted
    theirs = p.to(name)
    np.testing.assert_array_equal(theirs, sl.Convention.of(name).from_ours(p.matrix))
    back = sl.Parameterization.from_matrix(theirs, convention=name, resolution=256)
    assert np.abs(back.matrix - p.matrix).max() <= ROUND_TRIP * np.abs(p.matrix).max()
    assert back.resolution == 256
    assert back.technique == "matrix"


def test_an_imported_matrix_draws_the_same_map(fitted):
    scene, p = fitted
    renderer = sl.Renderer("cpu")
    theirs = p.to("opengl").tolist()
    back = sl.Parameterization.from_matrix(theirs, convention=sl.Convention(z_range=(-1, 1)))
    # Powers of two: nothing is rounded on the way.
    np.testing.assert_array_equal(
        renderer.shadow_map(scene, back, resolution=256), renderer.shadow_map(scene, p, resolution=256)
    )


def test_several_maps_have_depths_a_selection_and_tiles(fitted):
    _, p = fitted
    stack = np.array([p.matrix, np.diag([0.5, 0.5, 1, 1]) @ p.matrix])
    atlas = sl.Convention.opengl_bias().in_atlas(2)
    several = sl.Parameterization.from_matrix(
        atlas.from_ours(stack), convention=atlas, eye_depth=[(0.5, 10), (10, np.inf)], selection="containment"
    )
    np.testing.assert_allclose(several.matrices, stack, rtol=0, atol=ROUND_TRIP * np.abs(stack).max() * 4)
    assert [part.eye_depth for part in several.partitions] == [(0.5, 10.0), (10.0, np.inf)]
    assert several.selection == "containment"
    assert several.to(atlas).shape == (2, 4, 4)
    one = sl.Parameterization.from_matrix(stack[0])
    assert one.selection == "depth"
    assert one.partitions[0].eye_depth == (0.0, np.inf)
    assert one.partitions[0].region.shape == (0, 4)
    assert one.partitions[0].post_warp_terms == {}
    assert one.partitions[0].technique == "matrix"


def test_what_is_wrong_is_told(fitted):
    _, p = fitted
    make = sl.Parameterization.from_matrix
    with pytest.raises(UnknownNameError, match="unknown name 'opengles'"):
        make(p.matrix, convention="opengles")
    with pytest.raises(ArgumentError, match="convention: expected a Convention"):
        make(p.matrix, convention=7)
    with pytest.raises(UnknownNameError, match='unknown selection "nearest": expected one of depth, containment'):
        make(p.matrix, selection="nearest")
    with pytest.raises(ArgumentError, match=r"eye_depth: expected an array of shape \(1, 2\)"):
        make(p.matrix, eye_depth=[(0, 1), (1, 2)])
    for bad in ((2, 1), (-np.inf, 1), (np.nan, 1), (1, 1)):
        with pytest.raises(ArgumentError, match="eye_depth: expected a finite near depth"):
            make(p.matrix, eye_depth=[bad])
    with pytest.raises(ArgumentError, match="as many as maps"):
        p.to(sl.Convention(xy_range=(0, 1)).in_atlas(2))
    with pytest.raises(ArgumentError, match="singular"):
        make(np.zeros((4, 4)), convention="opengl")


def test_samples_are_a_gbuffer_or_nothing(fitted):
    scene, _ = fitted
    technique = sl.technique("lispsm").by_body()
    assert technique.needs_samples is False
    p = technique.parameterize(scene, scene.camera, scene.light, resolution=256)
    g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=32)
    again = technique.parameterize(scene, scene.camera, scene.light, resolution=256, samples=g)
    np.testing.assert_array_equal(again.matrix, p.matrix)
    with pytest.raises(ArgumentError, match=r"samples: expected a shadowlab.Samples, got .*ndarray"):
        technique.parameterize(scene, scene.camera, scene.light, samples=np.zeros(3))
