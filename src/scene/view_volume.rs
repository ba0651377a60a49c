//! The volume that a camera sees, relative to its pose: a pyramid or a box, in the middle of the view axis or beside it.
//!
//! ```text
//!   perspective                      orthographic                    shifted by (0, 1): the lower edge
//!        ___---|                    ______________                         ___---|
//!  eye <       |  2 z tan(fov / 2)  |            |  height               /       |
//!        ---___|                    |____________|                 eye ---------_|
//!      near   far                  near         far                 straight ahead is the picture's lower edge
//! ```
//! Places across the view are told in one measure for both: `X / w`, with w the depth before a perspective eye and 1 for
//! parallel rays. The picture reaches from `center - half` to `center + half` in it.

use glam::{DMat4, DVec2};

use crate::error::{Error, Result};

/// How the rays of a picture run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// From the eye.
    Perspective {
        /// The full vertical angle of the picture before it is shifted, radians.
        fov_y: f64,
    },
    /// Parallel to the view direction.
    Orthographic {
        /// The full height of the picture, world units.
        height: f64,
    },
}

/// The volume that a camera sees, relative to its pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewVolume {
    /// How its rays run.
    pub lens: Lens,
    /// Width by height of the picture.
    pub aspect: f64,
    /// How far the middle of the picture lies to the right of the view axis and above it, in half widths and half heights.
    pub shift: DVec2,
    /// Near depth, along the view direction.
    pub near: f64,
    /// Far depth, along the view direction; infinity for a perspective without an end.
    pub far: f64,
}

/// The largest shift. Chosen because a crop of one pixel from a picture of 2^20 has about that: beyond, f32 does not tell the
/// directions of neighbouring pixels apart.
const MOST_SHIFT: f64 = 1e6;

impl ViewVolume {
    /// A pyramid in the middle of the view axis. Not checked: [`ViewVolume::checked`] does that.
    pub fn perspective(fov_y: f64, aspect: f64, near: f64, far: f64) -> Self {
        Self { lens: Lens::Perspective { fov_y }, aspect, shift: DVec2::ZERO, near, far }
    }
    /// A box in the middle of the view axis. Not checked: [`ViewVolume::checked`] does that.
    pub fn orthographic(height: f64, aspect: f64, near: f64, far: f64) -> Self {
        Self { lens: Lens::Orthographic { height }, aspect, shift: DVec2::ZERO, near, far }
    }
    /// The same beside the view axis.
    pub fn shifted(self, shift: DVec2) -> Self {
        Self { shift, ..self }
    }
    /// The same with other near and far planes.
    pub fn with_depths(self, near: f64, far: f64) -> Self {
        Self { near, far, ..self }
    }
    /// The volume itself.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a field of view outside (0, pi); a height or aspect that is not finite and above 0; a
    /// shift that is not finite or beyond a million; a near plane of a perspective that is not before the eye; a far plane not
    /// beyond the near one; an infinite far plane of a box.
    pub fn checked(self) -> Result<Self> {
        match self.lens {
            Lens::Perspective { fov_y } if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) => {
                let fix = "give radians (np.radians turns degrees into them)";
                return Err(Error::argument("fov_y", "an angle in (0, pi) radians", fov_y, fix));
            }
            Lens::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                let fix = "give the full height of the picture in world units";
                return Err(Error::argument("height", "a finite length above 0", height, fix));
            }
            _ => {}
        }
        if !(self.aspect > 0.0 && self.aspect.is_finite()) {
            return Err(Error::argument("aspect", "a finite number above 0", self.aspect, "give width / height"));
        }
        let half = self.half_size();
        if !(half.is_finite() && half.recip().is_finite()) {
            let (name, value) = match self.lens {
                Lens::Perspective { fov_y } => ("fov_y", fov_y),
                Lens::Orthographic { height } => ("height", height),
            };
            let [x, y] = half.to_array();
            let got = format!("{value} and {}, with which half the picture is {x} wide and {y} high", self.aspect);
            let expected = "a picture whose sides are finite and above 0";
            return Err(Error::argument(format!("{name}, aspect"), expected, got, "give others"));
        }
        if !(self.shift.abs().max_element() <= MOST_SHIFT) || self.shift.is_nan() {
            let fix = "give half widths and half heights of the picture: (0, 1) has the horizon at its lower edge";
            let expected = format!("two numbers between -{MOST_SHIFT:e} and {MOST_SHIFT:e}");
            return Err(Error::argument("shift", expected, self.shift, fix));
        }
        self.checked_depths()
    }
    fn checked_depths(self) -> Result<Self> {
        let Self { near, far, .. } = self;
        let expected = |what: &str| format!("{what} beyond near = {near}");
        match self.lens {
            Lens::Perspective { .. } => {
                if !(near > 0.0 && near.is_finite()) {
                    return Err(Error::argument("near", "a finite distance above 0", near, "move the near plane"));
                }
                if !(far > near) {
                    return Err(Error::argument("far", expected("a distance"), far, "move the far plane"));
                }
            }
            Lens::Orthographic { .. } => {
                if !near.is_finite() {
                    return Err(Error::argument("near", "a finite depth", near, "move the near plane"));
                }
                if !(far > near && (far - near).is_finite()) {
                    let fix = "move the far plane; only a perspective camera may have one at infinity";
                    return Err(Error::argument("far", expected("a finite depth"), far, fix));
                }
            }
        }
        Ok(self)
    }
    /// Whether all rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.lens, Lens::Orthographic { .. })
    }
    /// Full height of the picture: at depth 1 of a perspective, at every depth of an orthographic one.
    pub fn height(&self) -> f64 {
        2.0 * self.half_size().y
    }
    /// Half the picture's width and height, over w.
    pub fn half_size(&self) -> DVec2 {
        let y = match self.lens {
            Lens::Perspective { fov_y } => (0.5 * fov_y).tan(),
            Lens::Orthographic { height } => 0.5 * height,
        };
        DVec2::new(y * self.aspect, y)
    }
    /// The middle of the picture, over w.
    pub fn center(&self) -> DVec2 {
        self.shift * self.half_size()
    }
    /// `clip_from_view`, z from 0 at near to 1 at far.
    pub fn clip_from_view(&self) -> DMat4 {
        let Self { aspect, shift, near, far, .. } = *self;
        use glam::dcamera::rh::proj::directx;
        match self.lens {
            Lens::Perspective { fov_y } => {
                let mut m = if far.is_finite() {
                    directx::perspective(fov_y, aspect, near, far)
                } else {
                    directx::perspective_infinite(fov_y, aspect, near)
                };
                // Straight ahead is where z alone, which is -depth, leaves x and y.
                (m.z_axis.x, m.z_axis.y) = (shift.x, shift.y);
                m
            }
            Lens::Orthographic { .. } => {
                let half = self.half_size();
                let mut m = directx::orthographic(-half.x, half.x, -half.y, half.y, near, far);
                (m.w_axis.x, m.w_axis.y) = (0.0 - shift.x, 0.0 - shift.y);
                m
            }
        }
    }
    /// The same with z from 1 at near to 0 at far (`[lapidous1999]`): of a depth in floating point no digit is lost however
    /// near the near plane is.
    pub fn reversed_clip_from_view(&self) -> DMat4 {
        let mut m = self.clip_from_view();
        // Not 1 minus the other, of which hardly a digit is left where near / far is small.
        (m.z_axis.z, m.w_axis.z) = match self.lens {
            Lens::Perspective { .. } if self.far.is_finite() => {
                let at_far = self.near / (self.far - self.near);
                (at_far, at_far * self.far)
            }
            Lens::Perspective { .. } => (0.0, self.near),
            Lens::Orthographic { .. } => {
                let per_depth = (self.far - self.near).recip();
                (per_depth, self.far * per_depth)
            }
        };
        m
    }
    /// NDC z of a depth, 0 at near and 1 at far.
    #[inline(always)]
    pub fn ndc_depth(&self, depth: f64) -> f64 {
        let Self { near, far, .. } = *self;
        match self.lens {
            Lens::Perspective { .. } if far.is_finite() => far * (depth - near) / (depth * (far - near)),
            Lens::Perspective { .. } => (depth - near) / depth,
            Lens::Orthographic { .. } => (depth - near) / (far - near),
        }
    }
    /// The depth of an NDC z less 1: of -1 at near to 0 at far.
    pub fn depth_before_far(&self, to_far: f64) -> f64 {
        let Self { near, far, .. } = *self;
        match self.lens {
            Lens::Perspective { .. } if far.is_finite() => near * far / (near - to_far * (far - near)),
            Lens::Perspective { .. } => -near / to_far,
            Lens::Orthographic { .. } => far + to_far * (far - near),
        }
    }
}
