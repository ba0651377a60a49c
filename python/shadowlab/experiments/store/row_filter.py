"""Which rows a text asks for: `misclassified > 0 and technique in ["lispsm", "tsm"]`.

The text is read as an expression of Python's, of which only what a question needs is known: columns, numbers, texts,
comparisons, arithmetic, `and`, `or`, `not`. Nothing of it is handed to Python or SQLite to run. A comparison with a
missing value is neither true nor false, as in SQL, and a row of which the whole is not true is left out.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeAlias

from ...errors import ArgumentError, UnknownNameError
from ...text import shown
from ...text.checked import a_text
from .row_text import Cell

#: Of a row: the value of an expression, None where it is missing.
Asked: TypeAlias = Callable[[Mapping[str, Cell]], Any]

# Letters of a text, and expressions within one another: more than anybody writes, and far from Python's own limits.
LONGEST_WHERE, DEEPEST_WHERE = 4000, 40
EXAMPLE = 'try "misclassified > 0"'

_COMPARED: Mapping[type, Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_COMPUTED: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv
}  # fmt: skip
# What SQL writes otherwise, outside of texts.
_OF_SQL = ((r"<>", "!="), (r"(?<![<>=!])=(?!=)", "=="), (r"&&?", " and "), (r"\|\|?", " or "))
_WORDS_OF_SQL = {"AND": "and", "OR": "or", "NOT": "not", "IN": "in", "IS": "is", "NULL": "None", "null": "None"}
# A text in quotes, or a name in backticks.
_QUOTED = re.compile(r"""("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')|`([^`]*)`""")


def row_filter(where: object, columns: Collection[str]) -> Callable[[Mapping[str, Cell]], bool]:
    """Whether a row is one of those that a text asks for.

    Parameters
    ----------
    where : str
    columns : collection of str
        The names that it may use.

    Raises
    ------
    ArgumentError
        For something that is no such text, and, when it is asked of a row, for values that do not compare.
    UnknownNameError
        For a column that does not exist; the message lists those that do.
    """
    text = a_text("where", where)
    if not 0 < len(text.strip()) <= LONGEST_WHERE:
        raise ArgumentError(f"where: expected 1 to {LONGEST_WHERE:,} letters, got {shown(text)}; {EXAMPLE}")
    names: list[str] = []
    try:
        python = _as_python(text, names)
        tree = ast.parse(python, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        what = error.msg if isinstance(error, SyntaxError) else type(error).__name__
        raise ArgumentError(f"where: {shown(text)} does not read ({what}); {EXAMPLE}") from None
    asked = _Reading(columns, names, python).of(tree, 0)

    def wanted(row: Mapping[str, Cell]) -> bool:
        found = asked(row)
        if found is not None and not isinstance(found, bool):
            raise ArgumentError(f"where: expected something true or false, got {shown(found)}; compare it: {EXAMPLE}")
        return found is True

    return wanted


def _as_python(text: str, names: list[str]) -> str:
    """The text with SQL's words as Python's; names in backticks become numbered ones, which `names` keeps."""
    parts, at = [], 0
    for found in _QUOTED.finditer(text):
        parts.append(_words(text[at : found.start()]))
        if found[1] is not None:
            parts.append(found[1])
        else:
            parts.append(f" __{len(names)}__ ")
            names.append(found[2])
        at = found.end()
    return "".join([*parts, _words(text[at:])]).strip()


def _words(text: str) -> str:
    for pattern, python in _OF_SQL:
        text = re.sub(pattern, python, text)
    return re.sub(r"\b[A-Za-z]+\b", lambda found: _WORDS_OF_SQL.get(found[0], found[0]), text).replace("\n", " ")


class _Reading:
    """Makes functions of a row from the parts of an expression."""

    def __init__(self, columns: Collection[str], names: list[str], text: str):
        self._columns, self._names, self._text = columns, names, text

    def _shown(self, node: ast.expr) -> str:
        return shown(ast.get_source_segment(self._text, node))

    def of(self, node: ast.expr, depth: int) -> Asked:
        """The function of a part."""
        if depth > DEEPEST_WHERE:
            raise ArgumentError(f"where: expected at most {DEEPEST_WHERE} parentheses deep, got more; {EXAMPLE}")
        inner = [self.of(one, depth + 1) for one in _parts_of(node)]
        match node:
            case ast.Constant(value=bool() | int() | float() | str() | None as value):
                return lambda row: value
            case ast.Name() | ast.Attribute():
                return self._column(node)
            case ast.BoolOp(op=op):
                return _all(inner) if isinstance(op, ast.And) else _any(inner)
            case ast.UnaryOp(op=ast.Not()):
                return _not(inner[0])
            case ast.UnaryOp(op=ast.USub()):
                return lambda row: _computed(operator.sub, 0, inner[0](row))
            case ast.BinOp(op=op) if type(op) in _COMPUTED:
                how = _COMPUTED[type(op)]
                return lambda row: _computed(how, inner[0](row), inner[1](row))
            case ast.List() | ast.Tuple():
                return lambda row: [one(row) for one in inner]
            case ast.Compare(ops=ops):
                return _chain(inner, ops)
        known = "columns, numbers, texts, comparisons, + - * /, and, or, not, in"
        raise ArgumentError(f"where: expected {known}; got {self._shown(node)}; {EXAMPLE}")

    def _column(self, node: ast.expr) -> Asked:
        words, inner = [], node
        while isinstance(inner, ast.Attribute):  # names may have dots: `lispsm.near`
            words.append(inner.attr)
            inner = inner.value
        if not isinstance(inner, ast.Name):
            raise ArgumentError(f"where: expected the name of a column, got {self._shown(node)}; {EXAMPLE}")
        name = ".".join([inner.id, *reversed(words)])
        if found := re.fullmatch(r"__(\d+)__", name):
            name = self._names[int(found[1])]
        if name not in self._columns:
            raise UnknownNameError(f"where: unknown column {shown(name)}; expected one of {', '.join(self._columns)}")
        return lambda row: row.get(name)


def _parts_of(node: ast.expr) -> list[ast.expr]:
    match node:
        case ast.BoolOp(values=values):
            return values
        case ast.UnaryOp(operand=operand):
            return [operand]
        case ast.BinOp(left=left, right=right):
            return [left, right]
        case ast.List(elts=elts) | ast.Tuple(elts=elts):
            return elts
        case ast.Compare(left=left, comparators=comparators):
            return [left, *comparators]
    return []


def _truth(value: Any) -> bool | None:
    if value is None or isinstance(value, bool):
        return value
    raise ArgumentError(f"where: expected something true or false, got {shown(value)}; compare it: {EXAMPLE}")


def _all(parts: list[Asked]) -> Asked:
    def asked(row: Mapping[str, Cell]) -> bool | None:
        return _and([_truth(part(row)) for part in parts])

    return asked


def _any(parts: list[Asked]) -> Asked:
    def asked(row: Mapping[str, Cell]) -> bool | None:
        found = [_truth(part(row)) for part in parts]
        return True if True in found else None if None in found else False

    return asked


def _not(part: Asked) -> Asked:
    def asked(row: Mapping[str, Cell]) -> bool | None:
        found = _truth(part(row))
        return None if found is None else not found

    return asked


def _chain(values: list[Asked], ops: list[ast.cmpop]) -> Asked:
    """Comparisons side by side: `1 < maps <= 4`."""

    def asked(row: Mapping[str, Cell]) -> bool | None:
        found = [one(row) for one in values]
        return _and([_relation(op, a, b) for op, a, b in zip(ops, found[:-1], found[1:], strict=True)])

    return asked


def _and(found: list[bool | None]) -> bool | None:
    return False if False in found else None if None in found else True


def _relation(op: ast.cmpop, a: Any, b: Any) -> bool | None:
    if isinstance(op, (ast.Is, ast.IsNot)):
        if b is not None:
            raise ArgumentError(f"where: expected None after is, got {shown(b)}; compare with ==")
        return (a is None) is isinstance(op, ast.Is)
    if isinstance(op, (ast.In, ast.NotIn)):
        return _held(a, b, isinstance(op, ast.In))
    if a is None or b is None:
        return None
    if isinstance(a, list) or isinstance(b, list) or isinstance(a, str) != isinstance(b, str):
        raise ArgumentError(f"where: expected values of one kind, got {shown(a)} and {shown(b)}; {EXAMPLE}")
    return _COMPARED[type(op)](a, b)


def _held(a: Any, b: Any, wanted: bool) -> bool | None:
    """Whether a value is in a list, or a text in a text."""
    if a is None or b is None:
        return None
    if isinstance(b, list) and not isinstance(a, list):
        return (a in b) is wanted
    if isinstance(a, str) and isinstance(b, str):
        return (a in b) is wanted
    raise ArgumentError(
        f'where: expected a list or a text after in, got {shown(b)}; try technique in ["lispsm", "tsm"]'
    )


def _computed(how: Callable[[Any, Any], Any], a: Any, b: Any) -> Any:
    """A number; None where one is missing, and where there is none: division by zero, overflow."""
    if a is None or b is None:
        return None
    if not all(isinstance(one, (int, float)) for one in (a, b)):
        raise ArgumentError(f"where: expected numbers, got {shown(a)} and {shown(b)}; {EXAMPLE}")
    try:
        found = how(a, b)
    except (ZeroDivisionError, OverflowError):
        return None
    return None if found != found else found
