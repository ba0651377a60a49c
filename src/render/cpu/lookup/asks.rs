//! Which texels of the maps the pixels of a picture look up, and how far away they compare there.

use rayon::prelude::*;

use super::comparison::Comparison;
use super::lookup::MapLookup;
use super::mask::MaskInput;
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
            for pixel in y * width..(y + 1) * width {
                let Some((p, normal)) = surfaces.receiver(pixel) else { continue };
                let p_world = surfaces.origin + p;
                if !self.light.illuminates(p_world, normal) {
                    continue;
                }
                let Some(k) = lookups.choose(p, self.camera.depth_of(p_world)) else { continue };
                let next = self.next(pixel, k).map(|next| next.map);
                for k in std::iter::once(k).chain(next) {
                    let map = lookups.map(k);
                    if let Comparison::At(reference) = map.compare_at(p, normal) {
                        let reach = reference.kernel.reach();
                        marks[k].add(reference.p_texel, reach, map.farthest_within(&reference, reach));
                    }
                }
            }
            Ok::<_, Error>(())
        })?;
        let asked = marks.into_iter().zip(&lookups.p.partitions).enumerate().map(|(k, (marks, partition))| {
            let map: &MapLookup = lookups.map(k);
            marks.is_asked().then(|| marks.finish(partition, surfaces.origin, &map.stored))
        });
        Ok(asked.collect())
    }
}
