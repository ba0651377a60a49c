"""Cameras and lights of other programs' scenes, known by their attributes as their meshes are (`foreign`)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from .asked import said
from .foreign import in_order, is_pyrender_scene
from .placed import camera_at, farthest, unique

if TYPE_CHECKING:
    from ..types import Light

# Room beyond the scene for what has no end, as a share of its distance.
SPARE = 0.05
# Of a camera that takes its viewport's shape: what `Camera.look_at` takes.
ASPECT = 16 / 9

T = TypeVar("T")


def cameras_of(source: Any) -> tuple[dict[str, _core.Camera], list[str]]:
    """The cameras of a scene by name, and what there is to say of the others."""
    found: dict[str, _core.Camera] = {}
    notes: list[str] = []
    for name, camera, pose in _asked(_cameras(source), "camera", notes):
        label = f"camera {name!r}"
        try:
            settings = _lens(camera, label, notes)
            found[unique(name, found)] = camera_at(pose, **settings)
        except ArgumentError as e:
            notes.append(f"left out {label}: {e}")
        except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
            notes.append(f"left out {label}: {said(e)}")
    return found, notes


def _cameras(source: Any) -> Iterator[tuple[str, Any, NDArray[np.float64]]]:
    if is_pyrender_scene(source):
        for i, (node, pose) in enumerate(in_order(source, source.camera_nodes)):
            yield node.name or node.camera.name or f"camera {i + 1}", node.camera, pose
    elif getattr(source, "has_camera", False):
        # Asked for only where one was set: trimesh would make one.
        yield source.camera.name or "camera", source.camera, np.asarray(source.camera_transform, np.float64)


def _asked(things: Iterator[T], kind: str, notes: list[str]) -> Iterator[T]:
    """The same, up to where the other program fails."""
    try:
        yield from things
    except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
        notes.append(f"left out a {kind}: {said(e)}")


def _lens(theirs: Any, label: str, notes: list[str]) -> dict[str, float]:
    """Field of view or height, aspect, near and far of another program's camera."""
    if hasattr(theirs, "yfov"):
        aspect, far = theirs.aspectRatio, theirs.zfar
        if aspect is None:
            aspect = ASPECT
            notes.append(f"{label} has no aspect ratio: 16:9 is taken; camera.replace(aspect=...) changes it")
        far = math.inf if far is None else far
        return {"fov_y": float(theirs.yfov), "aspect": float(aspect), "near": float(theirs.znear), "far": float(far)}
    if hasattr(theirs, "fov") and hasattr(theirs, "z_far"):
        across, up = np.tan(0.5 * np.radians(np.asarray(theirs.fov, np.float64)))
        near, far = float(theirs.z_near), float(theirs.z_far)
        return {"fov_y": 2 * float(np.arctan(up)), "aspect": float(across / up), "near": near, "far": far}
    if hasattr(theirs, "xmag"):
        # Half the width and half the height.
        across, up = float(theirs.xmag), float(theirs.ymag)
        return {"height": 2 * up, "aspect": across / up, "near": float(theirs.znear), "far": float(theirs.zfar)}
    raise ArgumentError(
        f"{type(theirs).__name__} does not say how wide its picture is; sl.Camera.from_matrices takes its matrices"
    )


def lights_of(source: Any, bounds: NDArray[np.float64]) -> tuple[dict[str, Light], list[str]]:
    """The lights of a pyrender scene by name, and what there is to say of the others; other scenes have none."""
    found: dict[str, Light] = {}
    notes: list[str] = []
    for i, (node, pose) in enumerate(_asked(_lights(source), "light", notes)):
        name = node.name or node.light.name or f"light {i + 1}"
        try:
            made = _light(node.light, pose, bounds)
            found[unique(name, found)] = made
        except ArgumentError as e:
            notes.append(f"left out light {name!r}: {e}")
        except Exception as e:  # noqa: BLE001 - properties of other programs raise what they like
            notes.append(f"left out light {name!r}: {said(e)}")
    return found, notes


def _lights(source: Any) -> Iterator[tuple[Any, NDArray[np.float64]]]:
    if is_pyrender_scene(source):
        yield from in_order(source, source.light_nodes)


def _light(theirs: Any, pose: NDArray[np.float64], bounds: NDArray[np.float64]) -> Light:
    way, position = -pose[:3, 2], pose[:3, 3]
    if not hasattr(theirs, "range"):
        return _core.DirectionalLight(way)
    # Light without a range has no end; one that reaches all of the scene is the same for it. A point has no extent.
    whole = (1 + SPARE) * farthest(bounds, position) or 1.0
    reach = whole if theirs.range is None else float(theirs.range)
    if hasattr(theirs, "outerConeAngle"):
        # Theirs is from the axis to the edge, ours from edge to edge.
        return _core.SpotLight(position, way, cone_angle=2 * float(theirs.outerConeAngle), range=reach)
    return _core.PointLight(position, range=reach)
