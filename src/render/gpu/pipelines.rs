//! The compiled shaders and the fixed state around them.

use wgpu::{
    ColorTargetState, CompareFunction, ComputePipeline, ComputePipelineDescriptor, DepthStencilState, Device, Features,
    FragmentState, PipelineCompilationOptions, PrimitiveState, RenderPipeline, RenderPipelineDescriptor, ShaderModule,
    ShaderModuleDescriptor, ShaderSource, TextureFormat, VertexBufferLayout, VertexState, VertexStepMode,
    vertex_attr_array,
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

/// What a pixel shows.
const SURFACE: &str = include_str!("shaders/surface.wgsl");
/// Which map serves it.
const CHOOSE: &str = include_str!("shaders/choose.wgsl");

/// What is compiled when the renderer is made.
pub(super) struct Pipelines {
    /// Depth alone.
    pub depth: RenderPipeline,
    surface: Option<SurfacePipelines>,
}

/// What G-buffers, masks and footprints take.
pub(super) struct SurfacePipelines {
    pub ids: IdsPipeline,
    /// Of triangles that the host has projected.
    pub ids_exact: RenderPipeline,
    pub gbuffer: ComputePipeline,
    pub mask: ComputePipeline,
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
        let depth = render_pipeline(device, "depth", include_str!("shaders/depth.wgsl"), &VERTEX_BUFFERS, None);
        gpu.check()?;
        let surface = gpu.has_compute.then(|| SurfacePipelines {
            ids: ids_pipeline(device),
            ids_exact: ids_exact_pipeline(device),
            gbuffer: compute_pipeline(device, "gbuffer", &[SURFACE, include_str!("shaders/gbuffer.wgsl")]),
            mask: compute_pipeline(device, "shadow_mask", &[SURFACE, CHOOSE, include_str!("shaders/lookup.wgsl")]),
            footprint: compute_pipeline(
                device,
                "footprint",
                &[SURFACE, CHOOSE, include_str!("shaders/footprint.wgsl")],
            ),
        });
        gpu.check()?;
        Ok(Self { depth, surface })
    }

    /// What G-buffers, masks and footprints take.
    ///
    /// # Errors
    /// [`Error::Device`] on a device that has no compute shaders.
    pub fn surface(&self, gpu: &Gpu) -> Result<&SurfacePipelines> {
        self.surface.as_ref().ok_or_else(|| Error::Device {
            what: format!("{} has no compute shaders with five storage buffers, so it gives depth maps only", gpu.info),
            fix: "name another adapter, or use backend \"cpu\"".into(),
        })
    }
}

/// The vertices of a mesh, and the columns of each instance's matrix.
const VERTEX_BUFFERS: [Option<VertexBufferLayout<'static>>; 2] = [
    Some(VertexBufferLayout {
        array_stride: RECORD,
        step_mode: VertexStepMode::Vertex,
        attributes: &vertex_attr_array![0 => Float32x3],
    }),
    Some(VertexBufferLayout {
        array_stride: 64,
        step_mode: VertexStepMode::Instance,
        attributes: &vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
    }),
];

fn ids_pipeline(device: &Device) -> IdsPipeline {
    let target = Some(ColorTargetState::from(IDS));
    if device.features().contains(Features::PRIMITIVE_INDEX) {
        let source = include_str!("shaders/ids.wgsl");
        IdsPipeline::Indexed(render_pipeline(device, "ids", source, &VERTEX_BUFFERS, target))
    } else {
        let source = include_str!("shaders/ids_pulled.wgsl");
        IdsPipeline::Pulled(render_pipeline(device, "ids_pulled", source, &[], target))
    }
}

fn ids_exact_pipeline(device: &Device) -> RenderPipeline {
    let layout = |array_stride, attributes| {
        Some(VertexBufferLayout { array_stride, step_mode: VertexStepMode::Vertex, attributes })
    };
    let buffers = [layout(RECORD, &vertex_attr_array![0 => Float32x3]), layout(8, &vertex_attr_array![1 => Uint32x2])];
    let source = include_str!("shaders/ids_exact.wgsl");
    render_pipeline(device, "ids_exact", source, &buffers, Some(ColorTargetState::from(IDS)))
}

fn module(device: &Device, label: &str, source: String) -> ShaderModule {
    device
        .create_shader_module(ShaderModuleDescriptor { label: Some(label), source: ShaderSource::Wgsl(source.into()) })
}

/// A pipeline that draws the nearest surface of a map, or with a target, where depth is reversed and fragments go through the
/// entry point "ids", of an eye.
fn render_pipeline(
    device: &Device,
    label: &str,
    source: &str,
    buffers: &[Option<VertexBufferLayout>],
    target: Option<ColorTargetState>,
) -> RenderPipeline {
    let module = module(device, label, source.into());
    let nearer = if target.is_some() { CompareFunction::Greater } else { CompareFunction::Less };
    let targets = [target];
    let fragment = targets[0].is_some().then_some(FragmentState {
        module: &module,
        entry_point: Some("ids"),
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

/// A pipeline of the entry point `name` in texts that follow each other.
fn compute_pipeline(device: &Device, name: &str, sources: &[&str]) -> ComputePipeline {
    let module = module(device, name, sources.join("\n"));
    device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(name),
        layout: None,
        module: &module,
        entry_point: Some(name),
        compilation_options: PipelineCompilationOptions::default(),
        cache: None,
    })
}
