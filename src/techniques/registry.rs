//! Techniques by name.

use std::cell::Cell;

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

/// A word that has another name now.
#[derive(Debug, Clone, Copy)]
pub struct Renamed {
    /// The technique.
    pub technique: &'static str,
    /// The parameter.
    pub param: &'static str,
    /// The word as it was, and as it is.
    pub words: [&'static str; 2],
}

/// Words of earlier versions that still work.
pub static RENAMED: &[Renamed] = &[
    Renamed { technique: "psm", param: "range", words: ["receivers", "body"] },
    Renamed { technique: "z_partition", param: "range", words: ["receivers", "body"] },
];

/// Parameters with today's words.
fn renamed(name: &str, params: &[(String, Value)]) -> Vec<(String, Value)> {
    let mut params = params.to_vec();
    for old in RENAMED.iter().filter(|old| old.technique == name) {
        for (_, value) in params.iter_mut().filter(|(param, _)| param == old.param) {
            if matches!(value, Value::Choice(word) if word == old.words[0]) {
                *value = Value::Choice(old.words[1].into());
            }
        }
    }
    params
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
    let _level = Level::enter()?;
    let (entry, settings) = resolved(name, params)?;
    let made = made(entry, settings)?;
    let most = made.most_maps();
    if most > MOST_MAPS {
        let expected = format!("techniques that make at most {MOST_MAPS} maps of a view");
        let fix = "divide the view into fewer parts, or put fewer schemes within one another";
        return Err(Error::argument("technique", expected, format!("{} with up to {most}", made.spec().name), fix));
    }
    Ok(made)
}

/// Techniques within techniques, outermost counted: a scheme for the light, for the depths and for the faces, a warp, and as
/// many again.
const MOST_NESTED: usize = 8;

/// Maps of a view, those of a point light's faces not counted. Chosen because an engine has tens, and a thousand take seconds.
const MOST_MAPS: usize = 1024;

/// A level of techniques within techniques, as long as one is being made.
struct Level;

thread_local!(static LEVELS: Cell<usize> = const { Cell::new(0) });

impl Level {
    fn enter() -> Result<Self> {
        let levels = LEVELS.get() + 1;
        if levels > MOST_NESTED {
            let expected = format!("at most {MOST_NESTED} techniques within one another");
            return Err(Error::argument("technique", expected, "more", "put fewer schemes within one another"));
        }
        LEVELS.set(levels);
        Ok(Self)
    }
}

impl Drop for Level {
    fn drop(&mut self) {
        LEVELS.set(LEVELS.get() - 1);
    }
}

fn made(entry: &Entry, settings: Settings) -> Result<Box<dyn Technique>> {
    match entry.make {
        Make::Warp(make) => {
            let warp = make(&settings)?;
            let tightening = settings.tightening()?;
            let (range, holds) = (settings.range(), settings.holds());
            let (margin, slack) = (settings.declared_number("margin")?, settings.declared_number("slack")?);
            Ok(Box::new(Focused { spec: entry.spec, settings, tightening, range, holds, margin, slack, warp }))
        }
        Make::Scheme(make) => make(settings),
    }
}

/// The line of a technique, and its settings with some of them given.
///
/// # Errors
/// As [`technique`], but for what a technique's own file checks.
pub(super) fn resolved(name: &str, params: &[(String, Value)]) -> Result<(&'static Entry, Settings)> {
    let entry = TECHNIQUES.iter().find(|entry| entry.spec.name == name).ok_or_else(|| Error::UnknownName {
        kind: "technique".into(),
        name: name.to_string(),
        valid: specs().map(|spec| spec.name.to_string()).collect(),
    })?;
    Ok((entry, entry.spec.resolve(&renamed(name, params))?))
}
