//! What is stored as text: `front`, `back:spacing=linear,format=unorm16`.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::format::Format;
use super::kind::{Spacing, Stored, StoredSurface};
use crate::error::{Error, Result};
use crate::names::named;
use crate::render::settings_text::{Settings, split};

/// Characters of a text that an error shows.
const MOST_SHOWN: usize = 80;

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
    /// [`Error::UnknownName`] for a surface, setting or name that does not exist; [`Error::InvalidArgument`] for a setting that
    /// is given twice, and a limit that is no number of 0 or more.
    fn from_str(text: &str) -> Result<Self> {
        let (surface, rest) = split(text);
        let mut stored = Self { surface: StoredSurface::named(surface)?, ..Self::default() };
        let settings = Settings::read("stored", surface, &["spacing", "format", "limit"], rest)?;
        if let Some(name) = settings.value("spacing") {
            stored.spacing = Spacing::named(name)?;
        }
        if let Some(name) = settings.value("format") {
            stored.format = Format::named(name)?;
        }
        if let Some(limit) = settings.value("limit") {
            let (expected, got) = ("a number of texels", limit.chars().take(MOST_SHOWN).collect::<String>());
            let refused = |_| Error::argument(settings.name("limit"), expected, format!("{got:?}"), "try limit=8");
            stored.limit = limit.parse().map_err(refused)?;
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
        let twice = "front:format=f16,format=f32".parse::<Stored>().unwrap_err().to_string();
        assert!(twice.contains("stored front: format") && twice.contains("give it once"), "{twice}");
    }
}
