"""The rows: which work, beside whose, and what the project has set itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

# In which environment a side runs: this project's, the one that holds large peers alone, or a compiled program.
Where = Literal["project", "peers", "compiled"]


@dataclass(frozen=True)
class Work:
    """A function of `ours.py` or `theirs.py`, or a program in C++, and its arguments.

    `needs` names inputs that only exist once the bench runs: `data` (the arrays' file), `matrix` (of lispsm at a
    resolution).
    """

    name: str
    options: dict = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    where: Where = "project"
    module: str = "ours"


@dataclass(frozen=True)
class Row:
    """One comparison: how many times `ours` goes into the time of `other`.

    Attributes
    ----------
    wanted : float or None
        The goal; None for rows that only inform.
    more : bool
        Whether a larger ratio is better. It is not where `other` is more of our own work (`of` is then read the other
        way round: other / ours is the growth).
    one_thread : bool
        Whether both sides get one thread on one core.
    of : "cpu" or "wall"
        Which time is compared.
    """

    part: str
    what: str
    ours: Work
    other: Work
    wanted: float | None = None
    more: bool = True
    one_thread: bool = True
    of: Literal["cpu", "wall"] = "cpu"


def _theirs(name: str, where: Where = "project", *needs: str, **options: object) -> Work:
    return Work(name, options, needs, where, "theirs")


def _ours(name: str, *needs: str, **options: object) -> Work:
    return Work(name, options, needs)


_RAYS = (
    ("Mitsuba", "mitsuba", "peers", 1.1),
    ("embreex", "embreex", "project", 1.5),
    ("Open3D", "open3d", "peers", 1.8),
)
_BUILDS = (
    ("Open3D", "open3d", "peers", 1.0),
    ("embreex", "embreex", "project", 1.8),
    ("Mitsuba", "mitsuba", "peers", 3.0),
)

ROWS: tuple[Row, ...] = (
    *(
        Row(
            "maps",
            f"cpu map {side}², 441 k triangles, beside moderngl on its driver",
            _ours("shadow_map", side=side),
            _theirs("moderngl_map", "project", "data", "matrix", side=side),
            wanted,
            one_thread=False,
        )
        for side, wanted in ((1024, 15.0), (2048, 9.0), (4096, 6.0))
    ),
    *(
        Row(
            "gpu maps",
            f"gpu map {side}², 441 k triangles, beside moderngl on its driver",
            _ours("shadow_map", side=side, backend="gpu"),
            _theirs("moderngl_map", "project", "data", "matrix", side=side),
            1.0,
            one_thread=False,
            of="wall",
        )
        for side in (1024, 2048, 4096)
    ),
    *(
        Row(
            "rays",
            f"primary and shadow rays, beside {title}",
            _ours("rays", "data"),
            _theirs(f"{name}_rays", where, "data"),
            wanted,
        )
        for title, name, where, wanted in _RAYS
    ),
    Row(
        "rays",
        "the same on all threads, beside embreex on one",
        _ours("rays", "data"),
        _theirs("embreex_rays", "project", "data"),
        one_thread=False,
        of="wall",
    ),
    Row(
        "rays",
        "the whole truth of 1024² pixels, beside embreex's rays",
        _ours("truth", size=1024),
        _theirs("embreex_rays", "project", "data"),
    ),
    *(
        Row(
            "build",
            f"hierarchy, beside {title}",
            _ours("build", "data"),
            _theirs(f"{name}_build", where, "data"),
            wanted,
        )
        for title, name, where, wanted in _BUILDS
    ),
    *(
        Row(
            "fits",
            f"fit of lispsm over the body, from Python, beside {title}",
            _ours("fit", calls=1000),
            Work(name, {"calls": 1000}, (), "compiled"),
            wanted,
        )
        for title, name, wanted in (("OGRE", "fit_ogre", 4.5), ("OpenSceneGraph", "fit_osg", 8.0))
    ),
    Row(
        "fits",
        "the same over a forest of 10,000 instances, in fits over one mesh",
        _ours("fit", calls=200),
        _ours("fit", calls=200, scene="forest:trees=10000"),
        more=False,
    ),
    Row(
        "masks",
        "look-up of 1024² pixels, in passes of the footprint kernel",
        _ours("shadow_mask", side=1024, size=1024),
        _ours("footprint", side=1024, size=1024),
        1.48,
    ),
    *(
        Row(
            "uneven",
            f"logarithmic map {side}², beside a lispsm map",
            _ours("shadow_map", side=side, technique="log_psm"),
            _ours("shadow_map", side=side),
        )
        for side in (1024, 4096)
    ),
    Row(
        "uneven",
        "look-up of 1024² pixels in a logarithmic map, beside one in a lispsm map",
        _ours("shadow_mask", side=1024, size=1024, technique="log_psm"),
        _ours("shadow_mask", side=1024, size=1024),
    ),
    Row(
        "cascades",
        "four maps of 1024² of a z partition, in maps of 1024²",
        _ours("cascades", count=1, side=1024),
        _ours("cascades", count=4, side=1024),
        2.4,
        more=False,
    ),
    Row(
        "growth",
        "lispsm 2048² of a forest of 100 k trees, in those of 10 k",
        _ours("shadow_map", side=2048, scene="forest:trees=10000"),
        _ours("shadow_map", side=2048, scene="forest:trees=100000"),
        more=False,
        one_thread=False,
    ),
    Row(
        "lights",
        "states of 32 lights of the courtyard at 1024² as bits, in those of one light",
        _ours("states", count=1, size=1024),
        _ours("states", count=32, size=1024),
        12.0,
        more=False,
        one_thread=False,
    ),
    Row(
        "lights",
        "32 lights of the courtyard at 1024² against traced truth, in one light",
        _ours("lights", count=1, size=1024),
        _ours("lights", count=32, size=1024),
        12.0,
        more=False,
        one_thread=False,
    ),
    Row(
        "waiting",
        "`compare` of two techniques with all pictures saved, in those without",
        _ours("compare", pictures=False),
        _ours("compare", pictures=True),
        more=False,
        one_thread=False,
        of="wall",
    ),
)
