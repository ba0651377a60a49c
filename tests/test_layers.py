"""Imports point down, rooms are few, and a name is declared once: the house rules of the Python package.

The twin of layers.rs; the table is docs/ARCHITECTURE.md's. What is read of a file is its syntax tree: an import counts
in a function, in a class and under TYPE_CHECKING as well as at the top, and a name in a comment or a text is none.
"""

from __future__ import annotations

import importlib
import re
from collections import defaultdict
from pathlib import Path

import pytest
from layers_support import (
    TYPE_CHECKING,
    circle_in,
    imports_of,
    is_list,
    loads_by_name,
    modules_of,
    names_of,
    room_of,
    untyped,
)

PROJECT = Path(__file__).resolve().parents[1]
ROOT = PROJECT / "python" / "shadowlab"
MODULES = modules_of(ROOT)
SOURCES = {module: path.read_text(encoding="utf-8") for module, path in MODULES.items()}
IMPORTS = {module: imports_of(source, module, MODULES) for module, source in SOURCES.items()}

# What everybody stands on: the extension, errors, texts, types, and checks of single arguments.
GROUND = ("_core", "errors", "text", "types", "travel")
# For each room, what it may use beside itself: a room, or one module of it.
MAY_USE = {
    "_core": (),
    "errors": (),
    "text": ("_core", "errors", "types"),
    "types": ("_core",),
    "travel": ("errors",),
    "trace": GROUND,
    "scene": GROUND,
    "conventions": GROUND,
    "techniques": (*GROUND, "conventions.files"),
    "aliasing": (*GROUND, "trace", "conventions.doubts"),
    "experiments": (*GROUND, "trace", "scene", "techniques", "aliasing", "conventions.doubts"),
    "pictures": (*GROUND, "trace", "scene", "aliasing"),
    "plot": (*GROUND, "scene", "aliasing", "experiments", "pictures"),
    "reports": (*GROUND, "scene", "techniques", "aliasing", "experiments", "pictures", "conventions.doubts"),
    "doctor": (*GROUND, "trace", "scene", "techniques"),
    "cli": (*GROUND, "scene", "conventions", "techniques", "experiments", "reports", "doctor"),
}
MOST_ROOMS = 16

# Results show themselves: each of these imports what shows it where it is called, and no sooner.
UPWARD = {
    ("scene.view", "View._repr_html_"): ("reports",),
    ("experiments.study", "Study._sentences"): ("reports",),
    ("experiments.study", "Study.figure"): ("plot",),
    ("experiments.study", "Study.save"): ("reports",),
    ("experiments.study", "Study.load"): ("reports",),
    ("experiments.study", "Study.save_arrays"): ("reports",),
    ("experiments.study", "Study._repr_html_"): ("reports",),
    ("experiments.study", "Study.__repr__"): ("reports",),
    ("experiments.advice", "Advice.sentences"): ("reports",),
    ("experiments.advice", "Advice.reproduce"): ("reports",),
    ("experiments.advice", "Advice.figure"): ("plot",),
    ("experiments.advice", "Advice.save"): ("reports",),
    ("experiments.advice", "Advice.load"): ("reports",),
    ("experiments.advice", "Advice._repr_html_"): ("reports",),
    ("experiments.advice", "Advice.__repr__"): ("reports",),
    ("experiments.smallest_bias", "SmallestBias.figure"): ("plot",),
    ("experiments.prefiltered", "PrefilteredMaps.figure"): ("plot",),
    ("experiments.pixel_explanation", "PixelExplanation.figure"): ("plot",),
    ("experiments.pixel_explanation", "PixelExplanation.__str__"): ("reports",),
    ("experiments.scene_optimal_table", "SceneOptimalTable.figure"): ("plot",),
    ("experiments.scene_optimal_table", "SceneOptimalTable.save"): ("reports",),
    ("experiments.scene_optimal_table", "SceneOptimalTable.__repr__"): ("reports",),
    # Experiments over many maps stand in the list of aliasing by name; they are loaded at the first use.
    ("aliasing", TYPE_CHECKING): ("experiments",),
}
# The lists that load by name.
LOADING_LISTS = ("", "aliasing")

# What shadows are made of: each has a type, wherever it is an argument, a field or a variable.
TYPED = (
    "scene", "camera", "cameras", "light", "lights", "renderer", "gbuffer", "technique", "techniques",
    "parameterization",
)  # fmt: skip

# A name of two things that their rooms keep apart for whoever uses them.
SAME_NAME = {
    "causes": "aliasing.causes counts them, plot.causes draws the bars",
    "table": "library.table lists the scenes, columns.table makes every table of experiments",
}


def forbidden(module: str, source: str) -> list[str]:
    """The imports of one file that the table forbids, each as a sentence."""
    room = room_of(module)
    if room not in MAY_USE:
        return [f"{room} is not in the table of tests/test_layers.py"]
    allowed = MAY_USE[room]
    complaints = []
    for one in imports_of(source, module, MODULES):
        excepted = UPWARD.get((module, one.scope), ())
        if room_of(one.target) != room and not within(one.target, (*allowed, *excepted)):
            what = one.target or "the whole package"
            complaints.append(f"{module}, line {one.line} ({one.scope or 'top'}) uses {what}")
    if module not in LOADING_LISTS:
        complaints += [f"{module}, line {line} imports by a text" for line in loads_by_name(source)]
    return complaints


def within(target: str, allowed: tuple[str, ...]) -> bool:
    """Whether a module is one of these, or stands in one of these rooms."""
    return any(target == one or target.startswith(f"{one}.") for one in allowed)


def graph_of_modules() -> dict[str, set[str]]:
    """Which modules each uses, without the exceptions."""
    graph: dict[str, set[str]] = {module: set() for module in MODULES}
    for module, imports in IMPORTS.items():
        for one in imports:
            if not within(one.target, UPWARD.get((module, one.scope), ())) and one.target != module:
                graph[module].add(one.target)
    return graph


def graph_of_rooms(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Which rooms each uses, the list of the whole package left out: it is above them all."""
    rooms: dict[str, set[str]] = defaultdict(set)
    for module, targets in graph.items():
        if module:
            rooms[room_of(module)] |= {room_of(target) for target in targets} - {room_of(module)}
    return rooms


def modules_twice(modules: list[str]) -> list[str]:
    """Modules of one room that are called the same; `arguments` may be, each checks those of its folder.

    In two rooms a module may be called the same where its subject is: the causes of wrong pixels are `causes` as
    numbers (aliasing), as pictures and as plots.
    """
    found = defaultdict(list)
    for module in modules:
        if "." in module and not is_list(module, MODULES):
            found[room_of(module), module.rpartition(".")[2]].append(module)
    return [" and ".join(of) for (_, name), of in found.items() if len(of) > 1 and name != "arguments"]


def names_twice(sources: dict[str, str]) -> list[str]:
    """Names that two modules define, private ones in one room; lists of packages define none of their own."""
    found = defaultdict(list)
    for module, source in sources.items():
        if not is_list(module, MODULES) and room_of(module) != "_core":
            for name in names_of(source):
                found[room_of(module) if name.startswith("_") else "", name].append(module)
    return [f"{name}: {', '.join(of)}" for (_, name), of in found.items() if len(of) > 1 and name not in SAME_NAME]


def test_imports_point_down():
    complaints = [line for module, source in SOURCES.items() if module for line in forbidden(module, source)]
    assert len(SOURCES) > 80, f"only {len(SOURCES)} modules found: is the walk broken?"
    assert not complaints, "imports that the table of layers forbids:\n" + "\n".join(complaints)


def test_no_module_uses_itself_by_way_of_others():
    graph = graph_of_modules()
    assert sum(map(len, graph.values())) > 300
    assert circle_in(graph) is None
    assert circle_in(graph_of_rooms(graph)) is None
    assert circle_in({room: {room_of(one) for one in allowed} for room, allowed in MAY_USE.items()}) is None


def test_rooms_are_few():
    rooms = {room_of(module) for module in MODULES if module}
    assert rooms == set(MAY_USE)
    assert len(rooms) <= MOST_ROOMS


def test_a_module_has_its_name_for_itself_in_its_room():
    assert modules_twice(list(MODULES)) == []


def test_a_name_is_defined_once():
    assert names_twice(SOURCES) == []
    defined = [name for module, source in SOURCES.items() if not is_list(module, MODULES) for name in names_of(source)]
    assert all(defined.count(name) > 1 for name in SAME_NAME), "an exception that nothing needs"


def test_every_exception_is_needed():
    used = set()
    for module, imports in IMPORTS.items():
        for one in imports:
            if room_of(module) and room_of(one.target) != room_of(module):
                allowed = within(one.target, MAY_USE[room_of(module)])
                used |= {(module, one.scope, room_of(one.target))} if not allowed else set()
    assert used == {(*where, room) for where, rooms in UPWARD.items() for room in rooms}


def test_scenes_lights_and_the_like_have_types():
    complaints = [f"{module}, {line}" for module, source in SOURCES.items() for line in untyped(source, TYPED)]
    assert not complaints, "without a type:\n" + "\n".join(complaints)


@pytest.mark.parametrize("module", LOADING_LISTS)
def test_what_lists_load_by_name_is_there(module):
    assert loads_by_name(SOURCES[module])
    package = importlib.import_module(f"shadowlab.{module}".rstrip("."))
    for name in package.__all__:
        assert getattr(package, name) is not None


def test_the_extension_names_modules_that_are_there():
    named = set()
    for path in sorted((PROJECT / "src" / "python").glob("**/*.rs")):
        named |= set(re.findall(r'import\("shadowlab\.([\w.]+)"\)', path.read_text(encoding="utf-8")))
    assert {"errors", "conventions.convention", "aliasing.footprint"} <= named
    assert named <= set(MODULES)


def test_the_table_is_that_of_the_document():
    document = (PROJECT / "docs" / "ARCHITECTURE.md").read_text(encoding="utf-8")
    section = document.partition("\n## Rooms\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \|[^|]*\| ([^|]*) \|$", section, re.MULTILINE)
    told = {room: {*re.findall(r"`([\w.]+)`", cell), *(GROUND if "the ground" in cell else ())} for room, cell in rows}
    assert told == {room: set(allowed) for room, allowed in MAY_USE.items()}


FORBIDDEN = (
    "from ..plot import axes",
    "from .. import plot",
    "from .. import errors, plot",
    "from ..plot import *",
    "from ..plot.axes import say as words",
    "from ..reports.html.page import save_study",
    "import shadowlab.plot.axes",
    "import numpy, shadowlab.plot as drawn",
    "from shadowlab import plot",
    "from shadowlab.reports.words import place",
    "def f():\n    from ..reports import words",
    "async def f():\n    from ..reports import words",
    "class A:\n    def f(self):\n        from .. import reports\n        return reports",
    "class Study:\n    def table(self):\n        from ..plot import study_figure",
    "if TYPE_CHECKING:\n    from ..plot import axes",
    "if typing.TYPE_CHECKING:\n    import shadowlab.cli",
    "try:\n    import shadowlab.doctor\nexcept ImportError:\n    pass",
    "with open('x') as f:\n    from ..cli import main",
    "from ..conventions import diagnosis",
    "from ..conventions.convention import Convention",
    "from .. import Scene",
    "from shadowlab import Scene",
    "from shadowlab import *",
    "from .. import *",
    "import shadowlab",
    "import shadowlab as sl",
    "from importlib import import_module\nimport_module('shadowlab.plot')",
    "import importlib\nplot = importlib.import_module(name, package)",
    "plot = __import__('shadowlab.plot')",
)


@pytest.mark.parametrize("source", FORBIDDEN)
def test_a_forbidden_import_is_found_however_it_is_written(source):
    assert len(forbidden("experiments.study", source)) == 1


@pytest.mark.parametrize(
    "source",
    [
        "from . import run\nfrom .run import evaluate\nfrom ..aliasing.causes import CAUSES",
        "from .. import _core, aliasing, trace\nfrom ..conventions.doubts import notes_on",
        "import shadowlab.scene.view\nfrom shadowlab.techniques import registry\nfrom shadowlab.scene.view import View",
        "import numpy as np\nfrom plot import axes\nimport reports\nfrom shadowlabs import plot",
        "# from ..plot import axes\nTEXT = 'from ..plot import axes'\n'''import shadowlab.cli'''",
        "class Study:\n    def figure(self):\n        from .. import plot",
    ],
)
def test_what_points_down_or_is_no_import_passes(source):
    assert forbidden("experiments.study", source) == []


@pytest.mark.parametrize(
    "source",
    [
        "def f(scene: Any): ...",
        "async def f(*, camera: Any = None): ...",
        "def f(light: Any | None, /): ...",
        "def f(*lights: typing.Any): ...",
        "def f(cameras: Sequence[Any]): ...",
        "def f(renderer: 'Renderer | Any'): ...",
        "class A:\n    gbuffer: Any",
        "class A:\n    def f(self):\n        self.technique: dict[str, Any] = {}",
        "class A:\n    @property\n    def parameterization(self) -> Any: ...",
        "f = lambda: 0\ntechniques: Any = f()",
    ],
)
def test_a_name_without_a_type_is_found(source):
    assert len(untyped(source, TYPED)) == 1


@pytest.mark.parametrize(
    "source",
    [
        "def f(scene: Scene, *, camera: Camera | None = None): ...",
        "def f(scene, camera): ...",
        "def f(row: Mapping[str, Any], scenes: Any): ...",
        "class A:\n    light: Light\n    numbers: dict[str, Any]",
        "# scene: Any\nTEXT = 'scene: Any'",
        "def f(light: 'AnyLight'): ...",
    ],
)
def test_what_has_a_type_or_another_name_passes(source):
    assert untyped(source, TYPED) == []


def test_a_list_of_a_package_is_at_home_in_it():
    assert forbidden("plot", "from .axes import say\nfrom . import curves\nfrom .. import pictures") == []
    assert len(forbidden("plot", "from ..reports import words")) == 1
    assert len(forbidden("reports.html.page", "from ...plot import axes\nfrom ..words import place")) == 1
    assert forbidden("aliasing", "if TYPE_CHECKING:\n    from ..experiments.temporal import Temporal") == []
    assert len(forbidden("aliasing", "from ..experiments.temporal import Temporal")) == 1
    assert len(forbidden("_core", "from .errors import ArgumentError")) == 1
    assert len(forbidden("novelty.plan", "")) == 1
    with pytest.raises(ImportError, match="leads out of shadowlab"):
        forbidden("plot.axes", "from ... import elsewhere")


def test_a_circle_is_found_and_a_line_is_none():
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": set()}) is None
    assert circle_in({"a": {"b", "c"}, "b": {"c"}, "c": {"d"}}) is None
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert circle_in({"a": {"a"}}) == ["a", "a"]
    graph = graph_of_modules()
    graph["text"] |= {"techniques.labels"}
    assert circle_in(graph) is not None
    assert circle_in(graph_of_rooms(graph)) is not None


def test_modules_of_one_name_in_one_room_are_found():
    assert modules_twice(["plot.causes", "pictures.causes", "reports.words", "plot.deep.words"]) == []
    assert modules_twice(["reports.words", "reports.html.words"]) == ["reports.words and reports.html.words"]
    assert modules_twice(["aliasing.arguments", "aliasing.closed_form.arguments"]) == []


@pytest.mark.parametrize(
    "second",
    [
        "def twice(): ...",
        "async def twice(): ...",
        "class twice: ...",
        "twice = 1",
        "once, (twice, *rest) = made()",
        "twice: int = 1",
        "if condition:\n    twice = 1",
        "try:\n    pass\nexcept ImportError:\n    twice = None",
    ],
)
def test_a_name_that_two_modules_define_is_found(second):
    assert names_twice({"plot.axes": "def twice(): ...", "reports.words": second}) == [
        "twice: plot.axes, reports.words"
    ]
    private = {
        module: source.replace("twice", "_twice")
        for module, source in {"plot.a": "twice = 1", "plot.b": second}.items()
    }
    assert names_twice(private) == ["_twice: plot.a, plot.b"]


def test_names_within_others_or_of_another_room_are_no_second_definition():
    assert (
        names_twice({"plot.a": "def f():\n    twice = 1", "plot.b": "class A:\n    twice = 1", "plot.c": "twice = 1"})
        == []
    )
    assert names_twice({"plot.a": "def _twice(): ...", "reports.b": "def _twice(): ..."}) == []
    assert names_twice({"plot.a": "T = TypeVar('T')", "plot.b": "T = typing.TypeVar('T')"}) == []
    assert names_twice({"plot.a": "x.twice = 1\ny[twice] = 1", "plot.b": "twice = 1"}) == []
    assert names_twice({"plot.a": "@overload\ndef f(): ...\ndef f(): ..."}) == []
