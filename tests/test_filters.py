"""Filters and blending from Python: every kernel against numpy on a random map, and what takes a filter's text."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from explain_support import view_of
from filter_support import disc, settings_of

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import ArgumentError, UnknownNameError
from shadowlab.reports.reproduce import python_snippet
from shadowlab.text.checks import check_filter

SIDE = 64
SIZE = (40, 30)
#: Of places in a map of 64 texels, from positions in single precision: 1e-7 of a view of 20 texels' width, in weights.
TOLERANCE = 2e-5
FILTERS = (
    "nearest", "bilinear", "pcf:size=1", "pcf:size=3", "pcf:size=6.4", "tent:size=2", "tent:size=5.5",
    "poisson:count=16,radius=3,seed=5", "pcf:size=4px", "tent:size=6px", "poisson:count=9,radius=2.5px,seed=1",
)  # fmt: skip


def integral(name: str, width: float):
    """Of the kernel along one axis, from its middle."""
    if name == "tent":
        return lambda t: np.interp(t, *_integrated_tent(width))
    return lambda t: np.clip(t / width, -0.5, 0.5)


def _integrated_tent(width: float) -> tuple[np.ndarray, np.ndarray]:
    # By quadrature of the triangle itself.
    t = np.linspace(-0.5 * width, 0.5 * width, 200_001)
    height = (1 - np.abs(t) / (0.5 * width)) / (0.5 * width)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (height[1:] + height[:-1]) * np.diff(t))])
    return t, area


def expected_light(name: str, place, lit, jacobian, settings) -> float:
    """The light by a kernel over a padded map of which texels are lit, (2 PAD + SIDE)²."""
    pad = (lit.shape[0] - SIDE) // 2
    text = settings.get("size") or settings.get("radius") or "1"
    length, in_pixels = float(text.removesuffix("px")), text.endswith("px")
    image = jacobian if in_pixels else np.eye(2)
    if name == "poisson":
        axes = length * image
        if in_pixels:
            rows = np.linalg.norm(axes, axis=1, keepdims=True)
            axes = axes * (np.clip(rows, 0.5, 32) / rows)
        points = np.floor(place + disc(int(settings["count"]), int(settings["seed"])) @ axes.T).astype(int) + pad
        return float(np.mean(lit[points[:, 1], points[:, 0]]))
    widths = length * np.linalg.norm(image, axis=1)
    if in_pixels:
        widths = np.clip(widths, 1, 64)
    weights = []
    for at, width in zip(place, widths, strict=True):
        edges = np.arange(-pad, SIDE + pad + 1) - at
        weights.append(np.diff(integral(name, width)(edges)))
    return float(weights[1] @ lit @ weights[0])


@pytest.fixture(scope="module")
def plane():
    """A floor, a camera, a light, maps and a G-buffer of it; depths in the map are random."""
    scene = sl.Scene.from_arrays([[-50, 0, -50], [50, 0, -50], [50, 0, 50], [-50, 0, 50]], [[0, 2, 1], [0, 3, 2]])
    camera = sl.Camera.look_at((0.4, 3.0, 4.0), (0, 0, 0.3), aspect=4 / 3, fov_y=0.7, near=0.1, far=60.0)
    light = sl.DirectionalLight((0.4, -1.0, 0.3))
    p = sl.technique("lispsm:range=body").parameterize(scene, camera, light, resolution=SIDE)
    g = sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE)
    maps = np.random.default_rng(3).choice(np.array([0.0, 1.0], np.float32), (SIDE, SIDE))
    return scene, camera, light, p, g, maps


def ndc_of(matrix, points):
    clip = points @ matrix[:, :3].T + matrix[:, 3]
    return clip[..., :3] / clip[..., 3:]


def place_of(matrix, points):
    ndc = ndc_of(matrix, points)
    return np.stack([0.5 + 0.5 * ndc[..., 0], 0.5 - 0.5 * ndc[..., 1]], axis=-1) * SIDE


def jacobian_at(camera, matrix, x: float, y: float) -> np.ndarray:
    """Texels per pixel on the floor, by central differences of rays through the picture."""

    def at(dx, dy):
        origin, way = camera.rays([[x + dx, y + dy]], SIZE)
        on_floor = origin - way * (origin[:, 1:2] / way[:, 1:2])
        return place_of(matrix, on_floor)[0]

    h = 1e-3
    return np.stack([at(h, 0) - at(-h, 0), at(0, h) - at(0, -h)], axis=1) / (2 * h)


@pytest.mark.parametrize("text", FILTERS)
def test_every_kernel_is_that_of_numpy_on_a_random_map(plane, text):
    _, camera, light, p, g, maps = plane
    found = sl.aliasing.look_up(maps, g, camera, light, p, bias=sl.Bias.none(), filter=text)
    places, chosen = sl.aliasing.texel_coordinates(g, camera, light, p)
    pad = 40
    lit = np.pad(maps, pad, mode="edge") >= 0.5
    name, settings = settings_of(text)
    kernel = {"nearest": "nearest", "bilinear": "pcf"}.get(name, name)
    values, compared = [], 0
    for y, x in np.argwhere(chosen >= 0)[::7]:
        place = places[y, x]
        if kernel == "nearest":
            i, j = np.clip(np.floor(place).astype(int), 0, SIDE - 1)
            expected = float(maps[j, i] >= 0.5)
        else:
            jacobian = jacobian_at(camera, np.asarray(p.matrix), x + 0.5, y + 0.5)
            expected = expected_light(kernel, place, lit, jacobian, settings)
        # A point of a disc that falls on a texel's border goes to either side.
        slack = 1 / int(settings["count"]) if kernel == "poisson" and abs(found[y, x] - expected) > TOLERANCE else 0
        assert found[y, x] == pytest.approx(expected, abs=TOLERANCE + 1.01 * slack)
        values.append(slack)
        compared += 1
    assert compared > 100
    assert np.count_nonzero(values) <= 0.02 * compared
    if text != "nearest":
        assert np.ptp(found[chosen >= 0]) > 0.05


@pytest.mark.parametrize("text", FILTERS)
def test_what_is_compared_is_what_the_mask_says(plane, text):
    """Texels, weights and depths of `compared` give the light, with the receiver's plane and without."""
    _, camera, light, p, g, maps = plane
    for bias in (sl.Bias.none(), sl.Bias(plane=1, normal=0.2)):
        pixels = [(x, y) for y in range(0, SIZE[1], 5) for x in range(0, SIZE[0], 3)]
        which, _, own, texels, weights, depths = _core.compared(g, camera, light, p, pixels, bias=bias, filter=text)
        mask = sl.aliasing.look_up(maps, g, camera, light, p, bias=bias, filter=text)
        assert texels.shape == (*weights.shape, 2) == (*depths.shape, 2)
        for k, (x, y) in enumerate(pixels):
            if which[k] < 0 or np.isnan(own[k]):
                continue
            read = weights[k] > 0
            i, j = texels[k][read].T
            stored = maps[j, i].astype(float)
            assert weights[k].sum() == pytest.approx(1.0)
            assert mask[y, x] == pytest.approx(weights[k][read] @ (stored >= depths[k][read]), abs=1e-6)


def test_texts_are_read_as_the_core_reads_them():
    assert list(sl.filters()["name"]) == ["nearest", "bilinear", "pcf", "tent", "poisson"]
    for name, settings, doc in sl.filters().itertuples(index=False):
        text = f"{name}:{settings}" if settings else name
        assert _core.filter_text(text) == text
        assert doc
    assert _core.filter_text("pcf2x2") == "bilinear"
    assert _core.filter_text("poisson:radius=2px") == "poisson:count=16,radius=2px,seed=0"


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("vsm", UnknownNameError, "unknown filter 'vsm'; expected one of nearest, bilinear, pcf, tent, poisson"),
        ("pcf", ArgumentError, "filter pcf: size: expected a number of texels"),
        ("pcf:size=100", ArgumentError, "expected 1 to 64 texels, got 100 texels"),
        ("pcf:width=3", UnknownNameError, "expected one of size"),
        ("poisson:radius=2,count=1e3", ArgumentError, "filter poisson: count"),
        (None, ArgumentError, "filter: expected one of nearest"),
        (3, ArgumentError, "filter: expected one of nearest"),
    ],
)
def test_what_is_no_filter_is_named(text, error, message, plane):
    with pytest.raises(error) as raised:
        check_filter(text)
    assert message in str(raised.value)
    scene, camera, light, p, _, _ = plane
    if text is not None:
        with pytest.raises(error):
            sl.Renderer("cpu").shadow_mask(scene, camera, light, p, size=8, filter=text)


@pytest.mark.parametrize("blend", [-0.1, 1.5, float("nan"), "much", None])
def test_what_is_no_share_is_named(blend, plane):
    scene, camera, light, _, _, _ = plane
    with pytest.raises(ArgumentError, match=r"^blend: expected a number"):
        sl.compare(scene, camera, light, ["uniform"], size=(8, 6), blend=blend, progress=False)


def test_a_part_of_a_picture_has_the_kernels_of_the_whole(plane):
    """Of a crop, pixels are those of the picture that it was cut from."""
    _, camera, light, p, g, maps = plane
    part = g.crop(5, 7, 20, 12)
    for text in ("pcf:size=4px", "poisson:radius=2px"):
        whole = sl.aliasing.look_up(maps, g, camera, light, p, filter=text)
        assert np.array_equal(sl.aliasing.look_up(maps, part, camera, light, p, filter=text), whole[7:19, 5:25], True)


@pytest.mark.parametrize("text", ["pcf:size=3", "tent:size=4px", "poisson:count=8,radius=1.5"])
def test_experiments_take_every_filter(text):
    view = view_of("robots")
    study = sl.compare(
        view.scene,
        view.camera,
        view.light,
        ["uniform"],
        resolution=128,
        size=(80, 45),
        filter=text,
        renderer="cpu",
        progress=False,
    )
    run = study.runs[0]
    assert not run.failure
    assert run.errors.count == sum(run.causes.counts.values())
    small = sl.View(view.scene, view.camera, view.light, size=(80, 45))
    y, x = np.argwhere(run.errors.image > 0)[0]
    found = sl.explain_pixel(small, "uniform", x, y, resolution=128, renderer="cpu", filter=text, trials=False)
    assert found.light == pytest.approx(found.comparison.light, abs=1e-6)
    assert sum(read.weight for read in found.comparison.reads) == pytest.approx(1.0)
    assert found.cause is not None
    reads = sl.aliasing.usage(view.gbuffer("cpu"), view.camera, view.light, run.parameterization, filter=text)
    assert reads.mean * np.count_nonzero(reads.reads) >= reads.pixels


def test_planes_need_what_the_reach_of_the_kernel_needs():
    scene = sl.Scene.from_arrays([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    camera = sl.Camera.look_at((0.4, 3.0, 4.0), (0, 0, 0.3), aspect=4 / 3, fov_y=0.7, near=0.1, far=60.0)
    view = sl.View(scene, camera, sl.DirectionalLight((0.4, -1.0, 0.3)), size=(60, 45))
    bias = sl.Bias(texels=0, ndc=0, slope=0, plane=0)

    def closed_form(text):
        return sl.smallest_bias(
            view, "uniform", "world", resolution=128, renderer="cpu", filter=text, bias=bias, progress=False
        ).closed_form

    # A box of 3 texels reaches four times as far as a nearest lookup, a disc of 1.5 texels as far as that.
    nearest = closed_form("nearest")
    assert closed_form("pcf:size=3") == pytest.approx(4 * nearest, rel=1e-6)
    assert closed_form("poisson:radius=1.5") == pytest.approx(4 * nearest, rel=1e-6)
    assert closed_form("pcf:size=3px") > nearest


def test_maps_that_overlap_less_than_they_blend_warn():
    view = view_of("robots")
    p = sl.technique("z_partition:count=2,overlap=0.1").parameterize(view.scene, view.camera, view.light, resolution=64)
    take = (view.scene, view.camera, view.light, p)
    with pytest.warns(sl.errors.ShadowlabWarning, match=r"overlap by 0\.1, less than 0\.2; .* set overlap=0\.2"):
        sl.Renderer("cpu").shadow_mask(*take, size=16, blend=0.2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sl.Renderer("cpu").shadow_mask(*take, size=16, blend=0.1)


def test_compare_blends_and_says_so():
    view = view_of("robots")
    take = {
        "resolution": 128, "size": (320, 180), "renderer": "cpu", "progress": False, "truth": False,
        "filter": "bilinear",
    }  # fmt: skip
    of = ["z_partition:distances=(8,12),overlap=0.3"]
    plain = sl.compare(view.scene, view.camera, view.light, of, **take)
    study = sl.compare(view.scene, view.camera, view.light, of, blend=0.3, **take)
    assert study.lookup == "bilinear, blend 0.3"
    assert plain.lookup == "bilinear"
    label = of[0]
    a, b = plain.masks[label], study.masks[label]
    assert not np.array_equal(a, b, equal_nan=True)
    assert np.array_equal(plain.chosen[label], study.chosen[label])
    assert "blend=0.3" in python_snippet(study, study.runs)
    assert np.count_nonzero(a[~np.isnan(a)] != b[~np.isnan(b)]) > 50
