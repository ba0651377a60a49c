"""The stub of the extension says what the extension says: the same names, signatures and docstrings."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import imported

from shadowlab import _core

# The stub, and the parts that it exports; what signatures are made of is no part of the extension.
STUBS = sorted(Path(_core.__file__).parent.glob("_core*.pyi"))
TREES = {path.stem: ast.parse(path.read_text(encoding="utf-8")) for path in STUBS}
SHAPES = "_core_types"


def entries(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, str | None]]:
    """The classes, methods, properties and functions of a stub by their dotted names, each with its docstring."""
    for node in body:
        if isinstance(node, ast.ClassDef):
            yield f"{prefix}{node.name}", ast.get_docstring(node)
            yield from entries(node.body, f"{prefix}{node.name}.")
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("__"):
            yield f"{prefix}{node.name}", ast.get_docstring(node)


def of_extension(name: str) -> object:
    """What the extension has under a dotted name."""
    found: object = _core
    for part in name.split("."):
        found = getattr(found, part)
    return found


ENTRIES = {
    name: text
    for stem, tree in TREES.items()
    for name, text in entries(tree.body, f"{SHAPES}." if stem == SHAPES else "")
}


def differences(told: dict[str, str | None]) -> list[str]:
    """The entries whose docstring is not that of the extension, or of which either has none."""
    found = []
    for name, text in told.items():
        # Protocols of what the extension takes are no part of it.
        own = None if name.startswith("_") else getattr(of_extension(name), "__doc__", None)
        if not text or (not name.startswith("_") and text != inspect.cleandoc(own or "")):
            found.append(f"{name}: {text!r} in the stub, {own!r} in the extension")
    return found


def test_every_entry_has_the_docstring_of_the_extension():
    assert len(ENTRIES) > 130
    assert differences(ENTRIES) == []


@pytest.mark.parametrize("text", [None, "", "Something else.", _core.Camera.__doc__.strip() + " And more."])
def test_another_docstring_or_none_is_found(text):
    assert differences({"Camera": inspect.cleandoc(_core.Camera.__doc__)}) == []
    assert len(differences({"Camera": text})) == 1
    assert len(differences({"_Convention": None})) == 1


def test_signatures_are_those_of_the_extension():
    imported("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "shadowlab._core", "--ignore-missing-stub"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"


def test_the_stub_imports_nothing_of_the_package():
    nodes = [node for tree in TREES.values() for node in ast.walk(tree)]
    modules = {"." * node.level + str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    parts = {f".{stem}" for stem in TREES if stem != "_core"}
    assert modules <= {"collections.abc", "typing", "typing_extensions", "numpy", "numpy.typing"} | parts
