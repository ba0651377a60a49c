//! Maps that store more than the nearest depth in single precision: the depths of one or two layers are drawn, and then turned
//! into what is stored.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec2, DVec3, DVec4};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindingResource, BufferUsages, CommandEncoder, RenderPassDescriptor,
    RenderPipeline, Texture, TextureView,
};

use super::exact::Depths;
use super::layer_pipelines::{Encoding, Fragments};
use super::passes::{DepthPipelines, InUse, PassList, Session, Target, depth_attachment, layer_view};
use super::pipelines::DEPTH;
use crate::error::Result;
use crate::parameterization::Partition;
use crate::render::Keep;
use crate::render::stored::{Format, Spacing, Stored, StoredSurface, TexelRays};
use crate::scene::Scene;

const UNIFORM: BufferUsages = BufferUsages::UNIFORM.union(BufferUsages::COPY_DST);

/// `Settings` of stored.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Settings {
    far_depth: [f32; 4],
    near_depth: [f32; 4],
    far_w: [f32; 4],
    near_w: [f32; 4],
    columns: [[f32; 4]; 4],
    size: [f32; 2],
    limit: f32,
    unused: f32,
}

impl Encoding {
    /// That of what is stored.
    pub fn of(stored: Stored) -> Self {
        let surface = match stored.surface {
            _ if stored.is_plain() => 0,
            StoredSurface::Front | StoredSurface::Back => 1,
            StoredSurface::Second => 2,
            StoredSurface::Midpoint => 3,
            StoredSurface::Dual => 4,
        };
        let format = match stored.format {
            Format::F32 => 0,
            Format::F16 => 1,
            Format::Unorm16 | Format::Unorm24 => stored.format.levels().map_or(0, |levels| levels as u32),
        };
        Self { surface, spacing: u32::from(stored.spacing == Spacing::Linear), format }
    }
}

/// A functional of (x, y, 1), x and y in [-1, 1], by its least value and what it gains to the right and down.
fn by_gains(f: DVec3) -> [f32; 4] {
    // y goes up.
    [f.z - f.x.abs() - f.y.abs(), 2.0 * f.x, -2.0 * f.y, 0.0].map(|x| x as f32)
}

impl Settings {
    fn new(partition: &Partition, scene: &Scene, size: [u32; 2], stored: Stored) -> Result<Self> {
        let settings = Self {
            size: size.map(|n| n as f32),
            limit: stored.limit.min(f64::from(f32::MAX)) as f32,
            ..Self::zeroed()
        };
        if stored.is_plain() {
            return Ok(settings);
        }
        // Relative to the middle of the map and in units of its size, a power of two.
        let at = |origin: DVec3, unit: f64| {
            partition.shadow_clip_from_world * DMat4::from_translation(origin) * DMat4::from_scale(DVec3::splat(unit))
        };
        let rays = |m: &DMat4| TexelRays::new(m, &partition.post_warp, size);
        let middle = scene.origin() + rays(&at(scene.origin(), 1.0))?.middle();
        let about = rays(&at(middle, 1.0))?;
        let reach = about.reach();
        let unit = 2f64.powi((reach.log2().ceil() as i32).clamp(-1000, 1000));
        let about = rays(&at(middle, unit))?;
        let inverse = about.inverse;
        let row = match stored.spacing {
            Spacing::Linear => about.linear_row()?,
            Spacing::Projective => DVec4::ZERO,
        };
        let rows = inverse.transpose();
        let of = |row: DVec4, z: f64| DVec3::new(row.x, row.y, row.w + z * row.z);
        let (depth, w) = (rows * row, rows.w_axis);
        // Clip coordinates are homogeneous: one factor of them all.
        let scale = 2f64.powi(-(of(w, 0.5).abs().max_element().log2().floor() as i32).clamp(-1000, 1000));
        let affine = |row: DVec4, z: f64| by_gains(of(row, z) * scale);
        let step = DVec2::new(2.0 / f64::from(size[0]), 2.0 / f64::from(size[1]));
        let columns = [inverse.x_axis * step.x, inverse.y_axis * step.y, inverse.z_axis, inverse.w_axis];
        Ok(Self {
            far_depth: affine(depth, 1.0),
            near_depth: affine(depth, 0.0),
            far_w: affine(w, 1.0),
            near_w: affine(w, 0.0),
            columns: columns.map(|column| (column * scale).as_vec4().to_array()),
            ..settings
        })
    }
}

impl Session<'_> {
    /// Records the maps of some partitions, each of what it keeps, as they are stored; gives the texture, one layer each.
    #[allow(clippy::too_many_arguments)]
    pub fn draw_stored(
        &mut self,
        encoder: &mut CommandEncoder,
        in_use: &mut InUse,
        scene: &Scene,
        partitions: &[Partition],
        size: [u32; 2],
        stored: Stored,
        keep: &[Keep],
    ) -> Result<Texture> {
        let forward: Vec<DMat4> = partitions.iter().map(|p| p.shadow_clip_from_world).collect();
        let stored = stored.checked()?;
        if stored.is_plain() && stored.surface == StoredSurface::Front && stored.format == Format::F32 {
            return self.draw_depth(encoder, in_use, scene, &forward, size, keep);
        }
        let settings = partitions.iter().map(|p| Settings::new(p, scene, size, stored)).collect::<Result<Vec<_>>>()?;
        let is_reversed = !stored.is_plain();
        let fragments = if stored.surface == StoredSurface::Back { Fragments::Averted } else { Fragments::All };
        let (clips, depths) = match is_reversed {
            true => (forward.iter().map(reversed).collect(), Depths::Reversed),
            false => (forward, Depths::Forward),
        };
        let list = self.list(in_use, scene, &clips, size, (depths, keep), fragments == Fragments::Averted)?;
        let pipelines = self.layer_pipelines(&list, fragments, is_reversed)?;
        let behind = match stored.surface.takes_two() {
            true => Some(self.layer_pipelines(&list, Fragments::Behind, is_reversed)?),
            false => None,
        };
        let texture = self.state.pool.texture(self.gpu, DEPTH, size, partitions.len() as u32)?;
        in_use.textures.push(texture.clone());
        let mut layer = || -> Result<TextureView> {
            let layer = self.state.pool.texture(self.gpu, DEPTH, size, 1)?;
            in_use.textures.push(layer.clone());
            Ok(layer_view(&layer, 0))
        };
        let first = layer()?;
        let second = if behind.is_some() { layer()? } else { first.clone() };
        let encoding = self.state.layers.encoding(self.gpu, Encoding::of(stored));
        self.gpu.check()?;
        for (k, settings) in settings.iter().enumerate() {
            self.progress.check()?;
            let target = if is_reversed { Target::REVERSED } else { Target::FORWARD };
            self.record(encoder, in_use, &list, k, &first, &pipelines, target)?;
            if let Some(behind) = &behind {
                let target = Target { first: Some(&first), ..Target::REVERSED };
                self.record(encoder, in_use, &list, k, &second, behind, target)?;
            }
            self.encode(encoder, in_use, &encoding, settings, [&first, &second], &layer_view(&texture, k as u32))?;
        }
        self.gpu.check()?;
        Ok(texture)
    }

    fn layer_pipelines(&mut self, list: &PassList, fragments: Fragments, is_reversed: bool) -> Result<DepthPipelines> {
        let layers = &mut self.state.layers;
        let plain = layers.plain(self.gpu, fragments, is_reversed);
        let tested = list.is_tested().then(|| layers.tested(self.gpu, fragments, is_reversed));
        self.gpu.check()?;
        Ok(DepthPipelines { plain, tested })
    }

    /// Records how drawn depths become stored ones.
    pub fn encode(
        &mut self,
        encoder: &mut CommandEncoder,
        in_use: &mut InUse,
        pipeline: &RenderPipeline,
        settings: &Settings,
        [first, second]: [&TextureView; 2],
        into: &TextureView,
    ) -> Result<()> {
        let bytes = bytemuck::bytes_of(settings);
        let uniform = self.state.pool.buffer(self.gpu, UNIFORM, bytes.len() as u64)?;
        in_use.buffers.push(uniform.clone());
        self.gpu.queue.write_buffer(&uniform, 0, bytes);
        let group = self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: Some("stored"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: BindingResource::TextureView(first) },
                BindGroupEntry { binding: 2, resource: BindingResource::TextureView(second) },
            ],
        });
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("stored"),
            depth_stencil_attachment: Some(depth_attachment(into, 1.0)),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

/// The matrix with depth 1 at the near plane and 0 at the far plane.
fn reversed(clip_from_world: &DMat4) -> DMat4 {
    DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::NEG_Z, DVec4::new(0.0, 0.0, 1.0, 1.0)) * *clip_from_world
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_have_the_layout_of_the_shader() {
        // WGSL aligns a vec4f to 16 bytes, and the whole as well.
        assert_eq!((size_of::<Settings>(), std::mem::offset_of!(Settings, limit)), (144, 136));
    }
}
