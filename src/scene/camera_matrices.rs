//! The camera behind a view and a projection matrix.
//!
//! ```text
//! projection of a perspective camera      with s = +-1, the way its view space looks along z:
//!   | x 0 0 0 |      w = s z is the depth along the view d
//!   | 0 y 0 0 |      NDC x = x X / d,  y = y Y / d: tan(fov / 2) = 1 / |y|, aspect = |y / x|
//!   | 0 0 a b |      NDC z = s a + b / d: what it is at near and at far gives both
//!   | 0 0 s 0 |
//! ```
//! The signs of x, y and s name the axes of the view space that point right, up and forward, so both kinds of view space
//! are read, and y that points down.

use glam::{DMat3, DMat4, DVec3, DVec4, Vec4Swizzles};

use super::Camera;
use crate::error::{Error, Result};

/// What entries may be off by, relative to the largest of their row: matrices of single precision, and a few products.
const ROUNDING: f64 = 32.0 * f32::EPSILON as f64;

impl Camera {
    /// The camera of `view_from_world` and `clip_from_view`, both for column vectors; x to the right and y up in [-1, 1].
    ///
    /// `depths` is NDC z at the near and at the far plane. `far` is taken for a projection without a far plane, and for no
    /// other.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite, a view that is not a rotation and a translation, an
    /// orthographic, off-centre, sheared or singular projection, one without a far plane where `far` is none, and matrices
    /// that mirror the picture.
    pub fn from_matrices(view: &DMat4, projection: &DMat4, depths: [f64; 2], far: Option<f64>) -> Result<Self> {
        for (name, matrix) in [("view", view), ("projection", projection)] {
            if !matrix.is_finite() {
                let got = "a NaN or an infinity";
                return Err(Error::argument(name, "16 finite numbers", got, "check where it comes from"));
            }
        }
        let lens = Lens::of(projection, depths, far)?;
        let (eye, axes) = placement(view)?;
        // Rows of the rotation: right, up and forward of the picture in the world.
        let (forward, up) = (lens.forward * axes.z_axis, lens.up * axes.y_axis);
        let right = forward.cross(up);
        if right.dot(lens.right * axes.x_axis) < 0.0 {
            let (expected, got) = ("a picture of a right-handed world", "one that is mirrored");
            let fix = "name the convention: its handedness or axes, or the directions of x and y";
            return Err(Error::argument("projection", expected, got, fix));
        }
        Self::look_along(eye, forward, up, 2.0 * (1.0 / lens.y).atan(), lens.y / lens.x, lens.near, lens.far)
    }
}

/// Eye and rows of the rotation of a `view_from_world`.
fn placement(view: &DMat4) -> Result<(DVec3, DMat3)> {
    let refused = |got: String| {
        let fix = "give view_from_world for column vectors, or name the convention";
        Err(Error::argument("view", "a rotation and a translation", got, fix))
    };
    if view.row(3) != DVec4::W {
        return refused(format!("a last row of {}", view.row(3)));
    }
    let rotation = DMat3::from_mat4(*view);
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let largest = off.to_cols_array().into_iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest > ROUNDING {
        return refused(format!("axes whose products are off by {largest:.3e}: scaled or sheared"));
    }
    // The point that the matrix as it is takes to the origin.
    Ok((rotation.inverse() * -view.w_axis.xyz(), rotation.transpose()))
}

/// What a projection says of a camera, and which way the axes of its view space point.
struct Lens {
    x: f64,
    y: f64,
    right: f64,
    up: f64,
    forward: f64,
    near: f64,
    far: f64,
}

impl Lens {
    fn of(projection: &DMat4, [z_near, z_far]: [f64; 2], far: Option<f64>) -> Result<Self> {
        let refused = |expected: &'static str, got: String, fix: &'static str| {
            Err(Error::argument("projection", expected, got, fix))
        };
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| projection.row(i));
        let perspective = "a perspective projection, whose last row is 0, 0, -1, 0 or 0, 0, 1, 0";
        let fix = "give clip_from_view for column vectors, or name the convention";
        if w.xyz() == DVec3::ZERO && w.w != 0.0 {
            return refused(perspective, format!("an orthographic one, with {w}"), "a Camera is a perspective one");
        }
        if w.x != 0.0 || w.y != 0.0 || w.w != 0.0 || w.z == 0.0 {
            return refused(perspective, format!("{w}"), fix);
        }
        let size = w.z.abs();
        let [x, y, z, w] = [x, y, z, w].map(|row| row / size);
        if x.x == 0.0 || y.y == 0.0 {
            return refused("a projection of full rank", format!("{} and {} for x and y", x.x, y.y), fix);
        }
        let centred = |row: DVec4, i: usize| {
            let rest = row.to_array().into_iter().enumerate().filter(|(j, _)| *j != i);
            // NDC per unit of a tangent: what is beside the own axis moves the picture by that many halves of it.
            rest.into_iter().all(|(_, value)| value.abs() <= ROUNDING * row[i].abs().min(1.0))
        };
        if !(centred(x, 0) && centred(y, 1)) {
            let got = format!("rows {x} and {y}: off-centre or sheared");
            return refused("the eye before the middle of the picture", got, "render the whole picture, then crop it");
        }
        if z.x != 0.0 || z.y != 0.0 {
            return refused("a depth that does not depend on x and y", format!("{z}"), fix);
        }
        let (slope, offset) = (z.z * w.z, z.w);
        let depth_at = |ndc: f64| offset / (ndc - slope);
        let near = depth_at(z_near);
        // The slope of a projection without an end is the depth at the end itself.
        let endless = (z_far - slope).abs() <= f64::EPSILON * z_far.abs().max(slope.abs());
        let far = match (endless, far) {
            (true, Some(far)) => far,
            (true, None) => {
                return refused("one with a far plane", "an infinite one".into(), "give far=..., in world units");
            }
            (false, Some(_)) => {
                let got = format!("a projection that ends at {}", depth_at(z_far));
                let fix = "leave far out; camera.replace(far=...) moves the plane";
                return Err(Error::argument("far", "nothing where the projection has a far plane", got, fix));
            }
            (false, None) => depth_at(z_far),
        };
        if !(near > 0.0 && far > near) {
            let got = format!("near {near} and far {far}");
            let fix = "name the convention: its depth range, and whether depths are reversed";
            return refused("near and far planes before the eye, near first", got, fix);
        }
        let (right, up) = (x.x.signum(), y.y.signum());
        Ok(Self { x: x.x.abs(), y: y.y.abs(), right, up, forward: w.z, near, far })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative to the largest number: some roundings of f64 in matrices, their inverses and tangents.
    const SAME: f64 = 64.0 * f64::EPSILON;

    fn camera(far: f64) -> Camera {
        let (eye, target, up) =
            (DVec3::new(5e5, -3.0, 20.0), DVec3::new(5e5 + 4.0, 1.0, -9.0), DVec3::new(0.1, 1.0, 0.0));
        Camera::look_at(eye, target, up, 0.7, 1.6, 0.25, far).unwrap()
    }

    fn close(a: &Camera, b: &Camera, tolerance: f64) {
        assert!((a.eye() - b.eye()).length() <= tolerance * b.eye().length(), "{a:?} {b:?}");
        for (a, b) in [(a.forward(), b.forward()), (a.up(), b.up()), (a.right(), b.right())] {
            assert!((a - b).length() <= tolerance, "{a} {b}");
        }
        // The far plane is where the depth row cancels.
        let cancelled = b.far() / b.near();
        for (a, b, more) in [
            (a.fov_y(), b.fov_y(), 1.0),
            (a.aspect(), b.aspect(), 1.0),
            (a.near(), b.near(), 1.0),
            (a.far(), b.far(), cancelled),
        ] {
            assert!((a - b).abs() <= tolerance * more * b, "{a} {b}");
        }
    }

    /// The projection with NDC z written as `z_near` and `z_far` at the ends.
    fn written(c: &Camera, [z_near, z_far]: [f64; 2]) -> DMat4 {
        let map = DMat4::from_cols(
            DVec4::X,
            DVec4::Y,
            DVec4::new(0.0, 0.0, z_far - z_near, 0.0),
            DVec4::new(0.0, 0.0, z_near, 1.0),
        );
        map * c.projection()
    }

    #[test]
    fn a_camera_comes_back_from_its_matrices() {
        for far in [1.0, 40.0, 1e6] {
            let c = camera(far);
            for depths in [[0.0, 1.0], [-1.0, 1.0], [1.0, 0.0], [1.0, -1.0]] {
                let back = Camera::from_matrices(&c.view(), &written(&c, depths), depths, None).unwrap();
                close(&back, &c, SAME);
                // A positive multiple is the same projection.
                let scaled = written(&c, depths) * 3.0;
                close(&Camera::from_matrices(&c.view(), &scaled, depths, None).unwrap(), &c, SAME);
            }
        }
    }

    #[test]
    fn view_spaces_that_look_along_z_and_down_are_read() {
        let c = camera(40.0);
        for flip in [DVec3::new(1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, -1.0, -1.0)] {
            let flip = DMat4::from_scale(flip);
            let back = Camera::from_matrices(&(flip * c.view()), &(c.projection() * flip), [0.0, 1.0], None).unwrap();
            close(&back, &c, SAME);
        }
    }

    #[test]
    fn matrices_of_single_precision_will_do() {
        let c = Camera::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 1.0, 1.5, 0.5, 50.0).unwrap();
        let back = Camera::from_matrices(
            &c.view().as_mat4().as_dmat4(),
            &c.projection().as_mat4().as_dmat4(),
            [0.0, 1.0],
            None,
        );
        close(&back.unwrap(), &c, 4.0 * f64::from(f32::EPSILON));
    }

    #[test]
    fn an_infinite_projection_needs_a_far_plane() {
        let c = camera(40.0);
        for (depths, slope, offset) in [([0.0, 1.0], -1.0, -0.25), ([-1.0, 1.0], -1.0, -0.5), ([1.0, 0.0], 0.0, 0.25)] {
            let mut endless = c.projection();
            (endless.z_axis.z, endless.w_axis.z) = (slope, offset);
            let error = Camera::from_matrices(&c.view(), &endless, depths, None).unwrap_err().to_string();
            assert!(error.contains("infinite") && error.contains("far="), "{error}");
            close(&Camera::from_matrices(&c.view(), &endless, depths, Some(40.0)).unwrap(), &c, SAME);
            assert!(Camera::from_matrices(&c.view(), &endless, depths, Some(0.1)).is_err());
            assert!(Camera::from_matrices(&c.view(), &endless, depths, Some(f64::INFINITY)).is_err());
        }
        let error = Camera::from_matrices(&c.view(), &c.projection(), [0.0, 1.0], Some(9.0)).unwrap_err();
        assert!(error.to_string().contains("replace"), "{error}");
    }

    #[test]
    fn what_is_no_camera_is_refused_by_name() {
        let c = camera(40.0);
        let (view, projection) = (c.view(), c.projection());
        let changed = |matrix: DMat4, column: usize, row: usize, value: f64| {
            let mut m = matrix;
            m.col_mut(column)[row] = value;
            m
        };
        let orthographic = glam::dcamera::rh::proj::directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 9.0);
        for (view, projection, depths, word) in [
            (view, orthographic, [0.0, 1.0], "orthographic"),
            (view, changed(projection, 2, 0, 0.1), [0.0, 1.0], "off-centre"),
            (view, changed(projection, 1, 0, 0.1), [0.0, 1.0], "sheared"),
            (view, changed(projection, 3, 1, 0.1), [0.0, 1.0], "off-centre"),
            (view, changed(projection, 0, 2, 0.1), [0.0, 1.0], "depend on x and y"),
            (view, changed(projection, 0, 0, 0.0), [0.0, 1.0], "full rank"),
            (view, changed(projection, 0, 0, f64::NAN), [0.0, 1.0], "NaN"),
            (view, DMat4::ZERO, [0.0, 1.0], "perspective"),
            (view, projection, [1.0, 0.0], "reversed"),
            (view, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * projection, [0.0, 1.0], "mirrored"),
            (DMat4::from_scale(DVec3::splat(2.0)) * view, projection, [0.0, 1.0], "scaled"),
            (changed(view, 1, 0, 0.5), projection, [0.0, 1.0], "sheared"),
            (DMat4::ZERO, projection, [0.0, 1.0], "last row"),
            (view.transpose(), projection, [0.0, 1.0], "last row"),
            (changed(view, 3, 0, f64::INFINITY), projection, [0.0, 1.0], "infinity"),
        ] {
            let error = Camera::from_matrices(&view, &projection, depths, None).unwrap_err().to_string();
            assert!(error.contains(word), "{word}: {error}");
        }
    }
}
