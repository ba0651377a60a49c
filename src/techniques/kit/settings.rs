//! The values of a technique's parameters, checked against its [`Spec`] in one place.

use std::fmt;

use super::spec::{Default, Kind, LightSupport, ParamSpec, Spec};
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

impl fmt::Display for Kind {
    /// The range, for tables: "1 to 8", "0 or more", "auto, or 0.5 to 9".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The largest number there is means no limit, and has 309 digits; the smallest positive one means any above 0.
        let span = |min: &f64, max: &f64| match (*min, *max) {
            (f64::MIN_POSITIVE, f64::MAX) => "above 0".to_string(),
            (f64::MIN_POSITIVE, max) => format!("above 0, up to {max}"),
            (min, f64::MAX) => format!("{min} or more"),
            (min, max) => format!("{min} to {max}"),
        };
        match self {
            Self::Number { min, max } => f.write_str(&span(min, max)),
            Self::Integer { min, max } => write!(f, "{min} to {max}"),
            Self::Flag => f.write_str("True or False"),
            Self::Choice(words) => f.write_str(&words.join(", ")),
            Self::ChoiceOrNumber { words, min, max } => write!(f, "{}, or {}", words.join(", "), span(min, max)),
            Self::Numbers { words, count: [fewest, most], min, max } => {
                let many = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
                let or = if words.is_empty() { String::new() } else { format!("{}, or ", words.join(", ")) };
                // The most negative number means no limit either.
                let range = if *min == f64::MIN { String::new() } else { format!(", {}", span(min, max)) };
                write!(f, "{or}{many} numbers{range}")
            }
            Self::Techniques => f.write_str("a technique, or several separated by /"),
        }
    }
}

impl Kind {
    /// What values look like, for messages.
    pub fn expected(&self) -> String {
        match self {
            Self::Number { .. } => format!("a number, {self}"),
            Self::Integer { .. } => format!("a whole number, {self}"),
            Self::Flag => self.to_string(),
            Self::Choice(_) => format!("one of {self}"),
            Self::ChoiceOrNumber { .. } => format!("a word or a number: {self}"),
            Self::Numbers { .. } | Self::Techniques => self.to_string(),
        }
    }
    /// The value as this kind stores it, or nothing when it does not fit. Whole numbers pass for numbers, and text that
    /// reads as a number or as true or false for one, so that a command line can hand over its words.
    fn accept(&self, value: &Value) -> Option<Value> {
        let number = match value {
            Value::Number(x) => Some(*x),
            Value::Integer(i) => Some(*i as f64),
            Value::Choice(text) => text.trim().parse().ok(),
            Value::Flag(_) | Value::Numbers(_) => None,
        };
        let word = |words: &[&'static str]| match value {
            Value::Choice(text) if words.contains(&text.as_str()) => Some(value.clone()),
            _ => None,
        };
        // A NaN is in no range.
        let in_range = |min: f64, max: f64| number.filter(|x| (min..=max).contains(x)).map(Value::Number);
        match self {
            Self::Number { min, max } => in_range(*min, *max),
            Self::Integer { min, max } => {
                let whole = number.filter(|x| x.fract() == 0.0 && (*min as f64..=*max as f64).contains(x));
                whole.map(|x| Value::Integer(x as i64))
            }
            Self::Flag => match value {
                Value::Flag(b) => Some(Value::Flag(*b)),
                Value::Choice(text) => text.trim().to_ascii_lowercase().parse().ok().map(Value::Flag),
                _ => None,
            },
            Self::Choice(words) => word(words),
            Self::ChoiceOrNumber { words, min, max } => word(words).or_else(|| in_range(*min, *max)),
            Self::Numbers { words, count, min, max } => word(words).or_else(|| {
                let list = match value {
                    Value::Numbers(list) => Some(list.clone()),
                    Value::Choice(text) => numbers_of(text),
                    _ => number.map(|x| vec![x]),
                };
                let fits = |list: &Vec<f64>| {
                    (count[0]..=count[1]).contains(&list.len()) && list.iter().all(|x| (min..=max).contains(&x))
                };
                list.filter(fits).map(Value::Numbers)
            }),
            Self::Techniques => match value {
                Value::Choice(text) => Some(Value::Choice(text.trim().to_string())),
                _ => None,
            },
        }
    }
}

/// The numbers of a text: separated by commas or spaces, in parentheses or not.
fn numbers_of(text: &str) -> Option<Vec<f64>> {
    let inner = text.trim().trim_start_matches('(').trim_end_matches(')');
    let parts = inner.split([',', ' ']).filter(|part| !part.is_empty());
    parts.map(|part| part.parse().ok()).collect::<Option<Vec<f64>>>().filter(|list| !list.is_empty())
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
pub struct Settings(Vec<(&'static str, Value)>);

impl Settings {
    /// Names and values in the order of the spec.
    pub fn values(&self) -> &[(&'static str, Value)] {
        &self.0
    }
    /// Tells a value that follows from others as it is.
    pub(in crate::techniques) fn set(&mut self, name: &str, value: Value) {
        self.0.iter_mut().filter(|(n, _)| *n == name).for_each(|(_, old)| *old = value.clone());
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
        let (exact, receivers) = (("exact", Tightening::Exact), ("receivers", Tightening::Receivers));
        let (intersection, none) = (("intersection", Tightening::Intersection), ("none", Tightening::None));
        let samples = [("shadow", Tightening::Exact), ("seen", Tightening::Exact)];
        self.meaning("fit", &[samples[0], samples[1], exact, receivers, intersection, none])
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
