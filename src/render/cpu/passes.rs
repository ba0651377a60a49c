//! The passes over a scene: depth alone, and depth with the number of the visible triangle.

use std::mem::MaybeUninit;

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use super::faces::Faces;
use super::raster::{
    BandArea, Bands, Batches, Bins, DepthPixels, Draw, Entries, IdPixels, LANES, LayerPixels, Pixels, Round, Scratch,
    Tested, Viewport, draw,
};
use crate::error::{Error, Result};
use crate::memory::{filled, unwritten, written, written_part};
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
        let far = DepthPixels::<TO_FAR>::FAR;
        self.for_each_round(size, far, false, |round, bands, first| {
            let part = bands.rows() * size[0] as usize;
            depth.par_chunks_mut(part).enumerate().try_for_each(|(band, depth)| {
                progress.check()?;
                // SAFETY: the first round writes everything.
                let depth = if first { filled(depth, far) } else { unsafe { written_part(depth) } };
                let area = band_area(size, bands, band);
                draw_band(round, band, area, image, &mut DepthPixels::<TO_FAR> { depth });
                Ok(())
            })
        })
    }

    fn draw_layers(
        &mut self,
        size: [u32; 2],
        first: &mut [MaybeUninit<f32>],
        second: &mut [MaybeUninit<f32>],
    ) -> Result<()> {
        let (progress, image) = (self.progress, self.size);
        let far = LayerPixels::FAR;
        self.for_each_round(size, far, false, |round, bands, is_first| {
            let part = bands.rows() * size[0] as usize;
            let parts = first.par_chunks_mut(part).zip(second.par_chunks_mut(part)).enumerate();
            parts.try_for_each(|(band, (first, second))| {
                progress.check()?;
                // SAFETY: the first round writes everything.
                let (first, second) = if is_first {
                    (filled(first, far), filled(second, far))
                } else {
                    unsafe { (written_part(first), written_part(second)) }
                };
                draw_band(round, band, band_area(size, bands, band), image, &mut LayerPixels { first, second });
                Ok(())
            })
        })
    }

    fn draw_ids(&mut self, size: [u32; 2], depth: &mut [MaybeUninit<f32>], ids: &mut [MaybeUninit<u32>]) -> Result<()> {
        let (progress, image) = (self.progress, self.size);
        self.for_each_round(size, IdPixels::FAR, true, |round, bands, first| {
            let part = bands.rows() * size[0] as usize;
            let parts = depth.par_chunks_mut(part).zip(ids.par_chunks_mut(part)).enumerate();
            parts.try_for_each(|(band, (depth, id))| {
                progress.check()?;
                // SAFETY: the first round writes everything.
                let (depth, id) = if first {
                    (filled(depth, IdPixels::FAR), filled(id, NO_TRIANGLE))
                } else {
                    unsafe { (written_part(depth), written_part(id)) }
                };
                let area = band_area(size, bands, band);
                draw_band(round, band, area, image, &mut IdPixels { depth, id });
                Ok(())
            })
        })
    }

    /// Calls `draw` with each round of triangles before the depth of the far plane, binned, and whether it is the first; at
    /// least once.
    fn for_each_round(
        &mut self,
        drawn_size: [u32; 2],
        far: f32,
        numbered: bool,
        mut draw: impl FnMut(Round, Bands, bool) -> Result<()>,
    ) -> Result<()> {
        let viewport = Viewport::new(self.size, drawn_size, far);
        let batches = Batches::new(self.scene, &self.clip_from_world, &viewport, self.faces, self.keep)?;
        let bands = Bands::new(drawn_size);
        let mut first = true;
        batches.for_each_round(&viewport, bands, numbered, self.scratch, self.progress, |round| {
            draw(round, bands, std::mem::take(&mut first))
        })?;
        if first {
            // Nothing is in view.
            self.scratch.chunks = 0;
            draw(Round { scratch: self.scratch, tested: None }, bands, true)?;
        }
        Ok(())
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

/// Draws what a round leaves to a band of an image of `size` pixels.
fn draw_band<P: Pixels>(round: Round, band: usize, area: BandArea, size: [u32; 2], pixels: &mut P) {
    match round.tested {
        None => draw_round(round.scratch, band, area, pixels),
        Some(draws) => draw_tested(round.scratch, draws, band, area, size, pixels),
    }
}

/// Kept apart, for the loops of scenes without alpha tests to be laid out as if there were none.
#[inline(never)]
fn draw_tested<P: Pixels>(
    scratch: &Scratch,
    draws: &[Draw],
    band: usize,
    area: BandArea,
    size: [u32; 2],
    pixels: &mut P,
) {
    draw_round(scratch, band, area, &mut Tested::new(pixels, draws, area, size));
}

#[inline(never)]
fn draw_round<P: Pixels>(scratch: &Scratch, band: usize, area: BandArea, pixels: &mut P) {
    for bins in scratch.bins() {
        draw_bins(scratch, bins, band, area, pixels);
    }
}

fn draw_bins<P: Pixels>(scratch: &Scratch, bins: &Bins, band: usize, area: BandArea, pixels: &mut P) {
    let bin = bins.band(band);
    bin.fragments.draw(pixels);
    let (vertices, extra, large) = (&scratch.vertices[..], &bins.extra[..], &bins.large[..]);
    draw(Entries { entries: &bin.entries, vertices, extra, large }, area, pixels);
}

fn band_area(size: [u32; 2], bands: Bands, band: usize) -> BandArea {
    let first_row = band * bands.rows();
    BandArea { size, first_row: first_row as i32, rows: bands.rows().min(size[1] as usize - first_row) as i32 }
}
