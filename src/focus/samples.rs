//! What a camera sees, as points: for techniques that look at the receivers themselves.
//!
//! Plain data made by whoever has a renderer, so that techniques stay pure functions. Source: Lauritzen, Salvi, Lefohn 2010
//! `[lauritzen2010]` (sample distribution shadow maps); theory.md 9 and 12.1.

use glam::DVec3;

use crate::image::GBuffer;
use crate::parameterization::Region;
use crate::rays::LightFrame;
use crate::scene::{Camera, Light};

/// Visible surface points with their normals, world space, both in the order of the pixels they were seen in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReceiverSamples {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Unit normals, on the side of the eye.
    pub normals: Vec<DVec3>,
}

impl ReceiverSamples {
    /// One sample a pixel that shows anything.
    pub fn from_gbuffer(gbuffer: &GBuffer) -> Self {
        let seen = (0..gbuffer.triangle.len()).filter(|&i| gbuffer.triangle[i] >= 0);
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (points, normals) =
            seen.map(|i| (gbuffer.origin + vector(gbuffer.position[i]), vector(gbuffer.normal[i]))).unzip();
        Self { points, normals }
    }
    /// Position and normal of the samples that a map for a part of a view has to answer for: between the camera's near and
    /// far planes, on the rays of `region`, facing the light and within its reach (of a spot: the pyramid around its cone, as a
    /// face of a point light shines there too). The others are dark without a look.
    pub fn lit<'a>(
        &'a self,
        camera: &'a Camera,
        light: &'a Light,
        region: &'a Region,
    ) -> impl Iterator<Item = (DVec3, DVec3)> + 'a {
        let all = self.points.iter().copied().zip(self.normals.iter().copied());
        let depths = camera.near()..=camera.far();
        all.filter(move |(p, normal)| {
            depths.contains(&camera.depth_of(*p))
                && normal.dot(light.to_light(*p)) > 0.0
                && can_reach(light, *p)
                && region.contains(*p)
        })
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DirectionalLight, SpotLight};
    use glam::DVec4;

    #[test]
    fn lit_samples_are_those_of_the_part_that_face_the_light() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 1.0, 10.0).expect("a camera");
        let depths = [0.5, 1.0, 5.0, 10.0, 11.0];
        let samples = ReceiverSamples {
            points: depths.iter().flat_map(|d| [DVec3::new(0.1, -1.0, -d), DVec3::new(-0.1, -1.0, -d)]).collect(),
            normals: [DVec3::Y, DVec3::NEG_Y].repeat(depths.len()),
        };
        let down = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).expect("a light"));
        let seen = |light: &Light, region: &Region| -> Vec<f64> {
            samples.lit(&camera, light, region).map(|(p, _)| -p.z).collect()
        };
        // Points to the right face up, those to the left down.
        assert_eq!(seen(&down, &Region::ALL), [1.0, 5.0, 10.0]);
        assert_eq!(seen(&down, &Region::new(&[DVec4::new(0.0, 0.0, 1.0, 5.0)])), [1.0, 5.0]);
        assert!(seen(&down, &Region::new(&[DVec4::new(-1.0, 0.0, 0.0, 0.0)])).is_empty());
        let spot = SpotLight::new(DVec3::new(0.0, 5.0, -5.0), DVec3::NEG_Y, 0.5, 20.0).expect("a spot");
        assert_eq!(seen(&Light::Spot(spot), &Region::ALL), [5.0]);
    }
}
