//! The numbers of a whole image: of the size of its texels, all together and by bands of camera depth.
//!
//! One pass over the pixels in parallel. Sums are those of blocks of [`BLOCK`] pixels, which are added in their order, so
//! that the result does not depend on the number of threads. Percentiles are exact: values are selected by rank.

use rayon::prelude::*;

use super::selection::{Real, mean, percentiles_of};
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Pixels of a block. Chosen because a sum of as many numbers of one sign is off by at most 4096 * 2^-53 = 5e-13 of itself,
/// and because a block takes tens of microseconds.
const BLOCK: usize = 4096;

/// What is known of the texel that each pixel looks up; see [`crate::image::Footprint`] for what the arrays hold.
#[derive(Debug, Clone, Copy)]
pub struct Texels<'a, T> {
    /// Index of the map; below 0 of pixels that look up none, whose other values are not read.
    pub map: &'a [i16],
    /// Longest extent, pixels.
    pub major: &'a [T],
    /// Area by perspective alone, square pixels.
    pub perspective: &'a [T],
    /// Lengths along the map's x by perspective alone, pixels.
    pub along_t: &'a [T],
    /// The same along its y.
    pub along_s: &'a [T],
    /// What the slope of the surface adds.
    pub projection: &'a [T],
    /// Camera depth, world units.
    pub depth: &'a [T],
}

/// What is asked of the measured pixels.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// How many maps there are.
    pub maps: usize,
    /// Per cent of the pixels, rising.
    pub percentiles: &'a [f64],
    /// Limits of the histogram, pixels, rising; values below the first are in no bin.
    pub edges: &'a [f64],
    /// From this length on a texel shows, pixels.
    pub undersampled_from: f64,
}

/// The numbers of all measured pixels: those of [`Texels::major`] unless the name says otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// How many pixels look up a texel.
    pub measured: usize,
    /// Largest.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// One for each that was asked for, interpolated between neighbours in order.
    pub percentiles: Vec<f64>,
    /// Pixels with a longer texel than shows.
    pub undersampled: usize,
    /// Largest extent by perspective alone.
    pub perspective_max: f64,
    /// Its mean.
    pub perspective_mean: f64,
    /// Geometric mean of [`Texels::projection`].
    pub projection_mean: f64,
    /// Of each map the longest texels along y (s) and x (t) by perspective alone; nothing of maps that serve no pixel.
    pub longest: Vec<Option<[f64; 2]>>,
    /// Pixels of each bin.
    pub histogram: Vec<u64>,
    /// Nearest and farthest camera depth.
    pub depths: [f64; 2],
}

/// The numbers of the pixels of a band of camera depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// How many.
    pub pixels: usize,
    /// Largest and mean value, the 95th percentile, and the share of values that show; nothing of no pixels.
    pub of_values: Option<[f64; 4]>,
}

/// The numbers of all pixels that look up a texel; nothing where none does.
///
/// # Errors
/// [`Error::InvalidArgument`] for arrays of different lengths, and for NaN where a texel is looked up.
/// [`Error::Interrupted`].
pub fn summary<T: Real>(texels: &Texels<T>, asked: &Asked, progress: &Progress) -> Result<Option<Summary>> {
    let Texels { map, major, perspective, along_t, along_s, projection, depth } = *texels;
    let pixels = map.len();
    for (name, array) in [
        ("major", major),
        ("perspective", perspective),
        ("perspective_ts", along_t),
        ("perspective_ts", along_s),
        ("projection", projection),
        ("depth", depth),
    ] {
        check_length(name, array.len(), pixels)?;
    }
    let blocks: Vec<Block<T>> = (0..pixels.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            progress.check()?;
            let mut found = Block::new(asked);
            for i in (block * BLOCK..pixels.min((block + 1) * BLOCK)).filter(|&i| map[i] >= 0) {
                found.add(texels, asked, i);
            }
            Ok::<_, Error>(found)
        })
        .collect::<Result<_>>()?;
    let mut all = Block::<T>::new(asked);
    blocks.iter().for_each(|block| all.join(block));
    let n = all.measured as f64;
    let [square, total, perspective, log_projection] = all.sums;
    if all.sums.iter().any(|sum| sum.is_nan()) {
        let fix = "mark such pixels in its map";
        return Err(Error::argument("footprint", "numbers wherever a texel is looked up", "NaN", fix));
    }
    if all.measured == 0 {
        return Ok(None);
    }
    let values: Vec<&[T]> = blocks.iter().map(|block| &block.values[..]).collect();
    Ok(Some(Summary {
        measured: all.measured,
        max: all.max,
        mean: total / n,
        rms: (square / n).sqrt(),
        percentiles: percentiles_of(&values, asked.percentiles, progress)?,
        undersampled: all.undersampled,
        perspective_max: all.perspective_max,
        perspective_mean: perspective / n,
        projection_mean: (log_projection / n).exp(),
        longest: all.longest,
        histogram: all.histogram,
        depths: all.depths,
    }))
}

/// The numbers of bands of depth between limits that rise; the last limit belongs to the last band.
///
/// # Errors
/// [`Error::InvalidArgument`] for arrays of different lengths; [`Error::Interrupted`].
pub fn bands<T: Real>(
    map: &[i16],
    values: &[T],
    depth: &[T],
    limits: &[f64],
    undersampled_from: f64,
    progress: &Progress,
) -> Result<Vec<Band>> {
    check_length("major", values.len(), map.len())?;
    check_length("depth", depth.len(), map.len())?;
    let count = limits.len().saturating_sub(1);
    let blocks: Vec<Vec<(usize, T)>> = (0..map.len().div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            progress.check()?;
            let pixels = (block * BLOCK..map.len().min((block + 1) * BLOCK)).filter(|&i| map[i] >= 0);
            Ok(pixels.filter_map(|i| Some((band_of(depth[i].into(), limits)?, values[i]))).collect())
        })
        .collect::<Result<_>>()?;
    let mut counts = vec![0; count];
    blocks.iter().flatten().for_each(|&(band, _)| counts[band] += 1);
    let mut of_band: Vec<Vec<T>> = counts.into_iter().map(Vec::with_capacity).collect();
    blocks.iter().flatten().for_each(|&(band, value)| of_band[band].push(value));
    drop(blocks);
    of_band
        .into_par_iter()
        .map(|values| {
            progress.check()?;
            let pixels = values.len();
            let numbers = || values.iter().map(|&v| v.into());
            let most = numbers().fold(f64::NEG_INFINITY, f64::max);
            let long = numbers().filter(|v| *v > undersampled_from).count() as f64 / pixels as f64;
            let average = mean(&values);
            let of_values = match pixels {
                0 => None,
                _ => Some([most, average, percentiles_of(&[&values], &[95.0], progress)?[0], long]),
            };
            Ok(Band { pixels, of_values })
        })
        .collect()
}

/// The band of a depth; none outside of all.
pub fn band_of(depth: f64, limits: &[f64]) -> Option<usize> {
    let (&first, &last) = limits.first().zip(limits.last())?;
    if !(first..=last).contains(&depth) {
        return None;
    }
    let bands = limits.len().checked_sub(2)?;
    Some((limits.partition_point(|&limit| limit <= depth) - 1).min(bands))
}

/// An error unless an array has a value for each pixel.
pub fn check_length(name: &'static str, got: usize, pixels: usize) -> Result<()> {
    if got == pixels {
        return Ok(());
    }
    Err(Error::argument(name, format!("a value for each of {pixels} pixels"), got, "take all arrays of one image"))
}

/// What is found in a block of pixels.
struct Block<T> {
    measured: usize,
    undersampled: usize,
    max: f64,
    perspective_max: f64,
    /// Of squares, of values, of extents by perspective, of logarithms of the projection.
    sums: [f64; 4],
    longest: Vec<Option<[f64; 2]>>,
    histogram: Vec<u64>,
    depths: [f64; 2],
    values: Vec<T>,
}

impl<T: Real> Block<T> {
    fn new(asked: &Asked) -> Self {
        Self {
            measured: 0,
            undersampled: 0,
            max: f64::NEG_INFINITY,
            perspective_max: f64::NEG_INFINITY,
            sums: [0.0; 4],
            longest: vec![None; asked.maps],
            histogram: vec![0; asked.edges.len().saturating_sub(1)],
            depths: [f64::INFINITY, f64::NEG_INFINITY],
            values: Vec::new(),
        }
    }

    fn add(&mut self, texels: &Texels<T>, asked: &Asked, i: usize) {
        let at = |array: &[T]| -> f64 { array[i].into() };
        let (value, along_t, along_s, depth) =
            (at(texels.major), at(texels.along_t), at(texels.along_s), at(texels.depth));
        let extent = largest_extent(along_t, along_s, at(texels.perspective));
        // A projection that underflows is the smallest of single precision.
        let slope = at(texels.projection).max(f64::from(f32::MIN_POSITIVE));
        self.measured += 1;
        self.undersampled += usize::from(value > asked.undersampled_from);
        self.max = self.max.max(value);
        self.perspective_max = self.perspective_max.max(extent);
        let added = [value * value, value, extent, slope.ln()];
        self.sums.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        self.depths = [self.depths[0].min(depth), self.depths[1].max(depth)];
        // Maxima and minima forget a NaN.
        if [at(texels.perspective), at(texels.projection), depth].iter().any(|x| x.is_nan()) {
            self.sums[0] = f64::NAN;
        }
        if let Some(longest) = self.longest.get_mut(texels.map[i] as usize) {
            *longest = Some(longer(*longest, [along_s, along_t]));
        }
        if let Some(bin) = band_of(value, asked.edges) {
            self.histogram[bin] += 1;
        }
        self.values.push(texels.major[i]);
    }

    /// Takes over what a later block found, but for its values.
    fn join(&mut self, other: &Self) {
        self.measured += other.measured;
        self.undersampled += other.undersampled;
        self.max = self.max.max(other.max);
        self.perspective_max = self.perspective_max.max(other.perspective_max);
        self.sums.iter_mut().zip(other.sums).for_each(|(sum, x)| *sum += x);
        self.depths = [self.depths[0].min(other.depths[0]), self.depths[1].max(other.depths[1])];
        self.histogram.iter_mut().zip(&other.histogram).for_each(|(bin, n)| *bin += n);
        for (mine, theirs) in self.longest.iter_mut().zip(&other.longest) {
            *mine = theirs.map_or(*mine, |theirs| Some(longer(*mine, theirs)));
        }
    }
}

fn longer(a: Option<[f64; 2]>, b: [f64; 2]) -> [f64; 2] {
    a.map_or(b, |a| [a[0].max(b[0]), a[1].max(b[1])])
}

/// The larger singular value of a matrix by the lengths of its columns and its determinant.
fn largest_extent(along_t: f64, along_s: f64, area: f64) -> f64 {
    let squares = along_t * along_t + along_s * along_s;
    (0.5 * (squares + (squares * squares - 4.0 * (area * area)).max(0.0).sqrt())).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two bands' worth of pixels, every seventh without a texel.
    fn texels(n: usize) -> (Vec<i16>, Vec<f32>) {
        let map = (0..n).map(|i| if i % 7 == 3 { -1 } else { (i % 2) as i16 }).collect();
        (map, (0..n).map(|i| (0.3 * i as f32).sin().abs() * 4.0 + 0.01).collect())
    }

    #[test]
    fn the_numbers_are_those_of_the_definitions() {
        let (map, major) = texels(10_000);
        let ones = vec![1.0_f32; map.len()];
        let depth: Vec<f32> = (0..map.len()).map(|i| 1.0 + i as f32).collect();
        let of = Texels {
            map: &map,
            major: &major,
            perspective: &ones,
            along_t: &ones,
            along_s: &major,
            projection: &ones,
            depth: &depth,
        };
        let asked =
            Asked { maps: 3, percentiles: &[0.0, 50.0, 100.0], edges: &[0.0, 1.0, 2.0, 8.0], undersampled_from: 1.0 };
        let found = summary(&of, &asked, &Progress::new()).unwrap().unwrap();
        let mut values: Vec<f64> = (0..map.len()).filter(|&i| map[i] >= 0).map(|i| major[i].into()).collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        // The last pixel has no texel.
        assert_eq!((found.measured, found.max, found.depths), (n, values[n - 1], [1.0, 9_999.0]));
        assert!((found.mean - values.iter().sum::<f64>() / n as f64).abs() < 1e-12);
        let middle = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
        assert_eq!((found.percentiles[0], found.percentiles[2]), (values[0], values[n - 1]));
        assert!((found.percentiles[1] - middle).abs() < 1e-15);
        assert_eq!(found.histogram.iter().sum::<u64>(), n as u64);
        assert_eq!(found.undersampled, values.iter().filter(|v| **v > 1.0).count());
        assert_eq!(found.longest[2], None);
        assert_eq!(found.longest[0].unwrap()[1], 1.0);
        assert!((found.projection_mean - 1.0).abs() < 1e-15);
        let halves = bands(&map, &major, &depth, &[1.0, 5001.0, 10_000.0], 1.0, &Progress::new()).unwrap();
        assert_eq!(halves.iter().map(|b| b.pixels).sum::<usize>(), n);
        assert_eq!(halves[0].pixels, map[..5000].iter().filter(|m| **m >= 0).count());
        assert!(halves.iter().any(|b| b.of_values.unwrap()[0] == found.max));
    }

    #[test]
    fn one_changed_texel_changes_the_sums() {
        let (map, mut major) = texels(6000);
        let ones = vec![1.0_f32; map.len()];
        let asked = Asked { maps: 2, percentiles: &[50.0], edges: &[0.0, 8.0], undersampled_from: 1.0 };
        let of = |major: &[f32]| {
            let (perspective, along_t, along_s, projection, depth) =
                (&ones[..], &ones[..], &ones[..], &ones[..], &ones[..]);
            let of = Texels { map: &map, major, perspective, along_t, along_s, projection, depth };
            summary(&of, &asked, &Progress::new())
        };
        let before = of(&major).unwrap().unwrap();
        major[5999] += 1.0;
        let after = of(&major).unwrap().unwrap();
        assert!(after.mean > before.mean && after.rms > before.rms);
        major[4] = f32::NAN;
        assert!(of(&major).unwrap_err().to_string().contains("NaN"));
    }

    #[test]
    fn a_nan_in_any_array_is_refused() {
        let (good, bad) = ([1.0_f32; 3], [1.0, f32::NAN, 1.0]);
        let asked = Asked { maps: 1, percentiles: &[50.0], edges: &[0.0, 8.0], undersampled_from: 1.0 };
        for which in 0..6 {
            let [major, perspective, along_t, along_s, projection, depth] =
                std::array::from_fn(|k| if k == which { &bad[..] } else { &good[..] });
            let of = Texels { map: &[0; 3], major, perspective, along_t, along_s, projection, depth };
            assert!(summary(&of, &asked, &Progress::new()).is_err(), "{which}");
        }
    }

    #[test]
    fn pixels_without_a_texel_are_not_read_and_none_is_nothing() {
        let nan = [f32::NAN; 4];
        let of = Texels {
            map: &[-1, -2, -3, -1],
            major: &nan,
            perspective: &nan,
            along_t: &nan,
            along_s: &nan,
            projection: &nan,
            depth: &nan,
        };
        let asked = Asked { maps: 1, percentiles: &[50.0], edges: &[0.0, 8.0], undersampled_from: 1.0 };
        assert_eq!(summary(&of, &asked, &Progress::new()).unwrap(), None);
        let short = Texels { depth: &nan[..3], ..of };
        assert!(summary(&short, &asked, &Progress::new()).unwrap_err().to_string().starts_with("depth: "));
    }

    #[test]
    fn work_that_shall_stop_stops() {
        let progress = Progress::new();
        progress.stop();
        let found = bands(&[0], &[1.0_f64], &[1.0], &[0.0, 2.0], 1.0, &progress);
        assert_eq!(found, Err(Error::Interrupted));
    }

    #[test]
    fn the_last_limit_belongs_to_the_last_band() {
        let limits = [1.0, 2.0, 4.0];
        let found = [0.9, 1.0, 1.9, 2.0, 4.0, 4.1, f64::NAN].map(|depth| band_of(depth, &limits));
        assert_eq!(found, [None, Some(0), Some(0), Some(1), Some(1), None, None]);
        assert_eq!((band_of(1.0, &[1.0]), band_of(1.0, &[])), (None, None));
    }
}
