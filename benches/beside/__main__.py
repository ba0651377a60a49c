"""The same work here and in other programs, side by side: `make bench-peers`, or `python benches/beside`.

Each side is a process of its own (sides.py), which this program starts, pins to one core where the row is about one
thread, and asks in turn. Printed are the ratio of the least times, the tenth and ninetieth percentile of the ratios of
neighbouring runs, and the goal. Both sides must have the same result, as far as the work has one that is a number.

    python benches/beside [--part rays] [--seconds 5] [--json FILE] [--page docs/performance.md]
    python benches/beside --before FOLDER   # this build beside another: FOLDER holds its `shadowlab` package
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tests")]

from inputs import EYE, FAR, FOV_Y_DEG, LIGHT, NEAR, TARGET, bench_scene, camera, write  # noqa: E402
from sides import Ratio, Side, SideError, alternated  # noqa: E402
from table import ROWS, Row, Work  # noqa: E402

import shadowlab as sl  # noqa: E402

# How far numbers of both sides may lie apart: rays and depths in single precision.
APART = 1e-3
_MARK = re.compile(r"(<!-- benches/beside: begin -->\n).*?(<!-- benches/beside: end -->)", re.DOTALL)
COMPILED = {"fit_ogre": ("OGRE", "libogre-1.12-dev"), "fit_osg": ("openscenegraph-osgShadow", "libopenscenegraph-dev")}


class Bench:
    """The inputs of all rows, and where their sides run."""

    def __init__(self, folder: Path, peers_python: str):
        self.folder, self.data = folder, folder / "arrays.npz"
        self._pythons = {"project": sys.executable, "peers": peers_python}
        write(self.data)

    def options(self, work: Work) -> dict:
        """The arguments of a side, with what only exists now."""
        options = dict(work.options)
        if "data" in work.needs:
            options["data"] = str(self.data)
        if "matrix" in work.needs:
            scene = sl.Scene.from_arrays(*bench_scene())
            light = sl.DirectionalLight(LIGHT)
            p = sl.technique("lispsm").parameterize(scene, camera(), light, resolution=options["side"])
            options["matrix"] = p.matrix.tolist()
        return options

    def side(self, work: Work, one_thread: bool, package: str | None = None) -> Side:
        """A side of a row, not started; `package` is where its shadowlab lies."""
        if work.where == "compiled":
            least, most = bench_scene()[0].min(axis=0), bench_scene()[0].max(axis=0)
            numbers = (*EYE, *TARGET, FOV_Y_DEG, NEAR, FAR, *LIGHT, *least, *most, work.options["calls"])
            return Side([self._compiled(work.name), *map(str, numbers)], one_thread=one_thread)
        python = self._pythons[work.where]
        if not Path(python).exists():
            raise SideError(f"no {python}: make .venv-peers/.installed")
        command = [python, str(HERE / "worker.py"), work.module, work.name, json.dumps(self.options(work))]
        return Side(command, one_thread=one_thread, environment={"PYTHONPATH": package} if package else None)

    def _compiled(self, name: str) -> str:
        library, package = COMPILED[name]
        flags = subprocess.run(
            ["pkg-config", "--cflags", "--libs", library], capture_output=True, text=True, check=False
        )
        if flags.returncode:
            raise SideError(f"{library} is missing: apt-get install g++ pkg-config {package}")
        program = self.folder / name
        command = ["c++", "-O2", "-march=native", str(HERE / f"{name}.cpp"), "-o", str(program), *flags.stdout.split()]
        subprocess.run(command, check=True)
        return str(program)

    def measured(self, row: Row, seconds: float, before: str | None) -> tuple[Ratio, str]:
        """The ratio of a row, and who the other side is; beside another build, both sides do the row's own work."""
        other = row.ours if before else row.other
        ours, theirs = self.side(row.ours, row.one_thread), self.side(other, row.one_thread, before)
        with ours, theirs:
            # Other work of ours, such as more trees, has results of its own.
            same = before or other.module != "ours"
            for name in ours.ready["check"].keys() & theirs.ready["check"].keys() if same else ():
                a, b = ours.ready["check"][name], theirs.ready["check"][name]
                if abs(a - b) > APART * max(abs(a), abs(b)):
                    raise SideError(f"{row.what}: {name} is {a} here and {b} in {theirs.ready['about']}")
            return alternated(ours, theirs, seconds, row.of), theirs.ready["about"]


def verdict(row: Row, ratio: float) -> str:
    """What has become of the goal."""
    if row.wanted is None:
        return ""
    reached = ratio >= row.wanted if row.more else ratio <= row.wanted
    return f"{'' if row.more else 'at most '}{row.wanted:g} {'reached' if reached else 'missed'}"


def machine() -> str:
    """The processor and the system in one line."""
    info = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*:\s*(.*)", info.read_text()) if info.exists() else []
    return f"{names[0] if names else platform.processor()}, {os.cpu_count()} cores, {platform.system()}"


def page(path: Path, rows: list[dict]) -> None:
    """Write the table into a page, between its marks."""
    lines = ["| work | other side | ratio | spread | goal |", "| --- | --- | --- | --- | --- |"]
    lines += [
        f"| {r['what']} | {r['other']} | {r['ratio']:.2f} | {r['low']:.2f} to {r['high']:.2f} | {r['verdict']} |"
        for r in rows
    ]
    text = path.read_text()
    table = "\n".join([*lines, "", f"Measured on: {machine()}; {rows[0]['version']}.", ""])
    path.write_text(_MARK.sub(lambda m: m[1] + table + m[2], text))


def main() -> int:
    """Run the rows; the exit status is 1 where one could not be measured."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=5.0, help="least time of each row (default %(default)s)")
    parser.add_argument("--part", action="append", choices=sorted({row.part for row in ROWS}), help="these rows alone")
    parser.add_argument(
        "--before", metavar="FOLDER", help="beside another build of shadowlab instead of other programs"
    )
    parser.add_argument("--peers", metavar="PYTHON", default=str(HERE.parents[1] / ".venv-peers/bin/python"))
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the rows there, too")
    parser.add_argument("--page", metavar="FILE", type=Path, help="write the table into this page, too")
    options = parser.parse_args()
    rows, failures = [], []
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), options.peers)
        seen = set()
        for row in ROWS:
            if options.part and row.part not in options.part:
                continue
            if options.before and str(row.ours) in seen:
                continue
            seen.add(str(row.ours))
            try:
                ratio, other = bench.measured(row, options.seconds, options.before)
            except SideError as error:
                failures.append(f"{row.what}: {error}")
                print(f"  {row.what}: NOT MEASURED: {error}", flush=True)
                continue
            said = "" if options.before else verdict(row, ratio.ratio)
            what = f"{row.ours.name} {row.ours.options}" if options.before else row.what
            times = f"{ratio.ours:9.2f} {ratio.theirs:9.2f} ms"
            print(f"  {what:<70}{times}{ratio.ratio:8.2f} ({ratio.low:.2f} to {ratio.high:.2f})   {said}", flush=True)
            names = {"what": what, "other": other, "verdict": said, "version": f"shadowlab {sl.__version__}"}
            rows.append(names | ratio.as_data())
    if options.json:
        options.json.write_text(json.dumps({"machine": machine(), "rows": rows}, indent=1) + "\n")
    if options.page and rows:
        page(options.page, rows)
    return int(bool(failures))


if __name__ == "__main__":
    raise SystemExit(main())
