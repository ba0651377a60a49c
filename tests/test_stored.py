"""What a map stores: texts and values of `Stored`, formats as numpy rounds them, sizes of steps, open meshes."""

from __future__ import annotations

import pickle
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import ArgumentError, ShadowlabWarning, UnknownNameError

SURFACES = ("front", "back", "second", "midpoint", "dual")
SPACINGS = ("projective", "linear")
FORMATS = ("f32", "f16", "unorm16", "unorm24")
#: An orthographic map that looks straight down on the square of half side 2, from a height of 3 to one of -1.
DOWN = np.array([[0.5, 0, 0, 0], [0, 0, -0.5, 0], [0, -0.25, 0, 0.75], [0, 0, 0, 1.0]])
SUN = sl.DirectionalLight((0.0, -1.0, 0.0))


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> sl.Scene:
    """A closed box whose winding shows outwards."""
    corners = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    sides = [(0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
    return sl.Scene.from_arrays(np.array(corners), np.array(faces))


def floor(height: float = 0.0) -> sl.Scene:
    """An open square that faces up, twice as large as the map."""
    corners = [[-4.0, height, -4.0], [-4.0, height, 4.0], [4.0, height, 4.0], [4.0, height, -4.0]]
    return sl.Scene.from_arrays(np.array(corners), [[0, 1, 2], [0, 2, 3]])


def drawn(scene: sl.Scene, stored: sl.Stored | str | None, resolution: int = 64) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ShadowlabWarning)
        return sl.Renderer("cpu").shadow_map(scene, DOWN, resolution=resolution, stored=stored)


def test_texts_are_shortest_and_read_back() -> None:
    for surface in SURFACES:
        for spacing in SPACINGS:
            for name in FORMATS:
                for limit in (8.0, 0.25, float("inf")):
                    stored = sl.Stored(surface, spacing=spacing, format=name, limit=limit)
                    assert (stored.surface, stored.spacing, stored.format, stored.limit) == (
                        surface,
                        spacing,
                        name,
                        limit,
                    )
                    assert sl.Stored(str(stored)) == stored == eval(repr(stored), {"Stored": sl.Stored})
                    assert hash(sl.Stored(str(stored))) == hash(stored)
                    assert pickle.loads(pickle.dumps(stored)) == stored
    assert str(sl.Stored()) == "front"
    assert str(sl.Stored("back", spacing="linear", format="unorm16")) == "back:spacing=linear,format=unorm16"
    assert sl.Stored("back:spacing=linear", format="f16") == sl.Stored("back:spacing=linear,format=f16")
    assert sl.Stored("back") != sl.Stored("second")


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda: sl.Stored("fornt"), UnknownNameError, "front, back, second, midpoint, dual"),
        (lambda: sl.Stored("front:space=linear"), UnknownNameError, "expected one of spacing, format, limit"),
        (lambda: sl.Stored("front:format=f16,format=f32"), ArgumentError, "format: expected one value, got two"),
        (lambda: sl.Stored("front", spacing="cubic"), UnknownNameError, "projective, linear"),
        (lambda: sl.Stored(format="unorm8"), UnknownNameError, "f32, f16, unorm16, unorm24"),
        (lambda: sl.Stored("dual", limit=-0.5), ArgumentError, "stored.limit"),
        (lambda: sl.Stored("dual", limit=float("nan")), ArgumentError, "stored.limit"),
        (lambda: sl.Stored(3), ArgumentError, "surface"),
        (lambda: drawn(floor(), 3), ArgumentError, "stored"),
        (lambda: drawn(floor(), "front:format=f64"), UnknownNameError, "format"),
    ],
)
def test_bad_values_are_refused(make, error, match) -> None:
    with pytest.raises(error, match=match) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_formats_round_as_numpy_does() -> None:
    scene = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=128)
    renderer = sl.Renderer("cpu")
    for surface in SURFACES:
        for spacing in SPACINGS:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ShadowlabWarning)
                exact, *rounded = (
                    renderer.shadow_map(scene, p, stored=sl.Stored(surface, spacing=spacing, format=name))
                    for name in FORMATS
                )
            assert exact.min() < 1 == exact.max()
            wide = exact.astype(np.float64)
            np.testing.assert_array_equal(rounded[0], exact.astype(np.float16).astype(np.float32))
            for levels, found in zip((65535, 16777215), rounded[1:], strict=True):
                np.testing.assert_array_equal(found, (np.round(wide * levels) / levels).astype(np.float32))


def test_a_box_over_a_floor() -> None:
    both = together(floor(), box((-1, 0.5, -1), (1, 1.5, 1)))
    for surface, inside, outside in [
        ("front", 1.5, 0.0),
        ("back", 0.5, None),
        ("second", 0.5, None),
        ("midpoint", 1.0, None),
        ("dual", 1.5 - 2 * 4 / 64, -2 * 4 / 64),
    ]:
        for spacing in SPACINGS:
            found = drawn(both, sl.Stored(surface, spacing=spacing, limit=2.0))
            depths = [1.0 if height is None else (3 - height) / 4 for height in (inside, outside)]
            np.testing.assert_allclose([found[32, 32], found[2, 2]], depths, atol=3e-7, err_msg=f"{surface} {spacing}")


def together(*scenes: sl.Scene) -> sl.Scene:
    vertices, faces, first = [], [], 0
    for scene in scenes:
        for mesh in scene.meshes:
            vertices.append(np.asarray(mesh.vertices))
            faces.append(np.asarray(mesh.faces) + first)
            first += len(vertices[-1])
    return sl.Scene.from_arrays(np.concatenate(vertices), np.concatenate(faces))


def test_one_step_moves_the_stored_depth_by_one_number() -> None:
    p = sl.Parameterization.from_matrix(DOWN)
    for spacing in SPACINGS:
        stored = sl.Stored(spacing=spacing, format="unorm16")
        for height in (2.0, 0.1, -0.7):
            (step,) = stored.step(p, [[0.3, height, -0.2]])
            assert step == pytest.approx(4 / 65535)
            levels = [round(float(drawn(floor(h), stored)[20, 30]) * 65535) for h in (height, height - step)]
            assert levels[1] - levels[0] == 1
        half = sl.Stored(spacing=spacing, format="f16")
        # Depth 0.25 at a height of 2, 0.8 at one of -0.2: steps of 2^-12 and 2^-11 of a depth of 4.
        np.testing.assert_allclose(half.step(p, [[0, 1.99, 0], [0, -0.2, 0]]), [4 * 2.0**-12, 4 * 2.0**-11], rtol=1e-9)


def test_steps_of_a_spot_grow_with_the_square_of_the_distance() -> None:
    near, far = 2.0, 10.0
    # A camera at the origin that looks down -y.
    view = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    lens = np.array(
        [[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, -far / (far - near), -far * near / (far - near)], [0, 0, -1, 0]]
    )
    p = sl.Parameterization.from_matrix(lens @ view)
    depths = np.array([2.0, 4.0, 9.9])
    points = np.stack([0 * depths, -depths, 0 * depths], axis=1)
    steps = sl.Stored(format="unorm24").step(p, points)
    np.testing.assert_allclose(steps, depths**2 * (far - near) / (far * near) / 16777215, rtol=1e-9)
    linear = sl.Stored(format="unorm24", spacing="linear").step(p, points)
    np.testing.assert_allclose(linear, (far - near) / 16777215, rtol=1e-9)
    with pytest.raises(ArgumentError, match=r"points\[1\]"):
        sl.Stored().step(p, [[0, -3, 0], [0, -11, 0]])


def test_open_meshes_are_noted_where_casters_have_to_be_closed() -> None:
    renderer, camera = (
        sl.Renderer("cpu"),
        sl.Camera.look_at((0, 5, 1), (0, 0, 0), up=(0, 0, -1), fov_y=0.8, aspect=1, near=0.1, far=20),
    )
    closed = box((-1, 0.5, -1), (1, 1.5, 1))
    for surface in SURFACES:
        for scene, edges in ((floor(), 4), (closed, 0)):
            for call in (
                lambda scene=scene, surface=surface: renderer.shadow_map(scene, DOWN, resolution=8, stored=surface),
                lambda scene=scene, surface=surface: renderer.shadow_mask(
                    scene, camera, SUN, DOWN, size=8, resolution=8, stored=surface
                ),
            ):
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    call()
                texts = [str(w.message) for w in caught if issubclass(w.category, ShadowlabWarning)]
                if edges and surface in ("back", "second", "midpoint"):
                    assert len(texts) == 1
                    assert f"1 of 1 meshes are open, with {edges} border edges" in texts[0]
                    assert surface in texts[0]
                else:
                    assert not texts


def test_lookups_of_arrays_take_what_is_stored() -> None:
    scene = sl.library.scene("robots")
    camera, light = scene.camera, scene.light
    renderer = sl.Renderer("cpu")
    p = sl.technique("lispsm").parameterize(scene, camera, light, resolution=256)
    g = renderer.gbuffer(scene, camera, size=(96, 54))
    masks = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ShadowlabWarning)
        for stored in ("front", "front:spacing=linear", "midpoint:spacing=linear,format=unorm16", "back"):
            maps = renderer.shadow_map(scene, p, stored=stored)
            mask = renderer.shadow_mask(scene, camera, light, p, size=(96, 54), stored=stored)
            found, _ = _core.look_up(maps, g, camera, light, p, stored=stored)
            np.testing.assert_array_equal(found, mask)
            masks.append(mask)
            pixels = np.argwhere(~np.isnan(mask))[::50, ::-1]
            chosen, places, depths, *_ = _core.compared(g, camera, light, p, pixels, stored=stored)
            held = chosen >= 0
            texels = np.floor(places[held]).astype(int).clip(0, 255)
            lit = maps[texels[:, 1], texels[:, 0]] >= depths[held]
            at = pixels[held]
            np.testing.assert_array_equal(lit | np.isnan(depths[held]), mask[at[:, 1], at[:, 0]] == 1)
    # Other spacings store other numbers; the light is the same but for roundings.
    assert np.mean(masks[0] != masks[1]) < 0.01 + np.mean(np.isnan(masks[0]))
    assert np.nansum(masks[0] != masks[3]) > 10


def test_gpu_draws_what_the_cpu_draws(gpu_renderer: sl.Renderer) -> None:
    scene = together(floor(), box((-1, 0.5, -1), (1, 1.5, 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ShadowlabWarning)
        for surface in SURFACES:
            for spacing in SPACINGS:
                for name, step in (("f32", 2e-7), ("f16", 2.0**-11), ("unorm16", 1 / 65535), ("unorm24", 2e-7)):
                    stored = sl.Stored(surface, spacing=spacing, format=name)
                    maps = [
                        r.shadow_map(scene, DOWN, resolution=64, stored=stored)
                        for r in (gpu_renderer, sl.Renderer("cpu"))
                    ]
                    differ = np.abs(maps[0] - maps[1]) > 1.01 * step
                    assert differ.sum() == 0, f"{stored}: {differ.sum()}"


def test_the_table_of_steps_is_true() -> None:
    text = (Path(__file__).parents[1] / "docs" / "bias.md").read_text("utf-8")
    rows = re.findall(r"^\| `(f32|f16|unorm16|unorm24)` \| ([-\de. |]+) \|$", text, re.MULTILINE)
    assert [name for name, _ in rows] == list(FORMATS)
    deep = np.array([[0.02, 0, 0, 0], [0, 0, -0.02, 0], [0, -0.01, 0, 1.0], [0, 0, 0, 1]])
    lens = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, -100 / 99, 0, -100 / 99], [0, -1, 0, 0]])
    sun, spot = sl.Parameterization.from_matrix(deep), sl.Parameterization.from_matrix(lens)
    for name, cells in rows:
        stored = sl.Stored(format=name)
        steps = [
            *stored.step(sun, [[0, 90, 0], [0, 10, 0]]),
            *stored.step(spot, [[0, -2, 0], [0, -10, 0], [0, -90, 0]]),
            *sl.Stored(format=name, spacing="linear").step(spot, [[0, -2, 0], [0, -10, 0], [0, -90, 0]]),
        ]
        assert cells == " | ".join(f"{step:.2g}" for step in steps)
