"""The reasons for differing rays excuse what they should and nothing else."""

import numpy as np
import pytest
import trimesh
from peers.rays import ray_meets, single_precision_reach, unexplained_hits, unexplained_occlusions


@pytest.fixture(scope="module")
def ball():
    """Triangles of a ball, rays at the middle of some, their first hits in double precision, and the reach."""
    mesh = trimesh.creation.icosphere(3)
    triangles = np.asarray(mesh.triangles)
    origin = np.array([0.3, 0.5, 4.0])
    towards = triangles.mean(axis=1) - origin
    facing = np.einsum("ij,ij->i", np.asarray(mesh.face_normals), towards) < -0.5
    directions = towards[facing]
    reach = single_precision_reach(mesh.vertices, origin[None])
    return triangles, np.tile(origin, (len(directions), 1)), directions, np.ones(len(directions)), reach


def test_right_hits_are_explained(ball):
    triangles, origins, directions, t, reach = ball
    assert unexplained_hits(origins[:40], directions[:40], t[:40], t[:40], triangles, reach) == []


@pytest.mark.parametrize("wrong", [np.inf, 1.001, 0.999, 1.3])
def test_one_wrong_hit_is_reported(ball, wrong):
    triangles, origins, directions, t, reach = ball
    theirs = t[:5].copy()
    theirs[3] = wrong
    found = unexplained_hits(origins[:5], directions[:5], t[:5], theirs, triangles, reach)
    assert len(found) == 1
    assert found[0].startswith("theirs")


def test_the_back_of_the_ball_cannot_be_the_first_hit(ball):
    triangles, origins, directions, t, reach = ball
    low, high, _ = ray_meets(origins[0], directions[0], triangles, reach)
    back = 0.5 * (low + high).max()
    assert back > 1.05
    assert len(unexplained_hits(origins[:1], directions[:1], [back], t[:1], triangles, reach)) == 1


def test_a_ray_through_an_edge_may_be_judged_either_way():
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    origins, directions = np.array([[0.5, 0.5, 1.0]]), np.array([[0.0, 0, -1]])
    assert unexplained_hits(origins, directions, [1.0], [np.inf], triangle, 1e-6) == []
    assert unexplained_occlusions(origins, directions, [2.0], triangle, 1e-6) == []
    aside = origins - np.array([1e-5, 0, 0])
    assert len(unexplained_hits(aside, directions, [1.0], [np.inf], triangle, 1e-6)) == 1
    assert len(unexplained_occlusions(aside, directions, [2.0], triangle, 1e-6)) == 1
    beyond = origins + np.array([1e-5, 0, 0])
    assert len(unexplained_hits(beyond, directions, [1.0], [np.inf], triangle, 1e-6)) == 1
    assert len(unexplained_occlusions(beyond, directions, [2.0], triangle, 1e-6)) == 1


@pytest.mark.parametrize("end", [1.0, 1.0 + 5e-7])
def test_a_ray_that_ends_on_a_surface_may_be_judged_either_way(end):
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    origins, directions = np.array([[0.2, 0.2, 1.0]]), np.array([[0.0, 0, -1]])
    assert unexplained_occlusions(origins, directions, [end], triangle, 1e-6) == []
    assert len(unexplained_occlusions(origins, directions, [end + 1e-5], triangle, 1e-6)) == 1
    assert len(unexplained_occlusions(origins, directions, [end - 1e-5], triangle, 1e-6)) == 1


def test_embree_agrees_with_the_helper(ball, embreex_peer):
    triangles, origins, directions, t, reach = ball
    scene = embreex_peer.EmbreexScene(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    theirs, hit = scene.first_hit(*scene.rounded(origins, directions))
    assert (hit >= 0).all()
    np.testing.assert_allclose(theirs, t, atol=1e-5)
    assert unexplained_hits(origins[:40], directions[:40], t[:40], theirs[:40], triangles, reach) == []
    away = np.full(len(origins), 2.0)
    blocked = scene.occluded(*scene.rounded(origins, directions), away)
    assert blocked.all()
    assert not scene.occluded(*scene.rounded(origins, -directions), away).any()
    assert not scene.occluded(*scene.rounded(origins, directions), 0.5 * away / 1.1).any()
