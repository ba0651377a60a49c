//! Scenes on the device: geometry uploaded once, kept until room is needed.
//!
//! Meshes that are drawn together share a vertex and an index buffer (a *group*), so that one draw an instanced mesh needs
//! no change of buffers and a shader can reach any triangle of the group. A group holds as many meshes as a storage binding
//! of the device can show; nearly always it holds all. Groups are found by the ids of their meshes: scenes that differ
//! in transforms alone share them, and a scene that was dropped costs nothing but room.

use std::sync::Arc;

use wgpu::{Buffer, BufferUsages};

use super::alpha_tests::{DeviceTest, Levels, levels_bytes};
use super::device::Gpu;
use crate::error::Result;
use crate::progress::Progress;
use crate::scene::{Mesh, Scene};

/// Device memory that geometry nobody draws at the moment may take. Chosen to hold a hundred million triangles' worth of
/// sweeps over a few scenes without crowding out the maps.
const IDLE_BYTES: u64 = 1 << 30;

/// Bytes of a vertex: three f32. Also those of a triangle: three u32.
pub(super) const RECORD: u64 = 12;

/// The vertices and triangles of some meshes on the device.
pub(super) struct Geometry {
    /// `p_local`, mesh after mesh.
    pub vertices: Buffer,
    /// Indices into the vertices of their own mesh, mesh after mesh.
    pub indices: Buffer,
    /// Of the meshes that have alpha tests.
    pub tests: Vec<DeviceTest>,
}

/// Where a mesh lies in its group.
#[derive(Clone, Copy, Default)]
pub(super) struct MeshSlot {
    pub group: u32,
    pub first_vertex: u32,
    pub first_index: u32,
    pub index_count: u32,
    /// Index into [`Geometry::tests`].
    pub test: Option<u32>,
}

/// A scene ready to be drawn.
pub(super) struct DeviceScene {
    pub groups: Vec<Arc<Geometry>>,
    /// One a mesh of the scene; without meaning for meshes that no instance uses.
    pub meshes: Vec<MeshSlot>,
}

impl DeviceScene {
    /// A mesh that has an alpha test: where it lies, and what it consists of.
    pub fn tested(&self, mesh: u32) -> (MeshSlot, &Geometry, &DeviceTest) {
        let slot = self.meshes[mesh as usize];
        let geometry = &self.groups[slot.group as usize];
        (slot, geometry, &geometry.tests[slot.test.unwrap_or_default() as usize])
    }
}

/// The scenes and groups used last.
#[derive(Default)]
pub(super) struct SceneCache {
    /// Oldest first.
    scenes: Vec<(u64, Arc<DeviceScene>)>,
    groups: Vec<Group>,
}

struct Group {
    meshes: Vec<u64>,
    bytes: u64,
    geometry: Arc<Geometry>,
}

/// Scenes whose meshes' places are remembered; a matter of a few bytes a mesh.
const SCENES: usize = 16;

impl SceneCache {
    /// The scene on the device, uploaded if it is not there yet.
    pub fn get(&mut self, gpu: &Gpu, scene: &Scene, progress: &Progress) -> Result<Arc<DeviceScene>> {
        let found = match self.scenes.iter().position(|(id, _)| *id == scene.id()) {
            Some(at) => self.scenes.remove(at).1,
            None => Arc::new(self.build(gpu, scene, progress)?),
        };
        self.scenes.push((scene.id(), found.clone()));
        if self.scenes.len() > SCENES {
            self.scenes.remove(0);
        }
        Ok(found)
    }

    fn build(&mut self, gpu: &Gpu, scene: &Scene, progress: &Progress) -> Result<DeviceScene> {
        let mut used = vec![false; scene.meshes().len()];
        scene.instances().iter().for_each(|i| used[i.mesh as usize] = true);
        let mut meshes = vec![MeshSlot::default(); used.len()];
        let mut members: Vec<Vec<usize>> = Vec::new();
        let (mut vertices, mut triangles, mut tests) = (0, 0, 0);
        for index in (0..used.len()).filter(|&i| used[i]) {
            let mesh = &scene.meshes()[index];
            let (v, t) = (mesh.positions_local().len() as u64, mesh.triangles().len() as u64);
            gpu.check_buffer("the vertices of a mesh (bytes)", v * RECORD)?;
            gpu.check_buffer("the triangles of a mesh (bytes)", t * RECORD)?;
            let most = binding_bytes(gpu) / RECORD;
            if members.is_empty() || vertices + v > most || triangles + t > most {
                members.push(Vec::new());
                (vertices, triangles, tests) = (0, 0, 0);
            }
            let test = mesh.alpha_test().map(|_| tests);
            tests += u32::from(test.is_some());
            meshes[index] = MeshSlot {
                group: members.len() as u32 - 1,
                first_vertex: vertices as u32,
                first_index: 3 * triangles as u32,
                index_count: 3 * t as u32,
                test,
            };
            (vertices, triangles) = (vertices + v, triangles + t);
            members.last_mut().expect("pushed above").push(index);
        }
        let mut groups = Vec::with_capacity(members.len());
        for members in &members {
            progress.check()?;
            let members: Vec<&Mesh> = members.iter().map(|&m| &*scene.meshes()[m]).collect();
            groups.push(self.group(gpu, &members)?);
        }
        Ok(DeviceScene { groups, meshes })
    }

    fn group(&mut self, gpu: &Gpu, meshes: &[&Mesh]) -> Result<Arc<Geometry>> {
        let ids: Vec<u64> = meshes.iter().map(|m| m.id()).collect();
        let group = match self.groups.iter().position(|g| g.meshes == ids) {
            Some(at) => self.groups.remove(at),
            None => {
                let (geometry, bytes) = upload(gpu, meshes)?;
                let geometry = Arc::new(geometry);
                self.make_room(bytes);
                Group { meshes: ids, bytes, geometry }
            }
        };
        let geometry = group.geometry.clone();
        self.groups.push(group);
        Ok(geometry)
    }

    /// Forgets the groups used least recently until what is left fits beside `bytes` more.
    fn make_room(&mut self, bytes: u64) {
        let mut total = self.bytes() + bytes;
        while total > IDLE_BYTES && !self.groups.is_empty() {
            let gone = self.groups.remove(0);
            total -= gone.bytes;
            // Scenes hold their groups; one that lost a group is looked up anew.
            self.scenes.retain(|(_, scene)| !scene.groups.iter().any(|g| Arc::ptr_eq(g, &gone.geometry)));
        }
    }

    /// Bytes of geometry on the device.
    pub fn bytes(&self) -> u64 {
        self.groups.iter().map(|g| g.bytes).sum()
    }
}

/// Bytes that a group's buffers may have, so that a shader can bind each of them whole and index it with 32 bits.
fn binding_bytes(gpu: &Gpu) -> u64 {
    let most = gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size);
    most.min(u64::from(u32::MAX))
}

/// The geometry of meshes on the device, and its bytes.
fn upload(gpu: &Gpu, meshes: &[&Mesh]) -> Result<(Geometry, u64)> {
    let vertices: Vec<&[u8]> = meshes.iter().map(|m| bytemuck::cast_slice(m.positions_local())).collect();
    let indices: Vec<&[u8]> = meshes.iter().map(|m| bytemuck::cast_slice(m.triangles())).collect();
    let vertices = gpu.filled("vertices", BufferUsages::VERTEX | BufferUsages::STORAGE, &vertices)?;
    let indices = gpu.filled("indices", BufferUsages::INDEX | BufferUsages::STORAGE, &indices)?;
    let mut levels = Levels::new();
    let tests = meshes.iter().filter_map(|m| m.alpha_test());
    let tests: Vec<DeviceTest> = tests.map(|test| DeviceTest::new(gpu, test, &mut levels)).collect::<Result<_>>()?;
    let bytes = vertices.size() + indices.size() + levels_bytes(&levels);
    let bytes = bytes + tests.iter().map(DeviceTest::bytes).sum::<u64>();
    Ok((Geometry { vertices, indices, tests }, bytes))
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use wgpu::Features;

    use super::super::device::tests::opened;
    use super::*;
    use crate::scene::library;

    #[test]
    fn a_moved_scene_is_drawn_from_the_buffers_that_are_there() {
        let Some(gpu) = opened(Features::empty()) else { return };
        let (mut cache, progress) = (SceneCache::default(), Progress::new());
        let mut scene = library::build("forest", 1, &[]).unwrap().scene;
        let first = cache.get(&gpu, &scene, &progress).unwrap();
        let bytes = cache.bytes();
        let mut map = scene.instances()[3].world_from_mesh;
        // More scenes than are remembered.
        for _ in 0..2 * SCENES {
            map = DAffine3::from_translation(DVec3::new(0.1, 0.0, 0.2)) * map;
            scene = scene.with_transforms(&[3], &[map], &progress).unwrap();
            let moved = cache.get(&gpu, &scene, &progress).unwrap();
            assert_eq!(moved.groups.len(), first.groups.len());
            assert!(moved.groups.iter().zip(&first.groups).all(|(a, b)| Arc::ptr_eq(a, b)));
        }
        assert_eq!(cache.bytes(), bytes);
    }
}
