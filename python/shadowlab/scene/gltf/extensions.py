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
#: By how their names begin, and by name.
NO_SHADOW_FAMILIES = (
    "KHR_materials_", "KHR_texture_", "MSFT_texture_", "MSFT_packing_", "ADOBE_materials_", "NV_materials_", "KHR_xmp",
    "KHR_audio", "OMI_audio", "KHR_animation", "KHR_interactivity", "KHR_physics_", "OMI_physics_", "MSFT_physics_",
    "KHR_character", "KHR_avatar", "VRM", "AGI_", "SEIN_",
)  # fmt: skip
NO_SHADOW = frozenset((
    "KHR_techniques_webgl", "KHR_node_selectability", "KHR_node_hoverability", "KHR_implicit_shapes",
    "KHR_collision_shapes", "KHR_data_sizes", "KHR_lights_environment", "KHR_lights_image_based",
    "EXT_lights_image_based",
    "EXT_lights_ies", "EXT_mesh_features", "EXT_instance_features", "EXT_structural_metadata", "EXT_feature_metadata",
    "EXT_mesh_manifold", "EXT_bmesh_encoding", "CESIUM_primitive_outline", "FB_geometry_metadata", "GODOT_single_root",
    "MPEG_texture_video", "MPEG_audio_spatial", "MSFT_audio_emitter", "MOZ_hubs_components", "GRIFFEL_bim_data",
))  # fmt: skip
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
    unknown = [name for name in required if not may_be_passed(name)]
    if unknown:
        raise LoadError(
            f"{top.file}: expected required extensions that are read here ({', '.join(sorted(READ))}, and all that "
            f"concern shading alone), got {', '.join(unknown)}; export the file without"
        )
    for name in required:
        if name in LIBRARIES and not found(LIBRARIES[name]):
            raise LoadError(f"{top.file}: expected a decoder of {name}, which the file requires, found none; {HOW}")
    return frozenset(required), [name for name in used if not may_be_passed(name)]


def may_be_passed(name: str) -> bool:
    """Whether an extension is read, or has nothing to say about shadows."""
    return name in READ or name in NO_SHADOW or name.startswith(NO_SHADOW_FAMILIES)


def names_of_extensions(top: JsonObject, key: str) -> list[str]:
    """The names in one of the document's two lists."""
    names = top.value.get(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise top.wrong(key, "a list of names")
    return list(dict.fromkeys(names))
