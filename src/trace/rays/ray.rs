//! Rays made ready for one frame: f64 for triangles, f32 with error bounds for boxes. One, or several side by side.
//!
//! Triangles: the shear of Woop, Benthin, Wald 2013 `[woop2013]` (watertight ray/triangle intersection), in f64.
//! Boxes: slabs in f32. A far origin is first moved to where the ray enters the tree's box, in f64, so that what is
//! rounded to f32 has magnitude about 1 however far away the ray begins; boxes then grow by [`LocalRays::fill`]'s `pad`,
//! a bound on everything that was rounded, and the far side by a relative bound (Ize 2013 `[ize2013]`,
//! robust BVH ray traversal). A box that holds a triangle the ray meets is therefore never missed.

use glam::{DAffine3, DVec3};

use super::rough::Rough;
use super::ways::{Starts, Ways, larger, packed};
use crate::trace::hierarchy::Box3;

/// Bound on the roundings of a slab test relative to its result: direction to f32, its inverse, the product and the sum,
/// 2^-24 each, on either side of the comparison; 12 of them are above those eight.
pub const SLAB_SLACK: f32 = 1.0 + 6.0 * f32::EPSILON;
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

/// What the rays of a bundle have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shared {
    Nothing,
    /// As those towards a directional light.
    Direction,
    /// As those from an eye.
    Origin,
}

impl Shared {
    /// Whether those of some rays that are asked for (bits) share that.
    #[inline(always)]
    pub fn or_nothing<const N: usize>(self, rays: &WorldRays<N>, bits: u32) -> Self {
        let of = match self {
            Self::Nothing => return self,
            Self::Direction => &rays.direction,
            Self::Origin => &rays.origin,
        };
        let first = bits.trailing_zeros() as usize % N;
        let mut differs = 0;
        for axis in of {
            let one = axis[first].to_bits();
            for r in 0..N {
                let is_in = 0u64.wrapping_sub(u64::from((bits >> r) & 1));
                differs |= (axis[r].to_bits() ^ one) & is_in;
            }
        }
        if differs == 0 { self } else { Self::Nothing }
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
    /// Whether all have one inverse direction, and one padded origin.
    pub shared: Shared,
    /// For several rays at one triangle, where asked for.
    pub rough: Rough<N>,
    /// Those of the rays asked for that remain and have their largest axis and signs in common with the first.
    pub together: u32,
    /// The others that remain.
    pub apart: u32,
}

/// One ray.
pub type LocalRay = LocalRays<1>;

/// What rays are made ready for: see [`LocalRays::fill`].
struct Goal<'a> {
    bounds: &'a Box3,
    band: f64,
    asked: u32,
    roughly: bool,
}

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
        shared: Shared::Nothing,
        rough: Rough::NONE,
        together: 0,
        apart: 0,
    };

    /// The rays `origin + t * direction` taken into a frame, those asked for (bits); `range_of` has each one's `t_min` and
    /// `t_max`. What they share (of those asked for, bit for bit) is taken there once.
    /// Left out are those that miss `bounds`, grown by the reach of `band` (both in the frame's unit). `roughly`: what
    /// [`Rough`] needs, too.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn fill(
        &mut self,
        local_from_world: &DAffine3,
        bounds: &Box3,
        rays: &WorldRays<N>,
        shared: Shared,
        range_of: impl Fn(usize) -> [f64; 2],
        band: f64,
        asked: u32,
        roughly: bool,
    ) {
        let goal = Goal { bounds, band, asked, roughly };
        let first = asked.trailing_zeros() as usize % N;
        let one = |v: &[[f64; N]; 3]| v.map(|axis| [axis[first]]);
        match shared {
            Shared::Direction => {
                let ways = Ways::new(local_from_world, &one(&rays.direction), 1);
                return self.fill_by(&ways, &Starts::new(local_from_world, &rays.origin), range_of, goal);
            }
            Shared::Origin => {
                let start = Starts::new(local_from_world, &one(&rays.origin));
                // Origins far away are moved to the box, each ray's to a place of its own.
                if start.reach[0] <= NEAR_ORIGIN {
                    let ways = Ways::new(local_from_world, &rays.direction, asked);
                    return self.fill_by(&ways, &start, range_of, goal);
                }
            }
            Shared::Nothing => {}
        }
        let ways = Ways::new(local_from_world, &rays.direction, asked);
        self.fill_by(&ways, &Starts::new(local_from_world, &rays.origin), range_of, goal);
    }
    /// From directions and origins of all rays, or what they share of them.
    #[inline(always)]
    fn fill_by<const D: usize, const O: usize>(
        &mut self,
        ways: &Ways<D>,
        starts: &Starts<O>,
        range_of: impl Fn(usize) -> [f64; 2],
        Goal { bounds, band, asked, roughly }: Goal,
    ) {
        const { assert!((D == N || D == 1) && (O == N || O == 1)) };
        let Starts { origin, reach } = starts;
        // Otherwise so far out of this frame's scale that nothing in it has any extent.
        let (mut without_scale, mut is_far) = ([0; N], 0);
        for r in 0..N {
            let (size, reach) = (ways.size[r % D], reach[r % O]);
            // Zero times a number is zero: comparisons with infinity would become a look at the bits of each by itself.
            let has_scale = (size > 0.0) & (size * 0.0 + reach * 0.0 == 0.0);
            without_scale[r] = u64::from(!has_scale);
            is_far |= u64::from(reach > NEAR_ORIGIN);
        }
        let mut alive = asked & !packed(&without_scale);

        let (mut entered, mut entry, mut entered_reach) = (*origin, [0.0; O], [0.0; O]);
        let band_reach = BAND_REACH * band;
        let mut pad = [0.0; O];
        for r in 0..O {
            entered_reach[r] = larger(reach[r], 1.0);
            pad[r] = F32_PAD * entered_reach[r] + F64_PAD * reach[r] + band_reach;
        }
        if O == N && is_far != 0 {
            // Where the rays enter the padded box, in units of `unit`. The entered points have magnitude 1 and the pad.
            let (low, high) = (bounds.min.as_dvec3().to_array(), bounds.max.as_dvec3().to_array());
            for r in (0..O).filter(|&r| reach[r] > NEAR_ORIGIN) {
                pad[r] = 2.0 * F32_PAD + F64_PAD * reach[r] + band_reach;
                let [t_min, t_max] = range_of(r).map(|t| t * ways.scale[r % D]);
                let (mut first, mut last) = (t_min, t_max);
                for a in 0..3 {
                    let inverse = ways.slab[a][r % D].recip();
                    let (s, t) =
                        ((low[a] - pad[r] - origin[a][r]) * inverse, (high[a] + pad[r] - origin[a][r]) * inverse);
                    (first, last) = (first.max(s.min(t)), last.min(s.max(t)));
                }
                // Both err by less than the pad's own F64_PAD share.
                if !(first <= last && first.is_finite()) {
                    alive &= !(1 << r);
                }
                entry[r] = first;
                (0..3).for_each(|a| entered[a][r] = origin[a][r] + ways.unit[a][r % D] * first);
                entered_reach[r] =
                    larger(1.0, larger(larger(entered[0][r].abs(), entered[1][r].abs()), entered[2][r].abs()));
            }
        }
        let together = alive & !ways.others;
        let axes = ways.axes;
        self.first_plane = [0, 1, 2].map(|a| 2 * a + usize::from(ways.is_backward[a]));
        self.axes = axes;
        // A displacement of length b moves a sheared point by at most b * sqrt(1 + 1 + 1): both shears are at most 1.
        self.band = band * 3f64.sqrt();
        self.shared = match (D == N, O == N) {
            (false, _) => Shared::Direction,
            (_, false) => Shared::Origin,
            _ => Shared::Nothing,
        };
        for r in 0..N {
            self.shear[0][r] = ways.shear[0][r % D];
            self.shear[1][r] = ways.shear[1][r % D];
            self.t_per_z[r] = ways.t_per_z[r % D];
            self.s_per_t[r] = ways.scale[r % D];
            self.s_entry[r] = entry[r % O];
        }
        for k in 0..3 {
            for r in 0..N {
                self.origin[k][r] = origin[axes[k]][r % O];
            }
        }
        for a in 0..3 {
            // The sign of all that remain together.
            let sign = if ways.is_backward[a] { -1.0 } else { 1.0 };
            let (mut first, mut last) = ([0.0; O], [0.0; O]);
            for r in 0..O {
                first[r] = (entered[a][r] + sign * pad[r]) as f32;
                last[r] = (entered[a][r] - sign * pad[r]) as f32;
            }
            for r in 0..N {
                let inverse = ways.inverse[a][r % D];
                self.inverse[a][r] = inverse;
                self.first_origin[a][r] = first[r % O];
                self.last_origin[a][r] = last[r % O];
                self.first_offset[a][r] = first[r % O] * inverse;
                self.last_offset[a][r] = last[r % O] * inverse;
            }
        }
        if roughly {
            let points = [&entered[axes[0]], &entered[axes[1]], &entered[axes[2]]];
            self.rough.fill(points, &ways.shear, self.band, &entered_reach, reach);
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
            shared: Shared::Nothing,
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
