//! Which faces of meshes are drawn: all, or those that face away from the light.
//!
//! Source: theory.md 0: a map keeps the winding that the light sees where its determinant is negative (NDC is left-handed). So
//! the sign of `clip_from_local` counts a mirrored map and a mirrored instance at once: outside is where a mesh's own
//! winding says, however it is placed.

use glam::{DMat4, DVec3};

/// Which faces are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Faces {
    /// Both sides.
    All,
    /// Those whose outer side is averted from the light.
    Averted,
}

/// Tells the faces of one placed mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceTest {
    /// The sign of the turn of corners that show their outer side; nothing where all faces are drawn.
    outer: Option<f64>,
}

impl FaceTest {
    /// Of a mesh that a matrix takes to clip space.
    pub fn new(faces: Faces, clip_from_local: &DMat4) -> Self {
        // A flattened mesh is its own mirror image.
        let outer = || if clip_from_local.determinant() > 0.0 { -1.0 } else { 1.0 };
        Self { outer: (faces == Faces::Averted).then(outer) }
    }
    /// Whether all faces are drawn.
    #[inline(always)]
    pub fn takes_all(self) -> bool {
        self.outer.is_none()
    }
    /// Whether a triangle is drawn, by the clip coordinates of its corners.
    pub fn takes(self, corners: [[f64; 4]; 3]) -> bool {
        let Some(outer) = self.outer else { return true };
        let [a, b, c] = corners.map(|[x, y, _, w]| DVec3::new(x, y, w));
        // Differences first: the corners of a small triangle are nearly parallel.
        a.dot((b - a).cross(c - a)) * outer < 0.0
    }
}
