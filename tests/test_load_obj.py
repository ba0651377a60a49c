"""OBJ files line by line: what each statement means, what is refused and with which line."""

from __future__ import annotations

import io
import subprocess
import sys

import numpy as np
import pytest
from load_support import TRIANGLE, area, corners, loaded, warned
from PIL import Image

import shadowlab as sl
from shadowlab.errors import LoadError, SceneError
from shadowlab.scene.formats import obj_lines, words
from shadowlab.scene.formats.given import Given
from shadowlab.scene.formats.limits import Limits
from shadowlab.scene.formats.obj import read_obj

U = "v 0 1 0\nv 1 1 0\nv 1 1 2\nv 2 1 2\nv 2 1 0\nv 3 1 0\nv 3 1 3\nv 0 1 3\n"
SQUARE = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n"


@pytest.mark.parametrize(
    "text",
    [
        U + "f 8 7 6 5 4 3 2 1\n",
        U + "f -1 -2 -3 -4 -5 -6 -7 -8\n",
        U + "vt 0 0\nvn 0 1 0\nf 8/1 7//1 6/1/1 5 4 3 2/ 1//\n",
        U + "f 8 7 6 5 \\\n4 3 \\\n 2 1\n",
        U + "f 8 7 6 5 \\ \t\n4 3 \\\n 2 1\n",
        "\f\n" + U + "\v\n\ff 8 7 6 5 4 3 2 1\n",
        U + "fo 8 7 6 5 4 3 2 1\n",
        (U + "f 8 7 6 5 4 3 2 1\n").replace("\n", "\r\n"),
        (U + "f 8 7 6 5 4 3 2 1\n").replace(" ", "\t"),
        (U + "f 8 7 6 5 4 3 2 1").replace("\n", "  # a comment\n   "),
        "\ufeff# first\n\n" + U + "o thing\ng a b\ns off\nf 8 7 6 5 4 3 2 1\n",
        U.replace("\n", " 1 0.5 0.25\n") + "f 8 7 6 5 4 3 2 1\n",
        U.replace("\n", " 1.0\n") + "f 8 7 6 5 4 3 2 1\n",
        U.replace("2", "2e0").replace("3", "+.3E+1") + "f 8 7 6 5 4 3 2 1\n",
        U.replace("v 3 1 3\n", "v 3 1 3 1 0 0\n") + "f 8 7 6 5 4 3 2 1\n",
        U + "f 8 8 7 6 5 4 4 4 3 2 1 8\n",
        "f 8 7 6 5 4 3 2 1\n" + U,
        U + "usemtl a\nf 8 7 6 5 4 3 2 1\nusemtl b\n",
        (U + "f 8 7 6 5 4 3 2 1\n").encode("utf-16"),
    ],
)
def test_a_concave_polygon_however_it_is_written(text):
    scene = loaded(text, "obj")
    assert scene.triangle_count == 6
    assert area(scene) == pytest.approx(7)
    assert np.unique(corners(scene).reshape(-1, 3), axis=0).shape == (8, 3)


MEASURED = """
import tracemalloc
from shadowlab.scene.formats.obj_lines import ObjLines
from shadowlab.scene.formats.given import Given
for line in ("\\n", " \\n", "l 1\\n", "g\\n", "?\\n", "# x\\n"):
    data = (line * 2_000_000 + "v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n").encode()
    tracemalloc.start()
    lines = ObjLines.of(Given("a", "obj", lambda: data, lambda _: None))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Two copies of the text at once, and what is made for a block.
    assert len(lines.kinds) == 4 and peak < 3 * len(data) + (64 << 20), (line, len(data), peak)
"""


def test_what_says_nothing_of_polygons_takes_no_memory():
    """Lines that are counted are not kept: one byte each in the text, and nothing beside."""
    done = subprocess.run([sys.executable, "-c", MEASURED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_lines_are_found_across_blocks(monkeypatch):
    monkeypatch.setattr(obj_lines, "_BLOCK", 7)
    monkeypatch.setattr(words, "_PIECE", 5)
    text = (
        "# first\n"
        + U.replace("v", "  v", 1)
        + "vt 0 0\r\n"
        + "g "
        + "x" * 40
        + " # no\n"
        + " " * 20
        + "f 8/1 7 6 5 \\\n4 3 2/1 1\n"
    )
    text += "f -8 -7 -6\nl 1 2\nwhat\n\nf 1 2 3"
    scene, said = warned(text, "obj")
    assert scene.triangle_count == 8
    assert area(scene) == pytest.approx(7 + 2 * 1)
    assert "the first is line 16" in said
    with pytest.raises(LoadError, match=r"line 19: .*from 1 to 8"):
        warned(text + "\nf 1 2 9\n", "obj")


def test_polygons_beyond_the_limit_are_refused():
    polygon = U + "f 8 7 6 5 4 3 2 1\n"
    assert loaded(polygon, "obj", limits=Limits(corners=8)).triangle_count == 6
    with pytest.raises(LoadError, match=r"at most 7 corners of a polygon, got 8; .*Limits\(corners=...\)"):
        loaded(polygon, "obj", limits=Limits(corners=7))


def test_libraries_beyond_the_limit_are_refused():
    text = "".join(f"mtllib {i}.mtl\n" for i in range(3)) + TRIANGLE + "f 1 2 3\n"
    assert loaded(text, "obj", limits=Limits(entries=3)).triangle_count == 1
    with pytest.raises(LoadError, match="at most 2 material libraries, got 3"):
        loaded(text, "obj", limits=Limits(entries=2))


def test_negative_indices_count_from_where_they_stand():
    text = TRIANGLE + "f -3 -2 -1\n" + TRIANGLE.replace("v ", "v 1") + "f -3 -2 -1\n"
    scene = loaded(text, "obj")
    assert sorted(corners(scene)[:, :, 0].min(axis=1)) == [0, 10]


@pytest.mark.parametrize(
    ("text", "line", "match"),
    [
        (TRIANGLE + "f 0 1 2\n", 4, "indices from 1"),
        (TRIANGLE + "\n\nf 1 2 3\nf 1 2 4\n", 7, "from 1 to 3"),
        (TRIANGLE + "f 1 2 -4\n", 4, "-4"),
        (TRIANGLE + "f 1 2 x\n", 4, "corners such as"),
        (TRIANGLE + "f 1 2 3/1/1/1\n", 4, "corners such as"),
        (TRIANGLE + "f 1 2 3.5\n", 4, "corners such as"),
        (TRIANGLE + "f 1 2 \\\n3\nf 9 9 9\n", 6, "from 1 to 3"),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", 2, "3 numbers"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 z\nf 1 2 3\n", 3, "numbers"),
        ("v 0 0 0\nv 1 0 0\nv\nf 1 2 3\n", 3, "numbers after v"),
        ("v 0 0 0\nv 1 0 0\nv 1,5 0 2\nf 1 2 3\n", 3, "numbers"),
        (TRIANGLE + "f 1 2 99999999999999999999999\n", 4, "from 1 to 3"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(text, line, match):
    with pytest.raises(LoadError, match=rf"line {line}: .*{match}"):
        loaded(text, "obj")


def test_faces_with_too_few_corners_are_counted():
    scene, said = warned(TRIANGLE + "f 1 1 2\nf 1 2\nf 1 2 3\nf 2\n", "obj")
    assert scene.triangle_count == 1
    assert "3 faces with fewer than three distinct vertices" in said
    with pytest.raises(SceneError, match="no usable triangle: left out: 1 face with fewer"):
        loaded(TRIANGLE + "f 1 2 2\n", "obj")


def test_what_is_no_polygon_is_left_out_and_told():
    _, said = warned(TRIANGLE + "l 1 2\np 1\np 2\nf 1 2 3\n", "obj")
    assert "3 line or point elements" in said
    _, said = warned(TRIANGLE + "cstype bspline\ndeg 3\ncurv 0 1 1 2 3\nsurf 0 1 0 1 1 2\nend\nf 1 2 3\n", "obj")
    assert "2 free-form elements" in said
    _, said = warned(TRIANGLE + "f 1 2 3\nhello there\n", "obj")
    assert "no statements of OBJ (the first is line 5)" in said
    _, said = warned(TRIANGLE.replace("0 0 0", "0 0 0 2") + "f 1 2 3\n", "obj")
    assert "weight of rational curves" in said
    for text, match in (
        (TRIANGLE, "3 vertices alone"),
        (TRIANGLE + "curv 0 1 1 2\n", "free-form"),
        ("l 1 2\n", "line"),
    ):
        with pytest.raises(LoadError, match=match):
            loaded(text, "obj")


def test_a_missing_library_is_silent_and_one_outside_is_not_read(tmp_path):
    (tmp_path / "secret.mtl").write_text("newmtl a\nmap_d hole.png\n")
    folder = tmp_path / "models"
    folder.mkdir()
    path = folder / "a.obj"
    path.write_text("mtllib nowhere.mtl\nusemtl a\n" + TRIANGLE + "f 1 2 3\n")
    assert loaded(path.read_bytes(), "obj").triangle_count == 1
    assert sl.load_scene(path).triangle_count == 1
    (folder / "link.mtl").symlink_to(tmp_path / "secret.mtl")
    for name in ("../secret.mtl", str(tmp_path / "secret.mtl"), "link.mtl", "..\\secret.mtl", "sub/../../secret.mtl"):
        path.write_text(f"mtllib {name}\nusemtl a\n" + TRIANGLE + "f 1 2 3\n")
        with pytest.warns(sl.errors.ShadowlabWarning, match="outside the folder and was not read"):
            sl.load_scene(path)


def test_names_in_any_encoding():
    text = "usemtl caf\u00e9\n".encode("latin-1") + (TRIANGLE + "f 1 2 3\n").encode()
    assert loaded(text, "obj").triangle_count == 1


def test_a_texture_of_opacity_is_kept_with_its_coordinates():
    image = io.BytesIO()
    Image.fromarray(np.array([[0, 255], [255, 0]], np.uint8)).save(image, "PNG")
    files = {"a.mtl": b"newmtl leaf\nd 0.5\nmap_d -clamp on -s 1 1 leaf one.png\n", "leaf one.png": image.getvalue()}
    text = "mtllib a.mtl\nusemtl leaf\n" + TRIANGLE + "vt 0 0\nvt 1 0\nvt 0 0.75\nf 1/1 2/2 3/3\n"
    found = read_obj(Given("a.obj", "obj", lambda: text.encode(), files.get, Limits()))
    assert found.notes == []
    (mesh,) = found.meshes.values()
    test = mesh.alpha
    np.testing.assert_array_equal(test.texture, [[0, 255], [255, 0]])
    # v counts from the bottom row in OBJ.
    order = np.argsort(mesh.vertices @ (1, 2, 0))
    np.testing.assert_array_equal(test.uv[order], [[0, 1], [1, 1], [0, 0.25]])
    assert (test.wrap, test.factor, test.cutoff) == (("clamp", "clamp"), 1.0, 0.5)


def test_materials_are_meshes_and_unused_vertices_stay_away():
    text = SQUARE + "v 9 9 9\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 3 2 1\n"
    scene = loaded(text, "obj")
    assert [(len(mesh.vertices), len(mesh.faces)) for mesh in scene.meshes] == [(3, 1), (3, 2)]
