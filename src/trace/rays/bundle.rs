//! Rays that stay together: up to sixteen in one frame whose directions share their signs.
//!
//! Neighbouring rays enter nearly the same boxes. A bundle fetches each node once and tests its children once, by
//! interval arithmetic over all its rays (Boulos, Wald, Shirley 2006 `[boulos2006]`, culling of
//! entire ray packets); each child that is left is then tested against every ray side by side. What a ray meets
//! is the same as when it travels alone: its triangles are tested by the same function, and no box that it enters is
//! missed, since float operations are monotonous and both tests keep the error bounds of [`LocalRays`].

use super::ray::{LocalRays, Shared};

/// Rays of a bundle: two SIMD registers of f32. Chosen because sixteen rays enter about as many boxes as eight do.
pub const BUNDLE: usize = 16;
/// Set of rays of a bundle, a bit each.
pub type RayBits = u32;
/// Every ray of a bundle.
pub const ALL: RayBits = RayBits::MAX >> (RayBits::BITS - BUNDLE as u32);

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
        let mut is_in = [0; BUNDLE];
        for r in 0..BUNDLE {
            is_in[r] = if (bits >> r) & 1 != 0 { u32::MAX } else { 0 };
        }
        for a in 0..3 {
            let of = |x: &[f32; BUNDLE]| inside(x, &is_in, leader);
            hull.inverse[a] = match rays.shared {
                Shared::Direction => [rays.inverse[a][leader]; 2],
                _ => bounds(&of(&rays.inverse[a])),
            };
            let [first, last] = [&rays.first_origin[a], &rays.last_origin[a]];
            [hull.first_origin[a], hull.last_origin[a]] = match rays.shared {
                Shared::Origin => [first[leader], last[leader]],
                _ if rays.first_plane[a] & 1 != 0 => [least(&of(first)), largest(&of(last))],
                _ => [largest(&of(first)), least(&of(last))],
            };
        }
        hull
    }
}

/// With the leader's value where there is no ray.
#[inline(always)]
fn inside(x: &[f32; BUNDLE], is_in: &[u32; BUNDLE], leader: usize) -> [f32; BUNDLE] {
    let (mut out, leader) = ([0.0; BUNDLE], x[leader].to_bits());
    for r in 0..BUNDLE {
        out[r] = f32::from_bits((x[r].to_bits() & is_in[r]) | (leader & !is_in[r]));
    }
    out
}

/// The least and the largest.
#[inline(always)]
fn bounds(x: &[f32; BUNDLE]) -> [f32; 2] {
    [least(x), largest(x)]
}

/// The number that is before all others, in halves, as vector instructions do it.
#[inline(always)]
fn most(x: &[f32; BUNDLE], is_before: impl Fn(f32, f32) -> bool) -> f32 {
    const { assert!(BUNDLE == 16) };
    let (mut eight, mut four, mut two) = ([0.0; 8], [0.0; 4], [0.0; 2]);
    for i in 0..8 {
        eight[i] = if is_before(x[i], x[i + 8]) { x[i] } else { x[i + 8] };
    }
    for i in 0..4 {
        four[i] = if is_before(eight[i], eight[i + 4]) { eight[i] } else { eight[i + 4] };
    }
    for i in 0..2 {
        two[i] = if is_before(four[i], four[i + 2]) { four[i] } else { four[i + 2] };
    }
    if is_before(two[0], two[1]) { two[0] } else { two[1] }
}

/// The least.
#[inline(always)]
fn least(x: &[f32; BUNDLE]) -> f32 {
    most(x, |a, b| a < b)
}

/// The largest.
#[inline(always)]
pub fn largest(x: &[f32; BUNDLE]) -> f32 {
    most(x, |a, b| a > b)
}
