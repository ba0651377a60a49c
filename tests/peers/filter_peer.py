"""Filtered shadows by OpenGL through moderngl: the same map and the same kernel in GLSL.

Two programs share one text for the kernel. One reads positions from a texture, so that it answers for the points of a
G-buffer; the other draws the scene for an eye, as an engine would. Weights are those of theory.md (14.3), written anew.
"""

from __future__ import annotations

import moderngl
import numpy as np

MOST_POINTS = 256

_KERNEL = (
    f"#version 330\n#define MOST {MOST_POINTS}\n"
    + """
uniform sampler2D depths;
uniform bool is_upright;       // row 0 is NDC y = +1, else -1
uniform mat4 clip_from_point;
uniform vec3 to_light;
uniform float bias;            // NDC
uniform int kind;              // 0 nearest, 1 box, 2 points
uniform float width;           // of the box, texels
uniform int count;
uniform vec2 points[MOST];     // texels

float lit(ivec2 texel, float z) {
    ivec2 held = clamp(texel, ivec2(0), textureSize(depths, 0) - 1);
    if (!is_upright) held.y = textureSize(depths, 0).y - 1 - held.y;
    return texelFetch(depths, held, 0).r >= z ? 1.0 : 0.0;
}

float light(vec3 p, vec3 normal) {
    if (dot(normal, to_light) <= 0.0) return 0.0;
    vec4 clip = clip_from_point * vec4(p, 1.0);
    vec3 ndc = clip.xyz / clip.w;
    if (any(greaterThan(abs(ndc.xy), vec2(1.0)))) return 1.0;
    vec2 place = vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * vec2(textureSize(depths, 0));
    float z = clamp(ndc.z - bias, 0.0, 1.0);
    if (kind == 0) return lit(ivec2(floor(place)), z);
    float sum = 0.0;
    if (kind == 2) {
        for (int i = 0; i < count; i++) sum += lit(ivec2(floor(place + points[i])), z);
        return sum / float(count);
    }
    ivec2 first = ivec2(floor(place - 0.5 * width));
    int side = int(ceil(width)) + 1;
    for (int j = 0; j < side; j++) {
        for (int i = 0; i < side; i++) {
            vec2 low = max(vec2(first + ivec2(i, j)), place - 0.5 * width);
            vec2 high = min(vec2(first + ivec2(i, j) + 1), place + 0.5 * width);
            vec2 overlap = max(high - low, vec2(0.0)) / width;
            sum += overlap.x * overlap.y * lit(first + ivec2(i, j), z);
        }
    }
    return sum;
}
"""
)

_QUAD = """
#version 330
in vec2 position;
void main() { gl_Position = vec4(position, 0.0, 1.0); }
"""
_OF_TEXTURES = (
    _KERNEL
    + """
uniform sampler2D positions;
uniform sampler2D normals;
out float result;
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    result = light(texelFetch(positions, pixel, 0).xyz, texelFetch(normals, pixel, 0).xyz);
}
"""
)
_EYE = """
#version 330
uniform mat4 eye_clip_from_point;
in vec3 position;
out vec3 p;
void main() { p = position; gl_Position = eye_clip_from_point * vec4(position, 1.0); }
"""
_OF_SCENE = (
    _KERNEL
    + """
uniform vec3 eye;
in vec3 p;
out float result;
void main() {
    vec3 normal = normalize(cross(dFdx(p), dFdy(p)));
    result = light(p, dot(normal, eye - p) < 0.0 ? -normal : normal);
}
"""
)


class Filtered:
    """Masks of one G-buffer, or of one scene, through one map."""

    def __init__(self, peer, depths: np.ndarray, clip_from_point: np.ndarray, to_light, bias: float):
        self.peer, self.context = peer, peer.context
        self.map = (depths, clip_from_point, to_light, bias)
        with self.context as context:
            self.of_textures = context.program(vertex_shader=_QUAD, fragment_shader=_OF_TEXTURES)
            self.of_scene = context.program(vertex_shader=_EYE, fragment_shader=_OF_SCENE)
            self.depths = context.texture(depths.shape[::-1], 1, np.ascontiguousarray(depths).tobytes(), dtype="f4")
            corners = np.array([-1, -1, 3, -1, -1, 3], np.float32)
            self.quad = context.vertex_array(self.of_textures, [(context.buffer(corners.tobytes()), "2f", "position")])
            for program in (self.of_textures, self.of_scene):
                program["clip_from_point"].write(np.ascontiguousarray(clip_from_point.T, np.float32).tobytes())
                program["to_light"].value = tuple(float(x) for x in to_light)
                program["bias"].value = bias
                program["depths"].value = 0
            self.of_textures["is_upright"].value, self.of_scene["is_upright"].value = True, False

    def kernel(self, kind: int, width: float = 1.0, points: np.ndarray | None = None) -> None:
        """Sets the kernel: 0 nearest, 1 a box of a width, 2 points in texels."""
        padded = np.zeros((MOST_POINTS, 2), np.float32)
        if points is not None:
            padded[: len(points)] = points
        with self.context:
            for program in (self.of_textures, self.of_scene):
                program["kind"].value, program["width"].value = kind, width
                program["count"].value = 0 if points is None else len(points)
                program["points"].write(padded.tobytes())

    def surfaces(self, position: np.ndarray, normal: np.ndarray) -> None:
        """Puts (H, W, 3) positions and normals on the device."""
        height, width, _ = position.shape
        with self.context as context:
            images = (np.ascontiguousarray(image, np.float32).tobytes() for image in (position, normal))
            self.images = [context.texture((width, height), 3, image, dtype="f4") for image in images]
            self.target = context.framebuffer([context.texture((width, height), 1, dtype="f4")])
            self.of_textures["positions"].value, self.of_textures["normals"].value = 1, 2

    def mask(self) -> np.ndarray:
        """(H, W) float32 light at the surfaces that were put there."""
        with self.context as context:
            self.target.use()
            context.enable_only(moderngl.NOTHING)
            self.depths.use(0), self.images[0].use(1), self.images[1].use(2)
            self.quad.render(moderngl.TRIANGLES)
            return self._read(self.target)

    def scene(self, vertices: np.ndarray, faces: np.ndarray, eye_clip_from_point, eye, size: tuple[int, int]) -> None:
        """Puts a scene on the device, seen by an eye in a picture of (width, height) pixels."""
        with self.context as context:
            of = [(context.buffer(np.ascontiguousarray(vertices, np.float32).tobytes()), "3f", "position")]
            indices = context.buffer(np.ascontiguousarray(faces, np.uint32).tobytes())
            self.array = context.vertex_array(self.of_scene, of, index_buffer=indices, index_element_size=4)
            matrix = np.ascontiguousarray(np.asarray(eye_clip_from_point).T, np.float32)
            self.of_scene["eye_clip_from_point"].write(matrix.tobytes())
            self.of_scene["eye"].value = tuple(float(x) for x in eye)
            self.picture = context.framebuffer([context.texture(size, 1, dtype="f4")], context.depth_renderbuffer(size))

    def drawn(self) -> np.ndarray:
        """(H, W) float32: map and picture drawn, the light of the picture read; bottom row first."""
        depths, clip_from_point, _, _ = self.map
        drawn = self.peer.render(self.peer.of_opengl(clip_from_point), depths.shape[::-1])
        with self.context as context:
            self.picture.use()
            context.enable_only(moderngl.DEPTH_TEST)
            self.picture.clear(1.0, depth=1.0)
            drawn.compare_func = ""
            drawn.use(0)
            self.array.render(moderngl.TRIANGLES)
            return self._read(self.picture)

    def _read(self, target) -> np.ndarray:
        width, height = target.size
        return np.frombuffer(target.read(components=1, dtype="f4"), np.float32).reshape(height, width)
