"""The footprint of a texel in Python: what follows from its arrays, somebody's own matrices, errors."""

from __future__ import annotations

import doctest
import importlib

import numpy as np
import pytest
from footprint_support import EXACT, FROM_DETERMINANT, MAPS, RENDERER, ROBOTS, ROBOTS_SEEN, SINGLE, SIZE, of, synthetic
from hypothesis import given, settings
from hypothesis import strategies as st

import shadowlab as sl
from shadowlab.aliasing.footprint import AVERTED, NO_MAP, NOTHING, sides_of
from shadowlab.errors import ArgumentError

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(params=MAPS)
def measured(request):
    """Footprints of some maps."""
    return of(MAPS[request.param])


def test_what_follows_from_the_jacobian_is_what_numpy_says(measured):
    f, m = measured, measured.measured
    assert f.major.dtype == np.float32
    assert f.jacobian.shape == (*SIZE[::-1], 2, 2)
    assert f.size == SIZE
    j = f.jacobian[m].astype(np.float64)
    u, s, vt = np.linalg.svd(j)
    np.testing.assert_allclose(f.major[m], s[:, 0], rtol=SINGLE)
    # A determinant of entries in float32 is good to their digits; the core has it from more.
    np.testing.assert_allclose(f.minor[m], s[:, 1], rtol=SINGLE, atol=SINGLE * s[:, 0].max(initial=0))
    np.testing.assert_allclose(f.area[m], f.major[m] * f.minor[m], rtol=SINGLE)
    np.testing.assert_allclose(f.perspective[m], f.area[m] / f.projection[m], rtol=SINGLE)
    np.testing.assert_allclose(f.texels_per_pixel[m] * f.area[m], 1, rtol=SINGLE)
    np.testing.assert_allclose(f.m_t[m], np.linalg.norm(j[:, :, 0], axis=-1), rtol=SINGLE)
    np.testing.assert_allclose(f.m_s[m], np.linalg.norm(j[:, :, 1], axis=-1), rtol=SINGLE)
    # Singular vectors, either sign, where the longest is told from the other.
    clear = s[:, 0] > 1.01 * s[:, 1]
    assert np.count_nonzero(clear) > 1000
    for ours, theirs in ((f.direction, u[:, :, 0]), (f.texel_direction, vt[:, 0])):
        cosines = np.abs(np.sum(ours[m] * theirs, axis=-1))
        np.testing.assert_allclose(cosines[clear], 1, rtol=1e-4)
        np.testing.assert_allclose(np.linalg.norm(ours[m], axis=-1), 1, rtol=SINGLE)
    assert (f.undersampled == (m & (np.nan_to_num(f.major) > 1))).all()
    assert f.undersampled.dtype == bool
    assert f.undersampled.any()
    assert not f.undersampled[m].all()
    for array in (f.major, f.minor, f.area, f.perspective, f.perspective_major, f.projection, f.m_s, f.m_t, f.depth):
        assert np.isnan(array[~m]).all()
        assert np.isfinite(array[m]).all()
    assert np.isnan(f.direction[~m]).all()
    assert np.isnan(f.jacobian[~m]).all()
    assert sum(f.counts().values()) == f.map.size


def test_perspective_is_that_of_the_halfway_surface():
    camera = ROBOTS.camera
    for f, p in ((of(p), p) for p in MAPS.values()):
        chosen = np.flatnonzero(f.measured)[::50]
        points = ROBOTS_SEEN.position.reshape(-1, 3)[chosen].astype(np.float64)
        normals = sl.aliasing.halfway_normals(points, camera, ROBOTS.light)
        at = sl.aliasing.footprint_at(points, normals, camera, ROBOTS.light, p, size=SIZE)
        assert at.major.dtype == np.float64
        assert (at.map == f.map.reshape(-1)[chosen]).mean() > 0.99
        same = at.map == f.map.reshape(-1)[chosen]
        flat = lambda a, same=same, chosen=chosen: a.reshape(-1)[chosen][same]  # noqa: E731
        # Pictures keep positions in float32.
        np.testing.assert_allclose(at.projection, 1, rtol=1e-9)
        np.testing.assert_allclose(at.major[same], flat(f.perspective_major), rtol=FROM_DETERMINANT[f.major.dtype])
        np.testing.assert_allclose(at.perspective_major, at.major, rtol=FROM_DETERMINANT[at.major.dtype])
        np.testing.assert_allclose(at.perspective, at.area, rtol=1e-9)
        np.testing.assert_allclose(at.m_s[same], flat(f.perspective_ts[..., 1]), rtol=1e-4)
        np.testing.assert_allclose(at.m_t[same], flat(f.perspective_ts[..., 0]), rtol=1e-4)
        np.testing.assert_allclose(at.depth[same], flat(f.depth), rtol=1e-4)


def test_twice_the_texels_are_half_as_long():
    one, two = of(MAPS["lispsm"], 256), of(MAPS["lispsm"], (512, 256))
    m = one.measured
    assert one.resolution == (256, 256)
    assert two.resolution == (512, 256)
    assert (one.map == two.map).all()
    np.testing.assert_array_equal(two.m_t[m] * 2, one.m_t[m])
    np.testing.assert_array_equal(two.m_s[m], one.m_s[m])
    np.testing.assert_allclose(two.area[m] * 2, one.area[m], rtol=SINGLE)
    np.testing.assert_allclose(two.summary().storage_factor, one.summary().storage_factor, rtol=SINGLE)


entries = st.floats(-1e3, 1e3).map(lambda x: x if abs(x) > 1e-3 else 0.0)


@settings(deadline=None)
@given(st.lists(st.tuples(entries, entries, entries, entries), min_size=1, max_size=30), st.data())
def test_any_jacobians(rows, data):
    j = np.array(rows).reshape(-1, 2, 2)
    regular = np.abs(np.linalg.det(j)) > 1e-3 * np.square(j).sum(axis=(1, 2)) + 1e-6
    if not regular.any():
        return
    j = j[regular]
    codes = data.draw(
        st.lists(st.sampled_from([0, 0, 0, 1, 2, NO_MAP, AVERTED, NOTHING]), min_size=len(j), max_size=len(j))
    )
    f = synthetic(j, codes, maps=3)
    m = f.measured
    np.testing.assert_allclose(f.perspective_major[m], f.major[m], rtol=FROM_DETERMINANT[f.major.dtype])
    # The direction is an eigenvector: J Jᵀ stretches it by the square of the extent.
    if m.any():
        stretched = np.einsum("nij,nkj,nk->ni", j[m], j[m], f.direction[m])
        np.testing.assert_allclose(np.linalg.norm(stretched, axis=-1), f.major[m] ** 2, rtol=1e-7)
        back = np.einsum("nij,nj->ni", j[m], f.texel_direction[m])
        np.testing.assert_allclose(np.linalg.norm(back, axis=-1), f.major[m], rtol=1e-7)
    s = f.summary(bands=data.draw(st.integers(1, 9)))
    assert s.measured == np.count_nonzero(m)
    assert s.histogram.pixels.sum() == s.measured
    assert sum(s.counts.values()) == s.pixels == len(j)
    if s.measured:
        assert s.bands.pixels.sum() == s.measured
        values = list(s.percentiles.values())
        assert values == sorted(values)
        assert values[-1] <= s.max
        assert s.mean <= s.rms * (1 + EXACT) <= s.max * (1 + 2 * EXACT)


def assert_same_bits(one, two):
    """Raises unless all arrays of two footprints are the same."""
    for name in ("jacobian", "major", "minor", "perspective_ts", "projection", "depth", "map"):
        ours, theirs = getattr(one, name), getattr(two, name)
        assert (ours.dtype, ours.shape) == (theirs.dtype, theirs.shape), name
        np.testing.assert_array_equal(ours, theirs, err_msg=name)
    assert (one.resolution, one.size, one.maps) == (two.resolution, two.size, two.maps)


def test_a_renderer_finds_the_same():
    for p in MAPS.values():
        assert_same_bits(of(p), RENDERER.footprint(ROBOTS, ROBOTS.camera, ROBOTS.light, p, size=SIZE))
        two = RENDERER.footprint(ROBOTS, ROBOTS.camera, ROBOTS.light, p, size=SIZE, resolution=(300, 200))
        assert_same_bits(of(p, (300, 200)), two)


@pytest.mark.parametrize("name", ["jacobian", "major", "minor", "perspective_ts", "projection", "depth", "map"])
def test_one_changed_number_is_seen(name):
    one, two = of(MAPS["lispsm"]), of(MAPS["lispsm"])
    assert_same_bits(one, two)
    array = getattr(two, name)
    at = np.flatnonzero(two.measured)[-1]
    array.reshape(two.map.size, -1)[at, -1] += 1
    with pytest.raises(AssertionError):
        assert_same_bits(one, two)


def test_somebodys_own_matrices():
    p = MAPS["lispsm"]
    ours = of(p)
    for theirs in (p.matrix, p.matrix.tolist(), p.matrix[None], 3.0 * p.matrix):
        f = of(theirs, 512)
        np.testing.assert_allclose(f.major, ours.major, rtol=SINGLE)
        assert (f.map == ours.map).all()
        assert f.resolution == (512, 512)
    # A texel of a map that is the image is a pixel.
    with pytest.warns(sl.errors.ShadowlabWarning, match="not a map of this light"):
        f = of(np.asarray(ROBOTS.camera.clip_from_world), SIZE)
    np.testing.assert_allclose(
        f.jacobian[f.measured], np.broadcast_to(np.eye(2), (*f.map[f.measured].shape, 2, 2)), atol=1e-4
    )
    # The first that holds a point.
    halves = np.stack([np.diag([2.0, 2, 1, 1]) @ p.matrix, p.matrix])
    f = of(halves, 512)
    assert f.maps == 2
    assert set(np.unique(f.map)) >= {0, 1, AVERTED}
    assert (f.measured == ours.measured).all()
    np.testing.assert_allclose(f.major[f.map == 0] * 2, ours.major[f.map == 0], rtol=SINGLE)
    np.testing.assert_allclose(f.major[f.map == 1], ours.major[f.map == 1], rtol=SINGLE)
    several = MAPS["z_partition"]
    f = of(sl.Parameterization.from_matrix(several.matrices, eye_depth=[q.eye_depth for q in several.partitions]), 512)
    assert (f.map == of(several).map).all()


POINT = [ROBOTS.camera.eye + 10 * np.asarray(ROBOTS.camera.forward)]


@pytest.mark.parametrize(
    "change",
    [
        {"points": [[1.0, 2.0]]},
        {"points": [1.0, 2.0, 3.0]},
        {"points": "here"},
        {"points": [[0, 0, np.nan]]},
        {"points": [[0, 0, np.inf]]},
        {"normals": [[0.0, 1, 0]] * 2},
        {"normals": [[0.0, 1]]},
        {"normals": [[0.0, np.nan, 0]]},
        {"normals": None},
        {"camera": "mine"},
        {"light": (0, -1, 0)},
        {"parameterization": np.eye(3)},
        {"parameterization": np.full((4, 4), np.nan)},
        {"parameterization": np.zeros((4, 4))},
        {"parameterization": np.empty((0, 4, 4))},
        {"parameterization": "lispsm"},
        {"size": 0},
        {"size": (64, 0)},
        {"size": (1, 2, 3)},
        {"size": -3},
        {"size": 2.5},
        {"size": "large"},
        {"resolution": 0},
        {"resolution": (0, 64)},
        {"resolution": "high"},
    ],
    ids=str,
)
def test_wrong_arguments_are_told(change):
    arguments = {
        "points": POINT, "normals": [[0.0, 1, 0]], "camera": ROBOTS.camera, "light": ROBOTS.light,
        "parameterization": MAPS["lispsm"], "size": 64,
    }  # fmt: skip
    assert sl.aliasing.footprint_at(**arguments).map == [0]
    with pytest.raises(ArgumentError):
        sl.aliasing.footprint_at(**{**arguments, **change})
    if change.keys() <= {"camera", "light", "parameterization", "resolution"}:
        image = {
            "gbuffer": ROBOTS_SEEN,
            **{k: v for k, v in arguments.items() if k not in ("points", "normals", "size")},
        }
        with pytest.raises(ArgumentError):
            sl.aliasing.footprint(**{**image, **change})


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.diag([1, 1, 0, 1.0]), "parameterization: expected matrices of full rank, got a singular one"),
        (np.full((4, 4), np.nan), "parameterization: expected finite numbers"),
        (np.eye(3), r"parameterization: expected .*shape \(4, 4\).*got shape \[3, 3\]"),
        (np.eye(3).tolist(), r"parameterization: expected .*shape \(4, 4\).*got shape \[3, 3\]"),
        (7, r"parameterization: expected a Parameterization, or a finite \(4, 4\) or \(K, 4, 4\) array, got int"),
    ],
    ids=["singular", "nan", "shape", "list", "number"],
)
def test_what_is_wrong_with_a_matrix_is_told(matrix, words):
    with pytest.raises(ArgumentError, match=words):
        sl.Renderer("cpu").shadow_map(ROBOTS, matrix, resolution=16)


def test_no_gbuffer():
    with pytest.raises(ArgumentError):
        sl.aliasing.footprint(np.zeros((4, 4, 3)), ROBOTS.camera, ROBOTS.light, MAPS["lispsm"])


def test_halfway_normals():
    points = np.array([[0.0, 0, 0], [3, 1, -2]])
    for light in (
        ROBOTS.light,
        sl.PointLight((1, 9, 2), range=50),
        sl.SpotLight((1, 9, 2), (0, -1, 0), cone_angle=1, range=50),
    ):
        normals = sl.aliasing.halfway_normals(points, ROBOTS.camera, light)
        at = np.asarray(light.point)
        ways = [np.asarray(ROBOTS.camera.eye) - points, at[:3] - at[3] * points]
        cosines = [np.sum(normals * w, axis=-1) / np.linalg.norm(w, axis=-1) for w in ways]
        np.testing.assert_allclose(cosines[0], cosines[1], rtol=EXACT)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, rtol=EXACT)
    eye = np.asarray(ROBOTS.camera.eye)
    behind = sl.PointLight(eye + 10, range=50)
    for bad in (np.zeros(3), np.zeros((2, 2)), [eye], [eye + 10], [eye + 5]):
        with pytest.raises(ArgumentError, match="points"):
            sl.aliasing.halfway_normals(bad, ROBOTS.camera, behind)


def test_points_that_look_nothing_up():
    camera = ROBOTS.camera
    eye, forward = np.asarray(camera.eye), np.asarray(camera.forward)
    points = [POINT[0], POINT[0], eye - forward, eye + 1e9 * forward, POINT[0]]
    normals = [[0, 1, 0], [0, -1, 0], [0, 1, 0], [0, 1, 0], [0, 0, 0]]
    f = sl.aliasing.footprint_at(points, normals, camera, ROBOTS.light, MAPS["lispsm"], size=64)
    assert list(f.map) == [0, AVERTED, NOTHING, NO_MAP, NOTHING]
    assert np.isnan(f.major[1:]).all()
    assert np.isfinite(f.major[0])
    assert repr(f).startswith("Footprint(64 x 64, maps=1, resolution=512 x 512, measured=1, median=")


def test_the_example():
    finder, module = doctest.DocTestFinder(recurse=False), importlib.import_module("shadowlab.aliasing.footprint")
    examples = [t for t in finder.find(module.footprint, "footprint", module=module) if t.examples]
    assert examples
    for example in examples:
        assert doctest.DocTestRunner().run(example).failed == 0


def test_an_array_that_is_one_number_is_a_side():
    assert sides_of("size", np.array(5)) == sides_of("size", np.int64(5)) == sides_of("size", 5) == (5, 5)
    assert sides_of("size", np.array([5, 6])) == (5, 6)


def test_a_matrix_of_another_light_is_warned_of_and_measured_all_the_same():
    import warnings

    other = sl.technique("uniform").parameterize(ROBOTS, ROBOTS.camera, sl.DirectionalLight((-1, -0.2, 0.4)))
    own = np.array(MAPS["lispsm"].matrix)
    seen = (ROBOTS_SEEN, ROBOTS.camera, ROBOTS.light)
    with pytest.warns(sl.errors.ShadowlabWarning, match="not a map of this light"):
        e = sl.aliasing.footprint(*seen, np.array(other.matrix))
    assert np.isfinite(e.major[e.measured]).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sl.aliasing.footprint(*seen, own)
        sl.compare(
            ROBOTS, ROBOTS.camera, ROBOTS.light, {"other": sl.Parameterization.from_matrix(other.matrix)},
            resolution=64, size=(64, 36), progress=False,
        ).footprint("other")  # fmt: skip
