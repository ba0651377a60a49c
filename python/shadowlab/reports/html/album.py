"""The pictures of a page, each drawn and encoded once, on several threads, when the page is put together.

Until then marks stand in the page where the data of its pictures will be.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ... import _core, pictures
from ...text.progress import steps_of_call
from .parts import data_uri


class Album:
    """Pictures that are yet to be drawn, by their marks."""

    def __init__(self) -> None:
        self._draw: list[Callable[[], np.ndarray]] = []
        self._files: dict[str, int] = {}
        # Texts of the page come from anywhere; none of them says this.
        self._word = secrets.token_hex(8)

    def add(self, draw: Callable[[], np.ndarray], file: str | None = None) -> str:
        """Takes a picture (H, W, 3) uint8 up, also as a file of that name; the mark for its data URI."""
        self._draw.append(draw)
        if file is not None:
            self._files[file] = len(self._draw) - 1
        return f"{self._word}-{len(self._draw) - 1}."

    def __contains__(self, file: str) -> bool:
        return file in self._files

    def finished(self, page: str, progress: bool | None = False) -> tuple[str, dict[str, bytes]]:
        """The page with all pictures in it, and those that are files by their names."""
        encoded = self._encoded(progress)
        mark = re.compile(rf"{self._word}-(\d+)\.")
        whole = mark.sub(lambda found: data_uri(encoded[int(found[1])]), page)
        return whole, {name: encoded[number] for name, number in self._files.items()}

    def _encoded(self, progress: bool | None) -> list[bytes]:
        found = []
        pool = ThreadPoolExecutor(_core.threads(), "shadowlab-pictures")
        try:
            with steps_of_call(len(self._draw), progress) as step:
                for made in [pool.submit(_made, draw) for draw in self._draw]:
                    step("report: pictures")
                    found.append(made.result())
        finally:
            # After an error or Ctrl-C those that have not begun are left.
            pool.shutdown(wait=False, cancel_futures=True)
        return found


def _made(draw: Callable[[], np.ndarray]) -> bytes:
    """A picture as a file."""
    return pictures.png(draw())
