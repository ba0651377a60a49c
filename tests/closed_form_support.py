"""What the tests of closed forms share: how close is close, and views at random."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

# Of float64 through a dozen operations.
EXACT = 1e-12
IDEAL = ("uniform", "psm", "perspective", "lispsm", "log")
# The key of a warp in the tables, and its name.
WARPS = {"gmnpr": "gmnpr", "lispsm": "lispsm", "lispsm_dz": "lispsm-delta-z", "glpr_clamped": "glpr"}

ratios = st.floats(1.001, 1e6)
scales = st.floats(1e-30, 1e30)
shares = st.floats(0, 1)
fovs = st.floats(0.05, 2.8)
thetas = st.floats(1e-4, np.pi - 1e-4)
lams = st.one_of(st.floats(1e-6, 1e6), st.just(np.inf))


def close(ours, theirs, tolerance=EXACT):
    """Raises unless all are equal up to this share."""
    np.testing.assert_allclose(ours, theirs, rtol=tolerance, atol=0)


def view_of(scale, ratio):
    """Depths of a view."""
    return {"near": scale, "far": scale * ratio}
