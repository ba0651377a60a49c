//! The lights.

use glam::{DVec3, DVec4};

use super::camera::unit;
use crate::error::{Error, Result};

/// The narrowest cone of a spot, radians: a few times what directions are rounded by, 2^-52.
const NARROWEST_CONE: f64 = 1e-15;

/// The cosine up to which a surface is edge on to the light: what a unit normal formed and rounded in f32 can make of one across
/// it (two edges, their cross product, its length). Such walls are dark in truth, and a texel on them would be as long as f32
/// has digits.
pub const EDGE_ON: f64 = 4.0 * f32::EPSILON as f64;

/// A light at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    direction: DVec3,
}

/// A light at a point that shines into a circular cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    position: DVec3,
    direction: DVec3,
    cone_angle: f64,
    /// The cosine of half the angle: kept, because every receiver is held against it.
    cos_half_angle: f64,
    range: f64,
}

/// A light at a point that shines everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    position: DVec3,
    range: f64,
}

/// Any light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// See [`DirectionalLight`].
    Directional(DirectionalLight),
    /// See [`SpotLight`].
    Spot(SpotLight),
    /// See [`PointLight`].
    Point(PointLight),
}

impl DirectionalLight {
    /// A light that travels along `direction` (any length above 0).
    pub fn new(direction: DVec3) -> Result<Self> {
        Ok(Self { direction: unit_direction(direction)? })
    }
    /// A light that travels along a unit vector, which is kept as it is.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for another length.
    pub fn of_unit(direction: DVec3) -> Result<Self> {
        Ok(Self { direction: of_unit_length(direction)? })
    }
    /// The light that stands at an elevation above the horizon (y points up), in the direction of an azimuth: a turn about
    /// the y axis, from +z towards +x. Radians.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for an angle that is not finite, or an elevation outside of [-pi/2, pi/2].
    pub fn from_angles(azimuth: f64, elevation: f64) -> Result<Self> {
        if !azimuth.is_finite() {
            return Err(Error::argument("azimuth", "a finite angle in radians", azimuth, "0 is along +z"));
        }
        if !(elevation.abs() <= std::f64::consts::FRAC_PI_2) {
            let fix = "give radians (np.radians turns degrees into them)";
            return Err(Error::argument("elevation", "an angle in [-pi/2, pi/2] radians", elevation, fix));
        }
        let level = elevation.cos();
        Self::new(-DVec3::new(azimuth.sin() * level, elevation.sin(), azimuth.cos() * level))
    }
    /// Unit vector, the way the light travels.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
    /// [`Light::illuminates`], without branches; the same at every point.
    #[inline(always)]
    pub fn illuminates(&self, normal: DVec3) -> bool {
        faces(normal, -self.direction)
    }
}

impl SpotLight {
    /// A light at `position` that shines along `direction` into a cone of full angle `cone_angle` (radians, below pi and at
    /// least 1e-15) as far as `range`.
    pub fn new(position: DVec3, direction: DVec3, cone_angle: f64, range: f64) -> Result<Self> {
        if !(cone_angle > 0.0 && cone_angle < std::f64::consts::PI) {
            let fix = "give the full angle of the cone in radians; a wider light is a point light";
            return Err(Error::argument("cone_angle", "an angle in (0, pi) radians", cone_angle, fix));
        }
        if cone_angle < NARROWEST_CONE {
            let (expected, fix) = (format!("at least {NARROWEST_CONE:e} radians"), "widen the cone: it lights nothing");
            return Err(Error::argument("cone_angle", expected, cone_angle, fix));
        }
        let (position, range) = placed(position, range)?;
        let cos_half_angle = (0.5 * cone_angle).cos();
        Ok(Self { position, direction: unit_direction(direction)?, cone_angle, cos_half_angle, range })
    }
    /// The same light along a unit vector, which is kept as it is.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for another length.
    pub fn with_unit(self, direction: DVec3) -> Result<Self> {
        Ok(Self { direction: of_unit_length(direction)?, ..self })
    }
    /// Where it is.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    /// Unit axis of the cone.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
    /// Full angle of the cone, radians.
    pub fn cone_angle(&self) -> f64 {
        self.cone_angle
    }
    /// How far it shines.
    pub fn range(&self) -> f64 {
        self.range
    }
    /// Whether a point lies inside the cone and the range, by the vector from it to the light.
    #[inline(always)]
    fn reaches(&self, to_light: DVec3) -> bool {
        let distance = to_light.length();
        (distance <= self.range) & (-to_light.dot(self.direction) >= distance * self.cos_half_angle)
    }
    /// [`Light::illuminates`], without branches.
    #[inline(always)]
    pub fn illuminates(&self, p_world: DVec3, normal: DVec3) -> bool {
        let to_light = self.position - p_world;
        faces(normal, to_light) & self.reaches(to_light)
    }
}

impl PointLight {
    /// A light at `position` that shines as far as `range`.
    pub fn new(position: DVec3, range: f64) -> Result<Self> {
        let (position, range) = placed(position, range)?;
        Ok(Self { position, range })
    }
    /// Where it is.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    /// How far it shines.
    pub fn range(&self) -> f64 {
        self.range
    }
    /// [`Light::illuminates`], without branches.
    #[inline(always)]
    pub fn illuminates(&self, p_world: DVec3, normal: DVec3) -> bool {
        let to_light = self.position - p_world;
        faces(normal, to_light) & (to_light.length() <= self.range)
    }
}

impl Light {
    /// "directional", "spot" or "point".
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Directional(_) => "directional",
            Self::Spot(_) => "spot",
            Self::Point(_) => "point",
        }
    }
    /// The centre of projection as a homogeneous point: (-l, 0) or (p, 1) (theory.md 0).
    pub fn point(&self) -> DVec4 {
        match self {
            Self::Directional(l) => (-l.direction).extend(0.0),
            Self::Spot(l) => l.position.extend(1.0),
            Self::Point(l) => l.position.extend(1.0),
        }
    }
    /// The vector from a world point to the light, with the distance to travel: an occluder lies at `p + s * to_light` with
    /// `0 < s < 1` for a placed light, `0 < s` for a directional one (whose vector is a unit vector).
    #[inline]
    pub fn to_light(&self, p_world: DVec3) -> DVec3 {
        match self {
            Self::Directional(l) => -l.direction,
            Self::Spot(l) => l.position - p_world,
            Self::Point(l) => l.position - p_world,
        }
    }
    /// Whether light would arrive at a surface if nothing were in the way: its unit normal (on the side that the eye sees) is
    /// turned towards the light by more than [`EDGE_ON`], and the point lies within cone and range.
    #[inline]
    pub fn illuminates(&self, p_world: DVec3, normal: DVec3) -> bool {
        match self {
            Self::Directional(l) => l.illuminates(normal),
            Self::Spot(l) => l.illuminates(p_world, normal),
            Self::Point(l) => l.illuminates(p_world, normal),
        }
    }
    /// Whether light would arrive at a point if nothing were in the way: inside the cone and the range.
    #[inline]
    pub fn reaches(&self, p_world: DVec3) -> bool {
        match self {
            Self::Directional(_) => true,
            Self::Spot(l) => l.reaches(l.position - p_world),
            Self::Point(l) => (l.position - p_world).length() <= l.range,
        }
    }
}

/// Whether a unit normal is turned towards the light by more than [`EDGE_ON`].
#[inline(always)]
fn faces(normal: DVec3, to_light: DVec3) -> bool {
    normal.dot(to_light) > EDGE_ON * to_light.length()
}

fn unit_direction(direction: DVec3) -> Result<DVec3> {
    unit(direction).filter(|_| direction.is_finite()).ok_or_else(|| {
        Error::argument("direction", "three finite numbers, not all zero", direction, "give the way the light travels")
    })
}

fn of_unit_length(direction: DVec3) -> Result<DVec3> {
    // The roundings of a normalised vector's components and of its square; a NaN is no length.
    if (direction.length_squared() - 1.0).abs() <= 8.0 * f64::EPSILON {
        return Ok(direction);
    }
    Err(Error::argument("direction", "a unit vector", direction, "normalise it"))
}

fn placed(position: DVec3, range: f64) -> Result<(DVec3, f64)> {
    if !position.is_finite() {
        return Err(Error::argument("position", "three finite numbers", position, "check where it comes from"));
    }
    if !(range > 0.0 && range.is_finite()) {
        return Err(Error::argument("range", "a finite distance above 0", range, "give how far the light shines"));
    }
    Ok((position, range))
}
