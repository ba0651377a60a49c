"""Causes of wrong pixels: scenes whose cause is known by construction, then invariants over techniques and lights."""

from __future__ import annotations

import numpy as np
import pytest
from summary_support import causes_by_depth, edge_distance_of

import shadowlab as sl
from shadowlab.aliasing.causes import CAUSES, Causes
from shadowlab.errors import ArgumentError, UnknownNameError

SIZE = (320, 180)
ACNE, EDGE, LEAK, MISSING, OTHER = 1, 2, 3, 4, 5


def quad(a, b, c, d):
    """Vertices and faces of a rectangle."""
    return np.array([a, b, c, d], float), np.array([[0, 1, 2], [0, 2, 3]])


def joined(*parts):
    """One mesh of several parts."""
    vertices, faces, first = [], [], 0
    for v, f in parts:
        vertices.append(v)
        faces.append(f + first)
        first += len(v)
    return sl.Scene.from_arrays(np.concatenate(vertices), np.concatenate(faces))


def floor(half=20.0, y=0.0):
    return quad((-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half))


def plate(y, low=(-3, -3), high=(3, 3)):
    return quad((low[0], y, high[1]), (high[0], y, high[1]), (high[0], y, low[1]), (low[0], y, low[1]))


CAMERA = sl.Camera.look_at((0, 9, 14), (0, 0, 0), fov_y=0.9, aspect=16 / 9, near=0.5, far=80)
SUN = sl.DirectionalLight((0.5, -1, -0.2))


def only(**counts):
    """Counts of all causes, none of those that are not named."""
    return {name: counts.get(name, 0) for name in CAUSES.values()}


class View:
    """A scene seen and lit, with its truth."""

    def __init__(self, scene, camera=CAMERA, light=SUN, size=SIZE):
        self.scene, self.camera, self.light, self.size = scene, camera, light, size
        self.renderer = sl.Renderer("cpu")
        self.gbuffer = self.renderer.gbuffer(scene, camera, size=size)
        self.truth = sl.trace.shadow_mask(scene, camera, light, size=size)

    def causes(self, technique="uniform", *, resolution=256, bias=None, filter="nearest", renderer=None):
        draw = renderer or self.renderer
        p = technique
        if isinstance(technique, str):
            by_body = sl.technique(technique).by_body()
            p = by_body.parameterize(self.scene, self.camera, self.light, resolution=resolution)
        maps = draw.shadow_map(self.scene, p, resolution=resolution)
        mask = draw.shadow_mask(
            self.scene, self.camera, self.light, p, resolution=resolution, size=self.size, bias=bias, filter=filter
        )
        errors = sl.aliasing.misclassified(mask, self.truth)
        found = sl.aliasing.causes(
            self.scene, self.camera, self.light, p, mask, self.truth,
            gbuffer=self.gbuffer, maps=maps, bias=bias, filter=filter,
        )  # fmt: skip
        return found, errors, p


@pytest.fixture(scope="module")
def plane():
    return View(joined(floor()))


@pytest.fixture(scope="module")
def roof():
    return View(joined(floor(), plate(2.5)))


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "z_partition:count=3", "log"])
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_a_plane_alone_without_bias_has_acne_and_nothing_else(plane, technique, filter):
    found, errors, _ = plane.causes(technique, bias=sl.Bias.none(), filter=filter)
    assert errors.count > 1000
    assert found.counts == only(acne=errors.count)
    assert plane.causes(technique, filter=filter)[0].count == 0


def test_a_plate_above_a_plane_has_displaced_edges_by_no_more_than_a_texel(roof):
    for technique, resolution in (("uniform", 64), ("uniform", 256), ("lispsm", 128)):
        found, errors, p = roof.causes(technique, resolution=resolution)
        assert errors.count > 50
        assert found.counts == only(edge=errors.count)
        e = sl.aliasing.footprint(roof.gbuffer, roof.camera, roof.light, p, resolution=resolution)
        wrong = (found.image == EDGE) & e.measured
        # A texel is decided at its centre: edges move by half its diagonal, whose size changes over half a texel.
        limit = 1.05 * np.hypot(e.major, e.minor) / 2
        assert (found.distance[wrong] <= limit[wrong]).all(), (found.distance - limit)[wrong].max()
    assert roof.causes("uniform", resolution=64)[0].edge_distance["mean"] > 1.3 * found.edge_distance["mean"]


@pytest.mark.parametrize("world", [0.5, 2.0])
def test_bias_that_passes_the_caster_leaks(world):
    # A plate close above the floor: with a larger bias than its height along the ray all of its shadow is lost.
    view = View(joined(floor(), plate(0.3), plate(1.2, low=(-9, -3), high=(-5, 1))))
    bias = sl.Bias(world=world, texels=0, slope=0, ndc=0)
    found, *_ = view.causes("uniform", resolution=1024, bias=bias)
    assert found.leak > 200
    # The leak is where the nearest blocker to the light is no further than the bias.
    origins = np.asarray(view.gbuffer.position)[found.image == LEAK]
    to_light = -np.asarray(SUN.direction)
    far = origins + 50 * to_light
    t, *_ = sl._core.first_hit(view.scene, far, np.broadcast_to(-to_light, far.shape).copy())
    assert (50 - t <= world * (1 + 1e-6)).all()
    # Without a bias none of it is a leak.
    assert view.causes("uniform", resolution=1024, bias=sl.Bias.none())[0].leak == 0


def mask_through(view, p, bias, filter):
    maps = view.renderer.shadow_map(view.scene, p)
    return sl.aliasing.look_up(maps, view.gbuffer, view.camera, view.light, p, bias=bias, filter=filter)


@pytest.mark.parametrize("name", ["courtyard", "ceiling", "dueling", "skylight"])
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_what_is_called_a_leak_is_dark_without_the_bias(name, filter):
    scene = sl.library.scene(name)
    view = View(scene, scene.camera, scene.light)
    for bias in (None, sl.Bias(world=0.2)):
        found, _, p = view.causes("lispsm", resolution=512, bias=bias, filter=filter)
        unbiased = mask_through(view, p, sl.Bias.none(), filter) >= 0.5
        assert found.leak > 20
        assert not unbiased[found.image == LEAK].any()
        assert found.other <= 0.002 * found.count + 3


@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
@pytest.mark.parametrize("technique", ["uniform", "lispsm", "log"])
def test_a_lit_corner_has_no_edges_and_no_other(technique, filter):
    # A floor and a wall, both lit: there is no shadow whose edge could be displaced.
    wall = quad((-20, 0, -6), (20, 0, -6), (20, 20, -6), (-20, 20, -6))
    view = View(joined(floor(), wall), light=sl.DirectionalLight((0.2, -1, -0.3)))
    assert not ((view.truth == 0) & (np.asarray(view.gbuffer.position)[..., 2] > -5.9)).any()
    found, errors, _ = view.causes(technique, resolution=96, bias=sl.Bias.none(), filter=filter)
    assert errors.false_shadow > 500
    assert found.counts == only(acne=errors.count)


@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_hills_without_bias_shade_themselves(filter):
    x, z = np.meshgrid(np.linspace(-12, 12, 160), np.linspace(-12, 12, 160))
    y = 0.15 * np.sin(1.3 * x) * np.cos(1.1 * z)
    k = np.arange(159 * 160).reshape(159, 160)[:, :-1].ravel()
    faces = np.concatenate([np.stack([k, k + 160, k + 1], 1), np.stack([k + 1, k + 160, k + 161], 1)])
    scene = sl.Scene.from_arrays(np.stack([x, y, z], -1).reshape(-1, 3), faces)
    view = View(scene, light=sl.DirectionalLight((0.4, -1, 0.3)))
    assert not (view.truth == 0).any()
    found, errors, _ = view.causes("uniform", resolution=128, bias=sl.Bias.none(), filter=filter)
    assert errors.count > 5000
    assert found.counts == only(acne=errors.count)


def test_a_map_that_holds_what_is_not_there_is_neither_acne_nor_an_edge(roof):
    p = sl.technique("uniform").parameterize(roof.scene, CAMERA, SUN, resolution=256)
    maps = np.roll(roof.renderer.shadow_map(roof.scene, p), 90, axis=1)
    seen = (roof.gbuffer, CAMERA, SUN, p)
    mask = sl.aliasing.look_up(maps, *seen)
    found = sl.aliasing.causes(roof.scene, CAMERA, SUN, p, mask, roof.truth, gbuffer=roof.gbuffer, maps=maps)
    shadow = sl.aliasing.misclassified(mask, roof.truth).image == 1
    assert np.count_nonzero(found.image == OTHER) > 0.9 * np.count_nonzero(shadow) > 500


def test_a_caster_beyond_the_near_plane_is_missing(roof):
    p = sl.technique("uniform").parameterize(roof.scene, CAMERA, SUN, resolution=512)
    ndc, _ = p.partitions[0].project(np.array([[0, 2.5, 0], [0, 0, 0]]))
    between = float(ndc[:, 2].mean())
    cut = np.array(p.matrix)
    cut[2] = (cut[2] - between * cut[3]) / (1 - between)  # the near plane between the plate and the floor
    found, errors, _ = roof.causes(sl.Parameterization.from_matrix(cut, resolution=512), resolution=512)
    assert errors.false_light > 1000
    assert found.missing > 0.99 * errors.false_light


def test_a_receiver_outside_of_the_map_misses_its_caster(roof):
    p = sl.technique("uniform").parameterize(roof.scene, CAMERA, SUN, resolution=512)
    small = np.diag([3.0, 3.0, 1.0, 1.0]) @ np.array(p.matrix)
    half = np.array([[1.0, 0, 0, 1.0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) @ small
    p = sl.Parameterization.from_matrix(half, resolution=512)
    found, errors, _ = roof.causes(p, resolution=512)
    texel, which = sl.aliasing.texel_coordinates(roof.gbuffer, CAMERA, SUN, p)
    outside = (which == -1) & (found.image > 0)
    assert np.count_nonzero(outside) > 500
    assert (found.image[outside] == MISSING).all()
    assert np.isnan(texel[which < 0]).all()
    assert errors.count == found.count


def test_a_wire_thinner_than_a_texel_is_missing_and_found_by_a_finer_map():
    wires = [plate(2.0, low=(x, -3), high=(x + 0.02, 3)) for x in (-3, -1.3, 0.4, 2.1)]
    camera = sl.Camera.look_at((0, 6, 6), (0.5, 0, 0), fov_y=0.7, aspect=16 / 9, near=0.5, far=80)
    view = View(joined(floor(8), *wires), camera, size=(640, 360))
    coarse, errors, _ = view.causes("uniform", resolution=64)
    fine, *_ = view.causes("uniform", resolution=4096)
    assert coarse.missing > 0.75 * errors.false_light
    assert coarse.missing > 300
    assert fine.missing < 0.02 * coarse.missing


LIGHTS = {
    "sun": SUN,
    "spot": sl.SpotLight((3, 9, 3), (-0.3, -1, -0.3), cone_angle=1.3, range=40.0),
    "point": sl.PointLight((2, 7, 2), range=40.0),
}


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize(
    "technique", ["uniform", "lispsm", "plane_optimal:fallback=uniform", "z_partition:count=3,inner=lispsm", "log_psm"]
)
@pytest.mark.parametrize("bias", [None, sl.Bias.none(), sl.Bias(world=1.0)], ids=["default", "none", "large"])
def test_every_wrong_pixel_has_one_cause_that_fits_its_error(light, technique, bias):
    if light != "sun" and technique == "log_psm":
        with pytest.raises(sl.errors.ShadowlabError):
            sl.technique(technique).parameterize(joined(floor()), CAMERA, LIGHTS[light], resolution=64)
        return
    view = View(joined(floor(), plate(2.5), plate(0.4, low=(4, 0), high=(7, 4))), light=LIGHTS[light])
    found, errors, _ = view.causes(technique, resolution=200, bias=bias)
    assert sum(found.counts.values()) == found.count == errors.count
    assert found.undecided == errors.undecided
    np.testing.assert_array_equal(found.image > 0, errors.image > 0)
    np.testing.assert_array_equal(found.image == -1, errors.image == -1)
    assert set(np.unique(found.image[errors.image == 1])) <= {ACNE, EDGE, OTHER}
    assert set(np.unique(found.image[errors.image == 2])) <= {EDGE, LEAK, MISSING, OTHER}
    assert (np.isnan(found.distance) == (found.image != EDGE)).all()
    assert (found.distance[found.image == EDGE] >= 0).all()
    if bias == sl.Bias.none():
        assert found.leak == 0
    table = found.by_depth(4)
    assert table["wrong"].sum() == errors.count
    assert table["compared"].sum() == errors.compared
    assert (table[list(CAUSES.values())].sum(axis=1) == table["wrong"]).all()


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_scale_and_place_change_no_cause(roof, scale):
    move = np.array([5e3, -2e2, 1e3]) * scale

    def at(p):
        return np.asarray(p, float) * scale + move

    vertices = np.concatenate([floor()[0], plate(2.5)[0]])
    faces = np.concatenate([floor()[1], plate(2.5)[1] + 4])
    camera = sl.Camera.look_at(
        at(CAMERA.eye), at((0, 0, 0)), fov_y=0.9, aspect=16 / 9, near=0.5 * scale, far=80 * scale
    )
    view = View(sl.Scene.from_arrays(at(vertices), faces), camera)
    for bias in (None, sl.Bias.none()):
        first, second = roof.causes("lispsm", bias=bias)[0], view.causes("lispsm", bias=bias)[0]
        assert abs(first.count - second.count) <= 0.002 * SIZE[0] * SIZE[1]
        for name in CAUSES.values():
            assert abs(first.counts[name] - second.counts[name]) <= 0.01 * first.count + 5, name


def test_maps_of_both_renderers_have_the_same_causes(roof, gpu_renderer):
    for technique in ("uniform", "z_partition:count=2,inner=lispsm"):
        cpu, *_ = roof.causes(technique)
        gpu, *_ = roof.causes(technique, renderer=gpu_renderer)
        # A few pixels on silhouettes.
        assert np.count_nonzero(cpu.image != gpu.image) <= 1e-3 * cpu.image.size


def test_one_wrong_pixel_more_is_one_cause_more(roof):
    p = sl.technique("uniform").parameterize(roof.scene, CAMERA, SUN, resolution=256)
    maps = roof.renderer.shadow_map(roof.scene, p)
    mask = sl.aliasing.look_up(maps, roof.gbuffer, CAMERA, SUN, p)
    seen = (roof.scene, CAMERA, SUN, p)
    before = sl.aliasing.causes(*seen, mask, roof.truth, gbuffer=roof.gbuffer, maps=maps)
    y, x = np.argwhere((before.image == 0) & (roof.truth == 1))[500]
    mask[y, x] = 0.0
    after = sl.aliasing.causes(*seen, mask, roof.truth, gbuffer=roof.gbuffer, maps=maps)
    assert after.count == before.count + 1
    assert np.argwhere(after.image != before.image).tolist() == [[y, x]]


def test_nothing_wrong_and_nothing_seen(plane):
    found, *_ = plane.causes("uniform", resolution=512)
    assert found.count == 0
    assert found.edge_distance is None
    assert "0 wrong" in repr(found)
    up = sl.Camera.look_at((0, 5, 0), (0, 50, 1), fov_y=0.5, aspect=1, near=0.1, far=10)
    nothing = View(plane.scene, up, size=(8, 8))
    found, *_ = nothing.causes("uniform", resolution=16)
    assert (found.image == -1).all()
    assert found.by_depth().empty


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1e-3, 1.001, 255.0])
def test_maps_that_are_no_depths_are_told(roof, value):
    p = sl.technique("uniform").parameterize(roof.scene, CAMERA, SUN, resolution=64)
    maps = np.array(roof.renderer.shadow_map(roof.scene, p))
    mask = sl.aliasing.look_up(maps, roof.gbuffer, CAMERA, SUN, p)
    maps[0, 0] = -0.0
    sl.aliasing.look_up(maps, roof.gbuffer, CAMERA, SUN, p)
    maps[5, 7] = value
    for given in (maps, maps.astype(np.float64), np.asfortranarray(maps)):
        with pytest.raises(ArgumentError, match=r"maps: expected depths between 0 and 1, got .*scale"):
            sl.aliasing.look_up(given, roof.gbuffer, CAMERA, SUN, p)
        with pytest.raises(ArgumentError, match="maps: expected depths between 0 and 1"):
            sl.aliasing.causes(
                roof.scene, CAMERA, SUN, p, mask, roof.truth, gbuffer=roof.gbuffer, maps=given
            )  # fmt: skip


def test_bad_input_is_told(roof):
    found, _, p = roof.causes("uniform")
    maps = roof.renderer.shadow_map(roof.scene, p)
    mask = sl.aliasing.look_up(maps, roof.gbuffer, CAMERA, SUN, p)
    seen = (roof.scene, CAMERA, SUN, p)
    with pytest.raises(ArgumentError, match="gbuffer"):
        sl.aliasing.causes(*seen, mask, roof.truth, gbuffer=None, maps=maps)
    with pytest.raises(ArgumentError, match="truth"):
        sl.aliasing.causes(*seen, mask, roof.truth[1:], gbuffer=roof.gbuffer, maps=maps)
    with pytest.raises(ArgumentError, match="maps"):
        sl.aliasing.causes(*seen, mask, roof.truth, gbuffer=roof.gbuffer, maps=maps[None].repeat(2, axis=0))
    with pytest.raises(ArgumentError, match="shape"):
        sl.aliasing.causes(*seen, mask[1:], roof.truth[1:], gbuffer=roof.gbuffer, maps=maps)
    with pytest.raises(UnknownNameError, match="filter"):
        sl.aliasing.causes(*seen, mask, roof.truth, gbuffer=roof.gbuffer, maps=maps, filter="soft")
    with pytest.raises(ArgumentError, match="bands"):
        found.by_depth(0)


# Sums of blocks and numpy's pairwise sums round differently: some hundred roundings at most.
SUMMED = 1e-12


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (180, 320), (700, 900)])
@pytest.mark.parametrize("threads", [1, 3])
def test_the_core_counts_what_numpy_counts(shape, threads):
    random = np.random.default_rng(shape[0])
    image = random.choice([-1, 0, 0, 0, 1, 2, 3, 4, 5], shape).astype(np.int8)
    distance = np.where(image == EDGE, random.lognormal(0, 2, shape), np.nan).astype(np.float32)
    distance[::7, ::3] = np.where(image[::7, ::3] == EDGE, np.inf, np.nan)  # behind the camera
    found = Causes(image, distance, random.lognormal(2.0, 1.0, shape), 0)
    sl.set_threads(threads)
    try:
        counts, moved = found.counts, found.edge_distance
        tables = {bands: found.by_depth(bands) for bands in (1, 6, (0.5, 4.0, 9.0))}
    finally:
        sl.set_threads(None)
    assert counts == {name: int(np.count_nonzero(image == code)) for code, name in CAUSES.items()}
    assert found.count == np.count_nonzero(image > 0)
    assert moved == (None if (expected := edge_distance_of(found)) is None else pytest.approx(expected, rel=SUMMED))
    if (image >= 0).any():
        for bands, table in tables.items():
            assert table.to_dict("records") == causes_by_depth(found, bands)


def test_causes_of_nothing_have_no_bands():
    found = Causes(np.full((4, 5), -1, np.int8), np.full((4, 5), np.nan, np.float32), np.ones((4, 5)), 0)
    assert found.by_depth().empty
    assert (found.count, found.edge_distance) == (0, None)
