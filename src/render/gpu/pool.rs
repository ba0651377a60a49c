//! Textures and buffers between calls: on a software device making one costs as much as drawing into it.
//!
//! What waits is bounded in bytes and in number, oldest out first, and is given back when the renderer is asked to.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages,
};

use super::device::Gpu;
use crate::error::Result;

/// Bytes that resources nobody uses at the moment may take: a 4096 x 4096 map with its way back takes 128 MiB, and a mask
/// at 4K with its images about 300 MiB.
const IDLE_BYTES: u64 = 512 << 20;
/// Textures, and buffers, that may wait: a call takes about a dozen of each, so that the sizes of a few kinds of calls stay.
/// Without it calls of ever new small sizes would leave thousands, each with its own share of the driver's memory.
const IDLE_COUNT: usize = 64;
/// Smallest buffer, and the step of sizes: mapped and copied ranges count in steps of 8 bytes.
const STEP: u64 = 8;

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

    /// A buffer of `bytes`, at least one step of sizes, or up to twice as many.
    pub fn buffer(&mut self, gpu: &Gpu, usage: BufferUsages, bytes: u64) -> Result<Buffer> {
        let size = bytes.max(1).next_multiple_of(STEP);
        let fits = |b: &Buffer| b.usage() == usage && (size..=2 * size).contains(&b.size());
        if let Some(at) = self.buffers.iter().position(fits) {
            return Ok(self.buffers.remove(at));
        }
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

    /// Bytes of what waits.
    fn bytes(&self) -> u64 {
        self.textures.iter().map(texture_bytes).sum::<u64>() + self.buffers.iter().map(Buffer::size).sum::<u64>()
    }

    fn shrink(&mut self) {
        while self.bytes() > IDLE_BYTES || self.textures.len() > IDLE_COUNT {
            // Textures first: they are the larger ones.
            if self.textures.len() > 1 || self.buffers.is_empty() {
                self.textures.remove(0);
            } else {
                self.buffers.remove(0);
            }
        }
        if self.buffers.len() > IDLE_COUNT {
            self.buffers.remove(0);
        }
    }
}

fn texture_bytes(texture: &Texture) -> u64 {
    let texels = u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texture.depth_or_array_layers());
    texels * u64::from(texture.format().block_copy_size(None).unwrap_or(4))
}

#[cfg(test)]
mod tests {
    use wgpu::Features;

    use super::super::device::tests::opened;
    use super::super::passes::INSTANCES;
    use super::super::pipelines::DEPTH;
    use super::*;

    #[test]
    fn what_waits_is_used_again() {
        let Some(gpu) = &opened(Features::empty()) else { return };
        let mut pool = Pool::default();
        // Nothing has no bytes, yet a buffer for it has, and is found again.
        for bytes in [0, 1, 8, 9, 1000] {
            let buffer = pool.buffer(gpu, INSTANCES, bytes).unwrap();
            pool.put_buffer(buffer.clone());
            assert_eq!(pool.buffer(gpu, INSTANCES, bytes).unwrap(), buffer, "{bytes}");
            assert!(pool.buffers.is_empty(), "{bytes}");
        }
    }

    #[test]
    fn what_waits_is_bounded() {
        let Some(gpu) = &opened(Features::empty()) else { return };
        let mut pool = Pool::default();
        for side in 1..200 {
            let texture = pool.texture(gpu, DEPTH, [side, 1], 1).unwrap();
            pool.put_texture(texture);
            let buffer = pool.buffer(gpu, INSTANCES, 1 << (side % 8 + 4)).unwrap();
            let more = pool.buffer(gpu, INSTANCES, 1 << (side % 8 + 4)).unwrap();
            pool.put_buffer(buffer);
            pool.put_buffer(more);
        }
        assert_eq!(pool.textures.len(), IDLE_COUNT);
        assert_eq!(pool.textures[0].width(), 200 - IDLE_COUNT as u32, "the oldest go first");
        // Two of each size at most; a larger one serves, too.
        let buffers = pool.buffers.len();
        assert!((8..=16).contains(&buffers), "{buffers}");
        // As many bytes as may wait, beside the buffers that do.
        let large = [0, 1].map(|_| pool.texture(gpu, DEPTH, [8192; 2], 1).unwrap());
        large.into_iter().for_each(|texture| pool.put_texture(texture));
        assert!(pool.bytes() <= IDLE_BYTES);
        assert_eq!((pool.textures.len(), pool.buffers.len()), (1, buffers));
    }
}
