"""The store of runs: one SQLite file to which several processes add rows, each kept at once.

```
    run_key(view, technique, ...) -> key        a digest of everything that the row depends on
    missing(keys)                               what is not done yet
    put(key, row)                               committed when it returns; a killed process loses the run in flight
    rows(keys)                                  bit for bit what was put
```
"""

from __future__ import annotations

import os
import sqlite3
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, TypeVar, cast

from ...errors import ArgumentError, StateError
from ...text import shown
from ...text.arrays import checked_items
from ...text.checked import a_flag, a_path, a_text, a_word
from .database import EXAMPLE_FILE, JOURNALS, Journal, damage, opened_to_write, patiently, problem
from .keys import ALGORITHMS
from .row_text import Cell, digest_of_row, digest_of_state, text_of_row, xored
from .whole import READ_FIELDS, all_rows, row_from, state_of

T = TypeVar("T")

#: Letters of a key.
LONGEST_KEY = 200
# Keys that one question to SQLite names: older ones take 999.
KEYS_AT_ONCE = 500


class Store:
    """Rows of runs in one file, by keys.

    Parameters
    ----------
    path : path
        The file; made where there is none. Beside it SQLite keeps two more while it is open, ``-wal`` and ``-shm``.
    journal : {"wal", "delete"}, optional
        "wal" writes each row to a log and waits for no disk: a killed process loses nothing that `put` returned from, a
        power cut the rows of the last moments, never the file. "delete" waits for the disk with every row and works
        on network file systems. None takes what the file has; of a new one "wal", and "delete" on a network file
        system that is known for one.

    Raises
    ------
    ArgumentError
        For something that is no path or journal.
    StoreError
        For a file of another program or of a newer shadowlab, a damaged or locked one, one that cannot be written, and
        "wal" on a network file system. The message names the file and says what to do.

    Notes
    -----
    Opening reads the file once and holds every row against its digest. A store belongs to the process that opened it;
    its threads may share it, other processes open it again by its path.

    Examples
    --------
    >>> import tempfile, shadowlab as sl
    >>> folder = tempfile.TemporaryDirectory()
    >>> with sl.Store(f"{folder.name}/runs.sqlite") as store:
    ...     store.put("a", {"technique": "lispsm", "misclassified": 12})
    ...     store.missing(["a", "b"]), store.rows(["a"])
    (['b'], {'a': {'technique': 'lispsm', 'misclassified': 12}})
    """

    def __init__(self, path: str | os.PathLike[str], journal: Journal | None = None):
        self._path = a_path("path", path, EXAMPLE_FILE)
        a_word((*JOURNALS, None), "None takes what suits the file")("journal", journal)
        self._lock, self._process = threading.RLock(), os.getpid()
        self._connection: sqlite3.Connection | None = opened_to_write(self._path, journal)
        try:
            for _ in all_rows(self._path, self._connection):
                pass
        except BaseException:
            self.close()
            raise

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def journal(self) -> str:
        """How what is written is kept safe: "wal" or "delete"."""
        return str(self._asked(lambda sql: sql.execute("pragma journal_mode").fetchone()[0]).decode())

    def missing(self, keys: Iterable[str]) -> list[str]:
        """The keys of which no done row is there, each once, in their order.

        Raises
        ------
        ArgumentError
            For something that is no list of keys.
        StoreError
            Where the file cannot be read.
        """
        wanted = checked_keys(keys)
        found: set[bytes] = set()
        for names in _parts(wanted):
            marks = ",".join("?" * len(names))
            sql = f"select cast(key as blob) from runs where done = 1 and key in ({marks})"
            found |= {key for (key,) in self._asked(_question(sql, names))}
        return [key for key in wanted if key.encode() not in found]

    def rows(self, keys: Iterable[str]) -> dict[str, dict[str, Cell]]:
        """The rows of these keys, in their order, those that are not done among them; keys without a row are left out.

        Raises
        ------
        ArgumentError
            For something that is no list of keys.
        StoreError
            Where the file cannot be read, and for a row that is not what was put.
        """
        wanted = checked_keys(keys)
        found: dict[str, dict[str, Cell]] = {}
        for names in _parts(wanted):
            marks = ",".join("?" * len(names))
            for fields in self._asked(_question(f"select {READ_FIELDS} from runs where key in ({marks})", names)):
                row = row_from(self._path, fields)
                found[row.key] = row.cells(self._path)
        if not found.keys() <= set(wanted):
            raise damage(self._path, "it gives rows that were not asked for")
        return {key: found[key] for key in wanted if key in found}

    def put(self, key: str, row: Mapping[str, Cell], *, done: bool = True) -> None:
        """Keeps a row; it is in the file when this returns.

        Parameters
        ----------
        key : str
        row : mapping
            Names of columns to None, bool, int of 64 bits, float or str; numbers of numpy become those. NaN becomes
            None, for it stands for no number.
        done : bool
            False for a failure that another try may mend, such as a worker that was killed: the row is there, but its
            key stays `missing`. It takes the place of no done row.

        Raises
        ------
        ArgumentError
            For a key that is no text of 1 to 200 letters, and a row that cannot be kept.
        StoreError
            Where the file cannot be written: a full disk, a file that is read-only, one that stays locked. What was
            kept before is still there.
        """
        name, text = checked_key(key), text_of_row(row).encode()
        digest = digest_of_row(name.encode(), ALGORITHMS, a_flag("done", done), text)
        fields = (name, ALGORITHMS, int(done), digest, text.decode())
        self._asked(lambda sql: self._written(sql, fields))

    def __len__(self) -> int:
        return self._asked(lambda sql: state_of(self._path, sql))[0]

    def close(self) -> None:
        """Ends the use of the file; again does nothing."""
        with self._lock:
            connection, self._connection = self._connection, None
            # A connection that a fork copied belongs to the process that opened it.
            if connection is not None and self._process == os.getpid():
                connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise StateError("Store: expected a value, got an open file; send its path, and open it again there")

    def __repr__(self) -> str:
        return f"Store({str(self._path)!r}{', closed' if self._connection is None else ''})"

    def _asked(self, question: Callable[[sqlite3.Connection], T]) -> T:
        """What the file answers, once no other process holds it."""
        if self._process != os.getpid():
            raise problem(self._path, "closed", "another process opened it; open it again in this one")
        with self._lock:
            connection = self._connection
            if connection is None:
                raise problem(self._path, "closed", "it is closed; open it again")
            return patiently(self._path, lambda: question(connection))

    def _written(self, sql: sqlite3.Connection, fields: tuple[str, int, int, bytes, str]) -> None:
        """Writes a row and what is known of all rows together."""
        key, _, done, digest, _ = fields
        sql.execute("begin immediate")
        try:
            there = sql.execute("select digest, done from runs where key = ?", (key,)).fetchone()
            if there is None or done or not there[1]:
                count, digests = state_of(self._path, sql)
                if there is None:
                    count, digests = count + 1, xored(digests, digest)
                    sql.execute("insert into runs values (?, ?, ?, ?, ?)", fields)
                else:
                    if not isinstance(there[0], bytes) or len(there[0]) != len(digest):
                        raise damage(self._path, "the digest of a row is missing")
                    digests = xored(digests, there[0], digest)
                    change = "update runs set version = ?, done = ?, digest = ?, row = ? where key = ?"
                    sql.execute(change, (*fields[1:], key))
                state = (count, digests, digest_of_state(count, digests))
                sql.execute("update state set rows = ?, digests = ?, digest = ?", state)
            sql.execute("commit")
        except BaseException:
            if sql.in_transaction:
                sql.execute("rollback")
            raise


def checked_key(key: object) -> str:
    """The key of a row.

    Raises
    ------
    ArgumentError
    """
    text = a_text("key", key)
    if not 0 < len(text) <= LONGEST_KEY or "\0" in text:
        raise ArgumentError(f"key: expected 1 to {LONGEST_KEY} letters, got {shown(key)}; run_key makes one")
    return text


def checked_keys(keys: object) -> list[str]:
    """The keys of rows, each once.

    Raises
    ------
    ArgumentError
    """
    fix = "run_key makes them"
    if isinstance(keys, (str, bytes)):
        raise ArgumentError(f"keys: expected several keys, got {shown(keys)}; give a list")
    # Lists and the like are as long as they say; what else may be read has a limit.
    plain = type(keys) in (list, tuple, dict)
    given = cast("Iterable[object]", keys) if plain else checked_items("keys", keys, "several keys", fix)
    return list(dict.fromkeys(map(checked_key, given)))


def _parts(keys: Sequence[str]) -> Iterable[Sequence[str]]:
    return (keys[i : i + KEYS_AT_ONCE] for i in range(0, len(keys), KEYS_AT_ONCE))


def _question(text: str, names: Sequence[str]) -> Callable[[sqlite3.Connection], list[tuple[Any, ...]]]:
    return lambda sql: sql.execute(text, tuple(names)).fetchall()
