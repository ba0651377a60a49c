//! The light at runs of receivers through kernels that compare many texels: texel by texel, all receivers at once.
//!
//! Sums have the order of [`Kernel::average`], so that they are the same bit for bit.

use glam::{DMat2, DVec2};

use super::lookup::MapLookup;
use super::runs::{Compared, lit};
use crate::aliasing::receivers::RUN;
use crate::render::{Kernel, first_texel, integral_of_box, integral_of_tent, texels_across};
use crate::simd::dispatch;

dispatch! {
    /// The light of a kernel that compares many texels, in a map of as many texels as the lookup says; of a common case.
    pub(super) fn wide(kernel: Kernel, lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) = wide_body
}

#[inline(always)]
fn wide_body(kernel: Kernel, lookup: &MapLookup, map: &[f32], found: &Compared, light: &mut [f32; RUN]) {
    let sum = match kernel {
        Kernel::Box(size) => separable(lookup, map, found, size, integral_of_box),
        Kernel::Tent(size) => separable(lookup, map, found, size, integral_of_tent),
        Kernel::Disc(axes) => disc(lookup, map, found, axes),
        Kernel::Nearest | Kernel::Bilinear => unreachable!("they have functions of their own"),
    };
    for i in 0..RUN {
        light[i] = if found.is_compared[i] { sum[i] as f32 } else { 1.0 };
    }
}

/// How receivers compare with a texel each: 1 where it is lit, else 0. `w` is [`MapLookup::w_of_rows`] of the texels.
#[inline(always)]
fn compared(
    lookup: &MapLookup,
    map: &[f32],
    found: &Compared,
    w: &[f64; RUN],
    texel: impl Fn(usize) -> DVec2,
    mut take: impl FnMut(usize, f64),
) {
    let (mut z, mut index) = ([0.0; RUN], [0; RUN]);
    for i in 0..RUN {
        let texel = texel(i);
        z[i] = lookup.depth_in_run(found, i, texel + 0.5);
        index[i] = lookup.index_of(texel);
    }
    if found.asks_planes {
        lookup.depths_on_planes(found, |i| texel(i).x + 0.5, w, &mut z);
    }
    for i in 0..RUN {
        // SAFETY: the index has been held to the map, whose length the caller of `wide` has checked.
        take(i, unsafe { lit(map, index[i], z[i]) });
    }
}

/// The averages with weights that are products (14.3), (14.4), row after row.
#[inline(always)]
fn separable(
    lookup: &MapLookup,
    map: &[f32],
    found: &Compared,
    size: DVec2,
    integral: impl Fn(f64, f64) -> f64,
) -> [f64; RUN] {
    let mut first = [[0.0; RUN]; 2];
    // The integral up to the texel that is next, along each axis.
    let mut reached = [[0.0; RUN]; 2];
    for axis in 0..2 {
        for i in 0..RUN {
            first[axis][i] = first_texel(found.at[axis][i], size[axis]);
            reached[axis][i] = integral(first[axis][i] - found.at[axis][i], size[axis]);
        }
    }
    let mut weights = |axis: usize, step: usize, to: &mut [f64; RUN]| {
        for i in 0..RUN {
            let end = integral(first[axis][i] + (step + 1) as f64 - found.at[axis][i], size[axis]);
            to[i] = end - reached[axis][i];
            reached[axis][i] = end;
        }
    };
    let mut columns = vec![[0.0; RUN]; texels_across(size.x)];
    columns.iter_mut().enumerate().for_each(|(step, column)| weights(0, step, column));
    let (mut sum, mut height) = ([0.0; RUN], [0.0; RUN]);
    for row in 0..texels_across(size.y) {
        let mut across = [0.0; RUN];
        let w = &lookup.w_of_rows(found, |i| first[1][i] + row as f64 + 0.5);
        for (column, width) in columns.iter().enumerate() {
            let texel = |i: usize| DVec2::new(first[0][i] + column as f64, first[1][i] + row as f64);
            compared(lookup, map, found, w, texel, |i, lit| across[i] += width[i] * lit);
        }
        weights(1, row, &mut height);
        for i in 0..RUN {
            sum[i] += height[i] * across[i];
        }
    }
    sum
}

/// The averages over the points of a disc.
#[inline(always)]
fn disc(lookup: &MapLookup, map: &[f32], found: &Compared, axes: DMat2) -> [f64; RUN] {
    let (points, mut sum) = (lookup.kernels.disc(), [0.0; RUN]);
    for q in points {
        let step = axes * *q;
        let texel = |i: usize| (DVec2::new(found.at[0][i], found.at[1][i]) + step).floor();
        let w = &lookup.w_of_rows(found, |i| texel(i).y + 0.5);
        compared(lookup, map, found, w, texel, |i, lit| sum[i] += lit);
    }
    sum.map(|sum| sum / points.len() as f64)
}
