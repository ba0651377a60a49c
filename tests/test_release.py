"""What renderers keep between calls, and give back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import shadowlab as sl

# What a process must be rid of, of a texture and a buffer for a map of 4096² texels, 64 MiB each.
GIVEN_BACK = 96 << 20


def test_what_is_released_is_made_anew(renderer):
    scene = sl.library.scene("robots")
    p = sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=128)

    def drawn():
        mask = renderer.shadow_mask(scene, scene.camera, scene.light, p, size=64, filter="pcf:size=3")
        return renderer.shadow_map(scene, p), renderer.gbuffer(scene, scene.camera, size=64).position, mask

    before = drawn()
    for _ in range(2):
        assert renderer.release() is None
    for a, b in zip(before, drawn(), strict=True):
        np.testing.assert_array_equal(a, b)


def resident() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no count of memory")
def test_a_software_device_gives_memory_back(gpu_renderer):
    if "llvmpipe" not in gpu_renderer.adapter:
        pytest.skip("the device has memory of its own")
    scene = sl.library.scene("robots")
    p = sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=64)
    gpu_renderer.shadow_map(scene, p, resolution=4096)
    kept = resident()
    gpu_renderer.release()
    assert kept - resident() > GIVEN_BACK
