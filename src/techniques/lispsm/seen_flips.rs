//! The error of a warp as the share of pixels whose shadow state changes within their texel: wrong pixels foretold.
//!
//! Source: theory.md (10.9), for the family of warps along one axis (10.10). With D = d(pixel) / d(x, y) of the
//! unwarped space and q, k of [`SeenError`](super::SeenError), a texel's sides in the picture are
//!
//! ```text
//! G = [D_x q Ex,  (D_x x k + D_y q) q Ey] / N
//! ```

use glam::{DMat2, DVec2};

use super::measure::{Measure, across_along_per_ndc};
use super::seen_error::Unwarped;
use crate::fit::MapSize;
use crate::focus::{Picture, RayFlip, RayFrame, Shadows};
use crate::techniques::kit::WarpSpace;

/// Of so many receivers one is asked at the first look at a strength.
const FEW_STEP: usize = 8;

/// The measure over receivers near shadows' edges for every warp distance of a warp space.
#[derive(Debug, Clone)]
pub struct SeenFlips<'a> {
    picture: &'a Picture,
    shadows: &'a Shadows,
    points: Vec<(f64, f64, DMat2, RayFlip)>,
    per_extent: f64,
    texels: DVec2,
}

impl<'a> SeenFlips<'a> {
    /// The measure of a space's warps; receivers at which the space's own w is not positive are left out.
    pub fn new(
        space: &WarpSpace,
        rays: &RayFrame,
        receivers: &[RayFlip],
        size: &MapSize,
        picture: &'a Picture,
        shadows: &'a Shadows,
    ) -> Self {
        let unwarped = Unwarped::new(space, rays);
        let point = |flip: &RayFlip| {
            let (x, eta, ray_per_unit) = unwarped.at(flip.ray)?;
            Some((x, eta, flip.pixel * ray_per_unit, *flip))
        };
        let points = receivers.iter().filter_map(point).collect();
        let texels = size.receivers_texels();
        Self { picture, shadows, points, per_extent: unwarped.per_extent, texels }
    }
    fn over(&self, step: usize, mu: f64, ndc: DVec2) -> f64 {
        let texel = ndc * across_along_per_ndc(mu) / self.texels;
        let (scale, k) = (1.0 / (1.0 + mu), mu / (1.0 + mu) * self.per_extent);
        let (mut sum, mut count) = (0.0, 0.0);
        for (x, eta, pixel, flip) in self.points.iter().step_by(step) {
            let q = ((1.0 + mu * eta) * scale).max(0.0);
            let across = pixel.x_axis * (q * texel.x);
            let along = (pixel.x_axis * (x * k) + pixel.y_axis * q) * (q * texel.y);
            sum += self.shadows.flips(self.picture, &flip.near, &DMat2::from_cols(across, along));
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

impl Measure for SeenFlips<'_> {
    fn error(&self, mu: f64, ndc: DVec2) -> f64 {
        self.over(1, mu, ndc)
    }
    fn rough(&self, mu: f64, ndc: DVec2) -> f64 {
        self.over(FEW_STEP, mu, ndc)
    }
    fn is_less(&self, error: f64, other: f64) -> bool {
        error < other
    }
}
