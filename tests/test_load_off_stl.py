"""OFF and STL files: their dialects, and what is refused."""

from __future__ import annotations

import struct

import pytest
from load_support import area, loaded, warned

import shadowlab as sl
from shadowlab.errors import LoadError

U = "0 3 0\n3 3 0\n3 0 0\n2 0 0\n2 2 0\n1 2 0\n1 0 0\n0 0 0\n"
FACES = "8 0 1 2 3 4 5 6 7\n3 0 1 2\n"
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 2e0 0\nendloop\nendfacet\n"


def rows(text, more):
    """The lines with more at the end of each."""
    return text.replace("\n", f" {more}\n")


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n8 2 0\n" + U + FACES,
        "OFF 8 2 0\n" + U + FACES,
        "off\n8 2 0\n".upper() + U + FACES,
        "# a comment\n\nOFF # here\n# there\n8 2\n\n" + rows(U, "# and here") + FACES,
        "COFF\n8 2 0\n" + rows(U, "255 0 0 255") + FACES,
        "NOFF\n8 2 0\n" + rows(U, "0 0 1") + FACES,
        "STOFF\n8 2 0\n" + rows(U, "0.5 0.5") + FACES,
        "STCNOFF\n8 2 0\n" + rows(U, "0.5 0.5 1 1 1 1 0 0 1") + FACES,
        "OFF\r\n8 2 0\r\n" + (U + rows(FACES, "0.5 0.25 0.5")).replace("\n", "\r\n"),
        "OFF\n8 2 0\n" + U + "8 0 1 2 3 4 5 6 7 255 0 0\n3 0 1 2 7",
        "\ufeffOFF\n8 2 0\n" + U + FACES + "trailing words\n",
        "8 2 0\n" + U + FACES,
        "off\n8 2 0\n" + U + FACES,
        "OFF\n8 2 0\n" + U.replace("\n", " ") + "\n" + FACES,
        ("OFF\n8 2 0\n" + U + FACES).replace("\n", " "),
        "NOFF\n8 2 0\n" + rows(U, "\n0 0 1") + FACES,
        "OFF\n8 2 0\n" + (U + FACES).replace(" ", "\n"),
    ],
)
def test_off_in_its_dialects(text):
    scene = loaded(text, "off")
    assert scene.triangle_count == 7
    assert area(scene) == pytest.approx(7 + 4.5)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("4OFF\n8 2 0\n", "three coordinates"),
        ("nOFF\n3\n8 2 0\n", "three coordinates"),
        ("OFF BINARY\n", "three coordinates"),
        ("OF\n", "begins with OFF"),
        ("OFF\n", "numbers of vertices and faces"),
        ("OFF\n8\n", "numbers of vertices and faces"),
        ("OFF\n8 2 0\n" + U, "8 vertices and 2 faces"),
        ("OFF\n8 3 0\n" + U + FACES, "8 vertices and 3 faces"),
        ("OFF\n10000000000 1 0\n", "at most 1,000,000,000 vertices"),
        ("OFF\n8 -1 0\n" + U, "whole number of faces"),
        ("OFF\n8 1.5 0\n" + U, "whole number of faces"),
        ("OFF\n8 1 0\n" + U + "3 0 1 8\n", "from 0 to 7 in faces, got 8"),
        ("OFF\n8 1 0\n" + U + "3 0 1 -1\n", "got -1"),
        ("OFF\n8 2 0\n" + U.replace("\n", " ") + FACES[:-2], "8 vertices and 2 faces"),
        ("OFF\n8 1 0\n" + U + "4 0 1 2\n", "begin with its number"),
        ("OFF\n8 1 0\n" + U.replace("1 2", "one 2") + "3 0 1 2\n", "other words"),
        ("OFF\n8 0 0\n" + U, "8 vertices alone"),
    ],
)
def test_off_that_is_refused(text, match):
    with pytest.raises(LoadError, match=match):
        loaded(text, "off")


def binary(count, triangles, header=b"solid but binary"):
    """A binary STL file that says so many triangles."""
    record = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 7)
    return header.ljust(80) + struct.pack("<I", count) + record * triangles


def test_stl_is_binary_where_its_size_says_so():
    for header in (b"solid but binary", b"", b"\0\xff"):
        scene = loaded(binary(3, 3, header), "stl")
        assert (scene.triangle_count, area(scene)) == (3, 6)


def test_stl_with_bytes_after_its_triangles():
    scene, said = warned(binary(2, 2) + b"appended", "stl")
    assert scene.triangle_count == 2
    assert "8 bytes after the 2 triangles" in said


def test_stl_with_ends_of_two_words():
    assert area(loaded("solid\n" + FACET.replace("end", "end ") + "end solid\n", "stl")) == pytest.approx(2)


def test_stl_with_several_solids():
    text = (
        f"solid one\n{FACET}endsolid one\n\nSOLID a solid endsolid name\n{FACET * 2}ENDSOLID\nsolid empty\nendsolid\n"
    )
    scene = loaded(text, "stl")
    assert [len(mesh.faces) for mesh in scene.meshes] == [1, 2]
    assert area(scene) == pytest.approx(6)
    assert loaded(text.upper().replace("\n", "\r\n"), "stl").triangle_count == 3
    assert loaded(text.replace("normal 0 0 1", "normal nan nan nan"), "stl").triangle_count == 3
    assert loaded(text.replace("normal 0 0 1", ""), "stl").triangle_count == 3
    assert loaded(f"solid\n{FACET}solid\n{FACET}endsolid\n", "stl").triangle_count == 2


def test_stl_with_vertices_that_are_not_finite():
    scene, said = warned(f"solid\n{FACET}{FACET.replace('2e0', 'nan')}endsolid\n", "stl")
    assert scene.triangle_count == 1
    assert "1 face with vertices that are not finite" in said


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (binary(4, 3), "for the 4 triangles of its header"),
        (binary(2, 3), "for the 2 triangles of its header"),
        (binary(2**32 - 1, 1, b""), "4,294,967,295 triangles"),
        (binary(3, 3, b"")[:-1], "cut short"),
        (binary(0, 0), "expected triangles, got none"),
        (b"hello", "expected an STL file"),
        (b"solid\n", "expected endsolid"),
        (b"solid\nendsolid\n", "expected facets"),
        (f"solid\n{FACET}".encode(), "expected endsolid"),
        (f"solid\n{FACET.replace('vertex 2 0 0', '')}endsolid\n".encode(), "three vertices"),
        (f"solid\n{FACET.replace('2e0', 'two')}endsolid\n".encode(), "three numbers"),
        (f"solid\n{FACET.replace('2e0', '')}endsolid\n".encode(), "three numbers"),
        (f"solid\n{FACET.replace('2e0', '2e0 5')}endsolid\n".encode(), "three numbers"),
    ],
)
def test_stl_that_is_refused(data, match):
    with pytest.raises(LoadError, match=match):
        loaded(data, "stl")


def test_a_scene_far_away_keeps_its_shape():
    far = U.replace("3", "5000003").replace("2", "5000002").replace("1", "5000001")
    text = "OFF\n8 1 0\n" + "\n".join(
        f"{500000 + float(a)} {4600000 + float(b)} 0" for a, b, _ in map(str.split, U.splitlines())
    )
    assert area(loaded(text + "\n8 0 1 2 3 4 5 6 7\n", "off")) == pytest.approx(7)
    assert isinstance(loaded(f"OFF\n8 1 0\n{far}3 0 1 2\n", "off"), sl.Scene)
