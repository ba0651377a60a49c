"""A store whose writers are killed: it is whole each time, and ends as if nobody had been."""

from __future__ import annotations

import os
import random
import shutil
import signal
import sqlite3
import time
from pathlib import Path

import pandas as pd
import pytest
from store_support import fill, filling, key_of, row_of

import shadowlab as sl

#: How often writers are killed.
KILLS = int(os.environ.get("SHADOWLAB_STORE_KILLS", "10"))
#: Rows of the work, so many that it is not done before the last kill.
#: Rows up to which a writer lives, and seconds after.
ROWS, LONGEST_LIFE, LONGEST_REST = 40 * KILLS, 20, 0.01


def whole(path: Path) -> bool:
    """Whether SQLite finds the file as it left it; asked of a copy, so that the file stays as it is."""
    folder = path.parent / "copy"
    folder.mkdir()
    for one in path.parent.glob(f"{path.name}*"):
        shutil.copy(one, folder / one.name)
    if not (folder / path.name).exists():
        shutil.rmtree(folder)
        return True
    sql = sqlite3.connect(folder / path.name)
    found = sql.execute("pragma integrity_check").fetchall() == [("ok",)]
    sql.close()
    shutil.rmtree(folder)
    return found


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.parametrize("writers", [1, 3])
def test_killed_writers_lose_the_runs_in_flight_alone(tmp_path, writers):
    chance = random.Random(writers)
    undisturbed, path = tmp_path / "undisturbed" / "runs.sqlite", tmp_path / "killed" / "runs.sqlite"
    undisturbed.parent.mkdir()
    path.parent.mkdir()
    assert fill(undisturbed, ROWS) == ROWS
    keys, grew, done = [key_of(i) for i in range(ROWS)], 0, 0
    for _ in range(KILLS):
        work = [filling(path, ROWS) for _ in range(writers)]
        for _ in range(chance.randrange(LONGEST_LIFE)):
            os.read(work[0][1], 1)
        time.sleep(chance.random() * LONGEST_REST)
        for child, told in work:
            os.kill(child, signal.SIGKILL)
            os.close(told)
        ends = {os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child, _ in work}
        assert ends <= {-signal.SIGKILL, 0}, "a writer failed for another reason"
        assert whole(path)
        with sl.Store(path) as store:
            rows, now = store.rows(keys), ROWS - len(store.missing(keys))
        assert all(rows[key] in (row_of(i), {"failure": "in flight"}) for i, key in enumerate(keys) if key in rows)
        assert now >= done, "a row that was committed is gone"
        grew, done = grew + (now > done), now
    assert grew > 1
    assert fill(path, ROWS) == ROWS - done, "what was there was made again"
    pd.testing.assert_frame_equal(sl.read_store(path), sl.read_store(undisturbed), check_exact=True)
    with sl.Store(path) as store:
        assert list(map(repr, store.rows(keys).values())) == [repr(row_of(i)) for i in range(ROWS)]
