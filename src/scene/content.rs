//! What a scene is made of as one number: scenes of equal content have equal hashes.
//!
//! Content is what pictures depend on: the stored vertices and triangles of every mesh, the frame that places them, the rows
//! of the caller's face array that triangles come from, the order of meshes, and the instances in their order. Numbers count
//! by their value, so 0 and -0 are one.

use super::{Mesh, Scene};
use crate::digest::{Digest, Numbers};

/// Beginnings of the hashes; the number changes with what goes in.
const MESH: &str = "shadowlab mesh 1";
const SCENE: &str = "shadowlab scene 1";

/// The hash of a mesh.
pub(super) fn of_mesh(mesh: &Mesh) -> [u8; 32] {
    let mut digest = Digest::new(MESH, Numbers::Equal);
    digest.list(&mesh.mesh_from_local().to_cols_array());
    digest.list(bytemuck::cast_slice::<_, f32>(mesh.positions_local()));
    digest.list(mesh.triangles().as_flattened());
    digest.count(mesh.dropped_faces());
    digest.list(mesh.source_faces());
    digest.finish()
}

/// The hash of a scene: of the hashes of its meshes and its instances.
pub(super) fn of_scene(scene: &Scene) -> [u8; 32] {
    let mut digest = Digest::new(SCENE, Numbers::Equal);
    digest.count(scene.meshes().len());
    for mesh in scene.meshes() {
        digest.list(&mesh.content_hash());
    }
    digest.list(&scene.instances().iter().map(|i| i.mesh).collect::<Vec<_>>());
    digest.list(&scene.instances().iter().flat_map(|i| i.world_from_mesh.to_cols_array()).collect::<Vec<_>>());
    digest.finish()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DVec3};

    use super::super::{Instance, Mesh, Scene};

    const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    const FACES: [[i64; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn mesh(points: &[[f64; 3]], faces: &[[i64; 3]]) -> Arc<Mesh> {
        Arc::new(Mesh::new(points, faces).unwrap())
    }
    fn scene(meshes: &[&Arc<Mesh>], places: &[(u32, f64)]) -> Scene {
        let place = |&(mesh, x): &(u32, f64)| Instance {
            mesh,
            world_from_mesh: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
        };
        Scene::new(meshes.iter().map(|m| Arc::clone(m)).collect(), places.iter().map(place).collect()).unwrap()
    }

    #[test]
    fn equal_content_has_one_hash() {
        let (a, b) = (mesh(&POINTS, &FACES), mesh(&POINTS, &FACES));
        assert_ne!(a.id(), b.id());
        assert_eq!(a.content_hash(), b.content_hash());
        let one = scene(&[&a], &[(0, 0.0), (0, 1.0)]);
        assert_eq!(one.content_hash(), scene(&[&b], &[(0, -0.0), (0, 1.0)]).content_hash());
        assert_eq!(one.content_hash(), one.clone().content_hash());
    }

    #[test]
    fn every_change_of_content_changes_the_hash() {
        let a = mesh(&POINTS, &FACES);
        let mut moved = POINTS;
        moved[1][0] = 1.5;
        let b = mesh(&moved, &FACES);
        let turned = mesh(&POINTS, &[[0, 2, 1], [0, 2, 3]]);
        let mut broken = POINTS.to_vec();
        broken.push([f64::NAN; 3]);
        let dropped = mesh(&broken, &[[0, 1, 2], [0, 1, 4], [0, 2, 3]]);
        let dropped_later = mesh(&broken, &[[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
        let variants = [
            scene(&[&a], &[(0, 0.0)]),
            scene(&[&a], &[(0, 1.0)]),
            scene(&[&a], &[(0, 0.0), (0, 1.0)]),
            scene(&[&a], &[(0, 1.0), (0, 0.0)]),
            scene(&[&a, &a], &[(0, 0.0), (1, 1.0)]),
            scene(&[&a, &b], &[(0, 0.0), (1, 1.0)]),
            scene(&[&b, &a], &[(0, 0.0), (1, 1.0)]),
            scene(&[&b, &a], &[(1, 0.0), (0, 1.0)]),
            scene(&[&turned], &[(0, 0.0)]),
            scene(&[&dropped], &[(0, 0.0)]),
            scene(&[&dropped_later], &[(0, 0.0)]),
        ];
        for (i, one) in variants.iter().enumerate() {
            for other in &variants[..i] {
                assert_ne!(one.content_hash(), other.content_hash(), "{i}");
            }
        }
    }
}
