"""PLY files: elements and properties in any order, lists of any length, strips; both byte orders against text."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from load_support import area, corners, loaded, warned

from shadowlab.errors import LoadError
from shadowlab.scene.formats.strips import fan_triangles, strip_triangles

LETTERS = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
U = [(0, 3), (3, 3), (3, 0), (2, 0), (2, 2), (1, 2), (1, 0), (0, 0)]
VERTEX = [("float", "x"), ("float", "y"), ("float", "z")]
FACE = [("uchar", "int", "vertex_indices")]


def ply(elements, encoding="ascii", comments=()):
    """A PLY file of (name, properties, rows); a list in a row is a list in the file."""
    order = ">" if encoding == "binary_big_endian" else "<"
    head = ["ply", f"format {encoding} 1.0", *comments]
    body = b""
    for name, properties, rows in elements:
        head.append(f"element {name} {len(rows)}")
        head += [f"property {'list ' if len(one) == 3 else ''}{' '.join(one)}" for one in properties]
        for row in rows:
            words = []
            for one, value in zip(properties, row, strict=True):
                if len(one) == 3:
                    words += [(one[0], len(value)), *[(one[1], v) for v in value]]
                else:
                    words.append((one[0], value))
            if encoding == "ascii":
                body += (" ".join(str(value) for _, value in words) + "\n").encode()
            else:
                body += b"".join(struct.pack(order + LETTERS[kind], value) for kind, value in words)
    return "\n".join([*head, "end_header", ""]).encode() + body


POINTS = [(x, y, 0) for x, y in U] + [(10, 0, 0), (12, 0, 0), (12, 2, 0), (10, 2, 0)]
CASES = {
    "concave": ([("vertex", VERTEX, POINTS), ("face", FACE, [([0, 1, 2, 3, 4, 5, 6, 7],)])], 6, 7),
    "mixed": (
        [("vertex", VERTEX, POINTS), ("face", FACE, [([0, 1, 2, 3, 4, 5, 6, 7],), ([8, 9, 10, 11],), ([8, 9, 10],)])],
        9, 13),
    "quads": ([("vertex", VERTEX, POINTS), ("face", FACE, [([8, 9, 10, 11],), ([11, 10, 9, 8],)])], 4, 8),
    "faces before vertices": ([("face", FACE, [([8, 9, 10],)]), ("vertex", VERTEX, POINTS)], 1, 2),
    "others about": (
        [
            ("camera", [("double", "fov"), ("uchar", "float", "matrix")], [(0.5, [1, 2, 3]), (1.5, [4])]),
            ("vertex", [("uchar", "red"), ("double", "z"), ("short", "uchar", "marks"), ("float", "y"), ("float", "x")],
             [(9, z, [7] * (i % 3), y, x) for i, (x, y, z) in enumerate(POINTS)]),
            ("edge", [("int", "vertex1"), ("int", "vertex2")], [(0, 1), (1, 2)]),
            ("face",
             [("uchar", "flags"), ("ushort", "float", "texcoord"), ("int", "uint", "vertex_index"), ("float", "q")],
             [(1, [0.5] * 8, [8, 9, 10, 11], 0.5), (2, [], [8, 9, 10], 1.5)]),
        ], 3, 6),
    "strip": (
        [("vertex", VERTEX, POINTS),
         ("tristrips", [("int", "int", "vertex_indices")], [([8, 9, 11, 10, -1, 8, 9, 10],)])], 3, 6),
    "strips and faces": (
        [("vertex", VERTEX, POINTS), ("face", FACE, [([8, 9, 10, 11],)]),
         ("tristrips", [("int", "int", "vertex_indices")], [([8, 9, 11, 10],), ([8, 9, 10],)])], 5, 10),
}  # fmt: skip


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("name", CASES)
def test_elements_in_any_order_and_of_any_length(name, encoding):
    elements, triangles, expected = CASES[name]
    scene = loaded(ply(elements, encoding, ("comment a b", "obj_info made by hand")), "ply")
    assert scene.triangle_count == triangles
    assert area(scene) == pytest.approx(expected)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("name", CASES)
def test_a_file_that_is_cut_short_is_refused_wherever(name, encoding):
    whole = ply(CASES[name][0], encoding)
    # The last number of a text may lose digits unseen.
    for end in range(0, len(whole) - (3 if encoding == "ascii" else 1), 7):
        with pytest.raises(LoadError, match="bytes: "):
            loaded(whole[:end], "ply")


def test_lines_end_as_anywhere_and_have_more_numbers_than_the_header_says():
    text = ply(CASES["concave"][0])
    assert loaded(text.replace(b"\n", b"\r\n"), "ply").triangle_count == 6
    assert loaded(text.replace(b"\n", b"\r"), "ply").triangle_count == 6
    head, body = text.split(b"end_header\n")
    assert area(loaded(head + b"end_header\n" + body.replace(b"\n", b" 255 0 0\n"), "ply")) == pytest.approx(7)


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (ply([("vertex", VERTEX, POINTS)]), "expected faces or tristrips, got 12 vertex"),
        (ply([("vertex", VERTEX, POINTS), ("face", FACE, [])]), "12 vertex, 0 face"),
        (ply([("vertex", VERTEX, POINTS), ("face", FACE, [([0, 1, 12],)])]), "from 0 to 11, got 12"),
        (ply([("vertex", VERTEX, POINTS), ("face", FACE, [([0, 1, -1],)])]), "from 0 to 11, got -1"),
        (ply([("vertex", VERTEX, POINTS), ("tristrips", FACE, [([0, 1, -2],)])]), "got -2"),
        (ply([("vertex", VERTEX[:2], [(0, 0)]), ("face", FACE, [([0, 0, 0],)])]), "x, y and z"),
        (ply([("vertex", VERTEX, POINTS), ("face", [("int", "a")], [(0,)])]), "list vertex_indices of each face"),
        (ply(CASES["quads"][0]).replace(b"element face 2", b"element face 10000000000"), "at most 1,000,000,000"),
        (ply(CASES["quads"][0]).replace(b"element face 2", b"element face 900000000"), "cut short"),
        (ply(CASES["quads"][0], "binary_little_endian").replace(b"face 2", b"face 900000000"), "cut short"),
        (ply(CASES["quads"][0]).replace(b"float x", b"quad x"), "expected a PLY header, got the line"),
        (ply(CASES["quads"][0]).replace(b"ascii", b"xml"), "format ascii or binary"),
        (ply(CASES["quads"][0]).replace(b"12.0", b"twelve").replace(b"12 2", b"twelve 2"), "numbers alone"),
        (b"ply\n" + b"comment x\n" * 200_000, "end_header"),
        (b"plyx\n", "begins with 'ply'"),
        (ply([("vertex", [*VERTEX, ("float", "x")], [(0, 0, 0, 0)])], "binary_little_endian"), "different names"),
    ],
)
def test_what_is_refused_and_why(data, match):
    with pytest.raises(LoadError, match=match):
        loaded(data, "ply")


def test_faces_without_area_by_their_indices_are_counted():
    scene, said = warned(
        ply([("vertex", VERTEX, POINTS), ("face", FACE, [([8, 8, 9],), ([8, 9, 10],), ([],), ([1],)])]), "ply"
    )
    assert scene.triangle_count == 1
    assert "3 faces with fewer than three distinct vertices" in said


@pytest.mark.parametrize("spread", [lambda text: text.replace("\n", " "), lambda text: text.replace(" ", "\n")])
@pytest.mark.parametrize("name", CASES)
def test_numbers_may_run_on_over_lines(name, spread):
    elements, triangles, expected = CASES[name]
    head, _, body = ply(elements).decode().partition("end_header\n")
    scene = loaded(head + "end_header\n" + spread(body), "ply")
    assert (scene.triangle_count, area(scene)) == (triangles, pytest.approx(expected))
    with pytest.raises(LoadError):
        loaded(head + "end_header\n" + spread(body + "7\n"), "ply")


def test_a_body_that_begins_with_a_line_feed():
    properties = [("uchar", "mark"), *VERTEX]
    elements = [("vertex", properties, [(10, *one) for one in POINTS]), ("face", FACE, [([8, 9, 10],)])]
    head, _, body = ply(elements, "binary_little_endian").partition(b"end_header\n")
    for newline in (b"\n", b"\r", b"\r\n"):
        data = (head + b"end_header\n").replace(b"\n", newline) + body
        assert area(loaded(data, "ply")) == pytest.approx(2)


def test_names_are_there_once():
    once = ("vertex", VERTEX, POINTS)
    faces = ("face", FACE, [([8, 9, 10],)])
    for elements in ([once, once, faces], [("vertex", [*VERTEX, VERTEX[0]], [(*one, 0) for one in POINTS]), faces]):
        with pytest.raises(LoadError, match="twice"):
            loaded(ply(elements), "ply")


def test_strips_and_fans_by_hand():
    strip = np.array([0, 1, 2, 3, 3, 5, 5, 6, 7, 8, -1, 1, 2, -1, 4, 5, 6])
    made = strip_triangles(strip, np.array([len(strip)]))
    # Odd triangles turn round; those with a repeated corner only join.
    assert made.tolist() == [[0, 1, 2], [1, 3, 2], [5, 6, 7], [6, 8, 7], [4, 5, 6]]
    assert strip_triangles(np.array([0, 1, 2, 3]), np.array([2, 2])).tolist() == []
    assert fan_triangles(np.array([0, 1, 2, 3, 4, 5, 6]), np.array([4, 3])).tolist() == [
        [0, 1, 2],
        [0, 2, 3],
        [4, 5, 6],
    ]


def test_indices_are_whole_numbers_whatever_type_they_have():
    for kind in ("double", "float", "uint", "short"):
        elements = [("vertex", VERTEX, POINTS), ("face", [("int", kind, "vertex_index")], [([8, 9, 10],)])]
        assert corners(loaded(ply(elements, "binary_big_endian"), "ply"))[0, 0].tolist() == [10, 0, 0]
    with pytest.raises(LoadError, match=r"got 1\.5"):
        loaded(ply([("vertex", VERTEX, POINTS), ("face", [("int", "float", "vertex_index")], [([0, 1.5, 2],)])]), "ply")
