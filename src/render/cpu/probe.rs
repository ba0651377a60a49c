//! What a map holds around a receiver, in world units along the light's ray: see `aliasing::causes`.
//!
//! The gap of a texel is exact: the ray through the texel's centre meets the receiver's plane in one point (three linear
//! equations), and the stored depth lies on that ray at a distance that solves a linear equation again, since clip z and w are
//! affine along it.

use glam::{DMat3, DVec2, DVec3};

use super::lookup::{Comparison, MapLookup};
use crate::aliasing::causes::Probe;
use crate::parameterization::PostWarp;
use crate::render::Filter;

/// Texels around the point that a probe looks at, each way.
const AROUND: i64 = 1;

impl MapLookup {
    /// What the map, rows from the top, holds around a receiver at `p` relative to the origin with a unit normal.
    pub fn probe(&self, map: &[f32], p: DVec3, normal: DVec3) -> Probe {
        let [row_x, row_y, row_z, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        let ndc = self.post_warp.apply(DVec3::new(row_x.dot(p4), row_y.dot(p4), row_z.dot(p4)) / w, w);
        // Written so that a NaN is outside. Before the near plane casters may be missing; beyond the far plane none is.
        if !(w > 0.0 && ndc.z >= 0.0 && ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0) {
            return Probe { gap: f64::NEG_INFINITY, gap_around: f64::NEG_INFINITY, ..Probe::default() };
        }
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let p_texel = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size;
        let to_light = self.way_to_light(p);
        let carry = match self.compare_at(p, normal) {
            Comparison::At { z, .. } => self.way_to_depth(p, to_light, z).max(0.0),
            // The bias moves it past the light or the near plane.
            Comparison::Lit => f64::INFINITY,
        };
        let mut probe = Probe {
            is_held: true,
            texel: self.texel_size(p, to_light),
            carry,
            gap: f64::NEG_INFINITY,
            gap_around: f64::NEG_INFINITY,
        };
        let (read, corner) = match self.filter {
            Filter::Nearest => (0..=0, p_texel.floor()),
            Filter::Pcf2x2 => (0..=1, (p_texel - 0.5).floor()),
        };
        let middle = p_texel.floor();
        let first = corner.min(middle - AROUND as f64);
        let last = (corner + *read.end() as f64).max(middle + AROUND as f64);
        for j in first.y as i64..=last.y as i64 {
            for i in first.x as i64..=last.x as i64 {
                let gap = self.gap(map, p, normal, [i, j]);
                probe.gap_around = probe.gap_around.max(gap);
                if read.contains(&(i - corner.x as i64)) && read.contains(&(j - corner.y as i64)) {
                    probe.gap = probe.gap.max(gap);
                }
            }
        }
        probe
    }

    /// Whether a point, relative to the origin, lies within the depths of the map.
    pub fn holds_depth(&self, p: DVec3) -> bool {
        let p4 = p.extend(1.0);
        let (z, w) = (self.rows[2].dot(p4), self.rows[3].dot(p4));
        w > 0.0 && z >= 0.0 && z <= w
    }

    /// To the light: a unit vector.
    fn way_to_light(self, p: DVec3) -> DVec3 {
        (self.light.truncate() - self.light.w * p).normalize_or_zero()
    }

    /// How far along a unit vector clip z / w becomes a value; 0 where it never changes.
    fn way_to_depth(&self, p: DVec3, along: DVec3, z: f64) -> f64 {
        let [_, _, row_z, row_w] = self.rows;
        let (p4, d) = (p.extend(1.0), along.extend(0.0));
        let way = (z * row_w.dot(p4) - row_z.dot(p4)) / (row_z.dot(d) - z * row_w.dot(d));
        if way.is_finite() { way } else { 0.0 }
    }

    /// World size of a texel across the ray, its longer side; 0 where the map is singular.
    fn texel_size(&self, p: DVec3, to_light: DVec3) -> f64 {
        let step = |texel: [f64; 2]| self.on_plane(p, to_light, texel).map_or(0.0, |q| (q - p).length());
        let [row_x, row_y, _, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        let ndc = self.post_warp.apply(DVec3::new(row_x.dot(p4), row_y.dot(p4), 0.0) / w, w);
        let (dx, dy) = (2.0 / f64::from(self.size[0]), 2.0 / f64::from(self.size[1]));
        step([ndc.x + dx, ndc.y]).max(step([ndc.x, ndc.y + dy]))
    }

    /// The point with these NDC x and y on the plane through `p` with a normal.
    fn on_plane(&self, p: DVec3, normal: DVec3, [x, y]: [f64; 2]) -> Option<DVec3> {
        let [row_x, row_y, _, row_w] = self.rows;
        let across = row_x - x * row_w;
        // Linear in (q, 1): its product is zero.
        let along = match self.post_warp {
            PostWarp::None => row_y - y * row_w,
            // y = scale ln w + offset is known, so w is.
            PostWarp::Log { scale, offset } => {
                let w = ((y - offset) / scale).exp();
                row_w - glam::DVec4::W * w
            }
        };
        let m = DMat3::from_cols(across.truncate(), along.truncate(), normal).transpose();
        let q = m.inverse() * DVec3::new(-across.w, -along.w, normal.dot(p));
        q.is_finite().then_some(q)
    }

    /// How far from the receiver's plane towards the light lies what a texel holds; minus infinity for nothing.
    fn gap(&self, map: &[f32], p: DVec3, normal: DVec3, [i, j]: [i64; 2]) -> f64 {
        let [width, height] = self.size.map(i64::from);
        let (i, j) = (i.clamp(0, width - 1), j.clamp(0, height - 1));
        let stored = f64::from(map[(j * width + i) as usize]);
        if stored >= 1.0 {
            return f64::NEG_INFINITY;
        }
        let (x, y) = (2.0 * (i as f64 + 0.5) / width as f64 - 1.0, 1.0 - 2.0 * (j as f64 + 0.5) / height as f64);
        match self.on_plane(p, normal, [x, y]) {
            Some(q) => self.way_to_depth(q, self.way_to_light(q), stored),
            // A plane seen edge on from the light: its depth there is any.
            None => f64::NEG_INFINITY,
        }
    }
}
