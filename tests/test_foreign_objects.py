"""Objects of other programs that fail, lie or are damaged: a scene with a warning, or one of our errors."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

import shadowlab as sl
from shadowlab.errors import ArgumentError, SceneError, ShadowlabError, ShadowlabWarning

V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
F = np.array([[0, 1, 2]])
MESH = trimesh.Trimesh(V, F, process=False)


class SilentError(Exception):
    """An error whose message fails, too."""

    def __str__(self):
        raise ValueError


def failing(error, **attributes):
    """An object with an attribute that raises."""

    class Failing:
        @property
        def vertices(self):
            raise error

    made = Failing()
    vars(made).update(attributes)
    return made


class Lazy:
    """An array that fails when it is asked for."""

    def __array__(self, *_, **__):
        raise ZeroDivisionError("lazy")


def graph(geometry, get=lambda _: (np.eye(4), "m"), nodes=("n",), **more):
    """A scene graph as trimesh has them."""
    return SimpleNamespace(geometry=geometry, graph=SimpleNamespace(nodes_geometry=list(nodes), get=get), **more)


def mesh(vertices=V, faces=F, **more):
    """An object with vertices and faces."""
    return SimpleNamespace(vertices=vertices, faces=faces, **more)


def placed(matrix):
    """A scene graph that places a triangle so."""
    return graph({"m": MESH}, lambda _: (matrix, "m"))


def in_circles():
    """A scene of trimesh whose nodes are each other's parents."""
    made = trimesh.Scene(MESH)
    made.graph.update("x", "y", matrix=np.eye(4))
    made.graph.update("y", "x", matrix=np.eye(4), geometry=next(iter(made.geometry)))
    return made


def raising(*_):
    raise KeyError("gone")


REFUSED = {
    "vertices raise": (failing(RuntimeError("boom"), faces=F), ArgumentError, "RuntimeError: boom"),
    "an error without a message": (failing(SilentError(), faces=F), ArgumentError, "SilentError"),
    "lazy vertices": (mesh(Lazy()), ArgumentError, "vertices"),
    "lazy faces": (mesh(faces=Lazy()), ArgumentError, "faces"),
    "quads": (mesh(np.zeros((4, 3)), [[0, 1, 2, 3]]), ArgumentError, r"faces.*\(N, 3\)"),
    "float faces": (mesh(faces=F + 0.0), ArgumentError, "faces"),
    "huge index": (mesh(faces=[[0, 1, 2**62]]), SceneError, "vertex 4611686018427387904"),
    "unsigned index": (mesh(faces=np.array([[0, 1, 2**63 + 5]], np.uint64)), ArgumentError, "faces"),
    "negative index": (mesh(faces=[[0, 1, -1]]), SceneError, "vertex -1"),
    "beyond any integer": (mesh(faces=[[0, 1, 10**30]]), ArgumentError, "faces"),
    "words": (mesh([["a", "b", "c"]]), ArgumentError, "vertices"),
    "complex": (mesh(V + 1j), ArgumentError, "vertices"),
    "ragged": (mesh([[1, 2], [1, 2, 3]]), ArgumentError, "vertices"),
    "no geometry": (graph(None), ArgumentError, "source: expected a trimesh"),
    "geometry is a list": (graph([MESH]), ArgumentError, "source: expected a trimesh"),
    "missing geometry": (graph({"q": MESH}), SceneError, "node 'n', whose geometry 'm' does not exist"),
    "NaN": (placed(np.full((4, 4), np.nan)), ArgumentError, "transform"),
    "infinite": (placed(np.diag([np.inf, 1, 1, 1])), ArgumentError, "transform"),
    "three by three": (placed(np.eye(3)), ArgumentError, r"shape \(4, 4\), got \(3, 3\)"),
    "no transform": (placed(None), ArgumentError, "transform"),
    "a word": (placed("abc"), ArgumentError, "'abc'"),
    "projective": (placed(np.diag([1, 1, 1, 2.0])), ArgumentError, "last row"),
    "get raises": (graph({"m": MESH}, raising), ArgumentError, "KeyError: 'gone'"),
    "no pair": (graph({"m": MESH}, lambda _: 5), ArgumentError, "TypeError"),
    "no hash": (graph({"m": MESH}, lambda _: (np.eye(4), ["m"])), ArgumentError, "unhashable"),
    "in circles": (in_circles(), ArgumentError, "source"),
    "points": (trimesh.Scene(trimesh.PointCloud(V)), SceneError, "PointCloud"),
    "a path in a scene": (trimesh.Scene(trimesh.load_path(V[:2])), SceneError, "Path3D"),
    "a path": (trimesh.load_path(V[:2]), ArgumentError, "got Path3D"),
    "no primitives": (SimpleNamespace(primitives=None), ArgumentError, "source"),
    "a primitive of another kind": (SimpleNamespace(primitives=[5]), ArgumentError, "positions"),
    "indices that are no triangles": (
        SimpleNamespace(primitives=[SimpleNamespace(positions=V, indices=[0, 1], poses=None)]), ArgumentError,
        "reshape"),
    "no nodes": (SimpleNamespace(mesh_nodes=None, get_pose=None), ArgumentError, "source"),
    "a dictionary": ({"vertices": V, "faces": F}, ArgumentError, "got dict"),
    "too large": (mesh(V * 1e300), ArgumentError, "coordinates"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name):
    thing, error, match = REFUSED[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ShadowlabWarning)
        with pytest.raises(error, match=match) as caught:
            sl.Scene.from_trimesh(thing)
    assert isinstance(caught.value, ShadowlabError)


@pytest.mark.parametrize(
    ("thing", "match"),
    [
        (
            graph({"m": failing(RuntimeError("boom"), faces=F), "b": MESH}, lambda n: (np.eye(4), n), "mb"),
            "RuntimeError: boom",
        ),
        (graph({"b": MESH}, lambda n: (np.eye(4), n), "ab"), "node 'a', whose geometry 'a' does not exist"),
        (graph({"m": MESH}, has_camera=True), "left out a camera: AttributeError"),
        (graph({"m": MESH}, has_camera=True, camera_transform="x", camera=SimpleNamespace(name="c")), "ValueError"),
        (
            graph(
                {"m": MESH}, has_camera=True, camera_transform=np.eye(4),
                camera=SimpleNamespace(name="c", fov=(50, 40), z_near=0.1, z_far=None),
            ),
            "left out camera 'c': TypeError",
        ),
    ],
)  # fmt: skip
def test_what_is_left_out_and_told(thing, match):
    with pytest.warns(ShadowlabWarning, match=match):
        assert sl.Scene.from_trimesh(thing).triangle_count == 1
