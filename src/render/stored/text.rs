//! What is stored as text: `front`, `back:spacing=linear,format=unorm16`.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::format::Format;
use super::kind::{Spacing, Stored, StoredSurface};
use crate::error::{Error, Result};
use crate::names::named;

impl StoredSurface {
    /// The surface of a name.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(name: &str) -> Result<Self> {
        named("stored surface", name, &Self::NAMES)
    }
}

impl Spacing {
    /// The spacing of a name.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(name: &str) -> Result<Self> {
        named("spacing", name, &Self::NAMES)
    }
}

impl Format {
    /// The format of a name.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(name: &str) -> Result<Self> {
        named("format", name, &Self::NAMES)
    }
}

impl FromStr for Stored {
    type Err = Error;

    /// What a text says; what it leaves out is the default's.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a text that does not read, [`Error::UnknownName`] for a name that does not exist.
    fn from_str(text: &str) -> Result<Self> {
        let (surface, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut stored = Self { surface: StoredSurface::named(surface.trim())?, ..Self::default() };
        for part in rest.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let fix = "write, for example, back:spacing=linear,format=unorm16";
            let unreadable = |got: &str| {
                let expected = "a surface, then spacing=, format=, limit= after a colon";
                Error::argument("stored", expected, got.chars().take(80).collect::<String>(), fix)
            };
            let (key, value) = part.split_once('=').ok_or_else(|| unreadable(part))?;
            let value = value.trim();
            match key.trim() {
                "spacing" => stored.spacing = Spacing::named(value)?,
                "format" => stored.format = Format::named(value)?,
                "limit" => stored.limit = value.parse().map_err(|_| unreadable(part))?,
                _ => return Err(unreadable(part)),
            }
        }
        stored.checked()
    }
}

impl Display for Stored {
    /// The shortest text that reads as this.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let default = Self::default();
        let mut parts = Vec::new();
        if self.spacing != default.spacing {
            parts.push(format!("spacing={}", self.spacing.name()));
        }
        if self.format != default.format {
            parts.push(format!("format={}", self.format.name()));
        }
        if self.limit != default.limit {
            parts.push(format!("limit={}", self.limit));
        }
        f.write_str(self.surface.name())?;
        if parts.is_empty() { Ok(()) } else { write!(f, ":{}", parts.join(",")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_go_there_and_back() {
        for (_, surface) in StoredSurface::NAMES {
            for (_, spacing) in Spacing::NAMES {
                for (_, format) in Format::NAMES {
                    for limit in [Stored::LIMIT, 0.1, f64::INFINITY] {
                        let stored = Stored { surface, spacing, format, limit };
                        assert_eq!(stored.to_string().parse(), Ok(stored), "{stored}");
                    }
                }
            }
        }
        assert_eq!(Stored::default().to_string(), "front");
        let stored: Stored = " back : format = unorm16 , spacing = linear ".parse().unwrap();
        assert_eq!(stored.to_string(), "back:spacing=linear,format=unorm16");
    }

    #[test]
    fn what_does_not_read_is_refused() {
        for text in
            ["", "fronts", "front:spacing", "front:format=f64", "front:depth=1", "dual:limit=x", "dual:limit=-1"]
        {
            assert!(text.parse::<Stored>().is_err(), "{text}");
        }
        assert!("dual:limit=nan".parse::<Stored>().is_err());
    }
}
