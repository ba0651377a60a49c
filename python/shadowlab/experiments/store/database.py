"""The file of a store: opening it, knowing it for one, and SQLite's errors as ours.

The header of the file names this program and the version of its format. Nothing is written to a file before it is known
for a store, or for an empty one.
"""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeVar, get_args

from ...errors import StoreError
from ...text import reason_of
from .mounts import network_type
from .row_text import DIGEST_BYTES_OF_ROW, digest_of_state

T = TypeVar("T")

#: How SQLite keeps what is written safe: a log beside the file, or a copy of what is overwritten.
Journal = Literal["wal", "delete"]
JOURNALS: tuple[Journal, ...] = get_args(Journal)

#: "slab": what `file` and SQLite show of the program that a file belongs to.
APPLICATION = 0x736C6162
#: What paths of stores are called where an error shows one.
EXAMPLE_FILE = "runs.sqlite"
#: The first bytes of a file of SQLite.
FIRST_BYTES = b"SQLite format 3\0"
#: Of the tables; raised when they change.
STORE_FORMAT = 1
#: A row of one run. `state` has what no single row tells: how many there are, and the digests of all together.
SCHEMA = """
create table runs (
    key text not null unique, version integer not null, done integer not null, digest blob not null, row text not null
);
create table state (rows integer not null, digests blob not null, digest blob not null);
"""
TABLE_NAMES = ("runs", "state")
# Seconds after which a file that another process holds is given up, and between looks: Python sees Ctrl-C in between.
LONGEST_WAIT, LOOK_EVERY = 60.0, 0.05

# What the module of SQLite raises; texts of damaged files are not always UTF-8, in its own messages neither.
UNREADABLE = (sqlite3.Error, UnicodeError)

_PROBLEMS = (
    ("file is not a database", "foreign", "it is not a store of shadowlab; choose another path"),
    ("file is encrypted", "foreign", "it is not a store of shadowlab; choose another path"),
    ("readonly", "read_only", "it cannot be written to; give the folder and the file write permission, or copy it"),
    ("is full", "full", "the disk is full; make room and run again, for what is finished is kept"),
    ("locked", "locked", "another process writes to it; wait for that one, or end it"),
    ("unable to open", "missing", "it cannot be opened; check that the folder is there and may be read and written"),
    ("disk i/o error", "disk", "the system could not read or write it; check the disk and its free space"),
)
FIX_DAMAGE = "move it away and run again, or restore a copy; `sqlite3 FILE .recover` shows what can be read of it"


def problem(path: Path, word: str, what: str) -> StoreError:
    """The error of a store, which names its file."""
    error = StoreError(f"store {str(path)!r}: {what}")
    error.problem = word
    return error


def damage(path: Path, what: str) -> StoreError:
    """The error of a store with rows that are not what was written."""
    return problem(path, "damaged", f"it is damaged ({what}); {FIX_DAMAGE}")


def store_error_of(path: Path, error: Exception) -> StoreError:
    """An error of SQLite as one of ours."""
    # Codes of errors are there from Python 3.11 on, the texts in all.
    text = str(error).lower()
    for words, word, what in _PROBLEMS:
        if words in text:
            return problem(path, word, f"{what} ({reason_of(error)})")
    return damage(path, reason_of(error))


def patiently(path: Path, do: Callable[[], T]) -> T:
    """The result of something that is tried again while another process holds the file.

    Raises
    ------
    StoreError
    """
    until = time.monotonic() + LONGEST_WAIT
    while True:
        try:
            return do()
        except UNREADABLE as error:
            found = store_error_of(path, error)
            if found.problem != "locked" or time.monotonic() > until:
                raise found from error
        time.sleep(LOOK_EVERY)


def connected(path: Path, mode: Literal["ro", "rwc"], immutable: bool = False) -> sqlite3.Connection:
    """A connection that writes nothing by itself; transactions are begun by hand."""
    uri = f"{path.absolute().as_uri()}?mode={mode}{'&immutable=1' if immutable else ''}"
    found = sqlite3.connect(uri, timeout=LOOK_EVERY, isolation_level=None, check_same_thread=False, uri=True)
    found.text_factory = bytes  # what is damaged need not be UTF-8
    return found


def opened_to_write(path: Path, journal: Journal | None) -> sqlite3.Connection:
    """A connection to a store, which is made where there is none.

    Raises
    ------
    StoreError
    """
    check_place(path, missing=True)
    network = network_type(path)
    if network and journal == "wal":
        what = f'it lies on a network file system ({network}), where WAL loses rows; give journal="delete"'
        raise problem(path, "disk", what)
    connection = patiently(path, lambda: connected(path, "rwc"))
    try:
        new = patiently(path, lambda: has_no_tables(path, connection))
        wanted: Journal | None = journal or ("delete" if network else "wal" if new else None)
        has = patiently(path, lambda: set_journal(connection, wanted))
        # A commit to the log waits for no disk. Without a log only a full wait keeps the file whole in a power cut.
        patiently(path, lambda: connection.execute(f"pragma synchronous = {'normal' if has == 'wal' else 'full'}"))
        if wanted is not None and has != wanted:
            raise problem(path, "disk", f"its file system has no journal {wanted!r}, but {has!r}; choose another path")
        if new:
            patiently(path, lambda: make_tables(path, connection))
    except BaseException:
        connection.close()
        raise
    return connection


def opened_to_read(path: Path) -> sqlite3.Connection:
    """A connection to a store that is there; works in folders that may not be written to.

    Raises
    ------
    StoreError
    """
    check_place(path, missing=False)
    log = path.with_name(f"{path.name}-wal")
    try:
        return _reading(path, immutable=False)
    except StoreError as error:
        # WAL needs a file beside the store; without a log there is nothing in it that could change the rows.
        if error.problem not in ("missing", "read_only") or log.exists():
            raise
    return _reading(path, immutable=True)


def _reading(path: Path, immutable: bool) -> sqlite3.Connection:
    connection = patiently(path, lambda: connected(path, "ro", immutable))
    try:
        if patiently(path, lambda: has_no_tables(path, connection)):
            raise problem(path, "foreign", "it holds no runs; give the path that `sl.sweep(..., store=path)` was given")
    except BaseException:
        connection.close()
        raise
    return connection


def check_place(path: Path, missing: bool) -> None:
    """Raises for a path that no store can have; `missing` says whether there may be none yet.

    Raises
    ------
    StoreError
    """
    try:
        if path.is_file():
            with path.open("rb") as file:
                head = file.read(len(FIRST_BYTES))
            # SQLite takes a file of less than 512 bytes for an empty one.
            if head not in (b"", FIRST_BYTES):
                raise problem(path, "foreign", "it is not a store of shadowlab; choose another path")
            return
        if missing and not path.exists() and path.parent.is_dir():
            if not os.access(path.parent, os.W_OK):
                raise problem(path, "read_only", "its folder may not be written to; give it write permission")
            return
        what = "it is not a file" if path.exists() else "there is no such file"
        if not path.exists() and not path.parent.is_dir():
            what = f"there is no folder {str(path.parent)!r}"
    except StoreError:
        raise
    except PermissionError as error:
        what = f"it may not be read ({error.strerror}); give it read and write permission"
        raise problem(path, "read_only", what) from None
    except (OSError, ValueError) as error:
        what = reason_of(error)
    raise problem(path, "missing", f"{what}; give the path of a file, in a folder that is there")


def has_no_tables(path: Path, connection: sqlite3.Connection) -> bool:
    """Whether a file has no tables yet; raises for one that is no store of a version that is known.

    Raises
    ------
    StoreError
    """
    application, version, tables = header_of(connection)
    if not tables and application == 0 and version == 0:
        return True
    if application != APPLICATION:
        raise problem(path, "foreign", "it is a database of another program; choose another path")
    if version > STORE_FORMAT:
        what = f"a newer shadowlab wrote it (format {version}, known is {STORE_FORMAT})"
        raise problem(path, "newer", f"{what}; update shadowlab, or choose another path")
    if version < 1 or tables != [name.encode() for name in TABLE_NAMES]:
        raise damage(path, "its tables are others")
    return False


def header_of(connection: sqlite3.Connection) -> tuple[int, int, list[bytes]]:
    """The numbers of the program and of the format, and the names of the tables, all as of one moment."""
    alone = not connection.in_transaction
    if alone:
        # Another process may make the tables between one question and the next.
        connection.execute("begin")
    try:
        (application,), (version,) = (
            connection.execute(f"pragma {name}").fetchone() for name in ("application_id", "user_version")
        )
        names = connection.execute("select name from sqlite_master where type = 'table' order by name").fetchall()
    finally:
        if alone and connection.in_transaction:
            connection.execute("rollback")
    return application, version, [name for (name,) in names]


def set_journal(connection: sqlite3.Connection, wanted: Journal | None) -> str:
    """The journal that the file has then."""
    (has,) = connection.execute("pragma journal_mode").fetchone()
    if wanted is not None and has != wanted.encode():
        (has,) = connection.execute(f"pragma journal_mode = {wanted}").fetchone()
    return str(has.decode())


def make_tables(path: Path, connection: sqlite3.Connection) -> None:
    """Makes a store of an empty file, unless another process did so meanwhile."""
    connection.execute("begin immediate")
    try:
        if has_no_tables(path, connection):
            for statement in SCHEMA.split(";"):
                connection.execute(statement)
            connection.execute(f"pragma application_id = {APPLICATION}")
            connection.execute(f"pragma user_version = {STORE_FORMAT}")
            count, digests = 0, bytes(DIGEST_BYTES_OF_ROW)
            connection.execute("insert into state values (?, ?, ?)", (count, digests, digest_of_state(count, digests)))
        connection.execute("commit")
    except BaseException:
        if connection.in_transaction:
            connection.execute("rollback")
        raise
