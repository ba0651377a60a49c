"""Alpha tests in maps, G-buffers and truth: numpy, geometry of the same shape, all techniques, both renderers."""

from __future__ import annotations

import numpy as np
import pytest
from foliage_support import CAMERA, FACES, SUN, bars, carved, fence, floor, sampled, square, unit

import shadowlab as sl

SIZE = (240, 180)
# A map that is the picture of a square: x to the right, y up, from -1 to 1.
IDENTITY = sl.Parameterization.from_matrix(np.diag([1.0, 1, 0.5, 1]))
# Levels so near to the cutoff may fall on either side: coordinates are single precision.
NEAR = 0.02


def curtain(alpha):
    """A square over all of that map."""
    return sl.Scene.from_arrays(square((-1, -1, 0.5), (2, 0, 0), (0, 2, 0)), FACES, alpha=alpha)


def drawn(scene, size, backend="cpu"):
    """Where that map has something."""
    return sl.Renderer(backend).shadow_map(scene, IDENTITY, resolution=size) < 1


def centres(size):
    """Texture coordinates of the map's texels where the square's are from 0 to 1."""
    u, v = (np.arange(n) / n + 0.5 / n for n in size)
    return np.meshgrid(u, v)


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (7, 1), (4, 6), (64, 64)])
def test_sampling_is_that_of_numpy(wrap, shape):
    rng = np.random.default_rng(3)
    texture = rng.integers(0, 256, shape).astype(np.uint8)
    for repeats, offset in [((1, 1), (0, 0)), ((3.7, -2.2), (-1.3, 5.1)), ((0.01, 0.02), (100.3, -77.7))]:
        alpha = sl.AlphaTest(texture, unit(repeats, offset), wrap=(wrap, wrap), cutoff=0.4)
        u, v = centres((80, 60))
        ends = alpha.uv.astype(float)
        at = [ends[0, k] + (ends[2, k] - ends[0, k]) * t for k, t in enumerate((u, v))]
        level = sampled(alpha, *at) - 0.4 * 255
        found = drawn(curtain(alpha), (80, 60))
        sure = np.abs(level) > 1e-6
        assert sure.mean() > 0.9 or shape == (1, 1)
        np.testing.assert_array_equal(found[sure], level[sure] > 0)


def test_one_wrap_along_u_and_another_along_v():
    texture = np.random.default_rng(8).integers(0, 256, (5, 3)).astype(np.uint8)
    alpha = sl.AlphaTest(texture, unit((4, 4), (-2, -2)), wrap=("mirror", "clamp"))
    u, v = centres((90, 90))
    level = sampled(alpha, 4 * u - 2, 4 * v - 2) - 127.5
    sure = np.abs(level) > 1e-6
    np.testing.assert_array_equal(drawn(curtain(alpha), (90, 90))[sure], level[sure] > 0)


def test_a_large_texture_texel_for_texel():
    # 4096 texels along a side, one for each texel of the map.
    texture = np.random.default_rng(1).integers(0, 256, (4096, 4096), dtype=np.uint8)
    found = drawn(curtain(sl.AlphaTest(texture, unit())), (4096, 4096))
    # The share of a texel whose centre is missed by a rounding is that of the levels next to the cutoff.
    wrong = found != (texture >= 128)
    assert not wrong[np.abs(texture.astype(int) - 127.5) > 2].any()
    assert wrong.mean() < 1e-3


def test_coordinates_without_extent_read_one_place():
    texture = np.array([[255, 0]], np.uint8)
    for u, everything in [(0.25, True), (0.75, False), (1e9 + 0.0, False), (-3e38, False)]:
        scene = curtain(sl.AlphaTest(texture, np.full((4, 2), u), wrap=("clamp", "clamp")))
        assert drawn(scene, (16, 16)).all() == (everything or u < 0)
    # A triangle whose coordinates lie on a line, and one without area.
    alpha = sl.AlphaTest(texture, [[0, 0], [1, 0], [0.5, 0], [0.2, 0]])
    assert 0 < drawn(curtain(alpha), (16, 16)).mean() < 1
    flat = sl.Scene.from_arrays(np.zeros((4, 3)), FACES, alpha=alpha)
    assert not drawn(flat, (16, 16)).any()


def test_cutoff_and_factor():
    texture = np.full((2, 2), 100, np.uint8)
    for cutoff, factor, exists in [
        (100 / 255, 1, True),
        (0.5, 1, False),
        (0.5, 1.3, True),
        (1.01, 1, False),
        (0, 0, True),
    ]:
        scene = curtain(sl.AlphaTest(texture, unit(), cutoff, factor=factor))
        assert drawn(scene, (9, 9)).all() == exists, (cutoff, factor)
        assert drawn(scene, (9, 9)).any() == exists, (cutoff, factor)


def test_truth_of_a_fence_is_that_of_its_geometry():
    for light in (
        SUN,
        sl.PointLight((-1, 5, -3), range=50),
        sl.SpotLight((-1, 5, -3), (0.2, -1, 0.6), cone_angle=1.2, range=50),
    ):
        a, b = (sl.trace.shadow_mask(scene, CAMERA, light, size=SIZE) for scene in (fence(), carved()))
        decided = (a != -1) & (b != -1)
        np.testing.assert_array_equal(a[decided], b[decided])
        assert decided.mean() > 0.99
        assert (a == 0).mean() > 0.02


@pytest.mark.parametrize("name", list(dict.fromkeys(sl.techniques()["name"])))
def test_every_technique_draws_a_fence_as_its_geometry(name):
    holed, solid = fence(), carved()
    p = sl.technique(name).parameterize(holed, CAMERA, SUN, resolution=512)
    renderer = sl.Renderer("cpu")
    a, b = (renderer.shadow_map(scene, p, resolution=512) for scene in (holed, solid))
    # Edges of bars: geometry is rounded to 1/256 of a texel, textures are not.
    assert (np.abs(a - b) > 1e-6).mean() < 2e-3
    masks = [renderer.shadow_mask(scene, CAMERA, SUN, p, resolution=512, size=SIZE) for scene in (holed, solid)]
    assert (np.nan_to_num(masks[0], nan=2) != np.nan_to_num(masks[1], nan=2)).mean() < 4e-3
    truth = sl.trace.shadow_mask(holed, CAMERA, SUN, size=SIZE)
    known = (truth >= 0) & ~np.isnan(masks[0])
    wrong = ((masks[0] > 0.5) != (truth == 1)) & known
    # The fence is no solid board: that would be wrong in half of its shadow.
    board = floor() + sl.Scene.from_arrays(square((-2, 0, 0), (4, 0, 0), (0, 2, 0.3)), FACES)
    opaque = renderer.shadow_mask(board, CAMERA, SUN, p, resolution=512, size=SIZE)
    assert wrong.sum() < 0.5 * (((opaque > 0.5) != (truth == 1)) & known).sum()


def test_the_eye_sees_what_stands_behind_a_fence():
    a, b = (sl.Renderer("cpu").gbuffer(scene, CAMERA, size=SIZE) for scene in (fence(), carved()))
    floor_a, floor_b = a.instance == 0, b.instance == 0
    assert (floor_a != floor_b).mean() < 2e-3
    both = floor_a & floor_b
    np.testing.assert_allclose(a.position[both], b.position[both], atol=1e-5)
    through = floor_a & (a.triangle != -1)
    assert through.mean() > 0.2


def test_a_gpu_has_the_same_holes(gpu_renderer):
    scene = fence()
    for name in ("uniform", "lispsm", "z_partition:count=3"):
        p = sl.technique(name).parameterize(scene, CAMERA, SUN, resolution=512)
        a, b = (r.shadow_map(scene, p, resolution=512) for r in (gpu_renderer, sl.Renderer("cpu")))
        assert (np.abs(a - b) > 1e-5).mean() < 2e-3
        a, b = (
            r.shadow_mask(scene, CAMERA, SUN, p, resolution=512, size=SIZE) for r in (gpu_renderer, sl.Renderer("cpu"))
        )
        assert (np.nan_to_num(a, nan=2) != np.nan_to_num(b, nan=2)).mean() < 4e-3
    a, b = (r.gbuffer(scene, CAMERA, size=SIZE) for r in (gpu_renderer, sl.Renderer("cpu")))
    assert (a.instance != b.instance).mean() < 2e-3
    texture = np.random.default_rng(2).integers(0, 256, (33, 17)).astype(np.uint8)
    alpha = sl.AlphaTest(texture, unit((2.5, -3.5), (7.3, 1.1)), wrap=("mirror", "repeat"))
    u, v = centres((256, 256))
    ends = alpha.uv.astype(float)
    level = sampled(alpha, *(ends[0, k] + (ends[2, k] - ends[0, k]) * t for k, t in enumerate((u, v)))) - 127.5
    found = gpu_renderer.shadow_map(curtain(alpha), IDENTITY, resolution=256) < 1
    sure = np.abs(level) > NEAR
    np.testing.assert_array_equal(found[sure], level[sure] > 0)


def test_wrong_pixels_of_a_fence_have_the_causes_of_its_geometry():
    renderer = sl.Renderer("cpu")
    p = sl.technique("uniform").parameterize(fence(), CAMERA, SUN, resolution=256)
    found = []
    for scene in (fence(), carved()):
        gbuffer = renderer.gbuffer(scene, CAMERA, size=SIZE)
        mask = renderer.shadow_mask(scene, CAMERA, SUN, p, resolution=256, size=SIZE)
        truth = sl.trace.shadow_mask(scene, CAMERA, SUN, size=SIZE)
        maps = renderer.shadow_map(scene, p, resolution=256)
        found.append(sl.aliasing.causes(scene, CAMERA, SUN, p, mask, truth, gbuffer=gbuffer, maps=maps))
    a, b = (one.counts for one in found)
    assert b["edge"] > 200
    assert all(abs(a[name] - b[name]) <= 4 for name in a), (a, b)
    both = (found[0].image == 2) & (found[1].image == 2)
    # Edges of bars in a texture and of bars of triangles are as far away, to a part of a pixel.
    assert np.median(np.abs(found[0].distance - found[1].distance)[both]) < 0.05


def test_instances_and_threads():
    leaf = sl._core.Mesh(square((-1, 0, 0), (2, 0, 0), (0, 2, 0)), FACES, alpha=bars())
    ground = floor().meshes[0]
    transforms = np.tile(np.eye(4), (40, 1, 1))
    rng = np.random.default_rng(5)
    transforms[1:, :3, 3] = rng.uniform(-4, 4, (39, 3)) * [1, 0, 1]
    transforms[1:, 0, 0] = rng.choice([-1.0, 0.5, 1.0], 39)
    scene = sl.Scene([ground, leaf], [0] + [1] * 39, transforms)
    baked = floor()
    for t in transforms[1:]:
        baked = baked + sl.Scene([leaf], [0], t[None])
    p = sl.technique("lispsm").parameterize(scene, CAMERA, SUN, resolution=256)
    answers = []
    for threads in (1, 3):
        sl.set_threads(threads)
        for one in (scene, baked):
            renderer = sl.Renderer("cpu")
            answers.append(
                (
                    renderer.shadow_map(one, p, resolution=256),
                    renderer.gbuffer(one, CAMERA, size=SIZE).depth,
                    sl.trace.shadow_mask(one, CAMERA, SUN, size=SIZE),
                )
            )
    sl.set_threads(None)
    for other in answers[1:]:
        for a, b in zip(answers[0], other, strict=True):
            np.testing.assert_array_equal(a, b)
