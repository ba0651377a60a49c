//! The values of a technique's parameters, checked against its [`Spec`] in one place.

use std::sync::Arc;

use super::spec::{Default, LightSupport, ParamSpec, Spec};
use crate::error::{Error, Result};
use crate::fit::Tightening;
use crate::parameterization::Value;
use crate::scene::Light;

impl Default {
    /// The same as a [`Value`].
    pub fn value(&self) -> Value {
        match *self {
            Self::Number(x) => Value::Number(x),
            Self::Integer(i) => Value::Integer(i),
            Self::Flag(b) => Value::Flag(b),
            Self::Choice(word) => Value::Choice(word.to_string()),
        }
    }
}

impl Spec {
    /// The value of every parameter, in the order of the spec: what the caller gave, the default for the rest.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a parameter the technique does not have; [`Error::InvalidArgument`] for a value that does not
    /// fit, or for the same parameter twice.
    pub fn resolve(&self, given: &[(String, Value)]) -> Result<Settings> {
        for (i, (name, _)) in given.iter().enumerate() {
            if !self.params.iter().any(|p| p.name == name) {
                let valid = match self.params {
                    [] => vec!["none: it has no parameters".to_string()],
                    params => params.iter().map(|p| p.name.to_string()).collect(),
                };
                let kind = format!("parameter of technique {:?}", self.name);
                return Err(Error::UnknownName { kind: kind.into(), name: name.clone(), valid });
            }
            if given[..i].iter().any(|(earlier, _)| earlier == name) {
                return Err(Error::argument(name.clone(), "one value", "two", "give each parameter once"));
            }
        }
        let settle = |p: &ParamSpec| match given.iter().find(|(name, _)| name == p.name) {
            None => Ok((p.name, p.default.value())),
            Some((_, value)) => p.kind.accept(value).map(|v| (p.name, v)).ok_or_else(|| {
                let fix = format!("{} ({}: {})", p.doc, p.name, self.title);
                Error::argument(p.name, p.kind.expected(), value, fix)
            }),
        };
        Ok(Settings(self.params.iter().map(settle).collect::<Result<_>>()?))
    }
}

/// A technique's parameters with their values.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings(Arc<[(&'static str, Value)]>);

impl Settings {
    /// Names and values in the order of the spec.
    pub fn values(&self) -> &[(&'static str, Value)] {
        &self.0
    }
    /// The same, shared.
    pub fn shared(&self) -> Arc<[(&'static str, Value)]> {
        Arc::clone(&self.0)
    }
    /// Tells a value that follows from others as it is.
    pub(in crate::techniques) fn set(&mut self, name: &str, value: Value) {
        Arc::make_mut(&mut self.0).iter_mut().filter(|(n, _)| *n == name).for_each(|(_, old)| *old = value.clone());
    }
    fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(n, _)| *n == name).map(|(_, value)| value)
    }
    fn undeclared(&self, name: &str) -> Error {
        let valid = self.0.iter().map(|(name, _)| name.to_string()).collect();
        Error::UnknownName { kind: "setting of this kind".into(), name: name.to_string(), valid }
    }
    /// A number that is always one: the spec has its default.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a name that the spec does not declare as a number.
    pub fn declared_number(&self, name: &str) -> Result<f64> {
        self.number(name).ok_or_else(|| self.undeclared(name))
    }
    /// What the word of a parameter stands for, by the list of all its words.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a name that the spec does not declare as words; [`Error::InvalidArgument`] for a word that
    /// is not in the list.
    pub fn meaning<T: Clone>(&self, name: &str, meanings: &[(&str, T)]) -> Result<T> {
        let Some(Value::Choice(word)) = self.get(name) else { return Err(self.undeclared(name)) };
        let found = meanings.iter().find(|(known, _)| known == word);
        found.map(|(_, meaning)| meaning.clone()).ok_or_else(|| {
            let words = meanings.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ");
            Error::argument(
                name.to_string(),
                format!("one of {words}"),
                format!("{word:?}"),
                "choose one of these words",
            )
        })
    }
    /// How closely the map is cut: what [`FIT`](super::spec::FIT) says, or `published`, XPSM's, with the least w that it
    /// declares beside.
    ///
    /// # Errors
    /// As [`Settings::meaning`].
    pub fn tightening(&self) -> Result<Tightening> {
        if self.word("fit") == "published" {
            return Ok(Tightening::Ignoring { least_w: self.declared_number("epsilon_w")? });
        }
        let meanings = [
            // Cut to samples; along the light, and without any, as closely as it goes.
            ("shadow", Tightening::Exact),
            ("seen", Tightening::Exact),
            ("exact", Tightening::Exact),
            ("receivers", Tightening::Receivers),
            ("intersection", Tightening::Intersection),
            ("none", Tightening::None),
        ];
        self.meaning("fit", &meanings)
    }
    /// What a map must hold: what [`FIT`](super::spec::FIT) says.
    pub fn holds(&self) -> Holds {
        match self.word("fit") {
            "seen" => Holds::Seen,
            "shadow" => Holds::Shadow,
            _ => Holds::Body,
        }
    }
    /// The depths that place a warp: what [`RANGE`](super::spec::RANGE) says.
    pub fn range(&self) -> Range {
        if self.word("range") == "seen" { Range::Seen } else { Range::Body }
    }
    /// A number; nothing for a word.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.get(name)? {
            Value::Number(x) => Some(*x),
            Value::Integer(i) => Some(*i as f64),
            _ => None,
        }
    }
    /// A list of numbers; empty for a word.
    pub fn numbers(&self, name: &str) -> &[f64] {
        match self.get(name) {
            Some(Value::Numbers(list)) => list,
            _ => &[],
        }
    }
    /// Whether a flag is on.
    pub fn flag(&self, name: &str) -> bool {
        matches!(self.get(name), Some(Value::Flag(true)))
    }
    /// A word; "" for a number.
    pub fn word(&self, name: &str) -> &str {
        match self.get(name) {
            Some(Value::Choice(word)) => word,
            _ => "",
        }
    }
}

/// What a map must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// The receivers' body, as closely as its [`Tightening`] says.
    Body,
    /// The visible receivers that face the light.
    Seen,
    /// Those in shadow and their neighbours.
    Shadow,
}

/// The depths that place a warp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Those of the receivers' body.
    Body,
    /// Those of the visible receivers that face the light.
    Seen,
}

impl Spec {
    /// An error unless the technique serves a light.
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`].
    pub fn serves(&self, light: &Light) -> Result<()> {
        if self.lights.serves(light) {
            return Ok(());
        }
        Err(Error::UnsupportedLight {
            technique: self.name.to_string(),
            light: light.kind().into(),
            supported: self.lights.names().into(),
        })
    }
}

impl LightSupport {
    /// In words.
    pub fn names(&self) -> String {
        let all = [(self.directional, "directional"), (self.spot, "spot"), (self.point, "point")];
        all.iter().filter(|(served, _)| *served).map(|(_, name)| *name).collect::<Vec<_>>().join(" and ")
    }
    /// Whether it serves a light.
    pub fn serves(&self, light: &Light) -> bool {
        match light {
            Light::Directional(_) => self.directional,
            Light::Spot(_) => self.spot,
            Light::Point(_) => self.point,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::spec::Kind;
    use super::*;

    const SPEC: Spec = Spec {
        name: "probe",
        title: "Probe",
        source: "here",
        lights: LightSupport { directional: true, spot: false, point: false },
        params: &[
            ParamSpec {
                name: "near",
                unit: "world units",
                default: Default::Choice("auto"),
                kind: Kind::ChoiceOrNumber { words: &["auto"], min: 0.5, max: 9.0 },
                doc: "A distance.",
            },
            ParamSpec { name: "on", unit: "", default: Default::Flag(false), kind: Kind::Flag, doc: "A switch." },
            ParamSpec {
                name: "steps",
                unit: "",
                default: Default::Integer(3),
                kind: Kind::Integer { min: 1, max: 8 },
                doc: "A count.",
            },
            ParamSpec {
                name: "length",
                unit: "world units",
                default: Default::Number(1.0),
                kind: Kind::Number { min: 0.0, max: f64::MAX },
                doc: "A length without a limit.",
            },
        ],
    };

    fn given(name: &str, value: Value) -> Vec<(String, Value)> {
        vec![(name.to_string(), value)]
    }

    #[test]
    fn defaults_and_given_values_in_the_order_of_the_spec() {
        let defaults = SPEC.resolve(&[]).unwrap();
        assert_eq!((defaults.word("near"), defaults.flag("on"), defaults.number("steps")), ("auto", false, Some(3.0)));
        for (value, number) in [(Value::Integer(2), 2.0), (Value::Number(0.5), 0.5), (Value::Choice("4.5".into()), 4.5)]
        {
            assert_eq!(SPEC.resolve(&given("near", value)).unwrap().number("near"), Some(number));
        }
        assert!(SPEC.resolve(&given("on", Value::Choice("True".into()))).unwrap().flag("on"));
        assert_eq!(SPEC.resolve(&given("steps", Value::Number(8.0))).unwrap().number("steps"), Some(8.0));
    }

    #[test]
    fn a_technique_reads_what_its_spec_declares() {
        let settings = SPEC.resolve(&[]).unwrap();
        assert_eq!(settings.declared_number("length"), Ok(1.0));
        assert_eq!(settings.meaning("near", &[("far", 1), ("auto", 2)]), Ok(2));
        for undeclared in ["width", "near", "on"] {
            let error = settings.declared_number(undeclared).unwrap_err();
            assert!(matches!(&error, Error::UnknownName { name, .. } if name == undeclared), "{error}");
        }
        assert!(settings.meaning("length", &[("auto", 1)]).is_err());
        let forgotten = settings.meaning("near", &[("far", 1)]).unwrap_err().to_string();
        assert!(forgotten.contains("one of far") && forgotten.contains("auto"), "{forgotten}");
        assert!(settings.tightening().is_err(), "this spec declares no fit");
    }

    #[test]
    fn what_does_not_fit_is_refused_with_what_would() {
        let bad = [
            ("near", Value::Choice("far".into())),
            ("near", Value::Number(f64::NAN)),
            ("near", Value::Number(9.5)),
            ("near", Value::Flag(true)),
            ("on", Value::Number(1.0)),
            ("steps", Value::Number(2.5)),
            ("steps", Value::Integer(9)),
        ];
        for (name, value) in bad {
            let error = SPEC.resolve(&given(name, value.clone())).unwrap_err();
            assert!(matches!(&error, Error::InvalidArgument { name: n, .. } if n == name), "{value:?}: {error}");
        }
        let error = SPEC.resolve(&given("nera", Value::Flag(true))).unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown parameter of technique \"probe\" \"nera\": expected one of near, on, steps, length"
        );
        let message = |name: &str| SPEC.resolve(&given(name, Value::Number(-1.0))).unwrap_err().to_string();
        assert!(message("near").contains("a word or a number: auto, or 0.5 to 9"), "{}", message("near"));
        assert!(message("steps").contains("a whole number, 1 to 8"), "{}", message("steps"));
        assert!(message("length").contains("expected a number, 0 or more"), "{}", message("length"));
        let spans = [(f64::MAX, "above 0"), (2.0, "above 0, up to 2")];
        for (max, text) in spans {
            assert_eq!(Kind::Number { min: f64::MIN_POSITIVE, max }.to_string(), text);
            let numbers = Kind::Numbers { words: &["none"], count: [1, 7], min: f64::MIN_POSITIVE, max };
            assert_eq!(numbers.to_string(), format!("none, or 1 to 7 numbers, {text}"));
        }
        let twice = [given("on", Value::Flag(true)), given("on", Value::Flag(true))].concat();
        assert!(SPEC.resolve(&twice).is_err());
    }
}
