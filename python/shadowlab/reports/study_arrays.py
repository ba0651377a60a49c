"""A study as arrays: one .npz file with what the camera sees, the truth, the matrices, maps and masks.

Every array is plain numbers or text, so `numpy.load` reads the file without pickle. `VIEW_KEYS` and
`RUN_KEYS` list what is in it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..errors import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .._core import Partition
    from ..experiments.run import Run
    from ..experiments.study import Study

#: Arrays of the view. H and W are the picture's height and width.
VIEW_KEYS = {
    "depth": "(H, W) float32: NDC depth in [0, 1], 1 where nothing is",
    "position": "(H, W, 3) float64: world positions, the origin where nothing is",
    "normal": "(H, W, 3) float32: unit geometric normals on the side of the eye, 0 where nothing is",
    "triangle": "(H, W) int32: row of the mesh's face array, -1 where nothing is",
    "instance": "(H, W) int32: index of the instance, -1 where nothing is",
    "truth": "(H, W) int8: 1 lit, 0 in shadow, -1 undecided, -2 nothing; absent from a study without truth",
    "camera_view": "(4, 4) float64: view from world",
    "camera_projection": "(4, 4) float64: clip from view, NDC z in [0, 1]",
    "light_point": "(4,) float64: the light as a homogeneous point, (-direction, 0) of a directional one",
    "label": "(R,) text: names of the R runs, one per technique and resolution",
    "resolution": "(R,) int64: texels along each side of their maps",
    "failure": "(R,) text: why a run has no arrays; empty where it has",
}
#: Arrays of run i, counted from 0, as "run_i_NAME". K is the number of its maps, N the resolution.
RUN_KEYS = {
    "matrices": "(K, 4, 4) float64: shadow clip from world",
    "eye_depth": "(K, 2) float64: least and largest camera depth that each map serves, world units",
    "post_warp": "(K, 2) float64: scale and offset of the logarithm that replaces y by scale ln(w) + offset, or 0",
    "post_warp_x": "(K, P, 2) float64: knots (before, after) of the function by which a rectilinear warp replaces "
    "NDC x, NaN beyond a map's last one; absent where no map has such a warp",
    "post_warp_y": "(K, P, 2) float64: the same for NDC y",
    "maps": "(K, N, N) float32: depths in [0, 1], 1 where empty",
    "mask": "(H, W) float32: share of the light that arrives, NaN where nothing is seen",
    "chosen": "(H, W) int16: the map that each pixel reads, -1 for none; absent where there is one map",
    "difference": "(H, W) int8: 0 agrees, 1 false shadow, 2 false light, -1 not compared; absent without truth",
}


def study_arrays(study: Study) -> dict[str, np.ndarray]:
    """The arrays of a study, by the names in `VIEW_KEYS` and `RUN_KEYS`."""
    g = study.gbuffer
    arrays: dict[str, Any] = {
        name: getattr(g, name) for name in ("depth", "position", "normal", "triangle", "instance")
    }
    arrays |= {} if study.truth is None else {"truth": study.truth}
    arrays |= {
        "camera_view": study.camera.view,
        "camera_projection": study.camera.projection,
        "light_point": study.light.point,
        "label": np.array([run.label for run in study.runs], dtype=np.str_),
        "resolution": np.array([run.resolution for run in study.runs], dtype=np.int64),
        "failure": np.array([run.failure for run in study.runs], dtype=np.str_),
    }
    for i, run in enumerate(study.runs):
        arrays |= {f"run_{i}_{name}": array for name, array in run_arrays(run).items()}
    return {name: np.asarray(array) for name, array in arrays.items()}


def run_arrays(run: Run) -> dict[str, np.ndarray]:
    """The arrays of a run, by the names in `RUN_KEYS`; empty of one that failed."""
    p, maps = run.parameterization, run.maps
    if run.failure or p is None or maps is None:
        return {}
    found: dict[str, Any] = {
        "matrices": p.matrices,
        "eye_depth": [part.eye_depth for part in p.partitions],
        "post_warp": [[part.post_warp_terms.get(name, 0.0) for name in ("scale", "offset")] for part in p.partitions],
        "post_warp_x": padded_knots(p.partitions, 0),
        "post_warp_y": padded_knots(p.partitions, 1),
        "maps": maps if maps.ndim == 3 else maps[None],
        "mask": run.mask,
        "chosen": run.chosen,
        "difference": run.difference,
    }
    return {name: np.asarray(array) for name, array in found.items() if array is not None}


def padded_knots(parts: Sequence[Partition], axis: int) -> np.ndarray | None:
    """(K, P, 2) knots of the rectilinear warps of some maps along one axis, NaN beyond the last; None without any."""
    knots = [np.empty((0, 2)) if part.post_warp_knots is None else part.post_warp_knots[axis] for part in parts]
    most = max(map(len, knots))
    if most == 0:
        return None
    return np.stack([np.pad(k, ((0, most - len(k)), (0, 0)), constant_values=np.nan) for k in knots])


def save_study_arrays(study: Study, path: Path) -> Path:
    """Writes the arrays into a compressed .npz file; its path.

    Raises
    ------
    ArgumentError
        Where it cannot be written.
    """
    try:
        with path.open("wb") as file:
            np.savez_compressed(file, **cast("dict[str, Any]", study_arrays(study)))
    except OSError as error:
        reason = error.strerror or str(error)
        raise ArgumentError(f"path: cannot write {str(path)!r} ({reason}); choose another file") from error
    return path
