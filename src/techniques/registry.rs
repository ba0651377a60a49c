//! Techniques by name.

use std::fmt::Debug;

use glam::DVec4;

use super::{Settings, Spec, TECHNIQUES};
use crate::error::{Error, Result};
use crate::focus::{Coverage, FocusedView, MapSize};
use crate::geometry::Rows;
use crate::parameterization::{Parameterization, Partition, PostWarp, Value};
use crate::scene::{Camera, Light, Scene};

/// A technique with its settings: a pure function from a view to a [`Parameterization`].
pub trait Technique: Debug + Send + Sync {
    /// What it says of itself.
    fn spec(&self) -> &'static Spec;
    /// Every parameter with its value, in the order of the spec.
    fn settings(&self) -> Vec<(&'static str, Value)>;
    /// The maps for one scene, camera and light, made for `resolution` texels along each side.
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`]; [`Error::InvalidArgument`] for a resolution that leaves no texel inside the border.
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization>;
}

/// A line of [`TECHNIQUES`].
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The self-description.
    pub spec: &'static Spec,
    /// The technique from checked settings.
    pub make: fn(Settings) -> Result<Box<dyn Technique>>,
}

/// The self-descriptions of all techniques.
pub fn specs() -> impl Iterator<Item = &'static Spec> {
    TECHNIQUES.iter().map(|entry| entry.spec)
}

/// A technique by name, with some of its parameters; the others keep their defaults.
///
/// # Errors
/// [`Error::UnknownName`] for the name of the technique or of a parameter; [`Error::InvalidArgument`] for a value.
///
/// # Examples
/// ```
/// use shadowlab::techniques::{Value, technique};
/// let t = technique("lispsm", &[("near".into(), Value::Choice("basic".into()))])?;
/// assert_eq!(t.spec().name, "lispsm");
/// assert!(technique("lipsm", &[]).unwrap_err().to_string().contains("uniform, lispsm"));
/// # Ok::<(), shadowlab::Error>(())
/// ```
pub fn technique(name: &str, params: &[(String, Value)]) -> Result<Box<dyn Technique>> {
    let entry = TECHNIQUES.iter().find(|entry| entry.spec.name == name).ok_or_else(|| Error::UnknownName {
        kind: "technique".into(),
        name: name.to_string(),
        valid: specs().map(|spec| spec.name.to_string()).collect(),
    })?;
    (entry.make)(entry.spec.resolve(params)?)
}

/// An error unless the technique serves the light.
pub(super) fn check_light(spec: &Spec, light: &Light) -> Result<()> {
    if spec.lights.serves(light) {
        return Ok(());
    }
    Err(Error::UnsupportedLight {
        technique: spec.name.to_string(),
        light: light.kind().into(),
        supported: spec.lights.names().into(),
    })
}

/// The result of a technique with a single map, with the notes every technique owes.
pub(super) fn single_map(
    technique: &dyn Technique,
    view: &FocusedView,
    clip_from_world: &Rows,
    size: &MapSize,
    values: Vec<(&'static str, f64)>,
    mut notes: Vec<String>,
) -> Parameterization {
    if view.coverage == Coverage::NothingSeen {
        let lit = if view.spot().is_some() { " that the light reaches" } else { "" };
        notes.insert(0, format!("the camera sees no part of the scene{lit}: the map covers what the light can reach"));
    }
    let partition = Partition {
        shadow_clip_from_world: through_light(clip_from_world, &view.light).matrix(),
        post_warp: PostWarp::None,
        eye_depth: view.eye_depth,
    };
    Parameterization {
        technique: technique.spec().name.to_string(),
        settings: technique.settings(),
        partitions: vec![partition],
        resolution: size.resolution,
        border_texels: size.border,
        values,
        notes,
    }
}

/// The same rows with x, y and w exactly zero at a placed light (theory.md 0.1), where the way through local coordinates
/// left the rounding of the translation.
fn through_light(rows: &Rows, light: &Light) -> Rows {
    let p = light.point();
    if p.w == 0.0 {
        return *rows;
    }
    let row = |r: DVec4| r.truncate().extend(-r.truncate().dot(p.truncate()));
    Rows { x: row(rows.x), y: row(rows.y), z: rows.z, w: row(rows.w) }
}
