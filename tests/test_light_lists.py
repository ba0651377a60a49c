"""Several lights where one is taken: each callable has a row here that says what it does with a list of them.

The rows are held against the callables that are found by looking at the package, so that a new one needs a row.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hostile.calls import arguments, invoke
from hostile.examples import SIZE, world
from hostile.found import Callee, callees

import shadowlab as sl

#: A result per light, or one of all.
TAKE_SEVERAL = {
    "Renderer.shadow_states", "View", "_core.trace_shadow_masks", "sl.advise", "sl.aliasing.temporal", "sl.evaluate",
    "sl.plot.samples_and_maps", "sl.predict", "sl.smallest_bias", "sl.trace.shadow_mask", "sl.trace.soft_shadow_mask",
}  # fmt: skip
#: What has a view or a light as a field, and looks at nothing of it.
HOLD_SEVERAL = {"PixelExplanation", "PrefilteredMaps", "Run", "Study"}
#: One light each: the matrices, maps and pictures that they take or give are those of one.
TAKE_ONE = {
    "Bias.at", "LightPlane.of", "Preset.parameterize", "Preset.technique", "Renderer.casters", "Renderer.chosen_map",
    "Renderer.footprint", "Renderer.seen_map", "Renderer.shadow_mask", "Samples.from_arrays", "Samples.from_gbuffer",
    "Technique.parameterize", "TemporalFit.parameterize", "sl.aliasing.beam_texels", "sl.aliasing.causes",
    "sl.aliasing.footprint", "sl.aliasing.footprint_at", "sl.aliasing.halfway_normals", "sl.aliasing.look_up",
    "sl.aliasing.texel_coordinates", "sl.aliasing.usage", "sl.compare", "sl.explain_pixel", "sl.plot.cause_map",
    "sl.plot.cause_picture", "sl.plot.chosen_view", "sl.plot.culled", "sl.plot.difference", "sl.plot.difference_view",
    "sl.plot.error_map", "sl.plot.error_picture", "sl.plot.eye_view", "sl.plot.lattice", "sl.plot.lattice_picture",
    "sl.plot.light_view", "sl.plot.samples_view", "sl.plot.shade", "sl.prefiltered_maps",
}  # fmt: skip
#: An error names the argument, and says what to do with several.
SAYS_WHAT_TO_DO = re.compile(
    r"^(light|view)[^:]*: expected one light, got (several|2)\b.*; .*(for each|sl\.evaluate)", re.DOTALL
)


def lights() -> list[Any]:
    return [world().light, sl.DirectionalLight((-0.5, -1, 0.1))]


def several(callee: Callee) -> dict[str, Any] | None:
    """A good call with two lights; None for what takes no light."""
    given = None
    for name in (parameter.name for parameter in callee.parameters):
        if name not in ("light", "lights", "view"):
            continue
        good = dict(arguments(callee))
        if name == "view" and not isinstance(good[name], sl.View):
            continue
        w = world()
        given = good | {name: sl.View(w.scene, w.camera, lights(), size=SIZE) if name == "view" else lights()}
        if "parameterizations" in given:
            given["parameterizations"] = [w.p, w.p]
    return given


FOUND = {callee.name: callee for callee in callees() if several(callee) is not None}
INSIDE = {name for name in FOUND if name.startswith("_core.")} - TAKE_SEVERAL


def test_each_callable_has_a_row() -> None:
    assert set(FOUND) == TAKE_SEVERAL | HOLD_SEVERAL | TAKE_ONE | INSIDE
    assert len(TAKE_SEVERAL) + len(HOLD_SEVERAL) + len(TAKE_ONE) + len(INSIDE) == len(FOUND), "no two rows"


@pytest.mark.parametrize("name", sorted(TAKE_SEVERAL | HOLD_SEVERAL))
def test_what_takes_several_lights_has_a_result(name: str) -> None:
    assert invoke(FOUND[name], several(FOUND[name]) or {}) is not None


@pytest.mark.parametrize("name", sorted(TAKE_ONE | INSIDE))
def test_what_takes_one_light_says_what_to_do_with_several(name: str) -> None:
    with pytest.raises(sl.errors.ArgumentError) as raised:
        invoke(FOUND[name], several(FOUND[name]) or {})
    assert SAYS_WHAT_TO_DO.match(str(raised.value)), raised.value


@pytest.mark.parametrize("trace", [sl.trace.shadow_mask, sl.trace.soft_shadow_mask])
def test_truth_of_several_lights_is_that_of_each(trace: Callable[..., Any]) -> None:
    scene = sl.library.scene("robots")
    given = [scene.light, sl.PointLight((0, 6, 0), range=40.0), sl.DirectionalLight((0.4, -1.0, 0.2))]
    together = trace(scene, scene.camera, given, size=(64, 48))
    assert isinstance(together, tuple)
    for light, truth in zip(given, together, strict=True):
        np.testing.assert_array_equal(truth, trace(scene, scene.camera, light, size=(64, 48)))
    assert not np.array_equal(together[0], together[1], equal_nan=True)
    (alone,) = trace(scene, scene.camera, given[:1], size=(64, 48))
    np.testing.assert_array_equal(alone, together[0])


@pytest.mark.parametrize("trace", [sl.trace.shadow_mask, sl.trace.soft_shadow_mask])
def test_no_light_and_what_is_none_are_refused(trace: Callable[..., Any]) -> None:
    w = world()
    with pytest.raises(sl.errors.ArgumentError, match="light: expected at least one light, got none"):
        trace(w.scene, w.camera, [], size=SIZE)
    with pytest.raises(sl.errors.ArgumentError, match=r"light: expected a DirectionalLight, .*, got int"):
        trace(w.scene, w.camera, [w.light, 3], size=SIZE)
