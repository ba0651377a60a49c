//! The way back to the host: one copy on the device into a mappable buffer, one wait, one copy into the result.

use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use wgpu::{Buffer, BufferUsages, CommandEncoder, MapMode};
use wgpu::{COPY_BYTES_PER_ROW_ALIGNMENT, Extent3d, TexelCopyBufferInfo, TexelCopyBufferLayout, Texture};

use super::device::Gpu;
use super::failure::lock;
use super::pool::Pool;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// How staging buffers are used.
pub(super) const STAGING: BufferUsages = BufferUsages::COPY_DST.union(BufferUsages::MAP_READ);

/// Bytes of a row of texels in a buffer, as copies want it.
pub(super) fn padded_row(texels: u32, texel_bytes: u32) -> u32 {
    (texels * texel_bytes).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Bytes that the layers of a depth texture take in a buffer.
pub(super) fn depth_bytes(size: [u32; 2], layers: u32) -> u64 {
    u64::from(padded_row(size[0], 4)) * u64::from(size[1]) * u64::from(layers)
}

/// Records the copy of all layers of a depth texture into a buffer.
pub(super) fn copy_depth(encoder: &mut CommandEncoder, texture: &Texture, buffer: &Buffer) {
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(padded_row(texture.width(), 4)),
        rows_per_image: Some(texture.height()),
    };
    let size = Extent3d {
        width: texture.width(),
        height: texture.height(),
        depth_or_array_layers: texture.depth_or_array_layers(),
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), TexelCopyBufferInfo { buffer, layout }, size);
}

/// Sends the commands, waits, and gives the first `bytes` of the staging buffer to `take`. The buffer goes back to the pool.
pub(super) fn finish_and_read<T>(
    gpu: &Gpu,
    pool: &mut Pool,
    encoder: CommandEncoder,
    staging: Buffer,
    bytes: u64,
    progress: &Progress,
    take: impl FnOnce(&[u8]) -> T,
) -> Result<T> {
    let mapped = Arc::new(Mutex::new(None));
    let told = mapped.clone();
    let range = 0..bytes.next_multiple_of(8).min(staging.size());
    encoder.map_buffer_on_submit(&staging, MapMode::Read, range.clone(), move |result| *lock(&told) = Some(result));
    gpu.finish(encoder.finish(), progress)?;
    let told = lock(&mapped).take();
    let failed = |what: String| Error::Device { what, fix: "try again, or use backend \"cpu\"".into() };
    match told {
        Some(Ok(())) => {}
        Some(Err(error)) => return Err(failed(format!("the result could not be mapped: {error}"))),
        None => return Err(failed("the result was not mapped when the work was done".into())),
    }
    let view = staging.get_mapped_range(range).map_err(|error| failed(error.to_string()))?;
    let taken = take(&view[..bytes as usize]);
    drop(view);
    staging.unmap();
    pool.put_buffer(staging);
    Ok(taken)
}

/// Copies rows of `width` values out of padded ones.
pub(super) fn unpad(padded: &[u8], width: usize, rows: &mut [f32]) {
    let stride = padded_row(width as u32, 4) as usize;
    // Blocks of rows of about a MiB: enough for a thread to be worth waking.
    let block = (1usize << 20).div_ceil(stride);
    let work = |(target, source): (&mut [f32], &[u8])| {
        for (target, source) in target.chunks_exact_mut(width).zip(source.chunks_exact(stride)) {
            target.copy_from_slice(bytemuck::cast_slice(&source[..4 * width]));
        }
    };
    rows.par_chunks_mut(block * width).zip(padded.par_chunks(block * stride)).for_each(work);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_out_of_their_padding() {
        let (width, height) = (65, 5000);
        let stride = padded_row(width as u32, 4) as usize;
        assert_eq!(stride, 512);
        let mut padded = vec![f32::MAX; stride / 4 * height];
        for (i, x) in padded.iter_mut().enumerate().filter(|(i, _)| i % (stride / 4) < width) {
            *x = (i / (stride / 4) * width + i % (stride / 4)) as f32;
        }
        let mut rows = vec![0.0; width * height];
        unpad(bytemuck::cast_slice(&padded), width, &mut rows);
        assert!(rows.iter().enumerate().all(|(i, &x)| x == i as f32));
    }
}
