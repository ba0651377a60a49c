//! A ray made ready for one frame: f64 for triangles, f32 with error bounds for boxes.
//!
//! Triangles: the shear of S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013, in f64.
//! Boxes: slabs in f32. A far origin is first moved to where the ray enters the tree's box, in f64, so that what is
//! rounded to f32 has magnitude about 1 however far away the ray begins; boxes then grow by [`LocalRay::new`]'s `pad`,
//! a bound on everything that was rounded, and the far side by a relative bound (T. Ize, "Robust BVH ray traversal",
//! JCGT 2(2), 2013). A box that holds a triangle the ray meets is therefore never missed.

use glam::{DAffine3, DVec3, Vec3A};

use super::frame::power_of_two_near;
use super::tree::Box3;

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
/// Origins farther out than this are moved to the tree's box first. Nearer ones are not worth the time: the pad for them
/// is 4e-6 of the box at most, far below the size of a triangle that many share a mesh with.
const NEAR_ORIGIN: f64 = 16.0;

/// One ray in one frame. Its parameter `t` is the caller's.
#[derive(Debug, Clone, Copy)]
pub struct LocalRay {
    /// Origin, axes permuted so that the direction's largest component comes last.
    pub origin: [f64; 3],
    /// The permutation: `axes[2]` is the direction's largest axis.
    pub axes: [usize; 3],
    /// Shear: x' = x - shear[0] * z and y' = y - shear[1] * z put the ray on the z axis.
    pub shear: [f64; 2],
    /// `t = z * t_per_z`.
    pub t_per_z: f64,
    /// Half-width of the band about triangle edges that counts as "near", in sheared coordinates.
    pub band: f64,
    /// Per axis: the inverse direction, and its product with the padded origin for the plane met first and last.
    pub inverse: [f32; 3],
    pub first_offset: [f32; 3],
    pub last_offset: [f32; 3],
    /// Index into [`super::tree::Node::planes`] of the plane met first; the other is this ^ 1.
    pub first_plane: [usize; 3],
    /// `s = t * s_per_t - s_entry` is the slab test's parameter.
    s_per_t: f64,
    s_entry: f64,
}

impl LocalRay {
    /// The ray `origin + t * direction` taken into a frame, or none where it misses `bounds` between `t_min` and
    /// `t_max`, grown by `band` (all in the frame's unit).
    #[inline(always)]
    pub fn new(
        local_from_world: &DAffine3,
        bounds: &Box3,
        origin: DVec3,
        direction: DVec3,
        [t_min, t_max]: [f64; 2],
        band: f64,
    ) -> Option<Self> {
        let origin = local_from_world.transform_point3(origin);
        let direction = local_from_world.transform_vector3(direction);
        let size = direction.abs().max_element();
        if !(size > 0.0 && size.is_finite() && origin.is_finite()) {
            // So far out of this frame's scale that nothing in it has any extent.
            return None;
        }
        let scale = power_of_two_near(size);
        let per_scale = scale.recip();
        let unit = direction * per_scale;
        let reach = origin.abs().max_element();
        let floor = SMALLEST_COMPONENT;
        let slab = DVec3::from_array(unit.to_array().map(|x| if x.abs() < floor { floor.copysign(x) } else { x }));

        let (mut entered, mut entry) = (origin, 0.0);
        let mut pad = F32_PAD * reach.max(1.0) + F64_PAD * reach + band;
        if reach > NEAR_ORIGIN {
            // Where the ray enters the padded box, in units of `unit`. The entered point has magnitude 1 and the pad.
            pad = 2.0 * F32_PAD + F64_PAD * reach + band;
            let inverse = DVec3::ONE / slab;
            let low = (bounds.min.as_dvec3() - pad - origin) * inverse;
            let high = (bounds.max.as_dvec3() + pad - origin) * inverse;
            entry = low.min(high).max_element().max(t_min * scale);
            let exit = low.max(high).min_element().min(t_max * scale);
            // Both err by less than the pad's own F64_PAD share.
            if !(entry <= exit && entry.is_finite()) {
                return None;
            }
            entered = origin + unit * entry;
        }
        let inverse = Vec3A::ONE / slab.as_vec3a();
        let out = DVec3::splat(pad).copysign(slab);
        let first_offset = (entered + out).as_vec3a() * inverse;
        let last_offset = (entered - out).as_vec3a() * inverse;

        let u = unit.abs();
        let largest = if u.x >= u.y && u.x >= u.z {
            0
        } else if u.y >= u.z {
            1
        } else {
            2
        };
        let axes = [(largest + 1) % 3, (largest + 2) % 3, largest];
        let o = origin.to_array();
        let d = unit.to_array();
        let per_z = d[largest].recip();
        let backward = |axis: usize| usize::from(slab[axis] < 0.0);
        Some(Self {
            origin: axes.map(|axis| o[axis]),
            axes,
            shear: [d[axes[0]] * per_z, d[axes[1]] * per_z],
            t_per_z: per_z * per_scale,
            // A displacement of length b moves a sheared point by at most b * sqrt(1 + 1 + 1): both shears are at
            // most 1.
            band: band * 3f64.sqrt(),
            inverse: inverse.to_array(),
            first_offset: first_offset.to_array(),
            last_offset: last_offset.to_array(),
            first_plane: [backward(0), 2 + backward(1), 4 + backward(2)],
            s_per_t: scale,
            s_entry: entry,
        })
    }
    /// An upper bound of the slab parameter for `t`.
    #[inline(always)]
    pub fn slab_limit(&self, t: f64) -> f32 {
        // Negative only where t lies before the entry: nothing there, and the slab test's own floor of zero says so.
        (t * self.s_per_t - self.s_entry) as f32 * SLAB_SLACK
    }
}
