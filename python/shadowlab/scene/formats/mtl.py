"""Materials of Wavefront OBJ files, as far as shadows depend on them: textures that say where a surface is.

Source: Wavefront, "MTL material format", version 4.2.
"""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..alpha_test import AlphaTest, Wrap, alpha_of_image
from ..gathered import Gathered
from .given import Given, OutsideError, inside
from .limits import check_limit
from .words import plain_text, without_comments

#: Options of texture maps by how many words follow; others have one.
_WORDS_AFTER = {b"-mm": 2, b"-o": 3, b"-s": 3, b"-t": 3}


@dataclass(frozen=True)
class AlphaTexture:
    """What `map_d` says of a material."""

    file: str
    clamped: bool


def library_of(given: Given, libraries: list[bytes], found: Gathered) -> dict[bytes | None, AlphaTexture]:
    """Materials with a texture of opacity, from the libraries that a file names; missing ones are passed over."""
    made: dict[bytes | None, AlphaTexture] = {}
    for library in libraries:
        text = _optional(given, library, found)
        names = [library] if text is not None else library.split()
        for name in names:
            text = _optional(given, name, found) if text is None or len(names) > 1 else text
            if text is not None:
                made.update(_materials(text))
    return made


def _optional(given: Given, name: bytes, found: Gathered) -> bytes | None:
    """A file beside the given one, if it is there; one outside the folder is told of and not read."""
    reference = name.decode("utf-8", "replace").strip()
    try:
        return given.find(inside(given.name, reference))
    except OutsideError:
        note = f"{reference!r} lies outside the folder and was not read"
        if note not in found.notes:
            found.notes.append(note)
        return None


def _materials(text: bytes) -> dict[bytes | None, AlphaTexture]:
    found: dict[bytes | None, AlphaTexture] = {}
    name: bytes | None = None
    for line in without_comments(plain_text(text)).split(b"\n"):
        word, *rest = line.split(None, 1)[:2] or (b"",)
        if word == b"newmtl":
            name = rest[0].strip() if rest else b""
        elif word.lower() == b"map_d" and rest:
            file, clamped = _map_file(rest[0])
            found[name] = AlphaTexture(file, clamped)
    return found


def _map_file(words: bytes) -> tuple[str, bool]:
    """The file after the options, and whether the texture is clamped."""
    rest, clamped = words.strip(), False
    while rest.startswith(b"-"):
        option, *others = rest.split(None, 1)
        rest = others[0] if others else b""
        for _ in range(_WORDS_AFTER.get(option, 1)):
            word, *others = rest.split(None, 1) or (b"",)
            if _WORDS_AFTER.get(option, 1) == 3 and not _is_number(word):
                break
            clamped |= option == b"-clamp" and word == b"on"
            rest = others[0] if others else b""
    return rest.decode("utf-8", "replace").strip(), clamped


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


class Opacities:
    """The textures that materials name, each read once."""

    def __init__(self, given: Given):
        self.given, self.texels = given, 0
        self.read: dict[str, NDArray[np.uint8] | None] = {}

    def of(self, file: str, found: Gathered) -> NDArray[np.uint8] | None:
        """The opacity in a file; None where it is missing or no image.

        Raises
        ------
        LoadError
            For more texels than the limits allow, those of a texture counted for each material that has it.
        """
        if file not in self.read:
            data = _optional(self.given, file.encode(), found)
            self.read[file] = None if data is None else _opacity(self.given, data)
        texture = self.read[file]
        self.texels += 0 if texture is None else texture.size
        check_limit(self.given.limits, self.given.name, "elements", self.texels, "texels of the textures of materials")
        return texture


def alpha_test_of(
    opacities: Opacities,
    material: AlphaTexture,
    label: str,
    coordinates: NDArray[np.float64],
    uv: NDArray[np.int64],
    found: Gathered,
) -> AlphaTest | None:
    """The alpha test of vertices with these rows of texture coordinates; None, with a note, where there is none.

    MTL has no cutoff: glTF's default is taken. `d` alone blends, and what is blended is opaque here.
    """
    texture = opacities.of(material.file, found)
    if texture is None or not len(uv) or uv.max() >= len(coordinates):
        why = "its faces have no texture coordinates" if texture is not None else f"{material.file!r} is not read"
        found.notes.append(f"alpha-tested material {label!r} is opaque here: {why}")
        return None
    rows = coordinates[uv]
    # OBJ counts v from the bottom row of a texture, and one coordinate alone is u.
    flipped = np.stack([rows[:, 0], 1 - rows[:, 1] if rows.shape[1] > 1 else np.ones(len(rows))], axis=1)
    wrap: Wrap = "clamp" if material.clamped else "repeat"
    return AlphaTest(texture, flipped.astype(np.float32), wrap=(wrap, wrap))


def _opacity(given: Given, data: bytes) -> NDArray[np.uint8] | None:
    """The alpha of an image, or its grey values where it has none; None for what is no image."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(io.BytesIO(data)) as image:
                check_limit(given.limits, given.name, "elements", image.width * image.height, "texels of a texture")
                alpha = alpha_of_image(image)
                return np.asarray(image.convert("L"), np.uint8) if alpha is None else alpha
        except LoadError:
            raise
        except Exception:  # noqa: BLE001 - each of Pillow's decoders raises what its own parser raises
            return None
