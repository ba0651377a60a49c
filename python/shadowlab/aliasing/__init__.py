"""Errors as numbers: the size of texels in the image, where mask and truth disagree, what closed forms say."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._core import Misclassified, misclassified
from . import closed_form
from .beam_texels import BeamTexels, beam_texels
from .casters import Casters, CullRule
from .causes import Causes, causes
from .codes import Cause, Difference, NoTexel
from .footprint import Footprint, footprint, footprint_at, halfway_normals
from .frustum_body import outline
from .soft_error import SoftError, soft_error
from .summary import Summary
from .usage import Usage, look_up, texel_coordinates, usage

if TYPE_CHECKING:
    from ..experiments.frustum_scene import frustum_scene
    from ..experiments.light_angles import LightAngles, light_at_angle, over_light_angle
    from ..experiments.light_angles_of_frustum import frustum_over_light_angle
    from ..experiments.temporal import Temporal, temporal

__all__ = [
    "BeamTexels",
    "Casters",
    "Cause",
    "Causes",
    "CullRule",
    "Difference",
    "Footprint",
    "LightAngles",
    "Misclassified",
    "NoTexel",
    "SoftError",
    "Summary",
    "Temporal",
    "Usage",
    "beam_texels",
    "causes",
    "closed_form",
    "footprint",
    "footprint_at",
    "frustum_over_light_angle",
    "frustum_scene",
    "halfway_normals",
    "light_at_angle",
    "look_up",
    "misclassified",
    "outline",
    "over_light_angle",
    "soft_error",
    "temporal",
    "texel_coordinates",
    "usage",
]

#: Experiments over many maps, which stand here by name only: loaded at the first use.
_EXPERIMENTS = {
    "LightAngles": "light_angles",
    "Temporal": "temporal",
    "frustum_over_light_angle": "light_angles_of_frustum",
    "frustum_scene": "frustum_scene",
    "light_at_angle": "light_angles",
    "over_light_angle": "light_angles",
    "temporal": "temporal",
}


if not TYPE_CHECKING:  # a checker that saw this would take every misspelt name

    def __getattr__(name: str) -> object:
        if name not in _EXPERIMENTS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        value = getattr(import_module(f"..experiments.{_EXPERIMENTS[name]}", __name__), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
