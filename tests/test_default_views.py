"""Views of places: somebody stands in a town, a hall or a terrain, and sees something."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import trimesh

import shadowlab as sl
from shadowlab.scene.columns import Surfaces, floors_of
from shadowlab.scene.place import EYE_M, place_in
from shadowlab.scene.sunlight import shadow_score
from shadowlab.text.checks import VIEWS

SIZE = (96, 54)
# Vertices are kept in single precision, and numbers of a view have four digits or more.
ROUNDING = 2e-3


def town(turn=0.0, scale=1.0, place=(0.0, 0.0, 0.0), flip=False):
    """Houses along streets on a ground of 240 x 120, 6 to 15 high."""
    random = np.random.default_rng(4)
    parts = [trimesh.creation.box((240, 1, 120), transform=trimesh.transformations.translation_matrix((0, -0.5, 0)))]
    for x in range(-110, 111, 20):
        for z in range(-50, 51, 20):
            high = random.uniform(6, 15)
            at = trimesh.transformations.translation_matrix((x, high / 2, z))
            parts.append(trimesh.creation.box((12, high, 12), transform=at))
    mesh = trimesh.util.concatenate(parts)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, (0, 1, 0)))
    faces = mesh.faces[:, ::-1] if flip else mesh.faces
    return sl.Scene.from_arrays(scale * mesh.vertices + np.asarray(place), faces)


def hills(width=6000.0):
    """A terrain without anything on it, a tenth as high as wide."""
    x, z = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60), indexing="ij")
    y = 0.05 * (np.sin(9 * x) * np.cos(7 * z) + 1)
    corner = np.arange(59)[:, None] * 60 + np.arange(59)
    faces = np.concatenate([[corner, corner + 1, corner + 60], [corner + 60, corner + 1, corner + 61]], axis=0)
    faces = faces.reshape(2, 3, -1).transpose(0, 2, 1).reshape(-1, 3)
    return sl.Scene.from_arrays(width * np.stack([x, y, z], axis=-1).reshape(-1, 3), faces)


def hall():
    """A closed hall of 30 x 6 x 12 with pillars; windows along one long side let the light in."""
    parts = []
    for size, at in (
        ((30, 0.4, 12), (0, -0.2, 0)), ((30, 0.4, 12), (0, 6.2, 0)), ((30, 6, 0.4), (0, 3, -6)),
        ((0.4, 6, 12), (-15, 3, 0)), ((0.4, 6, 12), (15, 3, 0)),
        ((30, 1, 0.4), (0, 0.5, 6)), ((30, 1, 0.4), (0, 5.5, 6)),
        *(((1.5, 6, 0.4), (x, 3, 6)) for x in range(-14, 15, 4)),
        *(((0.5, 6, 0.5), (x, 3, 2)) for x in range(-12, 13, 6)),
    ):  # fmt: skip
        parts.append(trimesh.creation.box(size, transform=trimesh.transformations.translation_matrix(at)))
    return sl.Scene.from_trimesh(trimesh.util.concatenate(parts))


def level_angle(camera, light):
    """The angle between the view and the light, seen from above, degrees."""
    a, b = (np.asarray(v)[[0, 2]] / np.linalg.norm(np.asarray(v)[[0, 2]]) for v in (camera.forward, light.direction))
    return np.degrees(np.arccos(np.clip(a @ b, -1, 1)))


def shadows(scene, camera, light):
    """Shares of a picture: that shows a surface, of it lit, and of what faces the light in shadow."""
    truth = sl.trace.shadow_mask(scene, camera, light, size=SIZE)
    normals = np.asarray(sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE).normal)
    seen, facing = truth >= 0, normals @ light.direction < 0
    return seen.mean(), (truth == 1).sum() / seen.sum(), (truth == 0)[seen & facing].mean()


def test_the_three_views_are_views():
    scene = town()
    views = sl.default_views(scene)
    assert [view.label for view in views] == list(VIEWS)
    assert {view.size for view in views} == {(1360, 765)}
    for view in views:
        assert (view.camera, view.light) == sl.default_view(scene, view=view.label)
    along, above, against = views
    assert against.camera == along.camera
    assert above.camera.eye[1] > np.asarray(scene.bounds)[1, 1]
    assert level_angle(against.camera, against.light) >= 130
    assert 55 <= level_angle(along.camera, along.light) <= 110


@pytest.mark.parametrize("turn", [0.0, 0.5, np.pi / 2])
def test_somebody_stands_in_a_town_and_looks_along_it(turn):
    scene = town(turn)
    camera, light = sl.default_view(scene)
    assert camera.eye[1] == pytest.approx(EYE_M, abs=1e-3)
    long_side = np.array([np.cos(turn), 0, -np.sin(turn)])
    # The towards-the-middle line candidates turn by up to a quarter of the width over the length.
    assert abs(np.asarray(camera.forward) @ long_side) > 0.95
    seen, lit, shadowed = shadows(scene, camera, light)
    assert seen > 0.4
    assert lit > 0.3
    assert 0.08 < shadowed < 0.6
    # Nothing right before the eye, and more than the next house in the picture.
    g = sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE)
    depth = camera.depth(np.asarray(g.position)[np.asarray(g.triangle) >= 0])
    assert np.percentile(depth, 2) > EYE_M
    assert np.percentile(depth, 98) > 8 * np.percentile(depth, 2)


def test_faces_turned_inside_out_change_nothing():
    for view in VIEWS:
        assert sl.default_view(town(flip=True), view=view) == sl.default_view(town(), view=view)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (455_000.0, 30.0, -5_900_000.0)])
def test_without_metres_eyes_are_at_a_share_of_what_stands_there(place):
    """A model of a town, and the same where a country has its town: seen alike at every scale and place."""
    reference, light = sl.default_view(town(scale=0.01))
    for scale in (1e-5, 0.1, 1e3, 1e6):
        camera, other = sl.default_view(town(scale=scale, place=scale * 1e-2 * np.asarray(place)))
        eye = (np.asarray(camera.eye) / scale - 1e-2 * np.asarray(place)) / 100
        if scale != 0.1:
            np.testing.assert_allclose(eye, reference.eye, atol=ROUNDING)
            np.testing.assert_allclose(camera.forward, reference.forward, atol=ROUNDING)
            np.testing.assert_allclose(other.direction, light.direction, atol=ROUNDING)
        assert camera.eye[1] / scale - 1e-2 * place[1] == pytest.approx(0.1 * 14.5, rel=0.1)


def test_a_terrain_is_seen_by_somebody_who_stands_on_it():
    scene = hills()
    camera, light = sl.default_view(scene)
    below = sl.trace.first_hit(scene, [camera.eye], [[0.0, -1.0, 0.0]])[0][0]
    assert below == pytest.approx(EYE_M, rel=1e-3)
    seen, _, shadowed = shadows(scene, camera, light)
    assert seen > 0.4
    assert shadowed > 0.03
    # A model of it has no metres: a fiftieth of its relief.
    small = hills(1.0)
    camera, _ = sl.default_view(small)
    below = sl.trace.first_hit(small, [camera.eye], [[0.0, -1.0, 0.0]])[0][0]
    assert below == pytest.approx(0.02 * 0.1, rel=0.05)


def test_a_hall_is_seen_from_inside_with_light_through_its_windows():
    scene = hall()
    for view in VIEWS:
        camera, light = sl.default_view(scene, view=view)
        eye = np.asarray(camera.eye)
        assert (np.abs(eye[[0, 2]]) < (14.8, 5.8)).all()
        assert 0 < eye[1] < 6
        _, lit, _ = shadows(scene, camera, light)
        assert lit > 0.01, view
        if view == "along":
            assert eye[1] == pytest.approx(EYE_M, abs=1e-3)


def test_a_thing_is_seen_whole_on_its_ground_however_it_came():
    ball = sl.Scene.from_trimesh(trimesh.creation.icosphere(3, 1.0))
    whole = ball.with_ground()
    for view in VIEWS:
        (camera, light), (other, sun) = sl.default_view(whole, focus=ball, view=view), sl.default_view(whole, view=view)
        np.testing.assert_allclose(camera.eye, other.eye, atol=0.05)  # the lowest cap of the ball counts as ground
        np.testing.assert_allclose(light.direction, sun.direction, atol=ROUNDING)
        clip = (
            np.append(ball.to_arrays()[0], np.ones((ball.to_arrays()[0].shape[0], 1)), axis=1) @ other.clip_from_world.T
        )
        assert (np.abs(clip[:, :2]) <= clip[:, 3:]).all()
        seen, _, shadowed = shadows(whole, camera, light)
        assert seen > 0.5
        assert 0.01 < shadowed < 0.6
    camera, _ = sl.default_view(whole)
    assert 0 < camera.eye[1] < 2.5  # from a little above, not from a tower


def test_what_is_a_place_and_what_is_a_thing():
    assert place_in(Surfaces(town()))[0] is not None
    assert place_in(Surfaces(hall()))[0] is not None
    assert place_in(Surfaces(hills()))[0].level is None
    for thing in (trimesh.creation.icosphere(2), trimesh.creation.box((1, 3, 1)), trimesh.creation.box((9, 1, 9))):
        assert place_in(Surfaces(sl.Scene.from_trimesh(thing)))[0] is None


def test_floors_are_found_under_roofs_and_on_hills():
    scene = hall()
    columns = floors_of(Surfaces(scene), np.asarray(scene.bounds))
    inside = columns.known & np.isfinite(columns.room) & (columns.room > 5)
    assert inside.mean() > 0.8
    np.testing.assert_allclose(columns.floor[inside], 0, atol=1e-5)
    np.testing.assert_allclose(columns.room[inside], 6, atol=1e-5)


def test_a_score_of_shadows_wants_some_and_light():
    facing = np.ones(100, bool)

    def score(shadow, nothing=0):
        truth = np.ones(100, np.int8)
        truth[:shadow] = 0
        truth[100 - nothing :] = -2
        return shadow_score(truth, facing)

    assert score(30) == 1.0
    assert score(0) == score(100) == score(0, nothing=100) == 0.0
    assert 0 < score(5) < 1
    assert 0 < score(90) < score(70) < 1


def test_the_names_of_views_are_checked():
    with pytest.raises(sl.errors.UnknownNameError, match=r"along.*above.*against"):
        sl.default_view(hall(), view="below")
    with pytest.raises(sl.errors.ArgumentError, match="scene"):
        sl.default_views("hall.glb")


# Files of the shared scenes, their up axis, and whether somebody stands in them.
SHARED = {
    "kenney_city.glb": ("y", True), "graveyard.glb": ("y", True), "delft_city.ply": ("z", True),
    "ruudskogen_forest.ply": ("y", True), "st_helens_terrain.ply": ("z", True), "country_kitchen.glb": ("y", True),
    "bunny_10k.ply": ("y", False), "dragon_20k.ply": ("y", False), "teapot_6k.ply": ("y", False),
    "lucy_100k.ply": ("z", False), "armadillo_86k.ply": ("y", False), "buddha_100k.ply": ("y", False),
}  # fmt: skip


@pytest.mark.parametrize("name", SHARED)
def test_shared_scenes_show_shadows_in_every_view(shared_scenes, name):
    up, is_place = SHARED[name]
    part = sl.load_scene(shared_scenes / name, up=up)
    scene = part if is_place else part.with_ground()
    assert (place_in(Surfaces(part))[0] is not None) == is_place
    for view in sl.default_views(scene, focus=part):
        seen, lit, shadowed = shadows(scene, view.camera, view.light)
        assert seen > 0.2, view.label
        assert lit > 0.02, view.label
        assert shadowed > 0.02, view.label


@pytest.mark.parametrize("size", [0.0, 1e-200, 1e-12])
def test_a_point_over_a_floor_has_views(size):
    """What stands on the floor is too small for a picture, so the picture is of the floor."""
    floor = [[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]]
    thing = np.array([[0, 0.3, 0], [size, 0.3, 0], [0, 0.3 + size, 0]])
    scene = sl.Scene.from_arrays([*floor, *thing], [[0, 2, 1], [0, 3, 2], [4, 5, 6]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for view in sl.default_views(scene):
            assert 0 < view.camera.near < view.camera.far
            assert (view.camera.depth(np.array(floor)) > 0).all()
