//! What is drawn into maps of which a picture's pixels, or nobody, says what is looked up.

use super::lookup::{Lookups, MaskInput};
use super::stored::StoredMap;
use crate::error::Result;
use crate::image::Surfaces;
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::{Asked, Casters, Cull, Keep, MaskSettings, Rule, check_size, no_picture};
use crate::scene::{Camera, Light, Scene};

/// How a renderer finds what the pixels of a picture look up in each map.
type AskedOf = fn(Surfaces, &Camera, &Light, &Parameterization, &MaskSettings, &Progress) -> Result<Vec<Option<Asked>>>;

/// What the pixels of a picture look up in each map; nothing of maps that none asks.
///
/// # Errors
/// As [`check_size`] and [`Lookups::new`].
pub fn asked_of(
    surfaces: Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<Vec<Option<Asked>>> {
    check_size("resolution", settings.resolution)?;
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

/// What becomes of each instance in each map; `asked_of` finds what the picture's pixels look up, where that counts.
///
/// # Errors
/// [`no_picture`], and [`crate::Error::InvalidArgument`] for a matrix that cannot be drawn with.
pub fn casters_of(
    scene: &Scene,
    p: &Parameterization,
    cull: Cull,
    picture: Option<(Surfaces, &Camera, &Light)>,
    settings: &MaskSettings,
    progress: &Progress,
    asked_of: AskedOf,
) -> Result<Vec<Casters>> {
    let (size, stored) = (check_size("resolution", settings.resolution)?, settings.stored);
    let asked = match (cull, picture) {
        (Cull::Seen, Some((surfaces, camera, light))) => {
            Some(asked_of(surfaces, camera, light, p, settings, progress)?)
        }
        _ => None,
    };
    let of_map = |k: usize| {
        progress.check()?;
        let partition = &p.partitions[k];
        let volume = StoredMap { scene, partition, size, stored, keep: Keep::InVolume }.volume()?;
        let rules = match asked.as_ref().map(|asked| asked[k].as_ref()) {
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
