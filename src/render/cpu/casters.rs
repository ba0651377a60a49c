//! What is drawn into maps of which a picture's pixels, or nobody, says what is looked up.

use super::lookup::{Lookups, MaskInput};
use super::stored::StoredMap;
use crate::error::Result;
use crate::image::Surfaces;
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::{Asked, Casters, Cull, Keep, MaskSettings, Rule, no_picture};
use crate::scene::{Camera, Light, Scene};

/// What the pixels of a picture look up in each map; nothing of maps that none asks.
///
/// # Errors
/// As [`Lookups::new`].
pub fn asked_of(
    surfaces: Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<Vec<Option<Asked>>> {
    let lookups = &Lookups::new(p, camera, light, surfaces.origin, settings)?;
    MaskInput { surfaces, camera, light, lookups, progress }.asks()
}

/// What a setting that needs no picture keeps.
///
/// # Errors
/// [`no_picture`].
pub fn keep_of<'a>(cull: Cull) -> Result<Keep<'a>> {
    match cull {
        Cull::None => Ok(Keep::All),
        Cull::Volume => Ok(Keep::InVolume),
        Cull::Seen => Err(no_picture()),
    }
}

/// What becomes of each instance in each map; `asked` says what is looked up, where that counts.
///
/// # Errors
/// [`no_picture`], and [`crate::Error::InvalidArgument`] for a matrix that cannot be drawn with.
pub fn casters_of(
    scene: &Scene,
    p: &Parameterization,
    cull: Cull,
    asked: Option<&[Option<Asked>]>,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<Vec<Casters>> {
    let (size, stored) = (settings.resolution, settings.stored);
    let of_map = |k: usize| {
        progress.check()?;
        let partition = &p.partitions[k];
        let volume = StoredMap { scene, partition, size, stored, keep: Keep::InVolume }.volume()?;
        let rules = match asked.map(|asked| asked[k].as_ref()) {
            None => keep_of(cull)?.rules(scene, &volume),
            Some(Some(asked)) => Keep::Asked(asked).rules(scene, &volume),
            // No pixel asks the map.
            Some(None) => {
                let seen = |rule: Rule| if rule == Rule::Drawn { Rule::Unseen } else { rule };
                Keep::InVolume.rules(scene, &volume).into_iter().map(seen).collect()
            }
        };
        Ok(Casters::new(scene, rules))
    };
    (0..p.partitions.len()).map(of_map).collect()
}
