//! The renderer itself: the trait over the passes.

use std::mem::MaybeUninit;
use std::sync::Mutex;

use glam::{DMat4, DVec3};

use super::gbuffer::gbuffer;
use super::lookup::{Lookups, MaskInput};
use super::passes::{Pass, checked_matrix, pixel_count};
use super::raster::Scratch;
use super::uneven_lattice::Lattice;
use crate::aliasing::footprint::footprint;
use crate::error::{Error, Result};
use crate::image::{DepthMaps, Footprint, GBuffer, ShadowMask};
use crate::memory::{check_images, unwritten, written};
use crate::parameterization::{Parameterization, Partition, PostWarp};
use crate::progress::Progress;
use crate::render::{MaskSettings, Renderer, check_count, check_size};
use crate::scene::{Camera, Light, Scene};

/// Of a pixel while a G-buffer is drawn: it, and the depths and numbers of triangles that it is made of.
const GBUFFER_BYTES: usize = GBuffer::BYTES + 2 * size_of::<f32>();

/// Renders on the processor, with as many threads as the rayon pool it is called from.
///
/// ```
/// use shadowlab::render::{Renderer, cpu::CpuRenderer};
/// use shadowlab::{Camera, Mesh, Progress, Scene};
/// use glam::DVec3;
///
/// let mesh = Mesh::new(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let camera = Camera::look_at(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y, 1.0, 1.0, 0.1, 10.0)?;
/// let g = CpuRenderer::new().gbuffer(&Scene::from_mesh(mesh)?, &camera, [64, 64], &Progress::new())?;
/// assert_eq!(g.triangle[32 * 64 + 32], 0);
/// assert_eq!(g.normal[32 * 64 + 32], [0.0, 0.0, 1.0]);
/// # Ok::<(), shadowlab::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct CpuRenderer {
    /// Memory of finished calls for the next ones.
    scratch: Mutex<Vec<Scratch>>,
}

impl CpuRenderer {
    /// A renderer. It needs no device and always works.
    pub fn new() -> Self {
        Self::default()
    }

    /// Runs with scratch memory that no other call uses.
    fn with_scratch<T>(&self, work: impl FnOnce(&mut Scratch) -> Result<T>) -> Result<T> {
        // Nobody waits for it: after a fork the lock may be held by a thread that does not exist.
        let mut scratch = self.scratch.try_lock().ok().and_then(|mut free| free.pop()).unwrap_or_default();
        let result = work(&mut scratch);
        scratch.shrink();
        if let Ok(mut free) = self.scratch.try_lock() {
            free.push(scratch);
        }
        result
    }
}

impl Renderer for CpuRenderer {
    fn backend(&self) -> &'static str {
        "cpu"
    }

    fn adapter(&self) -> String {
        let threads = rayon::current_num_threads();
        format!("{} ({threads} thread{})", std::env::consts::ARCH, if threads == 1 { "" } else { "s" })
    }

    fn depth_maps(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        progress: &Progress,
    ) -> Result<DepthMaps> {
        let size = check_size("resolution", resolution)?;
        check_partitions(p)?;
        let layer = pixel_count(size);
        check_images("resolution", p.partitions.len(), size, size_of::<f32>())?;
        let mut data = unwritten::<f32>(layer * p.partitions.len())?;
        self.with_scratch(|scratch| {
            for (partition, depth) in p.partitions.iter().zip(data.chunks_exact_mut(layer)) {
                draw_map(scene, partition, size, depth, scratch, progress)?;
            }
            Ok(())
        })?;
        // SAFETY: every layer has been drawn, or the error has been returned.
        let data = unsafe { written(data) };
        Ok(DepthMaps { layers: p.partitions.len() as u32, size, data })
    }

    fn gbuffer(&self, scene: &Scene, camera: &Camera, size: [u32; 2], progress: &Progress) -> Result<GBuffer> {
        let size = check_size("size", size)?;
        check_images("size", 1, size, GBUFFER_BYTES)?;
        // Nearer is less.
        let clip_from_world = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * camera.reversed_clip_from_world();
        self.with_scratch(|scratch| gbuffer(&mut Pass { scene, clip_from_world, size, scratch, progress }, camera))
    }

    fn footprint(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        resolution: [u32; 2],
        size: [u32; 2],
        progress: &Progress,
    ) -> Result<Footprint> {
        check_size("resolution", resolution)?;
        check_images("size", 1, check_size("size", size)?, GBUFFER_BYTES + Footprint::BYTES)?;
        let gbuffer = self.gbuffer(scene, camera, size, progress)?;
        footprint(&gbuffer.surfaces(), camera, light, p, resolution, progress)
    }

    fn shadow_mask(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<ShadowMask> {
        check_size("size", settings.size)?;
        check_size("resolution", settings.resolution)?;
        check_partitions(p)?;
        check_images("resolution", 1, settings.resolution, size_of::<f32>())?;
        let lookups = &Lookups::new(p, camera, light, scene.origin(), settings)?;
        let gbuffer = &self.gbuffer(scene, camera, settings.size, progress)?;
        let input = MaskInput { surfaces: gbuffer.surfaces(), camera, light, lookups, progress };
        let size = settings.resolution;
        self.with_scratch(|scratch| {
            input.mask(|k, depth| draw_map(scene, &p.partitions[k], size, depth, scratch, progress))
        })
    }
}

/// Draws one map into all of `depth`.
fn draw_map(
    scene: &Scene,
    partition: &Partition,
    size: [u32; 2],
    depth: &mut [MaybeUninit<f32>],
    scratch: &mut Scratch,
    progress: &Progress,
) -> Result<()> {
    let clip_from_world = checked_matrix(&partition.shadow_clip_from_world)?;
    match &partition.post_warp {
        PostWarp::None => Pass { scene, clip_from_world, size, scratch, progress }.depth(depth),
        PostWarp::Log { scale, offset } => {
            Lattice::logarithmic(&clip_from_world, *scale, *offset, size)?.depth(scene, depth, progress)
        }
        PostWarp::Rectilinear(warp) => Lattice::rectilinear(&clip_from_world, warp, size).depth(scene, depth, progress),
    }
}

/// Refuses a parameterization without maps.
fn check_partitions(p: &Parameterization) -> Result<()> {
    if p.partitions.is_empty() {
        return Err(Error::argument("parameterization", "at least one partition", "none", "let a technique make it"));
    }
    check_count(p)?;
    Ok(())
}
