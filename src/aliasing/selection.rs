//! Means and percentiles of many numbers: exact, in parallel, and soon over where somebody asks to stop.
//!
//! Numbers of certain ranks are found in two passes: how many have each first half of a number's bits, in its order; then those
//! are put in order that share this half with a rank that is wanted.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::Progress;

/// Numbers of a block: their sum is off by at most as many roundings, and a block takes some microseconds.
const BLOCK: usize = 4096;
/// As many numbers are sorted in a millisecond.
const FEW: usize = 1 << 14;
/// Keys of 16 bits.
const KEYS: usize = 1 << 16;

/// A number of single or double precision.
pub trait Real: Copy + Into<f64> + Send + Sync {
    /// The order of all numbers.
    fn order(&self, other: &Self) -> Ordering;
    /// The first bits of it, such that larger numbers never have smaller keys.
    fn key(self) -> u16;
}

impl Real for f32 {
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
    fn key(self) -> u16 {
        ascending((self.to_bits() >> 16) as u16)
    }
}

impl Real for f64 {
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
    fn key(self) -> u16 {
        ascending((self.to_bits() >> 48) as u16)
    }
}

/// The first bits of a floating-point number such that they rise with it: below zero all of them turn around.
fn ascending(bits: u16) -> u16 {
    if bits >> 15 == 1 { !bits } else { bits | 1 << 15 }
}

/// The mean; NaN of no numbers.
pub fn mean<T: Real>(values: &[T]) -> f64 {
    let block = |part: &[T]| part.iter().map(|&v| v.into()).sum::<f64>();
    values.chunks(BLOCK).map(block).sum::<f64>() / values.len() as f64
}

/// The percentiles (0 to 100) of at least one number, each interpolated between its two neighbours in order, as numpy's default
/// method has it.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn percentiles_of<T: Real>(parts: &[&[T]], percentiles: &[f64], progress: &Progress) -> Result<Vec<f64>> {
    let last = parts.iter().map(|part| part.len()).sum::<usize>() - 1;
    let places: Vec<f64> = percentiles.iter().map(|q| q / 100.0 * last as f64).collect();
    let both = |at: &f64| [last.min(at.floor() as usize), last.min(at.floor() as usize + 1)];
    let mut ranks: Vec<usize> = places.iter().flat_map(both).collect();
    ranks.sort_unstable();
    ranks.dedup();
    let found = of_ranks(parts, &ranks, progress)?;
    let value = |rank: usize| found[ranks.partition_point(|&r| r < rank)];
    Ok(places.iter().map(|at| interpolated(both(at).map(value), at.fract())).collect())
}

/// Between two numbers in order, from the first (0) to the second (1), from the nearer one.
fn interpolated([a, b]: [f64; 2], t: f64) -> f64 {
    let rise = b - a;
    // Equal numbers, infinite ones among them, have no rise.
    if a == b || t == 0.0 {
        a
    } else if rise.is_infinite() {
        b
    } else if t < 0.5 {
        a + rise * t
    } else {
        b - rise * (1.0 - t)
    }
}

/// The numbers of ranks that rise.
fn of_ranks<T: Real>(parts: &[&[T]], ranks: &[usize], progress: &Progress) -> Result<Vec<f64>> {
    let count = parts.iter().map(|part| part.len()).sum::<usize>();
    if count <= FEW {
        let mut values: Vec<T> = parts.iter().flat_map(|part| part.iter().copied()).collect();
        values.sort_unstable_by(T::order);
        return Ok(ranks.iter().map(|&rank| values[rank].into()).collect());
    }
    let blocks: Vec<&[T]> = parts.iter().flat_map(|part| part.chunks(BLOCK)).collect();
    // Few groups: each has the counts of all keys.
    let group = blocks.len().div_ceil(rayon::current_num_threads());
    let counts: Vec<Vec<usize>> = blocks
        .par_chunks(group)
        .map(|blocks| {
            let mut counts = vec![0; KEYS];
            for block in blocks {
                progress.check()?;
                block.iter().for_each(|v| counts[usize::from(v.key())] += 1);
            }
            Ok::<_, Error>(counts)
        })
        .collect::<Result<_>>()?;
    // Of each rank the place of its key among those that are wanted, and its rank among the numbers with this key.
    let (mut wanted, mut place_of_key, mut before) = (Vec::new(), vec![usize::MAX; KEYS], 0);
    let mut ranks = ranks.iter().peekable();
    for (key, place) in place_of_key.iter_mut().enumerate() {
        let here: usize = counts.iter().map(|counts| counts[key]).sum();
        while let Some(rank) = ranks.next_if(|&&rank| rank < before + here) {
            if *place == usize::MAX {
                *place = wanted.last().map_or(0, |&(place, _)| place + 1);
            }
            wanted.push((*place, rank - before));
        }
        before += here;
    }
    let keys = wanted.last().map_or(0, |&(place, _)| place + 1);
    let gathered: Vec<Vec<Vec<T>>> = blocks
        .par_chunks(group)
        .map(|blocks| {
            let mut of_key = vec![Vec::new(); keys];
            for block in blocks {
                progress.check()?;
                for &value in *block {
                    if let Some(of_key) = of_key.get_mut(place_of_key[usize::from(value.key())]) {
                        of_key.push(value);
                    }
                }
            }
            Ok::<_, Error>(of_key)
        })
        .collect::<Result<_>>()?;
    let in_order = |place: usize| {
        let mut values: Vec<T> = gathered.iter().flat_map(|of_key| of_key[place].iter().copied()).collect();
        values.par_sort_unstable_by(T::order);
        values
    };
    let in_order: Vec<Vec<T>> = (0..keys).map(in_order).collect();
    progress.check()?;
    Ok(wanted.into_iter().map(|(place, rank)| in_order[place][rank].into()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percentiles<T: Real>(values: &[T], asked: &[f64]) -> Vec<f64> {
        percentiles_of(&[values], asked, &Progress::new()).unwrap()
    }

    #[test]
    fn percentiles_are_those_of_sorted_numbers() {
        for n in [1_usize, 2, 3, 10, 101, 40_001, 100_000] {
            // 0 to n - 1, each once: 7919 divides no n.
            let values: Vec<f64> = (0..n).map(|i| ((i * 7919) % n) as f64 - 20_000.0).collect();
            let asked = [0.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0, 100.0];
            let single: Vec<f32> = values.iter().map(|v| *v as f32).collect();
            for found in [percentiles(&values, &asked), percentiles(&single, &asked)] {
                for (q, value) in asked.into_iter().zip(found) {
                    let expected = q / 100.0 * (n - 1) as f64 - 20_000.0;
                    assert!((value - expected).abs() < 1e-9 * n as f64, "{n} {q} {value} {expected}");
                }
            }
            let (a, b) = values.split_at(n / 3);
            assert_eq!(percentiles_of(&[a, &[], b], &asked, &Progress::new()).unwrap(), percentiles(&values, &asked));
        }
    }

    #[test]
    fn equal_and_infinite_numbers_stay_what_they_are() {
        assert_eq!(percentiles(&[f32::INFINITY; 3], &[50.0]), [f64::INFINITY]);
        assert_eq!(percentiles(&[0.1_f64; 20_000], &[5.0, 33.3]), [0.1; 2]);
        assert_eq!(percentiles(&[1.0, f64::INFINITY], &[0.0, 30.0, 70.0]), [1.0, f64::INFINITY, f64::INFINITY]);
    }

    #[test]
    fn keys_rise_with_numbers() {
        let rising =
            [f64::NEG_INFINITY, -1e300, -2.0, -1.0, -1e-300, -0.0, 0.0, 1e-300, 1.0, 1.5, 1e300, f64::INFINITY];
        assert!(rising.windows(2).all(|pair| pair[0].key() <= pair[1].key()));
        assert!(rising.windows(2).all(|pair| (pair[0] as f32).key() <= (pair[1] as f32).key()));
    }

    #[test]
    fn work_that_shall_stop_stops() {
        let progress = Progress::new();
        progress.stop();
        let values = vec![1.0_f32; 20_000];
        assert_eq!(percentiles_of(&[&values], &[5.0], &progress), Err(Error::Interrupted));
    }

    #[test]
    fn a_mean_adds_all() {
        assert_eq!(mean(&[1.0_f32; 10_000]), 1.0);
        assert_eq!(mean(&[1.0_f64, 2.0, 6.0]), 3.0);
    }
}
