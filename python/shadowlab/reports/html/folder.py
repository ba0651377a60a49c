"""The folder that a report is written into."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from ...errors import ArgumentError, ShadowlabError


@contextlib.contextmanager
def report_folder(directory: Path) -> Iterator[None]:
    """Makes a folder; what the system says of it, or of files within, is an error of the argument.

    Raises
    ------
    ArgumentError
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        yield
    except ShadowlabError:
        raise  # some are errors of the system, too: of a scene's file, to draw the pictures in
    except OSError as error:
        reason = error.strerror or str(error)
        raise ArgumentError(f"directory: cannot write to {str(directory)!r} ({reason}); choose another") from error
