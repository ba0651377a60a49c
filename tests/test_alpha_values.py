"""Alpha tests as values: what is refused, equality, pickles, hashes, and what other programs' materials become."""

from __future__ import annotations

import pickle
import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from conftest import imported
from foliage_support import FACES, bars, fence, floor, square, unit
from PIL import Image
from travel_support import alpha_tests, bits, leafy_scene

import shadowlab as sl
from shadowlab import _core
from shadowlab.errors import ArgumentError, ShadowlabWarning, StateError

LEAF = square((-1, 0, 0), (2, 0, 0), (0, 2, 0))
IMAGE = np.random.default_rng(6).integers(0, 256, (5, 7, 4)).astype(np.uint8)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("texture", np.zeros((3, 3))),
        ("texture", np.zeros((3, 3, 4), np.uint8)),
        ("texture", np.zeros((0, 3), np.uint8)),
        ("texture", "leaf.png"),
        ("uv", [[0, np.nan]]),
        ("uv", [[0, 1e39]]),
        ("uv", [[0, 1, 2]]),
        ("uv", [["0", "1"]]),
        ("uv", [[0, 1], [2]]),
        ("uv", None),
        ("cutoff", np.nan),
        ("cutoff", -0.1),
        ("cutoff", "half"),
        ("cutoff", None),
        ("cutoff", True),
        ("factor", np.inf),
        ("factor", 1j),
        ("wrap", "repeat"),
        ("wrap", ("repeat",)),
        ("wrap", ("repeat", "border")),
        ("wrap", (1, 2)),
    ],
)
def test_what_no_test_is_made_of_names_the_argument(name, value):
    arguments = {"texture": np.zeros((2, 2), np.uint8), "uv": unit()}
    with pytest.raises(ArgumentError, match=name):
        sl.AlphaTest(**{**arguments, name: value})


def test_a_mesh_takes_anything_with_the_fields_and_nothing_else():
    alpha = bars()
    like = SimpleNamespace(**{name: getattr(alpha, name) for name in ("texture", "uv", "cutoff", "wrap", "factor")})
    assert _core.Mesh(LEAF, FACES, alpha=like) == _core.Mesh(LEAF, FACES, alpha=alpha)
    for wrong in ("leaf", 7, np.zeros((4, 2)), SimpleNamespace(texture=None)):
        with pytest.raises(ArgumentError, match="alpha"):
            _core.Mesh(LEAF, FACES, alpha=wrong)
    for name, value in [
        ("uv", unit()[:3]),
        ("uv", "none"),
        ("uv", np.full((4, 2), np.inf)),
        ("texture", np.zeros((2, 2, 2), np.uint8)),
        ("texture", np.zeros((0, 2), np.uint8)),
        ("wrap", ("up", "down")),
        ("wrap", None),
        ("cutoff", -1.0),
        ("cutoff", "half"),
        ("factor", np.nan),
    ]:
        with pytest.raises(ArgumentError, match=f"alpha.{name}"):
            _core.Mesh(LEAF, FACES, alpha=SimpleNamespace(**{**vars(like), name: value}))


def test_values_cannot_be_written_into():
    alpha = bars()
    for array in (alpha.texture, alpha.uv):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(AttributeError):
        alpha.cutoff = 1
    given = np.zeros((2, 2), np.uint8)
    kept = sl.AlphaTest(given, unit())
    given[:] = 255
    assert not kept.texture.any()


def test_meshes_tell_their_test_and_keep_it_through_scenes():
    alpha = bars(cutoff=0.3, factor=0.8)
    mesh = _core.Mesh(LEAF, FACES, alpha=alpha)
    assert mesh.alpha == alpha
    assert _core.Mesh(LEAF, FACES).alpha is None
    scene = sl.Scene.from_arrays(LEAF, FACES, alpha=alpha)
    for kept in (scene, scene.transformed(np.diag([2, 1, 1, 1])), scene + floor(), scene.with_ground()):
        assert kept.meshes[0].alpha == alpha
    # Vertices that no face uses are gone, and so are their coordinates.
    more = sl.AlphaTest(None, np.arange(10).reshape(5, 2))
    kept = _core.Mesh([*LEAF, [9, 9, 9]], [[4 - 1, 0, 1]], alpha=more).alpha
    np.testing.assert_array_equal(kept.uv, more.uv[[3, 0, 1]])


def test_content_counts_and_meshes_without_a_test_are_as_before():
    plain = sl.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1, 2]])
    found = [plain] + [
        sl.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1, 2]], alpha=alpha)
        for alpha in (
            sl.AlphaTest(None, [[0, 0], [1, 0], [0, 1]]),
            sl.AlphaTest(None, [[0, 0], [1, 0], [0, 1]], 0.25),
            sl.AlphaTest(None, [[0, 0], [1, 0], [0, 1]], factor=0.5),
            sl.AlphaTest(None, [[0, 0], [1, 0], [0, 1]], wrap=("repeat", "clamp")),
            sl.AlphaTest(np.full((1, 2), 255, np.uint8), [[0, 0], [1, 0], [0, 1]]),
            sl.AlphaTest(np.full((2, 1), 255, np.uint8), [[0, 0], [1, 0], [0, 1]]),
            sl.AlphaTest(None, [[0, 0], [1, 0], [0, 2]]),
        )
    ]
    assert len({scene.content_hash for scene in found}) == len(found)
    assert len(set(found)) == len(found)
    assert pickle.loads(pickle.dumps(found[3])) == found[3]
    # An opaque mesh has a state of version 1, which older versions read.
    assert plain.meshes[0].__reduce__()[1][1] == 1
    assert found[1].meshes[0].__reduce__()[1][1] == 2


def test_memory_counts_the_test():
    texture = np.zeros((512, 512), np.uint8)
    alpha = sl.AlphaTest(texture, unit())
    more = _core.Mesh(LEAF, FACES, alpha=alpha).memory - _core.Mesh(LEAF, FACES).memory
    assert texture.nbytes + alpha.uv.nbytes <= more < texture.nbytes + alpha.uv.nbytes + 1024


def test_states_come_back_bit_for_bit_and_textures_are_stored_once():
    scene = leafy_scene()
    back = pickle.loads(pickle.dumps(scene))
    assert back == scene
    assert [mesh.alpha for mesh in back.meshes] == [mesh.alpha for mesh in scene.meshes]
    assert bits(back.meshes[0].alpha.uv) == bits(scene.meshes[0].alpha.uv)
    texture = np.random.default_rng(0).integers(0, 256, (400, 400)).astype(np.uint8)
    leaves = [_core.Mesh(LEAF + k, FACES, alpha=sl.AlphaTest(texture, unit())) for k in range(20)]
    assert len(pickle.dumps(sl.Scene(leaves, range(20), [np.eye(4)] * 20))) < 1.2 * texture.nbytes


@pytest.mark.parametrize("value", [leafy_scene().meshes[2], _core.Scene(leafy_scene())])
def test_damaged_states_are_refused(value):
    function, (name, version, head, *arrays) = value.__reduce__()
    assert function(name, version, head, *arrays) == value
    for i, array in enumerate(arrays):
        for wrong in (array[:-1], np.concatenate([array, array]), array.astype(np.float16), None):
            if isinstance(wrong, np.ndarray) and wrong.shape == array.shape and wrong.dtype == array.dtype:
                continue
            with pytest.raises(StateError):
                function(name, version, head, *arrays[:i], wrong, *arrays[i + 1 :])
        if array.size:
            changed = array.copy()
            changed.view(np.uint8).reshape(-1)[0] ^= 1
            with pytest.raises(StateError):
                function(name, version, head, *arrays[:i], changed, *arrays[i + 1 :])
    for other in (0, 1, 3):
        with pytest.raises(StateError):
            function(name, other, head, *arrays)
    with pytest.raises(StateError):
        function(name, version, head, *arrays[:-5])


def trimesh_leaf(**material):
    """A leaf as trimesh has it: the origin of texture coordinates is at the lower left."""
    settings = {"alphaMode": "MASK", "baseColorTexture": Image.fromarray(IMAGE)} | material
    uv = unit() * [1, -1] + [0, 1]
    visual = trimesh.visual.TextureVisuals(uv=uv, material=trimesh.visual.material.PBRMaterial(**settings))
    return trimesh.Trimesh(LEAF, FACES, visual=visual, process=False)


def test_masked_materials_of_trimesh():
    def alpha(**material):
        return sl.Scene.from_trimesh(trimesh_leaf(**material)).meshes[0].alpha

    assert alpha() == sl.AlphaTest(IMAGE[..., 3], unit())
    assert alpha(alphaCutoff=0.2) == sl.AlphaTest(IMAGE[..., 3], unit(), 0.2)
    half = alpha(baseColorFactor=[1.0, 1.0, 1.0, 0.5])
    assert half.factor == pytest.approx(0.5, abs=1 / 255)
    assert alpha(baseColorTexture=Image.fromarray(IMAGE[..., :3])).texture is None
    palette = Image.fromarray(IMAGE[..., :3]).convert("P")
    palette.info["transparency"] = 0
    assert set(np.unique(alpha(baseColorTexture=palette).texture)) <= {0, 255}
    for mode in ("OPAQUE", "BLEND", None):
        assert alpha(alphaMode=mode) is None
    scene = trimesh.Scene({"leaf": trimesh_leaf()})
    assert sl.Scene.from_trimesh(scene).meshes[0].alpha == sl.AlphaTest(IMAGE[..., 3], unit())
    bare = trimesh_leaf()
    bare.visual.uv = None
    with pytest.warns(ShadowlabWarning, match="texture coordinates"):
        assert sl.Scene.from_trimesh(bare).meshes[0].alpha is None


def test_a_glb_that_trimesh_wrote(tmp_path):
    path = tmp_path / "leaf.glb"
    trimesh.Scene({"leaf": trimesh_leaf(alphaCutoff=0.25)}).export(path)
    found = sl.Scene.from_trimesh(trimesh.load(path)).meshes[0].alpha
    np.testing.assert_array_equal(found.texture, IMAGE[..., 3])
    np.testing.assert_allclose(found.uv, unit(), atol=1e-6)
    assert found.cutoff == 0.25


def test_the_way_to_trimesh_leaves_tests_out_and_says_so():
    with pytest.warns(ShadowlabWarning, match="alpha tests of 1 of 2 meshes"):
        there = fence().to_trimesh()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert all(mesh.alpha is None for mesh in sl.Scene.from_trimesh(there).meshes)
        floor().to_trimesh()


def test_masked_materials_of_pyrender():
    imported("pyrender")
    from peers import pyrender_shim

    pyrender_shim.install()
    pyrender = sys.modules["pyrender"]
    sampler = pyrender.Sampler(wrapS=33071, wrapT=33648)
    for source in (IMAGE, Image.fromarray(IMAGE)):
        texture = pyrender.Texture(source=source, source_channels="RGBA", sampler=sampler)
        material = pyrender.MetallicRoughnessMaterial(
            alphaMode="MASK", alphaCutoff=0.3, baseColorTexture=texture, baseColorFactor=[1.0, 1.0, 1.0, 0.7]
        )
        uv = unit() * [1, -1] + [0, 1]
        primitive = pyrender.Primitive(LEAF, indices=FACES, texcoord_0=uv, material=material)
        found = sl.Scene.from_trimesh(pyrender.Mesh([primitive])).meshes[0].alpha
        assert found.wrap == ("clamp", "mirror")
        assert (found.cutoff, found.factor) == (0.3, pytest.approx(0.7))
        np.testing.assert_array_equal(found.texture, IMAGE[..., 3])
        np.testing.assert_allclose(found.uv, unit(), atol=1e-6)


def test_repr_tells_sizes():
    assert repr(alpha_tests()[1]).startswith("AlphaTest(texture=3x2, uv of 4 vertices, cutoff=0.5")
