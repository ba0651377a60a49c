//! A placed mesh on its way into an image.

use glam::DMat4;

use super::projection::Projection;
use super::simd::LANES;
use crate::render::Volume;
use crate::render::cpu::faces::{FaceTest, Faces};
use crate::render::cpu::kept::Kept;
use crate::scene::Mesh;

/// One placed mesh of a batch.
#[derive(Debug, Clone)]
pub struct Draw<'a> {
    pub mesh: &'a Mesh,
    /// Which of its triangles are looked at.
    pub kept: Kept<'a>,
    pub projection: Projection,
    /// Which of its faces are drawn.
    pub faces: FaceTest,
    /// Where its vertices start in the batch.
    pub first_vertex: u32,
    /// The scene-wide number of its first triangle, instances counted each time.
    pub first_id: u32,
}

impl<'a> Draw<'a> {
    /// The first of a batch, under a matrix that takes the mesh to clip space.
    pub fn new(mesh: &'a Mesh, clip_from_local: &DMat4, volume: &Volume, faces: Faces, first_id: u32) -> Self {
        Self {
            mesh,
            kept: Kept::new(mesh, clip_from_local, volume),
            projection: Projection::new(clip_from_local, mesh.bounds_local()),
            faces: FaceTest::new(faces, clip_from_local),
            first_vertex: 0,
            first_id,
        }
    }

    /// The scene-wide numbers of some triangles from a place on, the last one again where there are fewer than [`LANES`].
    #[inline(always)]
    pub fn numbers(&self, first: u32, count: u32) -> [u32; LANES] {
        std::array::from_fn(|l| self.first_id + self.kept.number(first + (l as u32).min(count - 1)))
    }
}
