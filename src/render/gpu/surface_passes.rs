//! What is recorded and read for a view: the ids of its pixels, and what gbuffer.wgsl, lookup.wgsl and footprint.wgsl make of
//! them.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::Zeroable;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, Color, CommandEncoder,
    ComputePassDescriptor, ComputePipeline, LoadOp, Operations, RenderPassColorAttachment, RenderPassDescriptor,
    StoreOp, Texture, TextureViewDescriptor, TextureViewDimension,
};

use super::draw_list::DrawList;
use super::exact::Depths;
use super::guard_band::GuardBand;
use super::mask_pipelines::MaskKind;
use super::passes::{InUse, Session, depth_attachment, draw_indexed, layer_view};
use super::pipelines::{DEPTH, IDS, IdsPipeline, TestedIds, WORKGROUP};
use super::readback::{STAGING, finish_and_read};
use super::scene_cache::DeviceScene;
use super::surface::{EyeSpace, Placement, View, slots_by_group};
use super::uniforms::{Choice, Lookup, Map};
use crate::error::Result;
use crate::image::{Footprint, GBuffer, ShadowMask};
use crate::render::Keep;
use crate::scene::{Camera, Scene};

/// Bytes of results that one submission computes; more come in bands of rows. A quarter of the smallest binding of any
/// device in use (128 MiB), so that a wait is short and staging small.
const BAND_BYTES: u64 = 32 << 20;
/// Words a pixel in the result of gbuffer.wgsl.
const GBUFFER_WORDS: usize = 9;
/// Words a pixel in the result of lookup.wgsl.
const MASK_WORDS: usize = 2;
/// Words a pixel in the result of footprint.wgsl.
const FOOTPRINT_WORDS: usize = Footprint::PLANES + 1;
/// In place of a map's index in the result of lookup.wgsl: the pixel asks a map of another batch.
const OTHER_BATCH: i32 = -2;

const RESULT: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_SRC);

/// A view drawn: which triangle each pixel shows, and what it takes to make sense of that.
pub(super) struct Drawn {
    on_device: Arc<DeviceScene>,
    ids: Texture,
    depth: Texture,
    placements: Buffer,
    /// Each group that shows, with its slots.
    groups: Vec<(u32, Range<u32>)>,
    /// As [`EyeSpace::view`] gives it.
    view: View,
    size: [u32; 2],
}

impl Session<'_> {
    /// Records the ids and the depth, reversed, of what a camera sees.
    pub fn draw_ids(
        &mut self,
        encoder: &mut CommandEncoder,
        in_use: &mut InUse,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<Drawn> {
        let pipelines = self.pipelines.surface(self.gpu)?;
        let on_device = self.state.scenes.get(self.gpu, scene, self.progress)?;
        let guard = GuardBand::new(self.gpu, size);
        let mut list = DrawList::default();
        // The depth of parallel rays is linear, whichever way it runs.
        let depths = if camera.is_orthographic() { Depths::Forward } else { Depths::Reversed };
        let draws =
            list.push_pass(scene, &on_device, &camera.reversed_clip_from_world(), guard, depths, Keep::InVolume);
        // Never empty, as a binding and a buffer of vertices must not be.
        list.push_identity();
        let space = EyeSpace::new(scene, camera);
        let clips = self.upload(in_use, "the matrices of all visible instances (bytes)", &list.clip_from_local)?;
        let mut placements = space.placements(scene, &on_device, &list.instances);
        if placements.is_empty() {
            // No pixel asks for it, but a binding holds at least one.
            placements.push(Placement::zeroed());
        }
        let placements = self.upload(in_use, "the placements of all visible instances (bytes)", &placements)?;
        self.gpu.check_binding("the placements of all visible instances (bytes)", placements.size())?;
        let exact = self.upload_exact(in_use, &draws.exact)?;
        let exact_ids = match &exact {
            Some(_) => Some(self.upload(in_use, "the numbers of such triangles (bytes)", &draws.exact.ids)?),
            None => None,
        };
        let tested = if draws.is_tested(&on_device) { self.pipelines.tested(self.gpu)?.ids.as_ref() } else { None };
        let tested_exact = self.upload_tested(in_use, &draws)?;
        let groups = slots_by_group(&on_device, &draws.draws);
        for (group, _) in &groups {
            let geometry = &on_device.groups[*group as usize];
            self.gpu.check_binding("the vertices of one mesh (bytes)", geometry.vertices.size())?;
            self.gpu.check_binding("the triangles of one mesh (bytes)", geometry.indices.size())?;
        }
        let depth = self.state.pool.texture(self.gpu, DEPTH, size, 1)?;
        in_use.textures.push(depth.clone());
        let ids = self.state.pool.texture(self.gpu, IDS, size, 1)?;
        in_use.textures.push(ids.clone());
        let (depth_view, ids_view) = (layer_view(&depth, 0), layer_view(&ids, 0));
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("ids"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &ids_view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(depth_attachment(&depth_view, 0.0)),
            ..Default::default()
        });
        guard.set(&mut pass);
        match &pipelines.ids {
            IdsPipeline::Indexed(pipeline) => {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(1, clips.slice(..));
                draw_indexed(&mut pass, &on_device, &draws);
            }
            IdsPipeline::Pulled(pipeline) => {
                pass.set_pipeline(pipeline);
                let mut bound = None;
                for draw in draws.on_device(&on_device, false) {
                    let mesh = on_device.meshes[draw.mesh as usize];
                    if bound != Some(mesh.group) {
                        let geometry = &on_device.groups[mesh.group as usize];
                        let buffers = [&placements, &clips, &geometry.vertices, &geometry.indices];
                        let resources = buffers.map(Buffer::as_entire_binding);
                        pass.set_bind_group(0, &self.bind(&pipeline.get_bind_group_layout(0), &resources), &[]);
                        bound = Some(mesh.group);
                    }
                    pass.draw(mesh.first_index..mesh.first_index + mesh.index_count, draw.slots.clone());
                }
            }
        }
        if let (Some(corners), Some(ids)) = (&exact, &exact_ids) {
            pass.set_pipeline(&pipelines.ids_exact);
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.set_vertex_buffer(1, ids.slice(..));
            pass.draw(0..draws.exact.corners.len() as u32, 0..1);
        }
        if let Some(TestedIds { ids, ids_exact }) = tested {
            pass.set_pipeline(ids);
            let [layout_0, layout_1] = [0, 1].map(|group| ids.get_bind_group_layout(group));
            for draw in draws.on_device(&on_device, true) {
                let (mesh, geometry, test) = on_device.tested(draw.mesh);
                let buffers = [&placements, &clips, &geometry.vertices, &geometry.indices, &test.uv];
                let resources = buffers.map(Buffer::as_entire_binding);
                pass.set_bind_group(0, &test.bind(self.gpu, &layout_0), &[]);
                pass.set_bind_group(1, &self.bind(&layout_1, &resources), &[]);
                pass.draw(mesh.first_index..mesh.first_index + mesh.index_count, draw.slots.clone());
            }
            pass.set_pipeline(ids_exact);
            let layout = ids_exact.get_bind_group_layout(0);
            for exact in &tested_exact {
                let (_, _, test) = on_device.tested(exact.mesh);
                pass.set_bind_group(0, &test.bind(self.gpu, &layout), &[]);
                pass.set_vertex_buffer(0, exact.corners.slice(..));
                pass.set_vertex_buffer(1, exact.ids.slice(..));
                pass.set_vertex_buffer(2, exact.coordinates.slice(..));
                pass.draw(0..exact.count, 0..1);
            }
        }
        drop(pass);
        self.gpu.check()?;
        Ok(Drawn { on_device, ids, depth, placements, groups, view: space.view(scene, camera, size), size })
    }

    /// Reads the G-buffer of a drawn view; `encoder` holds the commands that draw it.
    pub fn read_gbuffer(&mut self, encoder: CommandEncoder, drawn: &Drawn, into: &mut GBuffer) -> Result<()> {
        let pipeline = &self.pipelines.surface(self.gpu)?.gbuffer;
        let depth = drawn.depth.create_view(&TextureViewDescriptor::default());
        let resources = [BindingResource::TextureView(&depth)];
        self.in_bands(encoder, drawn, pipeline, &resources, GBUFFER_WORDS, |pixels, bytes| {
            let n = pixels.len();
            let words: &[u32] = bytemuck::cast_slice(bytes);
            let words = |from: usize, to: usize| &words[from * n..to * n];
            into.depth[pixels.clone()].copy_from_slice(bytemuck::cast_slice(words(0, 1)));
            into.position[pixels.clone()].copy_from_slice(bytemuck::cast_slice(words(1, 4)));
            into.normal[pixels.clone()].copy_from_slice(bytemuck::cast_slice(words(4, 7)));
            into.triangle[pixels.clone()].copy_from_slice(bytemuck::cast_slice(words(7, 8)));
            into.instance[pixels].copy_from_slice(bytemuck::cast_slice(words(8, 9)));
        })
    }

    /// Adds the light of the maps of `lookup`'s batch to the shadow mask of a drawn view, 0 before the first; `encoder` holds the commands that
    /// draw the view and the maps.
    #[allow(clippy::too_many_arguments)]
    pub fn read_mask(
        &mut self,
        encoder: CommandEncoder,
        in_use: &mut InUse,
        drawn: &Drawn,
        (kind, choice, lookup): (MaskKind, &Choice, &Lookup),
        maps: &[Map],
        depth_maps: &Texture,
        into: &mut ShadowMask,
    ) -> Result<()> {
        let pipeline = &self.state.masks.get(self.gpu, kind);
        self.gpu.check()?;
        let (choice, maps) = self.upload_choice(in_use, choice, maps)?;
        let lookup = self.upload(in_use, "a lookup (bytes)", &[*lookup])?;
        let depth_maps = depth_maps.create_view(&TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2Array),
            ..Default::default()
        });
        let [choice, maps, lookup] = [&choice, &maps, &lookup].map(Buffer::as_entire_binding);
        let resources = [choice, maps, lookup, BindingResource::TextureView(&depth_maps)];
        self.in_bands(encoder, drawn, pipeline, &resources, MASK_WORDS, |pixels, bytes| {
            let (values, maps) = bytes.split_at(bytes.len() / MASK_WORDS);
            let values = bytemuck::cast_slice::<u8, f32>(values).iter().zip(bytemuck::cast_slice::<u8, i32>(maps));
            let to = into.data[pixels.clone()].iter_mut().zip(&mut into.partition[pixels]);
            for ((light, partition), (&value, &map)) in to.zip(values) {
                if map != OTHER_BATCH {
                    // The shader's -1 stands for NaN, of which WGSL knows nothing. Maps of several batches add up.
                    let is_asked = map as i16 != ShadowMask::NO_MAP;
                    *light = if value < 0.0 { f32::NAN } else { value + if is_asked { *light } else { 0.0 } };
                    *partition = map as i16;
                }
            }
        })
    }

    /// Reads the footprint of a drawn view; `encoder` holds the commands that draw it.
    pub fn read_footprint(
        &mut self,
        encoder: CommandEncoder,
        in_use: &mut InUse,
        drawn: &Drawn,
        choice: &Choice,
        maps: &[Map],
        into: &mut Footprint,
    ) -> Result<()> {
        let pipeline = &self.pipelines.surface(self.gpu)?.footprint;
        let (choice, maps) = self.upload_choice(in_use, choice, maps)?;
        let resources = [&choice, &maps].map(Buffer::as_entire_binding);
        self.in_bands(encoder, drawn, pipeline, &resources, FOOTPRINT_WORDS, |pixels, bytes| {
            let n = pixels.len();
            let words: &[u32] = bytemuck::cast_slice(bytes);
            let (planes, maps) = words.split_at(Footprint::PLANES * n);
            for (to, from) in into.planes.chunks_mut(into.map.len()).zip(planes.chunks(n)) {
                to[pixels.clone()].copy_from_slice(bytemuck::cast_slice(from));
            }
            // The shader's codes are those of the image, in 32 bits.
            into.map[pixels].iter_mut().zip(maps).for_each(|(to, &map)| *to = map as i16);
        })
    }

    /// What choose.wgsl reads, on the device.
    fn upload_choice(&mut self, in_use: &mut InUse, choice: &Choice, maps: &[Map]) -> Result<(Buffer, Buffer)> {
        let what = "the records of all maps (bytes)";
        let choice = self.upload(in_use, "how maps are chosen (bytes)", &[*choice])?;
        let maps = self.upload(in_use, what, maps)?;
        self.gpu.check_binding(what, maps.size())?;
        Ok((choice, maps))
    }

    /// Runs a shader over the pixels of a view in bands of rows; `resources` and then the result are its group 1. `take` is
    /// given the pixels of each band and their words.
    fn in_bands(
        &mut self,
        mut encoder: CommandEncoder,
        drawn: &Drawn,
        pipeline: &ComputePipeline,
        resources: &[BindingResource],
        words: usize,
        mut take: impl FnMut(Range<usize>, &[u8]),
    ) -> Result<()> {
        let [width, height] = drawn.size;
        let row_bytes = u64::from(width) * 4 * words as u64;
        let rows_at_once = (BAND_BYTES / row_bytes).clamp(1, height.into()) as u32;
        let groups_across = self.gpu.limits.max_compute_workgroups_per_dimension;
        let rows_at_once = rows_at_once.min(groups_across.saturating_mul(WORKGROUP));
        if width.div_ceil(WORKGROUP) > groups_across {
            let limit = "max_compute_workgroups_per_dimension";
            let needed = width.div_ceil(WORKGROUP).into();
            return Err(self.gpu.over_limit("the width of the image", needed, limit, groups_across.into()));
        }
        let band_bytes = row_bytes * u64::from(rows_at_once);
        self.gpu.check_binding("the results of a band of rows (bytes)", band_bytes)?;
        let result = self.state.pool.buffer(self.gpu, RESULT, band_bytes)?;
        let mut all: Vec<BindingResource> = resources.to_vec();
        all.push(result.as_entire_binding());
        let group_1 = self.bind(&pipeline.get_bind_group_layout(1), &all);
        let ids = drawn.ids.create_view(&TextureViewDescriptor::default());
        let layout_0 = pipeline.get_bind_group_layout(0);
        for first_row in (0..height).step_by(rows_at_once as usize) {
            self.progress.check()?;
            let rows = rows_at_once.min(height - first_row);
            let bytes = row_bytes * u64::from(rows);
            let mut in_use = InUse::default();
            for (group, slots) in &drawn.groups {
                let geometry = &drawn.on_device.groups[*group as usize];
                let view = drawn.view.part(first_row..first_row + rows, slots.clone());
                let view = self.upload(&mut in_use, "a view (bytes)", &[view])?;
                let group_0 = [
                    view.as_entire_binding(),
                    BindingResource::TextureView(&ids),
                    drawn.placements.as_entire_binding(),
                    geometry.vertices.as_entire_binding(),
                    geometry.indices.as_entire_binding(),
                ];
                let group_0 = self.bind(&layout_0, &group_0);
                let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &group_0, &[]);
                pass.set_bind_group(1, &group_1, &[]);
                pass.dispatch_workgroups(width.div_ceil(WORKGROUP), rows.div_ceil(WORKGROUP), 1);
            }
            let staging = self.state.pool.buffer(self.gpu, STAGING, band_bytes)?;
            encoder.copy_buffer_to_buffer(&result, 0, &staging, 0, bytes);
            self.gpu.check()?;
            let first = first_row as usize * width as usize;
            let pixels = first..first + rows as usize * width as usize;
            let recorded = std::mem::replace(&mut encoder, self.gpu.encoder("band"));
            let (gpu, pool) = (self.gpu, &mut self.state.pool);
            finish_and_read(gpu, pool, recorded, staging, bytes, self.progress, |bytes| take(pixels, bytes))?;
            in_use.release(pool);
        }
        self.state.pool.put_buffer(result);
        Ok(())
    }

    /// A bind group of resources in the order of their bindings.
    fn bind(&self, layout: &wgpu::BindGroupLayout, resources: &[BindingResource]) -> BindGroup {
        let numbered = (0u32..).zip(resources.iter().cloned());
        let entries: Vec<BindGroupEntry> =
            numbered.map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
        self.gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}
