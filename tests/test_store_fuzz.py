"""Damaged stores: every read gives the rows that were put, or an error of ours that names the file; never others."""

from __future__ import annotations

import random
import shutil

import pytest
from store_support import key_of, row_of

import shadowlab as sl
from shadowlab.errors import StoreError

ROWS = 60
#: Damaged copies of each kind.
COPIES = 100


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    path = tmp_path_factory.mktemp("good") / "runs.sqlite"
    with sl.Store(path) as store:
        for i in range(ROWS):
            store.put(key_of(i), row_of(i))
    return path


def said(error, path):
    """1 of an error that names the file and says what is wrong with it."""
    assert str(path) in str(error)
    assert error.problem in ("damaged", "foreign", "newer", "missing", "disk", "full")
    return 1


def flipped(chance, data):
    """One bit, or some bytes, are others."""
    for _ in range(chance.choice((1, 1, 1, 8, 64))):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return data


def header_flipped(chance, data):
    data[chance.randrange(100)] = chance.randrange(256)
    return data


def cut(chance, data):
    return data[: chance.randrange(len(data))]


def overwritten(chance, data):
    """A part of the file is that of another place, or nothing."""
    at, size = chance.randrange(len(data)), chance.choice((16, 512, 4096))
    other = chance.randrange(len(data))
    data[at : at + size] = data[other : other + size] if chance.random() < 0.5 else bytes(size)
    return data


def page_swapped(chance, data):
    """Two pages change places."""
    pages = len(data) // 4096
    a, b = chance.randrange(pages) * 4096, chance.randrange(pages) * 4096
    data[a : a + 4096], data[b : b + 4096] = data[b : b + 4096], data[a : a + 4096]
    return data


@pytest.mark.parametrize("harm", [flipped, header_flipped, cut, overwritten, page_swapped])
def test_a_damaged_file_is_refused_or_has_the_rows_that_were_put(tmp_path, good, harm):
    chance = random.Random(harm.__name__)
    wanted = {key_of(i): row_of(i) for i in range(ROWS)}
    refused = 0
    for n in range(COPIES):
        path = tmp_path / f"{n}.sqlite"
        data = bytes(harm(chance, bytearray(good.read_bytes())))
        path.write_bytes(data)
        try:
            with sl.Store(path) as store:
                found = store.rows(wanted)
                missing = store.missing(wanted)
            table = sl.read_store(path)
        except StoreError as error:
            refused += said(error, path)
            continue
        if not data:
            continue  # an empty file becomes a store
        assert found == wanted
        assert list(map(repr, found.values())) == list(map(repr, wanted.values()))
        assert missing == []
        assert len(table) == ROWS
    assert refused > COPIES // 5


def test_damage_after_opening_is_no_wrong_row(tmp_path, good):
    chance = random.Random(5)
    wanted = {key_of(i): row_of(i) for i in range(ROWS)}
    refused = 0
    for n in range(COPIES):
        path = tmp_path / f"{n}.sqlite"
        shutil.copy(good, path)
        with sl.Store(path, journal="delete") as store:
            data = flipped(chance, bytearray(path.read_bytes()))
            path.write_bytes(bytes(data))
            store._connection.execute("pragma shrink_memory")
            try:
                found = store.rows(wanted)
            except StoreError as error:
                refused += said(error, path)
                continue
        assert all(row == wanted[key] for key, row in found.items())
    assert refused > COPIES // 20


def test_a_damaged_log_loses_rows_and_makes_none_up(tmp_path):
    chance = random.Random(7)
    wanted = {key_of(i): row_of(i) for i in range(ROWS)}
    source = tmp_path / "open.sqlite"
    lost = 0
    with sl.Store(source) as store:
        for key, row in wanted.items():
            store.put(key, row)
        for n in range(COPIES // 3):
            path = tmp_path / f"{n}.sqlite"
            shutil.copy(source, path)
            log = bytearray(source.with_name(f"{source.name}-wal").read_bytes())
            path.with_name(f"{path.name}-wal").write_bytes(bytes(flipped(chance, log)))
            try:
                with sl.Store(path) as copy:
                    found = copy.rows(wanted)
                    missing = copy.missing(wanted)
            except StoreError as error:
                lost += said(error, path)
                continue
            assert all(row == wanted[key] for key, row in found.items())
            assert missing == [key for key in wanted if key not in found]
            lost += bool(missing)
    assert lost > 0
