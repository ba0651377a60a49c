"""Materials of a glTF document, as far as they let light through: alpha tests (glTF 2.0, "Alpha Coverage")."""

from __future__ import annotations

import io
import math
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import LoadError
from ..alpha_test import CUTOFF, WRAP_OF, AlphaTest, Wrap, alpha_of_image
from ..formats.limits import check_limit
from .accessors import Accessors
from .extensions import AVIF, SPECULAR_GLOSSINESS, TEXTURE_TRANSFORM, WEBP
from .items import JsonObject
from .primitives import Primitive

OPAQUE_ALPHA = 255
# Of a texture whose alpha is its coordinate: an exact table of the 8 bits that a texel has.
RAMP = np.arange(256, dtype=np.uint8)[None, :]


class Discarded:
    """Of a primitive whose material discards all of it."""


@dataclass(eq=False)
class Materials:
    """The materials of a document: what is decoded is kept, and names are collected for warnings."""

    accessors: Accessors
    #: Names of materials whose blending is not done.
    blended: dict[str, None] = field(default_factory=dict)
    _alpha: dict[int, NDArray[np.uint8] | str] = field(default_factory=dict)
    _ranges: dict[int, tuple[float, float]] = field(default_factory=dict)

    def alpha_test(self, primitive: Primitive) -> AlphaTest | type[Discarded] | None:
        """The alpha test of a primitive: None where all of it is opaque, `Discarded` where none of it is there.

        Raises
        ------
        LoadError
            For a material that cannot be read. Images that cannot be are named in a warning.
        """
        materials = self.accessors.document.materials
        if "material" not in primitive.item.value:
            return None
        item = materials[primitive.item.index("material", len(materials), "materials")]
        mode = item.text("alphaMode", "OPAQUE")
        if mode not in ("OPAQUE", "MASK", "BLEND"):
            raise item.wrong("alphaMode", "OPAQUE, MASK or BLEND")
        label = item.name or item.where
        if mode == "BLEND":
            self.blended[label] = None
        if mode != "MASK":
            return None
        return self._masked(item, label, primitive)

    def _masked(self, item: JsonObject, label: str, primitive: Primitive) -> AlphaTest | type[Discarded] | None:
        cutoff = item.number("alphaCutoff", CUTOFF)
        color, info = base_of(item)
        factor = 1.0 if color is None else float(color[3])
        vertex_alpha = self._vertex_alpha(primitive)
        if vertex_alpha is not None and len(vertex_alpha) and (vertex_alpha == vertex_alpha[0]).all():
            factor, vertex_alpha = factor * float(vertex_alpha[0]), None
        texture = None if info is None else self._texture(info)
        if isinstance(texture, str):
            self.accessors.document.notes.append(f"the texture of material {label} is not read ({texture})")
            texture = None
        lowest, highest = (1.0, 1.0) if texture is None else self._range(texture)
        if lowest == 1.0:
            texture = None
        if vertex_alpha is not None and len(vertex_alpha):
            lowest, highest = lowest * float(vertex_alpha.min()), highest * float(vertex_alpha.max())
        if highest * factor < cutoff:
            return Discarded
        if lowest * factor >= cutoff:
            return None
        if texture is None:
            assert vertex_alpha is not None
            # Linear between vertices, as the colours are: alpha is the coordinate, from the middle of the first texel.
            u = (np.clip(vertex_alpha, 0, 1) * 255 + 0.5) / 256
            uv = np.column_stack([u, np.full(len(u), 0.5)]).astype(np.float32)
            return AlphaTest(RAMP, uv, cutoff, ("clamp", "clamp"), factor)
        assert info is not None
        if vertex_alpha is not None:
            self.accessors.document.notes.append(f"material {label} is taken without the alpha of its vertices")
        # Every use of a texture is compared with those that there are.
        self.accessors.document.expand(texture.size)
        return AlphaTest(texture, self._coordinates(info, primitive), cutoff, self._wraps(info), factor)

    def _vertex_alpha(self, primitive: Primitive) -> NDArray[Any] | None:
        raw = primitive.raw_attribute("COLOR_0", self.accessors, "VEC3", "VEC4")
        if raw is None or raw[0].shape[1] < 4:
            return None
        colors = primitive.attribute("COLOR_0", self.accessors, "VEC3", "VEC4")
        return None if colors is None else np.nan_to_num(colors[:, 3].astype(np.float64), nan=1.0)

    def _texture(self, info: JsonObject) -> NDArray[np.uint8] | str:
        """The alpha (H, W) of a texture, or why it is not read."""
        textures, images = self.accessors.document.textures, self.accessors.document.images
        texture = textures[info.index("index", len(textures), "textures")]
        holder = texture if "source" in texture.value else texture.extension(WEBP, AVIF)
        if holder is None or "source" not in holder.value:
            return "its image is of a format that is not read"
        index = holder.index("source", len(images), "images")
        if index not in self._alpha:
            self._alpha[index] = self._decoded(images[index])
        return self._alpha[index]

    def _range(self, texture: NDArray[np.uint8]) -> tuple[float, float]:
        """The lowest and highest alpha of a texture that is kept."""
        if id(texture) not in self._ranges:
            self._ranges[id(texture)] = float(texture.min()) / OPAQUE_ALPHA, float(texture.max()) / OPAQUE_ALPHA
        return self._ranges[id(texture)]

    def _decoded(self, image: JsonObject) -> NDArray[np.uint8] | str:
        document, buffers = self.accessors.document, self.accessors.buffers
        try:
            if "uri" in image.value:
                data = buffers.at_uri(image)
            else:
                data = bytes(buffers.view(image.index("bufferView", len(document.views), "buffer views")).data)
        except LoadError as e:
            return str(e)
        from PIL import Image

        try:
            with warnings.catch_warnings():
                # Its size is held against our own limits.
                warnings.simplefilter("ignore")
                picture = Image.open(io.BytesIO(data))
                width, height = picture.size
                check_limit(document.given.limits, image.file, "elements", width * height, f"pixels in {image.where}")
                document.expand(4 * width * height)
                alpha = alpha_of_image(picture)
                return np.full((1, 1), OPAQUE_ALPHA, np.uint8) if alpha is None else alpha
        except (LoadError, MemoryError):
            raise
        except Exception as e:  # noqa: BLE001 - each of pillow's decoders raises what its parser raises
            return f"{type(e).__name__}: {e}"

    def _coordinates(self, info: JsonObject, primitive: Primitive) -> NDArray[np.float32]:
        transform = info.extension(TEXTURE_TRANSFORM)
        holder = transform if transform is not None and "texCoord" in transform.value else info
        name = f"TEXCOORD_{holder.whole('texCoord', 0)}"
        found = primitive.attribute(name, self.accessors, "VEC2")
        if found is None:
            raise primitive.item.broken(f"attributes: expected {name}, which its material's texture takes, found none")
        uv = found.astype(np.float64)
        if transform is not None:
            scale, offset = transform.numbers("scale", 2), transform.numbers("offset", 2)
            turn = transform.number("rotation", 0.0)
            uv = uv if scale is None else uv * scale
            c, s = math.cos(turn), math.sin(turn)
            uv = uv @ np.array([[c, -s], [s, c]]) + (0.0 if offset is None else offset)
        return uv.astype(np.float32)

    def _wraps(self, info: JsonObject) -> tuple[Wrap, Wrap]:
        texture = self.accessors.document.textures[info.whole("index")]
        samplers = self.accessors.document.samplers
        if "sampler" not in texture.value:
            return "repeat", "repeat"
        sampler = samplers[texture.index("sampler", len(samplers), "samplers")]
        found = []
        for key in ("wrapS", "wrapT"):
            wrap = WRAP_OF.get(sampler.whole(key, 10497))
            if wrap is None:
                raise sampler.wrong(key, " or ".join(f"{number} ({name})" for number, name in WRAP_OF.items()))
            found.append(wrap)
        return found[0], found[1]


def base_of(material: JsonObject) -> tuple[NDArray[np.float64] | None, JsonObject | None]:
    """The factor (4,) of a material's colour and the reference to its texture, each None where there is none."""
    older = material.extension(SPECULAR_GLOSSINESS)
    if older is not None:
        return older.numbers("diffuseFactor", 4), older.item("diffuseTexture")
    base = material.item("pbrMetallicRoughness")
    return (None, None) if base is None else (base.numbers("baseColorFactor", 4), base.item("baseColorTexture"))
