"""Texels that pixels read, where receivers lie in maps, and lookups into maps that are there."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing.usage import octaves
from shadowlab.errors import ArgumentError, UnknownNameError

TECHNIQUES = ["uniform", "lispsm", "z_partition:count=3,inner=lispsm", "log", "face_partition"]


class View:
    def __init__(self, name, size=(240, 135)):
        scene = sl.library.scene(name)
        self.scene, self.camera, self.light, self.size = scene, scene.camera, scene.light, size
        self.renderer = sl.Renderer("cpu")
        self.gbuffer = self.renderer.gbuffer(scene, scene.camera, size=size)

    def maps(self, technique, resolution=256):
        return sl.technique(technique).parameterize(self.scene, self.camera, self.light, resolution=resolution)

    def seen(self, p):
        return self.gbuffer, self.camera, self.light, p


@pytest.fixture(scope="module", params=["robots", "ceiling"])
def view(request):
    return View(request.param)


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_receivers_lie_where_their_map_projects_them(view, technique):
    p = view.maps(technique)
    texel, which = sl.aliasing.texel_coordinates(*view.seen(p))
    e = sl.aliasing.footprint(*view.seen(p))
    np.testing.assert_array_equal(which, e.map)
    assert (np.isnan(texel).all(axis=-1) == (which < 0)).all()
    position = np.asarray(view.gbuffer.position)
    for k, part in enumerate(p.partitions):
        mine = which == k
        ndc, _ = part.project(position[mine])
        expected = np.column_stack([0.5 + 0.5 * ndc[:, 0], 0.5 - 0.5 * ndc[:, 1]]) * 256
        np.testing.assert_allclose(texel[mine], expected, atol=1e-6)
    assert np.count_nonzero(which >= 0) > 1000


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize(("filter", "taps"), [("nearest", 1), ("bilinear", 4)])
def test_reads_are_the_texels_of_the_coordinates(view, technique, filter, taps):
    p = view.maps(technique)
    texel, which = sl.aliasing.texel_coordinates(*view.seen(p), resolution=(300, 200))
    found = sl.aliasing.usage(*view.seen(p), resolution=(300, 200), filter=filter)
    expected = np.zeros((len(p.partitions), 200, 300), np.uint32)
    corners = [(0, 0)] if taps == 1 else [(0, 0), (1, 0), (0, 1), (1, 1)]
    shift = 0.0 if taps == 1 else 0.5
    looked = which >= 0
    for i, j in corners:
        x, y = np.moveaxis(np.floor(texel[looked] - shift).astype(int), -1, 0) + np.array([[i], [j]])
        np.add.at(expected, (which[looked], np.clip(y, 0, 199), np.clip(x, 0, 299)), 1)
    np.testing.assert_array_equal(found.reads, expected)
    assert found.pixels == np.count_nonzero(looked)
    assert found.unused == pytest.approx(np.mean(expected == 0))
    assert found.mean == pytest.approx(expected[expected > 0].mean())
    table = found.histogram
    assert table["texels"].sum() == expected.size == found.texels
    assert table["share"].sum() == pytest.approx(1)
    for row in table.itertuples():
        assert np.count_nonzero((expected >= row[1]) & (expected <= row.to)) == row.texels


def test_octaves():
    assert octaves(np.array([0, 1, 2, 3, 4, 7, 8], np.uint32)).tolist() == [0, 1, 2, 2, 3, 3, 4]


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_a_lookup_into_given_maps_is_the_mask_of_the_renderer(view, technique, filter):
    p = view.maps(technique)
    maps = view.renderer.shadow_map(view.scene, p)
    bias = sl.Bias(texels=0.3)
    ours = sl.aliasing.look_up(maps, *view.seen(p), bias=bias, filter=filter)
    theirs = view.renderer.shadow_mask(view.scene, view.camera, view.light, p, size=view.size, bias=bias, filter=filter)
    np.testing.assert_array_equal(ours, theirs)
    # One texel of one map changes what its readers see, and nothing else.
    layers = maps.reshape(-1, 256, 256).copy()
    reads = sl.aliasing.usage(*view.seen(p)).reads
    k, y, x = np.unravel_index(reads.argmax(), reads.shape)
    layers[k, y, x] = 0.0
    changed = sl.aliasing.look_up(layers if len(layers) > 1 else layers[0], *view.seen(p), bias=bias)
    before = sl.aliasing.look_up(maps, *view.seen(p), bias=bias)
    differs = (changed != before) & ~np.isnan(before)
    assert np.count_nonzero(differs) <= reads[k, y, x]
    assert (changed[differs] == 0).all()


def test_bad_input_is_told(view):
    p = view.maps("z_partition:count=3")
    maps = view.renderer.shadow_map(view.scene, p)
    with pytest.raises(ArgumentError, match="maps"):
        sl.aliasing.look_up(maps[:2], *view.seen(p))
    with pytest.raises(ArgumentError, match="maps"):
        sl.aliasing.look_up(maps[:, :0], *view.seen(p))
    with pytest.raises(ArgumentError, match="gbuffer"):
        sl.aliasing.usage(None, view.camera, view.light, p)
    with pytest.raises(ArgumentError, match="light"):
        sl.aliasing.texel_coordinates(view.gbuffer, view.camera, "sun", p)
    with pytest.raises(ArgumentError, match="resolution"):
        sl.aliasing.usage(*view.seen(p), resolution=0)
    with pytest.raises(UnknownNameError, match="filter"):
        sl.aliasing.usage(*view.seen(p), filter="gauss")


def test_a_view_of_nothing_reads_nothing():
    scene = sl.library.scene("robots")
    away = sl.Camera.look_at((0, 50, 0), (0, 100, 1), fov_y=0.5, aspect=1, near=0.1, far=10)
    g = sl.Renderer("cpu").gbuffer(scene, away, size=16)
    found = sl.aliasing.usage(g, away, scene.light, np.eye(4), resolution=8)
    assert (found.unused, found.mean, found.pixels) == (1.0, 0.0, 0)
