//! The pipelines of maps that store more than the nearest depth: compiled when the first such map is drawn.

use std::collections::HashMap;

use wgpu::{
    CompareFunction, DepthStencilState, FragmentState, PipelineCompilationOptions, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, VertexState, vertex_attr_array,
};

use super::device::Gpu;
use super::pipelines::{ALPHA_TEST, DEPTH, VERTEX_BUFFERS, depth_pipeline, module, per_vertex};

/// Which fragments are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Fragments {
    /// All of them.
    All,
    /// Those of faces that are averted from the light.
    Averted,
    /// Those behind the first depth.
    Behind,
}

/// Where corners come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Source {
    /// Meshes without an alpha test.
    Plain,
    /// Meshes with one.
    Tested,
    /// Their triangles that the host has projected.
    TestedExact,
}

/// How drawn depths become stored ones: the constants of stored.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Encoding {
    pub surface: u32,
    pub spacing: u32,
    pub format: u32,
}

/// What has been compiled: a few dozen pipelines at most.
#[derive(Default)]
pub(super) struct LayerPipelines {
    depth: HashMap<(Fragments, bool, Source), RenderPipeline>,
    encodings: HashMap<Encoding, RenderPipeline>,
}

impl LayerPipelines {
    /// What draws depth of meshes without alpha tests; reversed depth is 1 at the near plane and 0 at the far plane.
    pub fn plain(&mut self, gpu: &Gpu, fragments: Fragments, is_reversed: bool) -> RenderPipeline {
        self.depth(gpu, fragments, is_reversed, Source::Plain)
    }

    /// The same of meshes with alpha tests, and of their triangles that the host has projected.
    pub fn tested(&mut self, gpu: &Gpu, fragments: Fragments, is_reversed: bool) -> [RenderPipeline; 2] {
        [Source::Tested, Source::TestedExact].map(|source| self.depth(gpu, fragments, is_reversed, source))
    }

    fn depth(&mut self, gpu: &Gpu, fragments: Fragments, is_reversed: bool, source: Source) -> RenderPipeline {
        let compiled = || {
            let layers = include_str!("shaders/layers.wgsl");
            let [vertices, matrices] = VERTEX_BUFFERS;
            let tested = || [layers, include_str!("shaders/layers_tested.wgsl"), ALPHA_TEST].join("\n");
            let with = |coordinates| [vertices.clone(), matrices.clone(), Some(coordinates)];
            let entry_point = Some(match fragments {
                Fragments::All => "all",
                // The determinant of a reversed matrix has the other sign.
                Fragments::Averted if is_reversed => "averted_reversed",
                Fragments::Averted => "averted",
                Fragments::Behind => "behind",
            });
            let device = &gpu.device;
            match source {
                Source::Plain => {
                    let text = [layers, include_str!("shaders/layers_plain.wgsl")].join("\n");
                    depth_pipeline(device, "layers", text, &VERTEX_BUFFERS, entry_point, is_reversed)
                }
                Source::Tested => {
                    let buffers = with(per_vertex(8, &vertex_attr_array![5 => Float32x2]));
                    depth_pipeline(device, "layers_tested", tested(), &buffers, entry_point, is_reversed)
                }
                Source::TestedExact => {
                    let buffers = with(per_vertex(16, &vertex_attr_array![5 => Float32x4]));
                    depth_pipeline(device, "layers_exact_tested", tested(), &buffers, entry_point, is_reversed)
                }
            }
        };
        self.depth.entry((fragments, is_reversed, source)).or_insert_with(compiled).clone()
    }

    /// What turns drawn depths into stored ones.
    pub fn encoding(&mut self, gpu: &Gpu, encoding: Encoding) -> RenderPipeline {
        self.encodings.entry(encoding).or_insert_with(|| encoding_pipeline(gpu, encoding)).clone()
    }
}

fn encoding_pipeline(gpu: &Gpu, Encoding { surface, spacing, format }: Encoding) -> RenderPipeline {
    let constants = [("surface", surface), ("spacing", spacing), ("format", format)].map(|(name, x)| (name, x.into()));
    let module = module(&gpu.device, "stored", include_str!("shaders/stored.wgsl").into());
    gpu.device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("stored"),
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("everything"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(FragmentState {
            module: &module,
            entry_point: Some("stored"),
            compilation_options: PipelineCompilationOptions { constants: &constants, ..Default::default() },
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}
