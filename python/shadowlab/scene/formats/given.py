"""What was given to be read: a name, its bytes, and the files beside it that it may refer to."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from urllib.parse import unquote

from ...errors import LoadError
from .limits import Limits, check_limit

#: Bytes that are read at once.
_READ_AT_ONCE = 16 << 20


@dataclass(frozen=True, eq=False)
class Given:
    """A file as readers see it, wherever its bytes come from.

    Attributes
    ----------
    name : str
        The path, or the name of the entry of an archive; for errors.
    kind : str
        The ending that says how to read it, in small letters and without a dot.
    read : callable
        Its bytes, at each call.
    find : callable
        The bytes of the file at a relative path beside it, or None where there is none. Never from outside its folder.
    limits : Limits
        What may be read at most.
    path : Path, optional
        Where it lies, if it is a file by itself.
    """

    name: str
    kind: str
    read: Callable[[], bytes]
    find: Callable[[str], bytes | None]
    limits: Limits = field(default_factory=Limits)
    path: Path | None = None

    @cached_property
    def data(self) -> bytes:
        """The bytes."""
        return self.read()

    def beside(self, reference: str) -> bytes:
        """The bytes of a file that this one refers to by a relative reference, percent-encoded or not.

        Raises
        ------
        LoadError
            For one that does not exist, lies outside the file's folder, or is above the limit of size.
        """
        for name in dict.fromkeys((reference, unquote(reference))):
            if (found := self.find(inside(self.name, name))) is not None:
                return found
        raise LoadError(f"{self.name}: expected {reference!r} beside it, found nothing there; put the file there")

    @classmethod
    def of_file(cls, path: Path, kind: str, limits: Limits) -> Given:
        """A file of the file system; what it refers to lies in its folder or below."""
        folder = path.resolve().parent

        def find(name: str) -> bytes | None:
            other = (folder / name).resolve()
            if not other.is_relative_to(folder):
                raise outside(str(path), name)
            return _bytes_of(other, limits) if other.is_file() else None

        return cls(str(path), kind, lambda: _bytes_of(path, limits), find, limits, path)


def inside(name: str, reference: str, *, is_uri: bool = True) -> str:
    """The reference, a URI or a path, as a path below a folder, with "/" between names.

    Raises
    ------
    LoadError
        For a path that leaves the folder, an absolute one, or an address of another scheme than that of files.
    """
    plain = reference.replace("\\", "/")
    parts = plain.split("/")
    # Names of files may have colons elsewhere than after the letter of a drive.
    has_root = ":" in parts[0] if is_uri else parts[0][1:2] == ":" and parts[0][0].isalpha() and len(parts) > 1
    absolute = plain.startswith("/") or has_root or "\0" in plain
    below = os.path.normpath("/".join(parts)).replace("\\", "/")
    if absolute or below == ".." or below.startswith("../") or not plain:
        raise outside(name, reference)
    return below


class OutsideError(LoadError):
    """A reference that leaves the folder of the file that has it."""


def outside(name: str, reference: str) -> OutsideError:
    """The error for a reference that leaves the folder."""
    return OutsideError(
        f"{name}: expected references to files in its own folder, got {reference!r}; "
        "files outside are not read: move the file into the folder"
    )


def _bytes_of(path: Path, limits: Limits) -> bytes:
    try:
        check_limit(limits, str(path), "size", path.stat().st_size, "bytes")
        read = io.BytesIO()
        with path.open("rb") as stream:
            while part := stream.read(_READ_AT_ONCE):
                read.write(part)
        return read.getvalue()
    except OSError as e:
        raise LoadError(f"{path}: expected a readable file, could not read it ({e.strerror or e}); check it") from e
