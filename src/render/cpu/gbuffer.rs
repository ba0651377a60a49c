//! What each pixel shows: the visible triangle turned into position and normal, in f64.
//!
//! Positions are where the ray through the pixel's centre meets the plane of the triangle: exact for the triangle as it
//! stands in the scene, free of the rounding of depth buffers and of the pixel grid.

mod runs;
mod surface;

use std::mem::MaybeUninit;

use glam::DVec3;
use rayon::prelude::*;

use self::runs::{LANES, Rays, RowRays, Seen, seen};
use self::surface::Surface;
use super::passes::{NO_TRIANGLE, Pass, pixel_count};
use crate::error::Result;
use crate::image::GBuffer;
use crate::memory::{filled, unwritten, written};
use crate::progress::Progress;
use crate::render::check_extent;
use crate::scene::{Camera, Scene};
use crate::simd::dispatch;

/// The G-buffer of what `pass` sees.
pub fn gbuffer(pass: &mut Pass, camera: &Camera) -> Result<GBuffer> {
    let (scene, size, progress) = (pass.scene, pass.size, pass.progress);
    check_extent(scene)?;
    let (depth, ids) = pass.depth_and_ids()?;
    resolve(scene, camera, size, depth, &ids, progress)
}

fn resolve(
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    mut depth: Vec<f32>,
    ids: &[u32],
    progress: &Progress,
) -> Result<GBuffer> {
    let n = pixel_count(size);
    let width = size[0] as usize;
    let view =
        View { scene, camera, first_ids: scene.first_triangles(), eye_from_origin: camera.eye() - scene.origin() };
    let rays = Rays::new(camera, size);
    let (mut position, mut normal) = (unwritten::<[f32; 3]>(n)?, unwritten::<[f32; 3]>(n)?);
    let (mut triangle, mut instance) = (unwritten::<i32>(n)?, unwritten::<i32>(n)?);
    let rows = (position.par_chunks_mut(width), normal.par_chunks_mut(width));
    let rows = rows.0.zip(rows.1).zip(triangle.par_chunks_mut(width).zip(instance.par_chunks_mut(width)));
    let rows = rows.zip(ids.par_chunks(width).zip(depth.par_chunks_mut(width))).enumerate();
    rows.try_for_each_init(Known::new, |known, (y, (((position, normal), (triangle, instance)), (ids, depth)))| {
        progress.check()?;
        row(&view, &rays.row(y), ids, known, &mut RowOut { depth, position, normal, triangle, instance });
        Ok(())
    })?;
    // SAFETY: every row has been written, or the error has been returned.
    let (position, normal) = unsafe { (written(position), written(normal)) };
    let (triangle, instance) = unsafe { (written(triangle), written(instance)) };
    Ok(GBuffer { size, origin: scene.origin(), depth, position, normal, triangle, instance })
}

/// What all rows share.
struct View<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    first_ids: &'a [u64],
    eye_from_origin: DVec3,
}

/// A row of the result. Its depths come as they have been rasterised, less 1.
struct RowOut<'a> {
    depth: &'a mut [f32],
    position: &'a mut [MaybeUninit<[f32; 3]>],
    normal: &'a mut [MaybeUninit<[f32; 3]>],
    triangle: &'a mut [MaybeUninit<i32>],
    instance: &'a mut [MaybeUninit<i32>],
}

/// Triangles of the rows before, which most rows show again.
struct Known(Vec<Option<Surface>>);

impl Known {
    /// Chosen because a row of a picture shows some hundred triangles, and all of them stay in a core's cache.
    const SLOTS: usize = 1024;

    fn new() -> Self {
        Self(vec![None; Self::SLOTS])
    }

    fn surface(&mut self, view: &View, id: u32) -> &Surface {
        let slot = &mut self.0[id as usize % Self::SLOTS];
        if slot.is_none_or(|known| known.id != id) {
            *slot = None;
        }
        slot.get_or_insert_with(|| Surface::new(view.scene, view.camera, view.first_ids, id))
    }
}

dispatch! {
    /// Writes a row.
    fn row(view: &View, rays: &RowRays, ids: &[u32], known: &mut Known, out: &mut RowOut) = row_body
}

#[inline(always)]
fn row_body(view: &View, rays: &RowRays, ids: &[u32], known: &mut Known, out: &mut RowOut) {
    let mut found = Seen::NONE;
    let mut first = 0;
    while first < ids.len() {
        let id = ids[first];
        let end = ids[first..].iter().position(|other| *other != id).map_or(ids.len(), |count| first + count);
        let run = first..end;
        first = end;
        if id == NO_TRIANGLE {
            out.depth[run.clone()].fill(1.0);
            filled(&mut out.position[run.clone()], [0.0; 3]);
            filled(&mut out.normal[run.clone()], [0.0; 3]);
            filled(&mut out.triangle[run.clone()], -1);
            filled(&mut out.instance[run], -1);
            continue;
        }
        let surface = known.surface(view, id);
        filled(&mut out.triangle[run.clone()], surface.triangle);
        filled(&mut out.instance[run.clone()], surface.instance);
        for begin in run.clone().step_by(LANES) {
            let some = begin..run.end.min(begin + LANES);
            let depth = &mut out.depth[some.clone()];
            seen(surface, (view.camera, view.eye_from_origin), rays, begin, depth, &mut found);
            depth.copy_from_slice(&found.ndc_depth[..depth.len()]);
            let ([x, y, z], [nx, ny, nz]) = (&found.position, &found.normal);
            for (i, pixel) in some.enumerate() {
                out.position[pixel].write([x[i], y[i], z[i]]);
                out.normal[pixel].write([nx[i], ny[i], nz[i]]);
            }
        }
    }
}
