//! The light that a filter makes of comparisons: theory.md 14.

use glam::{DVec2, DVec3};

use super::comparison::{Comparison, Reference};
use super::lookup::MapLookup;
use super::projected::Projected;
use crate::render::{Kernel, Tap};

impl MapLookup {
    /// The share of light, 0 to 1, that arrives at a receiver which faces the light and is within its reach; `map` has
    /// rows from the top.
    pub fn light(&self, map: &[f32], p: DVec3, normal: DVec3) -> f32 {
        let Comparison::At(reference) = self.compare_at(p, normal) else { return 1.0 };
        let [width, height] = self.size;
        // Clamp to edge.
        let lit = |i: i64, j: i64| -> f64 {
            // Of a texel beyond the edge, the plane where it would be.
            let z = self.depth_at(&reference, DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
            let i = i.clamp(0, i64::from(width) - 1) as usize;
            let j = j.clamp(0, i64::from(height) - 1) as usize;
            f64::from(u8::from(f64::from(map[j * width as usize + i]) >= z))
        };
        reference.kernel.average(self.kernels.disc(), reference.p_texel, lit) as f32
    }

    /// The texels that a lookup about a place reads for a receiver without bias.
    pub fn taps_at(&self, p: DVec3, normal: DVec3, place: DVec2) -> Vec<Tap> {
        self.kernel_at(p, normal).taps(self.kernels.disc(), place)
    }

    /// How far from a receiver without bias the centre of a texel that is compared can lie along each axis, texels.
    pub fn reach_at(&self, p: DVec3, normal: DVec3) -> DVec2 {
        self.kernel_at(p, normal).reach()
    }

    /// The kernel at a receiver without bias; outside of the map, and before its near plane, it is lit without one.
    fn kernel_at(&self, p: DVec3, normal: DVec3) -> Kernel {
        let at = |at: Projected| self.kernels.at(p, normal, [at.grad_x, at.grad_y]).0;
        self.kernels.fixed().or_else(|| self.projected(p).map(at)).unwrap_or(Kernel::Nearest)
    }

    /// The texels that [`MapLookup::light`] compares a receiver with.
    pub fn taps(&self, reference: &Reference) -> Vec<Tap> {
        reference.kernel.taps(self.kernels.disc(), reference.p_texel)
    }
}
