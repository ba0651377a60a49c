"""What all plots share: the axes that they take or make, pictures on them, the look of series."""

from __future__ import annotations

from typing import Any

import numpy as np

# Series of Okabe and Ito (2008), the two that mean false shadow and false light left out.
SERIES = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#8A6D00")
MARKERS = ("o", "s", "^", "D", "v", "P")


def _axes(ax: Any) -> Any:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def _picture(ax: Any, picture: np.ndarray, title: str, aspect: float) -> Any:
    ax = _axes(ax)
    height, width = picture.shape[:2]
    ax.imshow(picture, interpolation="antialiased", aspect=width / (aspect * height))
    ax.set(title=title, xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    return ax
