"""The node graph of glTF: transforms, scenes, visibility and instances, against numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest
from gltf_support import TRIANGLE, Gltf, corners, loaded, told

from shadowlab.errors import LoadError, SceneError
from shadowlab.scene.formats.given import Given
from shadowlab.scene.formats.limits import Limits
from shadowlab.scene.gltf.reader import read_gltf

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


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"translation": [1, 2, 0]}, [0, 1, 2, 3]),
        ({"scale": [3, 1, 1]}, [-3, -1, 3, 1]),
        ({"rotation": QUARTER, "scale": [3, 1, 1]}, [-1, -3, 1, 3]),
        ({"translation": [10, 0, 0], "rotation": QUARTER, "scale": [3, 1, 1]}, [9, -3, 11, 3]),
        ({"matrix": [0, 3, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1]}, [9, -3, 11, 3]),
        ({"scale": [-2, 1, 1], "translation": [5, 0, 0]}, [3, -1, 7, 1]),
        ({"matrix": [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, [-2, -1, 2, 1]),
        ({"scale": [2, 0, 1]}, [-2, 0, 2, 0]),
        ({"scale": [1e-30, 1e-30, 1e-30]}, [0, 0, 0, 0]),
    ],
)
def test_transforms(tmp_path, fields, expected):
    gltf, mesh = square()
    assert box(loaded(tmp_path, gltf.scene(gltf.node(mesh=mesh, **fields)))) == expected


def test_parents_come_first(tmp_path):
    gltf, mesh = square()
    leaf = gltf.node(mesh=mesh, translation=[3, 0, 0])
    middle = gltf.node(children=[leaf], rotation=QUARTER)
    root = gltf.node(children=[middle], scale=[1, 10, 1], mesh=mesh)
    scene = loaded(tmp_path, gltf.scene(root))
    assert box(scene) == [-1, -10, 1, 40]
    assert (scene.mesh_count, scene.instance_count) == (1, 2)


def test_what_is_scaled_to_a_line_or_a_point_is_left_out(tmp_path):
    """It has no area, so it casts nothing; a plane has one."""
    turned = {"rotation": [0.1, 0.2, 0.3, np.sqrt(0.86)]}
    for scale, left in (
        ([0, 0, 0], 1),
        ([3, 0, 0], 1),
        ([0, 1e-30, 0], 1),
        ([1, 1, 0], 2),
        ([1e-30] * 3, 2),
        ([1, 1e-9, 1e-9], 2),
    ):
        gltf, mesh = square()
        inner = gltf.node(mesh=mesh, scale=scale, **turned)
        scene, text = told(tmp_path, gltf.scene(gltf.node(mesh=mesh), gltf.node(children=[inner], **turned)))
        assert scene.instance_count == left
        assert ("left out 1 placed mesh of scale 0" in text) == (left == 1)
    gltf = instanced({"SCALE": [[1, 1, 1], [0, 0, 0], [2, 0, 0]]})
    scene, text = told(tmp_path, gltf)
    assert scene.instance_count == 1
    assert "left out 2 placed meshes" in text


@pytest.mark.parametrize("length", [1e-30, 0.5, 1e30])
def test_quaternions_of_another_length(tmp_path, length):
    gltf, mesh = square()
    gltf.scene(gltf.node(mesh=mesh, scale=[3, 1, 1], rotation=(np.array(QUARTER) * length).tolist(), name="turned"))
    scene, text = told(tmp_path, gltf)
    assert box(scene) == [-1, -3, 1, 3]
    assert "turned" in text
    assert "unit quaternion" in text


def test_a_zero_quaternion_turns_nothing_and_is_told(tmp_path):
    gltf, mesh = square()
    scene, text = told(tmp_path, gltf.scene(gltf.node(mesh=mesh, scale=[3, 1, 1], rotation=[0, 0, 0, 0], name="still")))
    assert box(scene) == [-3, -1, 3, 1]
    assert "'still'" in text
    assert "none is taken" in text


def test_matrices_that_are_not_affine(tmp_path):
    gltf, mesh = square()
    matrix = np.eye(4)
    matrix[3, 0] = 0.5
    with pytest.raises(LoadError, match="numbers 4, 8, 12 and 16"):
        loaded(tmp_path, gltf.scene(gltf.node(mesh=mesh, matrix=matrix.T.ravel().tolist())))


@pytest.mark.parametrize(
    "fields",
    [
        {"translation": [1, 2]},
        {"translation": "1 2 3"},
        {"rotation": [0, 0, 1]},
        {"scale": [1, 1, True]},
        {"scale": [1, None, 1]},
        {"matrix": [1] * 15},
        {"translation": [10**400, 0, 0]},
        {"mesh": 3},
        {"mesh": -1},
        {"mesh": "0"},
        {"children": 5},
        {"children": [9]},
        {"children": ["0"]},
        {"children": [0.5]},
        {"extensions": 3},
        {"extensions": {"KHR_node_visibility": {"visible": "no"}}},
    ],
)
def test_broken_nodes_are_refused_by_name(tmp_path, fields):
    gltf, mesh = square()
    with pytest.raises(LoadError, match=r"nodes\[0\]"):
        loaded(tmp_path, gltf.scene(gltf.node(**{"mesh": mesh, **fields})))


def test_transforms_that_overflow(tmp_path):
    gltf, mesh = square()
    leaf = gltf.node(mesh=mesh, scale=[1e200, 1, 1], name="leaf")
    gltf.scene(gltf.node(children=[leaf], scale=[1e200, 1, 1]))
    with pytest.raises(SceneError, match=r"leaf.*overflows"):
        loaded(tmp_path, gltf)
    gltf, mesh = square()
    with pytest.raises(SceneError, match="coordinates below"):
        loaded(tmp_path, gltf.scene(gltf.node(mesh=mesh, scale=[1e200, 1, 1])))


def test_a_matrix_counts_before_translation_and_is_told(tmp_path):
    gltf, mesh = square()
    matrix = np.diag([3.0, 1, 1, 1]).ravel().tolist()
    scene, text = told(tmp_path, gltf.scene(gltf.node(mesh=mesh, matrix=matrix, translation=[9, 9, 9])))
    assert box(scene) == [-3, -1, 3, 1]
    assert "matrix beside translation" in text


def test_cycles_and_two_parents_are_refused(tmp_path):
    for children, match in (
        ({0: [1], 1: [0]}, "below itself"),
        ({0: [0]}, "below itself"),
        ({0: [1], 1: [2], 2: [3], 3: [1]}, "one parent"),
        ({0: [1, 2], 1: [3], 2: [3]}, r"nodes\[3\].*one parent"),
        ({0: [1, 1]}, "one parent"),
    ):
        gltf, mesh = square()
        for i in range(4):
            gltf.node(mesh=mesh, **({"children": children[i]} if i in children else {}))
        with pytest.raises(LoadError, match=match):
            loaded(tmp_path, gltf.scene(0))


def test_chains_of_ten_thousand_nodes(tmp_path):
    gltf, mesh = square()
    for i in range(10_000):
        gltf.node(children=[i + 1], translation=[0.5, 0, 0])
    gltf.node(mesh=mesh)
    assert box(loaded(tmp_path, gltf.scene(0))) == [4999, -1, 5001, 1]


def test_which_nodes_are_in_the_scene(tmp_path):
    def forest():
        gltf, mesh = square()
        for x in (0, 10, 20):
            gltf.node(mesh=mesh, translation=[x, 0, 0])
        return gltf

    gltf = forest()
    gltf.json["scenes"] = [{"nodes": [0]}, {"nodes": [1, 2]}]
    assert box(loaded(tmp_path, gltf)) == [-1, -1, 1, 1]
    gltf.json["scene"] = 1
    assert box(loaded(tmp_path, gltf)) == [9, -1, 21, 1]
    assert box(loaded(tmp_path, forest())) == [-1, -1, 21, 1]
    gltf.json["scene"] = 2
    with pytest.raises(LoadError, match="scene: expected one of the file's 2 scenes"):
        loaded(tmp_path, gltf)
    gltf = forest()
    gltf.json["scene"] = 0
    with pytest.raises(LoadError, match="scene"):
        loaded(tmp_path, gltf)
    gltf = forest()
    gltf.json["scenes"] = [{"nodes": [0, 0]}]
    assert loaded(tmp_path, gltf).instance_count == 1
    gltf = forest()
    gltf.json["nodes"][0]["children"] = [1]
    gltf.json["scenes"] = [{"nodes": [1]}]
    with pytest.raises(LoadError, match="expected roots"):
        loaded(tmp_path, gltf)
    gltf = forest()
    gltf.json["scenes"] = [{}]
    with pytest.raises(SceneError, match="places no mesh"):
        loaded(tmp_path, gltf)


def test_meshes_that_no_node_shows_are_left_out(tmp_path):
    gltf, mesh = square()
    gltf.mesh(TRIANGLE)
    gltf.node(mesh=1)
    scene = loaded(tmp_path, gltf.scene(gltf.node(mesh=mesh)))
    assert (scene.mesh_count, scene.instance_count) == (1, 1)


def test_invisible_nodes_hide_all_below_them(tmp_path):
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}}
    shown = {"extensions": {"KHR_node_visibility": {"visible": True}}}
    gltf, mesh = square(extensionsUsed=["KHR_node_visibility"])
    leaf = gltf.node(mesh=mesh, translation=[50, 0, 0], **shown)
    middle = gltf.node(mesh=mesh, translation=[20, 0, 0], children=[leaf])
    gltf.scene(gltf.node(mesh=mesh, translation=[9, 0, 0], children=[middle], **hidden), gltf.node(mesh=mesh, **shown))
    assert box(loaded(tmp_path, gltf)) == [-1, -1, 1, 1]


def instanced(attributes, **node):
    gltf, mesh = square(extensionsUsed=["EXT_mesh_gpu_instancing"], extensionsRequired=["EXT_mesh_gpu_instancing"])
    made = {name: gltf.accessor(*(v if isinstance(v, tuple) else (v,))) for name, v in attributes.items()}
    for index in made.values():
        if gltf.json["accessors"][index]["componentType"] != 5126:
            gltf.json["accessors"][index]["normalized"] = True
    gltf.node(mesh=mesh, extensions={"EXT_mesh_gpu_instancing": {"attributes": made}}, **node)
    return gltf.scene(0)


def test_instances_stay_instances(tmp_path):
    attributes = {
        "TRANSLATION": [[10, 0, 0], [0, 20, 0]],
        "ROTATION": [QUARTER, [0, 0, 0, 1]],
        "SCALE": [[3, 1, 1], [1, 2, 1]],
    }
    scene = loaded(tmp_path, instanced(attributes, translation=[100, 0, 0], scale=[2, 1, 1]))
    assert (scene.mesh_count, scene.instance_count) == (1, 2)
    found = corners(scene).reshape(2, -1, 3)
    np.testing.assert_allclose(found.min(axis=1)[:, :2], [[118, -3], [98, 18]], atol=1e-4)
    np.testing.assert_allclose(found.max(axis=1)[:, :2], [[122, 3], [102, 22]], atol=1e-4)


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ({"TRANSLATION": [[5, 0, 0]] * 3}, [4, -1, 6, 1]),
        ({"SCALE": [[5, 1, 1]]}, [-5, -1, 5, 1]),
        ({"ROTATION": ([[0, 0, 90, 90]], "i1"), "SCALE": [[4, 1, 1]]}, [-1, -4, 1, 4]),
        ({"ROTATION": ([[0, 0, 23170, 23170]], "i2"), "SCALE": [[4, 1, 1]]}, [-1, -4, 1, 4]),
        ({"_ID": [1.0, 2.0], "TRANSLATION": [[5, 0, 0], [9, 0, 0]]}, [4, -1, 10, 1]),
        ({"_ID": [1.0, 2.0]}, [-1, -1, 1, 1]),
    ],
)
def test_instances_by_some_attributes(tmp_path, attributes, expected):
    scene = loaded(tmp_path, instanced(attributes))
    np.testing.assert_allclose(scene.bounds[:, :2].ravel(), expected, atol=1e-4)
    assert scene.instance_count == len(next(iter(attributes.values()))) or "ROTATION" in attributes


def test_instances_that_are_refused(tmp_path):
    with pytest.raises(LoadError, match="TRANSLATION 2, SCALE 1"):
        loaded(tmp_path, instanced({"TRANSLATION": [[0, 0, 0]] * 2, "SCALE": [[1, 1, 1]]}))
    with pytest.raises(LoadError, match="got none"):
        loaded(tmp_path, instanced({}))
    with pytest.raises(LoadError, match="finite"):
        loaded(tmp_path, instanced({"TRANSLATION": [[np.nan, 0, 0]]}))
    with pytest.raises(LoadError, match="VEC4"):
        loaded(tmp_path, instanced({"ROTATION": [[0, 0, 1]]}))
    scene, text = told(tmp_path, instanced({"ROTATION": [[0, 0, 0, 0], QUARTER]}))
    assert scene.instance_count == 2
    assert "1 of 2 instances" in text
    gltf = instanced({"TRANSLATION": [[0, 0, 0]]})
    gltf.json["accessors"][-1]["count"] = 20_000_000
    with pytest.raises(LoadError, match="instances"):
        loaded(tmp_path, gltf)


def test_many_small_arrays_of_instances_are_limited_together(tmp_path):
    gltf = instanced({"TRANSLATION": np.zeros((400, 3))})
    gltf.json["nodes"] *= 3
    gltf.json["scenes"] = [{"nodes": [0, 1, 2]}]
    path = tmp_path / "scene.glb"
    path.write_bytes(gltf.glb())
    with pytest.raises(LoadError, match=r"at most 1,000 placed meshes, got 1,200.*instances="):
        read_gltf(Given.of_file(path, "glb", Limits(instances=1000)))
    # Zeros that no byte of the file holds.
    gltf = instanced({"_ID": [0.0]})
    accessor = gltf.json["accessors"][-1]
    del accessor["bufferView"]
    accessor["count"] = 900_000
    with pytest.raises(LoadError, match="for each byte"):
        loaded(tmp_path, gltf)


def test_meshes_hang_on_cameras_and_lights(tmp_path):
    gltf, mesh = square(extensions={"KHR_lights_punctual": {"lights": [{"type": "point", "range": 3}]}})
    gltf.add("cameras", type="perspective", perspective={"yfov": 1, "znear": 0.1, "zfar": 9, "aspectRatio": 1})
    child = gltf.node(mesh=mesh, translation=[1, 0, 0])
    lamp = gltf.node(
        children=[child], mesh=mesh, extensions={"KHR_lights_punctual": {"light": 0}}, translation=[0, 5, 0]
    )
    scene = loaded(tmp_path, gltf.scene(gltf.node(camera=0, mesh=mesh, children=[lamp], translation=[10, 0, 0])))
    assert box(scene) == [9, -1, 12, 6]
    assert scene.instance_count == 3
    assert len(scene.cameras) == len(scene.lights) == 1
