//! The passes over a scene: depth alone, and depth with the number of the visible triangle.

use std::mem::MaybeUninit;

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use super::faces::Faces;
use super::raster::{
    BandArea, Bands, Batches, Bins, Cover, DepthPixels, Draw, Entries, IdPixels, LANES, LayerPixels, Pixels, Round,
    SLAB, Scratch, Tested, Tiles, Viewport, draw,
};
use super::rooms::{Rooms, Turn};
use crate::error::{Error, Result};
use crate::memory::{unwritten, written, written_part};
use crate::progress::Progress;
use crate::render::Keep;
use crate::scene::Scene;

/// The number of no triangle.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// What a pass draws: the view, and where the work goes.
pub struct Pass<'a> {
    pub scene: &'a Scene,
    pub clip_from_world: DMat4,
    pub size: [u32; 2],
    pub faces: Faces,
    pub keep: Keep<'a>,
    pub scratch: &'a mut Scratch,
    pub progress: &'a Progress,
}

impl Pass<'_> {
    /// Draws depth, 1 where nothing is, into all of `depth` (rows from the top).
    pub fn depth(&mut self, depth: &mut [MaybeUninit<f32>]) -> Result<()> {
        self.depth_from::<false>(depth)
    }

    /// Draws depth minus 1, 0 where nothing is, into all of `depth`: f32 has as many digits of a depth near the far plane as of
    /// one near the near plane, which linear depths need.
    pub fn depth_to_far(&mut self, depth: &mut [MaybeUninit<f32>]) -> Result<()> {
        self.clip_from_world = to_far(&self.clip_from_world);
        self.depth_from::<true>(depth)
    }

    /// The same for the two nearest depths that differ.
    pub fn layers_to_far(&mut self, first: &mut [MaybeUninit<f32>], second: &mut [MaybeUninit<f32>]) -> Result<()> {
        self.clip_from_world = to_far(&self.clip_from_world);
        let drawn_size = drawn_size(self.size);
        if drawn_size == self.size {
            return self.draw_layers(drawn_size, first, second);
        }
        let n = pixel_count(drawn_size);
        let (mut wide, mut wide_second) = (unwritten(n)?, unwritten(n)?);
        self.draw_layers(drawn_size, &mut wide, &mut wide_second)?;
        // SAFETY: written above.
        unsafe {
            crop(written_part(&mut wide), drawn_size, first, self.size);
            crop(written_part(&mut wide_second), drawn_size, second, self.size);
        }
        Ok(())
    }

    fn depth_from<const TO_FAR: bool>(&mut self, depth: &mut [MaybeUninit<f32>]) -> Result<()> {
        let drawn_size = drawn_size(self.size);
        if drawn_size != self.size {
            let mut wide = unwritten(pixel_count(drawn_size))?;
            self.draw_depth::<TO_FAR>(drawn_size, &mut wide)?;
            // SAFETY: written above.
            crop(unsafe { written_part(&mut wide) }, drawn_size, depth, self.size);
            return Ok(());
        }
        self.draw_depth::<TO_FAR>(drawn_size, depth)
    }

    /// Depth, -1 at the near plane and 0 at the far plane or where nothing is, and the scene-wide number of the triangle seen,
    /// [`NO_TRIANGLE`] where nothing is. For an eye, whose surfaces may be at any multiple of its near depth: f32 has as many
    /// digits of a depth close to 0 as of any other, while those close to 1 are all alike.
    pub fn depth_and_ids(&mut self) -> Result<(Vec<f32>, Vec<u32>)> {
        let drawn_size = drawn_size(self.size);
        let n = pixel_count(drawn_size);
        let (mut depth, mut ids) = (unwritten(n)?, unwritten(n)?);
        self.draw_ids(drawn_size, &mut depth, &mut ids)?;
        // SAFETY: written above.
        let (mut depth, mut ids) = unsafe { (written(depth), written(ids)) };
        if drawn_size != self.size {
            let n = pixel_count(self.size);
            let (mut narrow, mut narrow_ids) = (unwritten(n)?, unwritten(n)?);
            crop(&depth, drawn_size, &mut narrow, self.size);
            crop(&ids, drawn_size, &mut narrow_ids, self.size);
            // SAFETY: `crop` writes all of its target.
            (depth, ids) = unsafe { (written(narrow), written(narrow_ids)) };
        }
        Ok((depth, ids))
    }

    fn draw_depth<const TO_FAR: bool>(&mut self, size: [u32; 2], depth: &mut [MaybeUninit<f32>]) -> Result<()> {
        let (progress, image) = (self.progress, self.size);
        let mut rooms = Rooms::new(size, DepthPixels::<TO_FAR>::FAR);
        self.for_each_round(size, rooms.far, false, |round, cover, bands| {
            let parts = rooms.parts(bands, depth).zip(cover.bands_mut());
            parts.try_for_each_init(Vec::new, |spare, (part, tiles)| {
                progress.check()?;
                let (band, area) = (part.band, part.area);
                part.draw(turn_of(round, band), spare, |depth| {
                    draw_band(round, band, area, image, tiles, &mut DepthPixels::<TO_FAR> { depth });
                });
                Ok(())
            })
        })?;
        rooms.finish(depth);
        Ok(())
    }

    fn draw_layers(
        &mut self,
        size: [u32; 2],
        first: &mut [MaybeUninit<f32>],
        second: &mut [MaybeUninit<f32>],
    ) -> Result<()> {
        let (progress, image) = (self.progress, self.size);
        let far = LayerPixels::FAR;
        let (mut rooms, mut rooms_of_second) = (Rooms::new(size, far), Rooms::new(size, far));
        self.for_each_round(size, far, false, |round, cover, bands| {
            let parts = rooms.parts(bands, first).zip(rooms_of_second.parts(bands, second)).zip(cover.bands_mut());
            parts.try_for_each_init(Default::default, |spare: &mut [Vec<f32>; 2], ((part, part_of_second), tiles)| {
                progress.check()?;
                let (band, area, [spare, spare_of_second]) = (part.band, part.area, spare);
                part.draw(turn_of(round, band), spare, |first| {
                    part_of_second.draw(turn_of(round, band), spare_of_second, |second| {
                        draw_band(round, band, area, image, tiles, &mut LayerPixels { first, second });
                    });
                });
                Ok(())
            })
        })?;
        rooms.finish(first);
        rooms_of_second.finish(second);
        Ok(())
    }

    fn draw_ids(&mut self, size: [u32; 2], depth: &mut [MaybeUninit<f32>], ids: &mut [MaybeUninit<u32>]) -> Result<()> {
        let (progress, image) = (self.progress, self.size);
        let (mut rooms, mut rooms_of_ids) = (Rooms::new(size, IdPixels::FAR), Rooms::new(size, NO_TRIANGLE));
        self.for_each_round(size, rooms.far, true, |round, cover, bands| {
            let parts = rooms.parts(bands, depth).zip(rooms_of_ids.parts(bands, ids)).zip(cover.bands_mut());
            let spare = || (Vec::new(), Vec::new());
            parts.try_for_each_init(spare, |(spare, spare_of_ids), ((part, part_of_ids), tiles)| {
                progress.check()?;
                let (band, area) = (part.band, part.area);
                part.draw(turn_of(round, band), spare, |depth| {
                    part_of_ids.draw(turn_of(round, band), spare_of_ids, |id| {
                        draw_band(round, band, area, image, tiles, &mut IdPixels { depth, id });
                    });
                });
                Ok(())
            })
        })?;
        rooms.finish(depth);
        rooms_of_ids.finish(ids);
        Ok(())
    }

    /// Calls `draw` with each round of triangles before the depth of the far plane, binned; at least once.
    fn for_each_round(
        &mut self,
        drawn_size: [u32; 2],
        far: f32,
        numbered: bool,
        mut draw: impl FnMut(Round, &mut Cover, Bands) -> Result<()>,
    ) -> Result<()> {
        let viewport = Viewport::new(self.size, drawn_size, far);
        let batches = Batches::new(self.scene, &self.clip_from_world, &viewport, self.faces, self.keep)?;
        let bands = Bands::new(drawn_size);
        batches.for_each_round(&viewport, bands, numbered, self.scratch, self.progress, |round, cover| {
            draw(round, cover, bands)
        })
    }
}

/// The matrix with depths of 1 less.
fn to_far(clip_from_world: &DMat4) -> DMat4 {
    DMat4::from_translation(DVec3::NEG_Z) * *clip_from_world
}

/// The matrix if it can be drawn with.
pub fn checked_matrix(matrix: &DMat4) -> Result<DMat4> {
    if matrix.is_finite() {
        return Ok(*matrix);
    }
    let fix = "check where the matrix comes from";
    Err(Error::argument("shadow_clip_from_world", "16 finite numbers", "a NaN or an infinity", fix))
}

pub fn pixel_count(size: [u32; 2]) -> usize {
    size[0] as usize * size[1] as usize
}

/// An image narrower than a vector is drawn as wide as one and cut afterwards.
fn drawn_size([width, height]: [u32; 2]) -> [u32; 2] {
    [width.max(LANES as u32), height]
}

fn crop<T: Copy>(wide: &[T], wide_size: [u32; 2], narrow: &mut [MaybeUninit<T>], size: [u32; 2]) {
    let rows = wide.chunks_exact(wide_size[0] as usize).zip(narrow.chunks_exact_mut(size[0] as usize));
    for (from, to) in rows {
        for (to, from) in to.iter_mut().zip(from) {
            to.write(*from);
        }
    }
}

/// What a round leaves to a band.
fn turn_of(round: Round, band: usize) -> Turn {
    Turn { is_first: round.is_first, is_empty: round.is_empty(band) }
}

/// Draws what a round leaves to a band of an image of `size` pixels; `tiles` are its tiles.
fn draw_band<P: Pixels>(round: Round, band: usize, area: BandArea, size: [u32; 2], tiles: &mut [f32], pixels: &mut P) {
    match round.tested {
        None => draw_round(round, band, area, tiles, pixels),
        Some(draws) => draw_tested(round, draws, band, area, size, tiles, pixels),
    }
}

/// Kept apart, for the loops of scenes without alpha tests to be laid out as if there were none.
#[inline(never)]
fn draw_tested<P: Pixels>(
    round: Round,
    draws: &[Draw],
    band: usize,
    area: BandArea,
    size: [u32; 2],
    tiles: &mut [f32],
    pixels: &mut P,
) {
    draw_round(round, band, area, tiles, &mut Tested::new(pixels, draws, area, size));
}

/// Slab by slab, nearest first; after each of them the tiles are read again.
#[inline(never)]
fn draw_round<P: Pixels>(round: Round, band: usize, area: BandArea, tiles: &mut [f32], pixels: &mut P) {
    let (mut is_first, mut rest) = (round.is_first, round.scratch.bins());
    while !rest.is_empty() {
        let (slab, after) = rest.split_at(SLAB.min(rest.len()));
        rest = after;
        let mut columns = 0;
        for bins in slab {
            let cover = (round.hides && !is_first).then_some(Tiles { grid: round.grid, farthest: tiles });
            columns |= draw_bins(round, bins, band, area, cover, pixels);
        }
        if round.hides && !(rest.is_empty() && round.is_last) {
            round.grid.read(columns, area, pixels.hiding(), tiles);
        }
        is_first = false;
    }
}

/// Draws a chunk; bits of the columns of tiles that it has touched.
fn draw_bins<P: Pixels>(
    round: Round,
    bins: &Bins,
    band: usize,
    area: BandArea,
    cover: Option<Tiles>,
    pixels: &mut P,
) -> u64 {
    let bin = bins.band(band);
    bin.fragments.draw(pixels);
    let (vertices, extra, large) = (&round.scratch.vertices[..], &bins.extra[..], &bins.large[..]);
    let (entries, large_here) = (&bin.entries[..], &bin.large[..]);
    let entries = Entries { entries, vertices, extra, large, large_here, grid: round.grid, cover };
    bin.columns | draw(entries, area, pixels)
}
