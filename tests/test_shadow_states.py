"""The states of many lights as bits, from Python: those of masks, light by light."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl

SIZE = (97, 64)


@pytest.fixture(scope="module")
def scene() -> sl.Scene:
    return sl.library.scene("robots")


def lights(count: int) -> list[sl.DirectionalLight | sl.SpotLight | sl.PointLight]:
    turns = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    suns = [sl.DirectionalLight((np.cos(a), -1.2, np.sin(a))) for a in turns]
    lamps = [
        sl.PointLight((0, 6, 0), range=60.0),
        sl.SpotLight((2, 8, 3), (-0.2, -1.0, -0.3), cone_angle=1.4, range=60.0),
    ]
    return [*lamps, *suns][:count]


def bit(states: np.ndarray, i: int) -> np.ndarray:
    """Where light i arrives, as the documentation says it."""
    picture = states if states.ndim == 2 else states[i // 32]
    return (picture >> np.uint32(i % 32)) & 1 == 1


@pytest.mark.parametrize("backend", ["cpu", "gpu"])
@pytest.mark.parametrize(
    "how",
    [
        {},
        {"filter": "pcf:size=3", "bias": sl.Bias(world=0.05)},
        {"filter": "bilinear", "stored": "back", "cull": "none"},
        {"cull": "seen", "bias": sl.Bias.none()},
    ],
)
def test_bits_are_those_of_masks(scene: sl.Scene, backend: str, how: dict, request: pytest.FixtureRequest) -> None:
    if backend == "gpu":
        request.getfixturevalue("gpu_renderer")
    renderer = sl.Renderer(backend)
    given = lights(5)
    names = ["uniform", "lispsm:range=body", "z_partition:count=2", "tsm", "uniform"]
    maps = [
        sl.technique(name).parameterize(scene, scene.camera, light, resolution=128)
        for name, light in zip(names, given, strict=True)
    ]
    states = renderer.shadow_states(scene, scene.camera, given, maps, size=SIZE, **how)
    assert (states.dtype, states.shape) == (np.uint32, SIZE[::-1])
    for i, (light, p) in enumerate(zip(given, maps, strict=True)):
        mask = renderer.shadow_mask(scene, scene.camera, light, p, size=SIZE, **how)
        # Nothing there is NaN in a mask and 0 here.
        np.testing.assert_array_equal(bit(states, i), mask >= 0.5)
    assert not (states >> np.uint32(len(given))).any()
    assert len(np.unique(states)) > 4


def test_a_bit_says_what_counts_as_lit_against_the_truth(scene: sl.Scene) -> None:
    light, renderer = scene.light, sl.Renderer("cpu")
    p = sl.technique("uniform").parameterize(scene, scene.camera, light, resolution=128)
    states = renderer.shadow_states(scene, scene.camera, [light], [p], size=SIZE, filter="pcf:size=3")
    mask = renderer.shadow_mask(scene, scene.camera, light, p, size=SIZE, filter="pcf:size=3")
    truth = sl.trace.shadow_mask(scene, scene.camera, light, size=SIZE)
    compared = (truth >= 0) & ~np.isnan(mask)
    wrong = compared & (bit(states, 0) != (truth == sl.trace.Truth.LIT))
    assert wrong.sum() == sl.aliasing.misclassified(mask, truth).count > 0


def test_more_than_32_lights_take_more_than_one_picture(scene: sl.Scene) -> None:
    given, renderer = lights(33), sl.Renderer("cpu")
    t = sl.technique("uniform:range=body")
    maps = [t.parameterize(scene, scene.camera, light, resolution=32) for light in given]
    states = renderer.shadow_states(scene, scene.camera, given, maps, size=SIZE)
    assert states.shape == (2, *SIZE[::-1])
    for i in (0, 31, 32):
        mask = renderer.shadow_mask(scene, scene.camera, given[i], maps[i], size=SIZE)
        np.testing.assert_array_equal(bit(states, i), mask >= 0.5)
    assert states[1].max() == 1
    assert renderer.shadow_states(scene, scene.camera, given[:32], maps[:32], size=SIZE).ndim == 2


def test_the_eye_view_does_not_depend_on_the_resolution_of_maps(scene: sl.Scene) -> None:
    given, renderer = lights(4), sl.Renderer("cpu")
    matrices = [np.asarray(sl.technique("uniform").parameterize(scene, scene.camera, x).matrices) for x in given]
    states = renderer.shadow_states(scene, scene.camera, given, matrices, size=SIZE, resolution=(64, 32))
    for i, (light, p) in enumerate(zip(given, matrices, strict=True)):
        mask = renderer.shadow_mask(scene, scene.camera, light, p, size=SIZE, resolution=(64, 32))
        np.testing.assert_array_equal(bit(states, i), mask >= 0.5)


def test_lights_and_maps_that_do_not_belong_together_are_refused(scene: sl.Scene) -> None:
    light, renderer = scene.light, sl.Renderer("cpu")
    p = sl.technique("uniform").parameterize(scene, scene.camera, light, resolution=32)

    def states(lights: object, maps: object, size: object = SIZE) -> object:
        return renderer.shadow_states(scene, scene.camera, lights, maps, size=size)  # type: ignore[arg-type]

    for given, expected in [
        (([light, light], [p]), "parameterizations: expected a parameterization for each of 2 lights, got 1"),
        (([], []), "lights: expected at least one light, got none"),
        ((light, [p]), "lights: expected several lights, got DirectionalLight"),
        (([light, 3], [p, p]), r"lights\[1\]: expected a DirectionalLight, SpotLight or PointLight, got int"),
        (([light], [3]), "parameterization"),
        (([light], p), "parameterizations: expected a parameterization for each light"),
        (([light], [p], 0), "size"),
    ]:
        with pytest.raises(sl.errors.ArgumentError, match=expected):
            states(*given)
