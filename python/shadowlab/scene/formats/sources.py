"""What `load_scene` takes as a source, as a file that readers read."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ...errors import ArgumentError, LoadError
from ...text import shown
from ...text.checked import has_all
from .archives import ARCHIVES, MAGICS, PACKED
from .given import Given
from .limits import Limits, check_limit

_PART = 1 << 20


def given_source(source: object, kind: str | None, limits: Limits) -> Given:
    """A path, bytes or an open file as what readers read.

    Raises
    ------
    ArgumentError
        For something else, a closed file, and bytes whose kind nobody says.
    LoadError
        For a file that is missing, no regular file, or fails while it is read.
    """
    if isinstance(source, (bytes, bytearray, memoryview)):
        if kind is None:
            raise ArgumentError('kind: expected the ending of a mesh file for bytes, got none; try kind="obj"')
        return _of_bytes("bytes", kind, bytes(source), limits)
    if isinstance(source, (str, os.PathLike)):
        path = _path(source)
        return Given.of_file(path, kind or ending_of(path.name), limits)
    if has_all(source, "read") and callable(getattr(source, "read", None)):
        return _of_stream(source, kind, limits)
    raise ArgumentError(
        f'source: expected the path of a mesh file, its bytes or an open file, got {shown(source)}; try "scene.glb"'
    )


def ending_of(name: str) -> str:
    """The ending of a file's name in small letters, that of an archive whole; "" where it has none."""
    lower = name.lower()
    for ending in ARCHIVES:
        if lower.endswith(f".{ending}"):
            return ending
    return Path(lower).suffix.lstrip(".")


def inner_ending(name: str, kind: str) -> tuple[str, str]:
    """The name without the ending of a packed file, and the ending that is left."""
    inner = name[: -len(kind) - 1] if name.lower().endswith(f".{kind}") else name
    left = ending_of(inner)
    return inner, "" if left in (*PACKED, *ARCHIVES) else left


def _path(source: str | os.PathLike[str]) -> Path:
    try:
        path = Path(os.fsdecode(os.fspath(source)))
    except Exception as e:
        raise ArgumentError(f'source: expected a path, got {shown(source)} ({e}); try "scene.glb"') from e
    try:
        if path.is_dir():
            raise LoadError(f"{path}: expected a mesh file, found a directory; name a file in it")
        if not path.exists():
            raise LoadError(f"{path}: expected a mesh file, found nothing there; check the path")
        if not path.is_file():
            raise LoadError(f"{path}: expected a regular file, found a pipe or a device; read it and pass its bytes")
    except (OSError, ValueError) as e:
        if isinstance(e, LoadError):
            raise
        raise LoadError(f"{path}: expected a mesh file, could not look for it ({e}); check the path") from e
    return path


def _of_bytes(name: str, kind: str, data: bytes, limits: Limits) -> Given:
    check_limit(limits, name, "size", len(data), "bytes")
    return Given(name, kind, lambda: data, lambda _: None, limits)


def _of_stream(stream: Any, kind: str | None, limits: Limits) -> Given:
    name = getattr(stream, "name", None)
    try:
        label = os.fsdecode(os.fspath(name)) if isinstance(name, (str, bytes, os.PathLike)) else ""
    except Exception:  # noqa: BLE001 - a name that fails is none
        label = ""
    ending = kind or ending_of(label)
    if not ending:
        raise ArgumentError(
            'kind: expected the ending of a mesh file for a file without a name, got none; try kind="obj"'
        )
    shown_name = label or "the open file"
    data = _read(stream, shown_name, limits)
    if kind is None and ending in PACKED and not data.startswith(MAGICS[ending]):
        # An unpacking file, as of gzip.open, has the name of the packed one.
        ending = inner_ending(label, ending)[1] or ending
    if label and Path(label).is_file():
        beside = Given.of_file(Path(label), ending, limits)
        return Given(shown_name, ending, lambda: data, beside.find, limits)
    return _of_bytes(shown_name, ending, data, limits)


def _read(stream: Any, name: str, limits: Limits) -> bytes:
    """All that a file gives from where it stands; text as UTF-8."""
    if getattr(stream, "closed", False) is True:
        raise ArgumentError(f"source: expected an open file, got {name}, which is closed; open it")
    parts: list[bytes] = []
    total = 0
    while True:
        try:
            part = stream.read(_PART)
        except UnicodeDecodeError as e:
            raise LoadError(f"{name}: expected text, could not decode it ({e}); open it in binary mode") from e
        except Exception as e:
            raise LoadError(
                f"{name}: expected a readable file, could not read it ({type(e).__name__}: {e}); check it"
            ) from e
        if isinstance(part, str):
            part = part.encode("utf-8", "replace")
        if not isinstance(part, (bytes, bytearray, memoryview)):
            raise LoadError(f"{name}: expected bytes or text from its read, got {shown(part)}; open it in binary mode")
        if not len(part):
            break
        parts.append(bytes(part))
        total += len(part)
        check_limit(limits, name, "size", total, "bytes")
    return b"".join(parts)
