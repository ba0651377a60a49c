//! Filters as text: `nearest`, `bilinear`, `pcf:size=3`, `tent:size=3px`, `poisson:count=16,radius=2,seed=0`.

use std::fmt;
use std::str::FromStr;

use super::value::{Extent, Filter, Unit};
use crate::error::{Error, Result};
use crate::render::settings_text::{Settings, split};

/// A kind of filter, as it is listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterSpec {
    /// Its name.
    pub name: &'static str,
    /// Its settings with examples of values; empty for none.
    pub settings: &'static str,
    /// What it is.
    pub doc: &'static str,
}

/// Every kind of filter, in order of cost.
pub const FILTERS: [FilterSpec; 5] = [
    FilterSpec { name: "nearest", settings: "", doc: "one comparison, with the texel that the receiver falls into" },
    FilterSpec {
        name: "bilinear",
        settings: "",
        doc: "bilinear weights over the four nearest texel centres (2x2 percentage-closer filtering)",
    },
    FilterSpec {
        name: "pcf",
        settings: "size=3",
        doc: "a box about the receiver: each texel weighs its overlap with the box; size=1 is bilinear",
    },
    FilterSpec {
        name: "tent",
        settings: "size=4",
        doc: "a triangle along each axis, size its whole width: the box of half the width, twice",
    },
    FilterSpec {
        name: "poisson",
        settings: "count=16,radius=2,seed=0",
        doc: "comparisons of equal weight at the points of a Poisson disc, the same disc at every pixel",
    },
];

/// The name of `bilinear` in older texts.
const PCF_2X2: &str = "pcf2x2";

impl FromStr for Filter {
    type Err = Error;

    /// The filter of a text.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a filter or a setting that does not exist; [`Error::InvalidArgument`] for a setting that is
    /// missing, given twice, not a number or out of its limits.
    fn from_str(text: &str) -> Result<Self> {
        let (name, rest) = split(text);
        let settings = |name, known| Settings::read("filter", name, known, rest);
        match name {
            "nearest" => settings("nearest", &[]).map(|_| Self::Nearest),
            "bilinear" | PCF_2X2 => settings("bilinear", &[]).map(|_| Self::Bilinear),
            "pcf" => Self::Pcf { size: settings("pcf", &["size"])?.extent("size")? }.checked(),
            "tent" => Self::Tent { size: settings("tent", &["size"])?.extent("size")? }.checked(),
            "poisson" => {
                let settings = settings("poisson", &["count", "radius", "seed"])?;
                let (count, seed) = (settings.whole("count", 16)?, settings.whole("seed", 0)?);
                Self::Poisson { count, radius: settings.extent("radius")?, seed }.checked()
            }
            _ => {
                let valid = FILTERS.iter().map(|spec| spec.name.to_string()).collect();
                Err(Error::UnknownName { kind: "filter".into(), name: name.into(), valid })
            }
        }
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nearest => f.write_str("nearest"),
            Self::Bilinear => f.write_str("bilinear"),
            Self::Pcf { size } => write!(f, "pcf:size={size}"),
            Self::Tent { size } => write!(f, "tent:size={size}"),
            Self::Poisson { count, radius, seed } => write!(f, "poisson:count={count},radius={radius},seed={seed}"),
        }
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.length, if self.unit == Unit::Pixels { "px" } else { "" })
    }
}

impl Settings<'_> {
    fn extent(&self, key: &str) -> Result<Extent> {
        let (expected, fix) = ("a number of texels, or of pixels with px", format!("try {key}=3 or {key}=3px"));
        let Some(text) = self.value(key) else {
            return Err(Error::argument(self.name(key), expected, "nothing", fix));
        };
        let (number, unit) = match text.strip_suffix("px") {
            Some(number) => (number.trim_end(), Unit::Pixels),
            None => (text, Unit::Texels),
        };
        match number.parse::<f64>() {
            Ok(length) if length.is_finite() => Ok(Extent { length, unit }),
            _ => Err(Error::argument(self.name(key), expected, format!("{text:?}"), fix)),
        }
    }
    fn whole(&self, key: &str, default: u32) -> Result<u32> {
        let Some(text) = self.value(key) else { return Ok(default) };
        let expected = format!("a whole number from 0 to {}", u32::MAX);
        let refused =
            |_| Error::argument(self.name(key), expected, format!("{text:?}"), format!("try {key}={default}"));
        text.parse().map_err(refused)
    }
}
