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
#[derive(Debug, Clone)]
pub struct Bundle {
    pub rays: LocalRays<BUNDLE>,
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
        for a in 0..3 {
            let backward = rays.first_plane[a] & 1;
            hull.inverse[a] = bounds(&inside(&rays.inverse[a], bits, leader));
            hull.first_origin[a] = bounds(&inside(&rays.first_origin[a], bits, leader))[1 - backward];
            hull.last_origin[a] = bounds(&inside(&rays.last_origin[a], bits, leader))[backward];
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

#[inline(always)]
fn bounds(x: &[f32; BUNDLE]) -> [f32; 2] {
    let of = |pick: fn(f32, f32) -> f32| {
        let four: [f32; 4] = std::array::from_fn(|i| pick(x[i], x[i + 4]));
        pick(pick(four[0], four[2]), pick(four[1], four[3]))
    };
    [of(|a, b| if a < b { a } else { b }), of(|a, b| if a > b { a } else { b })]
}

/// The largest.
#[inline(always)]
pub fn largest(x: &[f32; BUNDLE]) -> f32 {
    bounds(x)[1]
}
