"""Morph targets and skins of glTF, against numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest
from gltf_support import TRIANGLE, Gltf, corners, loaded, told

from shadowlab.errors import LoadError, SceneError

ROUNDING = 2.0**-22
HALF = np.sqrt(0.5)
#: A quarter turn about z: x becomes y.
QUARTER = [0, 0, HALF, HALF]
#: A square of side 2 about the origin, in x, y.
SQUARE = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
FACES = [0, 1, 2, 0, 2, 3]


def square(**fields) -> tuple[Gltf, int]:
    gltf = Gltf(**fields)
    return gltf, gltf.mesh(SQUARE, FACES, name="square")


def box(scene):
    return scene.bounds[:, :2].ravel().round(6).tolist()


def morphing(weights, node_weights=None, **second):
    gltf = Gltf()
    up = gltf.accessor([[0, 0, 0], [0, 0, 0], [0, 2, 0], [0, 2, 0]])
    wide = gltf.accessor(np.zeros((4, 3)), bufferView=None, sparse=gltf.sparse([1, 2], [[1, 0, 0]] * 2))
    fields = {} if weights is None else {"weights": weights}
    gltf.mesh(SQUARE, FACES, targets=[{"POSITION": up}, {"POSITION": wide}], **fields)
    gltf.node(mesh=0, **({} if node_weights is None else {"weights": node_weights}))
    return gltf.scene(0)


@pytest.mark.parametrize(
    ("weights", "node_weights", "expected"),
    [
        (None, None, [-1, -1, 1, 1]),
        ([0, 0], None, [-1, -1, 1, 1]),
        ([1, 0], None, [-1, -1, 1, 3]),
        ([0.5, 3], None, [-1, -1, 4, 2]),
        ([1, 0], [0, 1], [-1, -1, 2, 1]),
        ([1, 1], [0, 0], [-1, -1, 1, 1]),
        (None, [-1, 0], [-1, -1, 1, -1]),
    ],
)
def test_morph_targets(tmp_path, weights, node_weights, expected):
    assert box(loaded(tmp_path, morphing(weights, node_weights))) == expected


def test_morph_targets_that_are_refused(tmp_path):
    with pytest.raises(LoadError, match=r"one per weight.*which are 3, got 2"):
        loaded(tmp_path, morphing([1, 1, 1]))
    with pytest.raises(LoadError, match="weights"):
        loaded(tmp_path, morphing(["1", 0]))
    gltf = morphing([1, 0])
    gltf.json["accessors"][0]["count"] = 3
    with pytest.raises(LoadError, match="expected 4 elements"):
        loaded(tmp_path, gltf)


def test_weights_without_targets_are_told(tmp_path):
    gltf, mesh = square()
    scene, text = told(tmp_path, gltf.scene(gltf.node(mesh=mesh, weights=[1])))
    assert box(scene) == [-1, -1, 1, 1]
    assert "square has weights and no morph targets" in text


def test_nodes_share_a_mesh_only_with_equal_weights(tmp_path):
    gltf = morphing([1, 0])
    for x, weights in ((10, None), (20, [0, 1]), (30, [0, 1])):
        gltf.node(mesh=0, translation=[x, 0, 0], **({"weights": weights} if weights else {}))
    gltf.json["scenes"][0]["nodes"] = [0, 1, 2, 3]
    scene = loaded(tmp_path, gltf)
    assert (scene.mesh_count, scene.instance_count) == (2, 4)
    assert box(scene) == [-1, -1, 32, 3]


def test_quantised_targets(tmp_path):
    gltf = Gltf()
    moves = np.zeros((3, 4), np.int8)
    moves[:, 1] = 127
    target = gltf.accessor(moves[:, :3], "i1", bufferView=gltf.view(moves.tobytes(), byteStride=4), normalized=True)
    gltf.mesh(TRIANGLE, targets=[{"POSITION": target}, {"NORMAL": target}], weights=[3, 1])
    assert box(loaded(tmp_path, gltf.scene(gltf.node(mesh=0)))) == [0, 3, 1, 4]


# A strip of four vertices: the lower pair on joint 0, the upper pair on joint 1, which stands at y = 1.
JOINTS = [[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]]
WEIGHTS = [[1, 0, 0, 0]] * 4


def skinned(
    joint_fields, *, joints=JOINTS, joint_kind="u1", weights=WEIGHTS, weight_kind="f4", inverse=True, more=None
):
    gltf = Gltf()
    scaled = np.array(weights, float)
    if weight_kind != "f4":
        scaled = np.round(scaled * np.iinfo(weight_kind).max)
    attributes = {
        "JOINTS_0": gltf.accessor(joints, joint_kind),
        "WEIGHTS_0": gltf.accessor(scaled, weight_kind, normalized=weight_kind != "f4"),
    }
    for name, (values, kind) in (more or {}).items():
        attributes[name] = gltf.accessor(values, kind)
    gltf.mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], FACES, attributes=attributes, name="arm")
    bind = np.tile(np.eye(4), (2, 1, 1))
    bind[1, 1, 3] = -1
    skin = {"joints": [0, 1]}
    if inverse:
        skin["inverseBindMatrices"] = gltf.accessor(bind.swapaxes(1, 2).reshape(2, 16))
    gltf.add("skins", **skin)
    gltf.node(children=[1])
    gltf.node(**{"translation": [0, 1, 0], **joint_fields})
    return gltf.scene(0, gltf.node(mesh=0, skin=0))


@pytest.mark.parametrize(("joint_kind", "weight_kind"), [("u1", "f4"), ("u2", "u1"), ("u1", "u2")])
def test_skins_at_rest_and_posed(tmp_path, joint_kind, weight_kind):
    kinds = {"joint_kind": joint_kind, "weight_kind": weight_kind}
    assert box(loaded(tmp_path, skinned({}, **kinds))) == [0, 0, 1, 1]
    # A quarter turn of the upper joint about (0, 1): (1, 1) goes to (0, 2).
    found = corners(loaded(tmp_path, skinned({"rotation": QUARTER}, **kinds)))
    np.testing.assert_allclose(found[0], [[0, 0, 0], [1, 0, 0], [0, 2, 0]], atol=1e-5)


def test_the_transform_of_a_skinned_node_is_ignored(tmp_path):
    gltf = skinned({})
    gltf.json["nodes"][2]["translation"] = [50, 0, 0]
    gltf.json["nodes"][0]["translation"] = [0, 7, 0]
    assert box(loaded(tmp_path, gltf)) == [0, 7, 1, 8]


def test_weights_blend_and_are_brought_to_a_sum_of_one(tmp_path):
    half = [[0.5, 0.5, 0, 0]] * 4
    pairs = [[0, 1, 0, 0]] * 4
    scene = loaded(tmp_path, skinned({"scale": [3, 1, 1]}, joints=pairs, weights=half))
    assert box(scene) == [0, 0, 2, 1]
    scene, text = told(tmp_path, skinned({"scale": [3, 1, 1]}, joints=pairs, weights=np.array(half) * 4))
    assert box(scene) == [0, 0, 2, 1]
    assert "weights of arm do not add up to 1" in text
    scene, text = told(tmp_path, skinned({"scale": [3, 1, 1]}, weights=np.zeros((4, 4))))
    assert box(scene) == [0, 0, 3, 1]
    assert "4 vertices of arm have no weights" in text


def test_a_second_set_of_joints(tmp_path):
    more = {"JOINTS_1": ([[1, 0, 0, 0]] * 4, "u1"), "WEIGHTS_1": ([[0.5, 0, 0, 0]] * 4, "f4")}
    scene = loaded(
        tmp_path, skinned({"scale": [3, 1, 1]}, joints=np.zeros((4, 4)), weights=np.array(WEIGHTS) * 0.5, more=more)
    )
    assert box(scene) == [0, 0, 2, 1]
    with pytest.raises(LoadError, match="JOINTS_1"):
        loaded(tmp_path, skinned({}, more={"WEIGHTS_1": more["WEIGHTS_1"]}))


def test_skins_that_are_refused(tmp_path):
    with pytest.raises(SceneError, match=r"arm.*joints below the 2.*got 7 at vertex 2"):
        loaded(tmp_path, skinned({}, joints=[[0] * 4, [0] * 4, [7, 0, 0, 0], [1] * 4]))
    # One without weight does not matter.
    loaded(tmp_path, skinned({}, joints=[[0, 9, 0, 0], [0, 9, 0, 0], [1, 9, 9, 9], [1, 0, 0, 0]]))
    for change, match in (
        (lambda j: j["skins"][0].update(joints=[]), "joints"),
        (lambda j: j["skins"][0].update(joints=[0, 99]), r"skins\[0\].joints\[1\]"),
        (lambda j: j["skins"][0].update(joints=[0, 1, 2]), "inverseBindMatrices: expected 3"),
        (lambda j: j["skins"][0].update(inverseBindMatrices=0), "MAT4"),
        (lambda j: j["nodes"][2].update(skin=1), "skin"),
        (lambda j: j["accessors"][0].update(count=3), "JOINTS_0: expected 4"),
    ):
        gltf = skinned({})
        change(gltf.json)
        with pytest.raises(LoadError, match=match):
            loaded(tmp_path, gltf)


def test_a_skin_without_inverse_matrices(tmp_path):
    assert box(loaded(tmp_path, skinned({}, inverse=False))) == [0, 0, 1, 2]


def test_one_mesh_with_two_skins(tmp_path):
    gltf = skinned({})
    # Both of its vertices' joints are the root, moved by 40.
    gltf.add("skins", joints=[gltf.node(translation=[40, 0, 0])] * 2)
    gltf.node(mesh=0, skin=1)
    gltf.json["scenes"][0]["nodes"] += [3, 4]
    scene = loaded(tmp_path, gltf)
    assert (scene.mesh_count, scene.instance_count) == (2, 2)
    assert box(scene) == [0, 0, 41, 1]


def test_joints_outside_of_the_scene_pose_too(tmp_path):
    gltf = skinned({"translation": [0, 5, 0]})
    gltf.json["scenes"][0]["nodes"] = [2]
    assert box(loaded(tmp_path, gltf)) == [0, 0, 1, 5]


def test_morphs_come_before_skins(tmp_path):
    gltf = skinned({"rotation": QUARTER})
    (primitive,) = gltf.json["meshes"][0]["primitives"]
    primitive["targets"] = [{"POSITION": gltf.accessor([[0, 0, 0], [0, 0, 0], [4, 0, 0], [0, 0, 0]])}]
    gltf.json["meshes"][0]["weights"] = [1]
    # (5, 1) turned about (0, 1) is (0, 6).
    np.testing.assert_allclose(loaded(tmp_path, gltf).bounds[1, :2], [1, 6], atol=1e-5)


def test_a_skinned_mesh_with_instances_is_told(tmp_path):
    gltf = skinned({})
    placing = {"TRANSLATION": gltf.accessor([[9, 0, 0], [0, 9, 0]])}
    gltf.json["nodes"][2]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": placing}}
    scene, text = told(tmp_path, gltf)
    assert box(scene) == [0, 0, 1, 1]
    assert "'arm'" in text
    assert "skinned and instanced" in text


def test_a_skin_for_a_mesh_without_joints(tmp_path):
    gltf = skinned({})
    gltf.json["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}}], "name": "stiff"})
    gltf.mesh(TRIANGLE, name="stiff")
    gltf.node(mesh=2, skin=0, translation=[7, 0, 0])
    gltf.json["scenes"][0]["nodes"] = [3]
    scene, text = told(tmp_path, gltf)
    assert box(scene) == [7, 0, 8, 1]
    assert "stiff has no joints" in text
