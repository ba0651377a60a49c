"""Along a path: snapped maps do not drift, maps that stand do not flip, and what moves is measured as it moves."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError
from shadowlab.experiments.frame_pair import RANDOM_DRIFT_MEAN, RANDOM_DRIFT_RMS, drift_of, seen_by

# Rounding of texel coordinates of a few hundred, at positions rounded to float32 once for both frames.
NO_DRIFT = 1e-9


def path(scene, steps=4, turn=0.004, way=0.03):
    c = scene.camera
    eyes = [np.asarray(c.eye) + way * i * np.array([1.0, 0.1, -0.7]) for i in range(steps)]
    return [
        sl.Camera.look_at(
            eye, eye + np.asarray(c.forward) + turn * i * np.asarray(c.right),
            fov_y=c.fov_y, aspect=c.aspect, near=c.near, far=c.far,
        )
        for i, eye in enumerate(eyes)
    ]  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return sl.library.scene("courtyard")


@pytest.fixture(scope="module")
def walked(scene):
    techniques = ["uniform", "uniform:stable=true", "lispsm", "z_partition:count=3,stable=true", "z_partition:count=3"]
    return sl.aliasing.temporal(scene, path(scene), scene.light, techniques, resolution=512, progress=False)


def test_snapped_maps_do_not_drift_and_no_shadow_flips(walked):
    rows = walked.summary.set_index("technique")
    for label in ("uniform:stable=true", "z_partition:count=3,stable=true"):
        assert rows.loc[label, "drift_max"] < NO_DRIFT
        assert rows.loc[label, "scale"] == pytest.approx(1.0, abs=1e-9)
    assert rows.loc["uniform:stable=true", "flip_share"] == 0
    # Of splits a receiver may change its map.
    assert rows.loc["z_partition:count=3,stable=true", "flip_share"] < 1e-3


def test_maps_fitted_anew_drift_like_a_lattice_thrown_down_at_random(walked):
    rows = walked.summary.set_index("technique")
    for label in ("uniform", "lispsm", "z_partition:count=3"):
        assert 0.5 * RANDOM_DRIFT_MEAN < rows.loc[label, "drift_mean"] < 1.5 * RANDOM_DRIFT_MEAN
        assert rows.loc[label, "flip_share"] > 3e-3
    rng = np.random.default_rng(1)
    found = drift_of(rng.uniform(0, 100, (400_000, 2)), rng.uniform(0, 100, (400_000, 2)))
    assert found["drift_mean"] == pytest.approx(RANDOM_DRIFT_MEAN, rel=3e-3)
    assert found["drift_rms"] == pytest.approx(RANDOM_DRIFT_RMS, rel=3e-3)
    assert found["drift_max"] <= np.sqrt(0.5)


def test_a_lattice_that_is_moved_by_a_known_way_drifts_by_it(scene):
    cameras = path(scene, 3, way=0.0, turn=0.0)
    p = sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=256)

    class Moved:
        """A map that moves by a quarter of a texel to the right and by a whole one down in every frame."""

        name, settings = "moved", {}

        def __init__(self):
            self.frame = -1

        def parameterize(self, scene, camera, light, *, resolution):
            self.frame += 1
            move = np.eye(4)
            move[:2, 3] = np.array([0.25, -1.0]) * (self.frame % 2) * 2 / resolution
            return sl.Parameterization.from_matrix(move @ p.matrix, resolution=resolution)

    found = sl.aliasing.temporal(scene, cameras, scene.light, {"moved": Moved()}, resolution=256, progress=False)
    for column in ("drift_mean", "drift_rms", "drift_max"):
        np.testing.assert_allclose(found.table[column].astype(float), 0.25, atol=1e-9)
    np.testing.assert_allclose(found.table["scale"].astype(float), 1.0, atol=1e-9)


def test_a_camera_that_stands_still_changes_nothing(scene):
    found = sl.aliasing.temporal(
        scene,
        [scene.camera] * 3,
        scene.light,
        ["uniform", "lispsm:near=optimal", "log"],
        resolution=256,
        progress=False,
    )
    assert (found.table["drift_max"] == 0).all()
    assert (found.table["flips"] == 0).all()
    assert (found.table["judged"] > 1000).all()
    assert (found.table["scale"] == 1).all()


def test_under_a_moving_light_only_what_stays_is_judged(scene):
    lights = [sl.DirectionalLight(np.asarray(scene.light.direction) + 0.05 * i * np.array([1, 0, 0])) for i in range(3)]
    cameras = [scene.camera] * 3
    found = sl.aliasing.temporal(scene, cameras, lights, ["uniform"], resolution=512, progress=False)
    still = sl.aliasing.temporal(scene, cameras, scene.light, ["uniform"], resolution=512, progress=False)
    assert (found.table["judged"] < still.table["judged"]).all()
    assert (found.table["judged"] > 0.5 * still.table["judged"]).all()
    # Most of what changes is the truth's: few of those judged flip.
    assert (found.table["flip_share"] < 0.1).all()


def test_flips_are_those_of_the_masks_of_both_frames(scene):
    cameras = path(scene, 2)
    size = (128, 72)
    found = sl.aliasing.temporal(scene, cameras, scene.light, ["uniform"], resolution=256, size=size, progress=False)
    renderer = sl.Renderer("cpu")
    g = renderer.gbuffer(scene, cameras[0], size=size)
    masks, which = [], []
    for camera in cameras:
        p = sl.technique("uniform").parameterize(scene, camera, scene.light, resolution=256)
        maps = renderer.shadow_map(scene, p)
        masks.append(sl.aliasing.look_up(maps, g, camera, scene.light, p))
        which.append(sl.aliasing.texel_coordinates(g, camera, scene.light, p)[1])
    both = (which[0] >= 0) & (which[1] >= 0) & seen_by(cameras[1], g.position) & (np.asarray(g.triangle) >= 0)
    row = found.table.iloc[0]
    assert row["judged"] == np.count_nonzero(both)
    assert row["flips"] == np.count_nonzero((masks[0] != masks[1]) & both) > 0


def test_what_a_technique_cannot_do_is_told_in_its_rows(scene):
    spot = sl.SpotLight((0, 20, 0), (0, -1, 0), cone_angle=1.0, range=60)
    found = sl.aliasing.temporal(scene, path(scene, 3), spot, ["uniform", "psm"], resolution=64, progress=False)
    failed = found.table[found.table["technique"] == "psm"]
    assert failed["failure"].str.contains("spot").all()
    assert (found.table[found.table["technique"] == "uniform"]["failure"] == "").all()
    assert "spot" in found._repr_html_()


def test_bad_input_is_told(scene):
    with pytest.raises(ArgumentError, match="cameras"):
        sl.aliasing.temporal(scene, [scene.camera], scene.light)
    with pytest.raises(ArgumentError, match="cameras: expected at least two"):
        sl.aliasing.temporal(scene, scene.camera, scene.light)
    with pytest.raises(ArgumentError, match="cameras: expected at least two"):
        sl.aliasing.temporal([scene] * 2, [scene.camera], scene.light)
    with pytest.raises(ArgumentError, match="scene: expected at least two"):
        sl.aliasing.temporal([scene], scene.camera, scene.light)
    with pytest.raises(ArgumentError, match="scene: expected one scene, or 3, one per frame as of cameras, got 2"):
        sl.aliasing.temporal([scene] * 2, path(scene, 3), scene.light)
    with pytest.raises(ArgumentError, match="light: expected one light, or 2, one per frame as of scene, got 3"):
        sl.aliasing.temporal([scene] * 2, scene.camera, [scene.light] * 3)
    with pytest.raises(ArgumentError, match=r"scene\[1\]: expected the meshes and instances of scene\[0\]"):
        sl.aliasing.temporal([scene, sl.library.scene("robots")], scene.camera, scene.light)
    with pytest.raises(ArgumentError, match="scene: expected a Scene, got int"):
        sl.aliasing.temporal([scene, 3], scene.camera, scene.light)
    with pytest.raises(ArgumentError, match="scene: expected a Scene, got int"):
        sl.aliasing.temporal(3, path(scene, 2), scene.light)
    with pytest.raises(ArgumentError, match="give a list of its values"):
        sl.aliasing.temporal(scene, dict(enumerate(path(scene, 2))), scene.light)
    with pytest.raises(ArgumentError, match="camera: expected a Camera"):
        sl.aliasing.temporal(scene, [1, 2], scene.light)
    with pytest.raises(ArgumentError, match="one per frame as of cameras"):
        sl.aliasing.temporal(scene, path(scene, 3), [scene.light] * 2)
    with pytest.raises(ArgumentError, match="resolution"):
        sl.aliasing.temporal(scene, path(scene, 2), scene.light, resolution=0)
    with pytest.raises(UnknownNameError):
        sl.aliasing.temporal(scene, path(scene, 2), scene.light, ["uniformly"])


def test_receivers_that_a_map_gives_up_are_lost_and_flip(scene):
    p = sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=512)
    small = sl.Parameterization.from_matrix(np.diag([4.0, 4.0, 1, 1]) @ np.array(p.matrix), resolution=512)

    class Shrinks:
        """Covers the view in the first frame, and a part of it in the second."""

        name, settings, frame = "shrinks", {}, -1

        def parameterize(self, scene, camera, light, *, resolution):
            self.frame += 1
            return p if self.frame == 0 else small

    found = sl.aliasing.temporal(
        scene, [scene.camera] * 2, scene.light, {"s": Shrinks()}, resolution=512, progress=False
    )
    row = found.table.iloc[0]
    assert row["lost"] > 0.5
    assert row["switched"] == 0
    # Lit where they are in no map: what was in shadow flips.
    assert row["flips"] > 100


def test_each_frame_is_drawn_once(scene):
    class Counting:
        """A renderer that counts its maps."""

        def __init__(self):
            self.renderer, self.maps = sl.Renderer("cpu"), 0

        def __getattr__(self, name):
            return getattr(self.renderer, name)

        def shadow_map(self, *args, **kwargs):
            self.maps += 1
            return self.renderer.shadow_map(*args, **kwargs)

    counting = Counting()
    sl.aliasing.temporal(
        scene, path(scene, 5), scene.light, ["uniform", "lispsm"], resolution=64, renderer=counting, progress=False
    )
    assert counting.maps == 2 * 5
