"""What is said of a truth that leaves much undecided."""

import re
import warnings

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ShadowlabWarning

SIZE = 64


def view():
    scene = sl.library.scene("robots")
    camera, light, *_ = sl.default_view(scene)
    return scene, camera, light


def with_a_triangle_at(scene, distance):
    far = sl.Scene.from_arrays([[distance, 0, 0], [distance, 1, 0], [distance, 0, 1]], [[0, 1, 2]])
    return scene + far


def test_an_ordinary_scene_is_traced_without_a_word():
    scene, camera, light = view()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sl.trace.shadow_mask(scene, camera, light, size=SIZE)
        sl.trace.shadow_mask(scene, camera, [light, sl.PointLight((0, 5, 0), range=200)], size=SIZE)


@pytest.mark.parametrize("several", [False, True])
def test_a_scene_with_an_instance_far_away_is_told_how_much_is_undecided(several):
    scene, camera, light = view()
    distance = 1e6
    stretched = with_a_triangle_at(scene, distance)
    lights = [light] if several else light
    with pytest.warns(ShadowlabWarning, match="leave out instances far from all others") as caught:
        masks = sl.trace.shadow_mask(stretched, camera, lights, size=SIZE)
    (said,) = caught
    assert said.filename == __file__
    mask = masks[0] if several else masks
    numbers = r"(\d+)% .* about (\S+) units, .* (\S+) units across"
    percent, resolved, across = re.match(numbers, str(said.message)).groups()
    share = (mask == sl.trace.Truth.UNDECIDED).sum() / (mask != sl.trace.Truth.NOTHING).sum()
    assert int(percent) == round(100 * share) > 10
    assert float(across) == pytest.approx(np.ptp(stretched.bounds, axis=0).max(), rel=0.01)
    assert float(resolved) == pytest.approx(float(across) / 2 * 2.0**-22, rel=0.05)
