"""The line that says how many tests ran and how many skipped, from the logs of both runners."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

COUNTS = Path(__file__).resolve().parents[1] / ".ci" / "counts"


def test_skips_of_both_runners_are_counted(tmp_path: Path):
    rust, python = tmp_path / "rust.log", tmp_path / "python.log"
    rust.write_text(
        "test a ... ok\n\nskipped: no graphics adapter\ntest b ... ok\n\nskipped: no graphics adapter\n"
        "test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured\n"
        "test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured\n"
    )
    python.write_text("....\n===== 3 passed, 1 skipped in 2.00s =====\n")
    out = counted(rust, python)
    assert "Rust:   5 passed, 0 failed, 2 skipped, 1 ignored" in out
    assert "(2 times)" in out
    assert "Python: 3 passed, 1 skipped" in out


@pytest.mark.parametrize("workers", [0, 2])
def test_skips_of_every_worker_are_counted(tmp_path: Path, workers: int):
    tests = tmp_path / "test_few.py"
    tests.write_text(
        "import pytest\n@pytest.mark.parametrize('i', range(5))\ndef test_some(i):\n    if i % 2: pytest.skip('odd')\n"
    )
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    command = [sys.executable, "-m", "pytest", "-ra", "-n", str(workers), "--dist", "worksteal", "--durations=10"]
    log = subprocess.run([*command, str(tests)], cwd=tmp_path, env=own, capture_output=True, text=True, check=True)
    rust, python = tmp_path / "rust.log", tmp_path / "python.log"
    rust.write_text("")
    python.write_text(log.stdout)
    assert re.search(r"^Python: 3 passed, 2 skipped", counted(rust, python), re.MULTILINE)


def counted(rust: Path, python: Path) -> str:
    """What the script prints of two logs."""
    command = ["bash", str(COUNTS), str(rust), str(python)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
