"""Cameras of every kind: parallel rays, pictures beside the view axis, no far plane, extreme aspects and angles."""

from __future__ import annotations

import copy
import json
import math
import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, ShadowlabWarning
from shadowlab.reports.reproduce import camera_python
from shadowlab.reports.study_record import camera_record

F32 = float(np.finfo(np.float32).eps)
EYE, TARGET = (3.0, 6.0, 9.0), (0.2, 0.5, 0.0)


def room() -> sl.Scene:
    """A floor, a wall and three boxes that throw shadows on both."""
    quads = [
        [(-6, 0, -6), (6, 0, -6), (6, 0, 6), (-6, 0, 6)],
        [(-6, 0, -6), (6, 0, -6), (6, 5, -6), (-6, 5, -6)],
    ]
    for x, z, half, high in ((-2.0, -1.0, 0.8, 2.0), (1.5, 0.5, 0.6, 3.0), (0.0, 3.0, 0.4, 1.0)):
        (a, b), (c, d) = (x - half, x + half), (z - half, z + half)
        quads += [
            [(a, high, c), (b, high, c), (b, high, d), (a, high, d)],
            [(a, 0, d), (b, 0, d), (b, high, d), (a, high, d)],
            [(a, 0, c), (b, 0, c), (b, high, c), (a, high, c)],
            [(b, 0, c), (b, 0, d), (b, high, d), (b, high, c)],
            [(a, 0, c), (a, 0, d), (a, high, d), (a, high, c)],
        ]
    faces = [[4 * i + k for k in corner] for i in range(len(quads)) for corner in ((0, 1, 2), (0, 2, 3))]
    return sl.Scene.from_arrays(np.array(quads, np.float64).reshape(-1, 3), faces)


SCENE = room()
SUN = sl.DirectionalLight((-0.5, -1.0, -0.35))
LAMP = sl.SpotLight((-1.0, 9.0, 4.0), (0.1, -1.0, -0.4), cone_angle=1.4, range=40.0)
CAMERAS = {
    "perspective": sl.Camera.look_at(EYE, TARGET, near=0.5, far=40),
    "orthographic": sl.Camera.orthographic(EYE, TARGET, height=9, near=0.5, far=40),
    "orthographic, from among it": sl.Camera.orthographic((0, 1, 0), (-1, 0, -1.5), height=7, near=-20, far=20),
    "orthographic, shifted": sl.Camera.orthographic(EYE, TARGET, height=5, near=-5, far=40, shift=(0.6, -0.4)),
    "plan": sl.Camera.orthographic((0, 20, 0), (0, 0, 0), (0, 0, -1), height=14, aspect=1, near=0, far=30),
    "shifted": sl.Camera.look_at(EYE, TARGET, near=0.5, far=40, shift=(-0.5, 0.7)),
    "beside the axis": sl.Camera.look_at(EYE, (8.0, 0.5, 2.0), near=0.5, far=40, shift=(-1.4, 0.1)),
    "endless": sl.Camera.look_at(EYE, TARGET, near=0.5, far=math.inf),
    "endless, shifted": sl.Camera.look_at(EYE, TARGET, near=0.5, far=math.inf, shift=(0.3, 0.2)),
    "narrow": sl.Camera.look_at(EYE, TARGET, aspect=0.05, near=0.5, far=40),
    "broad": sl.Camera.look_at(EYE, TARGET, aspect=20, fov_y=0.2, near=0.5, far=40),
    "1 degree": sl.Camera.look_at((90, 180, 270), TARGET, fov_y=math.radians(1), near=100, far=500),
    "170 degrees": sl.Camera.look_at((0, 1.5, 4), TARGET, fov_y=math.radians(170), aspect=1, near=0.05, far=40),
}
NAMES = list(CAMERAS)
SAMPLED_SIZE = (97, 61)


def sized(camera: sl.Camera) -> tuple[int, int]:
    return SAMPLED_SIZE if 0.5 < camera.aspect < 3 else (40, 90) if camera.aspect < 1 else (150, 20)


@pytest.fixture(scope="module")
def cpu_renderer() -> sl.Renderer:
    return sl.Renderer("cpu")


@pytest.mark.parametrize("name", NAMES)
def test_matrices_rays_and_corners_say_the_same(name):
    camera = CAMERAS[name]
    size = (64, 48)
    pixels = np.array([(0.0, 0.0), (64.0, 0.0), (64.0, 48.0), (17.25, 40.5)])
    origins, directions = camera.rays(pixels, size)
    for depth in (camera.near, 0.5 * camera.near + 3.0, min(camera.far, 50.0)):
        p = origins + depth * directions
        np.testing.assert_allclose(camera.depth(p), depth, atol=1e-11)
        clip = np.column_stack([p, np.ones(4)]) @ camera.clip_from_world.T
        ndc = clip[:, :3] / clip[:, 3:]
        np.testing.assert_allclose(ndc[:, 0], pixels[:, 0] / 32 - 1, atol=1e-9)
        np.testing.assert_allclose(ndc[:, 1], 1 - pixels[:, 1] / 24, atol=1e-9)
        np.testing.assert_allclose(camera.corners(depth)[[2, 3, 1]], p[:3], atol=1e-9 * max(1, abs(depth)))
    ends = [camera.near] + ([camera.far] if math.isfinite(camera.far) else [])
    for depth, z in zip(ends, (0.0, 1.0), strict=False):
        clip = np.append(camera.corners(depth)[0], 1.0) @ camera.clip_from_world.T
        assert clip[2] / clip[3] == pytest.approx(z, abs=1e-9)
    if math.isinf(camera.far):
        clip = np.append(camera.corners(8.0)[1], 1.0) @ camera.clip_from_world.T
        assert clip[2] / clip[3] == pytest.approx(1 - camera.near / 8.0)


@pytest.mark.parametrize("backend", ["cpu", "gpu"])
@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_what_its_rays_meet(name, backend, request):
    """Positions, normals and depths of a G-buffer against rays that are cast one by one."""
    draw = request.getfixturevalue(f"{backend}_renderer")
    camera, size = CAMERAS[name], sized(CAMERAS[name])
    g = draw.gbuffer(SCENE, camera, size=size)
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    origins, directions = camera.rays(np.column_stack([x.ravel(), y.ravel()]), size)
    t, triangle, _ = sl.trace.first_hit(SCENE, origins + camera.near * directions, directions)
    depth = camera.near + t
    shows, met = g.triangle.ravel() >= 0, (triangle >= 0) & (depth < camera.far)
    # The centre of a pixel on an outline may be on either side.
    assert (shows == met).mean() > 0.99
    assert shows.mean() > 0.1, "the picture shows the scene"
    same = shows & (g.triangle.ravel() == triangle)
    assert same.sum() > 0.95 * shows.sum()
    step = 256 * F32 * (np.abs(np.asarray(SCENE.bounds)).max() + np.linalg.norm(camera.eye))
    places = g.position.reshape(-1, 3)[same]
    assert np.abs(places - (origins + depth[:, None] * directions)[same]).max() < step
    clip = np.column_stack([places, np.ones(len(places))]) @ camera.clip_from_world.T
    buffered = g.depth.ravel()[same]
    assert np.abs(buffered - clip[:, 2] / clip[:, 3]).max() < 2e-5
    assert ((buffered >= 0) & (buffered <= 1)).all()
    assert (g.depth.ravel()[~shows] == 1).all()
    facing = np.einsum("ni,ni->n", g.normal.reshape(-1, 3)[same], directions[same])
    assert (facing < 1e-6 * np.linalg.norm(directions[same], axis=1)).all()


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
@pytest.mark.parametrize("name", NAMES)
def test_masks_are_the_truth_but_for_edges(name, light, cpu_renderer):
    camera, size = CAMERAS[name], sized(CAMERAS[name])
    truth = sl.trace.shadow_mask(SCENE, camera, light, size=size)
    p = sl.technique("uniform").by_body().parameterize(SCENE, camera, light, resolution=2048)
    mask = cpu_renderer.shadow_mask(SCENE, camera, light, p, size=size, bias=sl.Bias(texels=1.0, slope=1.0))
    assert ((truth == -2) == np.isnan(mask)).mean() > 0.99
    decided = (truth >= 0) & ~np.isnan(mask)
    assert decided.mean() > 0.1
    assert (mask[decided] == (truth[decided] == 1)).mean() > 0.97


@pytest.mark.parametrize("name", NAMES)
def test_texels_have_the_size_that_differences_give(name, gpu_renderer, cpu_renderer):
    camera, size = CAMERAS[name], sized(CAMERAS[name])
    p = sl.technique("lispsm").by_body().parameterize(SCENE, camera, SUN, resolution=256)
    found = cpu_renderer.footprint(SCENE, camera, SUN, p, size=size)
    g = cpu_renderer.gbuffer(SCENE, camera, size=size)
    rows, columns = np.nonzero(found.map >= 0)
    assert len(rows) > 20
    chosen = np.random.default_rng(7).choice(len(rows), 20, replace=False)
    view = np.asarray(camera.clip_from_world)
    for row, column in zip(rows[chosen], columns[chosen], strict=True):
        point, normal = g.position[row, column], np.asarray(g.normal[row, column], np.float64)
        a = np.cross(normal, [0.36, 0.48, 0.8])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)

        def places(step, point=point):
            q = np.append(point + step, 1.0)
            clip = view @ q
            pixel = clip[:2] / clip[3] * [0.5 * size[0], -0.5 * size[1]]
            ndc, _ = p.partitions[0].project(q[None, :3])
            return pixel, ndc[0, :2] * [128, -128]

        h = 1e-4
        ends = [[places(sign * h * axis) for sign in (1, -1)] for axis in (a, b)]
        pixels, texels = (np.column_stack([e[0][k] - e[1][k] for e in ends]) for k in (0, 1))
        expected = pixels @ np.linalg.inv(texels)
        assert np.abs(found.jacobian[row, column] - expected).max() < 2e-3 * np.abs(expected).max()
    on_device = gpu_renderer.footprint(SCENE, camera, SUN, p, size=size)
    close = np.abs(found.depth - on_device.depth) < 1e-3 * np.abs(found.depth)
    both = (found.map >= 0) & (on_device.map >= 0) & close
    assert both.sum() > 0.9 * (found.map >= 0).sum()
    for field in ("major", "perspective", "projection", "depth"):
        one, other = (np.asarray(getattr(e, field))[both] for e in (found, on_device))
        assert np.percentile(np.abs(one - other) / np.abs(one), 99) < 1e-3, field


WARPS = ("psm", "tsm", "lispsm", "gmnpr", "glpr", "xpsm", "log", "log_psm")


@pytest.mark.parametrize("technique", WARPS)
def test_parallel_rays_have_no_perspective_to_warp_for(technique):
    camera = CAMERAS["orthographic, shifted"]
    view = sl.View(SCENE, camera, SUN, (64, 36))
    samples = view.samples()
    p = sl.technique(technique).by_body().parameterize(SCENE, camera, SUN, resolution=128, samples=samples)
    (note,) = [note for note in p.notes if note.kind == "no_warp"]
    assert note.details == ("parallel_rays",)
    assert "orthographic" in str(note)
    uniform = sl.technique("uniform").by_body().parameterize(SCENE, camera, SUN, resolution=128, samples=samples)
    corners = np.array(np.meshgrid(*np.asarray(SCENE.bounds).T)).reshape(3, -1).T
    np.testing.assert_allclose(
        p.partitions[0].project(corners)[0][:, :2], uniform.partitions[0].project(corners)[0][:, :2], atol=1e-9
    )


def test_splits_of_parallel_rays_are_even():
    camera = sl.Camera.orthographic((0, 5, 0), (1, 4, 0), height=9, near=-8, far=8)
    for splits in ("practical", "logarithmic", "uniform"):
        t = sl.technique("z_partition", count=4, splits=splits, range="camera", inner="uniform")
        p = t.by_body().parameterize(SCENE, camera, SUN, resolution=64)
        np.testing.assert_allclose([m.eye_depth for m in p.partitions], [(-8, -4), (-4, 0), (0, 4), (4, 8)], atol=1e-12)
        assert ("even_splits" in [note.kind for note in p.notes]) == (splits != "uniform")
    t = sl.technique("z_partition", distances=[-2.0, 3.0], range="camera", inner="uniform").by_body()
    ends = [m.eye_depth for m in t.parameterize(SCENE, camera, SUN, resolution=64).partitions]
    np.testing.assert_allclose(ends, [(-8, -2), (-2, 3), (3, 8)])


@pytest.mark.parametrize("technique", sorted(set(sl.techniques()["name"])))
def test_no_far_plane_is_a_far_plane_behind_the_scene(technique):
    endless = CAMERAS["endless, shifted"]
    bounded = endless.bounded(SCENE)
    assert bounded.far < 30
    assert bounded == endless.replace(far=bounded.far)
    made = []
    for camera in (endless, bounded):
        samples = sl.View(SCENE, camera, SUN, (64, 36)).samples()
        try:
            p = sl.technique(technique).parameterize(SCENE, camera, SUN, resolution=128, samples=samples)
        except sl.errors.UnsupportedError as error:
            made.append(str(error))
        else:
            made.append((p.matrices.tolist(), [m.eye_depth for m in p.partitions], [str(n) for n in p.notes]))
    assert made[0] == made[1]


def test_a_stable_map_without_a_far_plane_says_that_its_texels_change():
    p = sl.technique("uniform", stable=True).by_body().parameterize(SCENE, CAMERAS["endless"], SUN, resolution=64)
    assert [note.kind for note in p.notes] == ["end_moves"]


def test_a_camera_straight_down_chooses_another_up_and_says_so():
    with pytest.warns(ShadowlabWarning, match=r"up: .*straight down.*so up is \(0, 0, -1\)"):
        down = sl.Camera.look_at((0, 9, 0), (0, 0, 0))
    np.testing.assert_array_equal(down.up, [0, 0, -1])
    np.testing.assert_array_equal(down.right, [1, 0, 0])
    with pytest.warns(ShadowlabWarning, match="straight up"):
        above = sl.Camera.orthographic((0, 0, 0), (0, 1, 0), height=2)
    np.testing.assert_array_equal(above.up, [0, 0, 1])
    # It is what a camera comes to that tilts there.
    tilted = sl.Camera.look_at((0, 9, 0), (0, 0, -1e-6))
    np.testing.assert_allclose(tilted.up, down.up, atol=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        given = sl.Camera.look_at((0, 9, 0), (0, 0, 0), up=(0, 0, -1))
        assert given == down
        turned = given.replace(target=(0, 9, -5), up=(0, 1, 0))
    with pytest.warns(ShadowlabWarning, match="turned along its own up"):
        again = turned.replace(forward=(0, -1, 0))
    np.testing.assert_array_equal(again.up, [0, 0, -1])
    for parallel in ((0, 1, 0), (0, -3, 0)):
        with pytest.raises(ArgumentError, match=r"up: .*parallel.*leave it out"):
            sl.Camera.look_at((0, 9, 0), (0, 0, 0), up=parallel)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ShadowlabWarning):
            sl.Camera.look_at((0, 9, 0), (0, 0, 0))


@pytest.mark.parametrize("name", NAMES)
def test_cameras_travel_and_move(name):
    camera = CAMERAS[name]
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert copy.deepcopy(camera) == camera
    assert hash(pickle.loads(pickle.dumps(camera))) == hash(camera)
    assert len({hash(c) for c in CAMERAS.values()}) == len(CAMERAS)
    assert camera.replace() == camera
    back = sl.Camera.from_matrices(camera.view, camera.projection)
    for field in ("fov_y", "height", "aspect", "near", "far", "shift"):
        assert getattr(back, field) == pytest.approx(getattr(camera, field), rel=1e-9, abs=1e-9), field
    assert back.is_orthographic == camera.is_orthographic
    picture = sl.View(SCENE, camera, SUN, (32, 18))
    assert pickle.loads(pickle.dumps(picture.gbuffer("cpu"))) == picture.gbuffer("cpu")
    made = {}
    exec("import shadowlab as sl\n" + camera_python(camera), made)
    np.testing.assert_allclose(made["camera"].clip_from_world, camera.clip_from_world, rtol=1e-9, atol=1e-9)
    json.dumps(camera_record(camera), allow_nan=False)
    assert camera._repr_html_()
    assert ("height=" in repr(camera)) == camera.is_orthographic


def test_only_what_the_first_version_cannot_hold_is_of_the_second():
    def version(camera):
        return camera.__reduce__()[1][1]

    assert version(CAMERAS["perspective"]) == 1
    assert {version(CAMERAS[name]) for name in ("orthographic", "shifted", "endless")} == {2}


@pytest.mark.parametrize("name", NAMES)
def test_pictures_and_reports_take_every_camera(name, tmp_path):
    camera = CAMERAS[name]
    study = sl.compare(
        SCENE, camera, SUN, ["uniform", "lispsm", "z_partition"], resolution=128, size=sized(camera), renderer="cpu"
    )
    table = study.table
    assert np.isfinite(table["misclassified"]).all()
    study.save(tmp_path / "report")
    assert (tmp_path / "report").exists()


def test_the_command_line_makes_orthographic_and_shifted_cameras(tmp_path):
    for words in (["--ortho-height", "8"], ["--shift=0.3,-0.2"], ["--far", "inf"]):
        out = tmp_path / words[0].strip("-")[:5]
        run = [
            sys.executable,
            "-c",
            "import sys; from shadowlab.cli import main; sys.exit(main())",
            "compare",
            "@robots",
            "--technique",
            "uniform",
        ]
        run += ["--resolution", "64", "--size", "64x36", "--out", str(out), *words]
        done = subprocess.run(run, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
    both = [*run[:-2], "--ortho-height", "8", "--fov-deg", "50"]
    done = subprocess.run(both, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode != 0
    assert "ortho-height" in done.stderr


@pytest.mark.parametrize("aspect", [0.05, 0.3, 20.0])
def test_default_views_have_every_aspect(aspect):
    for view in sl.default_views(SCENE, aspect=aspect):
        assert view.camera.aspect == aspect
        assert (view.gbuffer("cpu").triangle >= 0).any()
