//! Which samples a map has to answer for: those that face the light, within its reach, of a part of a view.

use glam::{DVec3, Vec3};

use super::samples::{AT_ONCE, Samples, TOGETHER, vector};
use crate::error::Result;
use crate::parameterization::Region;
use crate::rays::LightFrame;
use crate::scene::{Camera, Light};
use crate::simd::dispatch;

impl Samples {
    /// Position and normal of the samples that a map for a part of a view has to answer for: between the camera's near and
    /// far planes, on the rays of `region`, facing the light and within its reach (of a spot: the pyramid around its cone, as a
    /// face of a point light shines there too). The others are dark without a look.
    pub fn lit<'a>(
        &'a self,
        camera: &'a Camera,
        light: &'a Light,
        region: &'a Region,
    ) -> impl Iterator<Item = (DVec3, DVec3)> + Clone + 'a {
        let all = self.points.iter().zip(self.normals.iter()).map(|(p, n)| (self.origin + vector(*p), vector(*n)));
        all.filter(move |(p, n)| counts(camera, light, region, *p, *n))
    }
    /// Whether a point is one that a map for a part of a view has to answer for.
    pub fn counts(&self, camera: &Camera, light: &Light, region: &Region, p: DVec3, normal: DVec3) -> bool {
        counts(camera, light, region, p, normal)
    }
    /// Indices of the samples that a map for a part of a view has to answer for.
    pub(super) fn facing(&self, camera: &Camera, light: &Light, region: &Region) -> Vec<u32> {
        // Nothing stops it.
        self.facing_watched(camera, light, region, || Ok(())).unwrap_or_default()
    }
    /// The same, asking now and then whether to go on.
    ///
    /// # Errors
    /// Those of `check`.
    pub fn facing_watched(
        &self,
        camera: &Camera,
        light: &Light,
        region: &Region,
        check: impl Fn() -> Result<()>,
    ) -> Result<Vec<u32>> {
        let (count, mut found) = (self.points.len() as u32, Vec::new());
        let parts = (0..count).step_by(AT_ONCE).map(|first| first..count.min(first.saturating_add(AT_ONCE as u32)));
        match light {
            // The common case without a test that is always true.
            Light::Directional(l) if region.functionals().is_empty() => {
                let toward = Toward::new(camera, -l.direction(), self.origin);
                for part in parts {
                    check()?;
                    for first in part.clone().step_by(TOGETHER) {
                        let some = first as usize..part.end.min(first + TOGETHER as u32) as usize;
                        let mut faces = [false; TOGETHER];
                        find_facing(&toward, &self.points[some.clone()], &self.normals[some.clone()], &mut faces);
                        let faces = &faces[..some.len()];
                        if faces.iter().fold(true, |all, face| all & face) {
                            found.extend(some.map(|i| i as u32));
                        } else {
                            found.extend((first..).zip(faces).filter(|(_, faces)| **faces).map(|(i, _)| i));
                        }
                    }
                }
            }
            _ => {
                for part in parts {
                    check()?;
                    found.extend(part.filter(|&i| self.counts_at(i, camera, light, region)));
                }
            }
        }
        Ok(found)
    }
    pub(super) fn counts_at(&self, i: u32, camera: &Camera, light: &Light, region: &Region) -> bool {
        let (p, n) = self.sample(i as usize);
        counts(camera, light, region, p, n)
    }
}

/// What is asked of samples under a directional light.
struct Toward<'a> {
    camera: &'a Camera,
    /// To the light, and the same in single precision.
    way: DVec3,
    single: Vec3,
    /// What samples are relative to.
    origin: DVec3,
}

impl<'a> Toward<'a> {
    fn new(camera: &'a Camera, way: DVec3, origin: DVec3) -> Self {
        Self { camera, way, single: way.as_vec3(), origin }
    }
}

dispatch! {
    /// Which samples face a directional light and lie between the camera's planes.
    fn find_facing(toward: &Toward, points: &[[f32; 3]], normals: &[[f32; 3]], faces: &mut [bool; TOGETHER]) = find_facing_body
}

#[inline(always)]
fn find_facing_body(toward: &Toward, points: &[[f32; 3]], normals: &[[f32; 3]], faces: &mut [bool; TOGETHER]) {
    let Toward { camera, way, single, origin } = *toward;
    let (near, far) = (camera.near(), camera.far());
    for ((faces, p), n) in faces.iter_mut().zip(points).zip(normals) {
        // In f32 as the normal is; what is undecided there is decided in f64.
        let cosine = n[0] * single.x + n[1] * single.y + n[2] * single.z;
        let is_toward = !(cosine < -1e-5) & ((cosine > 1e-5) | (vector(*n).dot(way) > 0.0));
        // Rounded as elsewhere: a split begins and ends at samples' depths.
        let depth = camera.depth_of(origin + vector(*p));
        *faces = is_toward & (depth >= near) & (depth <= far);
    }
}

/// Whether a point is one that a map for a part of a view has to answer for.
pub(super) fn counts(camera: &Camera, light: &Light, region: &Region, p: DVec3, normal: DVec3) -> bool {
    (camera.near()..=camera.far()).contains(&camera.depth_of(p))
        && normal.dot(light.to_light(p)) > 0.0
        && can_reach(light, p)
        && region.contains(p)
}

/// Whether a point is where a map of the light can be.
fn can_reach(light: &Light, p: DVec3) -> bool {
    let Light::Spot(spot) = light else { return light.reaches(p) };
    let frame = LightFrame::any(spot.direction());
    let from_light = p - spot.position();
    let depth = from_light.dot(frame.along);
    // Two faces of a point light meet: the tangent of the half angle is rounded, and a point on the seam is in one of them.
    let half = depth * (0.5 * spot.cone_angle()).tan() * (1.0 + 4.0 * f64::EPSILON);
    depth <= spot.range() && from_light.dot(frame.right).abs() <= half && from_light.dot(frame.up).abs() <= half
}
