//! Alpha tests on the device, and the draws that have them: the host's side of alpha_test.wgsl.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, BufferUsages, Extent3d,
    Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
};

use super::device::Gpu;
use crate::error::Result;
use crate::scene::{AlphaTest, AlphaTexture};

/// `AlphaTest` of alpha_test.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Values {
    size: [u32; 2],
    wrap: [u32; 2],
    threshold: f32,
    unused: u32,
}

/// The alpha test of a mesh on the device.
pub(super) struct DeviceTest {
    /// Texture coordinates by vertex.
    pub uv: Buffer,
    values: Buffer,
    levels: Texture,
}

/// Textures of a group of meshes, each on the device once: by where they are on the host.
pub(super) type Levels = HashMap<Option<*const AlphaTexture>, Texture>;

impl DeviceTest {
    /// The test of a mesh; `known` are textures that are on the device already.
    pub fn new(gpu: &Gpu, test: &AlphaTest, known: &mut Levels) -> Result<Self> {
        let parts = test.parts();
        let texture = parts.texture.as_ref();
        let key = texture.map(Arc::as_ptr);
        let levels = match known.get(&key) {
            Some(levels) => levels.clone(),
            None => known.entry(key).or_insert(levels(gpu, texture.map(|t| &**t))?).clone(),
        };
        let values = Values {
            size: [levels.width(), levels.height()],
            wrap: parts.wrap.map(|wrap| wrap as u32),
            threshold: test.threshold(),
            unused: 0,
        };
        let uv = BufferUsages::VERTEX.union(BufferUsages::STORAGE);
        Ok(Self {
            uv: gpu.filled("texture coordinates", uv, &[bytemuck::cast_slice(&parts.uv)])?,
            values: gpu.filled("alpha test", BufferUsages::UNIFORM, &[bytemuck::bytes_of(&values)])?,
            levels,
        })
    }

    /// Bytes on the device beside the texture.
    pub fn bytes(&self) -> u64 {
        self.uv.size() + self.values.size()
    }

    /// Group 0 of a pipeline.
    pub fn bind(&self, gpu: &Gpu, layout: &BindGroupLayout) -> BindGroup {
        let levels = self.levels.create_view(&TextureViewDescriptor::default());
        gpu.device.create_bind_group(&BindGroupDescriptor {
            label: Some("alpha test"),
            layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: self.values.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&levels) },
            ],
        })
    }
}

/// Bytes of textures.
pub(super) fn levels_bytes(levels: &Levels) -> u64 {
    levels.values().map(|t| u64::from(t.width()) * u64::from(t.height())).sum()
}

/// A texture's levels on the device; one opaque texel where there is none.
fn levels(gpu: &Gpu, texture: Option<&AlphaTexture>) -> Result<Texture> {
    let (size, texels) = texture.map_or(([1, 1], &[u8::MAX][..]), |t| (t.size(), t.texels()));
    gpu.check_texture("the texture of an alpha test", size, 1)?;
    let size = Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 };
    let made = gpu.device.create_texture(&TextureDescriptor {
        label: Some("alpha levels"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::R8Uint,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.check()?;
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size.width), rows_per_image: None };
    gpu.queue.write_texture(made.as_image_copy(), texels, rows, size);
    gpu.check()?;
    Ok(made)
}
