"""A small scene with two lights, and the advice on it."""

from __future__ import annotations

import numpy as np

import shadowlab as sl

SQUARE = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
FACES = [[0, 2, 1], [0, 3, 2]]
SIZE = (80, 64)
SETS = ["uniform", "lispsm", "z_partition:count=2", "z_partition:count=3,inner=(lispsm:near=optimal)"]


def made_view():
    """A square above a floor, a camera, and a light from above and one from the side."""
    scene = sl.Scene.from_arrays(4 * SQUARE, FACES) + sl.Scene.from_arrays(SQUARE + np.array([0, 1.0, 0]), FACES)
    camera = sl.Camera.look_at((0, 3, 5), (0, 0, 0), aspect=1.25, near=1.0, far=20.0)
    lights = {"noon": sl.DirectionalLight((0.3, -1, 0.1)), "low": sl.DirectionalLight((1, -0.4, -0.2))}
    return scene, camera, lights


def advise(view, **keywords):
    """The advice on a view, small and quick unless told otherwise."""
    arguments = {"memory": ["16 KiB", "48 KiB"], "techniques": SETS, "size": SIZE, "renderer": "cpu", "progress": False}
    return sl.advise(*view, **{**arguments, **keywords})
