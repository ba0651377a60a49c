//! The two halves of a ray in a frame, each of which the rays of a bundle may share: its direction and where it starts.

use glam::DAffine3;

use crate::trace::hierarchy::{inverse_power_of_two, power_of_two_near};

/// Direction components below this share of the largest are raised to it, which keeps inverses finite. Over a path of
/// length 64 in a box of size 2 that moves the ray by 2^-54, far below `pad`.
const SMALLEST_COMPONENT: f64 = 1.0 / (1u64 << 60) as f64;

/// Directions in a frame, `[axis][ray]`.
pub struct Ways<const N: usize> {
    /// Largest component.
    pub size: [f64; N],
    /// A power of two near it.
    pub scale: [f64; N],
    /// The direction over that.
    pub unit: [[f64; N]; 3],
    /// The same without components that have no finite inverse.
    pub slab: [[f64; N]; 3],
    pub inverse: [[f32; N]; 3],
    /// As in [`Line`](super::Line), of those that have the leader's largest axis and signs.
    pub shear: [[f64; N]; 2],
    pub t_per_z: [f64; N],
    pub axes: [usize; 3],
    /// Signs of the leader, the first that is asked for.
    pub is_backward: [bool; 3],
    /// Those that have other signs or another largest axis (bits).
    pub others: u32,
}

impl<const N: usize> Ways<N> {
    #[inline(always)]
    pub fn new(local_from_world: &DAffine3, directions: &[[f64; N]; 3], asked: u32) -> Self {
        let direction = turned(local_from_world, directions);
        let size = largest_of(&direction);
        let (mut scale, mut per_scale) = ([0.0; N], [0.0; N]);
        for r in 0..N {
            scale[r] = power_of_two_near(size[r]);
            per_scale[r] = inverse_power_of_two(scale[r]);
        }
        let (mut unit, mut slab, mut inverse) = ([[0.0; N]; 3], [[0.0; N]; 3], [[0.0; N]; 3]);
        for a in 0..3 {
            for r in 0..N {
                let x = direction[a][r] * per_scale[r];
                unit[a][r] = x;
                slab[a][r] = if x.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(x) } else { x };
                inverse[a][r] = 1.0 / slab[a][r] as f32;
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
        let leader = way[asked.trailing_zeros() as usize % N];
        let last = (leader >> 3) as usize % 3;
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][last];
        for r in 0..N {
            way[r] ^= leader;
        }
        let (mut shear, mut t_per_z) = ([[0.0; N]; 2], [0.0; N]);
        for r in 0..N {
            let per_z = unit[last][r].recip();
            shear[0][r] = unit[axes[0]][r] * per_z;
            shear[1][r] = unit[axes[1]][r] * per_z;
            t_per_z[r] = per_z * per_scale[r];
        }
        let is_backward = [0, 1, 2].map(|a| leader >> a & 1 != 0);
        Self { size, scale, unit, slab, inverse, shear, t_per_z, axes, is_backward, others: packed(&way) }
    }
}

/// Origins in a frame, `[axis][ray]`.
pub struct Starts<const N: usize> {
    pub origin: [[f64; N]; 3],
    /// Largest component.
    pub reach: [f64; N],
}

impl<const N: usize> Starts<N> {
    #[inline(always)]
    pub fn new(local_from_world: &DAffine3, origins: &[[f64; N]; 3]) -> Self {
        let mut origin = turned(local_from_world, origins);
        let moved = local_from_world.translation.to_array();
        for a in 0..3 {
            for r in 0..N {
                origin[a][r] += moved[a];
            }
        }
        Self { origin, reach: largest_of(&origin) }
    }
}

/// The linear part of a map.
#[inline(always)]
fn turned<const N: usize>(map: &DAffine3, v: &[[f64; N]; 3]) -> [[f64; N]; 3] {
    let linear = map.matrix3.to_cols_array_2d();
    let mut out = [[0.0; N]; 3];
    for a in 0..3 {
        for r in 0..N {
            out[a][r] = (linear[0][a] * v[0][r] + linear[1][a] * v[1][r]) + linear[2][a] * v[2][r];
        }
    }
    out
}

/// Of numbers that are not NaN: one instruction, which `f64::max` is not.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
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
pub fn packed<const N: usize>(numbers: &[u64; N]) -> u32 {
    if numbers.iter().fold(0, |any, x| any | x) == 0 {
        return 0;
    }
    numbers.iter().enumerate().fold(0, |bits, (r, &x)| bits | u32::from(x != 0) << r)
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3, Vec3};

    use crate::trace::hierarchy::Box3;
    use crate::trace::rays::{ALL, BUNDLE, LocalRays, Shared, WorldRay, WorldRays};

    /// Numbers of rays in a frame, as text.
    fn filled(rays: &WorldRays<BUNDLE>, shared: Shared, asked: u32) -> String {
        let map = DAffine3::from_rotation_y(0.7) * DAffine3::from_translation(DVec3::new(0.1, -0.3, 0.2));
        let bounds = Box3 { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let mut local = LocalRays::NONE;
        local.fill(&map, &bounds, rays, shared, |_| [0.0, 1e9], 1e-6, asked, true);
        local.shared = Shared::Nothing;
        format!("{local:?}")
    }

    #[test]
    fn what_rays_share_gives_the_same_numbers() {
        for far in [0.5, 8.0, 40.0] {
            for asked in [ALL, ALL & !1] {
                let place = |r: usize| far * DVec3::new((r as f64).sin(), 0.3, (r as f64).cos());
                let ray = |origin: DVec3, direction: DVec3| WorldRay { origin, direction };
                let direction = DVec3::new(0.3, -1.2, 1e-20);
                let along = WorldRays::from(std::array::from_fn(|r| ray(place(r), direction)));
                let from = WorldRays::from(std::array::from_fn(|r| ray(place(1), 0.1 * place(r) - place(1))));
                for (rays, shared, other) in
                    [(along, Shared::Direction, Shared::Origin), (from, Shared::Origin, Shared::Direction)]
                {
                    assert_eq!(shared.or_nothing(&rays, asked), shared);
                    assert_eq!(other.or_nothing(&rays, asked), Shared::Nothing);
                    assert_eq!(filled(&rays, shared, asked), filled(&rays, Shared::Nothing, asked), "{far} {shared:?}");
                }
            }
        }
    }

    #[test]
    fn rays_that_differ_in_a_bit_share_nothing_where_they_are_asked_for() {
        let mut rays = WorldRays::from([WorldRay { origin: DVec3::ONE, direction: DVec3::X }; BUNDLE]);
        rays.direction[1][5] = -0.0;
        assert_eq!(Shared::Direction.or_nothing(&rays, ALL), Shared::Nothing);
        assert_eq!(Shared::Direction.or_nothing(&rays, ALL & !(1 << 5)), Shared::Direction);
    }
}
