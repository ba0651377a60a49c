//! Techniques as text: `lispsm:near=optimal,axis=middle`, `z_partition:count=4,inner=(lispsm:near=optimal)/uniform`.
//!
//! ```text
//! list      = technique { "/" technique }
//! technique = name [ ":" key "=" value { "," key "=" value } ]
//! value     = word | number | list of numbers or technique text in parentheses
//! ```
//! What is in parentheses is one value, whatever separators are in it.

use super::kit::Technique;
use super::technique;
use crate::error::{Error, Result};
use crate::parameterization::Value;

/// The technique of a text.
///
/// # Errors
/// [`Error::InvalidArgument`] for a text that does not read; what [`technique()`] says of names and values.
pub fn technique_of(text: &str) -> Result<Box<dyn Technique>> {
    let (name, params) = named(text)?;
    technique(name, &params)
}

/// The name and the settings in the text of one technique.
///
/// # Errors
/// [`Error::InvalidArgument`] for a text that does not read.
pub(super) fn named(text: &str) -> Result<(&str, Vec<(String, Value)>)> {
    let text = bare(text);
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    let mut params = Vec::new();
    for part in pieces(rest, ',')?.into_iter().filter(|part| !part.is_empty()) {
        let Some((key, value)) = part.split_once('=') else {
            return Err(unreadable(text));
        };
        params.push((key.trim().replace('-', "_"), Value::Choice(bare(value).to_string())));
    }
    Ok((name.trim(), params))
}

/// The techniques of a text, in order; at least one.
///
/// # Errors
/// As [`technique_of`].
pub fn techniques_of(text: &str) -> Result<Vec<Box<dyn Technique>>> {
    pieces(text, '/')?.into_iter().map(technique_of).collect()
}

/// Parentheses within parentheses: far more than techniques within techniques have ([`MOST_NESTED`](super::registry)), so that
/// what reads them needs little of the stack and of time.
const MOST_PARENTHESES: i32 = 64;

/// A text without the parentheses around all of it.
fn bare(text: &str) -> &str {
    let mut text = text.trim();
    while let Some(inner) = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'))
        // "(a)/(b)" begins and ends with one, too.
        && pieces(inner, '/').is_ok()
    {
        text = inner.trim();
    }
    text
}

/// The pieces between separators outside of parentheses.
fn pieces(text: &str, separator: char) -> Result<Vec<&str>> {
    let (mut depth, mut start, mut found) = (0_i32, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            c if c == separator && depth == 0 => {
                found.push(text[start..i].trim());
                start = i + c.len_utf8();
            }
            _ => {}
        }
        if !(0..=MOST_PARENTHESES).contains(&depth) {
            return Err(unreadable(text));
        }
    }
    found.push(text[start..].trim());
    if depth == 0 { Ok(found) } else { Err(unreadable(text)) }
}

fn unreadable(text: &str) -> Error {
    let expected = "name:parameter=value,parameter=value with values such as basic, 0.5 or (1,2,3)";
    Error::argument("technique", expected, format!("{text:?}"), "see the table of techniques")
}

/// A technique as text that [`technique_of`] reads: its name, and the settings that are not the default.
pub fn text_of(technique: &dyn Technique) -> String {
    let spec = technique.spec();
    let settings = technique.settings();
    let changed = settings.iter().zip(spec.params).filter(|((_, value), p)| *value != p.default.value());
    let texts: Vec<String> = changed.map(|((name, value), _)| format!("{name}={}", setting_text(value))).collect();
    if texts.is_empty() { spec.name.to_string() } else { format!("{}:{}", spec.name, texts.join(",")) }
}

/// A value in the text of a technique, in parentheses where it would be read as several.
fn setting_text(value: &Value) -> String {
    match value {
        Value::Choice(word) if word.contains([',', '/', ':', '=', '(', ')']) => format!("({word})"),
        Value::Choice(word) => word.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_with_what_is_in_parentheses_as_one_value() {
        let t = technique_of(" lispsm: near=basic , near-factor=2 ").unwrap();
        assert!(t.settings().contains(&("near", Value::Choice("basic".into()))));
        assert!(t.settings().contains(&("near_factor", Value::Number(2.0))));
        let several = techniques_of("(lispsm:near=0.5)/uniform / (uniform)").unwrap();
        assert_eq!(several.iter().map(|t| t.spec().name).collect::<Vec<_>>(), ["lispsm", "uniform", "uniform"]);
        assert_eq!(pieces("a=(1,2),b=((3,4),5)", ',').unwrap(), ["a=(1,2)", "b=((3,4),5)"]);
        assert_eq!(bare(" ((x)) "), "x");
        assert_eq!(bare("(a)/(b)"), "(a)/(b)");
    }

    #[test]
    fn what_is_written_is_read() {
        let texts = [
            "lispsm",
            "lispsm:near=0.5,axis=middle",
            "uniform:stable=true",
            "z_partition:count=3,inner=lispsm/uniform",
            "z_partition:distances=(2,8),inner=(lispsm:near=basic,axis=middle)/uniform",
            "face_partition:inner=(z_partition:count=2,inner=(lispsm:near=basic))",
        ];
        for text in texts {
            let technique = technique_of(text).expect(text);
            let written = text_of(&*technique);
            let again = technique_of(&written).expect(&written);
            assert_eq!(
                (again.spec().name, again.settings()),
                (technique.spec().name, technique.settings()),
                "{written}"
            );
        }
        assert_eq!(text_of(&*technique_of("lispsm:near=optimal,axis=middle").unwrap()), "lispsm:axis=middle");
    }

    #[test]
    fn what_does_not_read_is_refused() {
        for text in
            ["", "lispsm:near", "lispsm:near=(1", "lispsm:near=1)", "nothing", "uniform//lispsm", "lispsm:nera=1"]
        {
            assert!(techniques_of(text).is_err(), "{text}");
        }
    }
}
