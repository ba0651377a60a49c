"""Extensions of glTF: which are read, which change nothing that casts or receives a shadow, and which are refused.

A file lists what it uses (`extensionsUsed`), and of these what it cannot be read without (`extensionsRequired`).

| extension | required | used only |
| --- | --- | --- |
| read here (`READ`) | read | read |
| compression (`LIBRARIES`) | decoded, or refused without a decoder | data without compression, if there are any |
| about shading, names, sound (`NO_SHADOW`) | passed over | passed over |
| any other | refused | passed over with a warning |
"""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable

from ...errors import LoadError
from .items import JsonObject

DRACO = "KHR_draco_mesh_compression"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
VISIBILITY = "KHR_node_visibility"
INSTANCING = "EXT_mesh_gpu_instancing"
PUNCTUAL = "KHR_lights_punctual"
TEXTURE_TRANSFORM = "KHR_texture_transform"
SPECULAR_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
WEBP = "EXT_texture_webp"
AVIF = "EXT_texture_avif"

#: Extensions whose meaning for geometry, cameras and lights is implemented.
READ = frozenset(
    (DRACO, *MESHOPT, VISIBILITY, INSTANCING, PUNCTUAL, TEXTURE_TRANSFORM, "KHR_mesh_quantization", WEBP, AVIF)
)
#: The module that decodes each compression; the extra `compressed` brings both.
LIBRARIES = {DRACO: "DracoPy", **dict.fromkeys(MESHOPT, "meshoptimizer")}
#: Extensions that change neither geometry nor what light goes through: shading, textures, sound, behaviour, metadata.
NO_SHADOW = re.compile(
    r"KHR_materials_\w+|KHR_texture_\w+|MSFT_texture_\w+|MSFT_packing_\w+|ADOBE_materials_\w+|NV_materials_\w+"
    r"|KHR_techniques_webgl|KHR_xmp\w*|KHR_audio\w*|MSFT_audio_emitter|OMI_audio\w*|KHR_animation\w*|KHR_interactivity\w*"
    r"|KHR_node_selectability|KHR_node_hoverability|KHR_physics_\w+|OMI_physics_\w+|MSFT_physics_\w+|KHR_implicit_shapes"
    r"|KHR_collision_shapes|KHR_character\w*|KHR_avatar\w*|VRM\w*|EXT_lights_ies|EXT_lights_image_?[bB]ased"
    r"|KHR_lights_(environment|image_based|dome|photometric)|EXT_mesh_features|EXT_instance_features"
    r"|EXT_structural_metadata|EXT_feature_metadata|EXT_mesh_manifold|EXT_bmesh_encoding|CESIUM_primitive_outline"
    r"|AGI_\w+|FB_geometry_metadata|GODOT_single_root|MPEG_texture_video|MPEG_audio_spatial|MOZ_hubs_components"
    r"|GRIFFEL_bim_data|PTC_shaderball|SEIN_\w+|KHR_mesh_variants|KHR_data_sizes"
)
HOW = "pip install 'shadowlab[compressed]'"


def installed(module: str) -> bool:
    """Whether a decoder is installed."""
    return importlib.util.find_spec(module) is not None


def checked_extensions(top: JsonObject, found: Callable[[str], bool] = installed) -> tuple[frozenset[str], list[str]]:
    """The required extensions, and those that are used, not read and may be missed.

    Parameters
    ----------
    top : JsonObject
        The document.
    found : callable
        Whether a module is installed.

    Raises
    ------
    LoadError
        For a required extension that is not read, or whose decoder is missing.
    """
    required, used = (names_of_extensions(top, key) for key in ("extensionsRequired", "extensionsUsed"))
    unknown = [name for name in required if name not in READ and not NO_SHADOW.fullmatch(name)]
    if unknown:
        raise LoadError(
            f"{top.file}: expected required extensions that are read here ({', '.join(sorted(READ))}, and all that "
            f"concern shading alone), got {', '.join(unknown)}; export the file without"
        )
    for name in required:
        if name in LIBRARIES and not found(LIBRARIES[name]):
            raise LoadError(f"{top.file}: expected a decoder of {name}, which the file requires, found none; {HOW}")
    missed = [n for n in used if n not in READ and not NO_SHADOW.fullmatch(n)]
    return frozenset(required), missed


def names_of_extensions(top: JsonObject, key: str) -> list[str]:
    """The names in one of the document's two lists."""
    names = top.value.get(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise top.wrong(key, "a list of names")
    return list(dict.fromkeys(names))
