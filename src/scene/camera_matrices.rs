//! The camera behind a view and a projection matrix.
//!
//! ```text
//! perspective        with s = +-1, the way its view space looks along z:
//!   | x 0 p 0 |      w = s z is the depth along the view d
//!   | 0 y q 0 |      NDC x = x X / d + s p,  y = y Y / d + s q: tan(fov / 2) = 1 / |y|, aspect = |y / x|, shift = -s (p, q)
//!   | 0 0 a b |      NDC z = s a + b / d: what it is at near and at far gives both; at infinity it is s a
//!   | 0 0 s 0 |
//!
//! orthographic
//!   | x 0 0 p |      NDC x = x X + p,  y = y Y + q: height = 2 / |y|, aspect = |y / x|, shift = -(p, q)
//!   | 0 y 0 q |
//!   | 0 0 a b |      NDC z = a Z + b: what it is at near and at far gives both, and which way the view looks along z
//!   | 0 0 0 1 |
//! ```
//! The signs of x, y and s name the axes of the view space that point right, up and forward, so both kinds of view space
//! are read, and y that points down.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

use super::camera::Camera;
use super::view_volume::{Lens, ViewVolume};
use crate::error::{Error, Result};

/// What entries may be off by, relative to the largest of their row: matrices of single precision, and a few products.
const ROUNDING: f64 = 32.0 * f32::EPSILON as f64;

/// A shift below this is the rounding of what undid a tile of an atlas, in f64: the picture is in the middle.
const NO_SHIFT: f64 = 64.0 * f64::EPSILON;

impl Camera {
    /// The camera of `view_from_world` and `clip_from_view`, both for column vectors; x to the right and y up in [-1, 1].
    ///
    /// `depths` is NDC z at the near and at the far plane. `far` is taken for a projection without a far plane, which is at
    /// infinity otherwise, and for no other.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite, a view that is not a rotation and a translation, a sheared,
    /// oblique or singular projection, and matrices that mirror the picture.
    pub fn from_matrices(view: &DMat4, projection: &DMat4, depths: [f64; 2], far: Option<f64>) -> Result<Self> {
        for (name, matrix) in [("view", view), ("projection", projection)] {
            if !matrix.is_finite() {
                let got = "a NaN or an infinity";
                return Err(Error::argument(name, "16 finite numbers", got, "check where it comes from"));
            }
        }
        let read = Read::of(projection, depths, far)?;
        let (eye, axes) = placement(view)?;
        // Rows of the rotation: right, up and forward of the picture in the world.
        let (forward, up) = (read.forward * axes.z_axis, read.up * axes.y_axis);
        let right = forward.cross(up);
        if right.dot(read.right * axes.x_axis) < 0.0 {
            let (expected, got) = ("a picture of a right-handed world", "one that is mirrored");
            let fix = "name the convention: its handedness or axes, or the directions of x and y; an orthographic picture is \
                       mirrored where depths run the other way (reversed_z), too";
            return Err(Error::argument("projection", expected, got, fix));
        }
        Self::look_along(eye, forward, up, read.volume)
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
struct Read {
    volume: ViewVolume,
    right: f64,
    up: f64,
    forward: f64,
}

/// A projection that is none of a camera.
fn refused<T>(expected: &'static str, got: String, fix: &'static str) -> Result<T> {
    Err(Error::argument("projection", expected, got, fix))
}

const COLUMNS: &str = "give clip_from_view for column vectors, or name the convention";

impl Read {
    fn of(projection: &DMat4, depths: [f64; 2], far: Option<f64>) -> Result<Self> {
        let rows = [0, 1, 2, 3].map(|i| projection.row(i));
        let w = rows[3];
        let (is_perspective, is_orthographic) = (w.z != 0.0 && w.w == 0.0, w.z == 0.0 && w.w != 0.0);
        if w.x != 0.0 || w.y != 0.0 || !(is_perspective || is_orthographic) {
            let expected =
                "a projection whose last row is 0, 0, -1, 0 or 0, 0, 1, 0 (perspective), or 0, 0, 0, 1 (orthographic)";
            return refused(expected, format!("{w}"), COLUMNS);
        }
        // A multiple is the same projection; the sign of a perspective's says which way it looks.
        let size = if is_perspective { w.z.abs() } else { w.w };
        let [x, y, z, w] = rows.map(|row| row / size);
        if x.x == 0.0 || y.y == 0.0 || (is_orthographic && z.z == 0.0) || (is_perspective && z.w == 0.0) {
            let got = format!("rows {x}, {y} and {z}");
            return refused("a projection of full rank", got, COLUMNS);
        }
        if z.x != 0.0 || z.y != 0.0 {
            let fix = "give the projection before its near plane was tilted";
            return refused("a depth that does not depend on x and y", format!("{z}: an oblique near plane"), fix);
        }
        // The column that moves the picture, and the one that has no part in it.
        let (moves, other) = if is_perspective { (2, 3) } else { (3, 2) };
        for (name, row, own, beside) in [("x", x, 0, 1), ("y", y, 1, 0)] {
            // In halves of the picture.
            let least = ROUNDING * row[own].abs().min(1.0);
            if row[beside].abs() > least {
                return refused(
                    "a picture whose sides are at right angles",
                    format!("row {name} {row}: sheared"),
                    COLUMNS,
                );
            }
            if row[other].abs() > least {
                let got = if is_perspective { "an eye beside the view's origin" } else { "rays aslant to the view" };
                let fix = if is_perspective { "move the eye in the view" } else { "look along the rays in the view" };
                return refused("rays as the view has them", format!("row {name} {row}: {got}"), fix);
            }
        }
        let (right, up) = (x.x.signum(), y.y.signum());
        let (scale, moved) = (DVec2::new(x.x.abs(), y.y.abs()), DVec2::new(x[moves], y[moves]));
        let aspect = scale.y / scale.x;
        // Of a perspective they are multiplied with z, whose sign is the view's.
        let towards = if is_perspective { -w.z } else { -1.0 };
        let shift = moved * towards;
        let shift = DVec2::from_array(shift.to_array().map(|s| if s.abs() <= NO_SHIFT { 0.0 } else { s }));
        let (lens, forward, near, far) = if is_perspective {
            let (near, far) = of_perspective(z.z * w.z, z.w, depths, far)?;
            (Lens::Perspective { fov_y: 2.0 * (1.0 / scale.y).atan() }, w.z, near, far)
        } else {
            let (forward, near, far) = of_box(z.z, z.w, depths, far)?;
            (Lens::Orthographic { height: 2.0 / scale.y }, forward, near, far)
        };
        Ok(Self { volume: ViewVolume { lens, aspect, shift, near, far }, right, up, forward })
    }
}

/// Near and far plane of NDC z = slope + offset / depth.
fn of_perspective(slope: f64, offset: f64, [z_near, z_far]: [f64; 2], far: Option<f64>) -> Result<(f64, f64)> {
    let depth_at = |ndc: f64| offset / (ndc - slope);
    let near = depth_at(z_near);
    // The slope of a projection without an end is the depth at the end itself, or, in single precision and pushed a little
    // further so that nothing at infinity is clipped, just off it.
    let off = (z_far - slope).abs();
    let endless = off <= f64::EPSILON * z_far.abs().max(slope.abs())
        || (off <= ROUNDING * (z_far - z_near).abs() && depth_at(z_far) < 0.0 && near > 0.0);
    let far = match (endless, far) {
        (true, far) => far.unwrap_or(f64::INFINITY),
        (false, None) => depth_at(z_far),
        (false, Some(_)) => return no_far(depth_at(z_far)),
    };
    if !(near > 0.0 && far > near) {
        let got = format!("near {near} and far {far}");
        let fix = "name the convention: its depth range, and whether depths are reversed";
        return refused("near and far planes before the eye, near first", got, fix);
    }
    Ok((near, far))
}

/// The way the view looks along z, near and far plane of NDC z = slope Z + offset.
fn of_box(slope: f64, offset: f64, [z_near, z_far]: [f64; 2], far: Option<f64>) -> Result<(f64, f64, f64)> {
    let forward = ((z_far - z_near) / slope).signum();
    let [near, end] = [z_near, z_far].map(|ndc| forward * ((ndc - offset) / slope));
    if far.is_some() {
        return no_far(end);
    }
    Ok((forward, near, end))
}

/// A far plane is given beside the projection's own.
fn no_far<T>(end: f64) -> Result<T> {
    let got = format!("a projection that ends at {end}");
    let fix = "leave far out; camera.replace(far=...) moves the plane";
    Err(Error::argument("far", "nothing where the projection has a far plane", got, fix))
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
        let cancelled = (b.far() / b.near()).abs();
        // Of parallel rays both planes are, by what lies between them.
        let of_box = if b.is_orthographic() { 1.0 + (b.far() - b.near()) / b.near().abs() } else { 1.0 };
        for (a, b, more) in [
            (a.fov_y(), b.fov_y(), 1.0),
            (a.aspect(), b.aspect(), 1.0),
            (a.near(), b.near(), of_box),
            (a.far(), b.far(), cancelled.max(of_box)),
        ] {
            assert!((a - b).abs() <= tolerance * more * b.abs(), "{a} {b}");
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
    fn boxes_and_shifted_pictures_come_back() {
        let pose = camera(40.0);
        let volumes = [
            pose.volume().shifted(DVec2::new(0.7, -1.5)),
            ViewVolume::orthographic(3.0, 1.6, -4.0, 25.0),
            ViewVolume::orthographic(3.0, 0.4, 2.0, 25.0).shifted(DVec2::new(-2.0, 1e-9)),
        ];
        for volume in volumes {
            let c = pose.with_volume(volume).unwrap();
            for depths in [[0.0, 1.0], [-1.0, 1.0], [1.0, 0.0]] {
                for flip in [DVec3::ONE, DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, -1.0)] {
                    let flip = DMat4::from_scale(flip);
                    let projection = written(&c, depths) * flip * -2.0;
                    let projection = if c.is_orthographic() { projection } else { -projection };
                    let back = Camera::from_matrices(&(flip * c.view()), &projection, depths, None).unwrap();
                    close(&back, &c, SAME);
                    assert_eq!(back.is_orthographic(), c.is_orthographic());
                    let (found, expected) = (back.volume(), c.volume());
                    assert!((found.shift - expected.shift).length() < SAME, "{found:?} {expected:?}");
                    assert!((found.height() / expected.height() - 1.0).abs() < SAME, "{found:?} {expected:?}");
                }
            }
            if c.is_orthographic() {
                // The other order of depths looks the other way, which mirrors the picture.
                let error = Camera::from_matrices(&c.view(), &c.projection(), [1.0, 0.0], None).unwrap_err();
                assert!(error.to_string().contains("reversed_z"), "{error}");
            }
        }
    }

    #[test]
    fn a_projection_without_an_end_has_its_far_plane_at_infinity_or_where_it_is_given() {
        let c = camera(40.0);
        for (depths, slope, offset) in [([0.0, 1.0], -1.0, -0.25), ([-1.0, 1.0], -1.0, -0.5), ([1.0, 0.0], 0.0, 0.25)] {
            let mut endless = c.projection();
            (endless.z_axis.z, endless.w_axis.z) = (slope, offset);
            close(&Camera::from_matrices(&c.view(), &endless, depths, Some(40.0)).unwrap(), &c, SAME);
            assert!(Camera::from_matrices(&c.view(), &endless, depths, Some(0.1)).is_err());
            for far in [None, Some(f64::INFINITY)] {
                let back = Camera::from_matrices(&c.view(), &endless, depths, far).unwrap();
                assert_eq!(back.far(), f64::INFINITY);
                assert!((back.near() - c.near()).abs() < SAME && back.projection().is_finite(), "{back:?}");
            }
            // Pushed a little beyond infinity, as for stencil shadows.
            let towards = if depths[1] == 0.0 { -1.0 } else { 1.0 };
            endless.z_axis.z += towards * 2.4e-7;
            let back = Camera::from_matrices(&c.view(), &endless, depths, None).unwrap();
            assert_eq!(back.far(), f64::INFINITY);
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
        let cabinet = changed(orthographic, 2, 0, 0.35);
        for (view, projection, depths, word) in [
            (view, cabinet, [0.0, 1.0], "aslant"),
            (view, changed(orthographic, 1, 0, 0.1), [0.0, 1.0], "sheared"),
            (view, changed(orthographic, 2, 2, 0.0), [0.0, 1.0], "full rank"),
            (view, changed(orthographic, 2, 3, 0.1), [0.0, 1.0], "last row"),
            (view, changed(projection, 1, 0, 0.1), [0.0, 1.0], "sheared"),
            (view, changed(projection, 3, 1, 0.1), [0.0, 1.0], "beside the view's origin"),
            (view, changed(projection, 0, 2, 0.1), [0.0, 1.0], "oblique"),
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
