"""The command line at a terminal, in a pipe, and when it is interrupted."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time

import pytest

SMALL = ("--size", "32x24", "--resolution", "64", "--backend", "cpu")


def test_ctrl_c_is_130_and_leaves_no_traceback(tmp_path):
    command = [
        sys.executable,
        "-m",
        "shadowlab.cli",
        "compare",
        "@forest",
        "--size",
        "4096x4096",
        "--resolution",
        "8192",
    ]
    process = subprocess.Popen(
        [*command, "--backend", "cpu", "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        # Tests that a script starts in the background inherit that SIGINT is ignored; the command must not.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    # The directory is made when the scene stands and the long work begins.
    end = time.monotonic() + 120
    while not (tmp_path / "out").exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert b"Traceback" not in err
    assert err.strip().splitlines()[-1] == b"shadowlab: interrupted"


def test_a_reader_that_leaves_is_no_error(mesh):
    command = f"{shlex.quote(sys.executable)} -m shadowlab.cli techniques | head -n 1"
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, check=False)
    assert done.stderr == b""


@pytest.mark.parametrize("command", ["techniques", "matrix MESH --format npy", "matrix MESH"])
@pytest.mark.parametrize(("target", "says"), [("> /dev/full", "No space left"), (">&-", "standard output is closed")])
def test_an_output_that_takes_nothing_is_one_line(mesh, command, target, says):
    if target.endswith("full") and not os.path.exists("/dev/full"):  # noqa: PTH110 - a device, not a path of ours
        pytest.skip("/dev/full is not here")
    words = f"{shlex.quote(sys.executable)} -m shadowlab.cli {command.replace('MESH', shlex.quote(mesh))} {target}"
    done = subprocess.run(["bash", "-c", words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("shadowlab: error: ")
    assert says in done.stderr
    assert "defect" not in done.stderr


def test_importing_and_version_touch_no_driver_and_no_pandas():
    heavy = ("pandas", "matplotlib", "trimesh")
    code = "import sys, shadowlab.cli; shadowlab.cli.given_options(['compare', '@robots']); "
    code += f"print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ})
    assert done.stdout.strip() == "[]"


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are for others")
def test_a_terminal_without_a_size_shows_progress(tmp_path):
    import pty

    leader, follower = pty.openpty()
    # As if all of it took long.
    code = "import sys; from shadowlab.text import progress; progress.SHOWN_AFTER_S = 0.0; progress.REFRESH_S = 0.0\n"
    code += "from shadowlab.cli.main import main; sys.exit(main())"
    words = [sys.executable, "-c", code, "compare", "@robots", *SMALL, "--out", str(tmp_path)]
    child = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=follower)
    os.close(follower)
    shown = b""
    while True:
        try:
            part = os.read(leader, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(leader)
    assert child.wait() == 0
    assert b"truth" in shown
    assert b"report: pictures" in shown
    assert b" left" in shown
