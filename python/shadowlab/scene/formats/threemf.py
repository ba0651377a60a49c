"""3MF: the items of a build with their objects and components, and the unit.

Source: 3MF Consortium, "3MF Core Specification" 1.3 and "Production Extension" 1.1, whose `path` names parts in
other model files of the package.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..gathered import Gathered
from .archives import Archive
from .given import Given
from .parts import Part, place_parts
from .units import METRES
from .words import plain_numbers
from .xml import child, children, floats, local, parsed_xml

_MODEL = "3d/3dmodel.model"
_RELATIONSHIPS = "_rels/.rels"
_MODEL_TYPE = "/3dmodel"
#: Extensions, by their namespaces, that are read, change no geometry, or whose elements are named as left out.
_EXTENSIONS = (
    "production", "material", "slice", "trianglesets", "beamlattice", "booleanoperations", "displacement", "volumetric",
    "implicit",
)  # fmt: skip
#: What an object and its mesh may hold without anything being left out.
_CONTENT = ("mesh", "components", "metadatagroup")
_OF_MESH = ("vertices", "triangles", "trianglesets")


def read_3mf(given: Given) -> Gathered:
    """The objects of a 3MF file where its build places them.

    Raises
    ------
    LoadError
        For a package without a model, an object that is missing or contains itself, and an unknown unit.
    """
    return _Package(given).gathered()


def _others(element: Any, known: tuple[str, ...]) -> list[str]:
    """The names of the elements directly in another that are none of these."""
    return [name for name in dict.fromkeys(map(local, element)) if name not in known]


class _Package:
    """A package: its models by path, and their objects as parts."""

    def __init__(self, given: Given):
        self.given = given
        self.archive = Archive.of(given, "zip")
        self.paths = {path.lower(): path for path in self.archive.names}
        self.found = Gathered()
        self.parts: dict[Hashable, Part] = {}
        self.read: set[str] = set()

    def gathered(self) -> Gathered:
        main = self._main()
        root = self._model(main)
        unit = root.get("unit", "millimeter")
        if unit not in METRES:
            listed = "micron, millimeter, centimeter, inch, foot, meter"
            raise LoadError(f"{self.given.name}: expected the unit {listed}, got {unit!r}; check the file")
        self.found.unit = METRES[unit]
        roots = []
        unprinted = 0
        for build in children(root, "build"):
            for item in children(build, "item"):
                if item.get("printable", "1").strip().lower() in ("0", "false"):
                    unprinted += 1
                else:
                    roots.append((self._object(main, item), self._transform(item)))
        if unprinted:
            self.found.left_out.append(f"{unprinted:,} item{'s' if unprinted > 1 else ''} not to be printed")
        place_parts(self.given, self.found, self.parts, roots)
        return self.found

    def _main(self) -> str:
        """The path of the model that the package begins with."""
        relationships = self.paths.get(_RELATIONSHIPS)
        if relationships is not None:
            for one in parsed_xml(self.given.name, self.archive.read(relationships), self.given.limits):
                target = one.get("Target", "").lstrip("/").lower()
                if one.get("Type", "").endswith(_MODEL_TYPE) and target in self.paths:
                    return self.paths[target]
        found = next((path for lower, path in self.paths.items() if lower.endswith(_MODEL)), None)
        if found is None:
            raise LoadError(f"{self.given.name}: expected a 3MF package with a 3D model, found none; check the file")
        return found

    def _model(self, path: str) -> Any:
        """The root of a model; its objects become parts."""
        root = parsed_xml(f"{self.given.name}/{path}", self.archive.read(path), self.given.limits)
        if local(root) != "model":
            raise LoadError(f"{self.given.name}: expected a 3MF model, got <{local(root)}>; check the file")
        self.read.add(path)
        self._check_extensions(root)
        # First all keys, since objects may come in any order.
        objects = [one for resources in children(root, "resources") for one in children(resources, "object")]
        for one in objects:
            if (path, one.get("id")) in self.parts:
                raise LoadError(
                    f"{self.given.name}: expected objects with different ids, got {one.get('id')!r} twice in {path}; "
                    "check the file"
                )
            self.parts[path, one.get("id")] = Part()
        for one in objects:
            key = path, one.get("id")
            part = self.parts[key]
            if (mesh := child(one, "mesh")) is not None:
                name = one.get("name") or f"object {one.get('id')}"
                vertices, triangles = self._mesh(mesh, name)
                if len(triangles):
                    self.found.add(key, name, vertices, triangles)
                    part.meshes.append(key)
                else:
                    self.found.empty.append(f"{name} (no triangle)")
            if others := _others(one, _CONTENT) + ([] if mesh is None else _others(mesh, _OF_MESH)):
                name = one.get("name") or f"object {one.get('id')}"
                self.found.left_out.append(f"{', '.join(others)} of {name}")
            for components in children(one, "components"):
                for component in children(components, "component"):
                    part.parts.append((self._object(path, component), self._transform(component)))
        return root

    def _check_extensions(self, root: Any) -> None:
        """Raises for an extension that the model requires and that is neither read nor named where it is left out."""
        for prefix in root.get("requiredextensions", "").split():
            namespace = root.nsmap.get(prefix, prefix)
            if not any(f"/{name}/" in namespace for name in _EXTENSIONS):
                raise LoadError(
                    f"{self.given.name}: expected required extensions that are read here ({', '.join(_EXTENSIONS)}), "
                    f"got {namespace}; export the file without"
                )

    def _object(self, path: str, reference: Any) -> Hashable:
        """The key of the object that an item or a component names."""
        other = next((value for name, value in reference.attrib.items() if name.endswith("}path")), None)
        if other is not None:
            known = self.paths.get(other.lstrip("/").lower())
            if known is None:
                raise LoadError(f"{self.given.name}: expected {other!r} in the package, found none; check the file")
            path = known
            if path not in self.read:
                self._model(path)
        key = path, reference.get("objectid")
        if key not in self.parts:
            raise LoadError(f"{self.given.name}: expected the object {key[1]!r} in {path}, found none; check the file")
        return key

    def _transform(self, reference: Any) -> NDArray[np.float64]:
        made = np.eye(4)
        text = reference.get("transform")
        if text is not None:
            made[:3] = floats(self.given.name, text, "a transform", 12).reshape(4, 3).T
        return made

    def _mesh(self, mesh: Any, name: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        vertices, triangles = child(mesh, "vertices"), child(mesh, "triangles")
        points = self._numbers(vertices, "vertex", ("x", "y", "z"), np.float64, f"the vertices of {name}")
        faces = self._numbers(triangles, "triangle", ("v1", "v2", "v3"), np.int64, f"the triangles of {name}")
        if len(faces) and (faces.min() < 0 or faces.max() >= len(points)):
            wrong = int(faces[(faces < 0) | (faces >= len(points))][0])
            raise LoadError(
                f"{self.given.name}: expected vertices from 0 to {len(points) - 1:,} in {name}, got {wrong}; "
                "check the file"
            )
        a, b, c = faces.T
        distinct = (a != b) & (b != c) & (c != a)
        self.found.degenerate += int(len(faces) - distinct.sum())
        return points, faces[distinct]

    def _numbers(self, of: Any, tag: str, names: tuple[str, str, str], dtype: Any, what: str) -> NDArray[Any]:
        """Three attributes of every element of a tag, as rows."""
        x, y, z = names
        rows = () if of is None else of.iterchildren(f"{{*}}{tag}")
        texts = [f"{row.get(x)} {row.get(y)} {row.get(z)}" for row in rows]
        values = plain_numbers(" ".join(texts).encode(), dtype)
        if len(values) != 3 * len(texts):
            raise LoadError(f"{self.given.name}: expected {', '.join(names)} as numbers for {what}; check the file")
        return values.reshape(-1, 3)
