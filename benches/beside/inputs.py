"""What every side is given: triangles, a camera, a light, and rays, as arrays in one file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

EYE, TARGET, FOV_Y_DEG, NEAR, FAR = (0.5, 2.2, 7.5), (0.0, 0.7, 0.0), 50.0, 0.5, 30.0
LIGHT = (0.6, -1.0, -0.45)
# Width and height of the picture that rays go through.
IMAGE = (1024, 1024)


def icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere of 20 * 4^level triangles."""
    golden = (1 + 5**0.5) / 2
    corner = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]], float)
    vertices = np.concatenate([corner, np.roll(corner, 1, axis=1), np.roll(corner, 2, axis=1)])
    distance = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    near = distance < 2.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] & near[b, c] & near[a, c]
    ]
    faces = np.array(faces)
    for _ in range(level):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, of_face = np.unique(edges, axis=0, return_inverse=True)
        middle = len(vertices) + of_face.reshape(-1, 3)
        vertices = np.concatenate([vertices, vertices[edges].mean(axis=1)])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        faces = np.concatenate([np.column_stack(t) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


def bench_scene() -> tuple[np.ndarray, np.ndarray]:
    """Five lumpy spheres of 81,920 triangles over a rolling ground of 31,752: 441,352 triangles, always the same."""
    rng = np.random.default_rng(20)
    sphere, sphere_faces = icosphere(6)
    parts, faces, count = [], [], 0
    for k, (x, z) in enumerate([(0, 0), (2.6, 0.8), (-2.4, 1.1), (1.2, -2.7), (-1.6, -2.4)]):
        waves = rng.normal(size=(6, 3)) * [[3], [5], [8], [13], [21], [34]]
        lumps = sum(np.sin(sphere @ w + k) / np.linalg.norm(w) for w in waves)
        parts.append(sphere * (1 + 0.35 * lumps[:, None]) + [x, 1.1, z])
        faces.append(sphere_faces + count)
        count += len(sphere)
    n = 127
    x, z = np.meshgrid(np.linspace(-6, 6, n), np.linspace(-6, 6, n))
    ground = np.column_stack([x.ravel(), 0.15 * (np.sin(2 * x) * np.cos(3 * z)).ravel(), z.ravel()])
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces.append(np.concatenate([corner + np.array([0, n, 1]), corner + np.array([1, n, n + 1])]) + count)
    parts.append(ground)
    # Rounded to single precision, so that every program is given the same numbers.
    return np.concatenate(parts).astype(np.float32).astype(np.float64), np.concatenate(faces).astype(np.int32)


def write(path: Path) -> None:
    """Triangles and rays, the latter in single precision relative to the scene's middle, as peers take them."""
    from peers.rays import pixel_rays

    import shadowlab as sl

    vertices, faces = bench_scene()
    scene = sl.Scene.from_arrays(vertices, faces)
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    origins, directions = (a.astype(np.float32) for a in pixel_rays(camera(), IMAGE))
    origins = (origins.astype(np.float64) - middle).astype(np.float32)
    t, triangle = sl.trace.first_hit(scene, origins.astype(np.float64) + middle, directions.astype(np.float64))[:2]
    hit = triangle >= 0
    corner = vertices[faces[triangle[hit]]]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    to_light = -np.asarray(LIGHT) / np.linalg.norm(LIGHT)
    # Not from surfaces edge on to the light; a thousandth of a unit off, on the light's side.
    lit = np.abs(normal @ to_light) > 1e-3
    points = origins[hit] + t[hit, None] * directions[hit]
    points = points[lit] + 1e-3 * normal[lit] * np.sign(normal[lit] @ to_light)[:, None]
    np.savez(
        path,
        middle=middle,
        vertices=(vertices - middle).astype(np.float32),
        faces=faces,
        origins=origins,
        directions=directions,
        shadow_origins=points.astype(np.float32),
        shadow_directions=np.tile(to_light.astype(np.float32), (len(points), 1)),
    )


def camera():
    """The camera of all rows about the bench scene."""
    import shadowlab as sl

    return sl.Camera.look_at(EYE, TARGET, fov_y=np.radians(FOV_Y_DEG), aspect=1.0, near=NEAR, far=FAR)
