"""Whether a store is whole: every row is what was written, none is missing, and none is there twice."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .database import UNREADABLE, damage, patiently, store_error_of
from .row_text import DIGEST_BYTES_OF_ROW, Cell, digest_of_row, digest_of_state, row_of_text, xored

#: What is read of a row, as bytes whatever the damage made of it.
READ_FIELDS = "cast(key as blob), version, done, digest, cast(row as blob)"


@dataclass(frozen=True)
class KeptRow:
    """A row of a store.

    Attributes
    ----------
    key : str
    version : int
        `keys.ALGORITHMS` when it was written.
    done : bool
    digest : bytes
    text : bytes
    """

    key: str
    version: int
    done: bool
    digest: bytes
    text: bytes

    def cells(self, path: Path) -> dict[str, Cell]:
        """The row itself; `path` is for the message of an error.

        Raises
        ------
        StoreError
        """
        try:
            return row_of_text(self.text.decode("utf-8"))
        except (ValueError, RecursionError):
            raise damage(path, f"the row of {self.key} does not read") from None


def row_from(path: Path, fields: tuple[object, ...]) -> KeptRow:
    """A row from what was read of it.

    Raises
    ------
    StoreError
        Unless it is what was written.
    """
    match fields:
        case (bytes(key), int(version), 0 | 1 as done, bytes(digest), bytes(text)):
            if digest == digest_of_row(key, version, bool(done), text):
                return KeptRow(key.decode("utf-8"), version, bool(done), digest, text)
    raise damage(path, "a row is not what was written")


def state_of(path: Path, connection: sqlite3.Connection) -> tuple[int, bytes]:
    """How many rows there are, and their digests xored, as the file says itself.

    Raises
    ------
    StoreError
    """
    states = connection.execute("select rows, digests, digest from state limit 2").fetchall()
    if len(states) == 1:
        rows, digests, digest = states[0]
        kinds = isinstance(rows, int) and isinstance(digests, bytes) and len(digests) == DIGEST_BYTES_OF_ROW
        if kinds and digest == digest_of_state(rows, digests):
            return rows, digests
    raise damage(path, "the count of its rows is not what was written")


def all_rows(path: Path, connection: sqlite3.Connection) -> Iterator[KeptRow]:
    """The rows in the order in which they were written first, as of one moment.

    Raises
    ------
    StoreError
        At the latest with the last row, unless the store is whole.
    """
    try:
        connection.execute("begin")
        try:
            # The first look takes the lock, which another process may hold; all others are of the same moment.
            patiently(path, lambda: connection.execute("select 1 from state").fetchone())
            faults = connection.execute("pragma integrity_check(1)").fetchone()[0]
            if faults != b"ok":
                raise damage(path, " ".join(faults.decode("utf-8", "replace").split())[:80])
            wanted, count, digests = state_of(path, connection), 0, bytes(DIGEST_BYTES_OF_ROW)
            for fields in connection.execute(f"select {READ_FIELDS} from runs order by rowid"):
                row = row_from(path, fields)
                count, digests = count + 1, xored(digests, row.digest)
                yield row
            if (count, digests) != wanted:
                raise damage(path, f"it has {count:,} of {wanted[0]:,} rows")
        finally:
            if connection.in_transaction:
                connection.execute("rollback")
    except UNREADABLE as error:
        raise store_error_of(path, error) from error
