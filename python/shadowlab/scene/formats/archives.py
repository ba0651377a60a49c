"""Archives: their entries by name, unpacked within limits that count what really comes out.

Only regular files with names below the archive's own root are taken; nothing is written anywhere.
"""

from __future__ import annotations

import bz2
import gzip
import io
import stat
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, cast

from ...errors import LoadError
from .given import Given, inside
from .limits import check_limit

#: Endings of archives, longer ones first, and how they are packed.
ARCHIVES = {
    "tar.bz2": "tar.bz2",
    "tar.gz": "tar.gz",
    "tbz2": "tar.bz2",
    "tgz": "tar.gz",
    "tar": "tar",
    "zip": "zip",
    "zae": "zip",
}
#: Endings of single packed files.
PACKED = ("gz", "bz2")
#: What packed files begin with.
MAGICS = {"gz": b"\x1f\x8b", "bz2": b"BZh"}
#: Bytes that are unpacked before their ratio counts: less harms nobody, however well it was packed.
_HARMLESS = 16 << 20
_CHUNK = 1 << 20
_FAILURES = (OSError, EOFError, RuntimeError, NotImplementedError, ValueError, zlib.error, zipfile.BadZipFile)


class Archive:
    """The files in an archive.

    Attributes
    ----------
    names : list of str
        In their order in the archive.
    """

    def __init__(self, names: list[str], read: Callable[[str], bytes]):
        self.names = names
        self.read = read

    @classmethod
    def of(cls, given: Given, packing: str) -> Archive:
        """The archive in a file, packed as `ARCHIVES` says.

        Raises
        ------
        LoadError
            For what is no such archive, entries with names outside it, links, and beyond a limit.
        """
        with _unpacking(given.name):
            return _zip(given) if packing == "zip" else _tar(given, packing)


def unpacked(given: Given, packing: str) -> bytes:
    """The one file in a .gz or .bz2.

    Raises
    ------
    LoadError
        For what is no such file, and beyond a limit.
    """
    with _unpacking(given.name):
        stream = _Counted(given, packing)
        parts = []
        while part := stream.read(_CHUNK):
            parts.append(part)
        return b"".join(parts)


@contextmanager
def _unpacking(name: str) -> Iterator[None]:
    try:
        yield
    except LoadError:
        raise
    except (*_FAILURES, tarfile.TarError) as e:
        raise LoadError(f"{name}: expected a readable archive, could not unpack it ({e}); check the file") from e


class _Counter:
    """Counts what is unpacked."""

    def __init__(self, given: Given):
        self.given, self.total = given, 0

    def add(self, count: int, packed: int) -> None:
        """Counts bytes that came from so many packed ones in all."""
        self.total += count
        limits, name = self.given.limits, self.given.name
        check_limit(limits, name, "size", self.total, "bytes unpacked")
        if self.total > _HARMLESS:
            check_limit(limits, name, "ratio", self.total / max(packed, 1), "bytes for each packed byte")


class _Counted:
    """A packed stream that counts what comes out of it."""

    def __init__(self, given: Given, packing: str):
        self.packed = io.BytesIO(given.data)
        self.counter = _Counter(given)
        opened = gzip.GzipFile(fileobj=self.packed) if packing.endswith("gz") else bz2.BZ2File(self.packed)
        self.stream = cast("IO[bytes]", opened if packing.endswith(("gz", "bz2")) else self.packed)

    def read(self, size: int) -> bytes:
        """At most so many bytes."""
        part = self.stream.read(min(size, _CHUNK))
        self.counter.add(len(part), self.packed.tell())
        return part


def _entry(given: Given, name: str, is_link: bool) -> str:
    """The name of an entry as a path below the archive's root."""
    if is_link:
        raise LoadError(
            f"{given.name}: expected regular files, got the link {name!r}; links in archives are not followed"
        )
    return inside(given.name, name, is_uri=False)


def _zip(given: Given) -> Archive:
    data = given.data
    end = data.rfind(b"PK\x05\x06")
    listed = int.from_bytes(data[end + 12 : end + 16], "little") if end >= 0 else 0
    directory = data[max(end - listed, 0) : max(end, 0)]
    check_limit(given.limits, given.name, "entries", directory.count(b"PK\x01\x02"), "files in an archive")
    packed = zipfile.ZipFile(io.BytesIO(data))
    infos = packed.infolist()
    check_limit(given.limits, given.name, "entries", len(infos), "files in an archive")
    by_name: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        name = _entry(given, info.filename, stat.S_ISLNK(info.external_attr >> 16))
        if not info.is_dir():
            by_name.setdefault(name, info)
    counter = _Counter(given)

    def read(name: str) -> bytes:
        info = by_name[name]
        check_limit(given.limits, given.name, "size", info.file_size, f"bytes of {name!r}")
        if info.file_size > _HARMLESS:
            ratio = info.file_size / max(info.compress_size, 1)
            check_limit(given.limits, given.name, "ratio", ratio, "bytes for each packed byte")
        parts = []
        with _unpacking(f"{given.name}/{name}"), packed.open(info) as stream:
            while part := stream.read(_CHUNK):
                counter.add(len(part), len(data))
                parts.append(part)
        return b"".join(parts)

    return Archive(list(by_name), read)


def _tar(given: Given, packing: str) -> Archive:
    stream = _Counted(given, packing)
    files: dict[str, bytes] = {}
    entries = 0
    with tarfile.open(fileobj=cast("IO[bytes]", stream), mode="r|", bufsize=_CHUNK) as packed:
        for member in packed:
            entries += 1
            check_limit(given.limits, given.name, "entries", entries, "files in an archive")
            name = _entry(given, member.name, member.issym() or member.islnk())
            if member.isdir():
                continue
            if not member.isreg() or member.issparse():
                raise LoadError(f"{given.name}: expected regular files, got {name!r} of another kind; pack it anew")
            check_limit(given.limits, given.name, "size", member.size, f"bytes of {name!r}")
            content = packed.extractfile(member)
            files.setdefault(name, b"" if content is None else content.read())
    return Archive(list(files), files.__getitem__)
