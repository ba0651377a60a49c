"""What tests of the command line share: mistakes that are one line."""

from __future__ import annotations


def fails(outcome, *parts):
    """One line on standard error, exit status 2, nothing on standard output."""
    status, out, err = outcome
    assert status == 2
    assert out == ""
    assert err.count("\n") == 1, err
    assert err.startswith("shadowlab: error: ")
    assert "Traceback" not in err
    for part in parts:
        assert part in err
    return err


def fails_in(file, outcome, *parts):
    """The same of a mistake in a configuration; parts that begin with a colon follow its name."""
    err = fails(outcome, *(f"{file}{part}" if part.startswith(":") else part for part in parts))
    assert "defect" not in err
