//! Rays in single precision beside triangles: which of them may come near one, with an error bound.
//!
//! The exact test (`kernel::exact`) shears a triangle's vertices, in f64, so that the ray is the z axis, and
//! looks at the signs of three edge functions. The rough one does the same in f32 for all rays of a bundle at once, and leaves out
//! those that the exact one would leave out whatever was rounded. Those that remain get the exact test, so the rough one never
//! decides what is met.
//!
//! The bound, with u = 2^-24 and vertices of magnitude at most 1, from an origin of magnitude at most R >= 1:
//! - a coordinate relative to the origin errs by u R (origin) + u (1 + R) (difference) <= 3 u R;
//! - sheared, `x - s z` with |s| <= 1 errs by 3 u R (x) + 3 u R (z) + 2 u R (s) + 2 u R (product) + 4 u R (difference), with
//!   terms of u^2 at most d = 18 u R. What the exact test rounds is added: 20 * 2^-53 of the origin's distance bounds its own
//!   operations and, for an origin far away, the move to the tree's box;
//! - an edge function `b.x a.y - b.y a.x` then errs by d (Sa + Sb) + 2 d^2 + 2 u Sa Sb, where Sa = |a.x| + |a.y| <= 8 u R / u:
//!   at most 26 u R (Sa + Sb) + 2 d^2.
//!
//! With e = 32 u R plus the rest, the error of each edge is below e (Sa + Sb + Sc + 4 e); six roundings of that product are within
//! the remaining 6 u R. The exact test's band about edges, whose margin is at most its half-width times Sa + Sb, adds to e.
//!
//! A triangle that is met behind the origin is left out where that is asked. The exact test's t has the sign of
//! T = u a.z + v b.z + w c.z, with the edge functions u, v, w, over that of their sum, which is that of each of them. A relative
//! coordinate errs by less than e, and an edge function by B = e (Sa + Sb + Sc + 4 e). So T errs by e U (coordinates),
//! 3 B (Z + e) (edge functions) and 4 u Z U <= e U / 4 (products and sums), where U is the sum of the magnitudes of u, v and w,
//! and Z <= 2 R + e the largest of those of z.

/// The coefficients of e U and B (Z + e) above, with room for the roundings of the bound itself.
pub const DEPTH_OF_ERROR: f32 = 1.5;
pub const DEPTH_OF_BOUND: f32 = 3.5;
/// The coefficient of u R above, and u.
const PER_REACH: f64 = 32.0 * (f32::EPSILON as f64 / 2.0);
/// What f64 rounds on both ways, times the 1.5 by which [`PER_REACH`] exceeds the error of a coordinate: 30 of 2^-53.
const PER_DISTANCE: f64 = 16.0 * f64::EPSILON;
/// Errors above this say nothing, and single precision may overflow: such rays are near everything.
const LARGEST: f64 = 1.0;

/// What the rough test needs of rays, side by side; axes as in [`Line`](super::Line).
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub struct Rough<const N: usize> {
    /// A point on each ray, near the tree's box.
    pub origin: [[f32; N]; 3],
    pub shear: [[f32; N]; 2],
    /// e of the file's header.
    pub error: [f32; N],
}

impl<const N: usize> Rough<N> {
    /// Of no ray.
    pub const NONE: Self = Self { origin: [[0.0; N]; 3], shear: [[0.0; N]; 2], error: [0.0; N] };

    /// Of rays through points near the tree's box (`reach` is their magnitude or more, at least 1), whose origins are as far away as
    /// `distance`; one of each where the rays share it.
    #[inline(always)]
    pub fn fill<const D: usize, const O: usize>(
        &mut self,
        points: [&[f64; O]; 3],
        shear: &[[f64; D]; 2],
        band: f64,
        reach: &[f64; O],
        distance: &[f64; O],
    ) {
        let mut is_rough = false;
        for r in 0..N {
            let error = PER_REACH * reach[r % O] + PER_DISTANCE * (1.0 + distance[r % O]) + band;
            is_rough |= !(error < LARGEST);
            self.error[r] = error as f32;
        }
        for a in 0..3 {
            for r in 0..N {
                self.origin[a][r] = points[a][r % O] as f32;
            }
        }
        for a in 0..2 {
            for r in 0..N {
                self.shear[a][r] = shear[a][r % D] as f32;
            }
        }
        if is_rough {
            self.without_use();
        }
    }
    #[cold]
    #[inline(never)]
    fn without_use(&mut self) {
        for r in 0..N {
            if !(f64::from(self.error[r]) < LARGEST) {
                // With no origin and shears up to 1 no edge function is above 8.
                (0..3).for_each(|a| self.origin[a][r] = 0.0);
                self.error[r] = 8.0;
            }
        }
    }
}
