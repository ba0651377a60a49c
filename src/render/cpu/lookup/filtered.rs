//! The light that a filter makes of comparisons: theory.md 14.

use glam::{DVec2, DVec3};

use super::comparison::Comparison;
use super::lookup::MapLookup;
use crate::render::Filter;

impl MapLookup {
    /// The share of light, 0 to 1, that arrives at a receiver which faces the light and is within its reach; `map` has
    /// rows from the top.
    pub fn light(&self, map: &[f32], p: DVec3, normal: DVec3) -> f32 {
        let Comparison::At(reference) = self.compare_at(p, normal) else { return 1.0 };
        let p_texel = reference.p_texel;
        let [width, height] = self.size;
        // Clamp to edge. Casts saturate.
        let lit = |i: i64, j: i64| -> f64 {
            // Of a texel beyond the edge, the plane where it would be.
            let z = self.depth_at(&reference, DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
            let i = i.clamp(0, i64::from(width) - 1) as usize;
            let j = j.clamp(0, i64::from(height) - 1) as usize;
            f64::from(u8::from(f64::from(map[j * width as usize + i]) >= z))
        };
        match self.filter {
            Filter::Nearest => lit(p_texel.x.floor() as i64, p_texel.y.floor() as i64) as f32,
            Filter::Pcf2x2 => {
                // Weights between the four texel centres around the point.
                let corner = (p_texel - 0.5).floor();
                let f = p_texel - 0.5 - corner;
                let (i, j) = (corner.x as i64, corner.y as i64);
                let top = (1.0 - f.x) * lit(i, j) + f.x * lit(i + 1, j);
                let bottom = (1.0 - f.x) * lit(i, j + 1) + f.x * lit(i + 1, j + 1);
                ((1.0 - f.y) * top + f.y * bottom) as f32
            }
        }
    }
}
