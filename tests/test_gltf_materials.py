"""Alpha tests of glTF materials: what is collected, what is opaque, what is left out, and what is said."""

from __future__ import annotations

import io

import numpy as np
import pytest
from gltf_support import TRIANGLE, Gltf, loaded, told
from PIL import Image

from shadowlab.errors import LoadError, SceneError
from shadowlab.scene.formats.given import Given
from shadowlab.scene.formats.limits import Limits
from shadowlab.scene.gltf.items import JsonObject
from shadowlab.scene.gltf.reader import read_gltf

UV = [[0, 0], [1, 0], [0, 1]]
#: Alpha of two rows of three texels.
ALPHA = np.array([[0, 128, 255], [255, 64, 0]], np.uint8)


def png(alpha, mode="RGBA", kind="PNG"):
    rgba = np.full((*alpha.shape, 4), 200, np.uint8)
    rgba[..., 3] = alpha
    data = io.BytesIO()
    Image.fromarray(rgba, "RGBA").convert(mode).save(data, kind, **({"lossless": True} if kind == "WEBP" else {}))
    return data.getvalue()


def leaf(image=None, *, base=None, texture=None, info=None, attributes=None, uv=UV, **material) -> Gltf:
    """An opaque triangle, and one with a material and, if an image is given, a texture."""
    gltf = Gltf()
    gltf.mesh(np.array(TRIANGLE) * 5, name="solid")
    own = dict(attributes or {})
    pbr = {} if base is None else {"baseColorFactor": base}
    if image is not None:
        gltf.add("images", bufferView=gltf.view(image), mimeType="image/png")
        gltf.add("textures", **{"source": 0, **(texture or {})})
        pbr["baseColorTexture"] = {"index": 0, **(info or {})}
        own.setdefault("TEXCOORD_0", gltf.accessor(uv))
    made = {name: value if isinstance(value, int) else gltf.accessor(*value) for name, value in own.items()}
    gltf.add("materials", name="foliage", pbrMetallicRoughness=pbr, **material)
    gltf.mesh(TRIANGLE, attributes=made, material=0, name="leaf")
    return gltf.scene(gltf.node(mesh=0), gltf.node(mesh=1))


def collected(tmp_path, gltf):
    """The only alpha test."""
    path = tmp_path / "scene.glb"
    path.write_bytes(gltf.glb())
    tests = [mesh.alpha for mesh in read_gltf(Given.of_file(path, "glb", Limits())).meshes.values()]
    (test,) = [test for test in tests if test is not None]
    return test


def test_a_mask_is_an_alpha_test(tmp_path):
    gltf = leaf(png(ALPHA), alphaMode="MASK", alphaCutoff=0.25, base=[1, 1, 1, 0.75])
    test = collected(tmp_path, gltf)
    np.testing.assert_array_equal(test.texture, ALPHA)
    assert test.texture.dtype == np.uint8
    np.testing.assert_array_equal(test.uv, np.array(UV, np.float32))
    assert test.uv.dtype == np.float32
    assert (test.cutoff, test.factor, test.wrap) == (0.25, 0.75, ("repeat", "repeat"))
    scene, text = told(tmp_path, gltf)
    assert scene.triangle_count == 2
    assert "foliage" not in text


def test_the_default_cutoff_and_samplers(tmp_path):
    gltf = leaf(png(ALPHA), alphaMode="MASK", texture={"sampler": 0})
    gltf.add("samplers", wrapS=33071, wrapT=33648)
    test = collected(tmp_path, gltf)
    assert (test.cutoff, test.wrap) == (0.5, ("clamp", "mirror"))
    gltf.json["samplers"][0]["wrapS"] = 9
    with pytest.raises(LoadError, match="wrapS"):
        loaded(tmp_path, gltf)


@pytest.mark.parametrize("kind", ["u1", "u2"])
def test_quantised_coordinates_of_another_set_and_a_transform(tmp_path, kind):
    most = np.iinfo(kind).max
    gltf = leaf(png(ALPHA), alphaMode="MASK", info={"texCoord": 1})
    at = gltf.accessor(np.array(UV) * most, kind, normalized=True)
    gltf.json["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_1"] = at
    np.testing.assert_allclose(collected(tmp_path, gltf).uv, UV, atol=1e-6)
    # The example of KHR_texture_transform: the lower left quadrant, turned.
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
        "KHR_texture_transform": transform
    }
    np.testing.assert_allclose(collected(tmp_path, gltf).uv, [[0, 1], [0, 0.5], [0.5, 1]], atol=1e-6)
    # Its set of coordinates counts before the other.
    transform["texCoord"] = 0
    transform.pop("rotation")
    np.testing.assert_allclose(collected(tmp_path, gltf).uv, [[0, 1], [0.5, 1], [0, 1.5]], atol=1e-6)


@pytest.mark.parametrize("kind", ["WEBP", "PNG"])
@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_kinds_of_images(tmp_path, kind, mode):
    if (kind, mode) == ("WEBP", "LA"):
        mode = "RGBA"
    np.testing.assert_array_equal(collected(tmp_path, leaf(png(ALPHA, mode, kind), alphaMode="MASK")).texture, ALPHA)


def test_palettes_with_a_transparent_colour_and_images_beside_the_file(tmp_path):
    picture = Image.fromarray(np.array([[0, 1], [1, 1]], np.uint8), "P")
    picture.putpalette([0, 0, 0, 255, 255, 255])
    data = io.BytesIO()
    picture.save(data, "PNG", transparency=0)
    gltf = leaf(b"", alphaMode="MASK")
    (tmp_path / "a leaf.png").write_bytes(data.getvalue())
    gltf.json["images"] = [{"uri": "a%20leaf.png"}]
    np.testing.assert_array_equal(collected(tmp_path, gltf).texture, [[0, 255], [255, 255]])


@pytest.mark.parametrize(
    "gltf",
    [
        leaf(alphaMode="MASK"),
        leaf(alphaMode="MASK", base=[1, 1, 1, 0.5]),
        leaf(png(ALPHA), alphaMode="OPAQUE"),
        leaf(png(ALPHA)),
        leaf(png(ALPHA), alphaMode="MASK", alphaCutoff=0),
        leaf(png(np.full((2, 2), 255, np.uint8)), alphaMode="MASK"),
        leaf(png(ALPHA, "RGB"), alphaMode="MASK"),
        leaf(png(np.full((2, 2), 200, np.uint8)), alphaMode="MASK"),
    ],
)
def test_what_discards_nothing_is_opaque_in_silence(tmp_path, gltf):
    assert loaded(tmp_path, gltf).triangle_count == 2


@pytest.mark.parametrize(
    "gltf",
    [
        leaf(alphaMode="MASK", base=[1, 1, 1, 0.49]),
        leaf(alphaMode="MASK", alphaCutoff=1.5),
        leaf(png(ALPHA), alphaMode="MASK", base=[1, 1, 1, 0.25]),
        leaf(png(ALPHA * 0), alphaMode="MASK"),
        leaf(alphaMode="MASK", attributes={"COLOR_0": ([[1, 1, 1, 0.25]] * 3,)}),
    ],
)
def test_what_discards_everything_is_left_out(tmp_path, gltf):
    scene, text = told(tmp_path, gltf)
    assert scene.triangle_count == 1
    assert "left out leaf" in text
    gltf.json["scenes"][0]["nodes"] = [1]
    with pytest.raises(SceneError, match="discards all"):
        loaded(tmp_path, gltf)


def test_alpha_of_vertices(tmp_path):
    colors = {"COLOR_0": ([[255, 0, 0, 0], [0, 0, 0, 102], [0, 0, 0, 255]], "u1")}
    gltf = leaf(alphaMode="MASK", attributes=colors)
    gltf.json["accessors"][1]["normalized"] = True
    test = collected(tmp_path, gltf)
    # Alpha is the coordinate: the texture read there has it.
    columns = test.uv[:, 0] * test.texture.shape[1] - 0.5
    np.testing.assert_allclose(np.interp(columns, np.arange(256), test.texture[0]), [0, 102, 255], atol=1e-3)
    # The same for all vertices multiplies the factor; three components have no alpha.
    gltf = leaf(png(ALPHA), alphaMode="MASK", base=[1, 1, 1, 0.8], attributes={"COLOR_0": ([[1, 1, 1, 0.75]] * 3,)})
    assert collected(tmp_path, gltf).factor == pytest.approx(0.6)
    assert loaded(tmp_path, leaf(alphaMode="MASK", attributes={"COLOR_0": ([[0, 0, 0]] * 3,)})).triangle_count == 2


def test_blending_and_images_that_are_not_read_are_told(tmp_path):
    _, text = told(tmp_path, leaf(png(ALPHA), alphaMode="BLEND"))
    assert "blended material foliage is opaque here" in text
    for image in (b"no image", png(ALPHA)[:60]):
        scene, text = told(tmp_path, leaf(image, alphaMode="MASK"))
        assert scene.triangle_count == 2
        assert "foliage" in text
    gltf = leaf(png(ALPHA), alphaMode="MASK")
    gltf.json["images"] = [{"uri": "gone.png"}]
    assert "gone.png" in told(tmp_path, gltf)[1]
    gltf = leaf(png(ALPHA), alphaMode="MASK")
    gltf.json["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    assert "format" in told(tmp_path, gltf)[1]
    gltf.json["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    np.testing.assert_array_equal(collected(tmp_path, gltf).texture, ALPHA)


def test_an_older_kind_of_material(tmp_path):
    gltf = leaf(png(ALPHA), alphaMode="MASK")
    material = gltf.json["materials"][0]
    older = {
        "diffuseFactor": [1, 1, 1, 0.9],
        "diffuseTexture": material.pop("pbrMetallicRoughness")["baseColorTexture"],
    }
    material["extensions"] = {"KHR_materials_pbrSpecularGlossiness": older}
    test = collected(tmp_path, gltf)
    assert test.factor == 0.9
    np.testing.assert_array_equal(test.texture, ALPHA)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda j: j["materials"][0].update(alphaMode="CUT"), "alphaMode"),
        (lambda j: j["materials"][0].update(alphaCutoff="0.5"), "alphaCutoff"),
        (lambda j: j["materials"][0]["pbrMetallicRoughness"].update(baseColorFactor=[1, 1, 1]), "baseColorFactor"),
        (lambda j: j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].update(index=4), "index"),
        (lambda j: j["textures"][0].update(source=4), "source"),
        (lambda j: j["meshes"][1]["primitives"][0].update(material=4), "material"),
        (lambda j: j["meshes"][1]["primitives"][0]["attributes"].pop("TEXCOORD_0"), "TEXCOORD_0"),
        (lambda j: j["materials"][0].update(pbrMetallicRoughness=[]), "pbrMetallicRoughness"),
    ],
)
def test_broken_materials(tmp_path, change, match):
    gltf = leaf(png(ALPHA), alphaMode="MASK")
    change(gltf.json)
    with pytest.raises(LoadError, match=match):
        loaded(tmp_path, gltf)


def test_images_count_against_the_limits(tmp_path):
    gltf = leaf(png(np.tile(ALPHA, (40, 40))), alphaMode="MASK")
    path = tmp_path / "scene.glb"
    path.write_bytes(gltf.glb())
    with pytest.raises(LoadError, match=r"pixels in images\[0\].*elements"):
        read_gltf(Given.of_file(path, "glb", Limits(elements=1000)))


def test_lists_are_made_once_however_many_materials_there_are(tmp_path, monkeypatch):
    gltf = leaf(png(ALPHA), alphaMode="MASK")
    for _ in range(5):
        gltf.json["meshes"].append(gltf.json["meshes"][1])
        gltf.json["scenes"][0]["nodes"].append(gltf.node(mesh=len(gltf.json["meshes"]) - 1))
    asked = []
    items = JsonObject.items
    monkeypatch.setattr(JsonObject, "items", lambda self, key: asked.append(self.where + key) or items(self, key))
    scene = loaded(tmp_path, gltf)
    assert sum(mesh.alpha is not None for mesh in scene.meshes) == 6
    assert [asked.count(key) for key in ("textures", "images", "samplers", "materials")] == [1, 1, 1, 1]
