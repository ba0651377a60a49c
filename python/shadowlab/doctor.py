"""What works on this machine, what is missing, and the command that brings it."""

from __future__ import annotations

import os
import platform
import sys
from dataclasses import dataclass
from html import escape
from importlib import metadata

from .travel import Value

# Optional programs by what they bring; all are in the extra "peers" or "notebook".
EXTRAS = (
    ("moderngl", "peers", "tests against OpenGL"),
    ("pyrender", "peers", "tests against pyrender"),
    ("embreex", "peers", "tests against Embree"),
    ("ipywidgets", "notebook", "progress bars in notebooks"),
    ("dask", "distributed", "sweeps on a cluster"),
    ("xarray", "tables", "sweeps as arrays with named axes"),
)
NEEDED = ("numpy", "pandas", "matplotlib", "trimesh", "click", "tqdm", "pillow")
MARKS = {"ok": "ok", "missing": "missing", "optional": "optional", "failed": "FAILED"}


@dataclass(frozen=True, eq=False)
class Finding(Value):
    """One thing that was looked at; `state` is "ok", "missing", "optional" (missing, but few need it) or "failed"."""

    name: str
    state: str
    text: str
    fix: str = ""


@dataclass(frozen=True, eq=False)
class Report(Value):
    """What `report` found; prints as text, shows as a table in notebooks."""

    findings: tuple[Finding, ...]

    @property
    def works(self) -> bool:
        """Whether the core works: everything it needs is there, and a small shadow came out right."""
        return all(finding.state in ("ok", "optional") for finding in self.findings)

    def __str__(self) -> str:
        width = max(len(finding.name) for finding in self.findings)
        lines = []
        for f in self.findings:
            lines.append(f"{MARKS[f.state]:8}  {f.name:{width}}  {f.text}")
            if f.fix:
                lines.append(f"{'':8}  {'':{width}}  fix: {f.fix}")
        lines.append("")
        lines.append("The core works." if self.works else "The core does not work; see above.")
        return "\n".join(lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        rows = []
        for f in self.findings:
            fix = f"<br><code>{escape(f.fix)}</code>" if f.fix else ""
            name = f"<th style='text-align:left'>{escape(f.name)}</th>"
            text = f"<td style='text-align:left'>{escape(f.text)}{fix}</td>"
            rows.append(f"<tr><td>{MARKS[f.state]}</td>{name}{text}</tr>")
        return f"<table>{''.join(rows)}</table>"


def report() -> Report:
    """Versions, threads, graphics adapters, optional programs, and whether a small shadow comes out right.

    This is the one place that asks the graphics drivers without a renderer being made.
    """
    workers = threads()
    # Without threads nothing is drawn, and why is said already.
    drawn = (core(),) if workers.state == "ok" else ()
    return Report((here(), workers, *drawn, *needed(), adapters(), *extras()))


def here() -> Finding:
    """Package, Python and machine."""
    from ._core import __version__

    python = f"Python {platform.python_version()} ({sys.executable})"
    return Finding("shadowlab", "ok", f"{__version__}, {python}, {platform.platform()}")


def threads() -> Finding:
    """How many threads parallel work has, and who says so."""
    from . import _core
    from .errors import ArgumentError
    from .text import shown

    try:
        count = _core.threads()
    except ArgumentError as error:
        given = os.environ.get("SHADOWLAB_THREADS", "")
        text = f"SHADOWLAB_THREADS: expected a whole number of threads from 1 to 1024, got {shown(given)}"
        return Finding("threads", "failed", text, error.fix)
    return Finding("threads", "ok", f"{count} for parallel work; set_threads or SHADOWLAB_THREADS changes that")


def core() -> Finding:
    """A square over a floor, drawn by the CPU renderer and traced: they must agree away from the shadow's edge."""
    import numpy as np

    from . import trace
    from ._core import Camera, DirectionalLight, Renderer
    from .errors import ShadowlabError
    from .scene.scenes import Scene
    from .techniques.registry import technique

    square = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    faces = [[0, 2, 1], [0, 3, 2]]
    try:
        scene = Scene.from_arrays(4 * square, faces) + Scene.from_arrays(square + np.array([0.0, 1.0, 0.0]), faces)
        camera = Camera.look_at((0, 6, 5), (0, 0, 0), aspect=1.0, near=1.0, far=20.0)
        light = DirectionalLight((0.3, -1, 0.1))
        p = technique("uniform").parameterize(scene, camera, light, resolution=256)
        mask = Renderer("cpu").shadow_mask(scene, camera, light, p, resolution=256, size=(48, 48))
        truth = trace.shadow_mask(scene, camera, light, size=(48, 48))
    except ShadowlabError as error:
        return Finding("core", "failed", str(error), "pip install --force-reinstall shadowlab")
    both = (truth >= trace.Truth.SHADOW) & np.isfinite(mask)
    wrong = int(((mask > 0.5) != (truth == trace.Truth.LIT))[both].sum())
    shadow = int((truth == trace.Truth.SHADOW).sum())
    # A square's silhouette crosses at most a few pixels of each of 48 rows; anything more is not rounding.
    if shadow == 0 or wrong > 48:
        text = f"a square's shadow of {shadow} pixels came out with {wrong} wrong"
        return Finding("core", "failed", text, "pip install --force-reinstall shadowlab")
    return Finding("core", "ok", "a small shadow was drawn on the CPU and agrees with traced truth")


def needed() -> list[Finding]:
    """The packages that the core needs."""
    findings = []
    for name in NEEDED:
        version = version_of(name)
        if version:
            findings.append(Finding(name, "ok", version))
        else:
            findings.append(Finding(name, "missing", "needed", f"pip install {name}"))
    return findings


def adapters() -> Finding:
    """The graphics adapters; without one the CPU renderer does everything."""
    from . import _core
    from .errors import DeviceError

    found = [f"{a['name']} ({a['backend']}, {a['device_type']})" for a in _core.adapters()]
    if found:
        return Finding("graphics", "ok", "; ".join(found))
    fix = ""
    try:
        _core.Renderer("gpu")
    except DeviceError as error:
        # The core knows whether there is no driver here or no GPU renderer in this build, and what helps.
        fix = error.fix
    return Finding("graphics", "optional", "no adapter; the CPU renderer does everything", fix)


def extras() -> list[Finding]:
    """Optional packages."""
    findings = []
    for name, extra, purpose in EXTRAS:
        version = version_of(name)
        if version:
            findings.append(Finding(name, "ok", f"{version}, for {purpose}"))
        else:
            findings.append(
                Finding(name, "optional", f"not installed; for {purpose}", f'pip install "shadowlab[{extra}]"')
            )
    return findings


def version_of(package: str) -> str | None:
    """The installed version, or None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
