//! What is recorded for the device: depth maps of several projections, each a layer of one texture.

use std::sync::Arc;

use glam::DMat4;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, CommandEncoder, IndexFormat,
    LoadOp, Operations, RenderPass, RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipeline, StoreOp,
    Texture, TextureView, TextureViewDescriptor, TextureViewDimension,
};

use super::device::Gpu;
use super::draw_list::{DrawList, PassDraws};
use super::exact::{Depths, ExactTriangles};
use super::guard_band::GuardBand;
use super::layer_pipelines::LayerPipelines;
use super::mask_pipelines::MaskPipelines;
use super::pipelines::{DEPTH, Pipelines};
use super::pool::Pool;
use super::scene_cache::{DeviceScene, RECORD, SceneCache};
use crate::error::Result;
use crate::progress::Progress;
use crate::render::Keep;
use crate::scene::Scene;

/// How the per-instance buffers are used: written by the host, read as vertices or by shaders.
pub(super) const INSTANCES: BufferUsages =
    BufferUsages::VERTEX.union(BufferUsages::STORAGE).union(BufferUsages::COPY_DST);

/// What stays between calls.
#[derive(Default)]
pub(super) struct State {
    pub scenes: SceneCache,
    pub pool: Pool,
    pub layers: LayerPipelines,
    pub masks: MaskPipelines,
}

impl State {
    /// Lets go of scenes, textures and buffers; what has been compiled stays.
    pub fn release(&mut self) {
        self.scenes = SceneCache::default();
        self.pool = Pool::default();
    }
}

/// One call at work.
pub(super) struct Session<'a> {
    pub gpu: &'a Gpu,
    pub pipelines: &'a Pipelines,
    pub state: &'a mut State,
    pub progress: &'a Progress,
}

/// What the commands recorded so far use; goes back to the pool when they have run.
#[derive(Default)]
pub(super) struct InUse {
    pub textures: Vec<Texture>,
    pub buffers: Vec<Buffer>,
}

impl InUse {
    /// Gives everything back.
    pub fn release(self, pool: &mut Pool) {
        self.textures.into_iter().for_each(|t| pool.put_texture(t));
        self.buffers.into_iter().for_each(|b| pool.put_buffer(b));
    }
}

impl Session<'_> {
    /// Records the depth of a scene under each projection; gives the texture, one layer each.
    pub fn draw_depth(
        &mut self,
        encoder: &mut CommandEncoder,
        in_use: &mut InUse,
        scene: &Scene,
        clips_from_world: &[DMat4],
        size: [u32; 2],
        keep: &[Keep],
    ) -> Result<Texture> {
        let list = self.list(in_use, scene, clips_from_world, size, (Depths::Forward, keep), false)?;
        let texture = self.state.pool.texture(self.gpu, DEPTH, size, list.passes.len() as u32)?;
        in_use.textures.push(texture.clone());
        let pipelines = DepthPipelines {
            plain: self.pipelines.depth.clone(),
            tested: if list.is_tested() { Some(self.pipelines.tested(self.gpu)?.depth()) } else { None },
        };
        for layer in 0..list.passes.len() {
            let view = layer_view(&texture, layer as u32);
            self.record(encoder, in_use, &list, layer, &view, &pipelines, Target::FORWARD)?;
        }
        self.gpu.check()?;
        Ok(texture)
    }

    /// What the passes of some projections draw, each what it keeps, on the device. `turns` as [`DrawList::turns`].
    pub fn list(
        &mut self,
        in_use: &mut InUse,
        scene: &Scene,
        clips_from_world: &[DMat4],
        size: [u32; 2],
        (depths, keep): (Depths, &[Keep]),
        turns: bool,
    ) -> Result<PassList> {
        let on_device = self.state.scenes.get(self.gpu, scene, self.progress)?;
        let guard = GuardBand::new(self.gpu, size);
        let mut list = DrawList { turns, ..DrawList::default() };
        let mut passes = Vec::with_capacity(clips_from_world.len());
        for (clip_from_world, keep) in clips_from_world.iter().zip(keep) {
            self.progress.check()?;
            passes.push(list.push_pass(scene, &on_device, clip_from_world, guard, depths, *keep));
        }
        let identity = list.push_identity();
        let matrices = self.upload(in_use, "the matrices of all visible instances (bytes)", &list.clip_from_local)?;
        Ok(PassList { on_device, guard, passes, identity, matrices })
    }

    /// Records one pass of a list.
    #[allow(clippy::too_many_arguments)]
    pub fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        in_use: &mut InUse,
        list: &PassList,
        index: usize,
        view: &TextureView,
        pipelines: &DepthPipelines,
        target: Target,
    ) -> Result<()> {
        let PassList { on_device, guard, passes, identity, matrices } = list;
        let (draws, identity) = (&passes[index], *identity);
        let exact = self.upload_exact(in_use, &draws.exact)?;
        let tested_exact = self.upload_tested(in_use, draws)?;
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("depth"),
            depth_stencil_attachment: Some(depth_attachment(view, target.far)),
            ..Default::default()
        });
        guard.set(&mut pass);
        pass.set_pipeline(&pipelines.plain);
        if let Some(first) = target.first {
            pass.set_bind_group(0, &self.bind_first(&pipelines.plain, 0, first), &[]);
        }
        pass.set_vertex_buffer(1, matrices.slice(..));
        draw_indexed(&mut pass, on_device, draws);
        if let Some(corners) = &exact {
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..draws.exact.corners.len() as u32, identity..identity + 1);
        }
        let Some([tested, tested_alone]) = &pipelines.tested else { return Ok(()) };
        pass.set_pipeline(tested);
        if let Some(first) = target.first {
            pass.set_bind_group(1, &self.bind_first(tested, 1, first), &[]);
        }
        let layout = tested.get_bind_group_layout(0);
        for draw in draws.on_device(on_device, true) {
            let (mesh, geometry, test) = on_device.tested(draw.mesh);
            pass.set_bind_group(0, &test.bind(self.gpu, &layout), &[]);
            // Texture coordinates begin with the mesh's first vertex, so all vertices do.
            let first = u64::from(mesh.first_vertex) * RECORD;
            pass.set_vertex_buffer(0, geometry.vertices.slice(first..));
            pass.set_vertex_buffer(2, test.uv.slice(..));
            pass.set_index_buffer(geometry.indices.slice(..), IndexFormat::Uint32);
            pass.draw_indexed(mesh.first_index..mesh.first_index + mesh.index_count, 0, draw.slots.clone());
        }
        pass.set_pipeline(tested_alone);
        if let Some(first) = target.first {
            pass.set_bind_group(1, &self.bind_first(tested_alone, 1, first), &[]);
        }
        let layout = tested_alone.get_bind_group_layout(0);
        for exact in &tested_exact {
            let (_, _, test) = on_device.tested(exact.mesh);
            pass.set_bind_group(0, &test.bind(self.gpu, &layout), &[]);
            pass.set_vertex_buffer(0, exact.corners.slice(..));
            pass.set_vertex_buffer(2, exact.coordinates.slice(..));
            pass.draw(0..exact.count, identity..identity + 1);
        }
        Ok(())
    }

    /// The group of a pipeline that reads the first depths.
    fn bind_first(&self, pipeline: &RenderPipeline, group: u32, first: &TextureView) -> BindGroup {
        self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: Some("first depths"),
            layout: &pipeline.get_bind_group_layout(group),
            entries: &[BindGroupEntry { binding: 0, resource: BindingResource::TextureView(first) }],
        })
    }

    /// The corners of exact triangles in a buffer of the device; nothing where there are none.
    pub fn upload_exact(&mut self, in_use: &mut InUse, exact: &ExactTriangles) -> Result<Option<Buffer>> {
        if exact.corners.is_empty() {
            return Ok(None);
        }
        self.upload(in_use, "triangles that take more than single precision (bytes)", &exact.corners).map(Some)
    }

    /// The same of meshes with alpha tests.
    pub fn upload_tested(&mut self, in_use: &mut InUse, draws: &PassDraws) -> Result<Vec<TestedExact>> {
        let shown = draws.tested_exact.iter().filter(|(_, exact)| !exact.corners.is_empty());
        let upload = |(mesh, exact): &(u32, ExactTriangles)| {
            let what = "triangles that take more than single precision (bytes)";
            Ok(TestedExact {
                mesh: *mesh,
                count: exact.corners.len() as u32,
                corners: self.upload(in_use, what, &exact.corners)?,
                ids: self.upload(in_use, what, &exact.ids)?,
                coordinates: self.upload(in_use, what, &exact.coordinates)?,
            })
        };
        shown.map(upload).collect()
    }

    /// Writes an array into a buffer of the device that the recorded commands will read.
    pub fn upload<T: bytemuck::Pod>(&mut self, in_use: &mut InUse, what: &str, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.gpu.check_buffer(what, bytes.len() as u64)?;
        let buffer = self.state.pool.buffer(self.gpu, INSTANCES, bytes.len() as u64)?;
        in_use.buffers.push(buffer.clone());
        self.gpu.queue.write_buffer(&buffer, 0, bytes);
        self.gpu.check()?;
        Ok(buffer)
    }
}

/// Passes over a scene whose draws are on the device.
pub(super) struct PassList {
    pub on_device: Arc<DeviceScene>,
    pub guard: GuardBand,
    pub passes: Vec<PassDraws>,
    /// The slot of a matrix that changes nothing.
    pub identity: u32,
    pub matrices: Buffer,
}

impl PassList {
    /// Whether anything has an alpha test.
    pub fn is_tested(&self) -> bool {
        self.passes.iter().any(|pass| pass.is_tested(&self.on_device))
    }
}

/// What draws depth: of meshes without and with alpha tests, of the latter also of triangles that the host has projected.
pub(super) struct DepthPipelines {
    pub plain: RenderPipeline,
    pub tested: Option<[RenderPipeline; 2]>,
}

/// Where depths go.
#[derive(Clone, Copy)]
pub(super) struct Target<'a> {
    /// Depth of the far plane.
    pub far: f32,
    /// The nearest depths, where those behind them are drawn.
    pub first: Option<&'a TextureView>,
}

impl Target<'_> {
    /// The nearest depth, 1 at the far plane.
    pub const FORWARD: Self = Self { far: 1.0, first: None };
    /// The nearest depth, 0 at the far plane.
    pub const REVERSED: Self = Self { far: 0.0, first: None };
}

/// Exact triangles of a mesh with an alpha test, on the device.
pub(super) struct TestedExact {
    pub mesh: u32,
    /// Corners.
    pub count: u32,
    pub corners: Buffer,
    pub ids: Buffer,
    pub coordinates: Buffer,
}

/// Records one draw a mesh of what the device projects and has no alpha test; pipeline and instances are set.
pub(super) fn draw_indexed(pass: &mut RenderPass, on_device: &DeviceScene, draws: &PassDraws) {
    let mut bound = None;
    for draw in draws.on_device(on_device, false) {
        let mesh = on_device.meshes[draw.mesh as usize];
        if bound != Some(mesh.group) {
            let group = &on_device.groups[mesh.group as usize];
            pass.set_vertex_buffer(0, group.vertices.slice(..));
            pass.set_index_buffer(group.indices.slice(..), IndexFormat::Uint32);
            bound = Some(mesh.group);
        }
        let indices = mesh.first_index..mesh.first_index + mesh.index_count;
        pass.draw_indexed(indices, mesh.first_vertex as i32, draw.slots.clone());
    }
}

/// One layer of a texture to draw into.
pub(super) fn layer_view(texture: &Texture, layer: u32) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// Depth cleared to that of the far plane and kept.
pub(super) fn depth_attachment(view: &TextureView, far: f32) -> RenderPassDepthStencilAttachment<'_> {
    let depth_ops = Some(Operations { load: LoadOp::Clear(far), store: StoreOp::Store });
    RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
}
