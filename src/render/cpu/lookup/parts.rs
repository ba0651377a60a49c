//! Which parts of a lookup are in use.

use glam::DVec4;

use crate::render::{Bias, Kernels, Spacing, Stored};

/// Which parts of a lookup are in use: of a map's settings, or constants of a kernel that is compiled without the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parts {
    /// The light has a place.
    pub(super) is_placed: bool,
    /// The receiver's plane has a part in the bias: `slope`, `plane` and `factor`.
    pub(super) takes_plane: bool,
    /// That part has a limit.
    pub(super) is_limited: bool,
    /// Depth is linear.
    pub(super) is_linear: bool,
    /// The kernel is constant in the picture.
    pub(super) is_in_pixels: bool,
    /// The parts of the bias of these names.
    pub(super) normal: bool,
    pub(super) factor: bool,
    pub(super) units: bool,
}

impl Parts {
    /// Those that a light and settings ask for.
    pub(super) fn of(light: DVec4, bias: &Bias, kernels: &Kernels, stored: &Stored) -> Self {
        Self {
            is_placed: light.w != 0.0,
            takes_plane: bias.slope > 0.0 || bias.plane > 0.0 || bias.factor != 0.0,
            is_limited: bias.slope_limit.is_finite(),
            is_linear: stored.spacing == Spacing::Linear,
            is_in_pixels: kernels.fixed().is_none(),
            normal: bias.normal != 0.0,
            factor: bias.factor != 0.0,
            units: bias.units != 0.0,
        }
    }
}

/// A combination of parts for which kernels over runs are compiled.
pub(super) trait Case: Copy {
    const PARTS: Parts;
}

/// A map without post-warp, or with a logarithm, that stores projective depth, a kernel in texels, and a bias without the rare parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common<const PLACED: bool, const PLANE: bool, const LIMITED: bool>;

impl<const PLACED: bool, const PLANE: bool, const LIMITED: bool> Case for Common<PLACED, PLANE, LIMITED> {
    const PARTS: Parts = Parts {
        is_placed: PLACED,
        takes_plane: PLANE,
        is_limited: LIMITED,
        is_linear: false,
        is_in_pixels: false,
        normal: false,
        factor: false,
        units: false,
    };
}
