//! The one error type of the crate: variants carry data, the message says what was expected, what came and what to do.

use std::borrow::Cow;

/// A short text that is usually a literal.
pub type Text = Cow<'static, str>;

/// The crate's result.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong, told so that the reader knows the next step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument outside its range, of the wrong size, not finite, or contradicting another.
    #[error("{name}: expected {expected}, got {got}; {fix}")]
    InvalidArgument {
        /// The argument as the caller knows it.
        name: Text,
        /// What would have been right.
        expected: Text,
        /// What came.
        got: String,
        /// What to do.
        fix: Text,
    },
    /// A name that is not in a registry.
    #[error("unknown {kind} {}: expected one of {}", readable(format!("{name:?}")), valid.join(", "))]
    UnknownName {
        /// What was looked up: "technique", "scene", "backend"...
        kind: Text,
        /// The name that came.
        name: String,
        /// The names that exist.
        valid: Vec<String>,
    },
    /// A face that points at a vertex that does not exist.
    #[error("face {face} uses vertex {index}, but there are {count} vertices (expected 0 to {}); check the face array", count.saturating_sub(1))]
    FaceIndex {
        /// Row of the face array.
        face: usize,
        /// The index in it.
        index: i64,
        /// How many vertices there are.
        count: usize,
    },
    /// A scene without a single usable triangle.
    #[error("the scene has no usable triangle: {reason}; give at least one triangle with finite vertices")]
    EmptyScene {
        /// Where they went.
        reason: String,
    },
    /// A technique that cannot serve this kind of light.
    #[error("technique {technique:?} {}", refused_light(light, supported))]
    UnsupportedLight {
        /// The technique.
        technique: String,
        /// The kind of light that came.
        light: Text,
        /// The kinds it serves.
        supported: Text,
    },
    /// A view that a technique cannot serve.
    #[error("technique {technique:?} {}", refused_view(reason, fix))]
    UnsuitedView {
        /// The technique.
        technique: Text,
        /// Why.
        reason: String,
        /// What to do.
        fix: Text,
    },
    /// No graphics adapter, or none of the wanted name.
    #[error("no graphics adapter{}: found {}; {fix}", wanted.as_ref().map(|w| format!(" matching {w:?}")).unwrap_or_default(), if found.is_empty() { "none".to_string() } else { found.join(", ") })]
    NoAdapter {
        /// The name asked for.
        wanted: Option<String>,
        /// The adapters that exist.
        found: Vec<String>,
        /// What to do.
        fix: Text,
    },
    /// The graphics device refused or failed.
    #[error("graphics device: {what}; {fix}")]
    Device {
        /// What happened.
        what: String,
        /// What to do.
        fix: Text,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// What a technique says to a light that it does not serve.
fn refused_light(light: &str, supported: &str) -> String {
    format!("does not support a {light} light; it supports {supported}")
}

/// What a technique says to a view that it does not serve.
fn refused_view(reason: &str, fix: &str) -> String {
    format!("cannot serve this view: {reason}; {fix}")
}

impl Error {
    /// The technique that refuses a light or a view, and the message without its name; nothing of other errors.
    pub fn refusal(&self) -> Option<(&str, String)> {
        match self {
            Self::UnsupportedLight { technique, light, supported } => {
                Some((technique, refused_light(light, supported)))
            }
            Self::UnsuitedView { technique, reason, fix } => Some((technique, refused_view(reason, fix))),
            _ => None,
        }
    }
    /// What to do, where the error has a text for that alone.
    pub fn fix(&self) -> Option<&str> {
        match self {
            Self::InvalidArgument { fix, .. }
            | Self::UnsuitedView { fix, .. }
            | Self::NoAdapter { fix, .. }
            | Self::Device { fix, .. } => Some(fix),
            _ => None,
        }
    }
    /// An [`Error::InvalidArgument`].
    pub fn argument(
        name: impl Into<Text>,
        expected: impl Into<Text>,
        got: impl std::fmt::Display,
        fix: impl Into<Text>,
    ) -> Self {
        let (expected, got) = (short_numbers(expected.into()), short_numbers(got.to_string().into()));
        Self::InvalidArgument { name: name.into(), expected, got: readable(got.into_owned()), fix: fix.into() }
    }
}

/// Letters of what came that a message shows: some lines on a screen.
const LONGEST_SHOWN: usize = 300;

/// What came, no longer than one can read.
fn readable(text: String) -> String {
    match text.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// Digits of a number that a message shows; more of them are only zeros.
const MOST_DIGITS: usize = 24;

/// The text with numbers of more digits as powers of ten: 1e300, which would be written as 301 digits.
fn short_numbers(text: Text) -> Text {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    if !text.split(|c| !is_part(c)).any(|word| word.len() > MOST_DIGITS) {
        return text;
    }
    let (mut short, mut rest) = (String::with_capacity(text.len()), &*text);
    while let Some(start) = rest.find(is_part) {
        let end = rest[start..].find(|c| !is_part(c)).map_or(rest.len(), |length| start + length);
        let (before, word) = (&rest[..start], &rest[start..end]);
        short.push_str(before);
        match word.parse::<f64>() {
            Ok(number) if word.len() > MOST_DIGITS && number.is_finite() => short.push_str(&format!("{number:e}")),
            _ => short.push_str(word),
        }
        rest = &rest[end..];
    }
    short.push_str(rest);
    short.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_powers_of_ten() {
        for (number, short) in [(1e300, "1e300"), (-2.5e-200, "-2.5e-200"), (0.1, "0.1"), (1e9, "1000000000")] {
            let expected = format!("a number beyond near = {number}, which is more");
            let text = Error::argument("far", expected, number, "move it").to_string();
            assert_eq!(
                text,
                format!("far: expected a number beyond near = {short}, which is more, got {short}; move it")
            );
        }
        let many = Error::argument("far", "less", "9".repeat(400), "move it").to_string();
        assert!(many.contains("999..."), "beyond what a float holds: {many}");
    }

    #[test]
    fn messages_are_short_whatever_came() {
        let long = "ä".repeat(100_000);
        let unknown = Error::UnknownName { kind: "scene".into(), name: long.clone(), valid: vec!["a".into()] };
        for error in [Error::argument("size", "a number", &long, "choose another"), unknown] {
            let text = error.to_string();
            assert!(text.chars().count() < 2 * LONGEST_SHOWN && text.contains("ä..."), "{text}");
        }
        assert!(Error::argument("size", "a number", "three", "choose another").to_string().contains("got three;"));
    }
}
