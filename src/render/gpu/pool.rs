//! Textures and buffers between calls: on a software device making one costs as much as drawing into it.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages,
};

use super::device::Gpu;
use crate::error::Result;

/// Bytes that resources nobody uses at the moment may take: a 4096 x 4096 map with its way back takes 128 MiB, and a mask
/// at 4K with its images about 300 MiB.
const IDLE_BYTES: u64 = 512 << 20;

/// Resources that wait to be used again.
#[derive(Default)]
pub(super) struct Pool {
    /// Oldest first.
    textures: Vec<Texture>,
    buffers: Vec<Buffer>,
}

impl Pool {
    /// A layered texture to draw into. Its content is whatever the last user left.
    pub fn texture(&mut self, gpu: &Gpu, format: TextureFormat, size: [u32; 2], layers: u32) -> Result<Texture> {
        gpu.check_texture("an image", size, layers)?;
        let same = |t: &Texture| {
            t.format() == format && [t.width(), t.height()] == size && t.depth_or_array_layers() == layers
        };
        if let Some(at) = self.textures.iter().position(same) {
            return Ok(self.textures.remove(at));
        }
        let texture = gpu.device.create_texture(&TextureDescriptor {
            label: Some("image"),
            size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        gpu.check()?;
        Ok(texture)
    }

    /// A buffer of `bytes` or up to twice as many.
    pub fn buffer(&mut self, gpu: &Gpu, usage: BufferUsages, bytes: u64) -> Result<Buffer> {
        let fits = |b: &Buffer| b.usage() == usage && (bytes..=2 * bytes).contains(&b.size());
        if let Some(at) = self.buffers.iter().position(fits) {
            return Ok(self.buffers.remove(at));
        }
        // Mapped and copied ranges count in steps of 8 bytes.
        let size = bytes.max(1).next_multiple_of(8);
        let buffer = gpu.device.create_buffer(&BufferDescriptor {
            label: Some("buffer"),
            size,
            usage,
            mapped_at_creation: false,
        });
        gpu.check()?;
        Ok(buffer)
    }

    /// Takes a texture back.
    pub fn put_texture(&mut self, texture: Texture) {
        self.textures.push(texture);
        self.shrink();
    }

    /// Takes a buffer back; it must not be mapped.
    pub fn put_buffer(&mut self, buffer: Buffer) {
        self.buffers.push(buffer);
        self.shrink();
    }

    fn shrink(&mut self) {
        let bytes = |pool: &Self| {
            pool.textures.iter().map(texture_bytes).sum::<u64>() + pool.buffers.iter().map(Buffer::size).sum::<u64>()
        };
        while bytes(self) > IDLE_BYTES {
            if self.textures.len() > 1 || self.buffers.is_empty() {
                self.textures.remove(0);
            } else {
                self.buffers.remove(0);
            }
        }
    }
}

fn texture_bytes(texture: &Texture) -> u64 {
    let texels = u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texture.depth_or_array_layers());
    texels * u64::from(texture.format().block_copy_size(None).unwrap_or(4))
}
