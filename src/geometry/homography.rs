//! Projective maps of space, row by row: a row of a 4x4 matrix is a linear functional of (p, 1).

use glam::{DMat2, DMat3, DMat4, DVec2, DVec3, DVec4};

/// The rows of a 4x4 matrix that acts on columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows {
    /// Clip x.
    pub x: DVec4,
    /// Clip y.
    pub y: DVec4,
    /// Clip z.
    pub z: DVec4,
    /// Clip w.
    pub w: DVec4,
}

impl Rows {
    /// The rows of a matrix.
    pub fn of(m: &DMat4) -> Self {
        let t = m.transpose();
        Self { x: t.x_axis, y: t.y_axis, z: t.z_axis, w: t.w_axis }
    }
    /// The matrix with these rows.
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_cols(self.x, self.y, self.z, self.w).transpose()
    }
    /// Clip coordinates of a point.
    pub fn clip(&self, p: DVec3) -> DVec4 {
        let p = p.extend(1.0);
        DVec4::new(self.x.dot(p), self.y.dot(p), self.z.dot(p), self.w.dot(p))
    }
    /// NDC of a point whose w is not 0.
    pub fn project(&self, p: DVec3) -> DVec3 {
        let clip = self.clip(p);
        clip.truncate() / clip.w
    }
    /// `target_from_source` acting on the result of these rows.
    pub fn then(&self, target_from_source: &[[f64; 4]; 4]) -> Self {
        let row = |m: &[f64; 4]| self.x * m[0] + self.y * m[1] + self.z * m[2] + self.w * m[3];
        let [x, y, z, w] = target_from_source;
        Self { x: row(x), y: row(y), z: row(z), w: row(w) }
    }
    /// The map after the affine crop of the box [low, high] (NDC) to [-1, 1]² x [0, 1] (theory.md 0, `C(lo, hi)`).
    pub fn cropped(&self, low: DVec3, high: DVec3) -> Self {
        let scale = (high - low).recip() * DVec3::new(2.0, 2.0, 1.0);
        let middle = 0.5 * (low + high);
        Self {
            x: (self.x - self.w * middle.x) * scale.x,
            y: (self.y - self.w * middle.y) * scale.y,
            z: (self.z - self.w * low.z) * scale.z,
            w: self.w,
        }
    }
    /// The matrix that [`Rows::cropped`] applies: `C(lo, hi)` of theory.md 0.
    pub fn crop(low: DVec3, high: DVec3) -> DMat4 {
        let scale = (high - low).recip() * DVec3::new(2.0, 2.0, 1.0);
        let moved = (0.5 * (low + high)).truncate().extend(low.z) * scale;
        DMat4::from_cols(DVec4::X * scale.x, DVec4::Y * scale.y, DVec4::Z * scale.z, (-moved).extend(1.0))
    }
    /// All rows times k: the same map where k > 0.
    pub fn scaled(&self, k: f64) -> Self {
        Self { x: self.x * k, y: self.y * k, z: self.z * k, w: self.w * k }
    }
    /// The rows for points told relative to the source's origin, when these act on points relative to `origin`.
    pub fn moved_to_world(&self, origin: DVec3) -> Self {
        let row = |r: DVec4| r.truncate().extend(r.w - r.truncate().dot(origin));
        Self { x: row(self.x), y: row(self.y), z: row(self.z), w: row(self.w) }
    }
    /// Derivative of NDC (x, y, z) along a direction at a point (E.5).
    pub fn derivative(&self, p: DVec3, direction: DVec3) -> DVec3 {
        let clip = self.clip(p);
        let d = direction.extend(0.0);
        let moved = DVec3::new(self.x.dot(d), self.y.dot(d), self.z.dot(d));
        (moved * clip.w - clip.truncate() * self.w.dot(d)) / (clip.w * clip.w)
    }
    /// Derivatives of NDC (x, y) along two directions at a point, one a column.
    pub fn jacobian(&self, p: DVec3, directions: [DVec3; 2]) -> DMat2 {
        let column = |d: DVec3| -> DVec2 { self.derivative(p, d).truncate() };
        DMat2::from_cols(column(directions[0]), column(directions[1]))
    }
}

/// Where a homography of the plane takes a point, its w there, and d(image) / d(point), rows first (E.5 in two dimensions).
#[inline]
pub fn planar_image(homography: &DMat3, p: DVec2) -> (DVec2, f64, DMat2) {
    let clip = *homography * p.extend(1.0);
    let at = clip.truncate() / clip.z;
    let gradient = |i: usize| (homography.row(i) - homography.row(2) * at[i]).truncate() / clip.z;
    (at, clip.z, DMat2::from_cols(gradient(0), gradient(1)).transpose())
}

/// Singular values of a 2x2 matrix, the larger one first.
pub fn singular_values(m: &DMat2) -> (f64, f64) {
    let (a, b, c, d) = (m.x_axis.x, m.y_axis.x, m.x_axis.y, m.y_axis.y);
    // Sums and differences of the two instead of a root of a difference: nothing cancels.
    let sum = (a + d).hypot(b - c);
    let difference = (a - d).hypot(b + c);
    (0.5 * (sum + difference), 0.5 * (sum - difference).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: Rows = Rows {
        x: DVec4::new(1.0, 0.2, -0.3, 4.0),
        y: DVec4::new(0.1, -2.0, 0.5, 1.0),
        z: DVec4::new(0.0, 0.3, 1.0, -2.0),
        w: DVec4::new(0.02, -0.1, 0.05, 3.0),
    };

    #[test]
    fn rows_act_as_their_matrix_and_crop_maps_the_box() {
        let p = DVec3::new(0.3, -0.8, 1.7);
        assert!((ROWS.matrix() * p.extend(1.0) - ROWS.clip(p)).length() < 1e-15);
        assert_eq!(Rows::of(&ROWS.matrix()), ROWS);
        let ndc = ROWS.project(p);
        let low = ROWS.cropped(ndc, ndc + DVec3::new(2.0, 3.0, 4.0)).project(p);
        let crop = Rows::crop(ndc, ndc + DVec3::new(2.0, 3.0, 4.0));
        assert!((crop * ndc.extend(1.0) - DVec4::new(-1.0, -1.0, 0.0, 1.0)).length() < 1e-14);
        let high = ROWS.cropped(ndc - DVec3::new(2.0, 3.0, 4.0), ndc).project(p);
        assert!((low - DVec3::new(-1.0, -1.0, 0.0)).length() < 1e-14);
        assert!((high - DVec3::ONE).length() < 1e-14);
        let origin = DVec3::new(100.0, -50.0, 7.0);
        assert!((ROWS.moved_to_world(origin).project(p + origin) - ndc).length() < 1e-12);
    }

    #[test]
    fn the_jacobian_of_the_plane_is_the_central_difference() {
        let homography = DMat3::from_cols_array(&[1.0, 0.1, 0.02, 0.2, -2.0, -0.1, 4.0, 1.0, 3.0]);
        let (p, h) = (DVec2::new(0.3, -0.8), 1e-5);
        let image = |p: DVec2| planar_image(&homography, p).0;
        let (at, w, jacobian) = planar_image(&homography, p);
        assert_eq!((homography * p.extend(1.0)).truncate(), at * w);
        for (k, axis) in [DVec2::X, DVec2::Y].into_iter().enumerate() {
            let difference = (image(p + axis * h) - image(p - axis * h)) / (2.0 * h);
            assert!((jacobian.col(k) - difference).length() < 1e-9, "{jacobian} {difference}");
        }
    }

    #[test]
    fn the_derivative_is_the_central_difference() {
        let (p, d, h) = (DVec3::new(0.3, -0.8, 1.7), DVec3::new(0.6, 0.0, -0.8), 1e-5);
        let difference = (ROWS.project(p + d * h) - ROWS.project(p - d * h)) / (2.0 * h);
        // Central difference: h² times the third derivative, plus rounding over h.
        assert!((ROWS.derivative(p, d) - difference).length() < 1e-9);
    }

    #[test]
    fn singular_values_multiply_to_the_determinant() {
        let m = DMat2::from_cols(DVec2::new(3.0, 1.0), DVec2::new(-0.5, 2.0));
        let (s, t) = singular_values(&m);
        assert!((s * t - m.determinant().abs()).abs() < 1e-14);
        let squares = m.x_axis.length_squared() + m.y_axis.length_squared();
        assert!((s * s + t * t - squares).abs() < 1e-13 && s >= t);
    }
}
