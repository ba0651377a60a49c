"""`shadowlab demo`: it needs no arguments, and what it says to try next works."""

from __future__ import annotations

import shlex

from shadowlab import cli


def test_the_demo_shows_a_table_a_verdict_and_a_report(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = run("demo")
    assert (status, err) == (0, "")
    assert "lispsm at 1024² has the fewest wrong pixels" in out
    assert "shadowlab-demo/report.html" in out.replace("\\", "/")
    assert (tmp_path / "shadowlab-demo" / "report.html").stat().st_size > 10_000
    commands = [line.strip() for line in out.partition("What to try next:")[2].splitlines() if line[2:3] != " "]
    words = [shlex.split(command) for command in commands if command]
    assert [one[1] for one in words] == ["compare", "explain", "advise", "techniques", "--help"]
    for one in words[:-1]:
        assert cli.given_options(one[1:])
    # The pixel is wrong indeed.
    explain = [*words[1][1:], "--no-trials", "--backend", "cpu"]
    status, out, err = run(*explain)
    assert (status, err) == (1, "")
    assert run("demo", "city.glb")[0] == 2
