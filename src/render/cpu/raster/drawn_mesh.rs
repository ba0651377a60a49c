//! A placed mesh on its way into an image.

use super::vertices::Projection;
use crate::render::cpu::faces::FaceTest;
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
