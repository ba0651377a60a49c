//! Scenes in which some instances stand elsewhere: geometry is shared.

use glam::DAffine3;

use super::Scene;
use crate::error::{Error, Result};
use crate::progress::Progress;

impl Scene {
    /// The scene with some of its instances placed anew; meshes and alpha tests stay shared.
    ///
    /// # Arguments
    /// * `indices` - which instances, each once
    /// * `world_from_mesh` - where each of them stands; any map that [`Scene::new`] takes
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for an index out of range or given twice, another number of maps than indices, and a map
    /// that is not finite or takes the mesh out of the range of f64; [`Error::Interrupted`].
    pub fn with_transforms(
        &self,
        indices: &[usize],
        world_from_mesh: &[DAffine3],
        progress: &Progress,
    ) -> Result<Self> {
        let count = self.instances().len();
        if indices.len() != world_from_mesh.len() {
            let expected = format!("one matrix for each of the {} indices", indices.len());
            return Err(Error::argument("matrices", expected, world_from_mesh.len(), "give as many"));
        }
        let mut is_moved = vec![false; count];
        for (k, &index) in indices.iter().enumerate() {
            let name = || format!("indices[{k}]");
            match is_moved.get_mut(index) {
                None => {
                    let expected = format!("the index of one of the {count} instances, from 0");
                    return Err(Error::argument(name(), expected, index, "give one of them"));
                }
                Some(moved) if *moved => {
                    let expected = "each instance once";
                    return Err(Error::argument(name(), expected, format!("{index} a second time"), "remove one"));
                }
                Some(moved) => *moved = true,
            }
        }
        if let Some(k) = world_from_mesh.iter().position(|map| !map.is_finite()) {
            let (expected, got) = ("16 finite numbers", "a NaN or an infinity");
            return Err(Error::argument(format!("matrices[{k}]"), expected, got, "check what moves the instance"));
        }
        progress.check()?;
        let mut instances = self.instances().to_vec();
        progress.check()?;
        for (&index, &map) in indices.iter().zip(world_from_mesh) {
            instances[index].world_from_mesh = map;
        }
        Self::watched(self.meshes().to_vec(), instances, progress)
    }
    /// Whether both have the same meshes, by content, in the same instances: one is the other with instances moved.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn has_instances_of(&self, other: &Self, progress: &Progress) -> Result<bool> {
        let of = |scene: &Self| scene.instances().iter().map(|i| i.mesh).collect::<Vec<_>>();
        if self.meshes().len() != other.meshes().len() || of(self) != of(other) {
            return Ok(false);
        }
        for (a, b) in self.meshes().iter().zip(other.meshes()) {
            if a.id() != b.id() && a.content_hash(progress)? != b.content_hash(progress)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3};

    use super::*;
    use crate::scene::library;

    fn hash(scene: &Scene) -> [u8; 32] {
        scene.content_hash(&Progress::new()).unwrap()
    }
    fn swayed(scene: &Scene, indices: &[usize], angle: f64) -> Vec<DAffine3> {
        let turn = DAffine3::from_mat3(DMat3::from_rotation_z(angle));
        indices.iter().map(|&i| scene.instances()[i].world_from_mesh * turn).collect()
    }

    #[test]
    fn a_moved_scene_is_what_its_instances_make_and_shares_its_meshes() {
        for name in library::names() {
            let scene = library::build(name, 1, &[]).unwrap().scene;
            let every_third: Vec<usize> = (0..scene.instances().len()).rev().step_by(3).collect();
            let maps = swayed(&scene, &every_third, 0.1);
            let moved = scene.with_transforms(&every_third, &maps, &Progress::new()).unwrap();
            let mut instances = scene.instances().to_vec();
            every_third.iter().zip(&maps).for_each(|(&i, &map)| instances[i].world_from_mesh = map);
            let anew = Scene::new(scene.meshes().to_vec(), instances).unwrap();
            assert_eq!(hash(&moved), hash(&anew), "{name}");
            assert_ne!(hash(&moved), hash(&scene), "{name}");
            assert_ne!(moved.id(), scene.id());
            assert_eq!((moved.bounds(), moved.triangle_count()), (anew.bounds(), anew.triangle_count()), "{name}");
            let placed = |of: &Scene| (0..of.instances().len()).map(|i| of.world_from_local(i)).collect::<Vec<_>>();
            assert_eq!(placed(&moved), placed(&anew), "{name}");
            assert!(moved.meshes().iter().zip(scene.meshes()).all(|(a, b)| Arc::ptr_eq(a, b)), "{name}");
            assert!(moved.has_instances_of(&scene, &Progress::new()).unwrap());
            let back: Vec<_> = every_third.iter().map(|&i| scene.instances()[i].world_from_mesh).collect();
            let back = moved.with_transforms(&every_third, &back, &Progress::new()).unwrap();
            assert_eq!((hash(&back), back.bounds()), (hash(&scene), scene.bounds()), "{name}");
        }
    }

    #[test]
    fn what_cannot_be_placed_is_told() {
        let scene = library::build("robots", 1, &[]).unwrap().scene;
        let (count, one) = (scene.instances().len(), DAffine3::IDENTITY);
        let far = DAffine3::from_translation(DVec3::splat(1e200));
        let broken = DAffine3::from_translation(DVec3::new(0.0, f64::NAN, 0.0));
        let cases: [(&[usize], &[DAffine3], &str); 5] = [
            (&[count], &[one], "indices[0]"),
            (&[1, 2, 1], &[one; 3], "indices[2]"),
            (&[0, 1], &[one], "matrices"),
            (&[0, 1], &[one, broken], "matrices[1]"),
            (&[0], &[far], "scene"),
        ];
        for (indices, maps, name) in cases {
            let error = scene.with_transforms(indices, maps, &Progress::new()).unwrap_err();
            assert!(error.to_string().starts_with(&format!("{name}: expected")), "{error}");
        }
        let other = library::build("forest", 1, &[]).unwrap().scene;
        assert!(!scene.has_instances_of(&other, &Progress::new()).unwrap());
    }
}
