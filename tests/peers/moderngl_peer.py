"""Depth maps by OpenGL through moderngl: headless EGL, 32-bit float depth, any clip matrix.

Source: OpenGL 4.5 core, sections 13.5 (clipping, glClipControl) and 14.6 (polygons).

Orientation: OpenGL's window y points up, so row 0 of what is read is NDC y = -1; rows are flipped here, so that row 0
is NDC y = +1 as everywhere in shadowlab.

Depth range: with glClipControl(GL_ZERO_TO_ONE) the clip volume is 0 <= z <= w and depth is z / w, as in shadowlab.
Where a driver lacks it, z is doubled and shifted to -w..w and OpenGL shifts it back: the same volume, but depth is
then formed from numbers of magnitude 1, so it carries an absolute error near 2^-24 (6e-8) everywhere instead of a
relative one.
"""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np

from .compare import homogeneous

_GL_LOWER_LEFT = 0x8CA1
_GL_ZERO_TO_ONE = 0x935F
_GL_TEXTURE_2D = 0x0DE1
_GL_DEPTH_COMPONENT = 0x1902
_GL_DEPTH_COMPONENT32F = 0x8CAC
_GL_FLOAT = 0x1406

_VERTEX_SHADER = """
#version 330
uniform mat4 clip_from_model;
in vec4 position;
void main() { gl_Position = clip_from_model * position; }
"""
_FRAGMENT_SHADER = """
#version 330
void main() {}
"""


class ModernGL:
    """One context, one program; scenes and targets are kept until the next of another kind."""

    def __init__(self, zero_to_one: bool = True):
        self.context = moderngl.create_context(standalone=True, backend="egl")
        with self.context as context:
            self.renderer = context.info["GL_RENDERER"]
            self.subpixel_bits = int(context.info["GL_SUBPIXEL_BITS"])
            self.zero_to_one = zero_to_one and "GL_ARB_clip_control" in context.extensions
            if self.zero_to_one:
                self._call("glClipControl", _GL_LOWER_LEFT, _GL_ZERO_TO_ONE)
            self._program = context.program(vertex_shader=_VERTEX_SHADER, fragment_shader=_FRAGMENT_SHADER)
        self._target = None
        self._geometry = None

    def _call(self, name: str, *arguments: int) -> None:
        address = self.context.mglo._context.load_opengl_function(name)
        integers = [ctypes.c_int if a is not None else ctypes.c_void_p for a in arguments]
        ctypes.CFUNCTYPE(None, *integers)(address)(*arguments)

    def _depth_target(self, size: tuple[int, int]):
        if self._target is None or self._target[0].size != size:
            self._drop(self._target)
            texture = self.context.depth_texture(size)
            # moderngl allocates 24-bit integers; the same texture object is given float storage.
            self._call("glBindTexture", _GL_TEXTURE_2D, texture.glo)
            self._call(
                "glTexImage2D",
                _GL_TEXTURE_2D,
                0,
                _GL_DEPTH_COMPONENT32F,
                *size,
                0,
                _GL_DEPTH_COMPONENT,
                _GL_FLOAT,
                None,
            )
            self._target = (texture, self.context.framebuffer(depth_attachment=texture))
        return self._target

    def _drop(self, objects) -> None:
        for item in reversed(objects or ()):
            item.release()

    def upload(self, positions: np.ndarray, faces: np.ndarray) -> None:
        """Put (V, 3) or (V, 4) positions and (F, 3) faces on the device."""
        with self.context as context:
            self._drop(self._geometry)
            vertices = context.buffer(np.ascontiguousarray(positions, np.float32).tobytes())
            indices = context.buffer(np.ascontiguousarray(faces, np.uint32).tobytes())
            layout = [(vertices, f"{positions.shape[1]}f", "position")]
            array = context.vertex_array(self._program, layout, index_buffer=indices, index_element_size=4)
            self._geometry = (vertices, indices, array)

    def draw(self, clip_from_model: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """(H, W) float32 depth of what was uploaded; `size` is (width, height)."""
        return self._draw(self.of_opengl(clip_from_model), size)

    def of_opengl(self, clip_from_model: np.ndarray) -> np.ndarray:
        """A matrix with z in [0, w] as this context takes it."""
        matrix = np.asarray(clip_from_model, np.float64)
        return matrix if self.zero_to_one else _TO_SYMMETRIC_Z @ matrix

    def render(self, gl_clip_from_model: np.ndarray, size: tuple[int, int]) -> moderngl.Texture:
        """The depth texture of what was uploaded, kept on the device until the next one; row 0 is NDC y = -1."""
        with self.context as context:
            texture, framebuffer = self._depth_target(size)
            framebuffer.use()
            # enable_only(DEPTH_TEST): no culling, so both sides of each triangle are drawn.
            context.enable_only(moderngl.DEPTH_TEST)
            context.depth_func = "<"
            framebuffer.clear(depth=1.0)
            self._program["clip_from_model"].write(np.ascontiguousarray(gl_clip_from_model.T, np.float32).tobytes())
            self._geometry[2].render(moderngl.TRIANGLES)
        return texture

    def _draw(self, gl_clip_from_model: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        texture = self.render(gl_clip_from_model, size)
        with self.context:
            depth = np.frombuffer(texture.read(), np.float32).reshape(size[1], size[0])
        return np.ascontiguousarray(depth[::-1])

    def depth(self, vertices, faces, clip_from_world, size: tuple[int, int]) -> np.ndarray:
        """(H, W) float32 depth of (V, 3) world vertices under `clip_from_world` with z in [0, 1].

        Clip coordinates are formed in double precision and rounded once, so that the difference to another renderer is
        its arithmetic and the rasteriser's, not this shader's product.
        """
        clip = homogeneous(vertices) @ np.asarray(clip_from_world, np.float64).T
        if not self.zero_to_one:
            clip = clip @ _TO_SYMMETRIC_Z.T
        self.upload(clip, faces)
        return self._draw(np.eye(4), size)

    def release(self) -> None:
        """Give the context back."""
        with self.context:
            self._drop(self._geometry)
            self._drop(self._target)
        self.context.release()


_TO_SYMMETRIC_Z = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1]])


def moderngl_depth(vertices, faces, clip_matrix, size: tuple[int, int]) -> np.ndarray:
    """(H, W) float32 depth map from a context of its own; see :class:`ModernGL` to keep one."""
    peer = ModernGL()
    try:
        return peer.depth(vertices, faces, clip_matrix, size)
    finally:
        peer.release()
