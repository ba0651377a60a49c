"""Scenes that move: what stays is the same bit for bit, what moves takes its shadow along."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import ArgumentError
from shadowlab.reports.reproduce import python_snippet
from shadowlab.scene.source import UNKNOWN_SCENE, Source

SIZE = (96, 54)


@pytest.fixture(scope="module")
def robots():
    return sl.library.scene("robots")


def square(side):
    corners = side / 2 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], float)
    return _core.Mesh(corners, [[0, 2, 1], [0, 3, 2]])


def shifted(way):
    matrix = np.eye(4)
    matrix[:3, 3] = way
    return matrix


@pytest.fixture(scope="module")
def table():
    """A square above a floor, both seen from above, a hundred pixels per unit."""
    scene = sl.Scene([square(8.0), square(1.0)], [0, 1], np.array([np.eye(4), shifted((0, 1, 0))]))
    camera = sl.Camera.orthographic((0, 5, 0), (0, 0, 0), up=(0, 0, -1), height=4.0, aspect=1.0, near=1, far=10)
    return scene, camera


def answers(scene, camera, light, draw, technique="uniform"):
    p = sl.technique(technique).parameterize(scene, camera, light, resolution=256)
    view = sl.View(scene, camera, light, size=SIZE)
    g = draw.gbuffer(scene, camera, size=SIZE)
    return [
        p.matrices,
        draw.shadow_map(scene, p),
        draw.shadow_mask(scene, camera, light, p, size=SIZE),
        g.depth, g.position_relative, g.normal, g.triangle, g.instance,
        np.asarray(sl.trace.shadow_mask(scene, camera, light, size=view.size)),
    ]  # fmt: skip


def same(first, second):
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("name", ["robots", "forest"])
def test_moving_by_the_identity_changes_nothing(renderer, name):
    scene = sl.library.scene(name, trees=200) if name == "forest" else sl.library.scene(name)
    before = answers(scene, scene.camera, scene.light, renderer)
    everything = np.arange(scene.instance_count)
    for index in (everything, everything[::3], everything[:0]):
        moved = scene.with_transforms(index, scene.transforms[index])
        assert moved == scene
        assert moved.content_hash == scene.content_hash
        same(answers(moved, scene.camera, scene.light, renderer), before)


def test_a_moved_scene_is_the_scene_made_anew(robots, renderer):
    draw, rng = renderer, np.random.default_rng(5)
    scene = robots
    answers(scene, robots.camera, robots.light, draw)  # so that hierarchies and buffers are there to be shared
    for count in (1, 7, robots.instance_count):
        index = rng.permutation(robots.instance_count)[:count]
        matrices = scene.transforms[index]
        matrices[:, :3, 3] += rng.normal(0, 0.3, (count, 3))
        scene = scene.with_transforms(index, matrices)
        anew = sl.Scene(robots.meshes, robots.mesh_index, scene.transforms)
        assert scene == anew
        assert scene != robots
        np.testing.assert_array_equal(scene.bounds, anew.bounds)
        same(*(answers(one, robots.camera, robots.light, draw, "lispsm") for one in (scene, anew)))
    back = scene.with_transforms(np.arange(robots.instance_count), robots.transforms)
    assert back.content_hash == robots.content_hash
    same(*(answers(one, robots.camera, robots.light, draw) for one in (back, robots)))


def test_a_shadow_moves_by_the_way_of_its_caster(table, renderer):
    # A square over a floor under a slanted light: its shadow is the square moved along the light, whatever casts it.
    scene, camera = table
    draw, light, size = renderer, sl.DirectionalLight((0.5, -1, 0)), (400, 400)
    p = sl.technique("uniform").parameterize(scene, camera, light, resolution=2048)

    def shadow(of):
        on_floor = np.asarray(draw.gbuffer(of, camera, size=size).instance) == 0
        mask = np.asarray(draw.shadow_mask(of, camera, light, p, size=size)) < 0.5
        truth = np.asarray(sl.trace.shadow_mask(of, camera, light, size=size)) == sl.trace.Truth.SHADOW
        return mask & on_floor, truth & on_floor

    for way, pixels in (((0.25, 0, 0), (0, 25)), ((0, 0, -0.5), (-50, 0)), ((-0.5, 0, 0.25), (25, -50))):
        moved = scene.with_transforms([1], [shifted(np.add((0, 1, 0), way))])
        for before, after in zip(shadow(scene), shadow(moved), strict=True):
            assert before.sum() > 4000
            np.testing.assert_array_equal(np.roll(before, pixels, (0, 1)), after)
    # Lowered by a half and moved by a quarter along the light, it shades the same.
    lowered = shadow(scene.with_transforms([1], [shifted((0.25, 0.5, 0))]))
    uncovered = np.s_[:, 275:]  # elsewhere the square hides the floor
    for before, after in zip(shadow(scene), lowered, strict=True):
        assert before[uncovered].sum() == 25 * 100
        np.testing.assert_array_equal(before[uncovered], after[uncovered])


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(0, 110), unique=True, max_size=20), st.floats(-3, 3), st.integers(0, 2))
def test_there_and_back_is_the_same_scene(index, way, axis):
    scene = sl.library.scene("robots")
    index = [i for i in index if i < scene.instance_count]
    matrices = scene.transforms[index]
    matrices[:, axis, 3] += way
    moved = scene.with_transforms(index, matrices)
    np.testing.assert_array_equal(moved.transforms[index], matrices)
    assert (moved == scene) == bool((matrices == scene.transforms[index]).all())
    back = moved.with_transforms(index[::-1], scene.transforms[index[::-1]])
    assert back == scene
    assert hash(back) == hash(scene)


def test_moved_scenes_are_values(robots):
    step = robots.transforms[[4]]
    step[0, 1, 3] += 0.5
    moved = robots.with_transforms([4], step)
    assert type(moved) is type(robots)
    assert moved.camera == robots.camera
    assert moved.light == robots.light
    for again in (pickle.loads(pickle.dumps(moved)), copy.copy(moved), copy.deepcopy(moved)):
        assert again == moved
        assert again.recipe == moved.recipe
        assert again.source == moved.source
    assert robots == sl.library.scene("robots")  # as it was
    assert _core.same_instances(robots, moved)
    assert all(a is b or a == b for a, b in zip(robots.meshes, moved.meshes, strict=True))


def test_the_recipe_makes_the_moved_scene_again_or_says_nothing(robots):
    step = robots.transforms[[4, 2]]
    step[:, 0, 3] += 1 / 3
    moved = robots.with_transforms([4, 2], step)
    assert eval(moved.recipe, {"sl": sl}) == moved
    assert Source.of_scene(moved).python == f"scene = {moved.recipe}"
    # The command line cannot say it.
    assert Source.of_scene(moved).arguments == ()
    assert Source.of_scene(robots).arguments == ("@robots",)
    everything = np.arange(robots.instance_count)
    for many in (
        robots.with_transforms(everything, robots.transforms),
        sl.Scene(robots.meshes, robots.mesh_index, robots.transforms).with_transforms([0], robots.transforms[:1]),
    ):
        assert many.recipe == ""
        assert Source.of_scene(many).python == UNKNOWN_SCENE
    for _ in range(40):  # of a long path it does not grow for ever
        moved = moved.with_transforms([4], step[:1])
    assert moved.recipe == ""


def test_a_report_of_a_moved_scene_can_be_run_again(robots):
    step = robots.transforms[[4]]
    step[0, 0, 3] += 0.25
    moved = robots.with_transforms([4], step)
    how = {"resolution": 64, "size": (32, 18), "renderer": "cpu", "progress": False}
    study = sl.compare(moved, robots.camera, robots.light, ["uniform"], **how)
    text = python_snippet(study, study.runs)
    scope = {}
    exec(text, scope)
    assert scope["scene"] == moved
    assert scope["study"].table["misclassified"].tolist() == study.table["misclassified"].tolist()


@pytest.mark.parametrize(
    ("indices", "matrices", "words"),
    [
        (
            [111_111],
            np.eye(4)[None],
            r"indices\[0\]: expected the index of one of the \d+ instances, from 0, got 111111",
        ),
        ([0, -1], [np.eye(4)] * 2, r"indices\[1\]: expected the index"),
        ([3, 1, 3], [np.eye(4)] * 3, r"indices\[2\]: expected each instance once, got 3 a second time"),
        ([0, 1], np.eye(4)[None], "matrices: expected one matrix for each of the 2 indices, got 1"),
        ([], np.eye(4)[None], "matrices: expected one matrix for each of the 0 indices, got 1"),
        ([0], np.eye(4), "matrices: expected"),
        ([0], np.eye(3)[None], "matrices: expected"),
        ([0.5], np.eye(4)[None], "indices: expected"),
        ("all", np.eye(4)[None], "indices: expected"),
        (None, None, "indices: expected"),
        ([0], [np.diag([1, 1, 1, 2.0])], r"matrices\[0\]: expected a last row of 0, 0, 0, 1"),
        ([0], [np.vstack([np.eye(4)[:3], [0, 0, 0.1, 1]])], r"matrices\[0\]: expected a last row"),
        ([0, 2], [np.eye(4), np.diag([np.nan, 1, 1, 1])], r"matrices\[1\]: expected 16 finite numbers"),
        ([0], [np.diag([np.inf, 1, 1, 1])], r"matrices\[0\]: expected 16 finite numbers"),
        ([0], [np.diag([1e200, 1, 1, 1])], "scene: expected coordinates"),
        ([0], np.eye(4, dtype=complex)[None], "matrices: expected"),
    ],
)
def test_what_cannot_be_placed_is_an_error(robots, indices, matrices, words):
    with pytest.raises(ArgumentError, match=words):
        robots.with_transforms(indices, matrices)


@pytest.mark.parametrize("nothing", [([], []), ((), ()), (np.zeros(0, int), np.zeros((0, 4, 4)))])
def test_a_move_of_nothing_is_the_same_scene(robots, nothing):
    assert robots.with_transforms(*nothing) == robots


def test_what_a_scene_takes_it_moves_to(robots):
    # Mirrored, sheared and flattened: as `Scene` takes them.
    flat, mirrored = robots.transforms[[5]] @ np.diag([1, 0, 1, 1.0]), robots.transforms[[6]] @ np.diag([-1, 1, 1, 1.0])
    moved = robots.with_transforms([5, 6], np.concatenate([flat, mirrored]))
    anew = sl.Scene(robots.meshes, robots.mesh_index, moved.transforms)
    truths = [sl.trace.shadow_mask(of, robots.camera, robots.light, size=SIZE) for of in (moved, anew)]
    np.testing.assert_array_equal(*truths)
    back = moved.with_transforms([5, 6], robots.transforms[[5, 6]])
    assert back == robots


def test_hierarchies_are_shared_in_any_order_of_tracing(robots):
    # Memory of a moved scene is that of one hierarchy; whoever is traced first builds it.
    steps = [robots.transforms[[9]] + shifted((0.1 * i, 0, 0)) - np.eye(4) for i in range(4)]
    scenes = [robots.with_transforms([9], step) for step in steps]
    order = [2, 0, 3, 1]
    truths = {i: sl.trace.shadow_mask(scenes[i], robots.camera, robots.light, size=SIZE) for i in order}
    for i, scene in enumerate(scenes):
        anew = sl.Scene(robots.meshes, robots.mesh_index, scene.transforms)
        np.testing.assert_array_equal(truths[i], sl.trace.shadow_mask(anew, robots.camera, robots.light, size=SIZE))
