//! Rays made ready for one frame: f64 for triangles, f32 with error bounds for boxes. One, or several side by side.
//!
//! Triangles: the shear of Woop, Benthin, Wald 2013 `[woop2013]` (watertight ray/triangle intersection), in f64.
//! Boxes: slabs in f32. A far origin is first moved to where the ray enters the tree's box, in f64, so that what is
//! rounded to f32 has magnitude about 1 however far away the ray begins; boxes then grow by [`LocalRays::fill`]'s `pad`,
//! a bound on everything that was rounded, and the far side by a relative bound (Ize 2013 `[ize2013]`,
//! robust BVH ray traversal). A box that holds a triangle the ray meets is therefore never missed.

use glam::{DAffine3, DVec3};

use super::rough::Rough;
use crate::trace::hierarchy::{Box3, inverse_power_of_two, power_of_two_near};

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
/// ([`LocalRays::fill`]), and the length of an edge is bounded by a sum, up to sqrt(2) of it. Boxes grow by as much, so that
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

/// Such rays side by side: `[axis][ray]`.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub struct WorldRays<const N: usize> {
    pub origin: [[f64; N]; 3],
    pub direction: [[f64; N]; 3],
}

impl<const N: usize> WorldRays<N> {
    /// Places for rays.
    pub const UNSET: Self = Self { origin: [[0.0; N]; 3], direction: [[0.0; N]; 3] };

    #[inline(always)]
    pub fn set(&mut self, ray: usize, to: &WorldRay) {
        let (origin, direction) = (to.origin.to_array(), to.direction.to_array());
        for a in 0..3 {
            self.origin[a][ray] = origin[a];
            self.direction[a][ray] = direction[a];
        }
    }
    #[inline(always)]
    pub fn get(&self, ray: usize) -> WorldRay {
        let vector = |of: &[[f64; N]; 3]| DVec3::new(of[0][ray], of[1][ray], of[2][ray]);
        WorldRay { origin: vector(&self.origin), direction: vector(&self.direction) }
    }
}

impl<const N: usize> From<[WorldRay; N]> for WorldRays<N> {
    #[inline(always)]
    fn from(rays: [WorldRay; N]) -> Self {
        let mut all = Self::UNSET;
        for (r, ray) in rays.iter().enumerate() {
            all.set(r, ray);
        }
        all
    }
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
    pub origin: [[f64; N]; 3],
    pub shear: [[f64; N]; 2],
    pub t_per_z: [f64; N],
    pub band: f64,
    /// `s = t * s_per_t - s_entry` is the slab test's parameter.
    s_per_t: [f64; N],
    s_entry: [f64; N],
    /// For several rays at one triangle, where asked for.
    pub rough: Rough<N>,
    /// Those of the rays asked for that remain and have their largest axis and signs in common with the first.
    pub together: u32,
    /// The others that remain.
    pub apart: u32,
}

/// One ray.
pub type LocalRay = LocalRays<1>;

impl<const N: usize> LocalRays<N> {
    /// No ray: zeros, which are quick to write.
    pub const NONE: Self = Self {
        inverse: [[0.0; N]; 3],
        first_offset: [[0.0; N]; 3],
        last_offset: [[0.0; N]; 3],
        first_origin: [[0.0; N]; 3],
        last_origin: [[0.0; N]; 3],
        first_plane: [0; 3],
        axes: [0; 3],
        origin: [[0.0; N]; 3],
        shear: [[0.0; N]; 2],
        t_per_z: [0.0; N],
        band: 0.0,
        s_per_t: [0.0; N],
        s_entry: [0.0; N],
        rough: Rough::NONE,
        together: 0,
        apart: 0,
    };

    /// The rays `origin + t * direction` taken into a frame, those asked for (bits); `range_of` has each one's `t_min` and
    /// `t_max`.
    /// Left out are those that miss `bounds`, grown by the reach of `band` (both in the frame's unit). `roughly`: what
    /// [`Rough`] needs, too.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn fill(
        &mut self,
        local_from_world: &DAffine3,
        bounds: &Box3,
        rays: &WorldRays<N>,
        range_of: impl Fn(usize) -> [f64; 2],
        band: f64,
        asked: u32,
        roughly: bool,
    ) {
        let linear = local_from_world.matrix3.to_cols_array_2d();
        let moved = local_from_world.translation.to_array();
        let turned = |v: &[[f64; N]; 3], a: usize, r: usize| {
            (linear[0][a] * v[0][r] + linear[1][a] * v[1][r]) + linear[2][a] * v[2][r]
        };
        let (mut origin, mut direction) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        for a in 0..3 {
            for r in 0..N {
                origin[a][r] = turned(&rays.origin, a, r) + moved[a];
                direction[a][r] = turned(&rays.direction, a, r);
            }
        }
        let (reach, size) = (largest_of(&origin), largest_of(&direction));
        // Otherwise so far out of this frame's scale that nothing in it has any extent.
        let (mut without_scale, mut far) = ([0; N], [0; N]);
        for r in 0..N {
            // Zero times a number is zero: comparisons with infinity would become a look at the bits of each by itself.
            let has_scale = (size[r] > 0.0) & (size[r] * 0.0 + reach[r] * 0.0 == 0.0);
            without_scale[r] = u64::from(!has_scale);
            far[r] = u64::from(reach[r] > NEAR_ORIGIN);
        }
        let mut alive = asked & !packed(&without_scale);
        let (mut scale, mut per_scale) = ([0.0; N], [0.0; N]);
        for r in 0..N {
            scale[r] = power_of_two_near(size[r]);
            per_scale[r] = inverse_power_of_two(scale[r]);
        }
        let (mut unit, mut slab) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        for a in 0..3 {
            for r in 0..N {
                let x = direction[a][r] * per_scale[r];
                unit[a][r] = x;
                slab[a][r] = if x.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(x) } else { x };
            }
        }

        let (mut entered, mut entry, mut entered_reach) = (origin, [0.0; N], [0.0; N]);
        let band_reach = BAND_REACH * band;
        let mut pad = [0.0; N];
        for r in 0..N {
            entered_reach[r] = larger(reach[r], 1.0);
            pad[r] = F32_PAD * entered_reach[r] + F64_PAD * reach[r] + band_reach;
        }
        if far.iter().fold(0, |any, far| any | far) != 0 {
            // Where the rays enter the padded box, in units of `unit`. The entered points have magnitude 1 and the pad.
            let (low, high) = (bounds.min.as_dvec3().to_array(), bounds.max.as_dvec3().to_array());
            for r in (0..N).filter(|&r| reach[r] > NEAR_ORIGIN) {
                pad[r] = 2.0 * F32_PAD + F64_PAD * reach[r] + band_reach;
                let [t_min, t_max] = range_of(r).map(|t| t * scale[r]);
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
                entered_reach[r] =
                    larger(1.0, larger(larger(entered[0][r].abs(), entered[1][r].abs()), entered[2][r].abs()));
            }
        }
        // Signs and largest axis in one number.
        let mut way = [0u64; N];
        for r in 0..N {
            let (x, y, z) = (unit[0][r].abs(), unit[1][r].abs(), unit[2][r].abs());
            let axis = if (x >= y) & (x >= z) { 0 } else { 2 - u64::from(y >= z) };
            let backward = |a: usize| u64::from(slab[a][r] < 0.0) << a;
            way[r] = backward(0) | backward(1) | backward(2) | (axis << 3);
        }
        let leader = way[alive.trailing_zeros() as usize % N];
        let backward = |a: usize| (leader >> a & 1) as usize;
        let last = (leader >> 3) as usize % 3;
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][last];
        for r in 0..N {
            way[r] ^= leader;
        }
        let together = alive & !packed(&way);

        for r in 0..N {
            let per_z = unit[last][r].recip();
            self.shear[0][r] = unit[axes[0]][r] * per_z;
            self.shear[1][r] = unit[axes[1]][r] * per_z;
            self.t_per_z[r] = per_z * per_scale[r];
        }
        self.first_plane = [backward(0), 2 + backward(1), 4 + backward(2)];
        self.axes = axes;
        for k in 0..3 {
            self.origin[k] = origin[axes[k]];
        }
        // A displacement of length b moves a sheared point by at most b * sqrt(1 + 1 + 1): both shears are at most 1.
        self.band = band * 3f64.sqrt();
        self.s_per_t = scale;
        self.s_entry = entry;
        for a in 0..3 {
            for r in 0..N {
                let padding = pad[r].copysign(slab[a][r]);
                let inverse = 1.0 / slab[a][r] as f32;
                let (first, last) = ((entered[a][r] + padding) as f32, (entered[a][r] - padding) as f32);
                self.inverse[a][r] = inverse;
                self.first_origin[a][r] = first;
                self.last_origin[a][r] = last;
                self.first_offset[a][r] = first * inverse;
                self.last_offset[a][r] = last * inverse;
            }
        }
        if roughly {
            let points = [&entered[axes[0]], &entered[axes[1]], &entered[axes[2]]];
            self.rough.fill(points, &self.shear, self.band, &entered_reach, &reach);
        }
        self.together = together;
        self.apart = alive & !together;
    }
    /// As in [`Line`].
    #[inline(always)]
    pub fn axes(&self) -> [usize; 3] {
        self.axes
    }
    /// One of the rays by itself.
    #[inline(always)]
    pub fn alone(&self, ray: usize) -> LocalRay {
        let of = |x: &[[f32; N]; 3]| [[x[0][ray]], [x[1][ray]], [x[2][ray]]];
        LocalRays {
            inverse: of(&self.inverse),
            first_offset: of(&self.first_offset),
            last_offset: of(&self.last_offset),
            first_origin: of(&self.first_origin),
            last_origin: of(&self.last_origin),
            first_plane: self.first_plane,
            axes: self.axes,
            origin: self.origin.map(|axis| [axis[ray]]),
            shear: self.shear.map(|axis| [axis[ray]]),
            t_per_z: [self.t_per_z[ray]],
            band: self.band,
            s_per_t: [self.s_per_t[ray]],
            s_entry: [self.s_entry[ray]],
            rough: Rough::NONE,
            together: 1,
            apart: 0,
        }
    }
    /// Whether the rays go down their largest axis, so that t falls where z grows.
    #[inline(always)]
    pub fn is_backward(&self) -> bool {
        self.first_plane[self.axes[2] % 3] & 1 != 0
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
    /// The same of each ray, for a `t` of its own.
    #[inline(always)]
    pub fn slab_limits(&self, t: &[f64; N]) -> [f32; N] {
        let mut limits = [0.0; N];
        for r in 0..N {
            limits[r] = self.slab_limit(r, t[r]);
        }
        limits
    }
}

/// Of numbers that are not NaN: one instruction, which `f64::max` is not.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Per ray the largest magnitude of three numbers.
#[inline(always)]
pub fn largest_of<const N: usize>(v: &[[f64; N]; 3]) -> [f64; N] {
    let mut out = [0.0; N];
    for r in 0..N {
        out[r] = larger(larger(v[0][r].abs(), v[1][r].abs()), v[2][r].abs());
    }
    out
}

/// A bit for each number that is not zero. Mostly none is.
#[inline(always)]
fn packed<const N: usize>(numbers: &[u64; N]) -> u32 {
    if numbers.iter().fold(0, |any, x| any | x) == 0 {
        return 0;
    }
    numbers.iter().enumerate().fold(0, |bits, (r, &x)| bits | u32::from(x != 0) << r)
}
