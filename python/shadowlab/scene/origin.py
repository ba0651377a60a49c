"""What is known of a scene that is not there: where it came from, what it was, and how it is made again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError, LoadError, ShadowlabError
from ..text.checked import A_SCENE
from ..travel import Value
from .recipe import scene_of_recipe
from .source import Source


@dataclass(frozen=True, eq=False)
class SceneOrigin(Value):
    """A scene by its content and its recipe.

    Attributes
    ----------
    name : str
        As tables call it.
    recipe : str
        The line of Python that makes it; "" of a scene of arrays.
    content_hash : str
        As of `Scene.content_hash`.
    box : tuple of float
        Its bounds: x, y and z of the lower corner, then of the upper.
    """

    name: str
    recipe: str
    content_hash: str
    box: tuple[float, ...]

    @classmethod
    def of_scene(cls, scene: _core.Scene) -> SceneOrigin:
        """What is known of a scene that is there."""
        box = tuple(np.asarray(scene.bounds, np.float64).ravel().tolist())
        return cls(Source.of_scene(scene).name, getattr(scene, "recipe", ""), scene.content_hash, box)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The corners of its box (2, 3), as of `Scene.bounds`."""
        return np.array(self.box, np.float64).reshape(2, 3)

    @cached_property
    def scene(self) -> _core.Scene:
        """The scene, made by its recipe at the first use; one for all views of it.

        Raises
        ------
        LoadError
            Where there is no recipe, it fails, or it makes another scene than this.
        """
        fix = "load it with scene=..., the scene itself"
        if not self.recipe:
            raise LoadError(f"scene: expected a scene of a file or of the library, but {self.name!r} was arrays; {fix}")
        try:
            made = scene_of_recipe(self.recipe)
        except ShadowlabError as error:
            raise LoadError(f"scene: cannot make {self.name!r} again ({error}); {fix}") from None
        if made.content_hash != self.content_hash:
            raise LoadError(f"scene: {self.name!r} has changed since: its content is another; {fix}")
        return made

    def take(self, scene: object) -> None:
        """Takes a scene for this one, in place of one that is made.

        Raises
        ------
        ArgumentError
            For something else, and a scene of another content.
        """
        A_SCENE("scene", scene)
        if getattr(scene, "content_hash", "") != self.content_hash:
            raise ArgumentError(
                f"scene: expected the scene {self.name!r} as it was, got one of another content; make it as then"
            )
        self.__dict__["scene"] = scene
