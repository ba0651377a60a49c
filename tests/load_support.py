"""What tests of `load_scene` share: loading text, and areas of what was loaded."""

from __future__ import annotations

import io
import warnings
import zipfile

import numpy as np

import shadowlab as sl

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def loaded(text, kind, **options):
    """The scene of a text or of bytes; a warning is an error."""
    data = text if isinstance(text, bytes) else text.encode()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return sl.load_scene(data, kind=kind, **options)


def warned(text, kind, **options):
    """The scene, and what was warned of."""
    data = text if isinstance(text, bytes) else text.encode()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = sl.load_scene(data, kind=kind, **options)
    assert all(issubclass(one.category, sl.errors.ShadowlabWarning) for one in caught)
    return scene, " ".join(str(one.message) for one in caught)


def corners(scene):
    """(T, 3, 3) corners of the triangles of a scene."""
    vertices, faces = scene.to_arrays()
    return vertices[faces]


def area(scene):
    """The area of all triangles."""
    a, b, c = np.moveaxis(corners(scene), 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def zipped(files, compression=zipfile.ZIP_DEFLATED):
    """The bytes of a zip of files by name."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as packed:
        for name, content in files.items():
            packed.writestr(name, content)
    return stream.getvalue()
