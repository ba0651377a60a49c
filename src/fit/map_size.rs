//! The texels of a map: how many, how many at its edges stay free, and the share that is left for receivers.

use glam::DVec2;

use crate::error::{Error, Result};

/// Texels along each edge of a map that no receiver maps to. Derived from the filters: a lookup compares texel centres up to
/// one texel from the point, so none of them lies off the map. Border texels are as complete as any other ([`fit`](super::fit())); nothing
/// is clamped to them, so they need not stay empty as the article has them.
pub const BORDER_TEXELS: u32 = 1;

/// A body without extent across the light gets this share of its distance (theory.md 1.1).
pub(super) const POINT_EXTENT: f64 = 1e-6;

/// The texels of a map and those at its edge that no receiver maps to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapSize {
    /// Texels along x and y.
    pub resolution: [u32; 2],
    /// Texels along each edge that no receiver maps to.
    pub border: u32,
    /// Texels between border and samples.
    pub margin: f64,
    /// Factor by which the samples' room is larger than they are, along x and y.
    pub slack: f64,
}

impl MapSize {
    /// A map with [`BORDER_TEXELS`] along each edge.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a resolution that leaves no texel between the borders.
    pub fn new(resolution: [u32; 2]) -> Result<Self> {
        let (border, least) = (BORDER_TEXELS, 2 * BORDER_TEXELS + 1);
        if let Some(&texels) = resolution.iter().find(|&&texels| texels < least) {
            let expected = format!("at least {least} texels (a border of {border} at each edge and one between)");
            return Err(Error::argument("resolution", expected, texels, "choose a larger map"));
        }
        Ok(Self { resolution, border, margin: 0.0, slack: 1.0 })
    }
    /// Texels along x and y.
    pub fn texels(&self) -> DVec2 {
        DVec2::from_array(self.resolution.map(f64::from))
    }
    /// Texels along x and y between the borders.
    pub fn between(&self) -> DVec2 {
        self.texels() - 2.0 * f64::from(self.border)
    }
    /// The share of [-1, 1] that receivers fill, along x and y.
    pub fn inset(&self) -> DVec2 {
        self.receivers_texels() / self.texels()
    }
    /// Texels along x and y that receivers fill.
    pub fn receivers_texels(&self) -> DVec2 {
        (self.between() - 2.0 * self.margin) / self.slack
    }
    /// Texels along x or y, whichever has fewer.
    pub fn fewest(&self) -> f64 {
        self.texels().min_element()
    }
    /// The same with so many texels between the border and the samples that the map must hold, and with a `slack` of 1 or more.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a margin that leaves less than half of the texels between the borders.
    pub fn with_room(self, margin: f64, slack: f64) -> Result<Self> {
        let between = self.between().min_element();
        if !(margin <= 0.25 * between) {
            let expected = format!("at most a quarter of the texels between the map's borders, {between}");
            return Err(Error::argument("margin", expected, margin, "give a smaller margin, or a larger map"));
        }
        Ok(Self { margin, slack, ..self })
    }
}
