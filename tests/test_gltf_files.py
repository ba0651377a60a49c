"""Containers of glTF, URIs, versions and extensions: what is read, and what is refused by name."""

from __future__ import annotations

import base64
import json
import struct

import numpy as np
import pytest
from gltf_support import TRIANGLE, Gltf, glb_of, loaded, told, written

import shadowlab as sl
from shadowlab.errors import LoadError, SceneError


def plain(**top) -> Gltf:
    gltf = Gltf(**top)
    return gltf.scene(gltf.node(mesh=gltf.mesh(name="thing")))


def beside(tmp_path, uri, file=None) -> bytes:
    """A text whose buffer is at a URI, with the file written."""
    gltf = plain()
    gltf.document()["buffers"][0]["uri"] = uri
    if file is not None:
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_bytes(gltf.data)
    return json.dumps(gltf.json).encode()


@pytest.mark.parametrize(
    ("uri", "file"),
    [
        ("a.bin", "a.bin"),
        ("b%20c.bin", "b c.bin"),
        ("b c.bin", "b c.bin"),
        ("100%25.bin", "100%.bin"),
        ("a%20b.bin", "a%20b.bin"),
        ("sub/a.bin", "sub/a.bin"),
        ("./sub/../a.bin", "a.bin"),
        ("b%C3%BCrste.bin", "bürste.bin"),
        ("bürste.bin", "bürste.bin"),
    ],
)
def test_buffers_beside_the_file(tmp_path, uri, file):
    assert loaded(tmp_path, beside(tmp_path, uri, file), "scene.gltf").triangle_count == 1


@pytest.mark.parametrize(
    "uri", ["gone.bin", "../up.bin", "/etc/passwd", "http://example.com/a.bin", "file:///a.bin", ""]
)
def test_buffers_that_are_missing_or_elsewhere(tmp_path, uri):
    (tmp_path / "in").mkdir()
    (tmp_path / "up.bin").write_bytes(b"\0" * 99)
    with pytest.raises(LoadError, match=r"scene\.gltf"):
        loaded(tmp_path / "in", beside(tmp_path, uri), "scene.gltf")


@pytest.mark.parametrize(
    "head",
    [
        "data:application/octet-stream;base64,",
        "data:;base64,",
        "DATA:application/gltf-buffer;charset=utf-8;BASE64,",
        "data:application/octet-stream,",
        "data:,",
    ],
)
def test_data_uris(tmp_path, head):
    gltf = plain()
    packed = "base64" in head.lower()
    body = base64.b64encode(gltf.data).decode() if packed else "".join(f"%{byte:02x}" for byte in gltf.data)
    document = {**gltf.document(), "buffers": [{"byteLength": len(gltf.data), "uri": head + body}]}
    assert loaded(tmp_path, json.dumps(document).encode(), "scene.gltf").triangle_count == 1
    if packed:
        document["buffers"][0]["uri"] = head + body.rstrip("=").replace("/", "%2F")
        assert loaded(tmp_path, json.dumps(document).encode(), "scene.gltf").triangle_count == 1
    document["buffers"][0]["uri"] = (head + body)[: -len(body) // 2]
    with pytest.raises(LoadError, match=r"buffers\[0\]"):
        loaded(tmp_path, json.dumps(document).encode(), "scene.gltf")


@pytest.mark.parametrize("uri", ["data:;base64,####", "data:nothing", 5, None])
def test_broken_uris(tmp_path, uri):
    with pytest.raises(LoadError, match=r"buffers\[0\].*uri"):
        loaded(tmp_path, beside(tmp_path, uri), "scene.gltf")


def test_text_with_a_byte_order_mark_and_names_in_any_script(tmp_path):
    gltf = Gltf()
    gltf.scene(gltf.node(mesh=gltf.mesh(name="塔 🌲"), name="ünder"))
    text = json.dumps(json.loads(gltf.text()), ensure_ascii=False).encode()
    for data in (text, b"\xef\xbb\xbf" + text):
        assert loaded(tmp_path, data, "scene.gltf").triangle_count == 1
    gltf.json["meshes"][0]["primitives"][0]["indices"] = gltf.accessor([0, 1, 9], "u2")
    gltf.json.pop("buffers", None)
    with pytest.raises(SceneError, match="塔 🌲"):
        loaded(tmp_path, gltf)
    for data in (text.decode().encode("utf-16"), text.replace("塔".encode(), b"\xff\xfe")):
        with pytest.raises(LoadError, match="UTF-8"):
            loaded(tmp_path, data, "scene.gltf")


def test_the_content_decides_not_the_ending(tmp_path):
    assert loaded(tmp_path, plain().glb(), "scene.gltf").triangle_count == 1
    assert loaded(tmp_path, plain().text(), "scene.glb").triangle_count == 1
    assert loaded(tmp_path, plain().text(), "SCENE.GLTF").triangle_count == 1


def test_binary_files_with_more_in_them(tmp_path):
    chunk = (0x12345678, b"anything")
    assert loaded(tmp_path, plain().glb(chunk, chunk)).triangle_count == 1
    assert loaded(tmp_path, plain().glb() + b"after the end").triangle_count == 1
    # The first of two binary chunks is the buffer.
    assert loaded(tmp_path, plain().glb((0x004E4942, b"\0" * 8))).triangle_count == 1
    # No binary chunk, but a buffer in the text.
    assert loaded(tmp_path, glb_of(plain().text(), b"")).triangle_count == 1


def lying(at: int, value: int):
    """A binary file with a number of its structure replaced."""
    data = bytearray(plain().glb())
    struct.pack_into("<I", data, at, value)
    return bytes(data)


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (lying(4, 1), "version 2 of the binary container, got 1"),
        (lying(8, 10**6), "1,000,000 bytes.*truncated"),
        (lying(8, 16), "chunk"),
        (lying(12, 2**32 - 1), "chunk of 4,294,967,295 bytes"),
        (lying(12, 20), "JSON"),
        (lying(16, 7), "JSON in its first chunk"),
        (plain().glb()[:-8], "truncated"),
        (plain().glb()[:20], "truncated"),
        (b"glTF", "header"),
        (b"", "JSON"),
        (b"glTF" + struct.pack("<II", 2, 12), "chunk of JSON"),
        (b"[]", "JSON object"),
        (b"{", "JSON"),
        (b"null", "JSON object"),
        (b'{"asset": {"version": "2.0"}, "a": NaN}', "NaN"),
        (b'{"a": ' + b"9" * 5000 + b"}", "JSON"),
        (b'{"a": ' * 100_000, "nested too deeply|JSON"),
        (b"[" * 1_000_000, "nested too deeply|JSON"),
    ],
)
def test_broken_files(tmp_path, data, match):
    with pytest.raises(LoadError, match=match):
        loaded(tmp_path, data)


def test_buffers_that_are_shorter_than_they_say(tmp_path):
    gltf = plain()
    gltf.document()["buffers"][0]["byteLength"] = 4000
    with pytest.raises(LoadError, match=r"buffers\[0\].*4,000 bytes, got 36"):
        loaded(tmp_path, gltf)
    gltf.json["buffers"][0]["byteLength"] = 10**12
    with pytest.raises(LoadError, match="size"):
        loaded(tmp_path, gltf)
    for broken in ({}, {"byteLength": "36"}, {"byteLength": 0}):
        gltf.json["buffers"] = [broken]
        with pytest.raises(LoadError, match="byteLength"):
            loaded(tmp_path, gltf)
    gltf.json["buffers"] = [{"byteLength": 36}]
    with pytest.raises(LoadError, match="URI or a binary chunk"):
        loaded(tmp_path, json.dumps(gltf.json).encode(), "scene.gltf")


def test_a_buffer_that_nothing_takes_may_be_missing(tmp_path):
    gltf = plain()
    gltf.document()["buffers"].append({"byteLength": 9, "uri": "sounds.bin"})
    gltf.add("bufferViews", buffer=1, byteLength=9)
    gltf.add("accessors", bufferView=1, count=1, type="SCALAR", componentType=5126)
    assert loaded(tmp_path, gltf).triangle_count == 1


@pytest.mark.parametrize(
    ("asset", "good"),
    [
        ({"version": "2.0"}, True),
        ({"version": "2.1"}, True),
        ({"version": "2.1", "minVersion": "2.0"}, True),
        ({"version": "2.1", "minVersion": "2.1"}, False),
        ({"version": "1.0"}, False),
        ({"version": "3.0"}, False),
        ({"version": "20.0"}, False),
        ({"version": 2.0}, False),
        ({"version": "2"}, False),
        ({"version": "9" * 5000 + ".0"}, False),
        ({}, False),
        (None, False),
        ("2.0", False),
    ],
)
def test_versions(tmp_path, asset, good):
    gltf = plain()
    gltf.json["asset"] = asset
    if good:
        assert loaded(tmp_path, gltf).triangle_count == 1
    else:
        with pytest.raises(LoadError, match="asset"):
            loaded(tmp_path, gltf)
    if asset is None:
        del gltf.json["asset"]
        with pytest.raises(LoadError, match="version of glTF"):
            loaded(tmp_path, gltf)


@pytest.mark.parametrize(
    "name", ["KHR_whatever", "CESIUM_RTC", "KHR_gaussian_splatting", "EXT_mesh_primitive_restart", "MSFT_lod"]
)
def test_extensions_that_are_not_read(tmp_path, name):
    with pytest.raises(LoadError, match=name):
        loaded(tmp_path, plain(extensionsUsed=[name], extensionsRequired=[name]))
    # Before anything else is looked at.
    gltf = plain(extensionsUsed=[name], extensionsRequired=[name])
    gltf.json.update(nodes=7, meshes="?")
    with pytest.raises(LoadError, match=name):
        loaded(tmp_path, gltf)
    scene, text = told(tmp_path, plain(extensionsUsed=["KHR_materials_unlit", name]))
    assert scene.triangle_count == 1
    assert name in text
    assert "unlit" not in text


@pytest.mark.parametrize(
    "name",
    ["KHR_materials_unlit", "KHR_materials_transmission", "KHR_texture_transform", "KHR_texture_basisu",
     "KHR_mesh_quantization", "KHR_xmp_json_ld",
     "KHR_node_visibility", "EXT_texture_webp", "KHR_lights_punctual",
     "KHR_animation_pointer"],
)  # fmt: skip
def test_extensions_that_are_silent(tmp_path, name):
    assert loaded(tmp_path, plain(extensionsUsed=[name], extensionsRequired=[name])).triangle_count == 1


@pytest.mark.parametrize("names", ["KHR_a", [3], {"a": 1}, None])
def test_lists_of_extensions_that_are_none(tmp_path, names):
    with pytest.raises(LoadError, match="extensionsUsed"):
        loaded(tmp_path, plain(extensionsUsed=names))


@pytest.mark.parametrize("key", ["nodes", "meshes", "scenes", "accessors", "bufferViews", "buffers"])
@pytest.mark.parametrize("value", [5, {"0": {}}, [5], "text", None])
def test_lists_that_are_none(tmp_path, key, value):
    gltf = plain()
    gltf.document()[key] = value
    with pytest.raises(LoadError, match=key):
        loaded(tmp_path, gltf)


def test_empty_documents(tmp_path):
    for document in (Gltf(), Gltf(scenes=[{}]), Gltf(nodes=[{}]), Gltf(nodes=[], meshes=[])):
        with pytest.raises(SceneError, match="no usable triangle"):
            loaded(tmp_path, json.dumps(document.json).encode(), "scene.gltf")


def test_a_mesh_is_taken_as_it_was_written(tmp_path):
    """Up, source and recipe as of every file."""
    path = written(tmp_path, plain())
    scene = sl.load_scene(path, up="z")
    np.testing.assert_allclose(scene.bounds, [[0, 0, -1], [1, 0, 0]], atol=1e-6)
    assert scene.source == str(path)
    assert eval(scene.recipe, {"sl": sl}) == scene
    assert len(TRIANGLE) == 3


def test_objects_beyond_the_limit_are_refused_before_they_are_read(tmp_path):
    gltf = plain(extras=[{}] * 100)
    path = written(tmp_path, gltf.text(), "scene.gltf")
    most = path.read_bytes().count(b"{") + path.read_bytes().count(b"[")
    assert sl.load_scene(path, limits=sl.Limits(objects=most)).triangle_count == 1
    with pytest.raises(LoadError, match=r"objects and lists, got .*Limits\(objects=...\)"):
        sl.load_scene(path, limits=sl.Limits(objects=most - 1))
