"""The store of runs: rows come back bit for bit, several processes write at once, files that are none are refused."""

from __future__ import annotations

import math
import os
import pickle
import sqlite3
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, StateError, StoreError
from shadowlab.experiments.store import database, mounts
from shadowlab.experiments.store.keys import ALGORITHMS

ROW = {
    "technique": "lispsm", "notes": "größer, 'quoted' \\ \n\0 end", "failure": "", "none": None, "yes": True,
    "no": False, "one": 1, "one_as_float": 1.0, "largest": 2**63 - 1, "least": -(2**63), "tenth": 0.1, "tiny": 5e-324,
    "huge": 1.7976931348623157e308, "minus_zero": -0.0, "infinite": math.inf, "minus_infinite": -math.inf,
}  # fmt: skip
WRITE_MANY = """
import sys, shadowlab as sl
path, name, count, journal = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
with sl.Store(path, journal=journal) as store:
    for i in range(count):
        store.put(f"{name}-{i}", {"by": name, "i": i})
        store.put("shared", {"by": name, "i": i})
"""


def same_bits(a, b):
    """Whether two rows are the same: names in order, types, and bits."""
    kinds = [(type(x), type(y)) for x, y in zip(a.values(), b.values(), strict=True)]
    return list(a) == list(b) and all(x is y for x, y in kinds) and repr(a) == repr(b)


def refused(path, problem, **how):
    with pytest.raises(StoreError) as found:
        sl.Store(path, **how)
    assert found.value.problem == problem
    assert str(path) in str(found.value)
    return str(found.value)


def test_rows_come_back_bit_for_bit(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", ROW)
        assert same_bits(store.rows(["a"])["a"], ROW)
    with sl.Store(path) as again:
        assert same_bits(again.rows(["a"])["a"], ROW)
        assert len(again) == 1
    assert not same_bits(ROW | {"one": 1.0}, ROW), "the comparison sees a type"
    assert not same_bits(ROW | {"minus_zero": 0.0}, ROW), "the comparison sees a sign"


def test_numbers_of_numpy_become_plain_ones(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        store.put("a", {"i": np.int64(7), "u": np.uint8(255), "f": np.float32(0.1), "b": np.bool_(True), "n": np.nan})
        wanted = {"i": 7, "u": 255, "f": float(np.float32(0.1)), "b": True, "n": None}
        assert same_bits(store.rows(["a"])["a"], wanted)


def test_what_is_missing_is_found_in_its_order(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        for i in range(0, 1500, 2):
            store.put(str(i), {"i": i})
        keys = [str(i) for i in range(1500)]
        assert store.missing([*keys, "1"]) == [str(i) for i in range(1, 1500, 2)]
        assert list(store.rows(reversed(keys))) == [str(i) for i in range(1498, -1, -2)]
        assert store.missing(iter(["x", "0"])) == ["x"]
        assert store.rows([]) == {}


def test_a_failure_that_may_pass_is_kept_and_stays_missing(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        store.put("a", {"failure": "killed"}, done=False)
        assert store.missing(["a"]) == ["a"]
        assert store.rows(["a"]) == {"a": {"failure": "killed"}}
        store.put("a", {"failure": ""})
        store.put("a", {"failure": "killed again"}, done=False)
        assert store.missing(["a"]) == []
        assert store.rows(["a"]) == {"a": {"failure": ""}}
        assert len(store) == 1


@pytest.mark.parametrize(
    ("key", "row", "said"),
    [
        ("", {}, "key"), ("x" * 201, {}, "key"), ("a\0b", {}, "key"), (1, {}, "key"), ("a", None, "row"),
        ("a", [("a", 1)], "row"), ("a", {1: 2}, "row"), ("a", {"": 2}, "row"), ("a", {"big": 2**63}, "big"),
        ("a", {"big": 10**5000}, "big"), ("a", {"list": [1]}, "list"), ("a", {"complex": 1j}, "complex"),
        ("a", {"text": "\ud800"}, "text"), ("a", {"long": "x" * (1 << 24)}, "row"), ("a", {"bytes": b"x"}, "bytes"),
        ("a", {str(i): i for i in range(2001)}, "row"),
    ],
)  # fmt: skip
def test_rows_that_cannot_be_kept_are_refused(tmp_path, key, row, said):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        with pytest.raises(ArgumentError, match=said):
            store.put(key, row)
        assert len(store) == 0


# Every row waits for the disk without a log.
@pytest.mark.parametrize(("journal", "count"), [("wal", 60), ("delete", 15)])
def test_several_processes_write_at_once(tmp_path, journal, count):
    path, names = tmp_path / "runs.sqlite", "abcd"
    words = [sys.executable, "-c", WRITE_MANY, str(path)]
    work = [subprocess.Popen([*words, name, str(count), journal]) for name in names]
    assert [one.wait(60) for one in work] == [0] * len(names)
    with sl.Store(path) as store:
        keys = [f"{name}-{i}" for name in names for i in range(count)]
        assert store.rows(keys) == {f"{name}-{i}": {"by": name, "i": i} for name in names for i in range(count)}
        assert len(store) == len(keys) + 1


def test_threads_share_a_store(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:

        def write(name):
            for i in range(50):
                store.put(f"{name}-{i}", {"i": i})
                assert store.rows([f"{name}-{i}"])

        threads = [threading.Thread(target=write, args=(name,)) for name in "abcd"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(store) == 200


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_opens_its_own(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", {})
        child = os.fork()
        if child == 0:
            try:
                store.rows(["a"])
            except StoreError:
                store.close()
                os._exit(0)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        store.put("b", {})
        assert store.missing(["a", "b"]) == []


def test_a_store_that_is_closed_says_so_and_does_not_travel(tmp_path):
    store = sl.Store(tmp_path / "runs.sqlite")
    with pytest.raises(StateError, match="path"):
        pickle.dumps(store)
    store.close()
    store.close()
    assert "closed" in repr(store)
    with pytest.raises(StoreError, match="open it again"):
        store.rows(["a"])


def test_files_that_are_no_store_are_refused_and_stay_as_they_are(tmp_path):
    for name, content in {"text": b"key,row\n" * 400, "short": b"x"}.items():
        path = tmp_path / name
        path.write_bytes(content)
        assert "another path" in refused(path, "foreign")
        assert path.read_bytes() == content
    path = tmp_path / "other.sqlite"
    with sqlite3.connect(path) as other:
        other.execute("create table runs (key)")
    content = path.read_bytes()
    assert "another program" in refused(path, "foreign")
    assert path.read_bytes() == content
    assert "not a file" in refused(tmp_path, "missing")
    assert "no folder" in refused(tmp_path / "none" / "runs.sqlite", "missing")


def test_an_empty_file_becomes_a_store(tmp_path):
    path = tmp_path / "runs.sqlite"
    path.touch()
    with sl.Store(path) as store:
        store.put("a", {})
    assert path.stat().st_size > 0


def test_a_newer_store_is_refused(tmp_path):
    path = tmp_path / "runs.sqlite"
    sl.Store(path).close()
    with sqlite3.connect(path) as sql:
        sql.execute(f"pragma user_version = {database.STORE_FORMAT + 1}")
    assert "update shadowlab" in refused(path, "newer")


@pytest.mark.parametrize(
    "harm",
    [
        "delete from runs where key = 'b'",
        "update runs set row = replace(row, '1', '2') where key = 'b'",
        "update runs set key = 'c' where key = 'b'",
        "update runs set done = 0 where key = 'b'",
        "update runs set version = version + 1 where key = 'b'",
        "update state set rows = rows - 1",
        "delete from state",
        "insert into runs select 'c', version, done, digest, row from runs where key = 'b'",
        "drop table state",
    ],
)
def test_rows_that_were_changed_are_refused(tmp_path, harm):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", {"i": 0})
        store.put("b", {"i": 1})
        with sqlite3.connect(path) as sql:
            sql.execute(harm)
        sql.close()
        if "where key = 'b'" in harm and harm.startswith("update runs set row"):
            with pytest.raises(StoreError, match="damaged"):
                store.rows(["b"])
    assert ".recover" in refused(path, "damaged")


def test_a_store_that_stays_locked_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(database, "LONGEST_WAIT", 0.1)
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        holder = sqlite3.connect(path, isolation_level=None)
        holder.execute("begin immediate")
        with pytest.raises(StoreError, match="another process") as found:
            store.put("a", {})
        assert found.value.problem == "locked"
        assert str(path) in str(found.value)
        holder.execute("rollback")
        holder.close()
        store.put("a", {})


def test_a_full_disk_is_an_error_and_what_was_kept_stays(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", {"i": 0})
        store._connection.execute("pragma max_page_count = 8")
        with pytest.raises(StoreError, match="full") as found:
            store.put("b", {"notes": "x" * 40_000})
        assert found.value.problem == "full"
        assert str(path) in str(found.value)
        assert store.rows(["a"]) == {"a": {"i": 0}}
    with sl.Store(path) as store:
        store.put("c", {})
        assert store.missing(["a", "c"]) == []


def test_a_store_that_cannot_be_written_says_so(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", {"i": 0})
        store._connection.execute("pragma query_only = 1")
        with pytest.raises(StoreError, match="write permission") as found:
            store.put("b", {})
        assert found.value.problem == "read_only"
        assert store.missing(["a", "b"]) == ["b"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_folders_that_may_not_be_written_to_are_read(tmp_path):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "runs.sqlite"
        with sl.Store(path) as store:
            store.put("a", {"i": 0})
        Path(folder).chmod(0o555)
        child = os.fork()
        if child == 0:
            status = 1
            try:
                if os.geteuid() == 0:
                    os.setuid(65534)  # nobody, whom permissions bind
                problems = []
                for place in (path, path.with_name("new.sqlite")):
                    try:
                        sl.Store(place).put("b", {})
                    except StoreError as error:
                        problems.append(error.problem)
                status = 0 if len(sl.read_store(path)) == 1 and problems == ["read_only"] * 2 else 2
            finally:
                os._exit(status)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        Path(folder).chmod(0o755)


def test_the_journal_is_chosen(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        assert store.journal == "wal"
        store.put("a", {"i": 0})
    with sl.Store(path, journal="delete") as store:
        assert store.journal == "delete"
        store.put("b", {"i": 1})
    with sl.Store(path) as store:
        assert store.journal == "delete", "None takes what the file has"
    with sl.Store(path, journal="wal") as store:
        assert store.journal == "wal"
        assert store.missing(["a", "b"]) == []


def test_network_file_systems_get_no_log(tmp_path, monkeypatch):
    mounted = f"21 1 0:1 / / rw - ext4 /dev/a rw\n22 21 0:2 / {tmp_path}/a\\040b rw shared:1 - nfs4 host:/x rw\n"
    folder = tmp_path / "a b"
    folder.mkdir()
    assert mounts.network_type(folder / "runs.sqlite", mounted) == "nfs4"
    assert mounts.network_type(tmp_path / "runs.sqlite", mounted) == ""
    over = mounted + f"23 22 0:3 / {tmp_path}/a\\040b rw - tmpfs none rw\n"
    assert mounts.network_type(folder / "runs.sqlite", over) == "", "the last mount hides the others"
    monkeypatch.setattr(database, "network_type", lambda path: "nfs4")
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        assert store.journal == "delete"
        store.put("a", {})
    assert 'journal="delete"' in refused(path, "disk", journal="wal")


def test_names_with_letters_of_addresses_are_files(tmp_path):
    for name in ("a b", "a?mode=memory", "a#b", "a%41", "ä"):
        with sl.Store(tmp_path / name) as store:
            store.put("a", {})
        assert (tmp_path / name).is_file()


def test_rows_know_the_version_of_the_algorithms(tmp_path):
    path = tmp_path / "runs.sqlite"
    with sl.Store(path) as store:
        store.put("a", {})
    with sqlite3.connect(path) as sql:
        assert sql.execute("select version from runs").fetchall() == [(ALGORITHMS,)]
