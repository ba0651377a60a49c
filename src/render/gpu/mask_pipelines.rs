//! The pipelines of shadow masks, one for each kind of filter and comparison: compiled when the first such mask is drawn.
//!
//! In a shader for all of them a software device goes through every branch for every pixel.

use std::collections::HashMap;

use wgpu::ComputePipeline;

use super::device::Gpu;
use super::pipelines::{CHOOSE, SURFACE, compute_pipeline, numbers};
use crate::render::{Filter, MaskSettings};

/// What masks have a pipeline for: the constants of lookup.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct MaskKind {
    filter: u32,
    compares_plane: bool,
}

impl MaskKind {
    /// That of some settings.
    pub fn new(settings: &MaskSettings) -> Self {
        let filter = match settings.filter {
            Filter::Nearest => 0,
            Filter::Bilinear => 1,
            Filter::Pcf { .. } => 2,
            Filter::Tent { .. } => 3,
            Filter::Poisson { .. } => 4,
        };
        Self { filter, compares_plane: settings.bias.plane > 0.0 }
    }
}

/// What has been compiled: ten pipelines at most.
#[derive(Default)]
pub(super) struct MaskPipelines(HashMap<MaskKind, ComputePipeline>);

impl MaskPipelines {
    /// What looks up masks of a kind.
    pub fn get(&mut self, gpu: &Gpu, kind: MaskKind) -> ComputePipeline {
        let compiled = || {
            let lookup = [include_str!("shaders/lookup.wgsl"), include_str!("shaders/filter.wgsl")];
            let sources = [numbers(&gpu.device), SURFACE, CHOOSE, lookup[0], lookup[1]];
            let constants =
                [("filter_kind", f64::from(kind.filter)), ("compares_plane", f64::from(u8::from(kind.compares_plane)))];
            compute_pipeline(&gpu.device, "shadow_mask", &sources, &constants)
        };
        self.0.entry(kind).or_insert_with(compiled).clone()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use wgpu::Features;

    use super::super::device::tests::opened;
    use super::super::renderer::{FEATURES, GpuRenderer};
    use super::*;
    use crate::render::{Bias, Renderer, Stored};
    use crate::scene::DirectionalLight;
    use crate::{Camera, Light, Mesh, Parameterization, Partition, Progress, Scene};

    /// Texels of the map.
    const RESOLUTION: u32 = 64;
    /// A place in the map in single precision, texels: four roundings of 2^-24 of its size, two of the position's and two of the row's
    /// product and quotient. A weight changes by as much over the width of the kernel, which is at least 1.
    const PLACE: f32 = RESOLUTION as f32 * 4.0 / 16_777_216.0;

    #[test]
    fn masks_without_double_precision_keep_to_their_bound() {
        let renderer = |features| opened(features).map(|gpu| GpuRenderer::on(gpu).unwrap());
        let (Some(single), Some(double)) = (renderer(FEATURES - Features::SHADER_F64), renderer(FEATURES)) else {
            return;
        };
        let square = |half: f64, y: f64| [[-half, y, -half], [half, y, -half], [half, y, half], [-half, y, half]];
        let vertices = [square(9.0, 0.0), square(1.013, 2.0)].concat();
        let mesh = Mesh::new(&vertices, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap();
        let scene = Scene::from_mesh(mesh).unwrap();
        let camera = Camera::look_at(DVec3::new(3.0, 7.0, 4.0), DVec3::ZERO, DVec3::Y, 0.9, 1.3, 0.1, 50.0).unwrap();
        let direction = DVec3::new(0.3, -1.0, 0.17).normalize();
        let view = glam::dcamera::rh::view::look_to_mat4(-10.0 * direction, direction, DVec3::X);
        let projection = glam::dcamera::rh::proj::directx::orthographic(-6.0, 6.0, -6.0, 6.0, 0.0, 20.0);
        let p = Parameterization::of_partitions(vec![Partition::of_matrix(projection * view)], [RESOLUTION; 2]);
        let light = Light::Directional(DirectionalLight::new(direction).unwrap());
        for filter in ["bilinear", "pcf:size=3", "tent:size=4.5", "pcf:size=3px"] {
            let settings = MaskSettings {
                resolution: [RESOLUTION; 2],
                size: [240, 180],
                bias: Bias::default(),
                filter: filter.parse().unwrap(),
                blend: 0.0,
                stored: Stored::default(),
            };
            let mask =
                |r: &GpuRenderer| r.shadow_mask(&scene, &camera, &light, &p, &settings, &Progress::new()).unwrap().data;
            let (a, b) = (mask(&single), mask(&double));
            let mut apart: Vec<f32> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).filter(|x| !x.is_nan()).collect();
            apart.sort_by(f32::total_cmp);
            // A comparison that goes the other way, by rounding of a depth or of a place at a texel's border.
            let nearly_all = apart[apart.len() - 1 - apart.len() / 1000];
            println!("{filter}: {nearly_all:e}, double precision: {}", double.has_double());
            assert!(b.iter().filter(|x| **x > 0.0 && **x < 1.0).count() > 100, "{filter}: no penumbra");
            assert!(nearly_all <= PLACE, "{filter}: {nearly_all:e}");
            assert!(nearly_all > 0.0 || !double.has_double(), "{filter}: nothing to bound");
        }
    }
}
