"""Scenes made again from their recipes: the line of Python that a scene keeps of how it was made.

A recipe that comes out of a file is read, not run: it may say `sl.library.scene`, `sl.load_scene`, sums of scenes and
the moves of a scene, all with literal arguments, and nothing else.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any

from ..errors import LoadError, ShadowlabError
from ..text import reason_of, shown
from . import library
from .files import load_scene
from .formats.limits import Limits
from .scenes import Scene

#: What a recipe calls, by its name there.
MAKERS: Mapping[str, Callable[..., Any]] = {
    "sl.library.scene": library.scene, "sl.load_scene": load_scene, "sl.Limits": Limits
}  # fmt: skip
MOVES = ("with_ground", "transformed", "with_transforms")


def scene_of_recipe(recipe: str) -> Scene:
    """The scene that a recipe makes.

    Raises
    ------
    LoadError
        For a text that is no recipe, and a scene that can no longer be made, as of a file that is gone.
    """
    try:
        made = _made(ast.parse(recipe, mode="eval").body)
    except ShadowlabError:
        raise
    except Exception as error:  # noqa: BLE001 - a text out of a file may say anything
        raise LoadError(
            f"recipe: expected a line that makes a scene, got {shown(recipe)} ({reason_of(error)})"
        ) from None
    if not isinstance(made, Scene):
        raise LoadError(f"recipe: expected a line that makes a scene, got {shown(recipe)}; give the scene itself")
    return made


def _made(node: ast.expr) -> Any:
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _made(left) + _made(right)
        case ast.Call(func=func, args=args, keywords=keywords):
            given = [_made(one) if isinstance(one, ast.Call) else ast.literal_eval(one) for one in args]
            named = {
                str(one.arg): _made(one.value) if isinstance(one.value, ast.Call) else ast.literal_eval(one.value)
                for one in keywords
            }
            if (name := ast.unparse(func)) in MAKERS:
                return MAKERS[name](*given, **named)
            if isinstance(func, ast.Attribute) and func.attr in MOVES and isinstance(of := _made(func.value), Scene):
                return getattr(of, func.attr)(*given, **named)
    raise LoadError("recipe: expected sl.library.scene, sl.load_scene, sums and moves of scenes; give the scene itself")
