"""Every format that the documentation promises loads with the core dependencies, shapes and sharing kept."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import shadowlab as sl

# Text formats are written with 8 digits, binary ones in single precision.
RELATIVE_ROUNDING = 1e-7

MESH_FORMATS = ["glb", "gltf", "ply", "obj", "stl", "off", "3mf", "dae"]
# Of these, trimesh writes whole scenes; the others hold one mesh.
SHARING_FORMATS = ["glb", "gltf", "3mf"]


def written(tmp_path, geometry, extension):
    """The path of the geometry in a file of its own."""
    path = tmp_path / f"model.{extension}"
    if extension == "gltf":
        # A glTF text comes with its buffers in files beside it.
        for name, data in geometry.export(file_type="gltf").items():
            (tmp_path / (path.name if name.endswith(".gltf") else name)).write_bytes(data)
    else:
        geometry.export(path)
    return path


@pytest.mark.parametrize("extension", MESH_FORMATS)
def test_mesh_loads(tmp_path, extension):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.apply_translation([3.0, -2.0, 0.5])
    scene = sl.load_scene(written(tmp_path, mesh, extension), unit=1)
    assert scene.triangle_count == len(mesh.faces)
    scale = np.abs(mesh.bounds).max()
    np.testing.assert_allclose(scene.bounds, mesh.bounds, rtol=0, atol=scale * RELATIVE_ROUNDING)


@pytest.mark.parametrize("extension", SHARING_FORMATS)
def test_instances_stay_instances(tmp_path, extension):
    mesh = trimesh.creation.icosphere(subdivisions=1)
    graph = trimesh.Scene()
    graph.add_geometry(mesh, node_name="first", geom_name="ball")
    for k in range(3):
        placed = trimesh.transformations.translation_matrix([4.0 * (k + 1), 0, k])
        graph.graph.update(f"copy{k}", matrix=placed, geometry="ball")
    scene = sl.load_scene(written(tmp_path, graph, extension), unit=1)
    assert scene.instance_count == 4
    assert scene.triangle_count == 4 * len(mesh.faces)
    scale = np.abs(graph.bounds).max()
    np.testing.assert_allclose(scene.bounds, graph.bounds, rtol=0, atol=scale * RELATIVE_ROUNDING)


def test_obj_in_another_encoding_loads(tmp_path):
    path = tmp_path / "café.obj"
    path.write_bytes("# café\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n".encode("latin-1"))
    assert sl.load_scene(path).triangle_count == 2


def test_polygons_become_triangles(tmp_path):
    path = tmp_path / "pentagon.off"
    path.write_text("OFF\n5 1 0\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n5 0 1 2 3 4\n")
    assert sl.load_scene(path).triangle_count == 3
