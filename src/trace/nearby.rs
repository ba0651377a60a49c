//! Rays in the order of where they begin, seen along the first one: those that follow each other lie in squares.
//!
//! Rays of a square part later than those of a piece of a row, so they enter fewer boxes. Shadow rays mostly come in the order of
//! the pixels that they belong to, in rows with gaps where pixels see nothing. Morton's curve `[morton1966]` over a grid takes them
//! from square to square. Rays that go different ways keep their order. Which rays travel together changes no answer.

use glam::DVec3;

use super::rays::{ALL, BUNDLE, RayBits};

/// Rays that are ordered at a time: some rows of an image. Of fewer the squares are flat, and more do not stay in the cache.
pub const MOST: usize = 1 << INDEX_BITS;
/// Bits of a ray's index; those above it are its place on the curve.
const INDEX_BITS: u32 = 12;
/// Bits of a cell's place along each axis: a few cells for each of the rays along the longer side of what they cover.
const CELL_BITS: u32 = 10;
const CELLS: usize = 1 << CELL_BITS;
/// Cosine of the angle, half a right one, within which rays go about the same way.
const COS_NEAR: f64 = std::f64::consts::FRAC_1_SQRT_2;
const _: () = assert!(INDEX_BITS + 2 * CELL_BITS == u32::BITS);

/// An order of up to [`MOST`] rays.
#[derive(Debug)]
pub struct Order(Vec<u32>);

impl Order {
    /// Of as many origins as directions.
    #[inline(always)]
    pub fn new(origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Self {
        debug_assert!(origins.len() <= MOST && origins.len() == directions.len());
        let (Some(&first), Some(way)) = (origins.first(), common_way(directions)) else {
            return Self((0..origins.len() as u32).collect());
        };
        let (u, v) = way.any_orthonormal_pair();
        let mut places = vec![[0.0f32; 2]; origins.len()];
        let (mut low, mut high) = ([0.0f32; 2], [0.0f32; 2]);
        for (place, origin) in places.iter_mut().zip(origins) {
            let [x, y, z] = [origin[0] - first[0], origin[1] - first[1], origin[2] - first[2]];
            let at = [(x * u.x + y * u.y + z * u.z) as f32, (x * v.x + y * v.y + z * v.z) as f32];
            for k in 0..2 {
                low[k] = if at[k] < low[k] { at[k] } else { low[k] };
                high[k] = if at[k] > high[k] { at[k] } else { high[k] };
            }
            *place = at;
        }
        let side = (high[0] - low[0]).max(high[1] - low[1]);
        let per_side = (CELLS - 1) as f32 / side;
        let scale = if per_side.is_finite() { per_side } else { 0.0 };
        let mut keys = vec![0; origins.len()];
        for (i, (key, at)) in keys.iter_mut().zip(&places).enumerate() {
            let cell = |k: usize| ((at[k] - low[k]) * scale) as u32;
            let place = apart(cell(0)) | apart(cell(1)) << 1;
            *key = place << INDEX_BITS | i as u32;
        }
        Self(sorted(keys))
    }
    /// The rays in turn, in bundles.
    #[inline(always)]
    pub fn bundles(&self) -> impl Iterator<Item = Nearby<'_>> {
        self.0.chunks(BUNDLE).map(Nearby)
    }
}

/// Rays of a bundle, at least one.
#[derive(Debug, Clone, Copy)]
pub struct Nearby<'a>(&'a [u32]);

impl Nearby<'_> {
    /// Where one of them is; those that are not there repeat the last.
    #[inline(always)]
    pub fn index(&self, ray: usize) -> usize {
        (self.0[ray.min(self.0.len() - 1)] & (MOST as u32 - 1)) as usize
    }
    /// Those that are there.
    #[inline(always)]
    pub fn bits(&self) -> RayBits {
        ALL >> (BUNDLE - self.0.len())
    }
}

/// In ascending order of their places: a pass for each half of their bits, which leaves what is equal in its order.
#[inline(always)]
fn sorted(mut keys: Vec<u32>) -> Vec<u32> {
    let mut to = vec![0; keys.len()];
    for shift in [INDEX_BITS, INDEX_BITS + CELL_BITS] {
        let digit = |key: u32| (key >> shift) as usize % CELLS;
        let mut next = [0u32; CELLS];
        keys.iter().for_each(|&key| next[digit(key)] += 1);
        let mut sum = 0;
        for count in &mut next {
            sum += std::mem::replace(count, sum);
        }
        for &key in &keys {
            let at = &mut next[digit(key)];
            to[*at as usize] = key;
            *at += 1;
        }
        std::mem::swap(&mut keys, &mut to);
    }
    keys
}

/// The first direction, unit, where the others are near it, as far as a few of them tell.
fn common_way(directions: &[[f64; 3]]) -> Option<DVec3> {
    const FEW: usize = 16;
    let unit = |direction: &[f64; 3]| DVec3::from_array(*direction).try_normalize();
    let first = unit(directions.first()?)?;
    let is_near = |direction: &[f64; 3]| unit(direction).is_some_and(|other| other.dot(first) > COS_NEAR);
    directions.iter().step_by(directions.len().div_ceil(FEW)).all(is_near).then_some(first)
}

/// The bits of a cell's place, each followed by a zero.
#[inline(always)]
fn apart(cell: u32) -> u32 {
    let bits = cell & (CELLS as u32 - 1);
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    fn indices(order: &Order) -> Vec<usize> {
        order.bundles().flat_map(|some| (0..some.bits().count_ones() as usize).map(move |r| some.index(r))).collect()
    }

    #[test]
    fn bundles_of_a_picture_are_squares() {
        // Along the rays the grid lies askew; a row has 64 of 4 rays side by side.
        let place = |i: usize| [(i % 64) as f64, (i / 64) as f64, 0.3 * (i % 64) as f64];
        let origins: Vec<[f64; 3]> = (0..64 * 64).map(place).collect();
        let order = Order::new(&origins, &vec![[0.0, 0.0, -2.0]; origins.len()]);
        let mut spans = 0.0;
        for some in order.bundles() {
            let at = |r: usize| origins[some.index(r)];
            let span = |k: usize| {
                let all = (0..BUNDLE).map(|r| at(r)[k]);
                all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
            };
            spans += span(0) + span(1);
        }
        // 6 of a square, 15 of a piece of a row.
        assert!(spans / 256.0 < 8.0, "{}", spans / 256.0);
        let mut all = indices(&order);
        all.sort_unstable();
        assert!(all.into_iter().eq(0..64 * 64));
    }

    #[test]
    fn every_ray_has_its_place_whatever_it_is() {
        for places in
            [vec![], vec![[1.0; 3]], vec![[2.0; 3]; 100], vec![[f64::NAN; 3]; 20], vec![[f64::INFINITY; 3]; 33]]
        {
            for direction in [[0.0, -1.0, 0.0], [0.0; 3], [f64::NAN; 3]] {
                // Those of one place keep their order.
                let directions = vec![direction; places.len()];
                assert!(indices(&Order::new(&places, &directions)).into_iter().eq(0..places.len()));
            }
        }
        let mixed: Vec<[f64; 3]> = (0..MOST).map(|i| [1e300, (i * 7919 % 4096) as f64, -1e-300]).collect();
        let mut all = indices(&Order::new(&mixed, &[[1.0, 0.0, 0.0]; MOST]));
        assert!(!all.iter().copied().eq(0..MOST));
        all.sort_unstable();
        assert!(all.into_iter().eq(0..MOST));
        let apart: Vec<[f64; 3]> = (0..MOST).map(|i| [1.0, (i % 7) as f64 - 3.0, 0.0]).collect();
        assert!(indices(&Order::new(&mixed, &apart)).into_iter().eq(0..MOST));
    }
}
