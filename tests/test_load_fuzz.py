"""Small valid files with random damage: a scene or one of our errors, and never by way of a reader's own failure.

`SHADOWLAB_FUZZ_SECONDS` makes the last test run for longer; its seed follows from the time, and is printed.
"""

from __future__ import annotations

import gzip
import os
import random
import time
import warnings

import numpy as np
import pytest
import trimesh
from load_support import zipped
from test_load_off_stl import FACES, FACET, U, binary
from test_load_ply import CASES, ply
from test_load_sources import tarred
from test_load_xml import POLY, TWICE, dae, model, package, primitive

import shadowlab as sl
from shadowlab.errors import InternalError, LoadError, ShadowlabError

OBJ = (
    b"mtllib a.mtl\no one\nv 0 1 0\n"
    b"v 1 1 0 0.5 0.5 0.5\nv 1 1 2 1\nv 2 1 2\nv 2 1 0\nv 3 1 0\nvt 0 0\nvt 1 0 0\nvn 0 1 0\n"
    b"usemtl a\nf 1 2 3\nf 1/1 2/2 3/1 4/1\nf 1//1 -2//1 3//-1\nusemtl b\nf 1/1/1 2/2/1 3/1/1 \\\n 4/2/1 5/1/1\nl 1 2\n"
)
MESH = package(
    '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>'
    '<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="2" y="0" z="0"/><vertex x="0" y="2" z="0"/>'
    '</vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>',
    '<item objectid="2"/>',
)
ASSET = "<unit meter='0.01'/><up_axis>Z_UP</up_axis>"
SEEDS = [
    ("obj", OBJ),
    *[("ply", ply(elements, encoding)) for elements, _, _ in CASES.values()
      for encoding in ("ascii", "binary_little_endian", "binary_big_endian")],
    ("off", ("COFF\n8 2 0 # a\n" + U + FACES).encode()),
    ("stl", f"solid one\n{FACET}endsolid one\nsolid two\n{FACET * 2}endsolid\n".encode()),
    ("stl", binary(3, 3)),
    ("dae", dae(POLY + primitive("tristrips", "1 0 2 7"), TWICE, ASSET).encode()),
    ("dae", dae(primitive("polygons", "0 1 2 3"), f"<node><rotate>0 0 1 9</rotate>{TWICE}</node>").encode()),
    ("3mf", MESH),
    ("zip", zipped({"a/a.obj": OBJ, "b.off": "OFF\n8 2 0\n" + U + FACES})),
    ("tgz", tarred({"a/a.obj": OBJ})),
    ("gz", gzip.compress(OBJ)),
    ("xaml", b"<Model3DGroup><GeometryModel3D/></Model3DGroup>"),
    ("dxf", b"0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n"),
    ("glb", trimesh.creation.box().export(file_type="glb")),
]  # fmt: skip
WORDS = [
    b"-1", b"0", b"1e10", b"10000000000", b"nan", b"-inf", b"1e999", b"99999999999999999999", b"x", b"#", b"\\\n",
    b"\n", b" ", b"/", b"\0", b"<", b">", b"&a;", b"'", b"..", b"2147483648", b"-9223372036854775808", b"\xff\xfe",
    b"solid", b"f ", b"1_0", b"+",
]  # fmt: skip
#: Kinds that other programs read, whose failures are theirs.
READ_BY_OTHERS = ("xaml", "dxf", "glb")
SECONDS = float(os.environ.get("SHADOWLAB_FUZZ_SECONDS", "2"))
SLOWEST = 5.0


def damaged(data, rng):
    """The bytes with a few random changes."""
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        at = rng.randrange(len(data) + 1)
        span = rng.choice((1, 1, 2, 4, 16))
        kind = rng.randrange(7)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            del data[at : at + span]
        elif kind == 2:
            data[at:at] = rng.choice(WORDS)
        elif kind == 3:
            data[at : at + span] = rng.choice(WORDS)
        elif kind == 4 and data:
            data[at % len(data)] = rng.randrange(256)
        elif kind == 5:
            other = rng.randrange(len(data) + 1)
            data[at:at] = data[other : other + span * 8]
        elif data:
            data[at : at + 4] = rng.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\0\x80"))
    return bytes(data)


def check(kind, data):
    """Loads it; whether there was a scene."""
    name = "a.obj.gz" if kind == "gz" else f"a.{kind}"
    begin = time.process_time()
    stream, refused = Named(data, name), None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = sl.load_scene(stream)
    except ShadowlabError as e:
        refused = e
    finally:
        assert time.process_time() - begin < SLOWEST, (kind, data)
    if refused is not None:
        said = str(refused)
        assert not isinstance(refused, InternalError)
        assert 20 < len(said) < 2500
        if kind not in READ_BY_OTHERS:
            assert "could not read it (" not in said or "well-formed" in said, (kind, data, said)
        return False
    assert scene.triangle_count > 0
    assert np.isfinite(scene.bounds).all()
    return True


class Named:
    """An open file with a name."""

    def __init__(self, data, name):
        self.data, self.name = data, name

    def read(self, size):
        part, self.data = self.data[:size], self.data[size:]
        return part


@pytest.mark.parametrize(("kind", "data"), SEEDS, ids=[f"{kind} {i}" for i, (kind, _) in enumerate(SEEDS)])
def test_damaged_files(kind, data):
    rng = random.Random(f"{kind} {len(data)}")
    if kind not in ("xaml", "dxf"):
        assert check(kind, data)
    for _ in range(60):
        check(kind, damaged(data, rng))


def test_random_bytes_and_wrong_endings():
    rng = random.Random(5)
    for kind, _ in SEEDS:
        for size in (0, 1, 3, 100, 5000):
            assert not check(kind, rng.randbytes(size))
        for other, data in SEEDS:
            if other != kind:
                check(kind, data)
    assert model("", "")
    assert isinstance(LoadError("x"), OSError)


def test_damaged_files_for_a_while():
    end = time.monotonic() + SECONDS
    seed = time.time_ns()
    rng = random.Random(seed)
    tried, scenes = {}, {}
    while time.monotonic() < end:
        kind, data = rng.choice(SEEDS)
        tried[kind] = tried.get(kind, 0) + 1
        scenes[kind] = scenes.get(kind, 0) + check(kind, damaged(data, rng))
    print(f"seed {seed}: tried {tried}, scenes {scenes}")
