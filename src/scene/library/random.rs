//! Seeded random numbers and smooth noise for the procedural scenes, and for discs of points.
//!
//! The generator is SplitMix64 (Steele, Lea and Flood 2014 `[steele2014]`).
//! Only integer operations, +, -, *, / and square roots are used, all of them exactly defined by IEEE 754, so that a
//! seed means the same scene on every platform.

use glam::DVec2;

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub(crate) struct Random {
    state: u64,
}

/// The increment of SplitMix64: 2^64 divided by the golden ratio, made odd.
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

impl Random {
    /// A stream for a seed and a purpose, so that more of one thing does not move the others.
    pub(crate) fn new(seed: u64, purpose: u64) -> Self {
        Self { state: mix(seed ^ mix(purpose)) }
    }
    /// 64 random bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN_GAMMA);
        mix(self.state)
    }
    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        unit_from_bits(self.bits())
    }
    /// A number in [low, high).
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    /// A whole number below `count` (which is at least 1).
    pub(super) fn below(&mut self, count: usize) -> usize {
        below(self.unit(), count)
    }
    /// A point of the unit disc, all of it as likely.
    pub(crate) fn in_disc(&mut self) -> DVec2 {
        loop {
            let p = DVec2::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            if p.length_squared() <= 1.0 {
                return p;
            }
        }
    }
    /// A unit vector in the plane, from a point of the disc rather than from an angle: no trigonometry.
    pub(super) fn direction(&mut self) -> DVec2 {
        loop {
            let p = DVec2::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            // The inner bound keeps the quotient accurate; it turns away 1 % of the points.
            if (0.01..=1.0).contains(&p.length_squared()) {
                return p / p.length();
            }
        }
    }
}

/// A whole number below `count` (which is at least 1), of a number in [0, 1).
pub(super) fn below(unit: f64, count: usize) -> usize {
    // The bias of the product is 2^-53 times the count: nothing beside the handful of choices made here.
    ((unit * count as f64) as usize).min(count - 1)
}

/// Smooth noise over the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    seed: u64,
}

impl Noise {
    /// Noise for a seed and a purpose.
    pub(super) fn new(seed: u64, purpose: u64) -> Self {
        Self { seed: mix(seed ^ mix(purpose)) }
    }
    /// Value noise in [-1, 1] with one lattice point a unit, twice differentiable (quintic fade: Perlin 2002
    /// `[perlin2002]`).
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        let (x0, y0) = (x.floor(), y.floor());
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let (u, v) = (fade(x - x0), fade(y - y0));
        let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let corner = |i: f64, j: f64| self.lattice((x0 + i) as i64, (y0 + j) as i64);
        lerp(lerp(corner(0.0, 0.0), corner(1.0, 0.0), u), lerp(corner(0.0, 1.0), corner(1.0, 1.0), u), v)
    }
    /// Octaves of [`Noise::at`], each twice as fine and half as strong; in [-2, 2].
    pub(super) fn octaves(&self, x: f64, y: f64, count: u32) -> f64 {
        // Shifted between octaves, so that their lattices do not share a point.
        (0..count)
            .map(|k| (f64::from(1u32 << k), f64::from(k) * 17.31))
            .map(|(f, s)| self.at(x * f + s, y * f - s) / f)
            .sum()
    }
    fn lattice(&self, i: i64, j: i64) -> f64 {
        let bits = mix(self.seed ^ mix((i as u64).wrapping_mul(GOLDEN_GAMMA) ^ mix(j as u64)));
        2.0 * unit_from_bits(bits) - 1.0
    }
}

/// The finalizer of SplitMix64.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The upper 53 bits as a number in [0, 1).
fn unit_from_bits(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_splitmix64() {
        // Published reference outputs for state 1234567.
        let mut random = Random { state: 1_234_567 };
        let expected: [u64; 3] = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(expected.map(|_| random.bits()), expected);
    }

    #[test]
    fn numbers_keep_their_ranges_and_fill_them() {
        let mut random = Random::new(7, 1);
        let draws: Vec<f64> = (0..10_000).map(|_| random.range(2.0, 5.0)).collect();
        assert!(draws.iter().all(|x| (2.0..5.0).contains(x)));
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        // The mean of 10,000 draws spreads by 3 / sqrt(12 * 10,000) = 0.0087; five of these.
        assert!((mean - 3.5).abs() < 5.0 * 0.0087, "{mean}");
        let mut seen = [0; 3];
        (0..300).for_each(|_| seen[random.below(3)] += 1);
        assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
        assert!((0..100).all(|_| (random.direction().length() - 1.0).abs() < 4.0 * f64::EPSILON));
    }

    #[test]
    fn noise_is_bounded_continuous_and_depends_on_the_seed() {
        let (a, b) = (Noise::new(1, 0), Noise::new(2, 0));
        let mut differs = false;
        for k in 0..1000 {
            let (x, y) = (f64::from(k) * 0.173 - 80.0, f64::from(k) * 0.091 - 40.0);
            assert!(a.at(x, y).abs() <= 1.0 && a.octaves(x, y, 4).abs() <= 2.0);
            // The quintic fade climbs by at most 15/8 a unit, on values that differ by at most 2.
            assert!((a.at(x + 1e-6, y) - a.at(x, y)).abs() <= 3.75e-6 * (1.0 + 1e-6));
            differs |= a.at(x, y) != b.at(x, y);
        }
        assert!(differs);
    }
}
