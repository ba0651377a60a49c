"""Views compressed by EXT_meshopt_compression and KHR_meshopt_compression.

The streams are decoded by the package meshoptimizer; the filters (appendix B of both extensions) follow here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .items import JsonObject

ATTRIBUTES, TRIANGLE_LISTS, INDICES = "ATTRIBUTES", "TRIANGLES", "INDICES"
MESHOPT_FILTERS = ("NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR")
MOST_STRIDE = 256


def decoded_view(packed: JsonObject, data: bytes, count: int, stride: int) -> bytes:
    """The bytes of a compressed view.

    Parameters
    ----------
    packed : JsonObject
        The extension's object: mode and filter.
    data : bytes
        The stream.
    count, stride : int
        Elements, and bytes of each.

    Raises
    ------
    LoadError
        For settings that the extension forbids, or a broken stream.
    """
    mode, after = packed.text("mode"), packed.text("filter", "NONE")
    if mode not in (ATTRIBUTES, TRIANGLE_LISTS, INDICES):
        raise packed.wrong("mode", f"{ATTRIBUTES}, {TRIANGLE_LISTS} or {INDICES}")
    if after not in MESHOPT_FILTERS or (after != "NONE" and mode != ATTRIBUTES):
        raise packed.wrong("filter", f"one of {', '.join(MESHOPT_FILTERS)}, and NONE but for {ATTRIBUTES}")
    strides: tuple[int, ...] = (2, 4)
    if mode == ATTRIBUTES:
        narrow = {"OCTAHEDRAL": (4, 8), "COLOR": (4, 8), "QUATERNION": (8,)}
        strides = narrow.get(after, tuple(range(4, MOST_STRIDE + 1, 4)))
    if stride not in strides:
        few = " or ".join(map(str, strides)) if len(strides) < 3 else f"a multiple of 4 up to {MOST_STRIDE}"
        raise packed.wrong("byteStride", few)
    if mode == TRIANGLE_LISTS and count % 3:
        raise packed.wrong("count", "a multiple of 3")
    if count == 0:
        return b""
    raw = stream(packed, mode, data, count, stride)
    return raw.tobytes() if after == "NONE" else filtered(after, raw, count, stride).tobytes()


def stream(packed: JsonObject, mode: str, data: bytes, count: int, stride: int) -> NDArray[np.uint8]:
    """The bytes before filtering."""
    import meshoptimizer

    try:
        if mode == ATTRIBUTES:
            decoded = meshoptimizer.decode_vertex_buffer(count, stride, data, dtype=np.dtype((np.void, stride)))
        else:
            decode = (
                meshoptimizer.decode_index_buffer if mode == TRIANGLE_LISTS else meshoptimizer.decode_index_sequence
            )
            # 32 bits per index, whatever the view keeps of them.
            decoded = decode(count, 4, data).astype(np.uint16 if stride == 2 else np.uint32)
    except (RuntimeError, ValueError) as e:
        raise packed.broken(f"expected a stream of meshoptimizer, could not decode it ({e})") from e
    found: NDArray[np.uint8] = np.ascontiguousarray(decoded).view(np.uint8)
    return found


def filtered(filter: str, raw: NDArray[np.uint8], count: int, stride: int) -> NDArray[np.generic]:
    """What a filter makes of the elements of a stream, in the bytes of the view."""
    if filter == "EXPONENTIAL":
        words = raw.view("<i4")
        mantissa = (words << 8) >> 8
        with np.errstate(over="ignore", under="ignore"):
            exponential: NDArray[np.generic] = np.ldexp(mantissa.astype(np.float64), words >> 24).astype("<f4")
        return exponential
    signed = filter != "COLOR"
    kind = {(True, 4): "<i1", (True, 8): "<i2", (False, 4): "<u1", (False, 8): "<u2"}[signed, stride]
    given = raw.view(kind).reshape(count, 4)
    most = float(np.iinfo(kind).max)
    made = {"OCTAHEDRAL": octahedral, "QUATERNION": quaternion, "COLOR": color}[filter](given, most)
    rounded: NDArray[np.generic] = np.clip(np.copysign(np.floor(np.abs(made) + 0.5), made), -most, most).astype(kind)
    return rounded


def octahedral(given: NDArray[np.integer], most: float) -> NDArray[np.float64]:
    """Unit vectors from octahedral coordinates relative to the third component; the fourth stays."""
    v = given.astype(np.float64)
    one = np.where(v[:, 2] == 0, 1.0, v[:, 2])
    x, y = v[:, 0] / one, v[:, 1] / one
    z = 1.0 - np.abs(x) - np.abs(y)
    t = np.minimum(z, 0.0)
    x, y = x - np.copysign(t, x), y - np.copysign(t, y)
    length = np.sqrt(x * x + y * y + z * z)
    return np.column_stack([most * x / length, most * y / length, most * z / length, v[:, 3]])


def quaternion(given: NDArray[np.integer], most: float) -> NDArray[np.float64]:
    """Unit quaternions from three components and, in the last two bits, which the fourth is."""
    last = given[:, 3].astype(np.int64)
    three = given[:, :3] / (last | 3)[:, None] / np.sqrt(2.0)
    w = np.sqrt(np.maximum(0.0, 1.0 - (three * three).sum(axis=1)))
    made, rows = np.empty((len(given), 4)), np.arange(len(given))
    for i in range(3):
        made[rows, ((last & 3) + 1 + i) % 4] = most * three[:, i]
    made[rows, last & 3] = most * w
    return made


def color(given: NDArray[np.integer], most: float) -> NDArray[np.float64]:
    """Colours and alpha from luma and two differences, scaled by the highest bit of the fourth component."""
    luma, alpha = given[:, 0].astype(np.int64), given[:, 3].astype(np.int64)
    half = int(most + 1) // 2
    first, second = ((given[:, i].astype(np.int64) + half) % (2 * half) - half for i in (1, 2))
    bits = alpha.copy()
    for shift in (1, 2, 4, 8):
        bits |= bits >> shift
    alpha = ((alpha << 1) & bits) | (alpha & 1)
    scale = most / np.maximum(bits, 1)
    columns = (luma + first - second, luma + second, luma - first - second, alpha)
    return np.column_stack([np.clip(column * scale, 0, most) for column in columns])
