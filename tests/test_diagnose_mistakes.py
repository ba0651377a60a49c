"""Differences of shadow matrices that are no convention: other crops and warps, other lights, common mistakes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import cli
from shadowlab.conventions.search import OPPOSITE

C = sl.Convention
TECHNIQUES = ("uniform", "lispsm", "tsm", "psm", "gmnpr", "xpsm", "z_partition")
CONVENTION_WORDS = ("axes", "z in [", "reversed", "x points", "y points", "transposed", "bias", "tile", "direction")
BIAS = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])


@pytest.fixture(scope="module", params=("uniform", "lispsm"))
def case(request):
    scene = sl.library.scene("robots")
    return scene, sl.technique(request.param).parameterize(scene, scene.camera, scene.light).matrix


def moved(x, y, z):
    made = np.eye(4)
    made[:3, 3] = x, y, z
    return made


@pytest.mark.parametrize("name", ["robots", "courtyard", "dueling"])
@pytest.mark.parametrize("with_camera", [False, True])
def test_maps_of_one_light_differ_by_no_convention(name, with_camera):
    scene = sl.library.scene(name)
    made = [sl.technique(t).parameterize(scene, scene.camera, scene.light).matrices[0] for t in TECHNIQUES]
    for mine, theirs in itertools.combinations(made, 2):
        found = sl.diagnose(mine, theirs, camera=scene.camera if with_camera else None)
        assert not found.same
        assert found.convention == C()
        assert not any(word in str(found) for word in CONVENTION_WORDS), found
        assert "another crop: " in str(found) or "another warp or crop of the same light" in str(found)


def test_cascades_are_crops_of_each_other_and_their_order_is_told():
    scene = sl.library.scene("robots")
    maps = sl.technique("z_partition:stable=True").parameterize(scene, scene.camera, scene.light).matrices
    for i, j in itertools.permutations(range(len(maps)), 2):
        found = sl.diagnose(maps[i], maps[j])
        assert not found.same
        assert found.differences[0].startswith("another crop: x scaled by"), found
        assert not any(word in str(found) for word in CONVENTION_WORDS), found
    found = sl.diagnose(maps, C.direct3d().from_ours(maps[[0, 2, 1, 3]]))
    assert not found.same
    assert found.differences[0] == "maps in another order: mine are theirs number 0, 2, 1, 3"
    assert found.convention == C.direct3d()


def test_a_crop_below_half_the_size_is_no_tile(case):
    _, m = case
    for crop in (moved(-0.3, 0.2, 0) @ np.diag([0.3, 0.4, 1, 1]), moved(0.4, 0.4, 0) @ np.diag([0.25, 0.25, 1, 1])):
        found = sl.diagnose(m, crop @ m)
        assert not found.same
        assert "another crop: x scaled by" in str(found)
        tile = tuple(np.append(0.5 + 0.5 * (crop[:2, 3] - np.diag(crop)[:2]), np.diag(crop)[:2]))
        assert sl.diagnose(m, crop @ m, tile=tile).same, "a tile that is named is one"


def test_a_tile_may_have_a_border_of_whole_texels(case):
    _, m = case
    whole = 1024 + 2 * 4
    tile = ((whole + 4) / (2 * whole), 4 / (2 * whole), 1024 / (2 * whole), 1024 / (2 * whole))
    assert sl.diagnose(m, C.of("opengl_bias").changed(tile=tile).from_ours(m)).same
    off = (tile[0] + 0.3 / (2 * whole), *tile[1:])
    assert not sl.diagnose(m, C.of("opengl_bias").changed(tile=off).from_ours(m)).same


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda m: np.diag([0.5, 0.5, 1, 1]) @ m, "twice the extent, a radius taken for a diameter?"),
        (lambda m: np.diag([2, 2, 1, 1]) @ m, "half the extent, a diameter taken for a radius?"),
        (lambda m: BIAS @ BIAS @ C.opengl().from_ours(m), "a bias matrix applied twice to x and y"),
        (lambda m: BIAS @ BIAS @ m, "depths biased by 0.5 z + 0.5 twice"),
        (lambda m: BIAS @ m, "depths biased by 0.5 z + 0.5 though they are in [0, 1] without"),
        (np.linalg.inv, "the inverse matrix: it takes the map to the world"),
        (lambda m: np.linalg.inv(m).T, "the inverse matrix: it takes the map to the world; transposed"),
        (lambda m: m @ np.diag([0.01, 0.01, 0.01, 1]), "a length of 1 in theirs is 0.01 in mine"),
        (lambda m: C.unity().from_ours(m @ np.diag([100, 100, 100, 1])), "a length of 1 in theirs is 100 in mine"),
        (lambda m: C.of("vulkan:x=left,reversed_z=True").from_ours(m), OPPOSITE),
    ],
)
@pytest.mark.parametrize("with_camera", [False, True])
def test_common_mistakes_are_named(case, wrong, words, with_camera):
    scene, m = case
    found = sl.diagnose(m, wrong(m), camera=scene.camera if with_camera else None)
    assert not found.same
    assert words in str(found)


@pytest.mark.parametrize("base", ["webgpu", "opengl", "direct3d", "vulkan"])
def test_points_of_view_space_and_points_relative_to_the_camera_are_told(case, base):
    scene, m = case
    world_from_view = np.linalg.inv(scene.camera.view)
    for theirs, words in (
        (m @ world_from_view, "the camera's view space"),
        (m @ world_from_view @ np.diag([1, 1, -1, 1]), "a left-handed view space"),
        (m @ moved(*scene.camera.eye), "for points relative to the camera"),
    ):
        found = sl.diagnose(m, C.of(base).from_ours(theirs), camera=scene.camera)
        assert not found.same
        assert words in found.differences[0], found
        assert found.convention == C.of(base)


def test_another_origin_of_a_warped_map_is_told():
    scene = sl.library.scene("robots")
    m = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light).matrix
    found = sl.diagnose(m, m @ moved(3, -2, 5))
    assert found.differences == ("a world about another origin: points of theirs are mine moved by (-3, 2, -5)",)


@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
@pytest.mark.parametrize("base", ["webgpu", "opengl"])
def test_an_opposite_light_is_told_first(technique, base):
    scene = sl.library.scene("robots")
    back = sl.DirectionalLight(-np.asarray(scene.light.direction))
    mine, theirs = (sl.technique(technique).parameterize(scene, scene.camera, x) for x in (scene.light, back))
    found = sl.diagnose(mine, theirs.to(base))
    assert not found.same
    assert found.differences[0] == OPPOSITE


def test_a_convention_is_told_by_the_nearest_preset():
    for name in C.PRESETS:
        assert str(C.of(name)) == ("webgpu" if name == "metal" else name)
    assert str(C.of("unity").changed(y="down")) == "unity:y=down"


def test_the_command_takes_a_view(tmp_path, capsys):
    scene = sl.library.scene("robots")
    m = sl.technique("uniform").parameterize(scene, scene.camera, scene.light).matrix
    np.save(tmp_path / "mine.npy", m)
    np.save(tmp_path / "theirs.npy", m @ moved(*scene.camera.eye))
    files = [str(tmp_path / "mine.npy"), str(tmp_path / "theirs.npy")]
    assert cli.main(["diagnose", *files]) == 1
    assert "relative to the camera" not in capsys.readouterr().out
    assert cli.main(["diagnose", *files, "@robots"]) == 1
    assert "relative to the camera" in capsys.readouterr().out
