"""What the modules of a Python package import, define and load by name, read from their syntax trees.

A module is its dotted name within the package: `experiments.run`. A package's list, its `__init__`, has the package's
name, `experiments`; that of the whole package has the empty name.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

#: The block of imports that only type checkers read, as a scope.
TYPE_CHECKING = "TYPE_CHECKING"
#: Functions that import what a text names.
LOADERS = ("import_module", "__import__")


@dataclass(frozen=True)
class Import:
    """One import.

    Attributes
    ----------
    target : str
        The module that is imported, within the package; "" for the list of the whole package.
    scope : str
        Class and function that it stands in, such as "Study.figure"; "TYPE_CHECKING" for what type checkers read.
    line : int
    """

    target: str
    scope: str
    line: int


def modules_of(root: Path) -> dict[str, Path]:
    """The files of a package by the names of their modules, stubs among them."""
    found = {}
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.pyi")]):
        parts = path.relative_to(root).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def room_of(module: str) -> str:
    """The folder at the top of the package that a module stands in, or the file at the top that it is.

    The extension's stub is divided into several files, which are one room; `python -m` with the package is its command
    line.
    """
    top = module.partition(".")[0]
    return "_core" if top.startswith("_core") else "cli" if top == "__main__" else top


def imports_of(source: str, module: str, modules: Mapping[str, Path], package: str = "shadowlab") -> list[Import]:
    """All imports of the package's own modules, at any depth; what comes from elsewhere is left out.

    An import that names the package itself, or something of it that is no module, is one of the package's list.
    """
    home = module.split(".") if module else []
    if not is_list(module, modules):
        home = home[:-1]
    found = []
    for node, scope in walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                first, _, rest = alias.name.partition(".")
                if first == package:
                    found.append(Import(nearest(rest, modules), scope, node.lineno))
        elif isinstance(node, ast.ImportFrom):
            base = base_of(node, home, package)
            if base is not None:
                targets = {nearest(".".join([*base, alias.name]), modules) for alias in node.names}
                found += [Import(target, scope, node.lineno) for target in sorted(targets)]
    return found


def is_list(module: str, modules: Mapping[str, Path]) -> bool:
    """Whether a module is the list of a package."""
    return module in modules and modules[module].name == "__init__.py"


def base_of(node: ast.ImportFrom, home: list[str], package: str) -> list[str] | None:
    """What stands before the names of `from ... import`; None where it is not of the package."""
    named = node.module.split(".") if node.module else []
    if node.level:
        if node.level - 1 > len(home):
            raise ImportError(f"line {node.lineno}: {'.' * node.level} leads out of {package}")
        return home[: len(home) - node.level + 1] + named
    return named[1:] if named[:1] == [package] else None


def nearest(name: str, modules: Mapping[str, Path]) -> str:
    """The module of a dotted name, which may go on with what the module defines."""
    while name and name not in modules:
        name = name.rpartition(".")[0]
    return name


def walk(node: ast.AST, scope: str = "") -> Iterator[tuple[ast.AST, str]]:
    """All nodes below one, each with the scope that it stands in."""
    for child in ast.iter_child_nodes(node):
        inner = scope
        if isinstance(child, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            inner = f"{scope}.{child.name}" if scope else child.name
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            inner = TYPE_CHECKING
        yield child, inner
        yield from walk(child, inner)


def untyped(source: str, names: Iterable[str]) -> list[str]:
    """The arguments, fields, variables and properties of these names whose annotation has `Any` in it, with lines."""
    found = []
    for node, _ in walk(ast.parse(source)):
        if isinstance(node, ast.arg):
            name, annotation = node.arg, node.annotation
        elif isinstance(node, ast.AnnAssign):
            name, annotation = ast.unparse(node.target).rpartition(".")[2], node.annotation
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            name, annotation = node.name, node.returns
        else:
            continue
        if name in names and annotation is not None and "Any" in words_of(annotation):
            found.append(f"line {node.lineno}: {name}: {ast.unparse(annotation)}")
    return found


def words_of(annotation: ast.expr) -> set[str]:
    """The names in an annotation, also where it is a text."""
    words = set()
    for node in ast.walk(annotation):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            words |= set(re.findall(r"\w+", node.value))
        elif isinstance(node, (ast.Name, ast.Attribute)):
            words.add(ast.unparse(node).rpartition(".")[2])
    return words


def loads_by_name(source: str) -> list[int]:
    """The lines that import what a text names, whatever the text is."""
    lines = []
    for node, _ in walk(ast.parse(source)):
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func).rpartition(".")[2]
            lines += [node.lineno] if called in LOADERS else []
    return lines


def names_of(source: str) -> list[str]:
    """The functions, classes and constants that a module defines at its top, each once; type variables are none."""
    found: dict[str, None] = {}
    for node in top_of(ast.parse(source)):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            found[node.name] = None
        elif isinstance(node, (ast.Assign, ast.AnnAssign)) and not is_type_variable(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [part for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)]
            found.update(dict.fromkeys(name.id for name in names if isinstance(name.ctx, ast.Store)))
    found.pop("__all__", None)
    return list(found)


def top_of(tree: ast.Module) -> Iterator[ast.stmt]:
    """The statements at the top of a module, those within `if`, `try` and `with` among them."""
    waiting: list[ast.stmt] = list(tree.body)
    while waiting:
        node = waiting.pop(0)
        yield node
        if isinstance(node, (ast.If, ast.Try, ast.With)):
            parts = [getattr(node, name, []) for name in ("body", "orelse", "finalbody")]
            parts += [handler.body for handler in getattr(node, "handlers", [])]
            waiting = [inner for part in parts for inner in part] + waiting


def is_type_variable(value: ast.expr | None) -> bool:
    """Whether an expression makes a type variable, which each module has to make for itself."""
    return isinstance(value, ast.Call) and ast.unparse(value.func).rpartition(".")[2] in ("TypeVar", "ParamSpec")


def circle_in(graph: Mapping[str, set[str]]) -> list[str] | None:
    """The nodes of a circle in order, the first again at the end; None where there is none."""
    done: set[str] = set()

    def visit(node: str, path: list[str]) -> list[str] | None:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return None
        for following in sorted(graph.get(node, ())):
            circle = visit(following, [*path, node])
            if circle:
                return circle
        done.add(node)
        return None

    for node in sorted(graph):
        circle = visit(node, [])
        if circle:
            return circle
    return None
