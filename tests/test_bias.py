"""The defaults that docs/bias.md tells, and how a bias is written down."""

from pathlib import Path

import pytest

import shadowlab as sl
from shadowlab.reports.reproduce import bias_python

DOCS = Path(__file__).parents[1] / "docs" / "bias.md"
PARTS = ("world", "texels", "ndc", "slope", "slope_limit", "plane", "normal")


def documented() -> dict[str, float]:
    """Part to default, from the table whose last column is headed "default"."""
    lines = DOCS.read_text("utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]
    start = next(i for i, row in enumerate(rows) if row[-1] == "default")
    table = {}
    for row in rows[start + 2 :]:
        if len(row) < 2:
            break
        table[row[0].strip("`")] = float(row[-1])
    return table


def test_the_table_of_defaults_is_true() -> None:
    assert documented() == {part: getattr(sl.Bias(), part) for part in PARTS}


@pytest.mark.parametrize("bias", [sl.Bias(), sl.Bias.none(), sl.Bias(slope_limit=3), sl.Bias(plane=1, normal=2), sl.Bias(slope_limit=float("inf"))])
def test_a_bias_survives_being_written_as_python(bias: sl.Bias) -> None:
    assert eval(bias_python(bias), {"sl": sl}) == bias
