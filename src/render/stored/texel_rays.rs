//! The light rays of a map's texels, and depths along them.
//!
//! Source: theory.md (13.4), (13.5). A projective map with inverse M⁻¹ has at the place (x, y) the points
//! X = M⁻¹ (x, y, z, 1), one for each depth z; with that w of X is the inverse of clip w. Behind a logarithm the matrix with 1 in
//! place of its row y has the same rays at (x, 1/w) (11.1), and a rectilinear map has them at f⁻¹(x), g⁻¹(y) (10.12).

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::geometry::Rows;
use crate::parameterization::PostWarp;

/// Largest clip w of what linear depth is fitted to, in units of the least: beyond, a texel is a million times as large.
const DEEPEST: f64 = 1024.0;

/// The rays of the texels of a map.
#[derive(Debug, Clone)]
pub(crate) struct TexelRays {
    /// Local space from projective places: columns x, y, z, 1.
    pub inverse: DMat4,
    pub post_warp: PostWarp,
    /// Texels along x and y.
    pub size: [u32; 2],
}

impl TexelRays {
    /// Of a matrix and what follows it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix without an inverse.
    pub fn new(clip_from_local: &DMat4, post_warp: &PostWarp, size: [u32; 2]) -> Result<Self> {
        let mut rows = Rows::of(clip_from_local);
        if let PostWarp::Log { scale, offset } = post_warp {
            // w at the middle row becomes 1, whatever the matrix was multiplied with.
            rows = rows.scaled((offset / scale).exp());
            rows.y = DVec4::W;
        }
        let inverse = rows.matrix().inverse();
        if inverse.is_finite() {
            return Ok(Self { inverse, post_warp: post_warp.clone(), size });
        }
        let fix = "check where the matrix comes from, or store the front or the back with spacing=projective";
        Err(Error::argument("shadow_clip_from_world", "a matrix that has an inverse", "a singular one", fix))
    }
    /// The projective place of NDC x and y.
    #[inline]
    pub fn place(&self, x: f64, y: f64) -> DVec2 {
        match &self.post_warp {
            PostWarp::None => DVec2::new(x, y),
            PostWarp::Log { scale, .. } => DVec2::new(x, (-y / scale).exp()),
            PostWarp::Rectilinear(warp) => warp.before(DVec2::new(x, y)),
        }
    }
    /// NDC x and y of a texel's centre.
    #[inline]
    pub fn ndc(&self, column: usize, row: usize) -> [f64; 2] {
        let [width, height] = self.size.map(f64::from);
        [(2 * column + 1) as f64 / width - 1.0, 1.0 - (2 * row + 1) as f64 / height]
    }
    /// The middle of the map; the origin where that is at infinity.
    pub fn middle(&self) -> DVec3 {
        let place = self.place(0.0, 0.0);
        let centre = self.inverse * DVec4::new(place.x, place.y, 0.5, 1.0);
        let centre = centre.truncate() / centre.w;
        if centre.is_finite() { centre } else { DVec3::ZERO }
    }
    /// How far the finite corners of the map reach from the origin; 1 where none does.
    #[cfg(feature = "gpu")]
    pub fn reach(&self) -> f64 {
        let corner = |k: u32| {
            let side = |bit: u32| f64::from(k >> bit & 1) * 2.0 - 1.0;
            let place = self.place(side(0), side(1));
            let point = self.inverse * DVec4::new(place.x, place.y, 0.5 + 0.5 * side(2), 1.0);
            (point.truncate() / point.w).length()
        };
        let reach = (0..8).map(corner).filter(|reach| reach.is_finite()).fold(0.0, f64::max);
        if reach > 0.0 { reach } else { 1.0 }
    }
    /// The way of the light on the map's central ray, a unit vector; zero where there is none.
    pub fn along(&self) -> DVec3 {
        let away = self.inverse.z_axis;
        (away.truncate() - away.w * self.middle()).normalize_or_zero()
    }
    /// The row that is 0 at the map's nearest and 1 at its farthest point along the light (13.5), of the parts of its near and far
    /// plane whose clip w is at most [`DEEPEST`] times the least there: a border may reach to the horizon of a warp.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a map that has no such part.
    pub fn linear_row(&self) -> Result<DVec4> {
        let along = self.along();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| self.place(x, y));
        let at = |place: DVec2, z: f64| self.inverse * DVec4::new(place.x, place.y, z, 1.0);
        // Of either plane by itself: from the near to the far plane of a spot w may grow by more without a warp.
        let largest = [0.0, 1.0].map(|z| corners.iter().map(|c| at(*c, z).w).fold(0.0, f64::max));
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut count = |point: DVec4| {
            let depth = along.dot(point.truncate()) / point.w;
            (near, far) = (near.min(depth), far.max(depth));
        };
        // A quotient of affine functions is least and largest at corners of the part.
        for (z, largest) in [(0.0, largest[0]), (1.0, largest[1])] {
            let least = largest / DEEPEST;
            for k in 0..4 {
                let [a, b] = [corners[k], corners[(k + 1) % 4]].map(|corner| at(corner, z));
                if a.w >= least {
                    count(a);
                }
                if (a.w >= least) != (b.w >= least) {
                    count(a + (b - a) * ((least - a.w) / (b.w - a.w)));
                }
            }
        }
        let row = (along / (far - near)).extend(-near / (far - near));
        if largest.iter().all(|w| *w > 0.0) && along != DVec3::ZERO && row.is_finite() && far > near {
            return Ok(row);
        }
        let expected = "for spacing=linear maps with a far plane and points before the projection centre";
        Err(Error::argument("stored", expected, "a map without one or the other", "use spacing=projective"))
    }
    /// World size of a texel across the ray at a depth, its longer side.
    #[inline]
    pub fn texel(&self, place: DVec2, z: f64) -> f64 {
        let m = &self.inverse;
        let point = *m * DVec4::new(place.x, place.y, z, 1.0);
        let p = point.truncate() / point.w;
        let moved = |column: DVec4| (column.truncate() - column.w * p) / point.w;
        let ray = moved(m.z_axis).normalize_or_zero();
        let [dx, dy] = [2.0 / f64::from(self.size[0]), 2.0 / f64::from(self.size[1])];
        let step = match &self.post_warp {
            PostWarp::None => DVec2::new(dx, dy),
            PostWarp::Log { scale, .. } => DVec2::new(dx, dy * place.y / scale.abs()),
            PostWarp::Rectilinear(warp) => DVec2::new(dx, dy) / warp.slopes(place),
        };
        (moved(m.x_axis).cross(ray) * step.x).length().max((moved(m.y_axis).cross(ray) * step.y).length())
    }
}
