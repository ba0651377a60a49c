"""Formats that trimesh reads: its scene, with every error of its parsers as one of ours."""

from __future__ import annotations

import io
from typing import Any

from ...errors import LoadError, ShadowlabError
from .archives import Archive
from .given import Given
from .xml import parsed_xml

#: Formats that are XML, and those that are packages of XML.
_XML, _PACKAGES = ("xaml",), ("3dxml",)
#: Documents in packages.
_DOCUMENTS = (".xml", ".3dxml", ".3drep", ".rels")


def trimesh_formats() -> frozenset[str]:
    """The endings of meshes that trimesh reads here."""
    from trimesh.exchange.load import mesh_formats
    from trimesh.path.exchange.load import path_formats

    return frozenset(mesh_formats() | path_formats())


def trimesh_scene(given: Given) -> Any:
    """A `trimesh.Scene` of a file.

    Raises
    ------
    LoadError
        Whatever trimesh raises.
    """
    import trimesh

    if given.kind in _XML:
        parsed_xml(given.name, given.data, given.limits)
    if given.kind in _PACKAGES:
        archive = Archive.of(given, "zip")
        for name in archive.names:
            data = archive.read(name)
            if name.lower().endswith(_DOCUMENTS):
                parsed_xml(f"{given.name}/{name}", data, given.limits)
    try:
        # process=False: no merging, no reordering, so face numbers stay the file's.
        loaded = trimesh.load_scene(
            io.BytesIO(given.data), file_type=given.kind, resolver=_resolver(given), process=False
        )
        empty = not loaded.geometry
    except ShadowlabError:
        raise
    except Exception as e:  # each of trimesh's loaders raises what its own parser raises
        raise LoadError(
            f"{given.name}: expected a readable mesh, could not load it ({type(e).__name__}: {e}); check the file"
        ) from e
    if empty:
        raise LoadError(
            f"{given.name}: expected a readable mesh, could not load it (no geometry in it); check the file"
        )
    return loaded


def _resolver(given: Given) -> Any:
    from trimesh.resolvers import Resolver

    class Beside(Resolver):
        """Files beside the given one, and no others."""

        def __init__(self) -> None:
            pass

        def get(self, name: str) -> bytes:
            return given.beside(name)

        def write(self, name: str, data: Any) -> None:
            raise NotImplementedError

        def namespaced(self, namespace: str) -> Any:
            raise NotImplementedError

        def keys(self) -> list[str]:
            return []

    return Beside()
