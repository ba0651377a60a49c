//! Which texels of the maps the pixels of a picture look up, and how far away they compare there.

use rayon::prelude::*;

use super::comparison::Comparison;
use super::mask::MaskInput;
use crate::aliasing::receivers::{RUN, Receivers};
use crate::error::{Error, Result};
use crate::render::{Asked, Marks};

impl MaskInput<'_> {
    /// What the pixels look up in each map; nothing of maps that no pixel asks.
    ///
    /// # Errors
    /// [`Error::Interrupted`], and [`Error::InvalidArgument`] where memory is short.
    pub fn asks(&self) -> Result<Vec<Option<Asked>>> {
        let (lookups, surfaces, progress) = (self.lookups, &self.surfaces, self.progress);
        let marks = (0..lookups.count()).map(|k| Marks::new(lookups.map(k).size)).collect::<Result<Vec<_>>>()?;
        let width = surfaces.size[0] as usize;
        let rows = surfaces.triangle.len() / width.max(1);
        (0..rows).into_par_iter().try_for_each(|y| {
            progress.check()?;
            let mut run = Receivers::NONE;
            for first in (y * width..(y + 1) * width).step_by(RUN) {
                let count = RUN.min((y + 1) * width - first);
                run.read(surfaces, first, count);
                let chosen = self.maps_of(&run, &run.shown(surfaces, self.light, first, count));
                for (i, k) in chosen[..count].iter().enumerate() {
                    let Ok(k) = usize::try_from(*k) else { continue };
                    let next = self.next(first + i, k).map(|next| next.map);
                    for k in std::iter::once(k).chain(next) {
                        let map = lookups.map(k);
                        if let Comparison::At(reference) = map.compare_at(run.point(i), run.normal(i)) {
                            let reach = reference.kernel.reach();
                            marks[k].add(reference.p_texel, reach, map.farthest_within(&reference, reach));
                        }
                    }
                }
            }
            Ok::<_, Error>(())
        })?;
        let asked = marks.into_iter().zip(&lookups.p.partitions).enumerate().map(|(k, (marks, partition))| {
            marks.is_asked().then(|| marks.finish(partition, surfaces.origin, &lookups.map(k).stored))
        });
        Ok(asked.collect())
    }
}
