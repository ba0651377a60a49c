"""The other programs that have a Python face. Each function imports its own, for environments differ."""

from __future__ import annotations

import numpy as np
from worker import Work, of_map


def _arrays(data: str) -> dict[str, np.ndarray]:
    with np.load(data) as arrays:
        return {name: arrays[name] for name in arrays.files}


def moderngl_map(data: str, side: int, matrix: list[list[float]]) -> Work:
    """One depth map by OpenGL; the geometry stays on the device, the depths come back to numpy."""
    import moderngl
    from peers.moderngl_peer import ModernGL

    given, peer = _arrays(data), ModernGL()
    peer.upload(given["vertices"].astype(np.float64), given["faces"])
    to_middle = np.eye(4)
    to_middle[:3, 3] = given["middle"]
    clip = np.asarray(matrix) @ to_middle
    depth = peer.draw(clip, (side, side))
    about = f"moderngl {moderngl.__version__} ({peer.renderer})"
    return Work(lambda: peer.draw(clip, (side, side)), about, of_map(depth))


def _hits(run) -> dict[str, float]:
    hits, blocked = run()
    return {"hits": hits, "blocked": blocked}


def embreex_rays(data: str) -> Work:
    """Embree by way of embreex, which traces one ray at a time on the calling thread."""
    from importlib.metadata import version

    from peers.embreex_peer import EmbreexScene

    given = _arrays(data)
    scene = EmbreexScene(given["vertices"], given["faces"], robust=False)
    shift = scene.origin.astype(np.float64)
    origins = (given["origins"] - shift).astype(np.float32)
    shadow = (given["shadow_origins"] - shift).astype(np.float32)
    reach = np.full(len(shadow), 1e3, np.float32)

    def run() -> tuple[int, int]:
        triangle = scene.triangle(origins, given["directions"])
        blocked = scene.occluded(shadow, given["shadow_directions"], reach)
        return int((triangle >= 0).sum()), int(blocked.sum())

    return Work(run, f"embreex {version('embreex')}", _hits(run))


def embreex_build(data: str) -> Work:
    """Embree's hierarchy, made by the first ray."""
    from importlib.metadata import version

    from peers.embreex_peer import EmbreexScene

    given = _arrays(data)
    origin, direction = np.array([[0, 50, 0]], np.float32), np.array([[0, -1, 0]], np.float32)

    def run() -> EmbreexScene:
        scene = EmbreexScene(given["vertices"], given["faces"], robust=False)
        scene.triangle(origin, direction)
        return scene

    return Work(run, f"embreex {version('embreex')}")


def _open3d_scene(given: dict[str, np.ndarray], threads: int):
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
    scene.add_triangles(o3d.core.Tensor(given["vertices"]), o3d.core.Tensor(given["faces"].astype(np.uint32)))
    return scene


def open3d_rays(data: str) -> Work:
    """Open3D's RaycastingScene (Embree), one thread."""
    import open3d as o3d

    given = _arrays(data)
    scene = _open3d_scene(given, 1)
    primary = o3d.core.Tensor(np.concatenate([given["origins"], given["directions"]], axis=1))
    shadow = o3d.core.Tensor(np.concatenate([given["shadow_origins"], given["shadow_directions"]], axis=1))

    def run() -> tuple[int, int]:
        t = scene.cast_rays(primary, nthreads=1)["t_hit"].numpy()
        blocked = scene.test_occlusions(shadow, tnear=0.0, tfar=1e3, nthreads=1).numpy()
        return int(np.isfinite(t).sum()), int(blocked.sum())

    return Work(run, f"Open3D {o3d.__version__}", _hits(run))


def open3d_build(data: str) -> Work:
    """Open3D's hierarchy, made by the first ray."""
    import open3d as o3d

    given = _arrays(data)
    ray = o3d.core.Tensor(np.array([[0, 50, 0, 0, -1, 0]], np.float32))

    def run() -> object:
        scene = _open3d_scene(given, 1)
        scene.cast_rays(ray, nthreads=1)
        return scene

    return Work(run, f"Open3D {o3d.__version__}")


def _mitsuba(given: dict[str, np.ndarray]):
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(1)
    mesh = mi.Mesh("mesh", vertex_count=len(given["vertices"]), face_count=len(given["faces"]))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = given["vertices"].ravel()
    parameters["faces"] = given["faces"].astype(np.uint32).ravel()
    parameters.update()
    return dr, mi, mesh


def mitsuba_rays(data: str) -> Work:
    """Mitsuba's LLVM variant, one thread of its pool."""
    given = _arrays(data)
    dr, mi, mesh = _mitsuba(given)
    scene = mi.load_dict({"type": "scene", "mesh": mesh})

    def to_rays(origins: str, directions: str):
        ray = mi.Ray3f(mi.Point3f(given[origins].T.copy()), mi.Vector3f(given[directions].T.copy()))
        dr.eval(ray)
        return ray

    primary, shadow = to_rays("origins", "directions"), to_rays("shadow_origins", "shadow_directions")
    shadow.maxt = mi.Float(1e3)

    def run() -> tuple[int, int]:
        hit = scene.ray_intersect_preliminary(primary, coherent=True)
        blocked = scene.ray_test(shadow)
        prim, valid = hit.prim_index, hit.is_valid()
        dr.eval(prim, valid, blocked)
        return int(np.count_nonzero(valid.numpy())), int(np.count_nonzero(blocked.numpy()))

    return Work(run, f"Mitsuba {mi.__version__} (llvm_ad_rgb)", _hits(run))


def mitsuba_build(data: str) -> Work:
    """The hierarchy that Mitsuba makes with a scene."""
    dr, mi, mesh = _mitsuba(_arrays(data))

    def run() -> object:
        scene = mi.load_dict({"type": "scene", "mesh": mesh})
        dr.sync_thread()
        return scene

    return Work(run, f"Mitsuba {mi.__version__} (llvm_ad_rgb)")
