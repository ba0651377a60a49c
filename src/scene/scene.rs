//! Meshes placed by instances.

use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DMat4, DVec3};
use rayon::prelude::*;

use super::Mesh;
use super::instance_bounds::{Hull, bounds_of};
use super::instance_tree::{InstanceTree, Met};
use super::mesh::next_id;
use crate::digest::{Digest, Numbers};
use crate::error::{Error, Result};
use crate::geometry::{Aabb, OrientedBox};
use crate::memory::with_room;
use crate::progress::Progress;

/// What the hash of a scene begins with; the number changes with what goes in.
const CONTENT: &str = "shadowlab scene 1";

/// Instances between two looks at whether to go on: some milliseconds of work.
const AT_ONCE: usize = 1 << 17;

/// Instances up to which a walk over the hierarchy costs as much as one over all of them.
const FEW: usize = 32;

/// One placement of a mesh. Any invertible or flattening affine map: mirrored, sheared, scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// From the mesh's frame to the world.
    pub world_from_mesh: DAffine3,
}

/// Meshes and their instances. Immutable, cheap to clone.
#[derive(Debug, Clone)]
pub struct Scene {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    id: u64,
    meshes: Vec<Arc<Mesh>>,
    instances: Vec<Instance>,
    /// The scene-wide number of each instance's first triangle.
    first_triangles: Vec<u64>,
    tree: InstanceTree,
    bounds: Aabb,
    triangle_count: u64,
    content_hash: OnceLock<[u8; 32]>,
}

impl Scene {
    /// A scene from meshes and their placements.
    ///
    /// # Errors
    /// [`Error::EmptyScene`] without instances; [`Error::InvalidArgument`] for a transform that is not finite, takes the
    /// mesh out of the range of f64, or an instance of a mesh that does not exist.
    pub fn new(meshes: Vec<Arc<Mesh>>, instances: Vec<Instance>) -> Result<Self> {
        Self::watched(meshes, instances, &Progress::new())
    }
    /// The same, stopped where `progress` says so.
    ///
    /// # Errors
    /// As [`Scene::new`], and [`Error::Interrupted`].
    pub fn watched(meshes: Vec<Arc<Mesh>>, instances: Vec<Instance>, progress: &Progress) -> Result<Self> {
        if instances.is_empty() {
            return Err(Error::EmptyScene { reason: "no instance of any mesh".into() });
        }
        let wrong = |i: &Instance| i.mesh as usize >= meshes.len() || !i.world_from_mesh.is_finite();
        if let Some(i) = instances.par_iter().position_first(wrong) {
            let mesh = instances[i].mesh;
            if mesh as usize >= meshes.len() {
                return Err(Error::argument(
                    format!("instances[{i}].mesh"),
                    format!("an index below {}", meshes.len()),
                    mesh,
                    "add the mesh first",
                ));
            }
            return Err(Error::argument(
                format!("instances[{i}].transform"),
                "16 finite numbers",
                "a NaN or an infinity",
                "check the scene graph",
            ));
        }
        let placed = |i: usize| (&*meshes[instances[i].mesh as usize], placed(&meshes, &instances[i]));
        let mut hulls: Vec<Hull> = with_room("instances", instances.len())?;
        let hull = |i: usize| {
            let (mesh, world_from_local) = placed(i);
            Hull::new(mesh, &world_from_local)
        };
        for first in (0..instances.len()).step_by(AT_ONCE) {
            progress.check()?;
            hulls.par_extend((first..instances.len().min(first + AT_ONCE)).into_par_iter().map(hull));
        }
        let bounds = bounds_of(&hulls, placed, progress)?;
        // A map that overflows gives infinite bounds; every later step divides by the extent.
        if !(bounds.extent().is_finite() && bounds.extent().length_squared().is_finite()) {
            return Err(Error::argument(
                "scene",
                "coordinates whose squares fit into 64-bit floats",
                format!("bounds from {} to {}", bounds.min, bounds.max),
                "scale the scene down",
            ));
        }
        let tree = InstanceTree::new(&hulls, |hull| &hull.bounds, progress)?;
        drop(hulls);
        let mut first_triangles: Vec<u64> = with_room("instances", instances.len())?;
        let mut triangle_count = 0;
        first_triangles.extend(instances.iter().map(|i| {
            let first = triangle_count;
            triangle_count += meshes[i.mesh as usize].triangles().len() as u64;
            first
        }));
        Ok(Self {
            inner: Arc::new(Inner {
                id: next_id(),
                meshes,
                instances,
                first_triangles,
                tree,
                bounds,
                triangle_count,
                content_hash: OnceLock::new(),
            }),
        })
    }
    /// A scene of one mesh at its own place.
    pub fn from_mesh(mesh: Mesh) -> Result<Self> {
        Self::new(vec![Arc::new(mesh)], vec![Instance { mesh: 0, world_from_mesh: DAffine3::IDENTITY }])
    }
    /// Both scenes in one; meshes stay shared.
    pub fn joined(&self, other: &Self) -> Result<Self> {
        self.joined_watched(other, &Progress::new())
    }
    /// The same, stopped where `progress` says so.
    ///
    /// # Errors
    /// As [`Scene::watched`].
    pub fn joined_watched(&self, other: &Self, progress: &Progress) -> Result<Self> {
        let offset = self.meshes().len() as u32;
        let meshes = self.meshes().iter().chain(other.meshes()).cloned().collect();
        let mut instances = with_room("instances", self.instances().len() + other.instances().len())?;
        instances.extend_from_slice(self.instances());
        progress.check()?;
        instances.extend(other.instances().iter().map(|i| Instance { mesh: i.mesh + offset, ..*i }));
        Self::watched(meshes, instances, progress)
    }
    /// The whole scene moved by an affine map of the world.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        let moved = self.instances().iter().map(|i| Instance { world_from_mesh: *map * i.world_from_mesh, ..*i });
        Self::new(self.meshes().to_vec(), moved.collect())
    }
    /// A number no other scene of this process has; caches key on it.
    pub fn id(&self) -> u64 {
        self.inner.id
    }
    /// A hash of all that pictures depend on, the same in every process; found at the first call: of the meshes, their
    /// order, and the instances with their order. Numbers count by their value, so 0 and -0 are one.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn content_hash(&self, progress: &Progress) -> Result<[u8; 32]> {
        // Not `get_or_init`: a process that is forked while another thread hashes would wait for that thread for ever.
        let kept = &self.inner.content_hash;
        if let Some(hash) = kept.get() {
            return Ok(*hash);
        }
        let hash = self.hashed(progress)?;
        let _ = kept.set(hash); // by another thread it is the same
        Ok(hash)
    }
    /// The hash, where it has been found.
    pub fn known_hash(&self) -> Option<[u8; 32]> {
        self.inner.content_hash.get().copied()
    }
    fn hashed(&self, progress: &Progress) -> Result<[u8; 32]> {
        let mut digest = Digest::new(CONTENT, Numbers::Equal);
        digest.count(self.meshes().len());
        for mesh in self.meshes() {
            digest.list(&mesh.content_hash(progress)?);
        }
        let columns: Vec<_> = self.instances().iter().flat_map(|i| i.world_from_mesh.to_cols_array()).collect();
        digest.watched_list(&self.instances().iter().map(|i| i.mesh).collect::<Vec<_>>(), || progress.check())?;
        digest.watched_list(&columns, || progress.check())?;
        Ok(digest.finish())
    }
    /// Whether both are one object.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner)
    }
    /// The meshes, each stored once.
    pub fn meshes(&self) -> &[Arc<Mesh>] {
        &self.inner.meshes
    }
    /// The placements.
    pub fn instances(&self) -> &[Instance] {
        &self.inner.instances
    }
    /// From an instance's mesh-local f32 frame to the world.
    pub fn world_from_local(&self, instance: usize) -> DAffine3 {
        placed(&self.inner.meshes, &self.inner.instances[instance])
    }
    /// The hierarchy over the instances.
    pub fn tree(&self) -> &InstanceTree {
        &self.inner.tree
    }
    /// Meets groups of instances and instances as [`InstanceTree::visit`] does, or, where there are few, the instances in
    /// their order.
    pub fn visit(&self, mut meet: impl FnMut(Met) -> ControlFlow<(), bool>) -> ControlFlow<()> {
        if self.instances().len() > FEW {
            return self.inner.tree.visit(meet);
        }
        for i in 0..self.instances().len() {
            meet(Met::One(i))?;
        }
        ControlFlow::Continue(())
    }
    /// The scene-wide number of each instance's first triangle, instances counted each time.
    pub fn first_triangles(&self) -> &[u64] {
        &self.inner.first_triangles
    }
    /// The box of an instance's mesh, placed, relative to `origin`.
    pub fn box_of(&self, instance: usize, origin: DVec3) -> OrientedBox {
        OrientedBox::new(self.mesh_of(instance).bounds_local(), &self.world_from_local(instance), origin)
    }
    /// The corners of a triangle of an instance, world, in the order of its mesh.
    pub fn corners(&self, instance: usize, triangle: usize) -> [DVec3; 3] {
        let (mesh, to_world) = (self.mesh_of(instance), self.world_from_local(instance));
        mesh.triangles()[triangle].map(|k| to_world.transform_point3(mesh.positions_local()[k as usize].as_dvec3()))
    }
    /// The mesh of an instance.
    pub fn mesh_of(&self, instance: usize) -> &Mesh {
        &self.inner.meshes[self.inner.instances[instance].mesh as usize]
    }
    /// The world box of all vertices that triangles use.
    pub fn bounds(&self) -> &Aabb {
        &self.inner.bounds
    }
    /// The point positions are told relative to in single precision: the middle of the bounds.
    pub fn origin(&self) -> DVec3 {
        self.inner.bounds.center()
    }
    /// Triangles, instances counted each time.
    pub fn triangle_count(&self) -> u64 {
        self.inner.triangle_count
    }
    /// `clip_from_world` taken to an instance's local f32 frame; the product is formed in f64, so the world's
    /// translation cancels before anything is rounded.
    pub fn clip_from_local(&self, clip_from_world: &DMat4, instance: usize) -> DMat4 {
        *clip_from_world * DMat4::from(self.world_from_local(instance))
    }
}

/// From the local frame of an instance's mesh to the world. Not stored: it takes fewer operations than any use of it, and a
/// million of them 96 MB.
fn placed(meshes: &[Arc<Mesh>], instance: &Instance) -> DAffine3 {
    instance.world_from_mesh * *meshes[instance.mesh as usize].mesh_from_local()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(a.content_hash(&Progress::new()).unwrap(), b.content_hash(&Progress::new()).unwrap());
        let one = scene(&[&a], &[(0, 0.0), (0, 1.0)]);
        assert_eq!(
            one.content_hash(&Progress::new()).unwrap(),
            scene(&[&b], &[(0, -0.0), (0, 1.0)]).content_hash(&Progress::new()).unwrap()
        );
        assert_eq!(one.content_hash(&Progress::new()).unwrap(), one.clone().content_hash(&Progress::new()).unwrap());
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
                assert_ne!(
                    one.content_hash(&Progress::new()).unwrap(),
                    other.content_hash(&Progress::new()).unwrap(),
                    "{i}"
                );
            }
        }
    }
}
