"""The table in processes of their own: what a call that ends its process has done is part of the answer.

    python -m hostile.watched [--full] [--processes N] [FILE]

prints the counts, and writes the calls that went wrong to a file.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .judge import Outcome

TESTS = Path(__file__).resolve().parents[1]
#: Ends of a process that one share of the table survives.
MOST_ENDS = 200
#: Bytes that a process may have: a call that asks for more fails at once, instead of taking the machine's memory.
MEMORY = 24 << 30


def share(i: int, n: int, *words: str) -> tuple[Counter[str], list[Outcome], Counter[str]]:
    """Counts by kind, calls that went wrong, and the seconds of the slowest callables, of one share."""
    counts: Counter[str] = Counter()
    seconds: Counter[str] = Counter()
    wrong: list[Outcome] = []
    after: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        journal = Path(folder) / "journal"
        for _ in range(MOST_ENDS):
            command = [
                sys.executable,
                "-m",
                "hostile",
                "--share",
                f"{i}/{n}",
                "--journal",
                str(journal),
                *words,
                *after,
            ]
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, cwd=TESTS, preexec_fn=_limited, errors="replace"
            )
            lines = [json.loads(line) for line in done.stdout.splitlines()]
            wrong += [Outcome(**line) for line in lines if "counts" not in line]
            for line in lines:
                counts.update(line.get("counts", {}))
            if lines and "slowest" in lines[-1]:
                seconds.update(dict(lines[-1]["slowest"]))
                return counts, wrong, seconds
            if not journal.exists():
                raise RuntimeError(f"the table did not begin: {done.stderr[-2000:]}")
            last = json.loads(journal.read_text())
            wrong.append(Outcome(*last, "process ended", f"{done.returncode}: {done.stderr[-300:]}"))
            counts["process ended"] += 1
            after = ["--after", *last]
    return counts, wrong, seconds


def _limited() -> None:
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def run(processes: int, *words: str) -> tuple[Counter[str], list[Outcome], Counter[str]]:
    """The same of the whole table."""
    counts: Counter[str] = Counter()
    seconds: Counter[str] = Counter()
    wrong: list[Outcome] = []
    with ThreadPoolExecutor(processes) as pool:
        for some, faults, slow in pool.map(lambda i: share(i, processes, *words), range(processes)):
            counts.update(some)
            seconds.update(slow)
            wrong += faults
    return counts, wrong, seconds


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("file", nargs="?")
    options = parser.parse_args()
    words = ["--only", options.only, *(["--full"] if options.full else [])]
    counts, wrong, seconds = run(options.processes, *words)
    if options.file:
        lines: list[dict[str, Any]] = [asdict(outcome) for outcome in wrong]
        Path(options.file).write_text("".join(json.dumps(line) + "\n" for line in lines))
    for kind, count in counts.most_common():
        print(f"{count:8,} {kind}")
    for name, time in seconds.most_common(15):
        print(f"{time:8.1f} s {name}")


if __name__ == "__main__":
    main()
