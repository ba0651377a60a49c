//! Maps as the samples of a picture ask them: which of them each asks, and what a texel of that is in the picture.

use glam::{DMat2, DVec2};

use crate::aliasing::placed::{Placed, only_matrix, place};
use crate::aliasing::receivers::{RUN, Receivers};
use crate::aliasing::texel::{Eye, TexelMap, warped_texel};
use crate::error::{Error, Result};
use crate::focus::{Picture, Samples, Shadows};
use crate::parameterization::{Parameterization, Region};
use crate::progress::Progress;

/// Samples between two looks at whether to go on: some milliseconds of work.
const AT_ONCE: usize = 1 << 16;

/// Samples with the maps that they ask.
pub(super) struct AskedMaps<'a> {
    pub samples: &'a Samples,
    pub picture: &'a Picture,
    pub shadows: &'a Shadows,
    eye: Eye,
    /// Relative to the samples' origin.
    local: Parameterization,
    maps: Vec<TexelMap>,
}

impl<'a> AskedMaps<'a> {
    /// Maps of `size` texels.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for samples without shadow states, or a matrix that is not finite.
    pub fn new(samples: &'a Samples, p: &Parameterization, size: [u32; 2]) -> Result<Self> {
        let (Some(picture), Some(shadows)) = (&samples.picture, &samples.shadows) else { return Err(no_shadows()) };
        let eye = Eye::new(&picture.camera, samples.origin, picture.size);
        let local = p.relative_to(samples.origin)?;
        let maps = local.partitions.iter().map(|map| TexelMap::new(map, size)).collect();
        Ok(Self { samples, picture, shadows, eye, local, maps })
    }
    /// d(pixel) / d(texel) at a sample; nothing where no map holds it.
    pub fn texel(&self, i: usize) -> Option<DMat2> {
        self.asked_texel(i).map(|(_, texel)| texel)
    }
    /// The same, and which map holds it.
    pub fn asked_texel(&self, i: usize) -> Option<(usize, DMat2)> {
        let k = self.asked(i)?;
        let (point, normal) = self.samples.sample(i);
        let at = point - self.samples.origin;
        let texel = warped_texel(&self.maps[k], &self.local.partitions[k].post_warp, &self.eye, at, normal);
        let [xx, xy, yx, yy] = texel.jacobian;
        Some((k, DMat2::from_cols(DVec2::new(xx, yx), DVec2::new(xy, yy))))
    }
    /// Whether a sample faces the light, within its reach and the camera's planes.
    pub fn counts(&self, i: usize) -> bool {
        let (point, normal) = self.samples.sample(i);
        self.samples.counts(&self.picture.camera, &self.shadows.light, &Region::ALL, point, normal)
    }
    /// Those of some samples that are lost.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn lost(&self, samples: impl Iterator<Item = usize>, progress: &Progress) -> Result<Vec<usize>> {
        self.unheld(samples.filter(|&i| self.counts(i)), progress)
    }
    /// Those of all samples that are lost.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn all_lost(&self, progress: &Progress) -> Result<Vec<usize>> {
        let Some(matrix) = only_matrix(&self.local) else {
            // Those that count, found in one sweep, before a map is asked.
            let (camera, light) = (&self.picture.camera, &self.shadows.light);
            let facing = self.samples.facing_watched(camera, light, &Region::ALL, || progress.check())?;
            return self.unheld(facing.into_iter().map(|i| i as usize), progress);
        };
        // A map holds most of them, which takes less to know than whether they count.
        let (mut run, mut placed, mut lost) = (Receivers::NONE, Placed::NONE, Vec::new());
        let (count, origin) = (self.samples.len(), self.samples.origin.to_array());
        for first in (0..count).step_by(RUN) {
            if first.is_multiple_of(AT_ONCE) {
                progress.check()?;
            }
            let some = first..count.min(first + RUN);
            for (i, p) in self.samples.points[some.clone()].iter().enumerate() {
                // Rounded as the world position is.
                (0..3).for_each(|axis| run.p[axis][i] = origin[axis] + f64::from(p[axis]) - origin[axis]);
            }
            place(matrix, [1.0; 2], &run, &mut placed);
            lost.extend(some.filter(|i| !placed.is_held[i - first]).filter(|&i| self.counts(i)));
        }
        Ok(lost)
    }
    /// Those of some samples that no map holds, whether they count or not.
    fn unheld(&self, samples: impl Iterator<Item = usize>, progress: &Progress) -> Result<Vec<usize>> {
        let mut found = Vec::new();
        for (n, i) in samples.enumerate() {
            if n.is_multiple_of(AT_ONCE) {
                progress.check()?;
            }
            if self.asked(i).is_none() {
                found.push(i);
            }
        }
        Ok(found)
    }
    fn asked(&self, i: usize) -> Option<usize> {
        let (point, _) = self.samples.sample(i);
        self.local.choose(point - self.samples.origin, self.picture.camera.depth_of(point))
    }
}

pub(super) fn no_shadows() -> Error {
    let fix = "make them from a picture with shadow states: view.samples()";
    Error::argument("samples", "samples of a picture that say what is in shadow", "samples without shadow states", fix)
}
