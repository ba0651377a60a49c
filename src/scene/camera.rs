//! The camera: right-handed, looking along -z of its view space, NDC z in [0, 1].

use glam::{DMat4, DVec2, DVec3};

use super::view_volume::{Lens, ViewVolume};
use crate::error::{Error, Result};
use crate::geometry::{Aabb, Frustum, Sides};

/// A finite far plane in place of an infinite one lies this share behind the scene's last corner: far above rounding, and
/// hardly a row of a map.
const BEHIND_SCENE: f64 = 1.0 / 1024.0;

/// A camera: where it stands, how it is turned, and the volume that it sees. Right, up and forward are orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    volume: ViewVolume,
}

/// The ray of a place in the picture: `eye + from_eye + z * direction` has camera depth `z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRay {
    /// Where it meets depth 0, from the eye: zero for a perspective camera.
    pub from_eye: DVec3,
    /// Its direction, of depth 1: not normalised.
    pub direction: DVec3,
}

impl PixelRay {
    /// The point at a depth, from the eye.
    #[inline(always)]
    pub fn at(&self, depth: f64) -> DVec3 {
        self.from_eye + depth * self.direction
    }
}

impl Camera {
    /// A perspective camera at `eye` that looks at `target`; `fov_y` is the full vertical field of view in radians.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for anything not finite but `far`, `eye == target`, `up` parallel to the view, a field of
    /// view outside (0, pi), an aspect or near distance not above 0, or far not beyond near.
    #[allow(clippy::too_many_arguments)]
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_y: f64, aspect: f64, near: f64, far: f64) -> Result<Self> {
        Self::aimed(eye, target, up, ViewVolume::perspective(fov_y, aspect, near, far))
    }
    /// A camera at `eye` that looks at `target`.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for anything not finite, `eye == target`, `up` parallel to the view, and as
    /// [`ViewVolume::checked`].
    pub fn aimed(eye: DVec3, target: DVec3, up: DVec3, volume: ViewVolume) -> Result<Self> {
        Self::look_along(eye, Self::way(eye, target)?, checked_up(up)?, volume)
    }
    /// The unit vector from an eye to a target.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for anything not finite, and `eye == target`.
    pub fn way(eye: DVec3, target: DVec3) -> Result<DVec3> {
        for (name, v) in [("eye", eye), ("target", target)] {
            if !v.is_finite() {
                return Err(Error::argument(name, "three finite numbers", v, "check where it comes from"));
            }
        }
        unit(target - eye)
            .ok_or_else(|| Error::argument("target", "a point away from the eye", target, "move the eye or the target"))
    }
    /// A camera at `eye` that looks along `forward`, a vector of any length above 0.
    ///
    /// # Errors
    /// As [`Camera::aimed`].
    pub fn look_along(eye: DVec3, forward: DVec3, up: DVec3, volume: ViewVolume) -> Result<Self> {
        let fix = "give the way the camera looks";
        let forward = unit(forward).ok_or_else(|| Error::argument("forward", "a non-zero vector", forward, fix))?;
        let right = right_of(forward, up)?.ok_or_else(|| {
            let fix = "give another up vector, or leave it out: one is chosen then";
            Error::argument("up", "a vector not parallel to the view direction", up, fix)
        })?;
        Self::from_axes(eye, [right, right.cross(forward), forward], volume)
    }
    /// Up where none is given: +y. Along the y axis, where +y is no up, what it becomes as a camera tilts that way: -z for one
    /// that looks straight down, +z for one that looks straight up. With it, whether +y will not do.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for no direction.
    pub fn usual_up(forward: DVec3) -> Result<(DVec3, bool)> {
        Self::tilted_up(forward, DVec3::Y, DVec3::NEG_Z)
    }
    /// Up of a camera with these axes once it is turned along `forward`: its own; along its own up, what that becomes as it
    /// tilts that way. With it, whether its own will not do.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for no direction.
    pub fn tilted_up(forward: DVec3, up: DVec3, before: DVec3) -> Result<(DVec3, bool)> {
        let fix = "give the way the camera looks";
        let along = unit(forward).ok_or_else(|| Error::argument("forward", "a non-zero vector", forward, fix))?;
        Ok(match right_of(along, up)? {
            Some(_) => (up, false),
            None => (if along.dot(up) < 0.0 { before } else { -before }, true),
        })
    }
    /// A camera at `eye` with these axes, kept as they are: right, up and forward, orthonormal.
    ///
    /// # Errors
    /// As [`Camera::aimed`], and for axes that are not orthonormal and right-handed up to rounding.
    pub fn from_axes(eye: DVec3, axes: [DVec3; 3], volume: ViewVolume) -> Result<Self> {
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
        Ok(Self { eye, right, up, forward, volume: volume.checked()? })
    }
    /// The same camera with another volume.
    ///
    /// # Errors
    /// As [`ViewVolume::checked`].
    pub fn with_volume(self, volume: ViewVolume) -> Result<Self> {
        Ok(Self { volume: volume.checked()?, ..self })
    }
    /// The same camera with other near and far planes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a near plane of a perspective that is not before the eye, far not beyond near, or
    /// anything not finite but the far plane of a perspective.
    pub fn with_depths(self, near: f64, far: f64) -> Result<Self> {
        self.with_volume(self.volume.with_depths(near, far))
    }
    /// The same camera with a finite far plane: its own, or one just behind all of a scene's box.
    pub fn bounded(&self, bounds: &Aabb) -> Self {
        if self.far().is_finite() {
            return *self;
        }
        let deepest = bounds.corners().iter().map(|p| self.depth_of(*p)).fold(2.0 * self.near(), f64::max);
        // Of a scene at the very end of f64 there is nothing behind.
        let far = (deepest * (1.0 + BEHIND_SCENE)).min(f64::MAX);
        Self { volume: self.volume.with_depths(self.near(), far), ..*self }
    }
    /// The position. Rays of an orthographic camera do not run through it: depths begin there, and it is where the view axis
    /// is.
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
    /// Right, up and forward.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.right, self.up, self.forward]
    }
    /// The volume that it sees.
    pub fn volume(&self) -> ViewVolume {
        self.volume
    }
    /// Whether all of its rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.volume.is_orthographic()
    }
    /// Full vertical field of view of the picture before it is shifted, radians; 0 for parallel rays.
    pub fn fov_y(&self) -> f64 {
        match self.volume.lens {
            Lens::Perspective { fov_y } => fov_y,
            Lens::Orthographic { .. } => 0.0,
        }
    }
    /// Width by height.
    pub fn aspect(&self) -> f64 {
        self.volume.aspect
    }
    /// Near depth, along the view direction.
    pub fn near(&self) -> f64 {
        self.volume.near
    }
    /// Far depth, along the view direction; infinity for a perspective without an end.
    pub fn far(&self) -> f64 {
        self.volume.far
    }
    /// What it sees, with its eye at `apex`.
    pub fn frustum_at(&self, apex: DVec3) -> Frustum {
        let ([right, up, forward], volume) = (self.axes(), self.volume);
        let sides = if self.is_orthographic() { Sides::Parallel } else { Sides::Converging };
        let (half, center) = (volume.half_size().to_array(), volume.center().to_array());
        Frustum { apex, right, up, forward, sides, half, center, near: volume.near, far: volume.far }
    }
    /// Half the picture's width and height, over [`Camera::w_at`]: tangents of half the fields of view of a perspective that is
    /// not shifted, world units of an orthographic camera.
    pub fn half_size(&self) -> DVec2 {
        self.volume.half_size()
    }
    /// Depth of a world point along the view direction.
    #[inline(always)]
    pub fn depth_of(&self, p_world: DVec3) -> f64 {
        (p_world - self.eye).dot(self.forward)
    }
    /// What places across the view are divided by at a depth: the depth itself for a perspective, 1 for parallel rays.
    #[inline(always)]
    pub fn w_at(&self, depth: f64) -> f64 {
        if self.is_orthographic() { 1.0 } else { depth }
    }
    /// The ray to a point, both from the eye, with depth [`Camera::w_at`]: the point itself, or the view direction.
    #[inline(always)]
    pub fn way_to(&self, p: DVec3) -> DVec3 {
        if self.is_orthographic() { self.forward } else { p }
    }
    /// How far away a depth is as the picture has it, in world units: the depth itself; for parallel rays, which know none, the
    /// height of the picture, as large as the depth where a perspective of 53 degrees has a picture that high.
    pub fn distance_at(&self, depth: f64) -> f64 {
        if self.is_orthographic() { self.volume.height() } else { depth }
    }
    /// `view_from_world`.
    pub fn view(&self) -> DMat4 {
        glam::dcamera::rh::view::look_to_mat4(self.eye, self.forward, self.up)
    }
    /// `clip_from_view`, z from 0 at near to 1 at far.
    pub fn projection(&self) -> DMat4 {
        self.volume.clip_from_view()
    }
    /// `clip_from_world`.
    pub fn clip_from_world(&self) -> DMat4 {
        self.projection() * self.view()
    }
    /// The same with z from 1 at near to 0 at far: [`ViewVolume::reversed_clip_from_view`].
    pub fn reversed_clip_from_world(&self) -> DMat4 {
        self.volume.reversed_clip_from_view() * self.view()
    }
    /// The ray of a place (x, y) in pixels of a width x height image, row 0 at the top.
    pub fn pixel_ray(&self, x: f64, y: f64, size: [u32; 2]) -> PixelRay {
        self.pixel_rays(size)(x, y)
    }
    /// [`Camera::pixel_ray`] for many places of one image: the picture's sides are found once.
    pub(crate) fn pixel_rays(&self, size: [u32; 2]) -> impl Fn(f64, f64) -> PixelRay {
        let (half, center) = (self.half_size(), self.volume.center());
        let ([right, up, forward], parallel) = (self.axes(), self.is_orthographic());
        move |x, y| {
            let ndc_x = 2.0 * x / f64::from(size[0]) - 1.0;
            let ndc_y = 1.0 - 2.0 * y / f64::from(size[1]);
            let (across, above) = (ndc_x * half.x + center.x, ndc_y * half.y + center.y);
            if parallel {
                PixelRay { from_eye: right * across + up * above, direction: forward }
            } else {
                PixelRay { from_eye: DVec3::ZERO, direction: forward + right * across + up * above }
            }
        }
    }
    /// The corners of the picture at a depth, from the eye: left and right at the bottom, left and right at the top.
    pub fn corners_at(&self, depth: f64) -> [DVec3; 4] {
        let ray = self.pixel_rays([1, 1]);
        [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]].map(|[x, y]| ray(x, y).at(depth))
    }
}

fn checked_up(up: DVec3) -> Result<DVec3> {
    if up.is_finite() {
        return Ok(up);
    }
    Err(Error::argument("up", "three finite numbers", up, "check where it comes from"))
}

/// The unit vector to the right of a unit view direction; nothing where `up` is parallel to it.
fn right_of(forward: DVec3, up: DVec3) -> Result<Option<DVec3>> {
    let up = unit(up).ok_or_else(|| Error::argument("up", "a non-zero vector", up, "give an up vector"))?;
    let across = forward.cross(up);
    // Derived from f64: below 1e-9 the cross product has lost half of its digits.
    Ok(unit(across).filter(|_| across.length() > 1e-9))
}

/// The unit vector along `v`, at any scale; nothing for zero.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let size = v.abs().max_element();
    (size > 0.0 && size.is_finite()).then(|| (v / size).normalize())
}
