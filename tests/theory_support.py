"""Citations of docs/theory.md and docs/references.md: found in comments, docstrings and documentation, and resolved.

The forms are those that the head of docs/theory.md defines. Strings of a program are not read, nor are notebooks.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

SECTION = r"(?:\d{1,2}(?:\.\d{1,2})?|E(?:\.\d{1,2})?)"
# A number in parentheses after a word is an argument: sin(0.5).
EQUATION = r"(?<![\w)\]])\((?:\d{1,2}|E)\.[1-9]\d?\)"
ITEM = rf"(?:{EQUATION}|{SECTION}(?![\w]|\.\d))"
LIST = re.compile(rf"\btheory\.md\s+(?P<items>{ITEM}(?:(?:,\s+and|,|\s+and|\s+to)\s+{ITEM})*)")
KEY = re.compile(r"\[(?P<key>[a-z]+(?:19|20)\d\d[a-z]*)\](?!:)")
OWN_SECTION = re.compile(rf"§(?P<section>{SECTION})")
AUTHORS = re.compile(r"(?:\b[A-Z]\w+|\bal\.)\s+(?:19|20)\d\d\b(?!\s+`?\[)")
SOURCE = re.compile(r"\bSources?:\s(?:.|\n(?!\s*\n))*")
# What stands for a citation and is none, with what to write.
STALE = {
    re.compile(r"\b[Tt]heory\s+(?:\d|E\.\d)"): "write theory.md before the number",
    re.compile(r"(?<![\w.(])E\.\d(?!\w)"): "an equation stands in parentheses, a section behind theory.md",
    re.compile(r"\b[Ee]q(?:uations?|\.)\s+\(?(?:\d{1,2}|E)\.\d"): "write the number in parentheses alone",
}

# A token of Rust or WGSL: strings and characters are passed over, comments are kept.
TOKEN = re.compile(
    r"""(?P<raw>\br(\#*)".*?"\2)|(?P<string>"(?:\\.|[^"\\])*")|(?P<char>'(?:\\[^\n']+|[^'\\\n])')"""
    r"""|(?P<line>//[^\n]*)|(?P<block>/\*.*?\*/)""",
    re.DOTALL,
)
SUFFIXES = (".rs", ".wgsl", ".py", ".md")


@dataclass(frozen=True)
class Passage:
    """Text that belongs together, and the line in the file of each of its lines."""

    text: str
    lines: tuple[int, ...]

    def line_at(self, offset: int) -> int:
        starts = list(accumulate((len(line) + 1 for line in self.text.split("\n")), initial=0))
        return self.lines[bisect_right(starts, offset) - 1]


@dataclass(frozen=True)
class Theory:
    """What can be cited."""

    sections: frozenset[str]
    equations: frozenset[str]
    keys: frozenset[str]


@dataclass(frozen=True)
class Citation:
    """A number or key as it stands somewhere; `form` is section, equation, key, or what is wrong with it."""

    form: str
    value: str
    path: Path
    line: int

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.form} {self.value}"


def passages(path: Path) -> list[Passage]:
    """The comments and docstrings of a program, or the whole of a page."""
    text = path.read_text("utf-8")
    if path.suffix == ".md":
        lines = text.split("\n")
        return [Passage(text, tuple(range(1, len(lines) + 1)))]
    if path.suffix == ".py":
        return _joined(_python_comments(text)) + list(_python_docstrings(text))
    return _joined(_comments(text))


def _comments(text: str) -> Iterator[tuple[int, str]]:
    """The lines of comments of Rust or WGSL, by line number."""
    for match in TOKEN.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        if match["line"]:
            yield line, re.sub(r"^//[/!]?\s?", "", match["line"])
        elif match["block"]:
            yield from enumerate(match["block"].split("\n"), line)


def _python_comments(text: str) -> Iterator[tuple[int, str]]:
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("#").strip()


def _python_docstrings(text: str) -> Iterator[Passage]:
    """Every string that stands as a statement of its own."""
    source = text.split("\n")
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            first, last = node.lineno, node.end_lineno or node.lineno
            yield Passage("\n".join(source[first - 1 : last]), tuple(range(first, last + 1)))


def _joined(lines: Iterator[tuple[int, str]]) -> list[Passage]:
    """Comments on consecutive lines as one text: a citation can be wrapped."""
    found: list[list[tuple[int, str]]] = []
    for number, text in lines:
        if found and found[-1][-1][0] == number - 1:
            found[-1].append((number, text))
        else:
            found.append([(number, text)])
    return [Passage("\n".join(t for _, t in run), tuple(n for n, _ in run)) for run in found]


def citations(path: Path, name: Path | None = None) -> list[Citation]:
    """All citations in a file, and what looks like one and is none; `name` is what they are listed under."""
    found: list[Citation] = []
    name = name or path
    for passage in passages(path):

        def add(form: str, value: str, offset: int, passage: Passage = passage) -> None:
            found.append(Citation(form, " ".join(value.split()), name, passage.line_at(offset)))

        listed: list[tuple[int, int]] = []
        for match in LIST.finditer(passage.text):
            listed.append(match.span())
            for item in re.finditer(ITEM, match["items"]):
                if not item[0].startswith("("):
                    add("section", item[0], match.start("items") + item.start())
        for match in re.finditer(EQUATION, passage.text):
            add("equation", match[0], match.start())
        for match in KEY.finditer(passage.text):
            add("key", match["key"], match.start())
        if path.name == "theory.md":
            for match in OWN_SECTION.finditer(passage.text):
                add("section", match["section"], match.start())
        if path.suffix == ".md":
            continue
        for pattern, advice in STALE.items():
            for match in pattern.finditer(passage.text):
                if not any(a <= match.start() < b for a, b in listed):
                    add(f"not a citation ({advice}):", match[0], match.start())
        for source in SOURCE.finditer(passage.text):
            for match in AUTHORS.finditer(source[0]):
                add("no [key] behind", match[0], source.start() + match.start())
    return found


def files(root: Path) -> list[Path]:
    """Every file whose citations are resolved."""
    folders = [root / folder for folder in ("src", "python", "tests", "benches", "docs")]
    inside = [p for folder in folders for suffix in SUFFIXES for p in folder.rglob(f"*{suffix}")]
    return sorted([*inside, root / "README.md", root / "CONTRIBUTING.md"])


def declared_sections(theory: str) -> list[str]:
    """The numbers of the headings."""
    return re.findall(rf"^#{{2,3}} ({SECTION})\.? ", theory, re.MULTILINE)


def declared_equations(theory: str) -> list[tuple[str, str]]:
    """Each number at the end of a displayed line, with the section it stands in."""
    found, section, inside = [], "", False
    for line in theory.split("\n"):
        if line.startswith("```"):
            inside = not inside
        elif heading := re.match(rf"#{{2,3}} ({SECTION})\.? ", line):
            section = heading[1]
        elif inside and (number := re.search(rf"\s({EQUATION})$", line)):
            found.append((number[1], section))
    return found


def declared_keys(references: str) -> list[str]:
    """The keys of the list of sources."""
    return re.findall(r"^- \*\*([a-z]+(?:19|20)\d\d[a-z]*)\*\*", references, re.MULTILINE)


def theory_of(root: Path) -> Theory:
    """What the two pages of a checkout declare."""
    theory, references = ((root / "docs" / page).read_text("utf-8") for page in ("theory.md", "references.md"))
    equations = frozenset(number for number, _ in declared_equations(theory))
    return Theory(frozenset(declared_sections(theory)), equations, frozenset(declared_keys(references)))


def unresolved(found: list[Citation], theory: Theory) -> list[str]:
    """Citations of what is not there, as file:line, in the order of the files."""
    there = {"section": theory.sections, "equation": theory.equations, "key": theory.keys}
    wrong = [c for c in found if c.value not in there.get(c.form, frozenset())]
    return [str(c) for c in sorted(wrong, key=lambda c: (c.path, c.line))]


def uncited(found: list[Citation], theory: Theory) -> list[str]:
    """Sources that only the list of sources itself names."""
    cited = {c.value for c in found if c.form == "key" and c.path.name != "references.md"}
    return sorted(theory.keys - cited)


def duplicates(declared: list[str]) -> list[str]:
    """What is declared more than once."""
    return sorted(value for value, count in Counter(declared).items() if count > 1)
