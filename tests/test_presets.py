"""Presets: the engines' formulas with numbers worked out beside their sources, and the maps made from them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.techniques import presets as engines
from shadowlab.techniques.presets import ReceiversBody

NAMES = ["filament", "ogre-1.12", "openscenegraph", "bevy", "three.js", "godot"]
# A body from depth 2 to 50 under a light at 30 degrees to the view.
BODY = ReceiversBody(near=2.0, far=50.0, camera_near=0.5, camera_far=200.0, y_min=0.8, extent=60.0, sine=0.5)


@pytest.fixture(scope="module")
def view():
    scene = sl.library.scene("courtyard")
    return scene, scene.camera, scene.light


def test_the_table_tells_every_preset_with_its_source():
    table = sl.presets()
    assert list(table["name"]) == NAMES
    assert (table.map(len) > 10).drop(columns="name").all().all()
    for name in NAMES:
        assert sl.preset(name).name == name
    with pytest.raises(sl.errors.UnknownNameError, match=r"three\.js"):
        sl.preset("unreal")


def test_filament_has_the_larger_of_its_two_distances():
    # ShadowMap.cpp: dzn = 0.5, dzf = 100; z0 = 2, z1 = 2 + 60 / 2 = 32; vz0 = max(2, 1, 2), vz1 = min(50, 100, 32).
    assert engines.filament_near(BODY) == pytest.approx((2.0 + math.sqrt(2.0 * 32.0)) / 0.5)
    # A far virtual near plane: dzn = 30 of zf - zn = 48 leaves 2 - 3 * 30 / 48 = 0.125, and nopt1 = 240 wins.
    assert engines.filament_near(BODY, near_hint=30.5) == pytest.approx(30.0 / 0.125)
    # From two thirds of the depth range on, and below a sine of 0.02, the map is uniform.
    assert engines.filament_near(BODY, near_hint=32.5) == math.inf
    assert engines.filament_near(ReceiversBody(2.0, 50.0, 0.5, 200.0, 0.8, 60.0, 0.019)) == math.inf


def test_ogre_is_weaker_where_light_and_view_run_together():
    # cos 30 degrees = 0.866 is below the threshold: the tweak is 1.
    assert engines.ogre_near(BODY) == pytest.approx((2.0 + math.sqrt(0.5 * 200.0)) * 0.1)
    along = ReceiversBody(2.0, 50.0, 0.5, 200.0, 0.8, 60.0, math.sqrt(1.0 - 0.95**2))
    assert engines.ogre_near(along) == pytest.approx((2.0 + 10.0) * 0.1 * 11.0)


def test_openscenegraph_divides_by_the_sine_twice_and_stands_behind_the_eye():
    # z_n = 4, z_f = 34, n = (4 + sqrt(136)) / 0.5; the body begins 0.8 beyond the eye, the reference n - 2 behind.
    assert engines.openscenegraph_near(BODY) == pytest.approx((4.0 + math.sqrt(136.0)) / 0.5 - 2.0 + 0.8)


def test_split_depths_of_the_engines():
    # cascade.rs: base = (150 / 10)^(1/3) = 2.46621.
    assert engines.bevy_bounds() == pytest.approx([10.0, 24.662121, 60.822020, 150.0])
    assert engines.bevy_bounds(count=1) == [150.0]
    assert engines.godot_distances(0.05, 100.0) == pytest.approx([10.045, 20.04, 50.025])
    # CSM.js with near 1, far 1000: uniform 334, 667; logarithmic 10, 100; half way between, in shares of far.
    assert engines.three_breaks(1.0, 1000.0) == pytest.approx([0.172, 0.3835, 1.0])
    # CSMFrustum.js cuts at these shares of the way from near to far: 1 + 999 * 0.172.
    assert engines.three_distances(1.0, 1000.0) == pytest.approx([172.828, 384.1165])


# Near, far, and by hand: breaks of the modes uniform and logarithmic, and the depths of the practical one.
THREE_BY_HAND = [
    # 50 * 2^(1/3) = 62.99605, 50 * 2^(2/3) = 79.37005; practical 64.83136 and 81.35169 of 100; 50 + 50 * 0.6483136.
    (50.0, 100.0, (2 / 3, 5 / 6), (0.6299605, 0.7937005), (82.415679, 90.675846)),
    # 0.1 * 10^(4/3) = 2.154435, 0.1 * 10^(8/3) = 46.415888; 333.4, 666.7; practical 167.777217, 356.557944 of 1000.
    (0.1, 1000.0, (0.3334, 0.6667), (0.002154435, 0.046415888), (167.8604396, 356.6222882)),
    # 2 * 8^(1/3) = 4, 2 * 8^(2/3) = 8; 20/3, 34/3; practical 16/3, 29/3 of 16: 2 + 14/3 and 2 + 14 * 29/48.
    (2.0, 16.0, (5 / 12, 17 / 24), (0.25, 0.5), (20 / 3, 2 + 14 * 29 / 48)),
]


@pytest.mark.parametrize(("near", "far", "uniform", "logarithmic", "depths"), THREE_BY_HAND)
def test_three_js_cuts_the_frustum_at_its_breaks(view, near, far, uniform, logarithmic, depths):
    scene, _, light = view
    assert engines.three_breaks(near, far, share=0.0) == pytest.approx([*uniform, 1.0], rel=1e-6)
    assert engines.three_breaks(near, far, share=1.0) == pytest.approx([*logarithmic, 1.0], rel=1e-6)
    low, high = scene.bounds
    middle = 0.5 * (np.asarray(low) + np.asarray(high))
    # From outside, so that every range of depths holds a part of the scene.
    eye = middle + np.array([0.0, 0.2, 1.0]) * (near + 0.5 * (far - near))
    seen = sl.Camera.look_at(eye, middle, near=near, far=far)
    made = sl.preset("three.js").parameterize(scene, seen, light, resolution=64)
    settings = sl.preset("three.js").technique(scene, seen, light).settings
    assert list(settings["distances"]) == pytest.approx(list(depths), rel=1e-6)
    ends = [part.eye_depth for part in made.partitions]
    assert [end for _, end in ends] == pytest.approx([*depths, far], rel=1e-6)
    assert [begin for begin, _ in ends] == pytest.approx([near, *depths], rel=1e-6)


def test_three_js_ends_at_its_largest_depth(view):
    scene, camera, light = view
    seen = camera.replace(near=1.0, far=1e6)
    made = sl.preset("three.js").parameterize(scene, seen, light, resolution=64)
    assert made.partitions[-1].eye_depth[1] == pytest.approx(1e5)
    # 1 + 99999 * (33334 + 1e5 ** (1 / 3)) / 2e5, with 1e5 ** (1 / 3) = 46.4158883.
    assert made.partitions[0].eye_depth[1] == pytest.approx(16691.041042, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_a_technique(name, view):
    scene, camera, light = view
    made = sl.preset(name)
    p = made.parameterize(scene, camera, light, resolution=256)
    again = made.technique(scene, camera, light)
    assert np.isfinite(p.matrices).all()
    if name in ("filament", "ogre-1.12", "openscenegraph"):
        body = engines.receivers_body(scene, camera, light)
        near = {"filament": engines.filament_near, "ogre-1.12": engines.ogre_near}.get(
            name, engines.openscenegraph_near
        )
        assert again.name == "lispsm"
        assert p.values["warp_distance"] == pytest.approx(near(body), rel=1e-12)
    else:
        depths = [part.eye_depth[1] for part in p.partitions]
        assert again.name == "z_partition"
        assert depths == sorted(depths)
        assert len(depths) == {"bevy": 4, "three.js": 3, "godot": 4}[name]
        near, far = camera.near, camera.far
        first = {
            "bevy": 10.0,
            "godot": near + 0.1 * (min(far, 100.0) - near),
            "three.js": near
            + (far - near) * (0.5 * near * (far / near) ** (1 / 3) + 0.5 * (near + (far - near) / 3)) / far,
        }
        assert depths[0] == pytest.approx(first[name])


def test_presets_are_compared_by_their_texts_and_refuse_lamps(view):
    scene, camera, light = view
    study = sl.compare(
        scene, camera, light, ["uniform", "preset:filament", "preset:godot"], resolution=128, size=(64, 36),
        renderer="cpu", progress=False,
    )  # fmt: skip
    assert list(study.table["technique"]) == ["uniform", "preset:filament", "preset:godot"]
    assert (study.table["failure"] == "").all()
    lamp = sl.SpotLight((0, 9, 0), (0, -1, 0.1), cone_angle=1.0, range=40.0)
    with pytest.raises(sl.errors.UnsupportedError, match="directional"):
        sl.preset("godot").parameterize(scene, camera, lamp)


def test_cascades_end_where_the_engine_ends_them(view):
    scene, camera, light = view

    def seen(near, far):
        return sl.Camera.look_at(camera.eye, camera.eye + camera.forward, up=camera.up, near=near, far=far)

    # Bevy's cascades do not depend on the camera's planes, Godot's end at the nearer of the far plane and 100.
    ends = [part.eye_depth[1] for part in sl.preset("bevy").parameterize(scene, seen(0.5, 30.0), light).partitions]
    assert ends == pytest.approx(engines.bevy_bounds())
    assert sl.preset("godot").parameterize(scene, seen(0.5, 30.0), light).partitions[-1].eye_depth[1] == 30.0
    assert sl.preset("godot").parameterize(scene, seen(0.5, 300.0), light).partitions[-1].eye_depth[1] == 100.0
    for name in ("bevy", "godot"):
        with pytest.raises(sl.errors.UnsupportedError, match="up to a depth of"):
            sl.preset(name).parameterize(scene, seen(160.0, 400.0), light)


def test_light_along_the_view_is_uniform(view):
    scene, camera, _ = view
    p = sl.preset("filament").parameterize(scene, camera, sl.DirectionalLight(camera.forward), resolution=128)
    assert p.technique == "uniform"


def test_what_a_study_of_a_preset_says_to_run_again_runs(tmp_path):
    from shadowlab.reports.reproduce import command_line, python_snippet

    scene = sl.library.scene("robots")
    study = sl.compare(
        scene, scene.camera, scene.light, ["preset:filament"], resolution=64, size=(64, 36), progress=False
    )
    again: dict[str, object] = {}
    exec(python_snippet(study, study.runs).replace("print(study)", ""), again)
    assert again["study"].table["misclassified"].tolist() == study.table["misclassified"].tolist()
    assert "--technique preset:filament" in command_line(study, study.runs)
