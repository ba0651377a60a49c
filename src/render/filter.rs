//! How a map is read: theory.md 14, `[reeves1987]`. The average is of comparisons, never of depths.

/// The reconstruction filter of a lookup.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// One comparison with the texel the point falls into.
    #[default]
    Nearest,
    /// Percentage-closer filtering, bilinear weights over the four nearest texel centres.
    Pcf2x2,
}

impl Filter {
    /// The names users write, in order of cost.
    pub const NAMES: [(&'static str, Self); 2] = [("nearest", Self::Nearest), ("pcf2x2", Self::Pcf2x2)];

    /// How far from the point a compared texel centre can lie, in texels along each axis.
    pub fn reach_texels(self) -> f64 {
        match self {
            Self::Nearest => 0.5,
            Self::Pcf2x2 => 1.0,
        }
    }
}
