//! Four triangles side by side, as the SIMD test wants them.

use glam::Vec3;

use super::tree::{LEAF, NO_ITEM};
use crate::scene::Mesh;

/// A triangle of an instance: both indices.
pub type Face = (u32, u32);

/// Four triangles of a mesh: `vertices[vertex][axis][lane]` in the mesh's local frame, exactly its f32 positions.
///
/// Unused lanes repeat a vertex of the first triangle: a point, which no ray meets.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Packet {
    pub vertices: [[[f32; LEAF]; 3]; 3],
    pub triangles: [u32; LEAF],
}

impl Packet {
    pub fn new(mesh: &Mesh, triangles: [u32; LEAF]) -> Self {
        let mut vertices = [[[0.0; LEAF]; 3]; 3];
        for (lane, &triangle) in triangles.iter().enumerate() {
            let used = if triangle == NO_ITEM { triangles[0] } else { triangle };
            let indices = mesh.triangles()[used as usize];
            for (vertex, &index) in indices.iter().enumerate() {
                let index = if triangle == NO_ITEM { indices[0] } else { index };
                let p: Vec3 = mesh.positions_local()[index as usize];
                for axis in 0..3 {
                    vertices[vertex][axis][lane] = p[axis];
                }
            }
        }
        Self { vertices, triangles }
    }
    /// Bits of the lanes in use.
    #[inline(always)]
    pub fn used(&self) -> u32 {
        (0..LEAF).fold(0, |bits, lane| bits | (u32::from(self.triangles[lane] != NO_ITEM) << lane))
    }
}
