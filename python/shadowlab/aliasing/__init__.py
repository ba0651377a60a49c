"""Errors as numbers: the size of texels in the image, where mask and truth disagree, what closed forms say."""

from .._core import Misclassified, misclassified
from . import closed_form
from .beam_texels import BeamTexels, beam_texels
from .footprints import Footprint, footprint, footprint_at, halfway_normals
from .frustum_body import frustum_scene, outline
from .light_angles import LightAngles, light_at_angle, over_light_angle
from .light_angles_of_frustum import frustum_over_light_angle
from .paths import Temporal, temporal
from .summary import Summary
from .texels import Usage, look_up, texel_coordinates, usage
from .wrong_pixels import Causes, causes

__all__ = [
    "BeamTexels",
    "Causes",
    "Footprint",
    "LightAngles",
    "Misclassified",
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
    "temporal",
    "texel_coordinates",
    "usage",
]
