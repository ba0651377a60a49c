//! A viewport larger than the image, so that triangles that cross the image's border are not cut there.
//!
//! Cutting makes new vertices, rounds them to the sub-pixel grid and lays new planes of depth through them: on a software
//! device, which cuts at the viewport's border, slivers across the border of a 512 x 512 map came out wrong by 2e-5 in depth.
//! The viewport is a power of two times the image, about its middle, and the matrices are divided by as much: positions in
//! the image are the same bit by bit, and the border where triangles are cut is out of sight.

use glam::{DMat4, DVec3};
use wgpu::RenderPass;

use super::device::Gpu;

/// Most viewports to an image along each side. Chosen so that positions still have more than 8 sub-pixel bits in the fixed
/// point of software devices (32 bits) at the largest viewport.
const MOST: u32 = 8;

/// How many times the image the viewport is, along x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GuardBand {
    size: [u32; 2],
    factor: [u32; 2],
}

impl GuardBand {
    /// The largest one the device allows for an image.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let most = gpu.limits.max_texture_dimension_2d;
        let factor = size.map(|side| {
            let mut factor = 1;
            while 2 * factor <= MOST && 2 * factor * side <= most {
                factor *= 2;
            }
            factor
        });
        Self { size, factor }
    }

    /// Sets the viewport of a pass.
    pub fn set(self, pass: &mut RenderPass) {
        let [width, height] = [0, 1].map(|i| (self.factor[i] * self.size[i]) as f32);
        let [x, y] = [0, 1].map(|i| -0.5 * ((self.factor[i] - 1) * self.size[i]) as f32);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
    }

    /// From the clip space of the image to that of the viewport.
    pub fn viewport_from_clip(self) -> DMat4 {
        let [x, y] = self.factor.map(|factor| 1.0 / f64::from(factor));
        DMat4::from_scale(DVec3::new(x, y, 1.0))
    }
}
