//! Techniques by name.

use super::TECHNIQUES;
use super::kit::focused::Focused;
use super::kit::{Settings, Spec, Technique, Warp};
use crate::error::{Error, Result};
use crate::parameterization::Value;

/// A line of [`TECHNIQUES`].
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The self-description.
    pub spec: &'static Spec,
    /// The technique from checked settings.
    pub make: Make,
}

/// What a technique's file makes of checked settings.
#[derive(Debug, Clone, Copy)]
pub enum Make {
    /// One map by a warp, focused and fitted as all are.
    Warp(fn(&Settings) -> Result<Box<dyn Warp>>),
    /// A scheme that divides the view and has other techniques make the maps.
    Scheme(fn(Settings) -> Result<Box<dyn Technique>>),
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
    let settings = entry.spec.resolve(params)?;
    match entry.make {
        Make::Warp(make) => {
            let warp = make(&settings)?;
            let tightening = settings.tightening()?;
            Ok(Box::new(Focused { spec: entry.spec, settings, tightening, warp }))
        }
        Make::Scheme(make) => make(settings),
    }
}
