//! Depths on the planes of receivers under a logarithm: no plane is one there, so each texel asks where its ray meets the plane.

use glam::{DMat3, DVec3, DVec4};

use super::lookup::MapLookup;
use super::runs::Compared;
use crate::aliasing::receivers::RUN;
use crate::parameterization::PostWarp;

/// The point of a plane, through `p` with a normal, on which two functionals of (q, 1) are 0; not finite where there is none.
#[inline(always)]
pub(super) fn meeting_point(across: DVec4, along: DVec4, p: DVec3, normal: DVec3) -> DVec3 {
    let m = DMat3::from_cols(across.truncate(), along.truncate(), normal).transpose();
    m.inverse() * DVec3::new(-across.w, -along.w, normal.dot(p))
}

impl MapLookup {
    /// The w of a logarithm in rows with these centres, for receivers whose planes are asked.
    #[inline(always)]
    pub(super) fn w_of_rows(&self, found: &Compared, centre: impl Fn(usize) -> f64) -> [f64; RUN] {
        let mut w = [0.0; RUN];
        if let PostWarp::Log { scale, offset } = self.post_warp
            && found.asks_planes
        {
            let height = f64::from(self.size[1]);
            for i in 0..RUN {
                w[i] = ((1.0 - 2.0 * centre(i) / height - offset) / scale).exp();
            }
        }
        w
    }

    /// The depths that texels are compared with whose columns have these centres, and whose rows have these w:
    /// [`MapLookup::depth_at`] of a common case under a logarithm.
    #[inline(always)]
    pub(super) fn depths_on_planes(
        &self,
        found: &Compared,
        centre: impl Fn(usize) -> f64,
        w: &[f64; RUN],
        z: &mut [f64; RUN],
    ) {
        let [row_x, _, _, row_w] = self.rows;
        let width = f64::from(self.size[0]);
        for i in 0..RUN {
            let x = 2.0 * centre(i) / width - 1.0;
            let p = DVec3::new(found.p[0][i], found.p[1][i], found.p[2][i]);
            let normal = DVec3::new(found.normal[0][i], found.normal[1][i], found.normal[2][i]);
            let q = meeting_point(row_x - x * row_w, row_w - DVec4::W * w[i], p, normal);
            let depth = self.depth.at(q.extend(1.0));
            let is_known = q.is_finite() & depth.is_finite();
            let change = if is_known { depth - found.unbiased[i] } else { 0.0 };
            z[i] = self.depth_beside(found.z[i], change, found.limit[i]);
        }
    }
}
