//! The compiled shaders and the fixed state around them.
//!
//! No branch or loop of a shader is decided by uniform buffers alone: what decides is in storage, or constant in the pipeline.
//! Mesa's software device (lavapipe 22.3) takes the values of such uniforms for constants, compiles the shader for them each
//! time its pipeline is bound, and keeps what it has compiled: 0.3 to 1.6 MB and several milliseconds a call.

use std::sync::OnceLock;

use wgpu::{
    ColorTargetState, CompareFunction, ComputePipeline, ComputePipelineDescriptor, DepthStencilState, Device, Features,
    FragmentState, PipelineCompilationOptions, PrimitiveState, RenderPipeline, RenderPipelineDescriptor, ShaderModule,
    ShaderModuleDescriptor, ShaderSource, TextureFormat, VertexAttribute, VertexBufferLayout, VertexState,
    VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::scene_cache::RECORD;
use crate::error::{Error, Result};

/// Format of every depth image.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Format of ids: slot + 1 and triangle.
pub(super) const IDS: TextureFormat = TextureFormat::Rg32Uint;
/// Pixels along each side of a workgroup; `@workgroup_size` in the shaders.
pub(super) const WORKGROUP: u32 = 8;

/// The numbers of shaders that see to pixels, with and without double precision.
const NUMBERS: [&str; 2] = [include_str!("shaders/single.wgsl"), include_str!("shaders/double.wgsl")];
/// What a pixel shows.
pub(super) const SURFACE: &str = include_str!("shaders/surface.wgsl");
/// Which map serves it.
pub(super) const CHOOSE: &str = include_str!("shaders/choose.wgsl");
/// Which points of a mesh exist.
pub(super) const ALPHA_TEST: &str = include_str!("shaders/alpha_test.wgsl");

/// What is compiled when the renderer is made.
pub(super) struct Pipelines {
    /// Depth alone.
    pub depth: RenderPipeline,
    surface: Option<SurfacePipelines>,
    tested: OnceLock<TestedPipelines>,
}

/// What meshes with alpha tests take, compiled when the first is drawn.
pub(super) struct TestedPipelines {
    depth: RenderPipeline,
    /// Of triangles that the host has projected.
    depth_exact: RenderPipeline,
    /// None on a device that has no compute shaders, which draws no ids.
    pub ids: Option<TestedIds>,
}

/// See [`TestedPipelines`].
pub(super) struct TestedIds {
    pub ids: RenderPipeline,
    /// Of triangles that the host has projected.
    pub ids_exact: RenderPipeline,
}

/// What G-buffers, masks and footprints take.
pub(super) struct SurfacePipelines {
    pub ids: IdsPipeline,
    /// Of triangles that the host has projected.
    pub ids_exact: RenderPipeline,
    pub gbuffer: ComputePipeline,
    pub footprint: ComputePipeline,
}

/// How the ids of a pass come about.
pub(super) enum IdsPipeline {
    /// The device numbers the triangles.
    Indexed(RenderPipeline),
    /// The vertices tell their triangle.
    Pulled(RenderPipeline),
}

impl Pipelines {
    /// All that the device can run.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let device = &gpu.device;
        let depth =
            depth_pipeline(device, "depth", include_str!("shaders/depth.wgsl").into(), &VERTEX_BUFFERS, None, false);
        gpu.check()?;
        let surface = gpu.has_compute.then(|| SurfacePipelines {
            ids: ids_pipeline(device),
            ids_exact: ids_exact_pipeline(device),
            gbuffer: compute_pipeline(
                device,
                "gbuffer",
                &[numbers(device), SURFACE, include_str!("shaders/gbuffer.wgsl")],
                &[],
            ),
            footprint: compute_pipeline(
                device,
                "footprint",
                &[NUMBERS[0], SURFACE, CHOOSE, include_str!("shaders/footprint.wgsl")],
                &[],
            ),
        });
        gpu.check()?;
        Ok(Self { depth, surface, tested: OnceLock::new() })
    }

    /// What meshes with alpha tests take.
    pub fn tested(&self, gpu: &Gpu) -> Result<&TestedPipelines> {
        let tested = self.tested.get_or_init(|| TestedPipelines::new(gpu));
        gpu.check()?;
        Ok(tested)
    }

    /// What G-buffers, masks and footprints take.
    ///
    /// # Errors
    /// [`Error::Device`] on a device that has no compute shaders.
    pub fn surface(&self, gpu: &Gpu) -> Result<&SurfacePipelines> {
        self.surface.as_ref().ok_or_else(|| Error::Device {
            what: format!(
                "{} has no compute shaders with eight storage buffers, so it gives depth maps only",
                gpu.info
            ),
            fix: "name another adapter, or use backend \"cpu\"".into(),
        })
    }
}

impl TestedPipelines {
    /// Those that draw depth.
    pub fn depth(&self) -> [RenderPipeline; 2] {
        [self.depth.clone(), self.depth_exact.clone()]
    }
    fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let source = [include_str!("shaders/depth_tested.wgsl"), ALPHA_TEST].join("\n");
        let [vertices, matrices] = VERTEX_BUFFERS;
        let depth = |label, coordinates| {
            let buffers = [vertices.clone(), matrices.clone(), Some(coordinates)];
            depth_pipeline(device, label, source.clone(), &buffers, Some("depth"), false)
        };
        Self {
            depth: depth("depth_tested", per_vertex(8, &vertex_attr_array![5 => Float32x2])),
            depth_exact: depth("depth_exact_tested", per_vertex(16, &vertex_attr_array![5 => Float32x4])),
            ids: gpu.has_compute.then(|| TestedIds::new(device)),
        }
    }
}

impl TestedIds {
    fn new(device: &Device) -> Self {
        let target = || Some(ColorTargetState::from(IDS));
        let ids = [include_str!("shaders/ids_tested.wgsl"), ALPHA_TEST].join("\n");
        let exact = [include_str!("shaders/ids_exact_tested.wgsl"), ALPHA_TEST].join("\n");
        let [corners, numbers] = EXACT_BUFFERS;
        let buffers = [corners, numbers, Some(per_vertex(16, &vertex_attr_array![2 => Float32x4]))];
        Self {
            ids: render_pipeline(device, "ids_tested", ids, &[], Some("ids"), target(), true),
            ids_exact: render_pipeline(device, "ids_exact_tested", exact, &buffers, Some("ids"), target(), true),
        }
    }
}

/// A buffer of attributes that each vertex has.
pub(super) const fn per_vertex(array_stride: u64, attributes: &[VertexAttribute]) -> VertexBufferLayout<'_> {
    VertexBufferLayout { array_stride, step_mode: VertexStepMode::Vertex, attributes }
}

/// Corners that the host has projected, and their numbers.
const EXACT_BUFFERS: [Option<VertexBufferLayout<'static>>; 2] = [
    Some(per_vertex(RECORD, &vertex_attr_array![0 => Float32x3])),
    Some(per_vertex(8, &vertex_attr_array![1 => Uint32x2])),
];

/// The vertices of a mesh, and the columns of each instance's matrix.
pub(super) const VERTEX_BUFFERS: [Option<VertexBufferLayout<'static>>; 2] = [
    Some(per_vertex(RECORD, &vertex_attr_array![0 => Float32x3])),
    Some(VertexBufferLayout {
        array_stride: 64,
        step_mode: VertexStepMode::Instance,
        attributes: &vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
    }),
];

fn ids_pipeline(device: &Device) -> IdsPipeline {
    let target = Some(ColorTargetState::from(IDS));
    if device.features().contains(Features::PRIMITIVE_INDEX) {
        let source = include_str!("shaders/ids.wgsl").into();
        IdsPipeline::Indexed(render_pipeline(device, "ids", source, &VERTEX_BUFFERS, Some("ids"), target, true))
    } else {
        let source = include_str!("shaders/ids_pulled.wgsl").into();
        IdsPipeline::Pulled(render_pipeline(device, "ids_pulled", source, &[], Some("ids"), target, true))
    }
}

fn ids_exact_pipeline(device: &Device) -> RenderPipeline {
    let source = include_str!("shaders/ids_exact.wgsl").into();
    let target = Some(ColorTargetState::from(IDS));
    render_pipeline(device, "ids_exact", source, &EXACT_BUFFERS, Some("ids"), target, true)
}

pub(super) fn module(device: &Device, label: &str, source: String) -> ShaderModule {
    device
        .create_shader_module(ShaderModuleDescriptor { label: Some(label), source: ShaderSource::Wgsl(source.into()) })
}

/// A pipeline that draws the nearest depth of a map. Fragments go through an entry point if there is one.
pub(super) fn depth_pipeline(
    device: &Device,
    label: &str,
    source: String,
    buffers: &[Option<VertexBufferLayout>],
    entry_point: Option<&str>,
    is_reversed: bool,
) -> RenderPipeline {
    render_pipeline(device, label, source, buffers, entry_point, None, is_reversed)
}

/// A pipeline that draws the nearest surface, whose depth is largest where depth is reversed.
fn render_pipeline(
    device: &Device,
    label: &str,
    source: String,
    buffers: &[Option<VertexBufferLayout>],
    entry_point: Option<&str>,
    target: Option<ColorTargetState>,
    is_reversed: bool,
) -> RenderPipeline {
    let module = module(device, label, source);
    let nearer = if is_reversed { CompareFunction::Greater } else { CompareFunction::Less };
    let targets: Vec<_> = target.into_iter().map(Some).collect();
    let fragment = entry_point.map(|name| FragmentState {
        module: &module,
        entry_point: Some(name),
        compilation_options: PipelineCompilationOptions::default(),
        targets: &targets,
    });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(label),
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("clip_position"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers,
        },
        // Both sides, clipped at the near and the far plane: the defaults.
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(nearer),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment,
        multiview_mask: None,
        cache: None,
    })
}

/// The numbers that shaders have on a device.
pub(super) fn numbers(device: &Device) -> &'static str {
    NUMBERS[usize::from(device.features().contains(Features::SHADER_F64))]
}

/// A pipeline of the entry point `name` in texts that follow each other, with their constants.
pub(super) fn compute_pipeline(
    device: &Device,
    name: &str,
    sources: &[&str],
    constants: &[(&str, f64)],
) -> ComputePipeline {
    let module = module(device, name, sources.join("\n"));
    device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(name),
        layout: None,
        module: &module,
        entry_point: Some(name),
        compilation_options: PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}
