//! Meshes and placements on their way to a scene.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::builder::Shape;
use crate::error::Result;
use crate::memory::with_room;
use crate::progress::Progress;
use crate::scene::{Instance, Mesh, Scene};

/// A mesh that was added to an assembly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part(u32);

/// A scene under construction.
#[derive(Debug)]
pub(super) struct Assembly<'p> {
    meshes: Vec<Arc<Mesh>>,
    instances: Vec<Instance>,
    progress: &'p Progress,
}

impl<'p> Assembly<'p> {
    /// An empty one.
    pub(super) fn new(progress: &'p Progress) -> Self {
        Self { meshes: Vec::new(), instances: Vec::new(), progress }
    }
    /// An empty one with room for so many placements.
    pub(super) fn with_places(count: usize, progress: &'p Progress) -> Result<Self> {
        Ok(Self { instances: with_room("instances", count)?, ..Self::new(progress) })
    }
    /// An error where somebody wants the work to stop; asked for every mesh, and by loops that place many.
    pub(super) fn check(&self) -> Result<()> {
        self.progress.check()
    }
    /// Stores a mesh, to be placed any number of times.
    pub(super) fn part(&mut self, shape: &Shape) -> Result<Part> {
        self.check()?;
        self.meshes.push(Arc::new(shape.mesh()?));
        Ok(Part(self.meshes.len() as u32 - 1))
    }
    /// Places a part.
    pub(super) fn place(&mut self, part: Part, world_from_mesh: DAffine3) {
        self.instances.push(Instance { mesh: part.0, world_from_mesh });
    }
    /// Places parts in their order, as they are found in parallel.
    pub(super) fn place_all(&mut self, placed: impl IndexedParallelIterator<Item = (Part, DAffine3)>) {
        self.instances.par_extend(placed.map(|(part, world_from_mesh)| Instance { mesh: part.0, world_from_mesh }));
    }
    /// Places a part upright at a point, unturned.
    pub(super) fn place_at(&mut self, part: Part, x: f64, y: f64, z: f64) {
        self.place(part, DAffine3::from_translation(DVec3::new(x, y, z)));
    }
    /// Stores a shape that occurs once, at its own place.
    pub(super) fn fixed(&mut self, shape: &Shape) -> Result<()> {
        let part = self.part(shape)?;
        self.place(part, DAffine3::IDENTITY);
        Ok(())
    }
    /// The scene.
    pub(super) fn scene(self) -> Result<Scene> {
        Scene::watched(self.meshes, self.instances, self.progress)
    }
}

/// Upright placement: the mesh's x axis comes to point along `heading` (x and z of the world, unit length), scaled
/// uniformly.
pub(super) fn standing(at: DVec3, heading: DVec2, scale: f64) -> DAffine3 {
    let x = DVec3::new(heading.x, 0.0, heading.y);
    DAffine3::from_mat3_translation(DMat3::from_cols(x, DVec3::Y, x.cross(DVec3::Y)) * scale, at)
}

/// Upright placement turned by an angle about y (counter-clockwise from above, radians).
pub(super) fn turned(at: DVec3, angle: f64) -> DAffine3 {
    DAffine3::from_rotation_translation(DQuat::from_rotation_y(angle), at)
}
