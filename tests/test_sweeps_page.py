"""docs/sweeps.md: its examples run as written, one after the other."""

from __future__ import annotations

import re
import sys
import types
from pathlib import Path

import matplotlib as mpl
import pytest
from conftest import imported

PAGE = Path(__file__).resolve().parents[1] / "docs" / "sweeps.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """What the examples have defined so far, in a module as a script has one; and their folder."""
    mpl.use("Agg")
    module = types.ModuleType("__main__")
    before, sys.modules["__main__"] = sys.modules["__main__"], module
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("sweeps"))
        yield vars(module)
    sys.modules["__main__"] = before


def test_the_examples_run_as_written(names):
    for example in EXAMPLES:
        if "dask" in example:
            continue
        exec(compile(example, str(PAGE), "exec"), names)
    assert len(names["first"]) == 4
    assert len(names["more"]) == 6
    assert set(names["wrong"]["technique"]) <= {"lispsm", "tsm"}
    assert 0 < len(names["together"]) <= 4
    assert Path("pareto.png").stat().st_size > 5000


def test_the_example_on_dask_runs_as_written(names):
    imported("dask.distributed")
    (example,) = [one for one in EXAMPLES if "dask" in one]
    exec(compile(example, str(PAGE), "exec"), names)
    assert len(names["runs"]) == 4
