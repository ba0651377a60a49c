"""Closed forms of the errors of shadow maps: what the papers print and theory.md derives, for any numbers.

- A light overhead, receivers that fill the view: `dp_ds`, `dp_dt`, `n_opt`, `worst` (theory.md E.1).
- Storage and depth splits: `storage_factor`, `splits`, `dp_ds_in_split`, `max_dp_ds_of_splits` (theory.md 12.1, E.2).
- Any angle between light and view, on the view's centre ray: `warp_lambda`, `phi_offset`, `F`, `F_ends`, `F_least`,
  `F_log`, `G`, `dp_ds_on_surface` (theory.md 6, 7 and 11).

All arguments broadcast as arrays of numpy; single numbers give a float. Examples have numpy as np, and the names of
this module.
"""

from .any_angle import Ends, F, F_ends, F_least, F_log, G, Least, dp_ds_on_surface
from .overhead import Worst, dp_ds, dp_dt, n_opt, worst
from .splits import dp_ds_in_split, max_dp_ds_of_splits, splits, storage_factor
from .warp_distance import phi_offset, warp_lambda

__all__ = [
    "Ends",
    "F",
    "F_ends",
    "F_least",
    "F_log",
    "G",
    "Least",
    "Worst",
    "dp_ds",
    "dp_ds_in_split",
    "dp_ds_on_surface",
    "dp_dt",
    "max_dp_ds_of_splits",
    "n_opt",
    "phi_offset",
    "splits",
    "storage_factor",
    "warp_lambda",
    "worst",
]
