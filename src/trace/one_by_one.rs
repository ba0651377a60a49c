//! Rays each of which depends on what the last one met.

use glam::DVec3;

use super::batch::Hit;
use super::hierarchy::{Inner, Tracer};
use super::kernel::Kernel;
use super::rays::{WorldRay, WorldRays};
use super::walk::{Closest, Stack, first_of_ties, tie_reach, traverse_one};

/// Traces one ray after the other, on one core. Many rays that are known beforehand are faster by [`Tracer::first_hit`].
#[derive(Debug)]
pub struct OneByOne<'a> {
    scene: &'a Inner,
    stack: Stack,
}

impl Tracer {
    /// For rays that are not known beforehand.
    pub fn one_by_one(&self) -> OneByOne<'_> {
        OneByOne { scene: &self.inner, stack: Stack::new() }
    }
}

impl OneByOne<'_> {
    /// What a ray meets first, for `0 < t < t_max`: as [`Tracer::first_hit`]. World coordinates; all of them finite, the
    /// direction not zero.
    pub fn first_hit(&mut self, origin: DVec3, direction: DVec3, t_max: f64) -> Hit {
        let ray = WorldRay { origin: origin - self.scene.scene.origin(), direction };
        first(self.scene, ray, t_max, &mut self.stack)
    }
}

#[inline(always)]
fn first_with<K: Kernel>(scene: &Inner, ray: WorldRay, t_max: f64, stack: &mut Stack) -> Hit {
    let [tie] = tie_reach(scene, &WorldRays::from([ray]));
    let mut closest = Closest::<false>::new(0.0, t_max, 0.0);
    closest.note_ties(tie);
    traverse_one::<K, _>(scene, &ray, &mut closest, stack);
    let Closest { t, face: Some(first), is_tied, .. } = closest else { return Hit::NONE };
    let (instance, triangle) = if is_tied { first_of_ties::<K>(scene, &ray, (t, first), t_max, stack) } else { first };
    Hit { t, triangle: triangle as i32, instance: instance as i32 }
}

super::kernel::dispatched! {
    fn first(scene: &Inner, ray: WorldRay, t_max: f64, stack: &mut Stack) -> Hit = first_with;
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{Mesh, Progress, Scene};

    /// Triangles at many heights.
    fn leaves() -> Scene {
        let at = |k: usize| [(k as f64 * 1.7).sin(), (k as f64 * 2.3).cos(), (k as f64 * 0.9).sin()];
        let corner = |k: usize| {
            let ([x, y, z], [dx, dz]) = (at(k / 3), [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]][k % 3]);
            [x + dx, y + 0.2 * dx, z + dz]
        };
        let vertices: Vec<[f64; 3]> = (0..90).map(corner).collect();
        let faces: Vec<[i64; 3]> = (0..30).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Scene::from_mesh(Mesh::new(&vertices, &faces).unwrap()).unwrap()
    }

    #[test]
    fn rays_one_by_one_meet_what_they_meet_together() {
        let one = leaves();
        let moved = one.transformed(&DAffine3::from_translation(DVec3::new(0.3, 0.5, -0.2))).unwrap();
        // The last one's triangles are all met in pairs, and rays of a bundle differ in speed by more than is bounded together.
        let scenes = [one.clone(), one.joined(&moved).unwrap(), one.joined(&one).unwrap()];
        let speeds = [[1.0; 4], [1.0, 3.0, 0.2, 40.0], [1.0, 1e-9, 1e12, 0.5]];
        for (scene, speeds) in scenes.iter().flat_map(|scene| speeds.map(|speeds| (scene, speeds))) {
            let tracer = Tracer::new(scene, &Progress::new()).unwrap();
            let place = |k: usize| 0.15 * k as f64 - 1.5;
            let origins: Vec<[f64; 3]> = (0..400).map(|k| [place(k % 20), 4.0, place(k / 20)]).collect();
            let directions: Vec<[f64; 3]> = (0..400).map(|k| [0.1, -1.0, 0.05].map(|x| x * speeds[k % 4])).collect();
            let together = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
            let mut alone = tracer.one_by_one();
            for ((o, d), hit) in origins.iter().zip(&directions).zip(&together) {
                let (o, d) = (DVec3::from_array(*o), DVec3::from_array(*d));
                assert_eq!(alone.first_hit(o, d, f64::INFINITY), *hit);
                // Not what ends at a hit.
                assert!(hit.triangle < 0 || alone.first_hit(o, d, hit.t) == Hit::NONE);
            }
            let met = together.iter().filter(|hit| hit.triangle >= 0).count();
            assert!(met > 100 && met < 400, "{met}");
        }
    }
}
