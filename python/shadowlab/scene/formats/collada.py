"""COLLADA: nodes of a visual scene with their meshes, the up axis and the unit.

Source: Barnes and Finch, "COLLADA - Digital Asset Schema Release 1.5.0", Khronos, 2008; 1.4 has the same elements.
Materials, cameras, lights and animations are not read. Skins and morphs are taken at rest.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from ...errors import LoadError
from ..gathered import Gathered
from .collada_mesh import ColladaMeshes, referred
from .collada_transforms import node_matrix
from .given import Given
from .parts import Part, place_parts
from .xml import child, children, floats, local, parsed_xml

_UP = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


def read_collada(given: Given) -> Gathered:
    """The meshes of a COLLADA file, shared where nodes share them.

    Raises
    ------
    LoadError
        For what is no COLLADA, for references that lead nowhere, and for nodes that contain themselves.
    """
    root = parsed_xml(given.name, given.data, given.limits)
    if local(root) != "COLLADA":
        raise LoadError(f"{given.name}: expected a COLLADA document, got <{local(root)}>; check the file")
    return _Document(given, root).gathered()


class _Document:
    """A document with its elements by id."""

    def __init__(self, given: Given, root: Any):
        self.given, self.root = given, root
        self.by_id: dict[str, Any] = {}
        for element in root.iter():
            identity = element.get("id")
            if identity is not None:
                self.by_id.setdefault(identity, element)
        self.found = Gathered()
        self.meshes = ColladaMeshes(given, self.by_id, self.found)
        self.parts: dict[Hashable, Part] = {}

    def gathered(self) -> Gathered:
        self._asset()
        nodes = self._nodes()
        roots = [(self._part(node), node_matrix(self.given.name, node)) for node in nodes]
        if nodes:
            place_parts(self.given, self.found, self.parts, roots)
        else:
            for geometry in self.root.iter("{*}geometry"):
                for key in self.meshes.keys_of(geometry):
                    self.found.place(key, np.eye(4))
            self.found.notes.append("the file has no visual scene: every geometry is placed once, where it is")
        return self.found

    def _asset(self) -> None:
        asset = child(self.root, "asset")
        if asset is None:
            return
        if (up := child(asset, "up_axis")) is not None:
            word = (up.text or "").strip()
            if word not in _UP:
                raise LoadError(f"{self.given.name}: expected up_axis X_UP, Y_UP or Z_UP, got {word!r}; check the file")
            self.found.up = _UP[word]
        unit = child(asset, "unit")
        if unit is not None and unit.get("meter") is not None:
            self.found.unit = float(floats(self.given.name, unit.get("meter"), "metres of its unit", 1)[0])

    def _nodes(self) -> list[Any]:
        """The nodes at the top of the scene."""
        scenes = [*self.root.iter("{*}visual_scene")]
        instance = next(self.root.iter("{*}instance_visual_scene"), None)
        chosen = scenes[:1]
        if instance is not None:
            named = self._referred(instance)
            if named is None or local(named) != "visual_scene":
                raise LoadError(
                    f"{self.given.name}: expected the scene {instance.get('url')!r}, found none; check the file"
                )
            chosen = [named]
        return [node for scene in chosen for node in children(scene, "node")]

    def _part(self, top: Any) -> Hashable:
        """The key of a node as a part; it and all that it refers to become parts."""
        stack = [top]
        while stack:
            node = stack.pop()
            if node in self.parts:
                continue
            part = self.parts[node] = Part()
            for one in node:
                kind = local(one)
                if kind == "node":
                    part.parts.append((one, node_matrix(self.given.name, one)))
                    stack.append(one)
                elif kind == "instance_node":
                    if (other := self._referred(one)) is not None and local(other) == "node":
                        part.parts.append((other, node_matrix(self.given.name, other)))
                        stack.append(other)
                elif kind == "instance_geometry":
                    if (geometry := self._referred(one)) is not None and local(geometry) == "geometry":
                        part.meshes += self.meshes.keys_of(geometry)
                elif kind == "instance_controller" and (controller := self._referred(one)) is not None:
                    self._at_rest(part, controller)
        return top  # type: ignore[no-any-return]

    def _at_rest(self, part: Part, controller: Any) -> None:
        """Adds the mesh of a skin or of a morph as it is without joints and weights."""
        matrix = np.eye(4)
        seen: set[Any] = set()
        while local(controller) == "controller" and controller not in seen:
            seen.add(controller)
            kind = next(iter(children(controller, "skin", "morph")), None)
            if kind is None:
                return
            bind = child(kind, "bind_shape_matrix")
            if bind is not None:
                matrix = matrix @ floats(self.given.name, bind.text, "bind_shape_matrix", 16).reshape(4, 4)
            other = self._referred(kind, "source")
            if other is None:
                return
            controller = other
        note = "skins and morphs are taken at rest"
        if note not in self.found.notes:
            self.found.notes.append(note)
        if local(controller) == "geometry":
            key = (controller, "at rest", len(self.parts))
            self.parts[key] = Part(list(self.meshes.keys_of(controller)))
            part.parts.append((key, matrix))

    def _referred(self, element: Any, attribute: str = "url") -> Any:
        """The element that another refers to; None, and a word of it, where that is in another file or missing."""
        reference = element.get(attribute, "")
        found = referred(self.by_id, reference) if reference.startswith("#") else None
        if found is None:
            self.found.left_out.append(f"{local(element)} of {reference[:80]!r}, which is not in the file")
        return found
