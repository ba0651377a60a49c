"""Discs and texts of filters written anew: what tests and benches hold ours against."""

from __future__ import annotations

import numpy as np

MASK = (1 << 64) - 1


class SplitMix:
    """SplitMix64, and points of the unit disc by rejection."""

    def __init__(self, seed: int, purpose: int):
        self.state = self.mix(seed ^ self.mix(purpose))

    @staticmethod
    def mix(z: int) -> int:
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return z ^ (z >> 31)

    def unit(self) -> float:
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        return (self.mix(self.state) >> 11) / (1 << 53)

    def point(self) -> np.ndarray:
        while True:
            p = np.array([2 * self.unit() - 1, 2 * self.unit() - 1])
            if p @ p <= 1:
                return p


def disc(count: int, seed: int) -> np.ndarray:
    """Mitchell's best candidate: of 16 random points for each before it the farthest from all of them."""
    random, points = SplitMix(seed, 14), []
    for k in range(count):
        candidates = [random.point() for _ in range(16 * k + 1)]
        away = [min((np.sum((c - p) ** 2) for p in points), default=np.inf) for c in candidates]
        points.append(candidates[int(np.argmax(away))])
    return np.array(points)


def settings_of(text: str) -> tuple[str, dict[str, str]]:
    name, _, rest = text.partition(":")
    return name, dict(part.split("=") for part in rest.split(",") if part)
