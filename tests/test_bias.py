"""The defaults that docs/bias.md tells, and how a bias is written down."""

import re
from pathlib import Path

import matplotlib as mpl
import pytest

import shadowlab as sl
from shadowlab.reports.reproduce import bias_python

DOCS = Path(__file__).parents[1] / "docs" / "bias.md"
PARTS = ("world", "texels", "ndc", "slope", "slope_limit", "plane", "normal", "factor", "units")


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


@pytest.mark.parametrize(
    "bias",
    [sl.Bias(), sl.Bias.none(), sl.Bias(slope_limit=3), sl.Bias(plane=1, normal=2), sl.Bias(slope_limit=float("inf"))],
)
def test_a_bias_survives_being_written_as_python(bias: sl.Bias) -> None:
    assert eval(bias_python(bias), {"sl": sl}) == bias


def test_the_example_prints_what_the_page_says(capsys) -> None:
    mpl.use("Agg")
    python, printed = re.search(r"```python\n(.*?)```\n\n```\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL).groups()
    exec(compile(python, str(DOCS), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out == printed


def test_the_table_of_least_values_is_true() -> None:
    lines = [line for line in DOCS.read_text("utf-8").splitlines() if re.match(r"\| \w+ \| `\w+` \|", line)]
    assert len(lines) == 8
    views: dict[str, sl.View] = {}
    for line in lines:
        name, part = (cell.strip(" `") for cell in line.split("|")[1:3])
        if name not in views:
            scene = sl.library.scene(name)
            views[name] = sl.View(scene, scene.camera, scene.light, size=(640, 360))
        f = sl.smallest_bias(views[name], "lispsm", part, renderer="cpu", progress=False)
        numbers = (
            f"{f.value:.4g} | {f.acne:,} | {f.leaks:,} | {f.wrong:,} | {f.least_wrong_value:.4g} | {f.least_wrong:,}"
        )
        assert line == f"| {name} | `{part}` | {numbers} | {f.closed_form:.4g} |"
