//! Which of several lights arrive at each pixel, a bit per light: one pass over the pixels for all lights whose map is there.
//!
//! Source: Chong and Gortler 2007 `[chong2007]`, section 3: a buffer of four bytes a pixel has room for the states of 32 lights.
//! A run of receivers is read once, and the lights look at it one after the other; runs that a light does not face are
//! left out. The light is that of masks, bit for bit, and so are the states.

use rayon::prelude::*;

use super::lookup::Lookups;
use super::runs::Compared;
use crate::aliasing::receivers::{RUN, Receivers, Shown};
use crate::error::{Error, Result};
use crate::image::{ShadowMask, ShadowStates, Surfaces};
use crate::progress::Progress;
use crate::scene::Light;

/// A light whose only map is there.
pub struct OnlyMap<'a> {
    /// Which of all lights it is.
    pub number: usize,
    pub light: &'a Light,
    pub lookups: Lookups<'a>,
    /// As many texels as the lookups say.
    pub map: Vec<f32>,
}

impl OnlyMap<'_> {
    /// The picture that says whether the light arrives.
    pub fn picture(&self) -> usize {
        self.number / ShadowStates::PER_PICTURE
    }
}

/// Sets the bits of some lights in their picture of the surfaces, where they arrive.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn set_states(surfaces: &Surfaces, lights: &[OnlyMap], states: &mut [u32], progress: &Progress) -> Result<()> {
    let width = surfaces.size[0] as usize;
    states.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        progress.check()?;
        set_in_row(surfaces, lights, y * width, row);
        Ok::<_, Error>(())
    })
}

/// The same of a row, whose first pixel is given.
fn set_in_row(surfaces: &Surfaces, lights: &[OnlyMap], first: usize, row: &mut [u32]) {
    let (mut run, mut found, mut lit) = (Receivers::NONE, Compared::NONE, [1.0; RUN]);
    for (first, states) in (first..).step_by(RUN).zip(row.chunks_mut(RUN)) {
        let count = states.len();
        if surfaces.triangle[first..first + count].iter().all(|triangle| *triangle < 0) {
            continue;
        }
        run.read(surfaces, first, count);
        for one in lights {
            let shown = run.shown(surfaces, one.light, first, count);
            if !shown.contains(&Shown::Facing) {
                continue;
            }
            one.lookups.map(0).light_of_facing(&one.map, &run, &shown, &mut found, &mut lit);
            let bit = one.number % ShadowStates::PER_PICTURE;
            for (i, states) in states.iter_mut().enumerate() {
                let arrives = !found.is_held[i] | (lit[i] >= ShadowMask::LIT_FROM);
                *states |= u32::from((shown[i] == Shown::Facing) & arrives) << bit;
            }
        }
    }
}
