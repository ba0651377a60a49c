"""`where=` of a store: what it selects, and what it refuses."""

from __future__ import annotations

import sqlite3

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, StoreError, UnknownNameError
from shadowlab.experiments.columns import COLUMNS
from shadowlab.experiments.store.keys import ALGORITHMS
from shadowlab.experiments.store.row_filter import row_filter

ROWS = {
    "a": {"technique": "uniform", "misclassified": 9, "share": 0.5, "maps": 1, "lispsm.near": None, "failure": ""},
    "b": {"technique": "lispsm", "misclassified": 0, "share": 0.0, "maps": 1, "lispsm.near": 1.5, "failure": ""},
    "c": {"technique": "tsm", "misclassified": 4, "share": 0.25, "maps": 4, "lispsm.near": 2, "failure": ""},
    "d": {"technique": "psm", "misclassified": None, "share": None, "maps": None, "failure": "refuses, and why"},
    "e": {"technique": "of two", "misclassified": 2**62 + 1, "yes": True, "failure": "", "odd name": 1},
}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    file = tmp_path_factory.mktemp("where") / "runs.sqlite"
    with sl.Store(file) as store:
        for key, row in ROWS.items():
            store.put(key, row)
    return file


@pytest.mark.parametrize(
    ("where", "keys"),
    [
        ("misclassified > 0", "ace"), ("misclassified>=4 and misclassified<10", "ac"), ("0 < misclassified < 9", "c"),
        ("misclassified == 4611686018427387905", "e"), ("misclassified = 4611686018427387904", ""),
        ("not misclassified > 0", "b"), ("not (misclassified > 0)", "b"), ("misclassified <> 9", "bce"),
        ("misclassified is None", "d"), ("misclassified IS NOT NULL AND maps = 1", "ab"), ("maps != 1", "c"),
        ('technique in ["lispsm", "tsm"]', "bc"), ("technique NOT IN ('lispsm', 'tsm')", "ade"),
        ('"sm" in technique', "bcd"), ('failure != ""', "d"), ("failure = 'refuses, and why'", "d"),
        ("technique == 'a = b & c'", ""), ("lispsm.near > 1", "bc"), ("`lispsm.near` > 1.5", "c"),
        ("`odd name` = 1", "e"), ("(misclassified > 5) & (maps = 1) | (maps = 4)", "ac"), ("yes", "e"),
        ("misclassified / maps >= 1", "ac"), ("misclassified - 2 * maps < 0", "bc"), ("1 / misclassified > 0.2", "c"),
        ("share * -1 <= -0.25", "ac"), ("True", "abcde"), ("None", ""), ("misclassified > 0 or True", "abcde"),
        ("misclassified > 0 and False", ""), ("not None", ""), ("key = 'c'", "c"), ("light_angle is None", "abcde"),
    ],
)  # fmt: skip
def test_rows_are_selected(path, where, keys):
    if where.startswith("light_angle"):
        with pytest.raises(UnknownNameError, match=r"expected one of .*technique.*misclassified"):
            sl.read_store(path, where=where)
        return
    assert set(sl.read_store(path, where=where)["key"]) == set(keys)


@pytest.mark.parametrize(
    "where",
    [
        "", " ", "misclassified >", "misclassified > 'x'", "technique > 1", "technique", "misclassified",
        "maps + 'x' > 1", "__import__('os').system('true')", "technique.upper() == 'TSM'", "[x for x in maps]",
        "lambda: 1", "maps ** 9 > 1", "misclassified[0] > 1", "f'{maps}'", "maps if maps else maps", "(maps := 1)",
        "maps; drop table runs", "@maps > 1", "maps = 1 -- all", "maps is 1", "technique in 'a' in maps", "1 in maps",
        "maps in 1", "*maps", "b'x' = technique", "(" * 100 + "1" + ")" * 100, "not " * 60 + "yes",
        "maps > " + "-" * 3000 + "1", "x" * 5000, "a\0b", "9" * 5000, "maps == 1j", "maps == ...", "'a' 'b",
        "1 == 1 == (2,)", "{maps}", "maps < [1]", "await maps", "yield", "\ud800", "lambda: " * 400 + "1",
        "maps" + "[0]" * 900, "maps" + ".a" * 1500, "+" * 90 + "1",
    ],
)  # fmt: skip
def test_what_is_no_question_is_refused(path, where):
    with pytest.raises((ArgumentError, UnknownNameError), match="where"):
        sl.read_store(path, where=where)
    with sl.Store(path) as store:
        assert len(store) == len(ROWS)


def test_names_of_columns_are_listed_where_one_is_unknown(path):
    with pytest.raises(UnknownNameError, match=r"'missclassified'; expected one of .*misclassified.*lispsm\.near.*key"):
        sl.read_store(path, where="missclassified > 0")


def test_long_chains_are_no_trouble():
    asked = row_filter(" or ".join(["maps > 1"] * 300), ["maps"])
    assert asked({"maps": 2})
    assert not asked({"maps": 1})


def test_the_table_has_the_vocabulary_of_columns(path):
    table = sl.read_store(path)
    known = [name for name in table.columns if name in COLUMNS]
    assert known == [name for name in COLUMNS if name in set(table.columns) - {"key"}]
    assert list(table.columns) == [*known, "lispsm.near", "odd name", "yes", "key"]
    assert [str(table[name].dtype) for name in ("misclassified", "share", "lispsm.near", "yes")] == [
        "Int64", "float64", "float64", "boolean",
    ]  # fmt: skip
    assert table["misclassified"].max() == 2**62 + 1
    assert list(table["technique"]) == sorted(row["technique"] for row in ROWS.values())


def test_values_of_several_kinds_are_kept_as_they_are(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        for key, value in {"a": 2**62 + 1, "b": 0.5, "c": "text", "d": None}.items():
            store.put(key, {"mixed": value, "misclassified": value, "both": value if key in "ab" else None})
    table = sl.read_store(tmp_path / "runs.sqlite").set_index("key")
    for name in ("mixed", "misclassified"):
        assert [table[name][key] for key in "abcd"] == [2**62 + 1, 0.5, "text", None]
    assert table["both"]["a"] == 2**62 + 1


def test_rows_of_other_versions_are_left_out(tmp_path, monkeypatch):
    path = tmp_path / "runs.sqlite"
    monkeypatch.setattr("shadowlab.experiments.store.store.ALGORITHMS", ALGORITHMS - 1)
    with sl.Store(path) as store:
        store.put("old", {"maps": 1})
    monkeypatch.undo()
    with sl.Store(path) as store:
        store.put("new", {"maps": 1})
    assert list(sl.read_store(path)["key"]) == ["new"]
    assert set(sl.read_store(path, old=True)["key"]) == {"old", "new"}


def test_an_empty_store_is_an_empty_table_and_no_file_an_error(tmp_path):
    path = tmp_path / "runs.sqlite"
    with pytest.raises(StoreError, match="no such file"):
        sl.read_store(path)
    path.touch()
    with pytest.raises(StoreError, match="no runs"):
        sl.read_store(path)
    assert path.stat().st_size == 0
    sl.Store(path).close()
    assert sl.read_store(path).empty


def test_a_store_is_read_while_another_process_writes(path):
    with sl.Store(path):
        writer = sqlite3.connect(path, isolation_level=None)
        writer.execute("begin immediate")
        assert len(sl.read_store(path)) == len(ROWS)
        writer.execute("rollback")
        writer.close()


def test_infinities_and_missing_numbers_are_told_apart(tmp_path):
    with sl.Store(tmp_path / "runs.sqlite") as store:
        store.put("a", {"texel_max": np.inf})
        store.put("b", {"texel_max": np.nan})
    assert list(sl.read_store(tmp_path / "runs.sqlite", where="texel_max > 1e300")["key"]) == ["a"]
