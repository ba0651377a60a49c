"""Every public callable takes anything: a result, or an error of ours that names the argument, on one line.

Found by looking at the package, so that what is added is in it; a callable that `hostile.calls` cannot call fails. Of
the values, this takes those that stand for all; SHADOWLAB_HOSTILE=all takes all of them (some minutes). Python's own
TypeError for a missing argument or an unknown keyword is no part of it.
"""

from __future__ import annotations

import os
from collections import Counter

import pytest
from hostile import calls, found, judge, values, watched

import shadowlab as sl

FULL = os.environ.get("SHADOWLAB_HOSTILE") == "all"
# Calls of the table: fewer would mean that callables are not found.
LEAST_CALLS = 80_000 if FULL else 20_000


def test_every_callable_has_a_good_call_for_each_argument():
    unknown = []
    for callee in found.callees():
        try:
            calls.arguments(callee)
        except calls.Unknown as error:
            unknown.append(str(error))
    assert not unknown


def test_the_table_finds_what_the_package_has():
    names = {callee.name for callee in found.callees()}
    assert {"Camera.look_at", "sl.compare", "sl.plot.error_map", "sl.aliasing.closed_form.F", "View.samples"} <= names
    assert not found.properties(), "properties that can be written to need a row in the table"
    assert set(values.FEW) <= set(values.VALUES)


class AsGiven(sl.errors.ArgumentError):
    """An error that does not put itself on one line."""

    __str__ = Exception.__str__


def test_the_judge_tells_what_helps_from_what_does_not():
    def of(raised: Exception) -> str:
        def function(size: object) -> None:
            raise raised

        callee = found.Callee("function", function)
        judge.arguments.cache_clear()
        calls.MEANING["size"], kept = (lambda: (16, 9)), calls.MEANING["size"]
        try:
            return judge.judged(callee, "size", "None").kind
        finally:
            calls.MEANING["size"] = kept

    assert of(sl.errors.ArgumentError("size: expected one, got None")) == "error"
    assert of(sl.errors.ArgumentError("expected one, got None")) == "no name"
    assert of(AsGiven("size: expected one,\ngot None")) == "several lines"
    assert of(TypeError("size")) == "untyped TypeError"
    assert of(sl.errors.InternalError("size")) == "defect"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="time limits of calls are signals")
def test_every_call_gives_a_result_or_an_error_that_helps():
    counts, wrong, _ = watched.run(min(os.cpu_count() or 1, 4), *(["--full"] if FULL else []))
    listed = Counter(f"{one.callee}({one.argument}): {one.kind}" for one in wrong)
    first = "\n".join(f"{one.callee}({one.argument}={one.value}): {one.kind}: {one.text}" for one in wrong[:40])
    assert not wrong, f"{len(wrong)} of {counts.total()}: {dict(listed.most_common(20))}\n{first}"
    assert counts.total() > LEAST_CALLS
    assert counts["error"] > counts["result"] > 0
