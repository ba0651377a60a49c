"""Errors over the angle between light and view: printed ratios, made-up crossovers, rows that are those of a study."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import shadowlab as sl
from shadowlab.experiments.light_angles import LightAngles, light_at_angle, over_light_angle
from shadowlab.experiments.light_angles_of_frustum import frustum_over_light_angle


def square_view(far):
    """The view of the printed table."""
    return sl.Camera.look_at((0, 0, 0), (0, 0, -1), up=(0, 1, 0), fov_y=np.pi / 3, aspect=1.0, near=1, far=far)


def tilted():
    """A camera without symmetry."""
    return sl.Camera.look_at((3, -2, 5), (1, 4, 2), up=(0.2, 0.1, 1), fov_y=0.9, aspect=1.6, near=0.5, far=40)


@pytest.mark.parametrize("camera", [square_view(10), tilted()])
@pytest.mark.parametrize("azimuth", [0, 30, 90, 200, -45])
@pytest.mark.parametrize("angle", [0, 7, 90, 133, 180])
def test_the_light_has_the_angle_and_comes_from_the_azimuth(camera, angle, azimuth):
    d = np.asarray(light_at_angle(camera, angle, azimuth_deg=azimuth).direction)
    assert np.degrees(np.arctan2(np.linalg.norm(np.cross(d, camera.forward)), d @ camera.forward)) == pytest.approx(
        angle
    )
    if 0 < angle < 180:
        across = np.degrees(np.arctan2(-d @ camera.right, -d @ camera.up))
        assert (across - azimuth + 180) % 360 - 180 == pytest.approx(0, abs=1e-9)


# Angle, azimuth, far over near, the published LiSPSM over uniform, shear included, and half a unit of its last digit.
PRINTED = [
    (90, 0, 1000, 0.00115, 5e-6),
    (45, 0, 1000, 0.00457, 5e-6),
    (30, 0, 1000, 0.0476, 5e-5),
    (25, 0, 1000, 1.22, 5e-3),
    (10, 0, 1000, 12.2, 5e-2),
    (30, 45, 1000, 0.296, 5e-4),
    (10, 45, 1000, 2.49, 5e-3),
    (20, 0, 100, 1.29, 5e-3),
]


@pytest.mark.parametrize(("angle", "azimuth", "far", "ratio", "half_digit"), PRINTED)
def test_printed_ratios(angle, azimuth, far, ratio, half_digit):
    found = frustum_over_light_angle(square_view(far), [angle], azimuth_deg=azimuth, steps=1)
    assert abs(found.relative("storage_factor_sheared")["lispsm"].iloc[0] - ratio) <= half_digit


def test_closed_forms_of_light_from_overhead():
    splits = {f"z{k}": f"z_partition:count={k},splits=logarithmic,range=camera" for k in (2, 4)}
    techniques = {"uniform": "uniform", "lispsm": "lispsm:near=basic", **splits}
    table = frustum_over_light_angle(square_view(100), [90], techniques).table.set_index("technique")
    width = 2 * np.tan(np.pi / 6)
    for name, maps, side in (("uniform", 1, 100), ("z2", 2, 10), ("z4", 4, 100**0.25)):
        assert table.maps[name] == maps
        assert table.storage_factor[name] == pytest.approx(maps * side * (side - 1) / width, rel=1e-6)
    assert table.storage_factor["lispsm"] == pytest.approx(99 / width, rel=1e-6)
    assert table.storage_factor_sheared["lispsm"] > table.storage_factor["lispsm"]
    # Neither the image's size nor the map's matters to a ratio of texels to pixels.
    other = frustum_over_light_angle(square_view(100), [90], techniques, resolution=300, size=77).table
    assert other.storage_factor.to_numpy() == pytest.approx(table.storage_factor.to_numpy(), rel=1e-6)


def made_up(values, angles=(90, 60, 30, 10)):
    """A table of one technique with these values over a baseline of 1."""
    rows = [{"technique": "uniform", "angle_deg": a, "texel_p95": 2.0} for a in angles]
    rows += [{"technique": "t", "angle_deg": a, "texel_p95": 2.0 * v} for a, v in zip(angles, values, strict=True)]
    return LightAngles(pd.DataFrame(rows))


@pytest.mark.parametrize(
    ("values", "pays_from"),
    [
        ((0.1, 0.5, 2.0, 4.0), 45),  # halfway between 60 and 30 in the logarithm
        ((0.1, 0.2, 0.3, 0.9), 10),
        ((0.1, 2.0, 0.5, 0.5), 60 + 30 * np.log(2) / np.log(20)),
        ((0.1, 0.5, 1.0, 1.0), 30),  # one that gives up
        ((2.0, 0.5, 0.5, 0.5), None),
    ],
)
def test_crossovers(values, pays_from):
    row = made_up(values).crossovers("texel_p95").iloc[0]
    assert np.isnan(row.pays_from_deg) if pays_from is None else row.pays_from_deg == pytest.approx(pays_from)
    assert row.worst == max(values)
    assert row.best == min(values)


@pytest.mark.parametrize(
    ("values", "pays_from", "failed"),
    [
        ((0.1, None, 0.3, 0.9), 90, 1),  # better wherever it has a number, and yet it fails at 60
        ((0.1, 0.2, None, 2.0), 60, 1),
        ((None, 0.2, 0.3, 0.5), None, 1),
        ((0.1, 0.5, 2.0, None), 45, 1),  # what fails below changes nothing
        ((0.0, 2.0, 2.0, 2.0), 90, 0),  # no logarithm to interpolate
        ((None,) * 4, None, 4),
    ],
)
def test_a_failed_angle_ends_what_pays(values, pays_from, failed):
    found = made_up([np.nan if v is None else v for v in values]).crossovers("texel_p95")
    row = found.iloc[0]
    assert np.isnan(row.pays_from_deg) if pays_from is None else row.pays_from_deg == pytest.approx(pays_from)
    assert row.failed == failed
    known = [v for v in values if v is not None]
    assert (row.best, row.worst) == (min(known), max(known)) if known else np.isnan(row.worst)


def test_a_failed_baseline_ends_what_pays_and_none_wrong_is_no_failure():
    found = made_up((0.1, 0.5, 0.5, 0.5))
    base = found.table.technique == "uniform"
    found.table.loc[base & (found.table.angle_deg == 30), "texel_p95"] = np.nan
    row = found.crossovers("texel_p95").iloc[0]
    assert (row.pays_from_deg, row.failed) == (60, 1)
    none = made_up((0.1, 0.5, 0.0, 0.0))
    none.table.loc[(none.table.technique == "uniform") & (none.table.angle_deg <= 30), "texel_p95"] = 0.0
    row = none.crossovers("texel_p95").iloc[0]
    assert (row.pays_from_deg, row.worst, row.failed) == (30, 1.0, 0)


class Receivers:
    """Uniform maps of a technique that looks at receivers, and keeps what it was given."""

    name, settings, needs_samples = "receivers", {}, True

    def __init__(self):
        self.given = []

    def parameterize(self, scene, camera, light, *, resolution, samples):
        self.given.append(samples)
        return sl.technique("z_partition:count=2").parameterize(scene, camera, light, resolution=resolution)


def test_receivers_are_the_pixels_that_are_judged():
    scene, item = sl.library.scene("robots"), Receivers()
    found = over_light_angle(
        scene, scene.camera, [70], {"r": item}, resolution=64, size=(32, 18), renderer="cpu", progress=False
    ).table
    assert (found.failure == "").all()
    assert len(item.given) == 3, "two to find the side of two maps, and the one that is measured"
    assert all(samples.size == (32, 18) for samples in item.given)


@pytest.mark.parametrize("made_for", [32, 1024])
def test_given_maps_share_the_memory_too(made_for):
    scene = sl.library.scene("robots")
    light = light_at_angle(scene.camera, 70)
    text = "z_partition:count=3"
    given = sl.technique(text).parameterize(scene, scene.camera, light, resolution=made_for)
    found = over_light_angle(
        scene, scene.camera, [70], {"own": text, "given": given}, resolution=100, size=(80, 45), renderer="cpu",
        progress=False,
    ).table.set_index("technique")  # fmt: skip
    # The largest whole side with 3 n^2 <= 100^2.
    assert found.resolution.tolist() == [57, 57]
    study = sl.compare(
        scene, scene.camera, light, {"given": given}, resolution=57, size=(80, 45), renderer="cpu", progress=False
    ).table.iloc[0]
    row = found.loc["given"]
    assert (row.misclassified, row.texel_p95) == (study.misclassified, study.texel_p95)


def test_relative_is_a_row_an_angle_and_the_baseline_is_one():
    wide = made_up((0.1, 0.5, 2.0, 4.0), angles=(10, 90, 30, 60)).relative("texel_p95")
    assert wide.index.tolist() == [90, 60, 30, 10]
    assert wide["t"].tolist() == [0.5, 4.0, 2.0, 0.1]
    assert (wide["uniform"] == 1).all()


def test_rows_are_those_of_a_study_at_equal_memory():
    scene = sl.library.scene("robots")
    size, cpu = (160, 90), sl.Renderer("cpu")
    techniques = ("uniform", "lispsm", "z_partition:count=4")
    found = over_light_angle(
        scene, scene.camera, [70, 20], techniques, resolution=256, size=size, renderer=cpu, progress=False
    ).table
    assert found.angle_deg.tolist() == [70, 70, 70, 20, 20, 20]
    assert found.resolution.tolist() == [256, 256, 128] * 2
    for angle, rows in found.groupby("angle_deg"):
        light = light_at_angle(scene.camera, angle)
        for row in rows.itertuples():
            study = sl.compare(
                scene, scene.camera, light, [row.technique], resolution=row.resolution, size=size, renderer=cpu,
                progress=False,
            ).table.iloc[0]  # fmt: skip
            assert (row.misclassified, row.false_shadow) == (study.misclassified, study.false_shadow)
            samples = sl.View(scene, scene.camera, light, size=size).samples(renderer=cpu)
            technique = sl.technique(row.technique)
            p = technique.parameterize(scene, scene.camera, light, resolution=row.resolution, samples=samples)
            gbuffer = cpu.gbuffer(scene, scene.camera, size=size)
            summary = sl.aliasing.footprint(gbuffer, scene.camera, light, p).summary()
            assert (row.texel_p95, row.storage_factor) == (summary.percentiles[95], summary.storage_factor)
    blind = over_light_angle(scene, scene.camera, [70], truth=False, resolution=64, size=(32, 18), progress=False).table
    assert blind.misclassified.isna().all()
    assert blind.texel_p95.notna().all()


def test_what_a_technique_cannot_do_is_told_in_its_row():
    table = frustum_over_light_angle(square_view(100), [80, 10], ("uniform", "log")).table
    failed = table[table.failure != ""]
    assert failed[["technique", "angle_deg"]].to_numpy().tolist() == [["log", 10]]
    assert failed.storage_factor.isna().all()


def test_what_is_wrong_is_said():
    camera = square_view(10)
    found = made_up((1, 1, 1, 1))
    for call in (
        lambda: light_at_angle("eye", 3),
        lambda: light_at_angle(camera, 181),
        lambda: light_at_angle(camera, np.nan),
        lambda: light_at_angle(camera, "steep"),
        lambda: frustum_over_light_angle(camera, []),
        lambda: frustum_over_light_angle(camera, [3, 3]),
        lambda: frustum_over_light_angle(camera, "90"),
        lambda: frustum_over_light_angle(camera, [90], resolution=0),
        lambda: over_light_angle("scene", camera, [90]),
        lambda: found.relative("length"),
        lambda: found.relative("technique"),
        lambda: found.relative("texel_p95", baseline="lispsm"),
    ):
        with pytest.raises(sl.errors.ArgumentError):
            call()
    with pytest.raises(sl.errors.UnknownNameError):
        frustum_over_light_angle(camera, [90], ["warp"])
