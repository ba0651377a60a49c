//! Where shadows end in the picture: samples beside an edge, with the edge's direction.
//!
//! Source: Chong, Gortler 2007 `[chong2007]` (samples near shadow boundaries, none at discontinuities of depth); theory.md
//! 10.3 (the edge's normal from the states of the 5 x 5 pixels around). Thinning is ours: along Morton's curve `[morton1966]`
//! with an even step, handed out in bit-reversed order, so that every beginning of the list is spread evenly.
//!
//! ```text
//!      . . # # #        the normal n points from the shadow to the light; a sample on either
//!      . . . # #        side counts, where both neighbours are on one surface
//!      . . . . #   n ↙
//! ```

use glam::DVec3;

use super::picture::Picture;
use crate::error::Result;
use crate::image::TruthMask;

/// A sample at the edge of a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSample {
    /// Index of the sample.
    pub sample: u32,
    /// Unit normal of the edge in the picture, x to the right and y down, from shadow to light.
    pub normal: [f32; 2],
    /// Pixels at edges that it stands for.
    pub weight: f32,
}

/// In place of a sample's index.
pub(super) const NO_SAMPLE: u32 = u32::MAX;

/// Rows of a picture between two looks at whether to go on.
const ROWS_AT_ONCE: usize = 16;

/// At most `count` samples at edges, and the samples in shadow with their neighbours. `facing` has the index of the sample of
/// each pixel that faces the light, else [`NO_SAMPLE`]; `sample` gives world position and normal.
pub(super) fn edges_of(
    sample: impl Fn(usize) -> (DVec3, DVec3),
    picture: &Picture,
    image: &[i8],
    facing: &[u32],
    count: usize,
    check: impl Fn() -> Result<()>,
) -> Result<(Vec<EdgeSample>, Vec<u32>)> {
    let [width, height] = picture.size.map(|n| n as i64);
    let at = |x: i64, y: i64| ((0..width).contains(&x) && (0..height).contains(&y)).then(|| (y * width + x) as usize);
    let state = |pixel: usize| match image[pixel] {
        TruthMask::LIT => Some(false),
        TruthMask::SHADOW => Some(true),
        _ => None,
    };
    let eye = picture.camera.eye();
    let seen = |pixel: usize| {
        let (p, n) = sample(facing[pixel] as usize);
        (p - eye, n)
    };
    let mut found: Vec<(u32, usize)> = Vec::new();
    let (w, mut is_found) = (width as usize, vec![false; image.len()]);
    let mut meet = |pixel: usize, other: usize| {
        if is_one_surface(picture, seen(pixel), seen(other)) {
            for one in [pixel, other] {
                if !is_found[one] {
                    is_found[one] = true;
                    found.push((morton((one % w) as u32, (one / w) as u32), one));
                }
            }
        }
    };
    let mut differ = vec![0; w];
    for (y, row) in image.chunks_exact(w).enumerate() {
        if y.is_multiple_of(ROWS_AT_ONCE) {
            check()?;
        }
        let first = y * w;
        differing(&row[..w - 1], &row[1..], &mut differ[..w - 1]);
        places(&differ[..w - 1]).for_each(|x| meet(first + x, first + x + 1));
        if let Some(below) = image.get(first + w..first + 2 * w) {
            differing(row, below, &mut differ);
            places(&differ).for_each(|x| meet(first + x, first + x + w));
        }
    }
    let shaded = shaded(image, facing, w, &check)?;
    found.sort_unstable();
    check()?;
    let normal = |pixel: usize| {
        let (x, y) = (pixel as i64 % width, pixel as i64 / width);
        let (mut sum, mut mean, mut first, mut known) = ([0.0_f64; 2], 0.0, [0.0_f64; 2], 0.0);
        for dy in -2..=2 {
            for dx in -2..=2 {
                let Some(shadow) = at(x + dx, y + dy).and_then(state) else { continue };
                let lit = f64::from(u8::from(!shadow));
                sum = [sum[0] + lit * dx as f64, sum[1] + lit * dy as f64];
                first = [first[0] + dx as f64, first[1] + dy as f64];
                (mean, known) = (mean + lit, known + 1.0);
            }
        }
        mean /= known;
        let gradient = [sum[0] - mean * first[0], sum[1] - mean * first[1]];
        let length = gradient[0].hypot(gradient[1]);
        // A thin line in the middle of the window has no side: its nearest border's.
        if length > 1e-9 {
            return gradient.map(|g| (g / length) as f32);
        }
        let own = state(pixel);
        let beside = NEIGHBOURS
            .iter()
            .find(|(dx, dy)| at(x + dx, y + dy).is_some_and(|q| state(q).is_some() && state(q) != own));
        let sign = if own == Some(true) { 1.0 } else { -1.0 };
        beside.map_or([1.0, 0.0], |(dx, dy)| [sign * *dx as f32, sign * *dy as f32])
    };
    let (places, weight) = spread(found.len(), count);
    let edge = |pixel: usize| EdgeSample { sample: facing[pixel], normal: normal(pixel), weight };
    Ok((places.map(|i| edge(found[i].1)).collect(), shaded))
}

/// At most `count` of some edges, evenly, each with the weight of those it stands for.
pub(super) fn thinned(edges: &[EdgeSample], count: usize) -> Vec<EdgeSample> {
    let (places, share) = spread(edges.len(), count);
    places.map(|i| EdgeSample { weight: edges[i].weight * share, ..edges[i] }).collect()
}

/// At most `count` of so many places, evenly, in an order of which every beginning is spread over all; and how many each stands
/// for.
fn spread(all: usize, count: usize) -> (impl Iterator<Item = usize>, f32) {
    let kept = all.min(count);
    let each = if kept > 0 { all as f32 / kept as f32 } else { 0.0 };
    (bit_reversed(kept).map(move |i| evenly(i, kept, all)), each)
}

/// The place among `all` of one of `kept` that lie evenly between them.
pub(super) fn evenly(i: usize, kept: usize, all: usize) -> usize {
    (2 * i + 1) * all / (2 * kept)
}

/// The four beside a pixel.
const NEIGHBOURS: [(i64, i64); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// Whether, pair by pair, one state is lit and one is in shadow: 1 and 0 are the only two numbers with this `or` and `xor`.
fn differing(a: &[i8], b: &[i8], differ: &mut [u8]) {
    for ((a, b), differ) in a.iter().zip(b).zip(differ) {
        *differ =
            u8::from((a | b == TruthMask::LIT | TruthMask::SHADOW) & (a ^ b == TruthMask::LIT ^ TruthMask::SHADOW));
    }
}

/// Where numbers are not 0, which is rare: eight at once are looked at.
fn places(numbers: &[u8]) -> impl Iterator<Item = usize> {
    let eights = numbers.chunks(8).enumerate().filter(|(_, eight)| eight.iter().fold(0, |any, n| any | n) != 0);
    eights.flat_map(|(k, eight)| (0..eight.len()).filter(|&i| eight[i] != 0).map(move |i| 8 * k + i))
}

/// The samples of pixels that face the light and are in shadow, or whose state is not known, or that are beside one in shadow.
fn shaded(image: &[i8], facing: &[u32], width: usize, check: impl Fn() -> Result<()>) -> Result<Vec<u32>> {
    let height = image.len() / width;
    // Pixels of a row in shadow, and the ones beside them; 0 at both ends. An image has no state where nothing faces the light.
    let spread = |y: usize, dark: &mut [u8], into: &mut [u8]| {
        let row = &image[y * width..(y + 1) * width];
        dark[1..=width].iter_mut().zip(row).for_each(|(dark, state)| *dark = u8::from(*state == TruthMask::SHADOW));
        for (x, into) in into.iter_mut().enumerate() {
            *into = dark[x] | dark[x + 1] | dark[x + 2];
        }
    };
    let mut dark = vec![0; width + 2];
    let [mut above, mut here, mut below] = [vec![0; width], vec![0; width], vec![0; width]];
    spread(0, &mut dark, &mut here);
    let (mut found, mut chosen) = (Vec::new(), vec![0; width]);
    for y in 0..height {
        if y.is_multiple_of(ROWS_AT_ONCE) {
            check()?;
        }
        if y + 1 < height {
            spread(y + 1, &mut dark, &mut below);
        } else {
            below.fill(0);
        }
        let row = &image[y * width..(y + 1) * width];
        for (x, chosen) in chosen.iter_mut().enumerate() {
            *chosen = above[x] | here[x] | below[x] | u8::from(row[x] != TruthMask::LIT);
        }
        let facing = &facing[y * width..(y + 1) * width];
        found.extend(places(&chosen).map(|x| facing[x]).filter(|&sample| sample != NO_SAMPLE));
        std::mem::swap(&mut above, &mut here);
        std::mem::swap(&mut here, &mut below);
    }
    Ok(found)
}

/// Whether two samples of neighbouring pixels are of one surface, curved or not.
fn is_one_surface(picture: &Picture, (p, n): (DVec3, DVec3), (q, m): (DVec3, DVec3)) -> bool {
    picture.is_on_plane((p, n), q) || picture.is_on_plane((q, m), p)
}

/// The place of a pixel on Morton's curve.
fn morton(x: u32, y: u32) -> u32 {
    let spread = |v: u32| {
        let v = (v | v << 8) & 0x00ff_00ff;
        let v = (v | v << 4) & 0x0f0f_0f0f;
        let v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(x & 0xffff) | spread(y & 0xffff) << 1
}

/// The numbers below `count` in the order of their reversed bits.
fn bit_reversed(count: usize) -> impl Iterator<Item = usize> {
    let bits = usize::BITS - count.saturating_sub(1).leading_zeros();
    let room = if count == 0 { 0 } else { 1_usize << bits };
    (0..room)
        .map(move |i| if bits == 0 { i } else { i.reverse_bits() >> (usize::BITS - bits) })
        .filter(move |&i| i < count)
}
