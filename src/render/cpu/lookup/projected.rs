//! A receiver in a map, and how what it is there changes about it: theory.md 0, (E.5).

use glam::{DVec2, DVec3, DVec4};

use super::lookup::MapLookup;
use super::parts::Parts;
use super::warped::Warped;

/// A receiver in a map, with how what it is there changes about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    /// Whether the map has it, not before its near plane: elsewhere the rest means nothing.
    pub(super) is_inside: bool,
    pub(super) p_texel: DVec2,
    /// Before the post-warp.
    pub(super) plain: DVec3,
    /// Its depth in the units of what is stored: NDC z where that is projective.
    pub(super) depth: f64,
    /// Gradients in world space: of the texel coordinates X and Y (down), and of that depth.
    pub(super) grad_x: DVec3,
    pub(super) grad_y: DVec3,
    pub(super) grad_z: DVec3,
    /// The relative gradient of what depth on a plane is divided by, an affine function of the place in a projective map;
    /// zero where depth is projective.
    pub(super) grad_divisor: DVec3,
    /// The cross product of the first two.
    pub(super) cross: DVec3,
    /// One over its part along the ray; 0 where it has none.
    pub(super) per_det_ray: f64,
    /// To the light: a unit vector, whether the light is placed or at infinity.
    pub(super) to_light: DVec3,
    /// World size of a texel across the ray, its longer side.
    pub(super) texel: f64,
}

impl MapLookup {
    /// The receiver in the map, whose post-warp and parts in use are given for kernels that know them: without branches where
    /// they are constants.
    #[inline(always)]
    pub(super) fn projected(&self, parts: Parts, warped: Warped, p: DVec3) -> Projected {
        let [row_x, row_y, row_z, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        let plain = DVec3::new(row_x.dot(p4), row_y.dot(p4), row_z.dot(p4)) / w;
        let ndc = warped.apply(plain);
        let (u, v) = (0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        let within = |x: f64| x.clamp(0.0, 1.0) == x;
        // A NaN (of a matrix at the limits of f64) is outside.
        let is_inside = (w > 0.0) & (ndc.z >= 0.0) & within(u) & within(v);
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        // (E.5), quotient rule.
        let per_w = 1.0 / w;
        let gradient = |row: DVec4, value: f64| (row.truncate() - value * row_w.truncate()) * per_w;
        let (mut grad_x, mut grad_y) = (gradient(row_x, plain.x), gradient(row_y, plain.y));
        match warped {
            Warped::None => {}
            Warped::Log { scale, .. } => grad_y = row_w.truncate() * (scale * per_w),
            Warped::Rectilinear(warp) => {
                let slopes = warp.slopes(plain.truncate());
                (grad_x, grad_y) = (grad_x * slopes.x, grad_y * slopes.y);
            }
        }
        let (grad_x, grad_y) = (grad_x * (0.5 * size.x), grad_y * (-0.5 * size.y));
        let to_light = if parts.is_placed { self.way_to_light(p) } else { self.light.truncate() };
        let cross = grad_x.cross(grad_y);
        // A texel seen along the ray is a parallelogram whose sides are the columns of the inverse of [grad_x; grad_y] across
        // the ray; their lengths are |grad_y|/|det| and |grad_x|/|det|.
        let longer = grad_x.cross(to_light).length_squared().max(grad_y.cross(to_light).length_squared()).sqrt();
        let det_ray = cross.dot(to_light).abs();
        // det = 0 means that the matrix does not belong to this light; a texel then has no size to speak of.
        let per_det_ray = if det_ray > 0.0 { 1.0 / det_ray } else { 0.0 };
        let texel = longer * per_det_ray;
        let p_texel = DVec2::new(u, v) * size;
        let (depth, grad_z, grad_divisor) = if parts.is_linear {
            let (depth, divisor) = (self.depth.at(p4), self.depth.denominator);
            // A point of the plane is an affine function of its place over 1 / w (theory.md (13.9)).
            let grad_divisor = divisor.truncate() / divisor.dot(p4) - row_w.truncate() * per_w;
            (depth, self.depth.gradient(p4, depth), grad_divisor)
        } else {
            // What `self.depth` says, of numbers that are there.
            (ndc.z, gradient(row_z, ndc.z), DVec3::ZERO)
        };
        Projected {
            is_inside,
            p_texel,
            plain,
            depth,
            grad_x,
            grad_y,
            grad_z,
            grad_divisor,
            cross,
            per_det_ray,
            to_light,
            texel,
        }
    }
}

/// How far a plane's depth changes over the filter's reach along the map's x and y, in units of what its slope says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bends {
    /// The way on which it falls.
    pub(super) falling: DVec2,
    /// Either way, the larger one.
    pub(super) largest: DVec2,
}

impl MapLookup {
    /// Of a place before the post-warp, of a plane whose depth rises along x, and along y up, or falls; over a reach in texels.
    #[inline(always)]
    pub(super) fn bends(&self, parts: Parts, warped: Warped, at: DVec2, rises: [bool; 2], reach: DVec2) -> Bends {
        match warped {
            Warped::None => Bends { falling: DVec2::ONE, largest: DVec2::ONE },
            Warped::Log { scale, .. } => {
                let rises_with_w = rises[1] == (scale > 0.0);
                let [rising, falling] = if parts.is_in_pixels { self.bend_over(reach.y) } else { self.bend };
                let along = if rises_with_w { rising } else { falling };
                Bends { falling: DVec2::new(1.0, along), largest: DVec2::new(1.0, rising.max(falling)) }
            }
            // Depth is affine before the warp: what counts is how far the reach goes there.
            Warped::Rectilinear(warp) => {
                let reach = 2.0 * reach / DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
                if reach == DVec2::ZERO {
                    return Bends { falling: DVec2::ONE, largest: DVec2::ONE };
                }
                let (after, per_reach) = (warp.after(at), warp.slopes(at) / reach);
                let back = (at - warp.before(after - reach)) * per_reach;
                let on = (warp.before(after + reach) - at) * per_reach;
                let falling = |axis: usize| if rises[axis] { back[axis] } else { on[axis] };
                Bends { falling: DVec2::new(falling(0), falling(1)), largest: back.max(on) }
            }
        }
    }
}
