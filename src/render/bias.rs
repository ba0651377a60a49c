//! Depth bias, each part in the unit its name says. The parts add up.
//!
//! Source: theory.md 13: the constant world bias (13.1), the receiver-plane bias of a nearest lookup (13.2), tight at
//! `slope = 1`; the depth of the receiver's plane at each compared texel (`plane`), Isidoro 2006 `[isidoro2006]`; the offset along
//! the normal, Holbert 2011 `[holbert2011]`; the polygon offset of graphics APIs (13.11).

use crate::error::{Error, Result};

/// How much nearer to the light a receiver is moved before it is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bias {
    /// World units along the light ray.
    pub world: f64,
    /// World size of a shadow texel at the receiver, across the light ray (the longer side of its parallelogram).
    pub texels: f64,
    /// NDC depth.
    pub ndc: f64,
    /// Times the depth that the receiver's own plane gains over the filter's reach: 1 removes all acne of a plane.
    pub slope: f64,
    /// Upper limit of how far the slope part carries a receiver along the light ray, in world sizes of a shadow texel (as
    /// `texels`); infinity for none. What a surface straight across the ray gains in a warped map is no way along the ray and
    /// is not limited. It limits the `plane` part, too.
    pub slope_limit: f64,
    /// 1: what is compared with a texel is the depth of the receiver's own plane at that texel's centre, which is exact for
    /// planes; 0: the depth of the receiver; a part of the way between.
    pub plane: f64,
    /// World sizes of a shadow texel (as `texels`) by which the receiver is moved along its normal before anything else.
    pub normal: f64,
    /// As graphics APIs define `factor` of their polygon offset: times the larger change of the depth of the receiver's plane by a
    /// texel, along x or y. `slope_limit` limits it, too.
    pub factor: f64,
    /// As they define `units`: steps of the format of what is stored, at the receiver's depth.
    pub units: f64,
}

impl Default for Bias {
    /// Chosen by leaving scenes out, against traced truth; docs/bias.md has the tables.
    ///
    /// `plane` and `slope` together leave no acne on planes: what `plane` leaves of a plane's gain within the texel, 0.35, is less
    /// than `slope`, and 0.05 is for rasterisers that take the plane of depth through vertices rounded to their grid of 1/256.
    /// A part of the plane alone knows on which side of the receiver the texel's centre lies, so that it carries fewer receivers
    /// past thin casters than a slope of 1; all of it takes curved surfaces for their tangent planes. Half a texel is for these;
    /// `ndc` covers a few units in the last place of depth near 1. Slope and plane grow as 1/cos of the angle between normal and
    /// light, without end: a wall that the light grazes would be carried through its roof. Hence the limit of 16 texels.
    fn default() -> Self {
        Self { texels: 0.5, ndc: 1e-6, slope: 0.4, slope_limit: 16.0, plane: 0.65, ..Self::NONE }
    }
}

impl Bias {
    /// No bias at all: acne everywhere.
    pub const NONE: Self = Self {
        world: 0.0,
        texels: 0.0,
        ndc: 0.0,
        slope: 0.0,
        slope_limit: f64::INFINITY,
        plane: 0.0,
        normal: 0.0,
        factor: 0.0,
        units: 0.0,
    };

    /// What `glPolygonOffset(factor, units)`, `D3D11_RASTERIZER_DESC` and `depthBiasSlopeScale, depthBias` of Vulkan and WebGPU take
    /// off, and nothing else: `factor` max(|dz/dX|, |dz/dY|) + `units` r, r the step of the format. They add it to casters when a map
    /// is drawn; here the receiver's own plane has it, which is the same where that is what the map holds.
    pub const fn polygon_offset(factor: f64, units: f64) -> Self {
        Self { factor, units, ..Self::NONE }
    }

    /// This bias if every part is usable.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a part that is not finite (the limit may be infinite) or a negative slope or limit.
    pub fn checked(self) -> Result<Self> {
        let constants = [
            ("bias.world", self.world),
            ("bias.texels", self.texels),
            ("bias.ndc", self.ndc),
            ("bias.normal", self.normal),
            ("bias.factor", self.factor),
            ("bias.units", self.units),
        ];
        for (name, x) in constants {
            if !x.is_finite() {
                return Err(Error::argument(name, "a finite number", x, "0 switches this part off"));
            }
        }
        if !(self.slope >= 0.0 && self.slope.is_finite()) {
            return Err(Error::argument("bias.slope", "a finite number, 0 or more", self.slope, "0 switches it off"));
        }
        if !(0.0..=1.0).contains(&self.plane) {
            let fix = "1 compares with the receiver's plane, 0 with the receiver";
            return Err(Error::argument("bias.plane", "a number from 0 to 1", self.plane, fix));
        }
        if !(self.slope_limit >= 0.0) {
            let fix = "infinity switches the limit off";
            return Err(Error::argument("bias.slope_limit", "a number of texels, 0 or more", self.slope_limit, fix));
        }
        Ok(self)
    }
}
