"""Depth images and shadow textures by pyrender, read back as depth in [0, 1], row 0 at NDC y = +1.

Three habits of pyrender 0.1.45 stand between its images and a comparison; each is undone here, none is papered over:

1. **Orthographic depth is wrong.** It turns its depth buffer into distances by the perspective formula
   2 n f / (f + n - z (f - n)) for *every* camera, so distances from an OrthographicCamera come out wrong (a buffer
   value of 1/2, the middle of the range, is reported as 2 n f / (f + n) instead of (n + f) / 2). The formula is one
   to one, so it is inverted here and the depth buffer's own value comes back, for both cameras. Empty texels are
   reported as 0.
2. **Four samples a pixel.** The offscreen target is multisampled and its depth is resolved by taking one sample, which
   lies away from the pixel's centre. The target is created with one sample here.
3. **Back faces are culled in depth and shadow passes**, whatever the material says. Meshes are given to it with each
   triangle in both windings.

The depth buffer of the offscreen target and, on llvmpipe, of the shadow texture is a 24-bit integer: depths are
multiples of 1 / (2^24 - 1).
"""

from __future__ import annotations

import numpy as np
import pyrender
import pyrender.renderer
from OpenGL import GL

from . import pyrender_shim

pyrender_shim.install()

# pyrender's matrices give z in -w..w; shadowlab's z in 0..w. (z + w) / 2 is exact in the matrix up to one rounding.
UNIT_Z_FROM_SYMMETRIC = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])


class Pyrender:
    """One EGL context; a renderer in it."""

    def __init__(self):
        self._multisample = pyrender.renderer.glRenderbufferStorageMultisample
        pyrender.renderer.glRenderbufferStorageMultisample = self._single_sample
        self._renderer = pyrender.OffscreenRenderer(64, 64)
        self._make_current()
        self.renderer = GL.glGetString(GL.GL_RENDERER).decode()

    def _single_sample(self, target, _samples, *rest):
        self._multisample(target, 0, *rest)

    def _make_current(self) -> None:
        # Other programs of this process have contexts too; pyrender never lets go of its own.
        self._renderer._platform.make_current()

    def camera_distance(self, vertices, faces, camera, world_from_camera, size: tuple[int, int]) -> np.ndarray:
        """(H, W) float32: what pyrender's own `render` calls depth, of triangles seen by a pyrender camera."""
        scene = _scene(vertices, faces)
        scene.add(camera, pose=world_from_camera)
        self._renderer.viewport_width, self._renderer.viewport_height = size
        return self._renderer.render(scene, pyrender.RenderFlags.DEPTH_ONLY)

    def camera_depth(self, vertices, faces, camera, world_from_camera, size: tuple[int, int]) -> np.ndarray:
        """(H, W) float64 depth in [0, 1]: the same, undone to the depth buffer's values."""
        distance = self.camera_distance(vertices, faces, camera, world_from_camera, size)
        return depth_from_pyrender_distance(distance, camera.znear, camera.zfar)

    def shadow_texture(self, vertices, faces, light, world_from_light) -> tuple[np.ndarray, np.ndarray]:
        """The (N, N) float32 shadow texture that pyrender renders for a light, and its matrix with z in [0, 1]."""
        scene = _scene(vertices, faces)
        # pyrender draws shadows only on the way to an image; any camera will do.
        scene.add(pyrender.PerspectiveCamera(yfov=1.0, znear=0.1, zfar=10.0), pose=world_from_light)
        node = scene.add(light, pose=world_from_light)
        flags = pyrender.RenderFlags.SHADOWS_DIRECTIONAL | pyrender.RenderFlags.SHADOWS_SPOT
        self._renderer.viewport_width = self._renderer.viewport_height = 16
        self._renderer.render(scene, flags)
        self._make_current()
        light.shadow_texture._bind()
        depth = GL.glGetTexImage(GL.GL_TEXTURE_2D, 0, GL.GL_DEPTH_COMPONENT, GL.GL_FLOAT)
        light.shadow_texture._unbind()
        depth = np.array(depth, np.float32).reshape(light.shadow_texture.height, light.shadow_texture.width)
        view, projection = self._renderer._renderer._get_light_cam_matrices(scene, node, flags)
        return np.ascontiguousarray(depth[::-1]), UNIT_Z_FROM_SYMMETRIC @ projection @ view

    def release(self) -> None:
        """Give the context back."""
        self._renderer.delete()
        pyrender.renderer.glRenderbufferStorageMultisample = self._multisample


def depth_from_pyrender_distance(distance, near: float, far: float) -> np.ndarray:
    """Depth buffer values in [0, 1] from what pyrender calls linear depth: the inverse of its perspective formula."""
    distance = np.asarray(distance, np.float64)
    depth = np.ones(distance.shape)
    drawn = distance != 0
    symmetric = (far + near - 2 * near * far / distance[drawn]) / (far - near)
    # The distances are float32, so the ends of the range come back up to one rounding outside.
    depth[drawn] = np.clip(0.5 * (symmetric + 1), 0, 1)
    return depth


def clip_from_world(camera, world_from_camera, size: tuple[int, int]) -> np.ndarray:
    """(4, 4) matrix, z in [0, 1], by which pyrender draws for a camera."""
    projection = camera.get_projection_matrix(width=size[0], height=size[1])
    return UNIT_Z_FROM_SYMMETRIC @ projection @ np.linalg.inv(world_from_camera)


def world_from_light(position, direction) -> np.ndarray:
    """(4, 4) pose at `position` whose -z axis is `direction`, as pyrender and glTF place lights and cameras."""
    back = -np.asarray(direction, np.float64)
    back /= np.linalg.norm(back)
    side = np.cross(np.eye(3)[np.argmin(np.abs(back))], back)
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3] = np.column_stack([side, np.cross(back, side), back, position])
    return pose


def _scene(vertices, faces) -> pyrender.Scene:
    """A pyrender scene of one mesh, every triangle in both windings."""
    faces = np.asarray(faces)
    both = np.concatenate([faces, faces[:, ::-1]]).astype(np.uint32)
    positions = np.asarray(vertices, np.float32)
    # Normals are read by the image's shader only, but pyrender wants some.
    normals = np.tile(np.float32([0, 0, 1]), (len(positions), 1))
    primitive = pyrender.Primitive(
        positions=positions, normals=normals, indices=both, mode=pyrender.constants.GLTF.TRIANGLES
    )
    scene = pyrender.Scene()
    scene.add(pyrender.Mesh(primitives=[primitive]))
    return scene
