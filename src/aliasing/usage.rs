//! Which texels the pixels of an image read: where each receiver lies in its map, and how often each texel is asked.
//!
//! A texel that no pixel reads is waste; one that many read shows as a stair (theory.md E.2: the two sides of one Jacobian).

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::footprint::{check_surfaces, local_maps};
use super::placed::{Placed, only_matrix, place, texel_of};
use super::receivers::{RUN, Receivers, Shown};
use crate::error::{Error, Result};
use crate::image::{Footprint, Surfaces};
use crate::memory::{check_images, with_room};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::scene::{Camera, Light};

/// Pixels between two looks at whether to stop: well below a millisecond of work.
const AT_ONCE: usize = 4096;
/// Texels between two looks at whether to go on.
const TEXELS_AT_ONCE: usize = 1 << 20;

/// Where each pixel's receiver lies in its map.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// Texel coordinates, x to the right and y down; texel (i, j) covers [i, i + 1) x [j, j + 1). NaN where `map` is negative.
    pub texel: Vec<[f64; 2]>,
    /// As [`Footprint::map`].
    pub map: Vec<i16>,
}

/// Where the receivers of an image lie in maps of `resolution` texels (width, height). The camera tells their depth, by which
/// they find their map: the one that sees them, or another that the maps were made for.
///
/// # Errors
/// [`Error::InvalidArgument`] for no map, a matrix that is not finite, or an empty image; [`Error::Interrupted`].
pub fn locate(
    surfaces: &Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    resolution: [u32; 2],
    progress: &Progress,
) -> Result<Located> {
    check_surfaces(surfaces)?;
    let local = local_maps(p, surfaces.origin)?;
    let size = resolution.map(f64::from);
    let pixels = surfaces.triangle.len();
    check_images("gbuffer", 1, surfaces.size, size_of::<[f64; 2]>() + size_of::<i16>())?;
    let width = surfaces.size[0] as usize;
    let (mut texel, mut map) = (with_room("gbuffer", pixels)?, with_room("gbuffer", pixels)?);
    // Touched step by step: so much memory takes longer than a wait for Ctrl-C may.
    for filled in (0..pixels).step_by(TEXELS_AT_ONCE).map(|first| pixels.min(first + TEXELS_AT_ONCE)) {
        progress.check()?;
        texel.resize(filled, [f64::NAN; 2]);
        map.resize(filled, Footprint::NOTHING);
    }
    let only = only_matrix(&local);
    let rows = texel.par_chunks_mut(width).zip(map.par_chunks_mut(width)).enumerate();
    rows.try_for_each_init(
        || (Receivers::NONE, Placed::NONE),
        |(run, placed), (y, (texel, map))| {
            progress.check()?;
            for x in (0..width).step_by(RUN) {
                let (first, count) = (y * width + x, RUN.min(width - x));
                run.read(surfaces, first, count);
                if let Some(only) = only {
                    place(only, size, run, placed);
                }
                for (i, shown) in run.shown(surfaces, light, first, count).into_iter().take(count).enumerate() {
                    (texel[x + i], map[x + i]) = match (shown, only) {
                        (Shown::Nothing, _) => continue,
                        (Shown::Averted, _) => ([f64::NAN; 2], Footprint::AVERTED),
                        (Shown::Facing, Some(_)) if placed.is_held[i] => ([placed.texel[0][i], placed.texel[1][i]], 0),
                        (Shown::Facing, Some(_)) => ([f64::NAN; 2], Footprint::NO_MAP),
                        (Shown::Facing, None) => {
                            let p = run.point(i);
                            match local.choose(p, camera.depth_of(surfaces.origin + p)) {
                                Some(k) => (texel_of(local.partitions[k].project(p).0, size), k as i16),
                                None => ([f64::NAN; 2], Footprint::NO_MAP),
                            }
                        }
                    };
                }
            }
            Ok::<_, Error>(())
        },
    )?;
    Ok(Located { texel, map })
}

/// How many pixels read each texel: layer after layer, rows from the top.
///
/// `read` calls its last argument with each texel (column, row) that a pixel reads in a map. Beyond the map's edge it reads the
/// texel there.
///
/// # Errors
/// [`Error::InvalidArgument`] for more texels than fit into memory; [`Error::Interrupted`].
pub fn reads(
    located: &Located,
    layers: usize,
    resolution: [u32; 2],
    read: impl Fn(usize, usize, &mut dyn FnMut([i64; 2])) + Sync,
    progress: &Progress,
) -> Result<Vec<u32>> {
    let [width, height] = resolution.map(|n| n as usize);
    let texels = layers * width * height;
    check_images("resolution", layers, resolution, size_of::<u32>())?;
    let mut counts: Vec<AtomicU32> = Vec::new();
    counts.try_reserve_exact(texels).map_err(|_| {
        let got = format!("{layers} maps of {width} x {height}");
        Error::argument("resolution", "maps that fit into memory", got, "choose fewer or smaller maps")
    })?;
    for texels in (0..texels).step_by(TEXELS_AT_ONCE).map(|first| texels.min(first + TEXELS_AT_ONCE)) {
        progress.check()?;
        counts.resize_with(texels, AtomicU32::default);
    }
    let held = |x: i64, side: usize| x.clamp(0, side as i64 - 1) as usize;
    located.map.par_chunks(AT_ONCE).enumerate().try_for_each(|(chunk, maps)| {
        progress.check()?;
        for (i, &map) in maps.iter().enumerate().filter(|(_, map)| **map >= 0) {
            read(chunk * AT_ONCE + i, map as usize, &mut |[x, y]| {
                let row = (map as usize * height + held(y, height)) * width;
                counts[row + held(x, width)].fetch_add(1, Ordering::Relaxed);
            });
        }
        Ok::<_, Error>(())
    })?;
    progress.check()?;
    Ok(counts.into_iter().map(AtomicU32::into_inner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lookup_reads_its_texels_and_no_other() {
        let located = Located {
            texel: vec![[0.2, 0.9], [3.9, 1.0], [f64::NAN; 2], [4.0, 2.0], [1.5, 1.5]],
            map: vec![0, 1, Footprint::NO_MAP, 0, 0],
        };
        let read = |side: i64| {
            let located = &located;
            let read = move |pixel: usize, _: usize, count: &mut dyn FnMut([i64; 2])| {
                let [x, y] = located.texel[pixel].map(|x| (x - 0.5 * (side - 1) as f64).floor() as i64);
                (0..side * side).for_each(|n| count([x + n % side, y + n / side]));
            };
            reads(located, 2, [4, 2], read, &Progress::new()).unwrap()
        };
        let nearest = read(1);
        let mut expected = vec![0; 16];
        // (0, 0) of the first map; (3, 1) of the second; the far corner held to (3, 1); (1, 1).
        [0, 8 + 7, 7, 5].into_iter().for_each(|i| expected[i] += 1);
        assert_eq!(nearest, expected);
        let four = read(2);
        assert_eq!(four.iter().sum::<u32>(), 16, "four texels each, at the edge some twice");
        // 1.5 is a centre: itself with all of the weight, and its neighbours to the right and below.
        assert!(four[5] >= 1 && four[6] >= 1);
    }
}
