//! The causes of an image's wrong pixels, counted: all together, how far edges moved, and by bands of camera depth.

use rayon::prelude::*;

use super::causes::cause;
use super::selection::{mean, percentiles_of};
use super::summary::{band_of, check_length};
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Pixels between two looks at whether to stop: some tens of microseconds.
const BLOCK: usize = 1 << 14;
/// How many codes there are from [`cause::NONE`] on.
pub const CODES: usize = cause::OTHER as usize + 1;

/// Pixels by code, from [`cause::NONE`] on.
pub type Counts = [u64; CODES];

/// The causes of a whole image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CauseCounts {
    /// Pixels by code.
    pub counts: Counts,
    /// Mean, 95th percentile and largest distance of displaced edges, pixels; nothing where none is finite.
    pub edges_px: Option<[f64; 3]>,
}

/// Counts the causes in an image, and how far its edges moved, which `distance` holds where the cause is [`cause::EDGE`].
///
/// # Errors
/// [`Error::InvalidArgument`] for arrays of different lengths; [`Error::Interrupted`].
pub fn cause_counts(image: &[i8], distance: &[f32], progress: &Progress) -> Result<CauseCounts> {
    check_length("distance", distance.len(), image.len())?;
    let blocks: Vec<(Counts, Vec<f32>)> = image
        .par_chunks(BLOCK)
        .zip(distance.par_chunks(BLOCK))
        .map(|(image, distance)| {
            progress.check()?;
            let mut counts = [0; CODES];
            image.iter().for_each(|&code| count(&mut counts, code));
            let edges = image.iter().zip(distance).filter(|(code, far)| **code == cause::EDGE && far.is_finite());
            Ok::<_, Error>((counts, edges.map(|(_, far)| *far).collect()))
        })
        .collect::<Result<_>>()?;
    let counts = total(blocks.iter().map(|(counts, _)| counts));
    let edges: Vec<f32> = blocks.into_iter().flat_map(|(_, edges)| edges).collect();
    if edges.is_empty() {
        return Ok(CauseCounts { counts, edges_px: None });
    }
    let found = percentiles_of(&[&edges], &[95.0, 100.0], progress)?;
    Ok(CauseCounts { counts, edges_px: Some([mean(&edges), found[0], found[1]]) })
}

/// Nearest and farthest depth of the pixels that were compared; nothing where none was.
///
/// # Errors
/// As [`cause_counts`].
pub fn compared_depths(image: &[i8], depth: &[f64], progress: &Progress) -> Result<Option<[f64; 2]>> {
    check_length("depth", depth.len(), image.len())?;
    let range = |found: Option<[f64; 2]>, at: f64| Some(found.map_or([at; 2], |[a, b]| [a.min(at), b.max(at)]));
    let blocks: Vec<Option<[f64; 2]>> = image
        .par_chunks(BLOCK)
        .zip(depth.par_chunks(BLOCK))
        .map(|(image, depth)| {
            progress.check()?;
            let compared = image.iter().zip(depth).filter(|(code, _)| **code >= cause::NONE);
            Ok::<_, Error>(compared.map(|(_, at)| *at).fold(None, range))
        })
        .collect::<Result<_>>()?;
    Ok(blocks.into_iter().flatten().flatten().fold(None, range))
}

/// The causes by bands of depth between limits that rise; the last limit belongs to the last band.
///
/// # Errors
/// As [`cause_counts`].
pub fn causes_by_depth(image: &[i8], depth: &[f64], limits: &[f64], progress: &Progress) -> Result<Vec<Counts>> {
    check_length("depth", depth.len(), image.len())?;
    let bands = limits.len().saturating_sub(1);
    // Few blocks: each has the counts of all bands.
    let block = image.len().div_ceil(rayon::current_num_threads()).max(BLOCK);
    let blocks: Vec<Vec<Counts>> = image
        .par_chunks(block)
        .zip(depth.par_chunks(block))
        .map(|(image, depth)| {
            let mut counts = vec![[0; CODES]; bands];
            for (image, depth) in image.chunks(BLOCK).zip(depth.chunks(BLOCK)) {
                progress.check()?;
                for (&code, &at) in image.iter().zip(depth) {
                    if let Some(band) = band_of(at, limits) {
                        count(&mut counts[band], code);
                    }
                }
            }
            Ok::<_, Error>(counts)
        })
        .collect::<Result<_>>()?;
    Ok((0..bands).map(|band| total(blocks.iter().map(|counts| &counts[band]))).collect())
}

/// Codes that are none are left out, and so is what was not compared.
fn count(counts: &mut Counts, code: i8) {
    if let Some(n) = usize::try_from(code).ok().and_then(|code| counts.get_mut(code)) {
        *n += 1;
    }
}

fn total<'a>(of: impl Iterator<Item = &'a Counts>) -> Counts {
    of.fold([0; CODES], |mut sum, counts| {
        sum.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: [i8; 8] = [0, 1, 2, 2, 2, -1, 5, 0];
    const FAR: [f32; 8] = [9.0, 9.0, 1.0, 3.0, f32::INFINITY, 9.0, 9.0, 9.0];

    #[test]
    fn every_cause_is_counted_and_edges_are_measured() {
        let found = cause_counts(&IMAGE, &FAR, &Progress::new()).unwrap();
        assert_eq!(found.counts, [2, 1, 3, 0, 0, 1]);
        let [average, p95, most] = found.edges_px.unwrap();
        assert_eq!((average, most), (2.0, 3.0));
        assert!((p95 - 2.9).abs() < 1e-12);
        let none = cause_counts(&[0, -1], &[1.0, 1.0], &Progress::new()).unwrap();
        assert_eq!(none.edges_px, None);
        assert!(cause_counts(&IMAGE, &FAR[..7], &Progress::new()).is_err());
    }

    #[test]
    fn bands_divide_what_was_compared() {
        let depth = [1.0, 2.0, 3.0, 4.0, 5.0, 100.0, 6.0, 7.0];
        assert_eq!(compared_depths(&IMAGE, &depth, &Progress::new()).unwrap(), Some([1.0, 7.0]));
        assert_eq!(compared_depths(&[-1], &[1.0], &Progress::new()).unwrap(), None);
        let found = causes_by_depth(&IMAGE, &depth, &[1.0, 4.0, 7.0], &Progress::new()).unwrap();
        assert_eq!(found, [[1, 1, 1, 0, 0, 0], [1, 0, 2, 0, 0, 1]]);
    }
}
