"""Files that trimesh reads right give the very scene that its own reading gives: meshes, faces and their order."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from trimesh.exchange.ply import export_ply
from trimesh.exchange.stl import export_stl_ascii

import shadowlab as sl

BALL = trimesh.creation.icosphere(3)
SIDE = 12
GRID = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), -1).reshape(-1, 2)
HEIGHTS = np.sin(GRID.sum(axis=1) / 3)
CELLS = [
    [r * SIDE + c, (r + 1) * SIDE + c, (r + 1) * SIDE + c + 1, r * SIDE + c + 1]
    for r in range(SIDE - 1)
    for c in range(SIDE - 1)
]
POINTS = [f"{x} {y} {z:.6f}" for (x, y), z in zip(GRID, HEIGHTS, strict=True)]


def textured():
    """A ball with a coordinate of texture for each vertex."""
    made = BALL.copy()
    made.visual = trimesh.visual.TextureVisuals(uv=np.random.default_rng(0).random((len(made.vertices), 2)))
    return made


def obj(face, groups=1):
    """An OBJ file of quads; every third is a triangle where `groups` is 0."""
    lines = [f"v {point}" for point in POINTS] + ["vt 0 0", "vt 0 1", "vt 1 1", "vt 1 0", "vn 0 0 1"]
    for i, cell in enumerate(CELLS):
        if groups and i % 40 == 0:
            lines.append(f"usemtl m{i // 40 % groups}")
        kept = cell if groups or i % 3 else cell[:3]
        lines.append("f " + " ".join(face.format(v + 1, k + 1) for k, v in enumerate(kept)))
    return "\n".join([*lines, ""])


def off(mixed):
    """An OFF file of quads, and triangles where they are mixed."""
    faces = [cell if i % 3 or not mixed else cell[:3] for i, cell in enumerate(CELLS)]
    rows = [f"{len(face)} {' '.join(map(str, face))}" for face in faces]
    return "\n".join(["OFF", f"{len(POINTS)} {len(rows)} 0", *POINTS, *rows, ""])


FILES = {
    "ball.obj": lambda: trimesh.exchange.obj.export_obj(BALL),
    "normals.obj": lambda: trimesh.exchange.obj.export_obj(BALL, include_normals=True),
    "textured.obj": lambda: trimesh.exchange.obj.export_obj(textured()),
    "scene.obj": lambda: trimesh.exchange.obj.export_obj(trimesh.Scene([BALL, trimesh.creation.box()])),
    "quads.obj": lambda: obj("{0}"),
    "mixed.obj": lambda: obj("{0}", 0),
    "quads of materials.obj": lambda: obj("{0}/{1}/1", 3),
    "normals of materials.obj": lambda: obj("{0}//1", 2),
    "texture of materials.obj": lambda: obj("{0}/{1}", 2),
    "ball.ply": lambda: export_ply(BALL),
    "text.ply": lambda: export_ply(BALL, encoding="ascii"),
    "ball.off": lambda: trimesh.exchange.off.export_off(BALL),
    "quads.off": lambda: off(False),
    "mixed.off": lambda: off(True),
    "ball.stl": lambda: trimesh.exchange.stl.export_stl(BALL),
    "text.stl": lambda: export_stl_ascii(BALL),
    "ball.3mf": lambda: trimesh.exchange.threemf.export_3MF(BALL),
}


@pytest.mark.parametrize("name", FILES)
def test_the_same_scene_as_before(name, tmp_path):
    content = FILES[name]()
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    # COLLADA is not among them: pycollada rounds positions to single precision in the file's own coordinates.
    expected = sl.Scene.from_trimesh(trimesh.load_scene(path, process=False))
    assert sl.load_scene(path, unit=1) == expected
