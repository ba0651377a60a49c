"""Maps whose width is not their height: matrices, renderers, files, errors; the contract is in tests/rust/contract."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import shadowlab as sl

WIDE = (768, 256)


@pytest.fixture(scope="module")
def view():
    """A view with little of its own."""
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=(160, 90))


def made(view, technique, resolution):
    """Its maps in the view."""
    return sl.technique(technique).parameterize(view.scene, view.camera, view.light, resolution=resolution)


def test_a_pair_is_width_and_height(view):
    p = made(view, "lispsm", WIDE)
    assert p.resolution == WIDE
    assert "resolution=(768, 256)" in repr(p)
    assert "1 of 768 × 256" in p._repr_html_()
    assert sl.Renderer("cpu").shadow_map(view.scene, p).shape == (256, 768)
    assert made(view, "lispsm", (256, 256)) == made(view, "lispsm", 256)
    assert made(view, "lispsm", 256).resolution == 256


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "z_partition:count=2,inner=lispsm", "log_psm"])
def test_both_renderers_read_what_was_fitted(view, technique, gpu_renderer):
    cpu = sl.Renderer("cpu")
    renderers = [cpu] if technique == "log_psm" else [cpu, gpu_renderer]
    truth = sl.trace.shadow_mask(view.scene, view.camera, view.light, size=view.size)
    for renderer in renderers:

        def wrong(resolution, renderer=renderer):
            p = made(view, technique, resolution)
            mask = renderer.shadow_mask(view.scene, view.camera, view.light, p, size=view.size)
            return sl.aliasing.misclassified(mask, truth).count

        # Three times the columns at as many rows.
        assert wrong(WIDE) < 0.99 * wrong(256), f"{technique} by {renderer.backend}"


def test_texels_are_as_long_as_their_axis_has_them(view):
    g = view.gbuffer("cpu")
    lit = np.asarray(g.normal) @ view.light.direction < -0.1
    points, normals = (np.asarray(of)[lit][::50] for of in (g.position, g.normal))
    square, wide = (
        sl.aliasing.footprint_at(points, normals, view.camera, view.light, made(view, "uniform", r), size=view.size)
        for r in (256, WIDE)
    )
    # Of 256 texels two are the border along y in both; of 768 along x two, of 256 two.
    ratio = np.linalg.norm(wide.jacobian, axis=1) / np.linalg.norm(square.jacobian, axis=1)
    assert len(ratio) > 50
    assert np.allclose(ratio, [(256 - 2) / (768 - 2), 1.0], rtol=1e-5)


def test_files_and_pickles_keep_it(view, tmp_path):
    p = made(view, "lispsm", WIDE)
    assert pickle.loads(pickle.dumps(p)) == p
    matrix = sl.Parameterization.from_matrix(p.matrix, resolution=WIDE)
    assert matrix.resolution == WIDE
    assert pickle.loads(pickle.dumps(matrix)) == matrix
    file = Path(tmp_path) / "wide.json"
    file.write_text(json.dumps({"matrix": p.matrix.tolist(), "resolution": list(WIDE)}), "utf-8")
    assert sl.technique(f"matrix:file={file}").resolution == WIDE


@pytest.mark.parametrize(
    "resolution", [(0, 256), (256,), (256, 256, 256), (256.5, 256), "wide", (1 << 20, 16), (-1, 3)]
)
def test_what_is_no_size_is_refused(view, resolution):
    with pytest.raises(
        sl.errors.ArgumentError, match=r"^resolution: expected a whole number or a pair \(width, height\)"
    ):
        made(view, "uniform", resolution)


def test_a_side_without_a_texel_between_the_borders_is_refused(view):
    with pytest.raises(sl.errors.ArgumentError, match=r"resolution: expected at least 3 texels .*, got 2"):
        made(view, "uniform", (256, 2))
