"""The line that says how many tests ran and how many skipped, from the logs of both runners."""

import subprocess
from pathlib import Path

COUNTS = Path(__file__).resolve().parents[1] / ".ci" / "counts"


def test_skips_of_both_runners_are_counted(tmp_path: Path):
    rust, python = tmp_path / "rust.log", tmp_path / "python.log"
    rust.write_text(
        "test a ... ok\n\nskipped: no graphics adapter\ntest b ... ok\n\nskipped: no graphics adapter\n"
        "test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured\n"
        "test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured\n"
    )
    python.write_text("....\n===== 3 passed, 1 skipped in 2.00s =====\n")
    out = subprocess.run(
        ["bash", str(COUNTS), str(rust), str(python)], capture_output=True, text=True, check=True
    ).stdout
    assert "Rust:   5 passed, 0 failed, 2 skipped, 1 ignored" in out
    assert "(2 times)" in out
    assert "Python: 3 passed, 1 skipped" in out
