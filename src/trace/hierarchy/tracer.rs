//! The scene made ready for rays: a hierarchy per mesh, shared by its instances, and one over the instances.
//!
//! Rays are f64, relative to the scene's origin, and are taken into each instance's frame (t stays the same), where
//! triangles are exactly the mesh's f32 vertices. An instance whose transform flattens has no inverse; its triangles
//! are baked into a mesh of their own.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::build::Item;
use super::frame::{Frame, power_of_two_near};
use super::refit::refitted_or_built;
use super::tree::{Box3, LEAF, Tree};
use super::triangles::Packet;
use crate::error::Result;
use crate::geometry::Aabb;
use crate::memory::check_room;
use crate::progress::Progress;
use crate::scene::{Mesh, Scene};

/// Answers questions about rays in a scene. Cheap to clone.
///
/// ```
/// use shadowlab::{Mesh, Progress, Scene, trace::Tracer};
/// let floor = Mesh::new(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]], &[[0, 1, 2]])?;
/// let tracer = Tracer::new(&Scene::from_mesh(floor)?, &Progress::new())?;
/// let hits = tracer.first_hit(&[[1.0, 2.0, 1.0]], &[[0.0, -1.0, 0.0]], &Progress::new())?;
/// assert_eq!((hits[0].t, hits[0].triangle, hits[0].instance), (2.0, 0, 0));
/// # Ok::<(), shadowlab::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tracer {
    pub(in crate::trace) inner: Arc<Inner>,
}

/// See [`Tracer`].
#[derive(Debug)]
pub struct Inner {
    pub scene: Scene,
    /// Shared with the scenes that this one was moved from.
    pub meshes: Vec<Arc<TracedMesh>>,
    pub placed: Vec<Placed>,
    /// Over the instances' boxes; none where there is one instance.
    pub top: Option<Tree>,
    /// What that tree cost when it was built, before it was refitted.
    built_cost: f64,
    /// Scale from the world to the top tree's frame, a power of two.
    pub top_per_world: f64,
    /// Bound on the distance between a computed and the exact point of a surface, from f64 rounding, world units.
    pub surface_error: f64,
    /// What single precision resolves in this scene, world units: see [`F32_ROUNDINGS`].
    pub resolution: f64,
}

/// A mesh with its hierarchy; packet i holds the triangles of leaf i.
#[derive(Debug)]
pub struct TracedMesh {
    pub mesh: Arc<Mesh>,
    pub tree: Tree,
    pub packets: Vec<Packet>,
    /// Whether its triangles have an alpha test.
    pub is_tested: bool,
    is_baked: bool,
}

/// An instance.
#[derive(Debug)]
pub struct Placed {
    /// Index into [`Inner::meshes`].
    pub mesh: u32,
    pub frame: Frame,
}

/// f64 roundings between a surface and a computed point on it: into the frame and back (8 each), relative to a vertex
/// (1), shear (2), edge functions (3), weighting (6), and the point on the ray (2); below 32.
const F64_ROUNDINGS: f64 = 32.0;
/// f32 roundings of a coordinate on the way through a single-precision tracer or renderer: vertex, ray origin,
/// direction times t, and their sum.
const F32_ROUNDINGS: f64 = 4.0;
/// Relative error of one rounding.
const F64_ROUNDING: f64 = f64::EPSILON / 2.0;
const F32_ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// What the hierarchy of a mesh takes per triangle while it is made: boxes of triangles, nodes and leaves; then packets.
const BYTES_PER_TRIANGLE: u64 = 90;
/// What an instance takes: its frame, and a box in the upper hierarchy.
const BYTES_PER_INSTANCE: u64 = 640;

impl Tracer {
    /// The hierarchies of a scene, built on all cores.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn new(scene: &Scene, progress: &Progress) -> Result<Self> {
        Self::after(None, scene, progress)
    }
    /// Those of a scene that differs from this one in the places of its instances, such as [`Scene::with_transforms`]
    /// makes. Answers are those of [`Tracer::new`], bit for bit.
    ///
    /// Hierarchies of meshes that both scenes hold are shared, and the one over the instances is refitted while that is
    /// good enough. Any scene will do; of one with other meshes or another number of instances more is built.
    ///
    /// # Errors
    /// As [`Tracer::new`].
    pub fn moved(&self, scene: &Scene, progress: &Progress) -> Result<Self> {
        Self::after(Some(&self.inner), scene, progress)
    }
    fn after(before: Option<&Inner>, scene: &Scene, progress: &Progress) -> Result<Self> {
        let origin = scene.origin();
        progress.set_total(scene.meshes().len() as u64 + 1);
        let known: HashMap<u64, &Arc<TracedMesh>> =
            before.iter().flat_map(|b| &b.meshes).filter(|m| !m.is_baked).map(|m| (m.mesh.id(), m)).collect();
        let unknown = scene.meshes().iter().filter(|mesh| !known.contains_key(&mesh.id()));
        let triangles: u64 = unknown.map(|mesh| mesh.triangles().len() as u64).sum();
        let bytes = BYTES_PER_TRIANGLE * triangles + BYTES_PER_INSTANCE * scene.instances().len() as u64;
        check_room("scene", bytes, || format!("{triangles} triangles in {} places", scene.instances().len()))?;
        let mut sources: Vec<(Arc<Mesh>, bool)> = Vec::new();
        let mut slot_of: HashMap<u32, u32> = HashMap::new();
        let mut placed = Vec::with_capacity(scene.instances().len());
        for (index, instance) in scene.instances().iter().enumerate() {
            let map = scene.world_from_local(index);
            let map = DAffine3 { matrix3: map.matrix3, translation: map.translation - origin };
            let (mesh, frame) = match Frame::new(map) {
                Some(frame) => {
                    let slot = *slot_of.entry(instance.mesh).or_insert_with(|| {
                        sources.push((scene.meshes()[instance.mesh as usize].clone(), false));
                        (sources.len() - 1) as u32
                    });
                    (slot, frame)
                }
                None => {
                    progress.check()?;
                    let (mesh, frame) = baked(scene.mesh_of(index), &map, progress)?;
                    sources.push((Arc::new(mesh), true));
                    ((sources.len() - 1) as u32, frame)
                }
            };
            placed.push(Placed { mesh, frame });
        }
        let meshes = sources
            .into_par_iter()
            .map(|(mesh, is_baked)| {
                progress.check()?;
                let traced = match known.get(&mesh.id()) {
                    Some(&traced) => Arc::clone(traced),
                    None => Arc::new(TracedMesh::new(mesh, is_baked, progress)?),
                };
                progress.advance(1);
                Ok(traced)
            })
            .collect::<Result<Vec<_>>>()?;
        progress.check()?;

        let half_extent = (0.5 * scene.bounds().max - 0.5 * scene.bounds().min).max_element();
        let reach = placed.iter().map(|p| p.frame.reach()).fold(half_extent, f64::max);
        let top_per_world = if reach > 0.0 { 0.5 / power_of_two_near(reach) } else { 1.0 };
        let top = (placed.len() > 1).then(|| {
            let item = |(id, p): (usize, &Placed)| {
                let local = &meshes[p.mesh as usize].tree.bounds;
                let local = Aabb { min: local.min.as_dvec3(), max: local.max.as_dvec3() };
                let world = local.transformed(&p.frame.world_from_local);
                let bounds = outward(&Aabb { min: world.min * top_per_world, max: world.max * top_per_world });
                Item::new(bounds, id as u32)
            };
            let items = placed.iter().enumerate().map(item).collect();
            refitted_or_built(items, before.and_then(|b| Some((b.top.as_ref()?, b.built_cost))), progress)
        });
        let (top, built_cost) = top.transpose()?.unzip();
        let built_cost = built_cost.unwrap_or_default();
        let surface_error = placed
            .iter()
            .map(|p| F64_ROUNDINGS * F64_ROUNDING * p.frame.reach().max(half_extent) * p.frame.condition())
            .fold(0.0, f64::max);
        let resolution = (F32_ROUNDINGS * F32_ROUNDING * half_extent).max(2.0 * surface_error);
        progress.advance(1);
        let scene = scene.clone();
        let inner = Inner { scene, meshes, placed, top, built_cost, top_per_world, surface_error, resolution };
        Ok(Self { inner: Arc::new(inner) })
    }
    /// Bytes held beside the scene.
    pub fn memory(&self) -> usize {
        let mesh = |m: &TracedMesh| {
            let baked = if m.is_baked { m.mesh.memory() } else { 0 };
            m.tree.memory() + m.packets.capacity() * size_of::<Packet>() + baked
        };
        self.inner.meshes.iter().map(|m| mesh(m)).sum::<usize>()
            + self.inner.meshes.capacity() * size_of::<TracedMesh>()
            + self.inner.placed.capacity() * size_of::<Placed>()
            + self.inner.top.as_ref().map_or(0, Tree::memory)
    }
}

impl TracedMesh {
    fn new(mesh: Arc<Mesh>, is_baked: bool, progress: &Progress) -> Result<Self> {
        let positions = mesh.positions_local();
        let item = |(id, triangle): (usize, &[u32; 3])| {
            Item::new(triangle.iter().fold(Box3::EMPTY, |b, &i| b.with_point(positions[i as usize])), id as u32)
        };
        let items: Vec<Item> = mesh.triangles().par_iter().enumerate().map(item).collect();
        progress.check()?;
        let mut tree = Tree::build::<LEAF>(items, progress)?;
        let packets = tree.leaves.par_iter().map(|&leaf| Packet::new(&mesh, leaf)).collect();
        progress.check()?;
        // The packets hold them.
        tree.leaves = Vec::new();
        Ok(Self { is_tested: mesh.alpha_test().is_some(), mesh, tree, packets, is_baked })
    }
}

impl Inner {
    /// The corners of a triangle in the world, relative to the scene's origin.
    pub fn corners(&self, instance: u32, triangle: u32) -> [DVec3; 3] {
        let placed = &self.placed[instance as usize];
        let mesh = &self.meshes[placed.mesh as usize].mesh;
        mesh.triangles()[triangle as usize]
            .map(|i| placed.frame.world_from_local.transform_point3(mesh.positions_local()[i as usize].as_dvec3()))
    }
}

/// The mesh with an instance's transform in its vertices.
fn baked(mesh: &Mesh, map: &DAffine3, progress: &Progress) -> Result<(Mesh, Frame)> {
    let vertices: Vec<[f64; 3]> =
        mesh.positions_local().iter().map(|p| map.transform_point3(p.as_dvec3()).to_array()).collect();
    let faces: Vec<[i64; 3]> = mesh.triangles().iter().map(|t| t.map(i64::from)).collect();
    let mesh = Mesh::watched(&vertices, &faces, mesh.alpha_test().cloned(), progress)?;
    let frame = Frame::new(*mesh.mesh_from_local());
    // A mesh's own frame is a power of two and a translation, which always has an inverse.
    Ok((mesh, frame.unwrap_or(IDENTITY)))
}

const IDENTITY: Frame = Frame {
    world_from_local: DAffine3::IDENTITY,
    local_from_world: DAffine3::IDENTITY,
    local_per_world: 1.0,
    world_per_local: 1.0,
};

/// The box rounded to f32, never inward.
fn outward(b: &Aabb) -> Box3 {
    let down = |v: DVec3| Vec3::from_array(v.to_array().map(|x| (x as f32).next_down()));
    let up = |v: DVec3| Vec3::from_array(v.to_array().map(|x| (x as f32).next_up()));
    Box3 { min: down(b.min), max: up(b.max) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::library;

    #[test]
    fn hierarchies_of_meshes_are_shared_with_the_moved_scene() {
        let scene = library::build("robots", 1, &[]).unwrap().scene;
        let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
        let lifted = DAffine3::from_translation(DVec3::Y) * scene.instances()[1].world_from_mesh;
        let flat = scene.instances()[2].world_from_mesh * DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        for (index, map, more) in [(1, lifted, 0), (2, flat, 1)] {
            let moved = scene.with_transforms(&[index], &[map], &Progress::new()).unwrap();
            let after = tracer.moved(&moved, &Progress::new()).unwrap();
            let known = |m: &&Arc<TracedMesh>| tracer.inner.meshes.iter().any(|other| Arc::ptr_eq(m, other));
            let shared = after.inner.meshes.iter().filter(known).count();
            // Only what is baked is a mesh of its own.
            assert_eq!(after.inner.meshes.len() - shared, more);
            assert!(shared + more >= tracer.inner.meshes.len());
        }
    }
}
