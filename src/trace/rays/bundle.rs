//! Rays that stay together: up to eight in one frame whose directions share their signs.
//!
//! Neighbouring rays enter nearly the same boxes. A bundle fetches each node once and tests its children once, by
//! interval arithmetic over all its rays (Boulos, Wald, Shirley 2006 `[boulos2006]`, culling of
//! entire ray packets); each child that is left is then tested against every ray side by side. What a ray meets
//! is the same as when it travels alone: its triangles are tested by the same function, and no box that it enters is
//! missed, since float operations are monotonous and both tests keep the error bounds of [`LocalRays`].

use super::ray::LocalRays;

/// Rays of a bundle: a SIMD register of f32.
pub const BUNDLE: usize = 8;
/// Set of rays of a bundle, a bit each.
pub type RayBits = u32;

/// The indices in a set.
#[derive(Debug, Clone, Copy)]
pub struct Each(pub RayBits);

impl Iterator for Each {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let ray = self.0.trailing_zeros() as usize % BUNDLE;
        let is_left = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        is_left.then_some(ray)
    }
}

/// The rays, and bounds over them.
#[derive(Debug, Clone, Copy)]
pub struct Bundle<'a> {
    pub rays: &'a LocalRays<BUNDLE>,
    pub hull: Hull,
}

/// Bounds over the rays of a bundle, per axis: where along it a plane is met lies between the products of its distance
/// from the origin with both inverses.
#[derive(Debug, Clone, Copy)]
pub struct Hull {
    /// Smallest and largest.
    pub inverse: [[f32; 2]; 3],
    /// The padded origin that is farthest on the way, for planes met first.
    pub first_origin: [f32; 3],
    /// The padded origin that is least far on the way, for planes met last.
    pub last_origin: [f32; 3],
    /// As in [`LocalRays`].
    pub first_plane: [usize; 3],
}

impl Hull {
    /// Over the rays of a set that is not empty.
    #[inline(always)]
    pub fn new(rays: &LocalRays<BUNDLE>, bits: RayBits) -> Self {
        let mut hull = Self {
            inverse: [[0.0; 2]; 3],
            first_origin: [0.0; 3],
            last_origin: [0.0; 3],
            first_plane: rays.first_plane,
        };
        let leader = bits.trailing_zeros() as usize % BUNDLE;
        let all = bits == RayBits::MAX >> (RayBits::BITS - BUNDLE as u32);
        for a in 0..3 {
            let backward = rays.first_plane[a] & 1;
            let [mut inverse, mut first, mut last] = [rays.inverse[a], rays.first_origin[a], rays.last_origin[a]];
            if !all {
                (inverse, first, last) =
                    (inside(&inverse, bits, leader), inside(&first, bits, leader), inside(&last, bits, leader));
            }
            hull.inverse[a] = bounds(&inverse);
            hull.first_origin[a] = bounds(&first)[1 - backward];
            hull.last_origin[a] = bounds(&last)[backward];
        }
        hull
    }
}

/// With the leader's value where there is no ray.
#[inline(always)]
fn inside(x: &[f32; BUNDLE], bits: RayBits, leader: usize) -> [f32; BUNDLE] {
    let mut out = *x;
    for r in 0..BUNDLE {
        out[r] = if (bits >> r) & 1 != 0 { x[r] } else { x[leader] };
    }
    out
}

/// The least and the largest.
#[inline(always)]
fn bounds(x: &[f32; BUNDLE]) -> [f32; 2] {
    // In halves, as vector instructions do it; closures over one of both would stay calls.
    let less = |a: f32, b: f32| if a < b { a } else { b };
    let more = |a: f32, b: f32| if a > b { a } else { b };
    let (mut low, mut high) = ([0.0; BUNDLE / 2], [0.0; BUNDLE / 2]);
    for i in 0..BUNDLE / 2 {
        low[i] = less(x[i], x[i + BUNDLE / 2]);
        high[i] = more(x[i], x[i + BUNDLE / 2]);
    }
    [less(less(low[0], low[2]), less(low[1], low[3])), more(more(high[0], high[2]), more(high[1], high[3]))]
}

/// The largest.
#[inline(always)]
pub fn largest(x: &[f32; BUNDLE]) -> f32 {
    bounds(x)[1]
}
