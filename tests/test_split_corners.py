"""Corners with several indices become the vertices that trimesh makes of them, in its order."""

from __future__ import annotations

import numpy as np
import pytest
from trimesh.visual.texture import unmerge_faces

from shadowlab.scene.formats.split_corners import split_corners

# Indices above this do not fit three to a number of 64 bits, so that rows are compared as bytes.
LARGE = 1 << 21


@pytest.mark.parametrize("kinds", [2, 3])
@pytest.mark.parametrize("most", [3, 40, 5000, LARGE])
@pytest.mark.parametrize("faces", [1, 2, 400, 3000])
def test_vertices_are_those_of_trimesh(kinds, most, faces):
    random = np.random.default_rng(kinds * 1000 + most + faces)
    indices = [random.integers(0, most, (faces, 3)).astype(np.int32) for _ in range(kinds)]
    expected, *columns = unmerge_faces(indices[0], *indices[1:])
    corner, vertices = split_corners([index.reshape(-1) for index in indices])
    np.testing.assert_array_equal(corner.reshape(-1, 3), expected)
    for ours, theirs in zip(vertices, columns, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_every_corner_keeps_its_indices_and_no_vertex_comes_twice():
    random = np.random.default_rng(7)
    indices = [random.integers(0, 6, 300) for _ in range(3)]
    corner, vertices = split_corners(indices)
    for own, of_vertex in zip(indices, vertices, strict=True):
        np.testing.assert_array_equal(of_vertex[corner], own)
    assert len(set(zip(*vertices, strict=True))) == len(vertices[0])
    assert (np.diff(vertices[0]) >= 0).all()
