"""Runs a share of the table in this process: a line of JSON for every call that went wrong, and the counts at the end.

    python -m hostile [--full] [--share I/N] [--only TEXT] [--value TEXT] [--after CALLEE ARGUMENT VALUE]

`watched.py` runs it in processes of their own and goes on after calls that end them.
"""

from __future__ import annotations

import argparse
import dataclasses
import faulthandler
import json
import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")

from . import calls, found, judge, values


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--share", default="0/1")
    parser.add_argument("--only", default="")
    parser.add_argument("--value", default="")
    parser.add_argument("--after", nargs=3)
    parser.add_argument("--journal", default=os.devnull)
    options = parser.parse_args()
    part, parts = map(int, options.share.split("/"))
    counts: Counter[str] = Counter()
    seconds: Counter[str] = Counter()
    # What the calls print goes elsewhere.
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    chosen = [callee for i, callee in enumerate(found.callees()) if options.only in callee.name and i % parts == part]
    skip = tuple(options.after) if options.after else None
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for callee in chosen:
            if skip and callee.name != skip[0]:
                continue
            start = time.perf_counter()
            try:
                calls.invoke(callee, calls.arguments(callee))
            except Exception as error:  # noqa: BLE001 - reported
                failed = judge.Outcome(callee.name, "", "", "no good call", repr(error))
                out.write(json.dumps(dataclasses.asdict(failed)) + "\n")
                counts["no good call"] += 1
                continue
            for argument, value in judge.cases(callee):
                if skip:
                    skip = None if skip == (callee.name, argument, value) else skip
                    continue
                if options.value not in value or not (options.full or value in values.FEW):
                    continue
                faulthandler.dump_traceback_later(3 * judge.LIMIT, exit=True)
                Path(options.journal).write_text(json.dumps((callee.name, argument, value)), encoding="utf-8")
                outcome = judge.judged(callee, argument, value)
                counts[outcome.kind] += 1
                if not outcome.good:
                    out.write(json.dumps(dataclasses.asdict(outcome)) + "\n")
            skip = None
            # What is counted so far is not lost where a later call ends the process.
            out.write(json.dumps({"counts": counts}) + "\n")
            counts.clear()
            if "matplotlib.pyplot" in sys.modules:
                sys.modules["matplotlib.pyplot"].close("all")
            seconds[callee.name] = time.perf_counter() - start
        faulthandler.cancel_dump_traceback_later()
        os.chdir("/")
    out.write(json.dumps({"counts": counts, "slowest": seconds.most_common(20)}) + "\n")


if __name__ == "__main__":
    main()
