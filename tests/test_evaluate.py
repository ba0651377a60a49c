"""The evaluator: one technique at one resolution in one view."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.experiments import columns
from shadowlab.experiments.metrics import KNOWN_METRICS, MEASURED

SIZE = (160, 90)


@pytest.fixture(scope="module")
def view() -> sl.View:
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=SIZE, label="noon")


class Counting:
    """A renderer that counts what it is asked for."""

    backend, adapter = "counting", "the processor"

    def __init__(self) -> None:
        self.renderer = sl.Renderer("cpu")
        self.calls: dict[str, int] = {}

    def _count(self, name: str, *args, **kwargs):
        self.calls[name] = self.calls.get(name, 0) + 1
        return getattr(self.renderer, name)(*args, **kwargs)

    def gbuffer(self, *args, **kwargs):
        return self._count("gbuffer", *args, **kwargs)

    def shadow_map(self, *args, **kwargs):
        return self._count("shadow_map", *args, **kwargs)

    def shadow_mask(self, *args, **kwargs):
        return self._count("shadow_mask", *args, **kwargs)


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "z_partition:count=3,inner=lispsm", "log"])
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
def test_a_run_is_what_its_parts_give(view: sl.View, technique: str, filter: str) -> None:
    renderer, bias = sl.Renderer("cpu"), sl.Bias(texels=0.5)
    run = sl.evaluate(view, technique, 256, renderer=renderer, filter=filter, bias=bias)
    samples = view.samples(renderer=renderer)
    p = sl.technique(technique).parameterize(view.scene, view.camera, view.light, resolution=256, samples=samples)
    np.testing.assert_array_equal(run.parameterization.matrices, p.matrices)
    np.testing.assert_array_equal(run.maps, renderer.shadow_map(view.scene, p, resolution=256))
    how = {"resolution": 256, "size": SIZE, "bias": bias, "filter": filter}
    mask = renderer.shadow_mask(view.scene, view.camera, view.light, p, **how)
    np.testing.assert_array_equal(run.mask, mask)
    truth = sl.trace.shadow_mask(view.scene, view.camera, view.light, size=SIZE)
    errors = sl.aliasing.misclassified(mask, truth)
    gbuffer = renderer.gbuffer(view.scene, view.camera, size=SIZE)
    looks = (gbuffer, view.camera, view.light, p)
    causes = sl.aliasing.causes(
        view.scene, view.camera, view.light, p, mask, truth, gbuffer=gbuffer, maps=run.maps, bias=bias, filter=filter
    )
    summary = sl.aliasing.footprint(*looks, resolution=256).summary()
    row = run.row()
    assert row["misclassified"] == errors.count > 0
    assert {name: row[name] for name in causes.counts} == causes.counts
    assert (row["texel_mean"], row["texel_max"]) == (summary.mean, summary.max)
    assert row["unused"] == sl.aliasing.usage(*looks, resolution=256, filter=filter).unused
    assert (row["scene"], row["view"], row["technique"], row["failure"]) == ("robots", "noon", technique, "")


def test_only_what_is_asked_for_is_computed(view: sl.View) -> None:
    wanted = {
        "mask": {"map_ms", "lookup_ms"},
        "misclassified": {"map_ms", "lookup_ms", *columns.OF_WRONG},
        "texels": {"measured", "outside", "undersampled", "texel_mean", "texel_p50", "texel_p95", "texel_p99",
                   "texel_max", "perspective_max", "storage_factor"},
        "usage": {"unused"},
    }  # fmt: skip
    for metric, filled in wanted.items():
        renderer = Counting()
        run = sl.evaluate(view, "uniform", 128, metrics=[metric], renderer=renderer)
        assert {name for name in MEASURED if run.row()[name] is not None} == filled | {"fit_us"}, metric
        assert renderer.calls.get("shadow_map", 0) == int(metric in ("mask", "misclassified")), metric
        assert "shadow_mask" not in renderer.calls, "the maps that are there are looked up"
    renderer = Counting()
    run = sl.evaluate(view, "uniform", 128, metrics=[], renderer=renderer)
    assert not renderer.calls
    assert run.maps.shape == (128, 128), "arrays are made when they are asked for"
    assert renderer.calls == {"shadow_map": 1}


def test_without_timing_each_part_runs_once_and_with_it_more_often(view: sl.View) -> None:
    once, often = Counting(), Counting()
    sl.evaluate(view, "uniform", 128, renderer=once)
    assert once.calls == {"gbuffer": 1, "shadow_map": 1}
    sl.evaluate(view, "uniform", 128, renderer=often, timing=True)
    assert often.calls["shadow_map"] > 1


def test_a_view_is_drawn_and_traced_once_for_all_runs_and_clear_forgets(monkeypatch: pytest.MonkeyPatch) -> None:
    from shadowlab import _core

    traced = []
    trace = _core.trace_shadow_mask
    monkeypatch.setattr(_core, "trace_shadow_mask", lambda *a, **k: traced.append(1) or trace(*a, **k))
    scene = sl.library.scene("dueling")
    renderer = Counting()
    views = [sl.View(scene, scene.camera, scene.light, size=64) for _ in range(2)]
    for one in views:
        for technique in ("uniform", "lispsm"):
            sl.evaluate(one, technique, 64, renderer=renderer)
    assert (renderer.calls["gbuffer"], len(traced)) == (1, 1), "equal views share both"
    assert views[0].gbuffer(renderer) is views[1].gbuffer(renderer)
    views[0].clear()
    assert views[0].truth() is not None
    views[0].gbuffer(renderer)
    assert (renderer.calls["gbuffer"], len(traced)) == (2, 2)


def test_lights_of_a_view_are_traced_together_and_are_what_each_is_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    from shadowlab import _core

    together = []
    trace = _core.trace_shadow_masks
    monkeypatch.setattr(_core, "trace_shadow_masks", lambda *a, **k: together.append(len(a[2])) or trace(*a, **k))
    scene = sl.library.scene("dueling")
    lights = [
        scene.light,
        sl.DirectionalLight((0.4, -1.0, 0.2)),
        sl.PointLight((0.0, 5.0, 1.0), range=100.0),
        scene.light,
    ]
    view = sl.View(scene, scene.camera, lights, size=(96, 64))
    view.clear()
    truths = view.truth()
    assert together == [3], "equal lights are one"
    assert view.truth_ms > 0
    assert together == [3], "kept"
    for light, truth in zip(lights, truths, strict=True):
        assert np.array_equal(truth, sl.trace.shadow_mask(scene, scene.camera, light, size=(96, 64)))
    assert not np.array_equal(truths[0], truths[1])
    more = sl.View(scene, scene.camera, [lights[1], sl.DirectionalLight((-0.3, -1.0, 0.1))], size=(96, 64))
    assert np.array_equal(more.truth()[0], truths[1])
    assert together == [3], "only one is new"
    view.clear()


def test_lights_that_are_evaluated_share_the_eye_view_and_its_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    from shadowlab import _core

    traced: list[int] = []
    alone, together = _core.trace_shadow_mask, _core.trace_shadow_masks
    monkeypatch.setattr(_core, "trace_shadow_mask", lambda *a, **k: traced.append(1) or alone(*a, **k))
    monkeypatch.setattr(_core, "trace_shadow_masks", lambda *a, **k: traced.append(len(a[2])) or together(*a, **k))
    scene = sl.library.scene("robots")
    lights = [sl.DirectionalLight((x, -1.0, 0.3)) for x in (0.2, 0.5, 0.9)]
    view = sl.View(scene, scene.camera, lights, size=(97, 64))
    view.clear()
    run = sl.evaluate(view, "uniform", 64, metrics=("misclassified",), renderer="cpu")
    assert traced == [3]
    assert [part.numbers["compared"] for part in run.parts] == [errors.compared for errors in run.errors]
    assert traced == [3], "kept"
    sl.evaluate(view, "uniform", 64, metrics=("texels",), renderer="cpu")
    assert traced == [3], "no truth is needed"
    view.clear()


def test_a_truth_that_is_shared_cannot_be_written_to(view: sl.View) -> None:
    with pytest.raises(ValueError, match="read-only"):
        view.truth()[0, 0] = 1


def test_views_are_values(view: sl.View) -> None:
    same = sl.View(view.scene, view.camera, view.light, size=list(SIZE), label="noon")
    assert same == view
    assert hash(same) == hash(view)
    assert sl.View(view.scene, view.camera, view.light, size=SIZE, label="dawn") != view
    with pytest.raises(AttributeError):
        view.label = "dusk"  # type: ignore[misc]
    fitting = sl.View(view.scene, view.camera, view.light, size=None)
    assert fitting.size[0] / fitting.size[1] == pytest.approx(view.camera.aspect, rel=1e-2)
    assert sl.View(view.scene, view.camera, view.light).size == (1024, 1024)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scene": 1}, "scene: expected a Scene"),
        ({"camera": None}, "camera: expected a Camera"),
        ({"light": "sun"}, "light: expected a light.*DirectionalLight"),
        ({"light": []}, "light: expected at least one"),
        ({"size": (0, 5)}, "size: expected a whole number above 0"),
        ({"size": (1, 2, 3)}, "size: expected"),
        ({"label": 3}, "label: expected text"),
    ],
)
def test_a_view_of_something_else_says_what_it_expected(view: sl.View, change: dict, message: str) -> None:
    given = {"scene": view.scene, "camera": view.camera, "light": view.light, "size": SIZE, **change}
    with pytest.raises(sl.errors.ArgumentError, match=message):
        sl.View(**given)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"view": 1}, sl.errors.ArgumentError, "view: expected a View"),
        ({"technique": "lipsm"}, sl.errors.UnknownNameError, "lispsm"),
        ({"technique": 3}, sl.errors.ArgumentError, "expected a name"),
        ({"resolution": 0}, sl.errors.ArgumentError, "resolution"),
        ({"metrics": ["speed"]}, sl.errors.UnknownNameError, "unknown metric 'speed'.*misclassified"),
        ({"metrics": "usage"}, sl.errors.ArgumentError, "expected several"),
        ({"filter": "pcf9"}, sl.errors.UnknownNameError, "filter"),
        ({"bias": 0.1}, sl.errors.ArgumentError, "bias: expected a Bias"),
        ({"renderer": 5}, sl.errors.ArgumentError, "renderer"),
    ],
)
def test_arguments_are_checked_before_any_work(view: sl.View, change: dict, error: type, message: str) -> None:
    given = {"view": view, "technique": "uniform", "resolution": 64, **change}
    with pytest.raises(error, match=message):
        sl.evaluate(given.pop("view"), given.pop("technique"), given.pop("resolution"), **given)


def test_what_a_technique_cannot_do_is_the_failure_of_its_run(view: sl.View) -> None:
    lamp = sl.View(view.scene, view.camera, sl.PointLight((0, 8, 0), range=50.0), size=SIZE)
    run = sl.evaluate(lamp, "log", 64)
    assert run.failure
    assert run.row()["misclassified"] is None
    assert run.maps is run.mask is run.errors is run.causes is run.footprint is None


def test_counts_of_several_lights_add_up_and_the_worst_texel_stays(view: sl.View) -> None:
    lights = [view.light, sl.DirectionalLight((-1, -0.4, 0.2))]
    both = sl.View(view.scene, view.camera, lights, size=SIZE, label="two")
    run = sl.evaluate(both, "lispsm", 128, renderer="cpu")
    alone = [sl.evaluate(one, "lispsm", 128, renderer="cpu") for one in both.views]
    assert [part.numbers["misclassified"] for part in run.parts] == [one.numbers["misclassified"] for one in alone]
    row = run.row()
    assert row["misclassified"] == sum(one.numbers["misclassified"] for one in alone)
    assert row["maps"] == 2
    assert row["share"] == row["misclassified"] / sum(one.numbers["compared"] for one in alone)
    assert row["texel_max"] == max(one.numbers["texel_max"] for one in alone)
    assert len(run.maps) == len(both.truth()) == 2
    assert both.views[0].gbuffer("cpu") is both.gbuffer("cpu")
    assert set(row) >= {"scene", "view", "technique", "resolution", "misclassified", "failure"}


def test_arrays_that_had_to_go_are_made_again(view: sl.View, monkeypatch: pytest.MonkeyPatch) -> None:
    from shadowlab.experiments import drawing
    from shadowlab.scene.kept import Kept

    run = sl.evaluate(view, "lispsm", 128, renderer="cpu")
    before = [np.array(run.maps), np.array(run.mask), np.array(run.errors.image), np.array(run.causes.image)]
    monkeypatch.setattr(drawing, "KEPT", Kept(0))
    after = [run.maps, run.mask, run.errors.image, run.causes.image]
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)


def test_no_renderer_of_ours_is_kept_alive_and_others_are_told_apart(view: sl.View) -> None:
    import sys
    import weakref

    class Elsewhere:
        """Draws as ours does, and says that it is equal to all."""

        backend, adapter = "other", "elsewhere"

        def __init__(self) -> None:
            self.shadow_map, self.shadow_mask, self.gbuffer = ours.shadow_map, ours.shadow_mask, ours.gbuffer

        def __eq__(self, other: object) -> bool:
            return True

        def __hash__(self) -> int:
            return 1

    ours = sl.Renderer("cpu")
    fresh = sl.View(view.scene, view.camera, view.light, size=(31, 17))
    before = sys.getrefcount(ours)
    picture = fresh.gbuffer(ours)
    assert sys.getrefcount(ours) == before
    assert fresh.gbuffer("cpu") is picture
    one, other = Elsewhere(), Elsewhere()
    theirs = fresh.gbuffer(one)
    assert theirs is fresh.gbuffer(one)
    assert theirs is not picture
    assert fresh.gbuffer(other) is not theirs
    # Its place in memory, by which it is known, stays its own as long as its picture is kept.
    alive = weakref.ref(one)
    del one
    assert alive() is not None
    fresh.clear()
    assert alive() is None


def test_arrays_go_with_their_run(view: sl.View) -> None:
    import gc

    from shadowlab.experiments import drawing

    gc.collect()
    before = drawing.KEPT.bytes
    run = sl.evaluate(view, "uniform", 512, renderer="cpu")
    assert drawing.KEPT.bytes >= before + 4 * 512 * 512
    del run
    gc.collect()
    assert drawing.KEPT.bytes <= before


def test_metrics_are_the_ones_that_the_documentation_names() -> None:
    for name in KNOWN_METRICS:
        assert f'"{name}"' in (sl.evaluate.__doc__ or ""), name


def test_a_run_that_travelled_draws_its_arrays_again(view: sl.View) -> None:
    import pickle

    run = sl.evaluate(view, "lispsm", 128, renderer="cpu")
    back = pickle.loads(pickle.dumps(run))
    assert (back, hash(back)) == (run, hash(run))
    np.testing.assert_array_equal(back.maps, run.maps)
    np.testing.assert_array_equal(back.errors.image, run.errors.image)


def test_a_run_of_a_renderer_from_elsewhere_says_that_it_stayed_behind(view: sl.View) -> None:
    import pickle

    run = sl.evaluate(view, "lispsm", 128, renderer=Counting())
    back = pickle.loads(pickle.dumps(run))
    assert back.numbers == run.numbers
    with pytest.raises(sl.errors.ArgumentError, match="evaluate again with that renderer"):
        _ = back.maps
