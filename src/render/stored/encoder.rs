//! What is stored of a texel, from the two nearest depths of its ray: theory.md (13.6), (13.7), (13.8).
//!
//! Along a ray, linear depth and 1 / w are both affine functions of z over each other, so a mean of places on the ray is a mean of
//! linear depths, from which z follows by one quotient. stored.wgsl is the twin.

use glam::{DVec2, DVec3, DVec4};

use super::kind::{Spacing, Stored, StoredSurface};
use super::texel_rays::TexelRays;
use crate::error::Result;

/// The two nearest depths of a ray, z of the matrix; 1 for none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layers {
    pub first: f64,
    pub second: f64,
}

/// What is stored of the texels of a map, before it is rounded to a format.
#[derive(Debug, Clone)]
pub(crate) struct Encoder {
    stored: Stored,
    rays: TexelRays,
    /// Linear depth times w, and w, of (place, z, 1).
    linear: DVec4,
    w: DVec4,
    /// Units of linear depth to one along the axis of linear depth.
    axis: DVec3,
}

impl Encoder {
    /// For what takes more than the rasteriser's depth.
    ///
    /// # Errors
    /// As [`TexelRays::linear_row`], where depth is stored linear.
    pub fn new(rays: TexelRays, stored: Stored) -> Result<Self> {
        let row = match stored.spacing {
            Spacing::Linear => rays.linear_row()?,
            // Depths are averaged along the light, in any unit.
            Spacing::Projective => rays.along().extend(0.0),
        };
        let rows = rays.inverse.transpose();
        Ok(Self { stored, linear: rows * row, w: rows.w_axis, axis: row.truncate(), rays })
    }
    /// What is stored of a texel, in [0, 1].
    #[inline]
    pub fn texel(&self, column: usize, row: usize, layers: Layers) -> f64 {
        if layers.first >= 1.0 {
            return 1.0;
        }
        let [x, y] = self.rays.ndc(column, row);
        self.value(self.rays.place(x, y), layers)
    }
    /// What is stored at a projective place, in [0, 1].
    #[inline]
    pub fn value(&self, place: DVec2, layers: Layers) -> f64 {
        let Layers { first, second } = layers;
        let is_alone = second >= 1.0;
        let surface = self.stored.surface;
        if first >= 1.0 || is_alone && matches!(surface, StoredSurface::Second | StoredSurface::Midpoint) {
            return 1.0;
        }
        if surface == StoredSurface::Second && self.stored.spacing == Spacing::Projective {
            return second;
        }
        let (place4, z_axis) = (DVec4::new(place.x, place.y, 0.0, 1.0), DVec2::new(self.linear.z, self.w.z));
        let at_near = DVec2::new(self.linear.dot(place4), self.w.dot(place4));
        // (13.6)
        let linear = |z: f64| {
            let at = at_near + z * z_axis;
            at.x / at.y
        };
        let depth = match surface {
            StoredSurface::Front | StoredSurface::Back => linear(first),
            StoredSurface::Second => linear(second),
            // (13.7)
            StoredSurface::Midpoint => 0.5 * (linear(first) + linear(second)),
            // (13.8)
            StoredSurface::Dual => {
                let from = linear(first);
                let half = if is_alone { f64::INFINITY } else { 0.5 * (linear(second) - from) };
                let moved = half.min(self.limit(place, first));
                if moved == f64::INFINITY {
                    return 1.0;
                }
                from + moved
            }
        };
        let value = match self.stored.spacing {
            Spacing::Linear => depth,
            // The same quotient, solved for z.
            Spacing::Projective => (at_near.x - depth * at_near.y) / (depth * z_axis.y - z_axis.x),
        };
        value.clamp(0.0, 1.0)
    }
    /// The limit of dual layers at a depth, in linear depth.
    #[inline]
    fn limit(&self, place: DVec2, z: f64) -> f64 {
        if self.stored.limit == f64::INFINITY {
            return f64::INFINITY;
        }
        let m = &self.rays.inverse;
        let point = *m * DVec4::new(place.x, place.y, z, 1.0);
        let away = m.z_axis;
        let ray = (away.truncate() * point.w - away.w * point.truncate()).normalize_or_zero();
        self.stored.limit * self.rays.texel(place, z) * self.axis.dot(ray)
    }
}
