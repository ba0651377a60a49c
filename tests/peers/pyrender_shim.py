"""What pyrender 0.1.45 (2021, its last release) needs to run on numpy 2: one name that numpy removed.

Import this before pyrender. `numpy.infty` is given back for pyrender's own modules only: each sees a numpy of its own
that forwards everything else, so that no other code in the process comes to depend on the old name.
"""

from __future__ import annotations

import types

import numpy as np


class _OldNumpy(types.ModuleType):
    """numpy with the names of 1.x that pyrender still uses."""

    infty = np.inf

    def __getattr__(self, name: str):
        return getattr(np, name)


def install() -> None:
    """Give pyrender's modules their numpy. Needs pyrender to be importable; harmless when called twice."""
    import pyrender.mesh

    if not hasattr(np, "infty"):
        pyrender.mesh.np = _OldNumpy("numpy")
