//! How a library scene declares itself, and its parameters' values, checked in one place.

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::scene::{Camera, Light, Scene};

/// A scene with a view and a light that show what it is for.
#[derive(Debug, Clone)]
pub struct LibraryScene {
    /// Name in the library.
    pub name: &'static str,
    /// The geometry, metres, y up.
    pub scene: Scene,
    /// The view to start with.
    pub camera: Camera,
    /// The light to start with.
    pub light: Light,
}

/// One parameter of a scene, declared once; every value is a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LibraryParam {
    /// Keyword.
    pub name: &'static str,
    /// Value where none is given.
    pub default: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Whether only whole numbers make sense.
    pub whole: bool,
    /// One line, with the unit.
    pub doc: &'static str,
}

/// A scene's self-description.
#[derive(Debug, Clone, Copy)]
pub struct LibrarySpec {
    /// Name in the library.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    /// What the scene is for.
    pub shows: &'static str,
    /// Its parameters.
    pub params: &'static [LibraryParam],
    /// Builds it for a seed.
    pub(super) build: fn(u64, &Values) -> Result<LibraryScene>,
}

/// A value for each parameter of a spec, within its range, and whether somebody wants the work to stop.
#[derive(Debug)]
pub(super) struct Values<'p> {
    params: &'static [LibraryParam],
    values: Vec<f64>,
    pub progress: &'p Progress,
}

impl<'p> Values<'p> {
    /// What is given, checked, and the default of the rest.
    ///
    /// # Errors
    /// As [`build`](super::build).
    pub(super) fn checked(spec: &LibrarySpec, given: &[(String, f64)], progress: &'p Progress) -> Result<Self> {
        let mut values: Vec<f64> = spec.params.iter().map(|p| p.default).collect();
        let mut seen = vec![false; values.len()];
        for (name, value) in given {
            let index = spec.params.iter().position(|p| p.name == name).ok_or_else(|| Error::UnknownName {
                kind: format!("parameter of scene {:?}", spec.name).into(),
                name: name.clone(),
                valid: spec.params.iter().map(|p| p.name.to_string()).collect(),
            })?;
            let param = &spec.params[index];
            if std::mem::replace(&mut seen[index], true) {
                return Err(Error::argument(param.name, "one value", "two", "give it once"));
            }
            let fits = (param.min..=param.max).contains(value) && !(param.whole && value.fract() != 0.0);
            if !fits {
                let kind = if param.whole { "whole number" } else { "number" };
                let expected = format!("a {kind} from {} to {}", param.min, param.max);
                let fix = format!("the default of scene {:?} is {}", spec.name, param.default);
                return Err(Error::argument(param.name, expected, value, fix));
            }
            values[index] = *value;
        }
        Ok(Self { params: spec.params, values, progress })
    }
    /// The value of a parameter that the spec declares.
    pub(super) fn number(&self, name: &str) -> f64 {
        let index = self.params.iter().position(|p| p.name == name);
        self.values[index.expect("a scene asks only for parameters of its own spec")]
    }
    /// The value of a whole parameter that the spec declares.
    pub(super) fn count(&self, name: &str) -> usize {
        self.number(name) as usize
    }
}
