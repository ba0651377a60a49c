"""Summaries of footprints and of causes in numpy, one operation after another: what the core's are held against."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from shadowlab.aliasing.causes import CAUSES
from shadowlab.aliasing.extent import UNDERSAMPLED_FROM_PX, largest_extent
from shadowlab.aliasing.summary import HISTOGRAM_LIMITS_PX, PERCENTILES, even_limits


def numbers_of(footprint, bands=6):
    """What `Summary` holds of a footprint with at least one measured pixel, by name."""
    chosen = footprint.measured
    measured = int(np.count_nonzero(chosen))
    major, projection, depth = (
        a[chosen].astype(np.float64) for a in (footprint.major, footprint.projection, footprint.depth)
    )
    along_t, along_s = (footprint.perspective_ts[..., k][chosen].astype(np.float64) for k in (0, 1))
    of_map = footprint.map[chosen]
    perspective = largest_extent(
        np.stack([along_t, along_s], axis=-1), np.asarray(footprint.perspective[chosen], np.float64)
    )
    worst = [
        (along_s[of_map == k].max(), along_t[of_map == k].max()) for k in range(footprint.maps) if (of_map == k).any()
    ]
    limits = even_limits(depth.min(), depth.max(), bands) if isinstance(bands, int) else np.asarray(bands, float)
    return {
        "measured": measured,
        "max": major.max(),
        "mean": major.mean(),
        "rms": np.sqrt(np.mean(np.square(major))),
        **{f"p{k}": v for k, v in zip(PERCENTILES, np.percentile(major, PERCENTILES), strict=True)},
        "undersampled": np.count_nonzero(major > UNDERSAMPLED_FROM_PX) / measured,
        "perspective_max": perspective.max(),
        "perspective_mean": perspective.mean(),
        "projection_mean": np.exp(np.mean(np.log(np.maximum(projection, np.finfo(np.float32).tiny)))),
        "perspective_s_max": max(s for s, _ in worst),
        "perspective_t_max": max(t for _, t in worst),
        "storage_factor": sum(s * t for s, t in worst) * np.prod(footprint.resolution) / np.prod(footprint.size),
        "histogram": np.histogram(major, np.array([0.0, *HISTOGRAM_LIMITS_PX, np.inf]))[0].tolist(),
        "bands": [band_of(major[index]) for index in rows_of_bands(depth, limits)],
    }


def band_of(inside):
    """The numbers of a band of depth, of its values."""
    if inside.size == 0:
        return (0, None, None, None, None)
    shown = np.count_nonzero(inside > UNDERSAMPLED_FROM_PX) / inside.size
    return (inside.size, inside.max(), inside.mean(), np.percentile(inside, 95), shown)


def rows_of_bands(depth, limits):
    """Which depths lie in each band; the last limit belongs to the last."""
    index = np.searchsorted(limits, depth, side="right") - 1
    index = np.where(depth == limits[-1], len(limits) - 2, index)
    return [index == b for b in range(len(limits) - 1)]


def edge_distance_of(causes):
    """Mean, 95th percentile and largest distance of displaced edges in double precision; None where there is none."""
    moved = causes.distance[(causes.image == 2) & np.isfinite(causes.distance)].astype(np.float64)
    return None if moved.size == 0 else {"mean": moved.mean(), "p95": np.percentile(moved, 95), "max": moved.max()}


def causes_by_depth(causes, bands=6):
    """The rows of `Causes.by_depth`."""
    compared = causes.image >= 0
    depth = causes.depth[compared]
    limits = even_limits(depth.min(), depth.max(), bands) if isinstance(bands, int) else np.asarray(bands, float)
    rows = []
    for (near, far), inside in zip(pairwise(limits), rows_of_bands(causes.depth, limits), strict=True):
        image = causes.image[inside & compared]
        named = {name: int(np.count_nonzero(image == code)) for code, name in CAUSES.items()}
        whole = {"compared": int(image.size), "wrong": int(np.count_nonzero(image > 0))}
        rows.append({"near": near, "far": far, **whole, **named})
    return rows
