//! Library scenes by name.

use super::SPECS;
use super::spec::{LibraryScene, LibrarySpec, Values};
use crate::error::{Error, Result};
use crate::progress::Progress;

/// The names of the scenes.
pub fn names() -> Vec<&'static str> {
    SPECS.iter().map(|s| s.name).collect()
}

/// The scenes' self-descriptions.
pub fn specs() -> &'static [LibrarySpec] {
    SPECS
}

/// The scene of a name. The same seed and parameters give the same scene, vertex for vertex.
///
/// # Errors
/// [`Error::UnknownName`] for a scene or a parameter that does not exist; [`Error::InvalidArgument`] for a value out of its
/// range, a fraction where a whole number belongs, or a parameter given twice.
///
/// ```
/// let forest = shadowlab::scene::library::build("forest", 1, &[("trees".into(), 200.0)])?;
/// assert!(forest.scene.instances().len() > 200);
/// # Ok::<(), shadowlab::Error>(())
/// ```
pub fn build(name: &str, seed: u64, params: &[(String, f64)]) -> Result<LibraryScene> {
    watched(name, seed, params, &Progress::new())
}

/// The same, stopped where `progress` says so.
///
/// # Errors
/// As [`build`], and [`Error::Interrupted`].
pub fn watched(name: &str, seed: u64, params: &[(String, f64)], progress: &Progress) -> Result<LibraryScene> {
    let spec = SPECS.iter().find(|s| s.name == name).ok_or_else(|| Error::UnknownName {
        kind: "scene".into(),
        name: name.into(),
        valid: names().into_iter().map(String::from).collect(),
    })?;
    (spec.build)(seed, &Values::checked(spec, params, progress)?)
}
