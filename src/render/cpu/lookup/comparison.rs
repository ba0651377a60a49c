//! The biased depth that a receiver is compared with: theory.md 13.

use glam::{DVec2, DVec3};

use super::lookup::MapLookup;
use crate::parameterization::PostWarp;
use crate::render::Kernel;

/// How a receiver is to be compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Comparison {
    /// Lit without a look at the map: outside of it, behind its projection centre, or nearer than its near plane.
    Lit,
    /// Lit where the stored depth is at least [`MapLookup::depth_at`] of the texel.
    At(Reference),
}

/// A receiver that is compared with texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Where in the map.
    pub p_texel: DVec2,
    /// The texels that are compared.
    pub kernel: Kernel,
    /// Biased NDC depth, but for the part that each texel has of its own.
    pub z: f64,
    /// The receiver, relative to the origin, moved along its normal; and that.
    p: DVec3,
    normal: DVec3,
    /// NDC depth without bias.
    unbiased: f64,
    /// What depth on the receiver's plane changes by with each texel, and how much it may.
    per_texel: DVec2,
    limit: f64,
}

impl MapLookup {
    /// Where and with which depth a receiver is compared, `p` relative to the origin, `normal` its unit normal.
    ///
    /// All derivatives are taken at the receiver itself; the world part of the bias moves it along its light ray, which
    /// leaves its place in the map alone (0.1), so only z and w are evaluated again.
    pub fn compare_at(&self, p: DVec3, normal: DVec3) -> Comparison {
        let Some(mut at) = self.projected(p) else { return Comparison::Lit };
        let mut p = p;
        if self.bias.normal != 0.0 {
            p += self.bias.normal * at.texel * normal;
            let Some(moved) = self.projected(p) else { return Comparison::Lit };
            at = moved;
        }
        let [_, _, row_z, row_w] = self.rows;

        // Part 1: along the ray (13.1).
        let shift = self.bias.world + self.bias.texels * at.texel;
        let p4_moved = (p + shift * at.to_light).extend(1.0);
        let w_moved = row_w.dot(p4_moved);
        // Moved past the light, or past the plane through it: nothing can be in between.
        if !(w_moved > 0.0) {
            return Comparison::Lit;
        }
        let mut z = row_z.dot(p4_moved) / w_moved - self.bias.ndc;

        let (kernel, reach) = self.kernels.at(p, normal, [at.grad_x, at.grad_y]);

        // Part 2: what the receiver's own plane gains over the filter's reach (13.2). On the plane,
        // grad_z = a grad_x + b grad_y + c normal, so a = dz/dX and b = dz/dY are quotients of triple products.
        let (mut per_texel, mut limit) = (DVec2::ZERO, f64::INFINITY);
        if self.bias.slope > 0.0 || self.bias.plane > 0.0 {
            let facing = at.cross.dot(normal);
            let [a_det, b_det] = [at.grad_z.dot(at.grad_y.cross(normal)), -at.grad_z.dot(at.grad_x.cross(normal))];
            // On the plane, depth changes by these per texel, times det; Y grows down.
            let bends = self.bends(at.plain.truncate(), [a_det * facing > 0.0, b_det * facing < 0.0], reach);
            // Along x, and how much farther it is along y.
            let (reach, further) = (self.bias.slope * reach.x, reach.y / reach.x);
            if self.bias.slope_limit.is_finite() {
                // What a surface straight across the ray gains, by the change of w alone, carries nothing along the ray.
                let a_across = at.grad_z.dot(at.grad_y.cross(at.to_light)).abs() * bends.largest.x;
                let b_across = at.grad_z.dot(at.grad_x.cross(at.to_light)).abs() * bends.largest.y * further;
                let across = if at.det_ray > 0.0 { (a_across + b_across) / at.det_ray } else { 0.0 };
                limit = self.bias.slope_limit * at.texel * at.grad_z.dot(at.to_light).abs() + reach * across;
            }
            // A plane seen edge on (det = 0) has no finite slope in the map: the limit alone holds it.
            let is_edge_on = facing == 0.0;
            if self.bias.slope > 0.0 {
                let gain = (a_det.abs() * bends.falling.x + b_det.abs() * bends.falling.y * further) / facing.abs();
                z -= (reach * if is_edge_on { f64::INFINITY } else { gain }).min(limit);
            }
            if !is_edge_on {
                per_texel = DVec2::new(a_det, b_det) / facing;
            }
        }
        let (p_texel, unbiased) = (at.p_texel, at.ndc.z);
        Comparison::At(Reference { p_texel, kernel, z, p, normal, unbiased, per_texel, limit })
    }

    /// The depth that the texel with this centre is compared with (13.3), in [0, 1].
    ///
    /// Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's depth:
    /// nearer than the near plane is what lies there itself.
    #[inline(always)]
    pub fn depth_at(&self, reference: &Reference, centre: DVec2) -> f64 {
        if self.bias.plane == 0.0 {
            return reference.z.clamp(0.0, 1.0);
        }
        let change = match &self.post_warp {
            // NDC depth is affine on the plane.
            PostWarp::None => reference.per_texel.dot(centre - reference.p_texel),
            _ => self.change_on_plane(reference, centre),
        };
        (reference.z + self.bias.plane * change.clamp(-reference.limit, reference.limit)).clamp(0.0, 1.0)
    }

    /// How much farther the receiver's plane is at another place of the map; 0 where it is seen edge on.
    fn change_on_plane(&self, reference: &Reference, place: DVec2) -> f64 {
        let [_, _, row_z, row_w] = self.rows;
        let Some(q) = self.on_plane_at(reference.p, reference.normal, place) else { return 0.0 };
        let z = row_z.dot(q.extend(1.0)) / row_w.dot(q.extend(1.0));
        if z.is_finite() { z - reference.unbiased } else { 0.0 }
    }
}
