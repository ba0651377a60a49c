"""Diagnoses in either order: the same mistake has the same name, and the matrix that has it is named.

Each mistake is made by hand from a map: `own` is the matrix with the mistake, `good` the map.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.conventions.search import OPPOSITE

C = sl.Convention
EYES = [((6, 5, 12), (0, 1, 2)), ((0, 2, 0), (10, 1, 3)), ((-3, 20, 1), (0, 0, 0)), ((4, 3, 6), (0, 0.8, 0))]
BIAS = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])
LIGHTS = {
    "directional": sl.DirectionalLight((0.5, -0.8, -0.3)),
    "spot": sl.SpotLight((8, 25, 6), (-0.25, -1, -0.2), cone_angle=1.2, range=80.0),
}
# clip_from_world of other engines from ours: depths of [-1, 1], 1 at the near plane, y down.
PROJECTIONS = {
    "": np.eye(4),
    "z in [-1, 1]": np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1.0]]),
    "reversed z": np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1.0]]),
    "y down": np.diag([1.0, -1, 1, 1]),
}
CHANGES = [C(), C(vectors="row"), C(y="down"), C.opengl(), C.opengl_bias(), C.direct3d(), C.unity()]


@pytest.fixture(scope="module", params=itertools.product(range(len(EYES)), ("uniform", "lispsm"), LIGHTS), ids=str)
def view(request):
    """A scene, a camera and a good map."""
    eye, technique, light = request.param
    scene = sl.library.scene("robots")
    camera = sl.Camera.look_at(*EYES[eye], fov_y=0.9, aspect=4 / 3, near=0.1, far=100)
    return scene, camera, sl.technique(technique).parameterize(scene, camera, LIGHTS[light]).matrix


def named(own, good, words, **view):
    """Both diagnoses of a pair, which each have the words, about the right side."""
    made = []
    for side, pair in (("mine", (own, good)), ("theirs", (good, own))):
        found = sl.diagnose(*pair, **view)
        readings = found.differences[0].split(", or ")
        assert not found.same
        assert any(text.startswith(side) and words in text for text in readings), found
        made.append(found)
    return made


def spaces(camera):
    """Words for each space of the camera, and the matrix from the world to it."""
    made = {"view space": ("view matrix", np.asarray(camera.view))}
    for words, ndc in PROJECTIONS.items():
        clip = (f"NDC, {words})", f"clip_from_world ({words})") if words else ("(NDC)", "clip_from_world where")
        made[clip[0]] = (clip[1], ndc @ np.asarray(camera.clip_from_world))
    return made


def test_points_of_a_space_and_a_confused_inverse_have_names_from_both_sides(view):
    scene, camera, good = view
    for points, (matrix, space_from_world) in spaces(camera).items():
        named(good @ np.linalg.inv(space_from_world), good, points, camera=camera)
        for found in named(good @ space_from_world, good, matrix, camera=camera, scene=scene):
            assert "where its inverse belongs: the two are confused" in str(found)


@pytest.mark.parametrize("base", CHANGES, ids=str)
@pytest.mark.parametrize("light", LIGHTS)
def test_a_convention_beside_such_a_mistake_is_named_too(base, light):
    scene = sl.library.scene("robots")
    camera = sl.Camera.look_at(*EYES[0], fov_y=0.9, aspect=4 / 3, near=0.1, far=100)
    good = sl.technique("lispsm").parameterize(scene, camera, LIGHTS[light]).matrix
    for points, (matrix, space_from_world) in spaces(camera).items():
        own = base.from_ours(good @ np.linalg.inv(space_from_world))
        made = [*named(own, good, points, camera=camera)]
        made += named(base.from_ours(good @ space_from_world), good, matrix, camera=camera)
        # In a left-handed world a left-handed view space is as good a name, so it leaves other axes.
        assert base == C.unity() or [found.convention for found in made] == [base] * 4


def test_a_technique_s_map_is_never_the_one_with_the_mistake():
    scene = sl.library.scene("robots")
    camera = scene.camera
    p = sl.technique("lispsm").parameterize(scene, camera, LIGHTS["spot"])
    for space_from_world in (np.asarray(camera.view), np.linalg.inv(camera.view)):
        own = p.matrix @ space_from_world
        for side, pair in (("mine", (own, p)), ("theirs", (p, own))):
            found = sl.diagnose(*pair, camera=camera)
            assert found.side == side
            assert found.differences[0].startswith(f"{side} is ")
            assert ", or " not in found.differences[0]


def test_without_a_camera_no_space_is_named(view):
    _, camera, good = view
    for pair in itertools.permutations((good, good @ np.linalg.inv(camera.view))):
        assert "space" not in str(sl.diagnose(*pair))
        assert "confused" not in str(sl.diagnose(*pair))


def moved(x, y, z):
    made = np.eye(4)
    made[:3, 3] = x, y, z
    return made


MISTAKES = [
    (lambda m: np.linalg.inv(m), "is the inverse matrix: it takes the map to the world"),
    (lambda m: np.linalg.inv(m).T, "is the inverse matrix: it takes the map to the world"),
    (lambda m: BIAS @ BIAS @ C.opengl().from_ours(m), "a bias matrix applied twice to x and y"),
    (lambda m: BIAS @ BIAS @ m, "depths biased by 0.5 z + 0.5 twice"),
    (lambda m: np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.25, 0.75], [0, 0, 0, 1]]) @ m, "0.5 z + 0.5 twice"),
    (lambda m: BIAS @ m, "depths biased by 0.5 z + 0.5 though they are in [0, 1] without"),
    (lambda m: np.diag([0.5, 0.5, 1, 1]) @ m, "twice the extent, a radius taken for a diameter?"),
    (lambda m: np.diag([2, 2, 1, 1]) @ m, "half the extent, a diameter taken for a radius?"),
    (lambda m: C.of("vulkan:x=left,reversed_z=True").from_ours(m), OPPOSITE),
    (lambda m: C.of("opengl:x=left,reversed_z=True").from_ours(m), OPPOSITE),
    (lambda m: C.unity().from_ours(m @ np.diag([100, 100, 100, 1])), "a world in other units"),
    (lambda m: m @ np.diag([0.01, 0.01, 0.01, 1]), "a world in other units"),
]


@pytest.mark.parametrize(("wrong", "words"), MISTAKES)
@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
@pytest.mark.parametrize("with_camera", [False, True])
def test_common_mistakes_have_names_in_either_order(wrong, words, technique, with_camera):
    scene = sl.library.scene("robots")
    good = sl.technique(technique).parameterize(scene, scene.camera, scene.light).matrix
    for pair in itertools.permutations((wrong(good), good)):
        found = sl.diagnose(*pair, camera=scene.camera if with_camera else None)
        assert not found.same
        assert words in str(found)


def test_the_side_of_a_mistake_is_told():
    scene = sl.library.scene("robots")
    good = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light).matrix
    own = C.unity().from_ours(good @ np.diag([0.01, 0.01, 0.01, 1]))
    assert "a length of 1 in theirs is 0.01 in mine" in str(sl.diagnose(good, own))
    assert "a length of 1 in mine is 0.01 in theirs" in str(sl.diagnose(own, good))
    own = C.opengl().from_ours(good @ moved(3, -2, 5))
    assert "points of theirs are mine moved by (-3, 2, -5)" in str(sl.diagnose(good, own))
    assert "points of mine are theirs moved by (-3, 2, -5)" in str(sl.diagnose(own, good))
    for base in (C(), C.direct3d(), C.unity()):
        found = named(
            base.from_ours(good @ moved(*scene.camera.eye)), good, "relative to the camera", camera=scene.camera
        )
        assert [f.side for f in found] == ["mine", "theirs"]
        assert [f.convention for f in found] == [base, base]
    maps = sl.technique("z_partition").parameterize(scene, scene.camera, scene.light).matrices
    own = C.unity().from_ours(maps[[0, 2, 3, 1]])
    assert sl.diagnose(maps, own).differences[0] == "maps in another order: mine are theirs number 0, 3, 1, 2"
    assert sl.diagnose(own, maps).differences[0] == "maps in another order: theirs are mine number 0, 3, 1, 2"


@pytest.mark.parametrize("name", C.PRESETS)
def test_a_convention_of_mine_is_told_as_such(name):
    scene = sl.library.scene("robots")
    good = sl.technique("lispsm").parameterize(scene, scene.camera, scene.light).matrix
    found = sl.diagnose(C.of(name).from_ours(good), good, camera=scene.camera)
    assert found.same
    assert found.texels <= 1e-3
    if name not in ("webgpu", "metal", "vulkan", "reversed_z", "direct3d"):  # these are their own inverses
        assert (found.side, found.convention) == ("mine", C.of(name))
        assert all(text.startswith("mine: ") for text in found.differences)
    if C.of(name).xy_range == (-1, 1):
        found = sl.diagnose(C.of(name).from_ours(moved(0.01, 0, 0) @ good), good, camera=scene.camera)
        assert not found.same
        assert "another crop: x shifted by" in str(found)


FAR = {
    "far": (1.0, np.array([1e6, 2e5, -1e6])),
    "tiny": (1e-5, np.zeros(3)),
    "huge": (1e6, np.zeros(3)),
}


@pytest.mark.parametrize("name", FAR)
@pytest.mark.parametrize("technique", ["uniform", "lispsm"])
@pytest.mark.parametrize("down", [False, True], ids=["across", "down"])
def test_place_and_scale_and_a_view_straight_down_change_nothing(name, technique, down):
    scale, place = FAR[name]
    vertices = np.array([(-9, 0, -9), (9, 0, -9), (9, 0, 9), (-9, 0, 9), (-1, 0, 0), (1, 0, 0), (0, 3, 1)], float)
    faces = np.array([(0, 2, 1), (0, 3, 2), (4, 5, 6)])
    scene = sl.Scene.from_arrays(vertices * scale + place, faces)
    eye, target = (np.array(p, float) * scale + place for p in (((2, 12, 3), (2, 0, 3)) if down else EYES[0]))
    up = (0, 0, -1) if down else (0, 1, 0)
    camera = sl.Camera.look_at(eye, target, up=up, fov_y=0.9, near=0.1 * scale, far=100 * scale)
    good = sl.technique(technique).parameterize(scene, camera, LIGHTS["directional"]).matrix
    named(good @ np.linalg.inv(camera.view), good, "view space", camera=camera)
    named(good @ camera.view, good, "view matrix", camera=camera)
    named(good @ np.linalg.inv(camera.clip_from_world), good, "clip space (NDC)", camera=camera)
    assert sl.diagnose(good, good, camera=camera).differences == ()


def test_good_pairs_have_no_mistake():
    rng = np.random.default_rng(5)
    scene = sl.library.scene("courtyard")
    low, high = (np.asarray(corner) for corner in scene.bounds)
    words = ("is for points", "confused", "inverse", "another order", "units", "origin", "biased", "twice", "opposite")
    for _ in range(12):
        eye = low + (high - low) * rng.uniform(0.1, 0.9, 3) + (0, 3, 0)
        camera = sl.Camera.look_at(eye, low + (high - low) * rng.uniform(0.2, 0.8, 3), near=0.1, far=200)
        light = sl.DirectionalLight(rng.standard_normal(3) * (1, 0.2, 1) - (0, 1, 0))
        other = sl.DirectionalLight(np.asarray(light.direction) + rng.normal(0, 0.2, 3))
        good, another = (sl.technique("lispsm").parameterize(scene, camera, x).matrix for x in (light, other))
        crop = moved(*rng.uniform(-0.3, 0.3, 2), 0) @ np.diag([*rng.uniform(0.5, 1.5, 2), 1, 1]) @ good
        for pair in (*itertools.permutations((good, another)), *itertools.permutations((good, crop))):
            found = sl.diagnose(*pair, camera=camera, scene=scene)
            assert not found.same
            assert not any(word in str(found) for word in words), found
