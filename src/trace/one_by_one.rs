//! Rays each of which depends on what the last one met.

use glam::DVec3;

use super::batch::Hit;
use super::hierarchy::{Inner, Tracer};
use super::kernel::Kernel;
use super::rays::WorldRay;
use super::walk::{Closest, Stack, traverse_one};

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
    let mut closest = Closest::<false>::new(0.0, t_max, 0.0);
    traverse_one::<K, _>(scene, &ray, &mut closest, stack);
    let hit = |(instance, triangle)| Hit { t: closest.t, triangle: triangle as i32, instance: instance as i32 };
    closest.face.map_or(Hit::NONE, hit)
}

super::kernel::dispatched! {
    fn first(scene: &Inner, ray: WorldRay, t_max: f64, stack: &mut Stack) -> Hit = first_with;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, Progress, Scene};

    #[test]
    fn rays_one_by_one_meet_what_they_meet_together() {
        let corner =
            |k: usize, s: f64| [(k as f64 * 1.7).sin() + s, (k as f64 * 2.3).cos(), (k as f64 * 0.9).sin() - s];
        let vertices: Vec<[f64; 3]> = (0..90).map(|k| corner(k / 3, 0.2 * (k % 3) as f64)).collect();
        let moved: Vec<[f64; 3]> =
            vertices.iter().enumerate().map(|(k, v)| [v[0], v[1] + 0.3 * (k % 2) as f64, v[2]]).collect();
        let faces: Vec<[i64; 3]> = (0..30).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let scene = Scene::from_mesh(Mesh::new(&moved, &faces).unwrap()).unwrap();
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let origins: Vec<[f64; 3]> =
            (0..400).map(|k| [(k % 20) as f64 * 0.15 - 1.5, 4.0, (k / 20) as f64 * 0.15 - 1.5]).collect();
        let directions = vec![[0.1, -1.0, 0.05]; origins.len()];
        let together = tracer.first_hit(&origins, &directions, &Progress::new()).unwrap();
        let mut one = tracer.one_by_one();
        let mut met = 0;
        for ((o, d), hit) in origins.iter().zip(&directions).zip(&together) {
            let (o, d) = (DVec3::from_array(*o), DVec3::from_array(*d));
            assert_eq!(one.first_hit(o, d, f64::INFINITY), *hit);
            if hit.triangle >= 0 {
                met += 1;
                assert_ne!(one.first_hit(o, d, hit.t), *hit);
            }
        }
        assert!(met > 20);
    }
}
