"""Nobody reads back the texts that we write: notes, failures, verdicts."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import shadowlab as sl

PACKAGE = Path(sl.__file__).parent
# Names of texts that we write for people: who wants to know asks kinds, attributes or numbers.
TEXTS = {
    "note",
    "notes",
    "failure",
    "reason",
    "reasons",
    "refusal",
    "verdict",
    "sentence",
    "sentences",
    "doubt",
    "error",
}
READERS = {
    "startswith", "endswith", "removeprefix", "removesuffix", "split", "rsplit", "partition", "rpartition", "find",
    "index", "replace",
}  # fmt: skip
PATTERNS = {"match", "search", "fullmatch", "finditer", "findall", "sub"}
# Regular expressions are for what people type, for names of files, for anchors and for files that are read.
MAY_IMPORT_RE = {
    "experiments/memory.py": "budgets as people type them",
    "experiments/store/mounts.py": "blanks in the list of mounts",
    "experiments/store/row_filter.py": "words of SQL in questions that people type",
    "reports/html/album.py": "marks of pictures, which no text says",
    "reports/html/page.py": "names of the pictures that an earlier report wrote",
    "reports/html/parts.py": "anchors made from labels",
    "scene/formats/obj_lines.py": "lines that go on, in text files",
    "scene/formats/off.py": "the first word of files",
    "scene/formats/stl.py": "vertices in text files",
    "scene/formats/words.py": "comments and words of text files",
}


def names_in(node: ast.AST) -> Iterator[str]:
    """The names, attributes and keys of an expression."""
    for one in ast.walk(node):
        if isinstance(one, ast.Name):
            yield one.id
        elif isinstance(one, ast.Attribute):
            yield one.attr
        elif isinstance(one, ast.Subscript) and isinstance(one.slice, ast.Constant):
            yield str(one.slice.value)


def readers_of_text(source: str) -> list[int]:
    """The lines that look into a text of ours."""
    found = []
    for node in ast.walk(ast.parse(source)):
        looked_at: list[ast.AST] = []
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            on = node.func.value
            if isinstance(on, ast.Name) and on.id == "re":
                looked_at = [*node.args]
            elif node.func.attr in PATTERNS:
                looked_at = [on, *node.args]
            elif node.func.attr in READERS and node.args:  # without arguments `split` only trims
                looked_at = [on]
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            text_in = any(isinstance(op, (ast.In, ast.NotIn)) for op in node.ops) and texts(node.left)
            looked_at = sides[1:] if text_in else []
        if any(TEXTS & set(names_in(one)) for one in looked_at):
            found.append(node.lineno)
    return found


def texts(node: ast.AST) -> bool:
    """Whether an expression is a text: a literal, or a constant by its name."""
    if isinstance(node, ast.Name):
        return node.id.isupper()
    literal = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return literal or isinstance(node, ast.JoinedStr)


@pytest.mark.parametrize("reader", [
    'x = run.failure.startswith("technique")', 'x = str(error).rpartition("; ")[2]', 'x = "no warp" in row["notes"]',
    "x = CHECK in self.notes", 're.sub("a", "b", row["failure"])', "re.split(PATTERN, study.verdict)",
    'x = f"{a}: " not in notes', "OF_MAPS.match(note)",
])  # fmt: skip
def test_a_reader_of_texts_is_found(reader):
    assert readers_of_text(reader) == [1]


@pytest.mark.parametrize("reader", [
    'x = any(note.kind == "no_warp" for note in notes)', "x = note in notes", "x = label.startswith('a')",
    "x = str(error).split()", 're.sub("a", "b", label)',
])  # fmt: skip
def test_what_asks_data_is_no_reader(reader):
    assert readers_of_text(reader) == []


def test_no_module_reads_the_texts_that_we_write():
    paths = sorted(PACKAGE.rglob("*.py"))
    assert len(paths) > 80
    readers = {
        str(path.relative_to(PACKAGE)): lines
        for path in paths
        if (lines := readers_of_text(path.read_text(encoding="utf-8")))
    }
    assert readers == {}
    with_re = {
        str(path.relative_to(PACKAGE))
        for path in paths
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import) and any(alias.name == "re" for alias in node.names)
    }
    assert with_re == set(MAY_IMPORT_RE)
