//! What happens to map coordinates after the projective part.
//!
//! Source: theory.md (11.1) for the logarithm, (10.12) for the rectilinear warp. Under both, a light ray stays a point of the
//! map: y of a logarithm is a function of w, which is constant along a ray; x and y of a rectilinear warp are functions of
//! the projective x and y.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::piecewise_linear::PiecewiseLinear;

/// What happens to map coordinates after the projective part.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum PostWarp {
    /// Nothing.
    #[default]
    None,
    /// NDC y is replaced by `scale * ln(w) + offset`, w the clip w that the matrix gives (11.1). As w is constant
    /// along a light ray, rays stay points; x and z are those of the projective part. Planes are no planes any more.
    Log {
        /// NDC y per unit of ln w.
        scale: f64,
        /// NDC y where w = 1.
        offset: f64,
    },
    /// NDC x and y are each replaced by a function of themselves (10.12). z is that of the projective part, and lines along
    /// the map's axes stay such lines; other lines bend at the knots.
    Rectilinear(Arc<Rectilinear>),
}

/// A separable warp of the map's square: rows and columns of texels stay rows and columns, of uneven widths.
#[derive(Debug, Clone, PartialEq)]
pub struct Rectilinear {
    /// NDC x after the warp, of NDC x before it.
    pub x: PiecewiseLinear,
    /// NDC y after the warp, of NDC y before it.
    pub y: PiecewiseLinear,
}

impl PostWarp {
    /// NDC after this, of NDC and w before it (11.1), (10.12).
    pub fn apply(&self, ndc: DVec3, w: f64) -> DVec3 {
        match self {
            Self::None => ndc,
            Self::Log { scale, offset } => DVec3::new(ndc.x, scale * w.ln() + offset, ndc.z),
            Self::Rectilinear(warp) => warp.after(ndc.truncate()).extend(ndc.z),
        }
    }
    /// The name that users know.
    pub fn name(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Log { .. } => "log",
            Self::Rectilinear(_) => "rectilinear",
        }
    }
    /// The rectilinear warp, where it is one.
    pub fn rectilinear(&self) -> Option<&Rectilinear> {
        match self {
            Self::Rectilinear(warp) => Some(warp),
            Self::None | Self::Log { .. } => None,
        }
    }
}

impl Rectilinear {
    /// NDC x and y after the warp, of those before it.
    pub fn after(&self, ndc: DVec2) -> DVec2 {
        DVec2::new(self.x.after(ndc.x), self.y.after(ndc.y))
    }
    /// NDC x and y before the warp, of those after it.
    pub fn before(&self, ndc: DVec2) -> DVec2 {
        DVec2::new(self.x.before(ndc.x), self.y.before(ndc.y))
    }
    /// Growth of NDC after the warp per growth of NDC before it, along x and y, at NDC before it.
    pub fn slopes(&self, ndc: DVec2) -> DVec2 {
        DVec2::new(self.x.slope(ndc.x), self.y.slope(ndc.y))
    }
}
