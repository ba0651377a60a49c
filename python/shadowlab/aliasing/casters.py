"""Which instances a renderer draws into maps, and which rule left out the others."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..travel import Value

if TYPE_CHECKING:
    import pandas as pd


class CullRule(IntEnum):
    """What becomes of an instance, in `Casters.rules`."""

    DRAWN = 0
    OUTSIDE = 1  # its box lies outside of the map's volume
    UNSEEN = 2  # its box covers no texel that a pixel looks up
    BEHIND = 3  # its box lies behind all receivers that look up the texels it covers


@dataclass(frozen=True, eq=False, repr=False)
class Casters(Value):
    """What becomes of the instances of a scene in K maps. `Renderer.casters` makes it.

    Attributes
    ----------
    rules : (K, I) uint8
        The `CullRule` of each instance in each map.
    instances, triangles : (K, 4) int64
        Instances and their triangles by rule.

    Examples
    --------
    >>> import shadowlab as sl
    >>> s = sl.library.scene("forest", trees=500)
    >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    >>> found = sl.Renderer("cpu").casters(s, p)
    >>> list(found.table.columns)
    ['map', 'instances', 'triangles', 'drawn', 'outside', 'unseen', 'behind', 'drawn_triangles']
    """

    rules: NDArray[np.uint8]
    instances: NDArray[np.int64]
    triangles: NDArray[np.int64]

    @property
    def maps(self) -> int:
        """How many maps there are."""
        return len(self.rules)

    @property
    def drawn(self) -> int:
        """Instances that are drawn, those of all maps together."""
        return int(self.instances[:, CullRule.DRAWN].sum())

    @property
    def culled(self) -> int:
        """Instances that are not drawn, those of all maps together."""
        return int(self.instances.sum()) - self.drawn

    @property
    def table(self) -> pd.DataFrame:
        """One row per map: instances and triangles of the scene, instances by rule, and triangles that are drawn."""
        import pandas as pd

        by_rule = {rule.name.lower(): self.instances[:, rule] for rule in CullRule}
        return pd.DataFrame(
            {
                "map": np.arange(self.maps),
                "instances": self.instances.sum(axis=1),
                "triangles": self.triangles.sum(axis=1),
                **by_rule,
                "drawn_triangles": self.triangles[:, CullRule.DRAWN],
            }
        )

    def __repr__(self) -> str:
        total, counts = int(self.instances.sum()), self.instances.sum(axis=0)
        why = ", ".join(f"{counts[rule]:,} {rule.name.lower()}" for rule in CullRule)
        return f"Casters({self.maps} map{'' if self.maps == 1 else 's'}, {total:,} instances: {why})"
