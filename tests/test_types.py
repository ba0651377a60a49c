"""What a type checker says of calls: right ones pass as they are, and each wrong one is refused for its reason.

The calls stand in right_calls.py and wrong_calls.py; mypy, as strict as for the package, reads them once.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

import pytest
from conftest import imported

import shadowlab
from shadowlab import types
from shadowlab._core import technique_specs
from shadowlab.aliasing.causes import CAUSES, MEANINGS, CauseName
from shadowlab.aliasing.codes import Cause
from shadowlab.conventions.files import FORMS, Form
from shadowlab.experiments.measures import MEASURES, OVER, ErrorName, Over
from shadowlab.experiments.metrics import KNOWN_METRICS, METRICS, Metric
from shadowlab.plot.distributions import QUANTITIES, Quantity
from shadowlab.text.checks import BACKENDS, UP_AXES

TESTS = Path(__file__).resolve().parent
RIGHT, WRONG = TESTS / "right_calls.py", TESTS / "wrong_calls.py"
MARK = re.compile(r"# wrong: (.+)$")
ERROR = re.compile(r"^(?P<file>.+?):(?P<line>\d+): error: (?P<text>.+)$")
FEWEST_WRONG_CALLS = 90


def marks_of(source: str) -> dict[int, str]:
    """The lines that are wrong, and the words that a checker has for each."""
    found = {}
    for line, text in enumerate(source.splitlines(), 1):
        if mark := MARK.search(text):
            found[line] = mark[1].strip()
    return found


def complaints(marks: Mapping[int, str], errors: Mapping[int, Sequence[str]]) -> list[str]:
    """Where a checker's errors are not those that are marked."""
    found = [f"line {line}: taken, expected: {words}" for line, words in marks.items() if line not in errors]
    found += [f"line {line}: not marked, but: {texts}" for line, texts in errors.items() if line not in marks]
    return found + [
        f"line {line}: expected {words!r} in {list(errors[line])}"
        for line, words in marks.items()
        if line in errors and not any(words in text for text in errors[line])
    ]


@pytest.fixture(scope="module")
def errors() -> dict[str, dict[int, list[str]]]:
    """mypy's errors by file and line."""
    imported("mypy")
    environment = {**os.environ, "MYPYPATH": str(TESTS.parent / "python")}
    command = [sys.executable, "-m", "mypy", "--no-error-summary", "--no-pretty", "--no-color-output"]
    # The files of the command line take the place of those in pyproject.toml, whose settings hold.
    done = subprocess.run(
        [*command, str(RIGHT), str(WRONG)], cwd=TESTS.parent, env=environment, capture_output=True, text=True
    )
    found: dict[str, dict[int, list[str]]] = {}
    for line in done.stdout.splitlines():
        if error := ERROR.match(line):
            found.setdefault(Path(error["file"]).name, {}).setdefault(int(error["line"]), []).append(error["text"])
    assert done.returncode == 1, f"mypy did not run: {done.stdout}{done.stderr}"
    return found


def test_right_calls_are_taken_and_return_what_they_say(errors):
    assert errors.get(RIGHT.name, {}) == {}
    assert set(errors) == {WRONG.name}, "errors elsewhere"


def test_wrong_calls_are_refused_each_for_its_reason(errors):
    marks = marks_of(WRONG.read_text(encoding="utf-8"))
    assert len(marks) >= FEWEST_WRONG_CALLS
    assert complaints(marks, errors[WRONG.name]) == []


def test_a_call_that_is_taken_or_refused_for_another_reason_is_found():
    marks = marks_of('f(1)  # wrong: expected "str"\ng()\nh(2)  # wrong: Missing\n')
    assert marks == {1: 'expected "str"', 3: "Missing"}
    good = {1: ['Argument 1 has type "int"; expected "str"'], 3: ["another", "Missing positional argument"]}
    assert complaints(marks, good) == []
    assert len(complaints(marks, {1: good[1]})) == 1
    assert len(complaints(marks, {**good, 2: ["Too many arguments"]})) == 1
    assert len(complaints(marks, {**good, 3: ["Unexpected keyword"]})) == 1


@pytest.mark.parametrize(
    ("names", "literal"),
    [
        (BACKENDS, types.Backend),
        (UP_AXES, types.Up),
        (FORMS, Form),
        (KNOWN_METRICS, Metric),
        (OVER, Over),
        (QUANTITIES, Quantity),
        (MEANINGS, CauseName),
        ([measure.name for measure in MEASURES], ErrorName),
        ([code.name.lower() for code in Cause if code > Cause.RIGHT], CauseName),
    ],
)
def test_the_names_that_are_taken_are_those_of_the_type(names, literal):
    assert list(names) == list(get_args(literal))


def test_names_are_taken_by_the_core():
    assert list(CAUSES) == [code for code in Cause if code > Cause.RIGHT]
    assert [name for name in KNOWN_METRICS if name != "mask"] == list(METRICS)
    kinds = {kind for spec in technique_specs() for kind in spec["lights"]}
    assert kinds == {"directional", "spot", "point"}
    stub = (Path(shadowlab.__file__).parent / "_core_renderer.pyi").read_text(encoding="utf-8")
    for name, literal in (("backend", types.Backend),):
        words = re.search(rf"^\s*.*\b{name}: (?:TypeAlias = )?Literal\[([^\]]+)\]", stub, re.MULTILINE)
        assert words is not None
        assert tuple(re.findall(r'"(\w+)"', words[1])) == get_args(literal)
