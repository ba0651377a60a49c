"""Names of the numbers in images of codes, held against images that have them."""

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.aliasing import Cause, Difference, NoTexel
from shadowlab.trace import Truth


@pytest.fixture(scope="module")
def run() -> sl.Run:
    scene = sl.library.scene("robots")
    # A coarse map with splits that leave out what is far, so that every code there is occurs.
    view = sl.View(scene, scene.camera, scene.light, size=(320, 180))
    return sl.evaluate(view, "uniform", 96, renderer="cpu", bias=sl.Bias(world=0.05))


def test_truth_names_what_rays_say(run: sl.Run) -> None:
    truth, gbuffer = run.view.truth(), run.view.gbuffer("cpu")
    assert set(np.unique(truth)) <= set(Truth)
    seen = np.asarray(gbuffer.triangle) >= 0
    assert ((truth == Truth.NOTHING) == ~seen).mean() > 0.999, "apart from pixels on silhouettes"
    towards = np.einsum("hwk,k->hw", gbuffer.normal, -np.asarray(run.view.light.direction))
    assert not ((truth == Truth.LIT) & (towards < 0) & seen).any(), "what faces away is in shadow"
    assert (truth == Truth.LIT).any()
    assert (truth == Truth.SHADOW).any()
    assert (Truth.LIT, Truth.SHADOW, Truth.UNDECIDED, Truth.NOTHING) == (1, 0, -1, -2), "the numbers stay"


def test_differences_are_counted_under_their_names(run: sl.Run) -> None:
    errors = run.errors
    assert set(np.unique(errors.image)) <= set(Difference)
    assert np.count_nonzero(errors.image == Difference.FALSE_SHADOW) == errors.false_shadow > 0
    assert np.count_nonzero(errors.image == Difference.FALSE_LIGHT) == errors.false_light > 0
    assert np.count_nonzero(errors.image == Difference.NOT_COMPARED) == errors.image.size - errors.compared


def test_causes_are_counted_under_their_names(run: sl.Run) -> None:
    causes = run.causes
    assert set(np.unique(causes.image)) <= set(Cause)
    for name, count in causes.counts.items():
        assert np.count_nonzero(causes.image == Cause[name.upper()]) == count
    wrong = np.isin(run.errors.image, [Difference.FALSE_SHADOW, Difference.FALSE_LIGHT])
    np.testing.assert_array_equal(causes.image > Cause.RIGHT, wrong)
    np.testing.assert_array_equal(causes.image == Cause.NOT_COMPARED, run.errors.image == Difference.NOT_COMPARED)


def test_pixels_without_a_texel_say_why(run: sl.Run) -> None:
    e, gbuffer = run.footprint, run.view.gbuffer("cpu")
    assert set(np.unique(e.map)) <= {0, *NoTexel}
    np.testing.assert_array_equal(e.map == NoTexel.NOTHING, np.asarray(gbuffer.triangle) < 0)
    towards = np.einsum("hwk,k->hw", gbuffer.normal, -np.asarray(run.view.light.direction))
    assert (towards[e.map == NoTexel.AVERTED] <= 1e-6).all()
    assert (e.map == NoTexel.AVERTED).any()
    assert e.counts()["held by no map"] == np.count_nonzero(e.map == NoTexel.NO_MAP)
