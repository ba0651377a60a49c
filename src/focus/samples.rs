//! What a camera sees, as points: for techniques that look at the receivers themselves.
//!
//! Plain data made by whoever has a renderer, so that techniques stay pure functions. Source: Lauritzen, Salvi, Lefohn 2010
//! (sample distribution shadow maps); theory.md 10.

use glam::DVec3;

use crate::image::GBuffer;

/// Visible surface points with their normals, world space, both in the order of the pixels they were seen in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReceiverSamples {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Unit normals, on the side of the eye.
    pub normals: Vec<DVec3>,
}

impl ReceiverSamples {
    /// One sample a pixel that shows anything.
    pub fn from_gbuffer(gbuffer: &GBuffer) -> Self {
        let seen = (0..gbuffer.triangle.len()).filter(|&i| gbuffer.triangle[i] >= 0);
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (points, normals) =
            seen.map(|i| (gbuffer.origin + vector(gbuffer.position[i]), vector(gbuffer.normal[i]))).unzip();
        Self { points, normals }
    }
}
