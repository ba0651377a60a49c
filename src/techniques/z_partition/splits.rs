//! Where the depths of a view are split.
//!
//! Source: Zhang, Sun, Xu, Lun 2006 `[zhang2006]` (parallel-split shadow maps: uniform, logarithmic and the practical
//! blend of both); Lauritzen, Salvi, Lefohn 2010 `[lauritzen2010]` (sample distribution shadow maps: from the
//! distribution of depths); theory.md 12.1. Departure: of an orthographic camera all are by length.

use crate::scene::Camera;

/// How finely the distribution of depths is looked at. Chosen because a bin of a depth range of 1 : 10⁴ is then 0.9 % of its
/// depth, far below the shortest useful split.
const BINS: usize = 1024;

/// What makes splits equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The ratio of their ends, as a perspective has it.
    Ratio,
    /// Their length: parallel rays see all depths at one scale.
    Length,
}

impl Measure {
    /// What suits a camera.
    pub fn of(camera: &Camera) -> Self {
        if camera.is_orthographic() { Self::Length } else { Self::Ratio }
    }
    /// The share of the logarithmic scheme where so much is asked for.
    pub fn blend(self, asked: f64) -> f64 {
        match self {
            Self::Ratio => asked,
            Self::Length => 0.0,
        }
    }
    /// From one depth to another.
    fn between(self, near: f64, far: f64) -> f64 {
        match self {
            Self::Ratio => (far / near).ln(),
            Self::Length => far - near,
        }
    }
    /// The depth so far behind another.
    fn behind(self, near: f64, by: f64) -> f64 {
        match self {
            Self::Ratio => near * by.exp(),
            Self::Length => near + by,
        }
    }
}

/// The borders of `count` splits of [near, far], ends included: a share `blend` of the logarithmic scheme (all splits as long
/// in ratio) and the rest of the uniform one (all as long in depth), (12.1).
pub fn blended(near: f64, far: f64, count: usize, blend: f64) -> Vec<f64> {
    let inner = (1..count).map(|i| {
        let share = i as f64 / count as f64;
        let uniform = near + (far - near) * share;
        // Depths of parallel rays have no ratio.
        let logarithmic = if blend == 0.0 { uniform } else { near * (far / near).powf(share) };
        blend * logarithmic + (1.0 - blend) * uniform
    });
    [near].into_iter().chain(inner.map(|c| c.clamp(near, far))).chain([far]).collect()
}

/// Begin and end of `count` splits, each with an equal share of the bins of equal measure in which there is a sample. An end
/// before the next begin is a gap in the depths. Nothing without samples.
pub fn equal_shares(depths: &[f64], count: usize, measure: Measure) -> Vec<[f64; 2]> {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (near, far) = depths.iter().fold(ends, |(a, b), d| (a.min(*d), b.max(*d)));
    if depths.is_empty() {
        return Vec::new();
    }
    let range = measure.between(near, far);
    // All at one depth: a split there, and empty ones behind.
    if range <= 0.0 || range.is_nan() {
        return vec![[near, far]; count];
    }
    let mut occupied = [false; BINS];
    for depth in depths {
        occupied[((measure.between(near, *depth) / range * BINS as f64) as usize).min(BINS - 1)] = true;
    }
    let filled: Vec<usize> = (0..BINS).filter(|&bin| occupied[bin]).collect();
    let depth = |bins: f64| measure.behind(near, range * bins / BINS as f64);
    // Of the first `share` filled bins: where the last of them ends, and where the next begins.
    let border = |i: usize| {
        let share = filled.len() as f64 * i as f64 / count as f64;
        let (whole, part) = (share as usize, share.fract());
        let end = if part > 0.0 { filled[whole] as f64 + part } else { filled[whole - 1] as f64 + 1.0 };
        (depth(end), depth(filled[whole] as f64 + part))
    };
    let mut splits = vec![[near, far]; count];
    for i in 1..count {
        let (end, begin) = border(i);
        splits[i - 1][1] = end.clamp(near, far);
        splits[i][0] = begin.clamp(near, far);
    }
    splits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(got: &[f64], expected: &[f64]) {
        assert_eq!(got.len(), expected.len());
        for (a, b) in got.iter().zip(expected) {
            assert!((a - b).abs() <= 1e-12 * b, "{got:?} {expected:?}");
        }
    }

    #[test]
    fn borders_are_those_of_the_closed_forms() {
        assert_close(&blended(1.0, 100.0, 4, 0.0), &[1.0, 25.75, 50.5, 75.25, 100.0]);
        assert_close(&blended(1.0, 10_000.0, 4, 1.0), &[1.0, 10.0, 100.0, 1000.0, 10_000.0]);
        assert_close(&blended(2.0, 3.0, 1, 0.5), &[2.0, 3.0]);
        assert_eq!(blended(5.0, 5.0, 3, 0.5), [5.0; 4]);
    }

    #[test]
    fn evenly_filled_depths_split_as_logarithms_do() {
        let depths: Vec<f64> = (0..=100_000).map(|i| 1e4_f64.powf(f64::from(i) / 1e5)).collect();
        let splits = equal_shares(&depths, 4, Measure::Ratio);
        assert_close(&splits.concat(), &[1.0, 10.0, 10.0, 100.0, 100.0, 1000.0, 1000.0, 10_000.0]);
        // How often a depth is seen does not matter, as for a resolution that every part of it needs.
        let heavy = [depths, vec![3.0; 1_000_000]].concat();
        assert_eq!(equal_shares(&heavy, 4, Measure::Ratio), splits);
    }

    #[test]
    fn gaps_are_skipped() {
        // A hand before a far wall: two clusters of one width in ratio, so each is one of two splits.
        let cluster = |from: f64| (0..=10_000).map(move |i| from * 2_f64.powf(f64::from(i) / 1e4));
        let depths: Vec<f64> = cluster(1.0).chain(cluster(512.0)).collect();
        let splits = equal_shares(&depths, 2, Measure::Ratio);
        let bin = 1024_f64.powf(1.0 / BINS as f64);
        for (got, expected) in splits.concat().iter().zip([1.0, 2.0, 512.0, 1024.0]) {
            assert!((got / expected).ln().abs() <= bin.ln(), "{splits:?}");
        }
        let four = equal_shares(&depths, 4, Measure::Ratio);
        assert!(four.windows(2).all(|w| w[0][0] < w[0][1] && w[0][1] <= w[1][0]), "{four:?}");
    }

    #[test]
    fn lengths_split_evenly_and_depths_may_be_negative() {
        let depths: Vec<f64> = (0..=100_000).map(|i| -1.0 + f64::from(i) / 25_000.0).collect();
        let splits = equal_shares(&depths, 4, Measure::Length);
        for (got, expected) in splits.concat().iter().zip([-1.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0]) {
            assert!((got - expected).abs() < 1e-12, "{splits:?}");
        }
        assert_eq!(blended(-1.0, 3.0, 4, Measure::Length.blend(1.0)), [-1.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(equal_shares(&[-2.0, -2.0], 2, Measure::Length), [[-2.0; 2]; 2]);
    }

    #[test]
    fn few_samples_are_enough() {
        assert!(equal_shares(&[], 3, Measure::Ratio).is_empty());
        assert_eq!(equal_shares(&[2.0], 3, Measure::Ratio), [[2.0; 2]; 3]);
        let two = equal_shares(&[2.0, 8.0], 4, Measure::Ratio);
        assert!(two[0][0] == 2.0 && two[3][1] == 8.0 && two.iter().all(|s| s[0] <= s[1]), "{two:?}");
        assert!(two[1][1] < 2.1 && two[2][0] > 7.9, "{two:?}");
    }
}
