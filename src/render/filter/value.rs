//! A filter as a value, with the limits of its settings: theory.md 14, `[reeves1987]`.

use crate::error::{Error, Result};

/// Widest kernel, texels along each axis: 4225 comparisons a pixel. A kernel in pixels ends there, too.
pub const WIDEST_TEXELS: f64 = 64.0;
/// Most points of a Poisson disc: what a uniform buffer of a device holds beside the rest.
pub const MOST_POINTS: u32 = 256;

/// The reconstruction filter of a lookup. The average is of comparisons, never of depths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Filter {
    /// One comparison with the texel the point falls into.
    #[default]
    Nearest,
    /// Percentage-closer filtering, bilinear weights over the four nearest texel centres.
    Bilinear,
    /// Percentage-closer filtering: a texel weighs its overlap with a box about the point.
    Pcf {
        /// Side of the box.
        size: Extent,
    },
    /// A texel weighs the integral over it of a triangle along x times one along y, about the point.
    Tent {
        /// Where each triangle begins and ends, from end to end.
        size: Extent,
    },
    /// As many comparisons of equal weight, each with the texel that a point of a Poisson disc falls into.
    Poisson {
        /// Points.
        count: u32,
        /// Radius of the disc.
        radius: Extent,
        /// Which disc.
        seed: u32,
    },
}

/// A length of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// In its unit.
    pub length: f64,
    /// Its unit.
    pub unit: Unit,
}

/// The unit of a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Texels of the map: constant in the map.
    Texels,
    /// Pixels of the picture on the receiver's own plane: constant in the picture.
    Pixels,
}

impl Extent {
    /// A length in texels.
    pub const fn texels(length: f64) -> Self {
        Self { length, unit: Unit::Texels }
    }
    /// A length in pixels.
    pub const fn pixels(length: f64) -> Self {
        Self { length, unit: Unit::Pixels }
    }
}

impl Filter {
    /// Those without settings, by name, in order of cost.
    pub const PLAIN: [(&'static str, Self); 2] = [("nearest", Self::Nearest), ("bilinear", Self::Bilinear)];

    /// The length that sets how wide it is; nothing of those without settings.
    pub fn extent(&self) -> Option<Extent> {
        match self {
            Self::Nearest | Self::Bilinear => None,
            Self::Pcf { size } | Self::Tent { size } => Some(*size),
            Self::Poisson { radius, .. } => Some(*radius),
        }
    }
    /// Whether its kernel is constant in the picture.
    pub fn is_in_pixels(&self) -> bool {
        self.extent().is_some_and(|extent| extent.unit == Unit::Pixels)
    }
    /// This filter if its settings are usable.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a kernel narrower than one texel or wider than [`WIDEST_TEXELS`], no points or more than
    /// [`MOST_POINTS`].
    pub fn checked(self) -> Result<Self> {
        match self {
            Self::Nearest | Self::Bilinear => {}
            Self::Pcf { size } => check_length("filter pcf: size", size, 1.0, WIDEST_TEXELS)?,
            Self::Tent { size } => check_length("filter tent: size", size, 1.0, WIDEST_TEXELS)?,
            Self::Poisson { count, radius, .. } => {
                check_length("filter poisson: radius", radius, 0.5, 0.5 * WIDEST_TEXELS)?;
                if !(1..=MOST_POINTS).contains(&count) {
                    let expected = format!("1 to {MOST_POINTS} points");
                    return Err(Error::argument("filter poisson: count", expected, count, "try 16"));
                }
            }
        }
        Ok(self)
    }
}

/// Refuses a length beyond its limits; pixels may be small, for the kernel has a least width in texels.
fn check_length(name: &'static str, Extent { length, unit }: Extent, least: f64, most: f64) -> Result<()> {
    let (is_usable, expected, got) = match unit {
        Unit::Texels => {
            ((least..=most).contains(&length), format!("{least} to {most} texels"), format!("{length} texels"))
        }
        Unit::Pixels => (
            length > 0.0 && length <= most,
            format!("more than 0 and at most {most} pixels"),
            format!("{length} pixels"),
        ),
    };
    if is_usable { Ok(()) } else { Err(Error::argument(name, expected, got, "try 3 texels, or 3px for pixels")) }
}
