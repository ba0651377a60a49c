//! What shaders are told of a filter: the host's side of filter.wgsl.

use bytemuck::{Pod, Zeroable};

use crate::render::{Extent, Filter, Kernels, MOST_POINTS, Unit};

/// `Kernel` of filter.wgsl, a part of [`super::uniforms::Lookup`].
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Kernel {
    points: u32,
    unit: u32,
    length: f32,
    unused: u32,
    /// Two points each.
    disc: [[f32; 4]; MOST_POINTS as usize / 2],
}

impl Kernel {
    /// What a filter is, beside its kind.
    pub fn new(filter: &Filter, kernels: &Kernels) -> Self {
        let Extent { length, unit } = filter.extent().unwrap_or(Extent::texels(0.0));
        let mut disc = [[0.0; 4]; MOST_POINTS as usize / 2];
        for (i, q) in kernels.disc().iter().enumerate() {
            disc[i / 2][2 * (i % 2)..][..2].copy_from_slice(&q.as_vec2().to_array());
        }
        Self {
            points: kernels.disc().len() as u32,
            unit: u32::from(unit == Unit::Pixels),
            length: length as f32,
            unused: 0,
            disc,
        }
    }
}
