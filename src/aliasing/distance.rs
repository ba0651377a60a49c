//! Exact Euclidean distances in an image: from every pixel to the nearest one of a set.
//!
//! Source: Felzenszwalb, Huttenlocher 2012 `[felzenszwalb2012]`: the lower envelope of parabolas, along
//! columns, then along rows. In whole numbers, so there is no tolerance: the squared distances are below 2^31.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::Progress;

/// No pixel of the set in this column, or in the image.
const NONE: i64 = i64::MAX;

/// The distance in pixels from the centre of each pixel to that of the nearest one in `set`; infinity where the set is empty.
///
/// # Errors
/// [`crate::Error::Interrupted`].
///
/// # Panics
/// Where `set` is not `size[0] * size[1]` long.
pub fn distances(set: &[bool], size: [u32; 2], progress: &Progress) -> Result<Vec<f32>> {
    let [width, height] = size.map(|n| n as usize);
    assert_eq!(set.len(), width * height);
    if set.is_empty() {
        return Ok(Vec::new());
    }
    // Along columns: distance to the nearest pixel above or below, by a sweep each way over whole rows.
    let mut along: Vec<i64> = vec![NONE; set.len()];
    let mut since = vec![NONE; width];
    let mut sweep = |rows: &mut dyn Iterator<Item = usize>| {
        since.fill(NONE);
        for y in rows {
            for x in 0..width {
                let at = y * width + x;
                since[x] = if set[at] { 0 } else { since[x].saturating_add(1) };
                along[at] = along[at].min(since[x]);
            }
        }
    };
    sweep(&mut (0..height));
    sweep(&mut (0..height).rev());
    let mut result = vec![f32::INFINITY; set.len()];
    result.par_chunks_mut(width).zip(along.par_chunks(width)).try_for_each(|(row, along)| {
        progress.check()?;
        lower_envelope(along, row);
        Ok::<_, Error>(())
    })?;
    Ok(result)
}

/// For each x the root of the least `along[v]² + (x - v)²`.
fn lower_envelope(along: &[i64], row: &mut [f32]) {
    let parabolas = |v: usize| along[v] * along[v] + (v * v) as i64;
    // The parabolas of the envelope, and the first whole x from which each is the lowest.
    let (mut lowest, mut from): (Vec<usize>, Vec<i64>) = (Vec::new(), Vec::new());
    for v in (0..along.len()).filter(|&v| along[v] != NONE) {
        let mut start = 0;
        while let Some(&u) = lowest.last() {
            // v is below u from x > (f(v) - f(u)) / (2 v - 2 u) on.
            let crossing = (parabolas(v) - parabolas(u)).div_euclid(2 * (v - u) as i64) + 1;
            if crossing <= *from.last().expect("as many starts as parabolas") {
                lowest.pop();
                from.pop();
                start = 0;
            } else {
                start = crossing;
                break;
            }
        }
        if start < along.len() as i64 {
            lowest.push(v);
            from.push(start);
        }
    }
    let mut k = 0;
    for (x, distance) in row.iter_mut().enumerate() {
        while k + 1 < lowest.len() && from[k + 1] <= x as i64 {
            k += 1;
        }
        if let Some(&v) = lowest.get(k) {
            let across = x.abs_diff(v) as i64;
            *distance = ((along[v] * along[v] + across * across) as f64).sqrt() as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_trying_all(set: &[bool], [width, height]: [u32; 2]) -> Vec<f32> {
        let pixels = || (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
        let members: Vec<(u32, u32)> = pixels().zip(set).filter(|(_, is)| **is).map(|(at, _)| at).collect();
        let to = |(x, y): (u32, u32)| {
            let square = |(a, b): &(u32, u32)| u64::from(a.abs_diff(x)).pow(2) + u64::from(b.abs_diff(y)).pow(2);
            members.iter().map(square).min().map_or(f32::INFINITY, |d| (d as f64).sqrt() as f32)
        };
        pixels().map(to).collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_found_by_trying_all(width in 1u32..20, height in 1u32..20, seed: u64, share in 0u64..40) {
            let mut state = seed | 1;
            let mut next = || { state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); state >> 33 };
            let set: Vec<bool> = (0..width * height).map(|_| next() % 40 < share).collect();
            prop_assert_eq!(distances(&set, [width, height], &Progress::new()).unwrap(), by_trying_all(&set, [width, height]));
        }
    }

    #[test]
    fn an_empty_set_is_infinitely_far() {
        assert_eq!(distances(&[false; 6], [3, 2], &Progress::new()).unwrap(), [f32::INFINITY; 6]);
        assert!(distances(&[], [0, 4], &Progress::new()).unwrap().is_empty());
    }
}
