"""Scenes with a camera and a light for the comparisons: the library's, and the shared ones where they are."""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import shadowlab as sl

# The forest's trees are instances of a few meshes; some hundred show all that ten thousand show, and bake to arrays
# fast.
LIBRARY = {
    "courtyard": {},
    "robots": {},
    "ceiling": {},
    "skylight": {},
    "dueling": {},
    "forest": {"trees": 300},
}
SHARED = ("dragon_20k.ply", "graveyard.glb", "kenney_city.glb")


@dataclass(frozen=True, eq=False)
class Case:
    """A scene as shadowlab has it, the same triangles as plain arrays, and where it is seen and lit from."""

    name: str
    scene: sl.Scene
    camera: sl.Camera
    light: object
    vertices: np.ndarray
    faces: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """(3,) middle of the vertices' box: single-precision programs are given coordinates relative to it."""
        return 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the vertices' box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


@functools.cache
def library_case(name: str) -> Case:
    """A scene of the library."""
    scene = sl.library.scene(name, **LIBRARY[name])
    return Case(name, scene, scene.camera, scene.light, *scene.to_arrays())


@functools.cache
def shared_case(folder: Path, name: str) -> Case:
    """A shared scene with its first view; on the ground that its description gives it, if any."""
    description = json.loads((folder / "scenes.json").read_text())[name]
    view = description["views"][0]
    scene = sl.load_scene(folder / name)
    ground = description.get("ground")
    if ground is not None:
        scene = scene.with_ground(height=ground["height"])
    camera = sl.Camera.look_at(
        view["eye"],
        view["target"],
        up=view["up"],
        fov_y=np.radians(view["fov_y_deg"]),
        aspect=1.0,
        near=view["near"],
        far=view["far"],
    )
    light = sl.DirectionalLight(view["light_direction"])
    return Case(name, scene, camera, light, *scene.to_arrays())


def case_of(name: str, request) -> Case:
    """A case by its name; the test skips where the shared scenes are not there."""
    if name in LIBRARY:
        return library_case(name)
    return shared_case(request.getfixturevalue("shared_scenes"), name)
