//! Texts of a name and its settings: `pcf:size=3px`, `back:spacing=linear,format=unorm16`.

use crate::error::{Error, Result};

/// The name of a text and what comes after it.
pub(super) fn split(text: &str) -> (&str, &str) {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    (name.trim(), rest.trim())
}

/// The settings of a text, each given once.
#[derive(Debug)]
pub(super) struct Settings<'a> {
    of: String,
    given: Vec<(&'static str, &'a str)>,
}

impl<'a> Settings<'a> {
    /// Of a kind of thing and its name, which has settings that are known.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a setting that does not exist; [`Error::InvalidArgument`] for one that is given twice, and for any
    /// where there are none.
    pub fn read(kind: &str, name: &str, known: &[&'static str], text: &'a str) -> Result<Self> {
        let of = format!("{kind} {name}");
        let mut given: Vec<(&'static str, &'a str)> = Vec::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').map_or((part, ""), |(key, value)| (key.trim(), value.trim()));
            let Some(&key) = known.iter().find(|name| **name == key) else {
                if known.is_empty() {
                    let fix = format!("write {name} alone");
                    return Err(Error::argument(of, "no settings", format!("{part:?}"), fix));
                }
                let (kind, valid) = (format!("setting of {of}"), known.iter().map(ToString::to_string));
                return Err(Error::UnknownName { kind: kind.into(), name: key.into(), valid: valid.collect() });
            };
            if given.iter().any(|(name, _)| *name == key) {
                return Err(Error::argument(format!("{of}: {key}"), "one value", "two", "give it once"));
            }
            given.push((key, value));
        }
        Ok(Self { of, given })
    }
    /// The text of a setting; nothing where it is left out.
    pub fn value(&self, key: &str) -> Option<&'a str> {
        self.given.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }
    /// The name of a setting in errors.
    pub fn name(&self, key: &str) -> String {
        format!("{}: {key}", self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_once_each() {
        assert_eq!(split(" a : b=1, c "), ("a", "b=1, c"));
        assert_eq!(split("a"), ("a", ""));
        let read = |text| Settings::read("filter", "a", &["b", "c"], text);
        let settings = read("c = 2 ,, b=1").unwrap();
        assert_eq!((settings.value("b"), settings.value("c"), settings.value("d")), (Some("1"), Some("2"), None));
        assert_eq!(settings.name("b"), "filter a: b");
        assert_eq!(read("b").unwrap().value("b"), Some(""));
        assert!(matches!(read("d=1"), Err(Error::UnknownName { .. })));
        assert!(read("b=1,b=1").unwrap_err().to_string().contains("give it once"));
        let alone = Settings::read("filter", "a", &[], "b=1").unwrap_err().to_string();
        assert!(alone.contains("write a alone"), "{alone}");
    }
}
