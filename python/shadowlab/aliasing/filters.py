"""The filters that maps can be read with: theory.md 14."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import _core

if TYPE_CHECKING:
    import pandas as pd


def filters() -> pd.DataFrame:
    """The filters that maps can be read with, one per row.

    A filter is a text: its name, and behind a colon its settings. `size` and `radius` are in texels of the map, or with
    ``px`` in pixels of the picture on the receiver's own plane. A box and a triangle are then scaled along the map's
    axes by the length of the pixel's image, a disc by the pixel's image itself; every kernel is held between 1 and 64
    texels wide.

    Returns
    -------
    pandas.DataFrame
        Columns: name; settings, with examples of values; doc, what it is.

    Examples
    --------
    >>> import shadowlab as sl
    >>> list(sl.filters()["name"])
    ['nearest', 'bilinear', 'pcf', 'tent', 'poisson']
    """
    import pandas as pd

    return pd.DataFrame(_core.filter_kinds(), columns=["name", "settings", "doc"])
