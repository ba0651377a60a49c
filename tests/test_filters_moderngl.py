"""Filtered masks of both renderers against a GLSL program of the same kernel, on the same map and points."""

import numpy as np
import pytest
from filter_support import disc

import shadowlab as sl

RESOLUTION = 512
SIZE = (320, 180)
BIAS = 2e-4
#: Places in a map of 512 texels in single precision: 512 * 2^-24 * a few roundings, over the width of the kernel.
WEIGHTS = 5e-4
#: Pixels with comparisons that go the other way by rounding: of a depth, or of a point at a texel's border.
BORDERLINE = 0.01
KERNELS = {
    "nearest": (0, 1.0, None),
    "bilinear": (1, 1.0, None),
    "pcf:size=3": (1, 3.0, None),
    "pcf:size=5.5": (1, 5.5, None),
    "poisson:count=16,radius=2.5,seed=2": (2, 1.0, 2.5 * disc(16, 2)),
}


@pytest.fixture(scope="module")
def seen():
    """A scene with its map and G-buffer."""
    scene = sl.library.scene("robots")
    p = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light, resolution=RESOLUTION)
    cpu = sl.Renderer("cpu")
    g, depths = cpu.gbuffer(scene, scene.camera, size=SIZE), cpu.shadow_map(scene, p)
    origin = np.asarray(g.origin)
    moved = np.eye(4)
    moved[:3, 3] = origin
    return scene, p, g, depths, np.asarray(p.matrix) @ moved, g.position - origin


@pytest.fixture(scope="module")
def filtered(seen, moderngl_peer):
    from peers.filter_peer import Filtered

    scene, _, g, depths, matrix, position = seen
    peer = Filtered(moderngl_peer, depths, matrix, -np.asarray(scene.light.direction), BIAS)
    peer.surfaces(position, g.normal)
    return peer


@pytest.mark.parametrize("text", KERNELS)
def test_masks_are_those_of_the_same_kernel_in_glsl(text, seen, filtered, renderer, record_property):
    scene, p, g, depths, _, _ = seen
    filtered.kernel(*KERNELS[text])
    theirs = filtered.mask()
    bias = sl.Bias(ndc=BIAS, texels=0, slope=0, plane=0)
    if renderer.backend == "cpu":
        ours = sl.aliasing.look_up(depths, g, scene.camera, scene.light, p, bias=bias, filter=text)
    else:
        ours = renderer.shadow_mask(scene, scene.camera, scene.light, p, size=SIZE, bias=bias, filter=text)
    there = ~np.isnan(ours)
    assert (ours[there] > 0.99).mean() > 0.1
    assert (ours[there] < 0.01).mean() > 0.02
    if text != "nearest":
        assert ((ours[there] > 0.01) & (ours[there] < 0.99)).sum() > 300
    apart = np.abs(ours - theirs)[there]
    record_property("apart", float((apart > WEIGHTS).mean()))
    assert (apart > WEIGHTS).mean() <= BORDERLINE
    # A comparison that goes the other way has the weight of one texel or point.
    weight = {"nearest": 1.0, "bilinear": 1.0}.get(text, 0.35)
    assert (apart > weight).mean() <= 0.001
