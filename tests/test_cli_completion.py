"""Help and completion: commands that nobody calls are not loaded, shells complete commands, options and names."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

import shadowlab as sl
from shadowlab import cli
from shadowlab.cli.nearest import nearest_name, nearest_text
from shadowlab.techniques.presets import PRESETS

COMMANDS = (
    "demo",
    "sweep",
    "check",
    "compare",
    "advise",
    "explain",
    "experiment",
    "matrix",
    "diagnose",
    "techniques",
    "doctor",
    "completion",
)


def completed(line, shell="bash"):
    """What completes a line that ends at the cursor."""
    words = {"COMP_LINE": line, "COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}
    env = {**os.environ, **words, "_SHADOWLAB_COMPLETE": f"{shell}_complete"}
    done = subprocess.run([sys.executable, "-m", "shadowlab"], capture_output=True, text=True, check=True, env=env)
    assert done.stderr == ""
    return done.stdout.splitlines()


def test_the_package_is_a_command_with_help_that_lists_all():
    done = subprocess.run([sys.executable, "-m", "shadowlab", "--help"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("Usage: shadowlab [OPTIONS] COMMAND")
    listed = [line.split()[0] for line in done.stdout.partition("Commands:\n")[2].splitlines() if line[2:3].strip()]
    assert set(COMMANDS) <= set(listed)


@pytest.mark.parametrize("command", [*COMMANDS, "experiment scene-optimal"])
def test_every_command_has_help_with_its_arguments(command, capsys):
    with pytest.raises(SystemExit) as left:
        cli.main([*command.split(), "--help"])
    assert left.value.code == 0
    out = capsys.readouterr().out
    assert out.startswith(f"Usage: shadowlab {command} ")
    assert "--debug" in out
    assert out.count("MESH|@LIBRARY") in (0, 2)  # in the usage, and with what it is


def test_help_loads_no_command():
    code = "import sys; from shadowlab.cli import main\ntry: main(sys.argv[1:])\nexcept SystemExit: pass\n"
    code += "print('LOADED', *[m for m in sys.modules if m.startswith('shadowlab.cli.')])"
    for words, has in ((["--help"], False), (["compare", "--help"], True)):
        done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
        loaded = done.stdout.splitlines()[-1].split()
        assert ("shadowlab.cli.compare" in loaded) is has
        assert "shadowlab.cli.advise" not in loaded


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        ("shadowlab comp", {"compare", "completion"}),
        ("shadowlab matrix @robots --conv", {"--convention"}),
        ("shadowlab compare @", {f"@{name}" for name in sl.library.names()}),
        ("shadowlab compare @rob", {"@robots"}),
        ("shadowlab advise @robots --technique preset:", {f"preset:{one.name}" for one in PRESETS}),
        ("shadowlab compare --technique=lispsm:fi", {"lispsm:fit=", "lispsm:filter="}),
        ("shadowlab compare @robots --technique lispsm:near=basic,near_w", {"lispsm:near=basic,near_weight="}),
        ("shadowlab explain @robots --filter po", {"poisson"}),
        ("shadowlab compare @robots --view ", {"along", "above", "against"}),
        ("shadowlab experiment ", {"scene-optimal"}),
    ],
)
def test_bash_is_told_what_completes_a_line(line, answers):
    assert set(completed(line)) == {f"plain,{answer}" for answer in answers}


def test_meshes_are_files():
    assert completed("shadowlab compare cit") == ["file,cit"]


def test_zsh_is_told_what_commands_are_for():
    assert "techniques side by side, against traced truth" in completed("shadowlab comp", "zsh")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts_of_shells_are_valid_and_ask_by_the_variable(shell, run):
    status, out, err = run("completion", shell)
    assert (status, err) == (0, "")
    assert f"_SHADOWLAB_COMPLETE={shell}_complete" in out
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=out, text=True, check=True)


def test_bash_puts_back_what_stands_before_colons_and_at_signs(tmp_path, run):
    """The script's function as bash calls it, with the line that it stands in."""
    if not shutil.which("bash"):
        pytest.skip("bash is not here")
    command = tmp_path / "shadowlab"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m shadowlab "$@"\n')
    command.chmod(0o755)
    _, script, _ = run("completion", "bash")
    for line, replies in (
        ("shadowlab compare @rob", "robots"),
        ("shadowlab compare --technique=preset:fila", "filament"),
        ("shadowlab matrix @robots --technique lispsm:axi", "axis="),
    ):
        # `compopt` works only while a shell completes.
        text = f"{script}\ncompopt() {{ :; }}\nCOMP_LINE='{line}' COMP_POINT={len(line)}\n"
        text += '_shadowlab_completion "$1"; printf "%s\\n" "${COMPREPLY[@]}"'
        done = subprocess.run(["bash", "-c", text, "bash", str(command)], capture_output=True, text=True, check=True)
        assert done.stdout.split() == [replies], done.stderr


def test_the_nearest_name():
    names = ("resolution", "technique", "size")
    assert nearest_name("resolutoin", names) == "resolution"
    assert nearest_name("zzz", names) is None
    assert nearest_text("sise", names) == "did you mean 'size'? expected one of resolution, technique, size"
    assert nearest_text("zzz", names) == "expected one of resolution, technique, size"


def test_a_command_that_is_misspelt_has_a_nearest_one(run):
    status, out, err = run("compre", "@robots")
    assert (status, out) == (2, "")
    assert err.startswith("shadowlab: error: no such COMMAND 'compre'; did you mean 'compare'? expected one of ")
    assert err.endswith("; see shadowlab --help\n")
    assert "did you mean 'scene-optimal'?" in run("experiment", "scene-optimum")[2]
