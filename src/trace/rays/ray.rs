//! Rays made ready for one frame: f64 for triangles, f32 with error bounds for boxes. One, or several side by side.
//!
//! Triangles: the shear of Woop, Benthin, Wald 2013 `[woop2013]` (watertight ray/triangle intersection), in f64.
//! Boxes: slabs in f32. A far origin is first moved to where the ray enters the tree's box, in f64, so that what is
//! rounded to f32 has magnitude about 1 however far away the ray begins; boxes then grow by [`LocalRays::new`]'s `pad`,
//! a bound on everything that was rounded, and the far side by a relative bound (Ize 2013 `[ize2013]`,
//! robust BVH ray traversal). A box that holds a triangle the ray meets is therefore never missed.

use glam::{DAffine3, DVec3};

use crate::trace::hierarchy::{Box3, power_of_two_near};

/// Bound on the roundings of a slab test relative to its result: direction to f32, its inverse, the product and the sum,
/// 2^-24 each, on either side of the comparison; 12 of them are above those eight.
pub const SLAB_SLACK: f32 = 1.0 + 6.0 * f32::EPSILON;
/// Direction components below this share of the largest are raised to it, which keeps inverses finite. Over a path of
/// length 64 in a box of size 2 that moves the ray by 2^-54, far below `pad`.
const SMALLEST_COMPONENT: f64 = 1.0 / (1u64 << 60) as f64;
/// Bound on f32 roundings in the box test, relative to the largest of origin and box: origin to f32, its product with
/// the inverse direction, and the plane's, 2^-24 each; four cover that what is rounded includes the pad.
const F32_PAD: f64 = 4.0 * (f32::EPSILON as f64 / 2.0);
/// Bound on f64 roundings in entering the box and in the triangle test, relative to the origin's magnitude: fewer than
/// eight operations of 2^-53.
const F64_PAD: f64 = 4.0 * f64::EPSILON;
/// How far from a triangle, in bands, the test of the band can say that it is near: the shear stretches by up to sqrt(3)
/// ([`LocalRays::new`]), and the length of an edge is bounded by a sum, up to sqrt(2) of it. Boxes grow by as much, so that
/// what is near does not depend on which triangles share a box.
const BAND_REACH: f64 = 2.449_489_742_783_178;
/// Origins farther out than this are moved to the tree's box first. Nearer ones are not worth the time: the pad for them
/// is 4e-6 of the box at most, far below the size of a triangle that many share a mesh with.
const NEAR_ORIGIN: f64 = 16.0;

/// A ray in the world, relative to the scene's origin.
#[derive(Debug, Clone, Copy)]
pub struct WorldRay {
    pub origin: DVec3,
    pub direction: DVec3,
}

/// What the test of triangles needs of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Origin, axes permuted so that the direction's largest component comes last.
    pub origin: [f64; 3],
    /// The permutation: `axes[2]` is the direction's largest axis.
    pub axes: [usize; 3],
    /// Shear: `x' = x - shear[0] * z` and `y' = y - shear[1] * z` put the ray on the z axis.
    pub shear: [f64; 2],
    /// `t = z * t_per_z`.
    pub t_per_z: f64,
    /// Half-width of the band about triangle edges that counts as "near", in sheared coordinates.
    pub band: f64,
}

/// Rays in one frame whose directions share their largest axis and their signs: `[axis][ray]`. The parameter `t` is the
/// caller's. A ray's numbers do not depend on how many it is among.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub struct LocalRays<const N: usize> {
    /// The inverse direction, and its product with the padded origin for the plane met first and last.
    pub inverse: [[f32; N]; 3],
    pub first_offset: [[f32; N]; 3],
    pub last_offset: [[f32; N]; 3],
    /// The padded origin for the plane met first and last.
    pub first_origin: [[f32; N]; 3],
    pub last_origin: [[f32; N]; 3],
    /// Index into [`Node::planes`](crate::trace::hierarchy::Node::planes) of the plane met first; the other is this ^ 1.
    pub first_plane: [usize; 3],
    /// As in [`Line`].
    axes: [usize; 3],
    origin: [[f64; N]; 3],
    shear: [[f64; N]; 2],
    t_per_z: [f64; N],
    band: f64,
    /// `s = t * s_per_t - s_entry` is the slab test's parameter.
    s_per_t: [f64; N],
    s_entry: [f64; N],
}

/// One ray.
pub type LocalRay = LocalRays<1>;

impl<const N: usize> LocalRays<N> {
    /// The rays `origin + t * direction` taken into a frame, each with its `t_min` and `t_max`; and which of those
    /// asked for (bits) have their largest axis and signs in common with the first, and which of the others remain.
    /// Left out are those that miss `bounds`, grown by the reach of `band` (both in the frame's unit).
    #[inline(always)]
    pub fn new(
        local_from_world: &DAffine3,
        bounds: &Box3,
        rays: &[WorldRay; N],
        ranges: &[[f64; 2]; N],
        band: f64,
        asked: u32,
    ) -> (Self, u32, u32) {
        let linear = local_from_world.matrix3.to_cols_array_2d();
        let moved = local_from_world.translation.to_array();
        let from_world: [[f64; N]; 3] = std::array::from_fn(|a| std::array::from_fn(|r| rays[r].origin[a]));
        let towards_world: [[f64; N]; 3] = std::array::from_fn(|a| std::array::from_fn(|r| rays[r].direction[a]));
        let turned = |v: &[[f64; N]; 3], a: usize, r: usize| {
            (linear[0][a] * v[0][r] + linear[1][a] * v[1][r]) + linear[2][a] * v[2][r]
        };
        let (mut origin, mut direction) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        for a in 0..3 {
            for r in 0..N {
                origin[a][r] = turned(&from_world, a, r) + moved[a];
                direction[a][r] = turned(&towards_world, a, r);
            }
        }
        let largest_of = |v: &[[f64; N]; 3]| -> [f64; N] {
            std::array::from_fn(|r| larger(larger(v[0][r].abs(), v[1][r].abs()), v[2][r].abs()))
        };
        let (reach, size) = (largest_of(&origin), largest_of(&direction));
        // Otherwise so far out of this frame's scale that nothing in it has any extent.
        let has_scale = |r: usize| size[r] > 0.0 && size[r].is_finite() && reach[r].is_finite();
        let mut alive = (0..N).fold(0, |bits, r| bits | (u32::from(has_scale(r)) << r)) & asked;
        let scale = size.map(power_of_two_near);
        let per_scale = scale.map(f64::recip);
        let unit: [[f64; N]; 3] = std::array::from_fn(|a| std::array::from_fn(|r| direction[a][r] * per_scale[r]));
        let raised = |x: f64| if x.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(x) } else { x };
        let slab = unit.map(|axis| axis.map(raised));

        let (mut entered, mut entry) = (origin, [0.0; N]);
        let band_reach = BAND_REACH * band;
        let mut pad = reach.map(|reach| F32_PAD * larger(reach, 1.0) + F64_PAD * reach + band_reach);
        if (0..N).any(|r| reach[r] > NEAR_ORIGIN) {
            // Where the rays enter the padded box, in units of `unit`. The entered points have magnitude 1 and the pad.
            let (low, high) = (bounds.min.as_dvec3().to_array(), bounds.max.as_dvec3().to_array());
            for r in (0..N).filter(|&r| reach[r] > NEAR_ORIGIN) {
                pad[r] = 2.0 * F32_PAD + F64_PAD * reach[r] + band_reach;
                let [t_min, t_max] = ranges[r].map(|t| t * scale[r]);
                let (mut first, mut last) = (t_min, t_max);
                for a in 0..3 {
                    let inverse = slab[a][r].recip();
                    let (s, t) =
                        ((low[a] - pad[r] - origin[a][r]) * inverse, (high[a] + pad[r] - origin[a][r]) * inverse);
                    (first, last) = (first.max(s.min(t)), last.min(s.max(t)));
                }
                // Both err by less than the pad's own F64_PAD share.
                if !(first <= last && first.is_finite()) {
                    alive &= !(1 << r);
                }
                entry[r] = first;
                (0..3).for_each(|a| entered[a][r] = origin[a][r] + unit[a][r] * first);
            }
        }
        let leader = alive.trailing_zeros() as usize % N;
        let backward: [usize; 3] = std::array::from_fn(|a| usize::from(slab[a][leader] < 0.0));
        let axis_of = |r: usize| {
            let [x, y, z] = [0, 1, 2].map(|a: usize| unit[a][r].abs());
            if x >= y && x >= z {
                0
            } else if y >= z {
                1
            } else {
                2
            }
        };
        let last = axis_of(leader);
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let joins = |r: usize| (0..3).all(|a| (slab[a][r] < 0.0) == (backward[a] != 0)) & (axis_of(r) == last);
        let together = (0..N).fold(0, |bits, r| bits | (u32::from(joins(r)) << r)) & alive;

        let mut out = Self {
            inverse: slab.map(|axis| axis.map(|x| 1.0 / x as f32)),
            first_offset: [[0.0; N]; 3],
            last_offset: [[0.0; N]; 3],
            first_origin: [[0.0; N]; 3],
            last_origin: [[0.0; N]; 3],
            first_plane: [backward[0], 2 + backward[1], 4 + backward[2]],
            axes,
            origin: axes.map(|a| origin[a]),
            shear: [[0.0; N]; 2],
            t_per_z: [0.0; N],
            // A displacement of length b moves a sheared point by at most b * sqrt(1 + 1 + 1): both shears are at
            // most 1.
            band: band * 3f64.sqrt(),
            s_per_t: scale,
            s_entry: entry,
        };
        for a in 0..3 {
            for r in 0..N {
                let padding = pad[r].copysign(slab[a][r]);
                out.first_origin[a][r] = (entered[a][r] + padding) as f32;
                out.last_origin[a][r] = (entered[a][r] - padding) as f32;
                out.first_offset[a][r] = out.first_origin[a][r] * out.inverse[a][r];
                out.last_offset[a][r] = out.last_origin[a][r] * out.inverse[a][r];
            }
        }
        for r in 0..N {
            let per_z = unit[last][r].recip();
            out.shear[0][r] = unit[axes[0]][r] * per_z;
            out.shear[1][r] = unit[axes[1]][r] * per_z;
            out.t_per_z[r] = per_z * per_scale[r];
        }
        (out, together, alive & !together)
    }
    /// What the test of triangles needs of one of the rays.
    #[inline(always)]
    pub fn line(&self, ray: usize) -> Line {
        Line {
            origin: self.origin.map(|axis| axis[ray]),
            axes: self.axes,
            shear: self.shear.map(|axis| axis[ray]),
            t_per_z: self.t_per_z[ray],
            band: self.band,
        }
    }
    /// An upper bound of the slab parameter for `t` on one of the rays.
    #[inline(always)]
    pub fn slab_limit(&self, ray: usize, t: f64) -> f32 {
        // Negative only where t lies before the entry: nothing there, and the slab test's own floor of zero says so.
        (t * self.s_per_t[ray] - self.s_entry[ray]) as f32 * SLAB_SLACK
    }
}

/// Of numbers that are not NaN: one instruction, which `f64::max` is not.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
