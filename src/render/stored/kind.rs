//! The choices of what a map stores.
//!
//! Source: theory.md 13: second depth, Wang and Molnar 1994 `[wang1994]`; midpoint, Woo 1992 `[woo1992]`; dual
//! depth layers, Weiskopf and Ertl 2003 `[weiskopf2003]`; spacing linear along the light, `[scherzer2005]`.

use super::format::Format;
use crate::error::{Error, Result};
use crate::names::name_of;

/// Which depth of a light ray is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum StoredSurface {
    /// The surface nearest to the light.
    #[default]
    Front,
    /// The nearest surface that faces away from the light, by its winding.
    Back,
    /// The nearest depth beyond the first; 1 where there is none.
    Second,
    /// The middle between the first and the second depth along the ray; 1 where there is no second.
    Midpoint,
    /// The first depth moved towards the second by half of the way between them, at most [`Stored::limit`].
    Dual,
}

/// How depth is spaced between the near plane (0) and the far plane (1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Spacing {
    /// z / w of the map's matrix.
    #[default]
    Projective,
    /// World distance along the direction of the light: of a directional light its own, of another the map's central ray.
    Linear,
}

/// What a map stores of each light ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stored {
    /// Which depth.
    pub surface: StoredSurface,
    /// In which units.
    pub spacing: Spacing,
    /// Rounded to which numbers.
    pub format: Format,
    /// Of [`StoredSurface::Dual`]: the most that the first depth is moved along the ray, in world sizes of a shadow texel at
    /// the surface, across the ray.
    pub limit: f64,
}

impl Default for Stored {
    /// The nearest surface, as the matrix gives its depth, in single precision.
    fn default() -> Self {
        Self::FRONT
    }
}

impl StoredSurface {
    /// The names users write.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("front", Self::Front),
        ("back", Self::Back),
        ("second", Self::Second),
        ("midpoint", Self::Midpoint),
        ("dual", Self::Dual),
    ];
    /// Whether two depths of a ray are needed.
    pub fn takes_two(self) -> bool {
        matches!(self, Self::Second | Self::Midpoint | Self::Dual)
    }
    /// Whether it is a surface behind the first that light meets, or that one only where it is averted.
    pub fn is_behind_first(self) -> bool {
        matches!(self, Self::Back | Self::Second)
    }
    /// Whether a caster must be closed to be shadowed from behind: what a ray enters, it leaves.
    pub fn needs_closed(self) -> bool {
        matches!(self, Self::Back | Self::Second | Self::Midpoint)
    }
    /// The name users write.
    pub fn name(self) -> &'static str {
        name_of(&Self::NAMES, self)
    }
}

impl Spacing {
    /// The names users write.
    pub const NAMES: [(&'static str, Self); 2] = [("projective", Self::Projective), ("linear", Self::Linear)];
    /// The name users write.
    pub fn name(self) -> &'static str {
        name_of(&Self::NAMES, self)
    }
}

impl Stored {
    /// The default of [`Stored::limit`]: docs/bias.md has the table that it was chosen by.
    pub const LIMIT: f64 = 8.0;
    /// The default.
    pub const FRONT: Self =
        Self { surface: StoredSurface::Front, spacing: Spacing::Projective, format: Format::F32, limit: Self::LIMIT };

    /// This, if it is usable.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a limit that is negative or not a number.
    pub fn checked(self) -> Result<Self> {
        if self.limit >= 0.0 {
            return Ok(self);
        }
        let fix = "infinity stores the midpoint";
        Err(Error::argument("stored.limit", "a number of texels, 0 or more", self.limit, fix))
    }
    /// Whether the rasteriser's depth is what is stored, but for its format.
    pub fn is_plain(&self) -> bool {
        self.spacing == Spacing::Projective && !self.surface.takes_two()
    }
}
