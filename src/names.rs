//! Lists of names and their values.

use crate::error::{Error, Result};

/// The name of a value in its list.
pub(crate) fn name_of<T: Copy + PartialEq>(names: &[(&'static str, T)], value: T) -> &'static str {
    names.iter().find(|(_, v)| *v == value).map_or("", |(name, _)| name)
}

/// The value of a name in a list.
pub(crate) fn named<T: Copy>(kind: &'static str, name: &str, names: &[(&'static str, T)]) -> Result<T> {
    names.iter().find(|(n, _)| *n == name).map(|(_, value)| *value).ok_or_else(|| Error::UnknownName {
        kind: kind.into(),
        name: name.into(),
        valid: names.iter().map(|(n, _)| n.to_string()).collect(),
    })
}
