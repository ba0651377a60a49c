//! The biased depth that a receiver is compared with: theory.md 13.

use glam::{DVec2, DVec3};

use super::lookup::MapLookup;
use super::parts::Parts;
use super::projected::Projected;
use super::warped::Warped;
use crate::parameterization::PostWarp;
use crate::render::Kernel;

/// A number held to a limit either way; to the limit where it is none.
#[inline(always)]
fn held(x: f64, limit: f64) -> f64 {
    x.max(-limit).min(limit)
}

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
    /// Biased depth, but for the part that each texel has of its own.
    pub z: f64,
    /// The receiver, relative to the origin, moved along its normal; and that.
    p: DVec3,
    normal: DVec3,
    /// Depth without bias.
    pub(super) unbiased: f64,
    /// How depth on the receiver's plane changes with each texel, and how much it may.
    pub(super) plane: PlaneDepth,
    pub(super) limit: f64,
}

/// Depth on a plane about a receiver, by texels from it: theory.md (13.9).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PlaneDepth {
    pub(super) per_texel: DVec2,
    /// Relative change of what depth is divided by; zero where depth is projective.
    divisor: DVec2,
}

impl PlaneDepth {
    /// How much farther the plane is so many texels away; infinitely nearer beyond its horizon.
    #[inline(always)]
    fn change(&self, texels: DVec2) -> f64 {
        let divisor = 1.0 + self.divisor.dot(texels);
        if divisor > 0.0 { self.per_texel.dot(texels) / divisor } else { f64::NEG_INFINITY }
    }
}

impl MapLookup {
    /// Where and with which depth a receiver is compared, `p` relative to the origin, `normal` its unit normal.
    #[inline(always)]
    pub fn compare_at(&self, p: DVec3, normal: DVec3) -> Comparison {
        let (is_compared, reference) = self.compared(self.parts, self.warped_at(p), p, normal);
        if is_compared { Comparison::At(reference) } else { Comparison::Lit }
    }

    /// Whether a receiver is compared, and with what if it is; the map's parts in use and its post-warp are given for kernels that
    /// know them: without branches where they are constants of a common case.
    ///
    /// All derivatives are taken at the receiver itself; the world part of the bias moves it along its light ray, which
    /// leaves its place in the map alone (0.1), so only z and w are evaluated again.
    #[inline(always)]
    pub(super) fn compared(&self, parts: Parts, warped: Warped, p: DVec3, normal: DVec3) -> (bool, Reference) {
        let (mut p, mut at) = (p, self.projected(parts, warped, p));
        let mut is_compared = at.is_inside;
        if parts.normal {
            p += self.bias.normal * at.texel * normal;
            at = self.projected(parts, self.warped_at(p), p);
            is_compared &= at.is_inside;
        }

        // Part 1: along the ray (13.1).
        let shift = self.bias.world + self.bias.texels * at.texel;
        let p4_moved = (p + shift * at.to_light).extend(1.0);
        // Moved past the light, or past the plane through it: nothing can be in between.
        let w_moved = self.rows[3].dot(p4_moved);
        is_compared &= w_moved > 0.0;
        let moved = if parts.is_linear { self.depth.at(p4_moved) } else { self.rows[2].dot(p4_moved) / w_moved };
        let mut z = moved - self.bias.ndc;

        let (kernel, reach) =
            if parts.is_in_pixels { self.kernels.at(p, normal, [at.grad_x, at.grad_y]) } else { self.kernels.even() };

        // Part 2: what the receiver's own plane gains over the filter's reach (13.2). On the plane,
        // grad_z = a grad_x + b grad_y + c normal, so a = dz/dX and b = dz/dY are quotients of triple products.
        let (mut plane, mut limit) = (PlaneDepth::default(), f64::INFINITY);
        if parts.takes_plane {
            let facing = at.cross.dot(normal);
            // A plane seen edge on (det = 0) has no finite slope in the map: the limit alone holds it.
            let is_edge_on = facing == 0.0;
            let per_facing = if is_edge_on { 0.0 } else { 1.0 / facing };
            let (x_normal, y_normal) = (at.grad_x.cross(normal), at.grad_y.cross(normal));
            let on_plane = |g: DVec3| DVec2::new(g.dot(y_normal), -g.dot(x_normal)) * per_facing;
            // How depth on the plane changes per texel; Y grows down.
            plane.per_texel = on_plane(at.grad_z);
            if parts.is_linear && at.grad_divisor != DVec3::ZERO {
                plane.divisor = on_plane(at.grad_divisor);
            }
            let rises = [plane.per_texel.x > 0.0, plane.per_texel.y < 0.0];
            let bends = self.bends(parts, warped, at.plain.truncate(), rises, reach);
            // Along x, and how much farther it is along y.
            let (due, further) = (self.bias.slope * reach.x, reach.y / reach.x);
            if parts.is_limited {
                // What a surface straight across the ray gains, by the change of w alone, carries nothing along the ray.
                let a_across = at.grad_z.dot(at.grad_y.cross(at.to_light)).abs() * bends.largest.x;
                let b_across = at.grad_z.dot(at.grad_x.cross(at.to_light)).abs() * bends.largest.y * further;
                let across = (a_across + b_across) * at.per_det_ray;
                limit = self.bias.slope_limit * at.texel * at.grad_z.dot(at.to_light).abs() + due * across;
            }
            // Without a slope part it is not used, and of linear depth it is dear.
            let gain = if parts.is_linear && self.bias.slope > 0.0 {
                self.bias.slope * self.fall_in_reach(&at, p, normal, &plane, reach)
            } else {
                let falls = plane.per_texel.abs() * bends.falling;
                due * (falls.x + falls.y * further)
            };
            let or_endless = |x: f64| if is_edge_on { f64::INFINITY } else { x };
            z -= if self.bias.slope > 0.0 { or_endless(gain).min(limit) } else { 0.0 };
            if parts.factor {
                z -= held(self.bias.factor * or_endless(plane.per_texel.abs().max_element()), limit);
            }
        }
        if parts.units {
            z -= self.bias.units * self.stored.format.step(at.depth.clamp(0.0, 1.0));
        }
        let (p_texel, unbiased) = (at.p_texel, at.depth);
        (is_compared, Reference { p_texel, kernel, z, p, normal, unbiased, plane, limit })
    }

    /// The depth that the texel with this centre is compared with (13.3), in [0, 1].
    #[inline(always)]
    pub fn depth_at(&self, reference: &Reference, centre: DVec2) -> f64 {
        // (13.3), (13.9)
        let change = match &self.post_warp {
            _ if self.bias.plane == 0.0 => 0.0,
            PostWarp::None => reference.plane.change(centre - reference.p_texel),
            _ => self.change_on_plane(reference.p, reference.normal, reference.unbiased, centre),
        };
        self.depth_beside(reference.z, change, reference.limit)
    }

    /// The depth that a texel is compared with where the receiver's plane is so much farther than at the receiver: theory.md (13.3).
    ///
    /// Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's depth:
    /// nearer than the near plane is what lies there itself.
    #[inline(always)]
    pub(super) fn depth_beside(&self, z: f64, change: f64, limit: f64) -> f64 {
        let beside = z + self.bias.plane * held(change, limit);
        (if self.bias.plane == 0.0 { z } else { beside }).clamp(0.0, 1.0)
    }

    /// A depth that is at least that of [`MapLookup::depth_at`] for each texel whose centre lies within reach of the receiver.
    pub(super) fn farthest_within(&self, reference: &Reference, reach: DVec2) -> f64 {
        if self.bias.plane == 0.0 {
            return reference.z.clamp(0.0, 1.0);
        }
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * reach);
        let is_before_horizon = |texels: &DVec2| 1.0 + reference.plane.divisor.dot(*texels) > 0.0;
        // A quotient of affine functions is largest at a corner, unless it has a pole in between.
        let change = match &self.post_warp {
            PostWarp::None if corners.iter().all(is_before_horizon) => {
                corners.iter().fold(0.0, |most: f64, texels| most.max(reference.plane.change(*texels)))
            }
            _ => f64::INFINITY,
        };
        // Roundings of the change of depth at a texel between the corners.
        let change = self.bias.plane * change.min(reference.limit) * (1.0 + 16.0 * f64::EPSILON);
        (reference.z + change + 16.0 * f64::EPSILON).clamp(0.0, 1.0)
    }

    /// How much farther the plane of a receiver, at a depth, is at another place of the map; 0 where it is seen edge on.
    fn change_on_plane(&self, p: DVec3, normal: DVec3, depth: f64, place: DVec2) -> f64 {
        let Some(q) = self.on_plane_at(p, normal, place) else { return 0.0 };
        let z = self.depth.at(q.extend(1.0));
        if z.is_finite() { z - depth } else { 0.0 }
    }

    /// How much linear depth falls at most on a receiver's plane within the filter's reach: a quotient of affine functions is least
    /// at a corner (13.9), and post-warps turn rectangles into rectangles.
    fn fall_in_reach(&self, at: &Projected, p: DVec3, normal: DVec3, plane: &PlaneDepth, reach: DVec2) -> f64 {
        let fall = |x: f64, y: f64| {
            let texels = DVec2::new(x, y) * reach;
            -match &self.post_warp {
                PostWarp::None => plane.change(texels),
                _ => self.change_on_plane(p, normal, at.depth, at.p_texel + texels),
            }
        };
        fall(-1.0, -1.0).max(fall(1.0, -1.0)).max(fall(-1.0, 1.0)).max(fall(1.0, 1.0)).max(0.0)
    }
}
