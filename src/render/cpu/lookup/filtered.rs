//! The light that a filter makes of comparisons: theory.md 14.

use glam::{DVec2, DVec3};

use super::comparison::{Comparison, Reference};
use super::lookup::MapLookup;
use crate::render::{Kernel, Tap, bilinear};

impl MapLookup {
    /// The share of light, 0 to 1, that arrives at a receiver which faces the light and is within its reach; `map` has
    /// rows from the top.
    pub fn light(&self, map: &[f32], p: DVec3, normal: DVec3) -> f32 {
        let Comparison::At(reference) = self.compare_at(p, normal) else { return 1.0 };
        match reference.kernel {
            Kernel::Nearest => {
                let at = reference.p_texel.floor();
                self.lit(map, &reference, at.x as i64, at.y as i64) as f32
            }
            Kernel::Bilinear => bilinear(reference.p_texel, |i, j| self.lit(map, &reference, i, j)) as f32,
            _ => self.wide_light(map, reference),
        }
    }

    /// That of kernels that compare many texels: by itself and by a copy, so that the reference of the others stays in registers.
    #[inline(never)]
    fn wide_light(&self, map: &[f32], reference: Reference) -> f32 {
        let lit = |i: i64, j: i64| self.lit(map, &reference, i, j);
        reference.kernel.average(self.kernels.disc(), reference.p_texel, lit) as f32
    }

    /// 1 where the stored depth of a texel is at least that of the receiver there, else 0. Clamp to edge.
    #[inline(always)]
    fn lit(&self, map: &[f32], reference: &Reference, i: i64, j: i64) -> f64 {
        let [width, height] = self.size;
        // Of a texel beyond the edge, the plane where it would be.
        let z = self.depth_at(reference, DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
        let i = i.clamp(0, i64::from(width) - 1) as usize;
        let j = j.clamp(0, i64::from(height) - 1) as usize;
        f64::from(u8::from(f64::from(map[j * width as usize + i]) >= z))
    }

    /// The texels that a lookup about a place reads for a receiver without bias.
    pub fn taps_at(&self, p: DVec3, normal: DVec3, place: DVec2) -> Vec<Tap> {
        self.kernel_at(p, normal).taps(self.kernels.disc(), place)
    }

    /// Calls `read` with the column and row of each of them.
    pub fn texels_at(&self, p: DVec3, normal: DVec3, place: DVec2, read: &mut dyn FnMut([i64; 2])) {
        match self.kernel_at(p, normal) {
            Kernel::Nearest => read(Kernel::nearest(place)),
            kernel => kernel.taps(self.kernels.disc(), place).iter().for_each(|tap| read(tap.texel)),
        }
    }

    /// How far from a receiver without bias the centre of a texel that is compared can lie along each axis, texels.
    pub fn reach_at(&self, p: DVec3, normal: DVec3) -> DVec2 {
        self.kernel_at(p, normal).reach()
    }

    /// The kernel at a receiver without bias; outside of the map, and before its near plane, it is lit without one.
    fn kernel_at(&self, p: DVec3, normal: DVec3) -> Kernel {
        self.kernels.fixed().unwrap_or_else(|| {
            let at = self.projected(self.parts, self.warped_at(p), p);
            if at.is_inside { self.kernels.at(p, normal, [at.grad_x, at.grad_y]).0 } else { Kernel::Nearest }
        })
    }

    /// The texels that [`MapLookup::light`] compares a receiver with.
    pub fn taps(&self, reference: &Reference) -> Vec<Tap> {
        reference.kernel.taps(self.kernels.disc(), reference.p_texel)
    }
}
