"""What `load_scene` takes: paths, bytes, open files, archives; and what files may refer to."""

from __future__ import annotations

import bz2
import gzip
import io
import pathlib
import tarfile
import warnings
import zipfile

import numpy as np
import pytest
import trimesh
from load_support import TRIANGLE, loaded, warned, zipped

import shadowlab as sl
from shadowlab.errors import ArgumentError, LoadError

OBJ = (TRIANGLE + "f 1 2 3\n").encode()
TWO = (TRIANGLE + "f 1 2 3\nf 3 2 1\n").encode()


class Stream:
    """A file that can only be read."""

    def __init__(self, parts, **attributes):
        self.parts = list(parts)
        vars(self).update(attributes)

    def read(self, size=-1):
        part = self.parts.pop(0) if self.parts else b""
        if isinstance(part, Exception):
            raise part
        return part


def raising(*_):
    raise RuntimeError("no")


class Failing:
    """A path or a name that fails."""

    __fspath__ = raising


@pytest.mark.parametrize("kind", ["obj", "OBJ", ".obj"])
def test_bytes_of_every_sort(kind):
    for source in (
        OBJ,
        bytearray(OBJ),
        memoryview(OBJ),
        memoryview(OBJ + OBJ)[: len(OBJ)],
        memoryview(OBJ[::-1])[::-1],
    ):
        scene = sl.load_scene(source, kind=kind)
        assert scene.triangle_count == 1
        assert (scene.source, scene.recipe) == ("", "")


def test_open_files(tmp_path):
    path = tmp_path / "a.obj"
    path.write_bytes(b"junk\n" + OBJ)
    with path.open("rb") as binary, path.open(encoding="ascii") as text:
        for file in (binary, text):
            file.readline()
            scene = sl.load_scene(file)
            assert (scene.triangle_count, scene.source) == (1, str(path))
    with path.open("rb", buffering=0) as unbuffered, pytest.warns(sl.errors.ShadowlabWarning, match="line 1"):
        sl.load_scene(unbuffered)
    for stream in (
        io.BytesIO(OBJ),
        io.StringIO(OBJ.decode()),
        Stream([OBJ[:9], OBJ[9:]]),
        Stream([OBJ.decode()], name=7),
    ):
        assert sl.load_scene(stream, kind="obj").triangle_count == 1
    assert sl.load_scene(Stream([OBJ], name="b.obj")).triangle_count == 1
    assert sl.load_scene(Stream([OBJ], name=b"b.obj")).triangle_count == 1
    assert sl.load_scene(Stream([OBJ], name=pathlib.Path("b.stl")), kind="obj").triangle_count == 1


@pytest.mark.parametrize(
    ("source", "options", "error", "match"),
    [
        (OBJ, {}, ArgumentError, "kind: expected the ending of a mesh file for bytes"),
        (io.BytesIO(OBJ), {}, ArgumentError, "kind: expected the ending"),
        (Stream([OBJ], name="noending"), {}, ArgumentError, "kind: expected the ending"),
        (Stream([OBJ], name=Failing()), {}, ArgumentError, "kind: expected the ending"),
        (OBJ, {"kind": "docx"}, ArgumentError, "kind: expected the ending of a file that can be loaded .*obj"),
        (OBJ, {"kind": 3}, ArgumentError, "kind: .*got 3"),
        (OBJ, {"kind": ""}, ArgumentError, "kind"),
        (OBJ, {"kind": "obj", "limits": 5}, ArgumentError, "limits: expected sl.Limits, got 5"),
        (3, {}, ArgumentError, "source: expected the path"),
        (None, {}, ArgumentError, "source: expected the path"),
        ([OBJ], {}, ArgumentError, "source: expected the path"),
        (Failing(), {}, ArgumentError, "source: expected a path"),
        ("a\0.obj", {}, LoadError, "could not look|nothing there"),
        ("a" * 5000 + ".obj", {}, LoadError, "could not look|nothing there"),
        ("/dev/zero", {"kind": "obj"}, LoadError, "a pipe or a device"),
        (Stream([OBJ], closed=True), {"kind": "obj"}, ArgumentError, "which is closed"),
        (Stream([OBJ, OSError("gone")]), {"kind": "obj"}, LoadError, "OSError: gone"),
        (Stream([ZeroDivisionError()]), {"kind": "obj"}, LoadError, "ZeroDivisionError"),
        (Stream([None]), {"kind": "obj"}, LoadError, "bytes or text from its read, got None"),
        (Stream([5]), {"kind": "obj"}, LoadError, "got 5"),
        (Stream([]), {"kind": "obj"}, LoadError, "an empty one"),
        (Stream([OBJ] * 9), {"kind": "obj", "limits": sl.Limits(size=100)}, LoadError, "at most 100 bytes"),
        (OBJ, {"kind": "obj", "limits": sl.Limits(size=10)}, LoadError, "at most 10 bytes, got 32; .*Limits.size"),
        (OBJ, {"kind": "obj", "up": "x"}, ArgumentError, "up: expected"),
        (b"", {"kind": "ply"}, LoadError, "empty"),
    ],
)
def test_sources_that_are_refused(source, options, error, match):
    with pytest.raises(error, match=match):
        sl.load_scene(source, **options)


def test_a_closed_file(tmp_path):
    path = tmp_path / "a.obj"
    path.write_bytes(OBJ)
    with path.open("rb") as file:
        pass
    with pytest.raises(ArgumentError, match="which is closed"):
        sl.load_scene(file)


def test_the_recipe_makes_the_scene_again(tmp_path):
    path = tmp_path / "a.obj"
    path.write_bytes(OBJ)
    limits = sl.Limits(size=1000, ratio=20.5)
    scene = sl.load_scene(path, up="z", unit="cm", kind="obj", limits=limits)
    assert scene.recipe == (
        f"sl.load_scene({str(path)!r}, up='z', unit='cm', kind='obj', limits=sl.Limits(size=1000, ratio=20.5))"
    )
    again = eval(scene.recipe, {"sl": sl})
    assert again == scene
    np.testing.assert_array_equal(again.world_from_source, scene.world_from_source)
    assert sl.load_scene(path).recipe == f"sl.load_scene({str(path)!r})"


def tarred(files, mode="w:gz", **changes):
    """The bytes of a tar of files by name; changes are of every entry."""
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode=mode) as packed:
        for name, content in files.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            vars_ = {"size": 0, **changes} if "type" in changes else changes
            for key, value in vars_.items():
                setattr(info, key, value)
            packed.addfile(info, io.BytesIO(content))
    return stream.getvalue()


PACKED = {
    "zip": zipped,
    "tar": lambda files: tarred(files, "w:"),
    "tar.gz": tarred,
    "tgz": tarred,
    "tar.bz2": lambda files: tarred(files, "w:bz2"),
}


@pytest.mark.parametrize("kind", PACKED)
def test_all_meshes_of_an_archive_are_joined(kind, tmp_path):
    box = trimesh.creation.box().export(file_type="stl")
    data = PACKED[kind]({"read.me": b"hello", "b/box.stl": box, "a.obj": TWO, "B.OBJ": OBJ})
    path = tmp_path / f"models.{kind}"
    path.write_bytes(data)
    for scene in (sl.load_scene(path), loaded(data, kind), sl.load_scene(io.BytesIO(data), kind=kind)):
        assert [len(mesh.faces) for mesh in scene.meshes] == [12, 2, 1]
    if kind == "zip":
        assert sl.Scene.from_trimesh(trimesh.load_scene(path, process=False)).triangle_count == 15


@pytest.mark.parametrize("kind", PACKED)
def test_references_between_entries(kind):
    gltf = trimesh.creation.box().export(file_type="gltf")
    files = {f"deep/{name}": data for name, data in gltf.items()}
    assert loaded(PACKED[kind](files), kind).triangle_count == 12
    text = b"mtllib a.mtl\nusemtl leaf\n" + OBJ
    scene, said = warned(PACKED[kind]({"x/a.obj": text, "x/a.mtl": b"newmtl leaf\nmap_d a.png\n"}), kind)
    assert "alpha-tested material 'leaf'" in said
    # The library beside another file is not this one's.
    assert loaded(PACKED[kind]({"x/a.obj": text, "y/a.mtl": b"newmtl leaf\nmap_d a.png\n"}), kind).triangle_count == 1
    _, said = warned(
        PACKED[kind]({"x/a.obj": text.replace(b"a.mtl", b"../a.mtl"), "a.mtl": b"newmtl leaf\nmap_d a\n"}), kind
    )
    assert "outside the folder" in said
    assert scene.triangle_count == 1


@pytest.mark.parametrize("kind", ["gz", "bz2"])
def test_single_files(kind, tmp_path):
    pack = {"gz": gzip.compress, "bz2": bz2.compress}[kind]
    path = tmp_path / f"a.obj.{kind}"
    path.write_bytes(pack(OBJ))
    assert sl.load_scene(path).triangle_count == 1
    for name in ("a", "a.zip", "a.tar.gz", "a.gz"):
        other = tmp_path / f"{name}.{kind}"
        other.write_bytes(pack(OBJ))
        with pytest.raises(LoadError):
            sl.load_scene(other)
    path.write_bytes(pack(OBJ)[:-5])
    with pytest.raises(LoadError, match="could not unpack"):
        sl.load_scene(path)


@pytest.mark.parametrize("kind", PACKED)
def test_names_outside_an_archive_are_refused(kind):
    for name in ("../a.obj", "/a.obj", "a/../../b.obj", "c:/a.obj", "..\\a.obj"):
        with pytest.raises(LoadError, match=r"outside|own folder"):
            loaded(PACKED[kind]({name: OBJ}), kind)


def test_links_and_other_kinds_of_entries_are_refused():
    for kind in (tarfile.SYMTYPE, tarfile.LNKTYPE):
        with pytest.raises(LoadError, match="links in archives are not followed"):
            loaded(tarred({"a.obj": b""}, type=kind, linkname="/etc/passwd"), "tgz")
    for kind in (tarfile.FIFOTYPE, tarfile.CHRTYPE):
        with pytest.raises(LoadError, match="another kind"):
            loaded(tarred({"a.obj": b""}, type=kind), "tgz")
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        info = zipfile.ZipInfo("a.obj")
        info.external_attr = 0o120777 << 16
        packed.writestr(info, "/etc/passwd")
    with pytest.raises(LoadError, match="links in archives are not followed"):
        loaded(stream.getvalue(), "zip")


def test_archives_in_archives_are_not_read():
    inner = zipped({"a.obj": OBJ})
    for name in ("inner.zip", "inner.tar.gz", "a.obj.gz"):
        with pytest.raises(LoadError, match="an archive in an archive"):
            loaded(zipped({name: inner}), "zip")
    scene, said = warned(zipped({"inner.zip": inner, "a.obj": TWO}), "zip")
    assert scene.triangle_count == 2
    assert "'inner.zip', an archive in an archive" in said
    with pytest.raises(LoadError, match="1 other files"):
        loaded(zipped({"a.txt": b""}), "zip")


def test_files_of_an_archive_that_cannot_be_read_are_told():
    scene, said = warned(zipped({"bad.ply": b"ply\n", "a.obj": OBJ}), "zip")
    assert scene.triangle_count == 1
    assert "bytes/bad.ply: expected end_header" in said
    with pytest.raises(LoadError, match=r"bytes/bad\.ply: expected end_header"):
        loaded(zipped({"bad.ply": b"ply\n"}), "zip")


def test_what_macos_adds_to_archives_is_passed_over():
    files = {"__MACOSX/._a.obj": b"\0\5\x16\7", "a.obj": OBJ, "b/._c.obj": b"\0"}
    for data, kind in ((zipped(files), "zip"), (tarred(files), "tar.gz")):
        assert loaded(data, kind).triangle_count == 1


def test_names_in_archives_may_have_colons():
    assert loaded(tarred({"a: b.obj": OBJ}), "tar.gz").triangle_count == 1
    with pytest.raises(LoadError, match="own folder"):
        loaded(tarred({"c:/a.obj": OBJ}), "tar.gz")


def test_open_files_that_unpack(tmp_path):
    path = tmp_path / "a.obj.gz"
    path.write_bytes(gzip.compress(OBJ))
    with gzip.open(path) as stream:
        assert sl.load_scene(stream).triangle_count == 1
    with path.open("rb") as stream:
        assert sl.load_scene(stream).triangle_count == 1
    with path.open(encoding="utf-8") as stream, pytest.raises(LoadError, match="open it in binary mode"):
        sl.load_scene(stream)


def bomb(size=80 << 20):
    """Many zeros."""
    return bytes(size)


def test_bombs_are_refused_while_they_are_unpacked():
    zeros = bomb()
    compressed = gzip.compress(zeros, 9)
    files = {
        "zip": zipped({"a.obj": zeros}),
        "3mf": zipped({"3D/3dmodel.model": zeros}),
        "tar.gz": tarred({"a.obj": zeros}),
        "tar.bz2": tarred({"a.obj": zeros}, "w:bz2"),
    }
    for kind, data in files.items():
        with pytest.raises(LoadError, match="for each packed byte"):
            loaded(data, kind)
    with pytest.raises(LoadError, match="for each packed byte"):
        sl.load_scene(Stream([compressed], name="a.obj.gz"))
    with pytest.raises(LoadError, match="bytes unpacked"):
        sl.load_scene(Stream([compressed], name="a.obj.gz"), limits=sl.Limits(size=10 << 20))


def test_headers_that_lie_about_sizes():
    data = zipped({"a.obj": bytes(64 << 20)})
    lie = data.replace((64 << 20).to_bytes(4, "little"), (100).to_bytes(4, "little"))
    with pytest.raises(LoadError):
        loaded(lie, "zip")
    many = zipped({f"{k}.txt": b"" for k in range(2000)})
    with pytest.raises(LoadError, match="at most 1,000 files"):
        loaded(many, "zip", limits=sl.Limits(entries=1000))
    with pytest.raises(LoadError, match="at most 1,000 files"):
        loaded(tarred({f"{k}.txt": b"" for k in range(2000)}), "tgz", limits=sl.Limits(entries=1000))


def test_files_beside_are_read_within_the_folder_alone(tmp_path):
    box = trimesh.creation.box().export(file_type="gltf")
    folder = tmp_path / "models"
    folder.mkdir()
    for name, data in box.items():
        (folder / name).write_bytes(data)
    assert sl.load_scene(folder / "model.gltf").triangle_count == 12
    buffer = next(name for name in box if name.endswith(".bin"))
    (folder / buffer).rename(tmp_path / buffer)
    for reference in (f"../{buffer}", str(tmp_path / buffer), f"file://{tmp_path / buffer}"):
        (folder / "model.gltf").write_bytes(box["model.gltf"].replace(buffer.encode(), reference.encode()))
        with pytest.raises(LoadError):
            sl.load_scene(folder / "model.gltf")
    (folder / buffer).symlink_to(tmp_path / buffer)
    (folder / "model.gltf").write_bytes(box["model.gltf"])
    with pytest.raises(LoadError, match=r"outside|own folder"):
        sl.load_scene(folder / "model.gltf")


def test_warnings_point_at_the_call():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sl.load_scene(OBJ + b"p 1\n", kind="obj")
    assert caught[0].filename == __file__
