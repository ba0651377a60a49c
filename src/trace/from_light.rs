//! What the light meets first on its way to points: what an exact shadow map would hold there.

use glam::DVec3;

use super::batch::Hit;
use super::hierarchy::Tracer;
use crate::error::Result;
use crate::progress::Progress;
use crate::scene::Light;

/// What light meets on its way to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstLit {
    /// The triangle that it meets first; none where the way to the point and the point itself are empty.
    pub hit: Hit,
    /// How far before the point, world units: positive for a blocker.
    pub before: f64,
    /// Where, world.
    pub at: DVec3,
}

impl Tracer {
    /// What the light meets first on its way to each of some points (world), none of which is at the light.
    ///
    /// # Errors
    /// As [`Tracer::first_hit`].
    pub fn first_from_light(&self, light: &Light, points: &[DVec3], progress: &Progress) -> Result<Vec<FirstLit>> {
        let (bounds, light) = (self.inner.scene.bounds(), light.point());
        let ray = |&p: &DVec3| {
            if light.w != 0.0 {
                return (light.truncate(), p - light.truncate());
            }
            // From beyond everything: further from the point than any of the scene.
            let to_light = light.truncate();
            let reach = (p - bounds.center()).length() + bounds.diagonal();
            (p + reach * to_light, -reach * to_light)
        };
        let rays: Vec<(DVec3, DVec3)> = points.iter().map(ray).collect();
        let (origins, directions): (Vec<_>, Vec<_>) = rays.iter().map(|(o, d)| (o.to_array(), d.to_array())).unzip();
        let hits = self.first_hit(&origins, &directions, progress)?;
        let first = |(hit, (origin, way)): (Hit, (DVec3, DVec3))| {
            // A ray that meets nothing ends at the point.
            let t = if hit.triangle < 0 { 1.0 } else { hit.t };
            FirstLit { hit, before: (1.0 - t) * way.length(), at: origin + t * way }
        };
        Ok(hits.into_iter().zip(rays).map(first).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DirectionalLight, PointLight};
    use crate::{Mesh, Scene};

    #[test]
    fn the_roof_is_met_before_the_table_and_the_table_before_the_floor() {
        let level = |y: f64| [[-1.0, y, -1.0], [1.0, y, -1.0], [1.0, y, 1.0], [-1.0, y, 1.0]];
        let vertices: Vec<[f64; 3]> = [0.0, 1.0, 3.0].into_iter().flat_map(level).collect();
        let quad = |k: i64| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]];
        let faces: Vec<[i64; 3]> = (0..3).flat_map(quad).collect();
        let scene = Scene::from_mesh(Mesh::new(&vertices, &faces).unwrap()).unwrap();
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let floor = DVec3::new(0.3, 0.0, 0.2);
        let sun = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap());
        let lamp = Light::Point(PointLight::new(DVec3::new(0.3, 2.0, 0.2), 10.0).unwrap());
        for (light, expected, height) in [(sun, 3.0, 3.0), (lamp, 1.0, 1.0)] {
            let found = tracer.first_from_light(&light, &[floor, floor + 7.0 * DVec3::X], &Progress::new()).unwrap();
            assert!((found[0].before - expected).abs() < 1e-12 && (found[0].at.y - height).abs() < 1e-12);
            assert!(found[1].hit.triangle < 0 && found[1].before == 0.0);
        }
    }
}
