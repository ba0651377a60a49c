//! The perspective camera: right-handed, looking along -z of its view space, NDC z in [0, 1].

use glam::{DMat4, DVec3};

use crate::error::{Error, Result};

/// A perspective camera. Right, up and forward are orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    fov_y: f64,
    aspect: f64,
    near: f64,
    far: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target`; `fov_y` is the full vertical field of view in radians.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for anything not finite, `eye == target`, `up` parallel to the view, a field of view
    /// outside (0, pi), an aspect or near distance not above 0, or far not beyond near.
    #[allow(clippy::too_many_arguments)]
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_y: f64, aspect: f64, near: f64, far: f64) -> Result<Self> {
        for (name, v) in [("eye", eye), ("target", target), ("up", up)] {
            if !v.is_finite() {
                return Err(Error::argument(name, "three finite numbers", v, "check where it comes from"));
            }
        }
        let forward = unit(target - eye).ok_or_else(|| {
            Error::argument("target", "a point away from the eye", target, "move the eye or the target")
        })?;
        Self::look_along(eye, forward, up, fov_y, aspect, near, far)
    }
    /// A camera at `eye` that looks along `forward`, a vector of any length above 0.
    ///
    /// # Errors
    /// As [`Camera::look_at`].
    #[allow(clippy::too_many_arguments)]
    pub fn look_along(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        fov_y: f64,
        aspect: f64,
        near: f64,
        far: f64,
    ) -> Result<Self> {
        let fix = "give the way the camera looks";
        let forward = unit(forward).ok_or_else(|| Error::argument("forward", "a non-zero vector", forward, fix))?;
        let up_unit = unit(up).ok_or_else(|| Error::argument("up", "a non-zero vector", up, "give an up vector"))?;
        // Derived from f64: below 1e-9 the cross product has lost half of its digits.
        let right =
            unit(forward.cross(up_unit)).filter(|_| forward.cross(up_unit).length() > 1e-9).ok_or_else(|| {
                Error::argument("up", "a vector not parallel to the view direction", up, "give another up vector")
            })?;
        Self::from_axes(eye, [right, right.cross(forward), forward], fov_y, aspect, near, far)
    }
    /// A camera at `eye` with these axes, kept as they are: right, up and forward, orthonormal.
    ///
    /// # Errors
    /// As [`Camera::look_at`], and for axes that are not orthonormal and right-handed up to rounding.
    pub fn from_axes(eye: DVec3, axes: [DVec3; 3], fov_y: f64, aspect: f64, near: f64, far: f64) -> Result<Self> {
        let [right, up, forward] = axes;
        if !eye.is_finite() {
            return Err(Error::argument("eye", "three finite numbers", eye, "check where it comes from"));
        }
        // Derived from f64: the roundings of a cross product whose length is 1e-9, the least that `look_along` takes, are
        // some 1e-7 of it. A NaN is no such number.
        let rounding = 1e-6;
        let products = [right.dot(up), up.dot(forward), forward.dot(right)];
        let orthonormal = axes.iter().all(|a| (a.length_squared() - 1.0).abs() <= rounding)
            && products.iter().all(|p| p.abs() <= rounding)
            && right.cross(up).dot(forward) < 0.0;
        if !orthonormal {
            let got = format!("right {right}, up {up}, forward {forward}");
            return Err(Error::argument("axes", "orthonormal axes, right-handed", got, "use look_at"));
        }
        if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
            let fix = "give radians (np.radians turns degrees into them)";
            return Err(Error::argument("fov_y", "an angle in (0, pi) radians", fov_y, fix));
        }
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Error::argument("aspect", "a finite number above 0", aspect, "give width / height"));
        }
        Self { eye, right, up, forward, fov_y, aspect, near, far }.with_depths(near, far)
    }
    /// The same camera with other near and far planes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a near distance not above 0, far not beyond near, or anything not finite.
    pub fn with_depths(self, near: f64, far: f64) -> Result<Self> {
        if !(near > 0.0 && near.is_finite()) {
            return Err(Error::argument("near", "a finite distance above 0", near, "move the near plane"));
        }
        if !(far > near && far.is_finite()) {
            let expected = format!("a finite distance beyond near = {near}");
            return Err(Error::argument("far", expected, far, "move the far plane"));
        }
        Ok(Self { near, far, ..self })
    }
    /// The position.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }
    /// Unit vector to the right of the image.
    pub fn right(&self) -> DVec3 {
        self.right
    }
    /// Unit vector to the top of the image.
    pub fn up(&self) -> DVec3 {
        self.up
    }
    /// Unit view direction.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }
    /// Full vertical field of view, radians.
    pub fn fov_y(&self) -> f64 {
        self.fov_y
    }
    /// Width by height.
    pub fn aspect(&self) -> f64 {
        self.aspect
    }
    /// Near depth, along the view direction.
    pub fn near(&self) -> f64 {
        self.near
    }
    /// Far depth, along the view direction.
    pub fn far(&self) -> f64 {
        self.far
    }
    /// Tangents of half the horizontal and half the vertical field of view.
    pub fn tan_half_fov(&self) -> (f64, f64) {
        let y = (0.5 * self.fov_y).tan();
        (y * self.aspect, y)
    }
    /// Depth of a world point along the view direction.
    pub fn depth_of(&self, p_world: DVec3) -> f64 {
        (p_world - self.eye).dot(self.forward)
    }
    /// `view_from_world`.
    pub fn view(&self) -> DMat4 {
        glam::dcamera::rh::view::look_to_mat4(self.eye, self.forward, self.up)
    }
    /// `clip_from_view`, z from 0 at near to 1 at far.
    pub fn projection(&self) -> DMat4 {
        glam::dcamera::rh::proj::directx::perspective(self.fov_y, self.aspect, self.near, self.far)
    }
    /// `clip_from_world`.
    pub fn clip_from_world(&self) -> DMat4 {
        self.projection() * self.view()
    }
    /// The same with z from 1 at near to 0 at far (`[lapidous1999]`): of a depth in floating point no digit is lost however
    /// near the near plane is.
    pub fn reversed_clip_from_world(&self) -> DMat4 {
        // Not 1 minus the other, of which hardly a digit is left where near / far is small.
        let at_far = self.near / (self.far - self.near);
        let mut projection = self.projection();
        (projection.z_axis.z, projection.w_axis.z) = (at_far, at_far * self.far);
        projection * self.view()
    }
    /// Where the centre of pixel (x, y) of a width x height image meets the plane at depth 1: `p - eye`, not normalised, so
    /// that `eye + z * ray` has camera depth `z`.
    pub fn pixel_ray(&self, x: f64, y: f64, size: [u32; 2]) -> DVec3 {
        self.pixel_rays(size)(x, y)
    }
    /// [`Camera::pixel_ray`] for many pixels of one image: the tangents are found once.
    pub(crate) fn pixel_rays(&self, size: [u32; 2]) -> impl Fn(f64, f64) -> DVec3 {
        let (tx, ty) = self.tan_half_fov();
        let (forward, right, up) = (self.forward, self.right, self.up);
        move |x, y| {
            let ndc_x = 2.0 * x / f64::from(size[0]) - 1.0;
            let ndc_y = 1.0 - 2.0 * y / f64::from(size[1]);
            forward + right * (ndc_x * tx) + up * (ndc_y * ty)
        }
    }
}

/// The unit vector along `v`, at any scale; nothing for zero.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let size = v.abs().max_element();
    (size > 0.0 && size.is_finite()).then(|| (v / size).normalize())
}
