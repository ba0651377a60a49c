"""Alpha tests whose answer is known: a fence as a texture and the same fence as geometry, and sampling in numpy."""

from __future__ import annotations

import numpy as np

import shadowlab as sl

# Columns of a fence's texture, every second of them a bar.
COLUMNS = 16
CAMERA = sl.Camera.look_at((1.5, 4, 7), (0, 0.5, 0), fov_y=0.8, aspect=4 / 3, near=0.5, far=60)
SUN = sl.DirectionalLight((0.3, -1, 0.8))
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def square(corner, right, up):
    """Corners of a parallelogram, upper left first, as (0, 0) of texture coordinates is."""
    corner, right, up = (np.asarray(v, float) for v in (corner, right, up))
    return np.array([corner + up, corner + up + right, corner + right, corner])


def unit(repeats=(1.0, 1.0), offset=(0.0, 0.0)):
    """Texture coordinates of a square."""
    return np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * repeats + np.asarray(offset)


def floor(half=8.0):
    return sl.Scene.from_arrays(square((-half, 0, half), (2 * half, 0, 0), (0, 0, -2 * half)), FACES)


def bars(**settings):
    """The texture of a fence: levels cross one half at the borders of texels, where the bars end."""
    texture = np.zeros((1, COLUMNS), np.uint8)
    texture[:, ::2] = 255
    return sl.AlphaTest(texture, unit(), wrap=("clamp", "clamp"), **settings)


def fence():
    """A fence on a floor whose bars are in a texture."""
    return floor() + sl.Scene.from_arrays(square((-2, 0, 0), (4, 0, 0), (0, 2, 0.3)), FACES, alpha=bars())


def carved():
    """The same fence whose bars are geometry."""
    vertices, faces = [], []
    for k in range(0, COLUMNS, 2):
        faces.append(FACES + 4 * len(vertices))
        vertices.append(square((-2 + 4 * k / COLUMNS, 0, 0), (4 / COLUMNS, 0, 0), (0, 2, 0.3)))
    return floor() + sl.Scene.from_arrays(np.concatenate(vertices), np.concatenate(faces))


def folded(u, wrap):
    """The index of a texel that may lie outside, by numpy's own rules."""
    name = {"repeat": "wrap", "mirror": "symmetric", "clamp": "edge"}[wrap[0]]
    index, count = wrap[1]
    reach = int(np.abs(index).max()) + count + 1
    return np.pad(np.arange(count), reach, mode=name)[index + reach]


def sampled(alpha, u, v):
    """Levels of a texture at coordinates, bilinear between centres."""
    height, width = alpha.texture.shape
    texture = alpha.texture.astype(float)

    def neighbours(u, wrap, count):
        place = np.asarray(u, float) * count - 0.5
        first = np.floor(place).astype(int)
        return folded(u, (wrap, (first, count))), folded(u, (wrap, (first + 1, count))), place - first

    left, right, across = neighbours(u, alpha.wrap[0], width)
    upper, lower, down = neighbours(v, alpha.wrap[1], height)
    rows = [texture[y, left] * (1 - across) + texture[y, right] * across for y in (upper, lower)]
    return rows[0] * (1 - down) + rows[1] * down
