"""An independent judge of why a pixel is wrong: rays of the map's own parameterization, as many per texel as it takes.

A ray at any place (x, y) of a map is a texel of an arbitrarily fine map of the same parameterization, read without
bias: `tests/test_causes_judged.py` compares the two. The judge follows the surfaces between a pixel's own ray and those
of the texels around, in steps of 1/64 of the way, and halves the steps across which depth jumps until they are
continuous or a silhouette.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from explain_support import Triangles

import shadowlab as sl

ACNE, EDGE, LEAK, MISSING, OTHER = 1, 2, 3, 4, 5
# Steps from a pixel's place in the map to a texel's centre: bars of 1/64 of a texel are seen.
STEPS = 64
# Halvings of the step that jumps: 2^-24 of 1/64 of a texel, where f64 still tells two rays apart.
HALVINGS = 24
# Rasterisers snap vertices to 1/256 of a texel, so a texel may hold what lies so far from its centre.
SNAP = 1 / 128
# Steps that are tried, the largest jumps first.
TRIED = 3
# Rise of a surface that is followed, texels a texel.
STEEPEST = 16
# Lengths across the rays that count as none, in texels: single precision of positions and stored depths.
TOUCH = 1e-3
# How far behind a surface the next one begins, parts of the scene's size: what single precision tells apart in a map.
APART = 1e-6
# Surfaces on a ray that are looked at for one that is averted from the light.
LAYERS = 64
# Texels that maps of dual layers move the first depth by, where no limit is given.
LIMIT = 8.0


@dataclass
class Verdict:
    """Causes and distances of wrong pixels.

    Attributes
    ----------
    pixels : (N,) int
        Flat indices of the wrong pixels that one map serves, or none.
    cause : (N,) int
        One of the codes above.
    distance : (N,) float
        Of edges, from the pixel to the nearest place of the shadow (of false light: of the light) that the texel's
        centre lies in, in pixels; NaN of others.
    """

    pixels: np.ndarray
    cause: np.ndarray
    distance: np.ndarray


class Judge:
    """Judges what a nearest lookup gets wrong in a projective map of some surface."""

    def __init__(self, scene, camera, light, p, gbuffer, resolution, surface="front"):
        self.surface = surface
        self.scene, self.camera, self.light = scene, camera, light
        self.matrices = np.stack([np.asarray(part.matrix) for part in p.partitions])
        assert all(part.post_warp == "none" for part in p.partitions)
        self.size = np.broadcast_to(np.asarray(resolution, float), (2,))
        self.position = np.asarray(gbuffer.position, float).reshape(-1, 3)
        self.normal = np.asarray(gbuffer.normal, float).reshape(-1, 3)
        self.shape = np.asarray(gbuffer.position).shape[:2]
        self.which = np.asarray(sl.aliasing.texel_coordinates(gbuffer, camera, light, p)[1]).ravel()
        self.reach = 4.0 * np.linalg.norm(np.ptp(np.asarray(scene.bounds), axis=0))

    # Geometry of the map: points `x` (..., 3), rows of the matrix (..., 4) of each.

    def rows(self, maps):
        return np.moveaxis(self.matrices[maps], -2, 0)

    def clip(self, maps, x):
        return [np.sum(row[..., :3] * x, -1) + row[..., 3] for row in self.rows(maps)]

    def texels(self, maps, x):
        """Texel coordinates, y down, and NDC depth."""
        cx, cy, cz, cw = self.clip(maps, x)
        return np.stack([0.5 + 0.5 * cx / cw, 0.5 - 0.5 * cy / cw], -1) * self.size, cz / cw

    def on_plane(self, maps, texel, point, normal):
        """Where the rays of places in the map meet planes."""
        ndc = np.stack([2 * texel[..., 0] / self.size[0] - 1, 1 - 2 * texel[..., 1] / self.size[1]], -1)
        rx, ry, _, rw = self.rows(maps)
        a, b = rx - ndc[..., :1] * rw, ry - ndc[..., 1:] * rw
        system = np.stack(np.broadcast_arrays(a[..., :3], b[..., :3], normal), -2)
        right = np.stack(np.broadcast_arrays(-a[..., 3], -b[..., 3], np.sum(normal * point, -1)), -1)
        bad = np.abs(np.linalg.det(system)) == 0
        system = np.where(bad[..., None, None], np.eye(3), system)
        return np.linalg.solve(system, right[..., None])[..., 0]

    def to_light(self, x):
        if isinstance(self.light, sl.DirectionalLight):
            d = -np.asarray(self.light.direction, float)
            return np.broadcast_to(d / np.linalg.norm(d), x.shape)
        way = np.asarray(self.light.position, float) - x
        return way / np.linalg.norm(way, axis=-1, keepdims=True)

    def met(self, maps, x):
        """What the map would hold on the rays through points `x`: how far before them, towards the light, and where.

        Nothing that the near plane cuts off counts; minus infinity where the ray is empty.
        """
        back = self.to_light(x)
        cz = self.clip(maps, x)[2]
        dz = np.sum(self.rows(maps)[2][..., :3] * back, -1)
        with np.errstate(divide="ignore", invalid="ignore"):
            near = np.where(dz != 0, -cz / dz, np.inf)
        # Only what is towards the light, and no further than everything.
        far = self.reach + np.linalg.norm(x - np.mean(np.asarray(self.scene.bounds), axis=0), axis=-1)
        if not isinstance(self.light, sl.DirectionalLight):
            far = np.minimum(far, np.linalg.norm(np.asarray(self.light.position, float) - x, axis=-1))
        start = np.where((near > 0) & np.isfinite(near), np.minimum(near, far), far)
        before, at, *_ = self.below(x, start)
        return before, at

    def below(self, x, start):
        """What is met first on the rays through points from heights on, downwards: how high, where, and whose."""
        back = self.to_light(x)
        origin = (x + start[..., None] * back).reshape(-1, 3)
        t, triangle, instance = sl._core.first_hit(self.scene, origin, np.ascontiguousarray(-back.reshape(-1, 3)))
        before = start - np.asarray(t).reshape(start.shape)
        at = x + np.where(np.isfinite(before), before, 0.0)[..., None] * back
        return before, at, np.asarray(triangle).reshape(start.shape), np.asarray(instance).reshape(start.shape)

    def kept(self, maps, x):
        """What the map stores of the rays through points: how far before them, and where."""
        first, at = self.met(maps, x)
        if self.surface == "front":
            return first, at
        back, apart = self.to_light(x), APART * self.reach

        def drawn(before, at):
            return np.where(np.isfinite(before) & (self.texels(maps, at)[1] < 1), before, -np.inf)

        first = drawn(first, at)
        some = np.where(np.isfinite(first), first, 0.0)
        if self.surface == "back":
            height, step = some, 1e-9 * self.reach
            found, todo = np.full(x.shape[:-1], -np.inf), np.isfinite(first)
            start = some + apart
            for _ in range(LAYERS):
                height, place, triangle, instance = self.below(x, start)
                height = drawn(height, place)
                todo &= np.isfinite(height)
                row = self.row[np.maximum(instance, 0)] + np.maximum(triangle, 0)
                averted = np.sum(self.outer[row] * back, -1) < 0
                found = np.where(todo & averted, height, found)
                todo &= ~averted
                start = np.where(todo, height - step, start)
                if not todo.any():
                    break
        else:
            height, place, *_ = self.below(x, some - apart)
            second = np.where(np.isfinite(first), drawn(height, place), -np.inf)
            with np.errstate(invalid="ignore"):
                half = np.where(np.isfinite(second), 0.5 * (first - second), np.inf)
            if self.surface == "dual":
                half = np.minimum(half, LIMIT * self.texel_size(maps, at, 1e-3))
            found = second if self.surface == "second" else first - half
        found = np.where(np.isfinite(first), found, -np.inf)
        at = x + np.where(np.isfinite(found), found, 0.0)[..., None] * back
        return drawn(found, at), at

    def shades(self, q, height, x, size):
        """Whether the triangles at heights over points `q` also stand between points `x` and the light."""
        start = np.where(np.isfinite(height), height, 0.0) + APART * self.reach
        _, _, triangle, instance = self.below(q, start)
        row = self.row[np.maximum(instance, 0)] + np.maximum(triangle, 0)
        a, b, c = np.moveaxis(self.corners[row], 1, 0)
        back, e1, e2 = self.to_light(x), b - a, c - a
        with np.errstate(divide="ignore", invalid="ignore"):
            p, s = np.cross(back, e2), x - a
            det = np.sum(e1 * p, -1)
            u, turned = np.sum(s * p, -1) / det, np.cross(s, e1)
            v, t = np.sum(back * turned, -1) / det, np.sum(e2 * turned, -1) / det
            inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > TOUCH * size)
        return inside & np.isfinite(height) & (triangle >= 0)

    @functools.cached_property
    def row(self):
        """Of each instance, the first of its triangles in `outer`."""
        counts = [self.scene.meshes[k].triangle_count for k in self.scene.mesh_index]
        return np.concatenate([[0], np.cumsum(counts)[:-1]])

    @functools.cached_property
    def triangles(self):
        """All triangles, relative to the scene's middle."""
        assert not any(mesh.dropped_faces for mesh in self.scene.meshes)
        return Triangles.of(self.scene)

    @functools.cached_property
    def corners(self):
        """Of all triangles, (N, 3, 3)."""
        return self.triangles.corners + self.triangles.middle

    @property
    def outer(self):
        """Normals (N, 3) of the outer sides of all triangles."""
        return self.triangles.outer

    def texel_size(self, maps, x, part=1.0):
        """World size of a texel across the ray, its longer side, from that of a part of it."""
        across = self.to_light(x)
        here, _ = self.texels(maps, x)
        step = [self.on_plane(maps, here + d, x, across) - x for d in ([part, 0.0], [0.0, part])]
        return np.max(np.linalg.norm(step, axis=-1), axis=0) / part

    def jumps(self, maps, a, b, size):
        """Whether what the map holds on the way from place `a` to place `b` has a silhouette."""
        point, normal = self.anchor
        t = np.linspace(0, 1, STEPS + 1)

        def held(t):
            texel = a + t[..., None] * (b - a)
            before = self.met(maps, self.on_plane(maps, texel, point, normal))[0]
            return np.where(np.isfinite(before), before, -1e30)

        before = held(np.broadcast_to(t[:, None], (STEPS + 1, len(a))))
        rise = np.abs(np.diff(before, axis=0))
        found = np.zeros(len(a), bool)
        pick = np.arange(len(a))
        for k in np.argsort(-rise, axis=0, kind="stable")[:TRIED]:
            low, high, at_low, at_high = t[k].copy(), t[k + 1].copy(), before[k, pick], before[k + 1, pick]
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                x = held(middle)
                first = np.abs(x - at_low) >= np.abs(at_high - x)
                high, at_high = np.where(first, middle, high), np.where(first, x, at_high)
                low, at_low = np.where(first, low, middle), np.where(first, at_low, x)
            found |= np.abs(at_high - at_low) > TOUCH * size
        return found

    def shaded(self, maps, x, size):
        """Whether points of planes are shaded by more than what touches them."""
        return self.met(maps, x)[0] > TOUCH * size

    def follows(self, maps, a, b, size):
        """How high above its plane the receiver's own surface lies at place `b`; NaN where it ends before."""
        point, normal = self.anchor
        height, lost = np.zeros(len(a)), np.zeros(len(a), bool)
        for t in np.linspace(0, 1, STEPS + 1)[1:]:
            x = self.on_plane(maps, a + t * (b - a), point, normal)
            back = self.to_light(x)
            # A surface no steeper than 16 texels a texel is met from as far above as it can have risen.
            above = height + STEEPEST * size / STEPS
            way, *_ = sl._core.first_hit(self.scene, x + above[:, None] * back, np.ascontiguousarray(-back))
            lost |= np.asarray(way) > 2 * STEEPEST * size / STEPS
            height = np.where(lost, 0.0, above - np.where(lost, 0.0, way))
        return np.where(lost, np.nan, height)

    def judge(self, errors, maps):
        """The verdict on the wrong pixels `errors` (H, W) of a nearest lookup in shadow maps `maps` (K, H, W)."""
        errors = np.asarray(errors).ravel()
        pixels = np.flatnonzero(errors > 0)
        # A surface that faces away from the light is in no map: it shades itself.
        cause = np.where(errors[pixels] == 1, ACNE, MISSING)
        distance = np.full(len(pixels), np.nan)
        held = self.which[pixels] >= 0
        maps = np.asarray(maps).reshape(-1, *map(int, self.size[::-1]))
        for error, work in ((1, self._shadow), (2, self._light)):
            mine = np.flatnonzero(held & (errors[pixels] == error))
            if len(mine):
                cause[mine], distance[mine] = work(
                    pixels[mine], np.asarray(maps).reshape(-1, *map(int, self.size[::-1]))
                )
        return Verdict(pixels, cause, distance)

    def _start(self, pixels, maps):
        k, x = self.which[pixels], self.position[pixels]
        self.anchor = (x, self.normal[pixels])
        place, depth = self.texels(k, x)
        size = self.texel_size(k, x)
        column = np.clip(np.floor(place).astype(int), 0, self.size.astype(int) - 1)
        stored = maps[k, column[:, 1], column[:, 0]].astype(float)
        centre = column + 0.5
        # The map is right where it holds what rays meet near the texel's centre, up to the snap of the rasteriser.
        around = [[0, 0], [-1, -1], [-1, 1], [1, -1], [1, 1], [-1, 0], [1, 0], [0, -1], [0, 1]]
        depths = []
        for d in np.asarray(around) * SNAP:
            there = self.on_plane(k, centre + d, *self.anchor)
            # At the silhouettes of solids, what lies behind the first surface begins at that one.
            for before, at in (self.kept(k, there), *([self.met(k, there)] if self.surface != "front" else [])):
                z = self.texels(k, at)[1]
                depths.append(np.where(np.isfinite(before) & (z <= 1), z, 1.0))
        low, high = np.min(depths, axis=0), np.max(depths, axis=0)
        wrong = (stored < low - 1e-6) | (stored > high + 1e-6)
        q = self.on_plane(k, centre, *self.anchor)
        before, kept = self.met(k, q)[0], self.kept(k, q)[0]
        return k, x, place, centre, size, stored, depth, wrong, q, before, kept

    def is_centre(self, k, q, stored, size):
        """Whether texels hold what the rays of their centres give, not what lies a rasteriser's rounding away."""
        before, at = self.kept(k, q)
        depth = np.where(np.isfinite(before), self.texels(k, at)[1], 1.0)
        texel = np.abs(np.sum(self.rows(k)[2][..., :3] * self.to_light(q), -1)) * size
        return np.abs(np.minimum(depth, 1.0) - stored) <= texel

    def is_own(self, before, own_height, size):
        """Whether a surface at a height over the receiver's plane is the receiver's own, followed there."""
        with np.errstate(invalid="ignore"):
            return (np.abs(before) <= TOUCH * size) | (np.abs(before - own_height) <= 4 * TOUCH * size)

    def _shadow(self, pixels, maps):
        k, x, place, centre, size, _, _, wrong, q, before, kept = self._start(pixels, maps)
        own = np.abs(before) <= TOUCH * size
        if self.surface in ("back", "second"):
            # Under a caster that has no such surface the map holds the receiver's own.
            own |= self.is_own(kept, self.follows(k, place, centre, size), size)
        edge = self.jumps(k, place, centre, size) & ~own
        cause = np.where(wrong, OTHER, np.where(edge, EDGE, ACNE))
        distance = np.full(len(pixels), np.nan)
        mine = np.flatnonzero(cause == EDGE)
        distance[mine] = self.nearest(k[mine], x[mine], q[mine], self.normal[pixels[mine]], size[mine], True)
        return cause, distance

    def _light(self, pixels, maps):
        k, x, place, centre, size, stored, depth, wrong, q, before, kept = self._start(pixels, maps)
        blocked = self.met(k, x)[0] > 0
        own_height = self.follows(k, place, centre, size)
        own = self.is_own(before, own_height, size)
        if self.surface in ("back", "second"):
            # Of a triangle that shades the pixel, too, the map holds a caster, though it continues the receiver's own.
            own |= self.is_own(kept, own_height, size) & ~self.shades(q, kept, x, size)
        leak = (stored < depth) & ~own
        # A texel around whose centre lies in the same shadow: all of the way to it is dark.
        around = np.array([[dx, dy] for dx in (-1, 0, 1) for dy in (-1, 0, 1)])
        there = (centre + around[:, None]).reshape(-1, 2)
        one = np.tile(np.arange(len(pixels)), len(around))
        dark = ((there > 0) & (there < self.size)).all(-1)
        for t in np.linspace(0, 1, STEPS + 1)[1:]:
            todo = np.flatnonzero(dark)
            if not len(todo):
                break
            of = one[todo]
            y = self.on_plane(k[of], place[of] + t * (there[todo] - place[of]), x[of], self.anchor[1][of])
            dark[todo] = self.shaded(k[of], y, size[of])
        # The texel's own centre is in the shadow, and what is stored there lights the pixel all the same.
        unstored = dark.reshape(len(around), -1)[4] & self.is_centre(k, q, stored, size)
        if self.surface != "front":
            there = self.on_plane(k[one], there, x[one], self.anchor[1][one])
            dark &= self.kept(k[one], there)[0] > TOUCH * size[one]
        drawn = dark.reshape(len(around), -1).any(axis=0) & ~unstored
        cause = np.select([~blocked, wrong, leak, drawn], [MISSING, OTHER, LEAK, EDGE], MISSING)
        distance = np.full(len(pixels), np.nan)
        mine = np.flatnonzero(cause == EDGE)
        distance[mine] = self.nearest(k[mine], x[mine], q[mine], self.normal[pixels[mine]], size[mine], False)
        return cause, distance

    def nearest(self, k, x, q, normal, size, is_dark):
        """Pixels from `x` to the nearest point of the region about `q`, all of the way from which is dark (or lit).

        By brute force in the image: 65 ways from `q`, each in steps of 1/32 of the length that can still come nearer.
        """
        a, b = self.pixels(x), self.pixels(q)
        reach = np.linalg.norm(b - a, axis=-1)
        turn = np.linspace(-1.4, 1.4, 65)[:, None]
        angle = np.arctan2(*(a - b).T[::-1]) + turn
        way = (np.stack([np.cos(angle), np.sin(angle)]) * 2 * reach * np.cos(turn)).reshape(2, -1).T
        one = np.tile(np.arange(len(x)), len(turn))
        going, best = np.ones(len(one), bool), reach[one]
        for t in np.linspace(0, 1, 33)[1:]:
            todo = np.flatnonzero(going)
            of = one[todo]
            c = b[of] + t * way[todo]
            good = self.shaded(k[of], self.seen(c, x[of], normal[of]), size[of]) == is_dark
            going[todo] = good
            closer = np.linalg.norm(c - a[of], axis=-1)
            best[todo] = np.where(good, np.minimum(best[todo], closer), best[todo])
        return best.reshape(len(turn), -1).min(axis=0)

    def pixels(self, x):
        """Where points are in the image, pixels."""
        y = (x - np.asarray(self.camera.eye)) @ np.stack([self.right, self.up, self.forward], -1)
        h, w = self.shape
        tan = np.tan(0.5 * self.camera.fov_y)
        return np.stack(
            [0.5 * w * (1 + y[:, 0] / (y[:, 2] * tan * self.camera.aspect)), 0.5 * h * (1 - y[:, 1] / (y[:, 2] * tan))],
            -1,
        )

    def seen(self, c, point, normal):
        """Where rays of the camera through places of the image meet planes."""
        h, w = self.shape
        tan = np.tan(0.5 * self.camera.fov_y)
        u = (2 * c[:, :1] / w - 1) * tan * self.camera.aspect
        v = (1 - 2 * c[:, 1:] / h) * tan
        way = self.forward + u * self.right + v * self.up
        eye = np.asarray(self.camera.eye)
        t = np.sum(normal * (point - eye), -1) / np.sum(normal * way, -1)
        return eye + t[:, None] * way

    @property
    def forward(self):
        return np.asarray(self.camera.forward, float)

    @property
    def right(self):
        return np.asarray(self.camera.right, float)

    @property
    def up(self):
        return np.cross(self.right, self.forward)
