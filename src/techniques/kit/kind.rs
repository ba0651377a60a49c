//! Which values the kinds of parameters take, in words and as a check.

use std::fmt;

use super::spec::Kind;
use crate::parameterization::Value;

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
            Self::Technique => f.write_str("a technique"),
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
            Self::Numbers { .. } | Self::Techniques | Self::Technique => self.to_string(),
        }
    }
    /// The value as this kind stores it, or nothing when it does not fit. Whole numbers pass for numbers, and text that
    /// reads as a number or as true or false for one, so that a command line can hand over its words.
    pub(in crate::techniques) fn accept(&self, value: &Value) -> Option<Value> {
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
            Self::Techniques | Self::Technique => match value {
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
