//! The renderer itself: the trait over the passes.

use glam::{DMat4, DVec3};

use super::casters::{asked_of, casters_of, keep_of};
use super::faces::Faces;
use super::gbuffer::gbuffer;
use super::masks::Lighting;
use super::passes::{Pass, pixel_count};
use super::scratches::Scratches;
use super::stored::StoredMap;
use crate::aliasing::footprint::footprint;
use crate::error::{Error, Result};
use crate::image::{DepthMaps, Footprint, GBuffer, ShadowMask, ShadowStates, Surfaces};
use crate::memory::{check_images, filled, unwritten, written};
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::render::{
    Casters, Cull, Keep, LightMaps, MaskSettings, Renderer, Stored, check_count, check_size, no_states,
};
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
    scratches: Scratches,
}

impl CpuRenderer {
    /// A renderer. It needs no device and always works.
    pub fn new() -> Self {
        Self::default()
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

    fn release(&self) -> Result<()> {
        self.scratches.release();
        Ok(())
    }

    fn maps_of(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        stored: Stored,
        cull: Cull,
        progress: &Progress,
    ) -> Result<DepthMaps> {
        let keep = keep_of(cull)?;
        self.draw_maps(scene, p, resolution, stored, |_| Some(keep), progress)
    }

    fn seen_maps(
        &self,
        scene: &Scene,
        surfaces: Surfaces,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<DepthMaps> {
        check_partitions(p)?;
        let asked = asked_of(surfaces, camera, light, p, settings, progress)?;
        let keep = |k: usize| asked[k].as_ref().map(Keep::Asked);
        self.draw_maps(scene, p, settings.resolution, settings.stored, keep, progress)
    }

    fn casters(
        &self,
        scene: &Scene,
        p: &Parameterization,
        cull: Cull,
        picture: Option<(Surfaces, &Camera, &Light)>,
        settings: &MaskSettings,
        progress: &Progress,
    ) -> Result<Vec<Casters>> {
        check_partitions(p)?;
        casters_of(scene, p, cull, picture, settings, progress, asked_of)
    }

    fn gbuffer(&self, scene: &Scene, camera: &Camera, size: [u32; 2], progress: &Progress) -> Result<GBuffer> {
        let size = check_size("size", size)?;
        check_images("size", 1, size, GBUFFER_BYTES)?;
        // Nearer is less.
        let clip_from_world = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * camera.reversed_clip_from_world();
        self.scratches.lend(|scratch| {
            let (faces, keep, scratch) = (Faces::All, Keep::InVolume, &mut scratch.raster);
            gbuffer(&mut Pass { scene, clip_from_world, size, faces, keep, scratch, progress }, camera)
        })
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

    fn mask_of(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        p: &Parameterization,
        settings: &MaskSettings,
        cull: Cull,
        progress: &Progress,
    ) -> Result<ShadowMask> {
        check_size("size", settings.size)?;
        check_maps(p, settings.resolution)?;
        let gbuffer = &self.gbuffer(scene, camera, settings.size, progress)?;
        let surfaces = gbuffer.surfaces();
        Lighting { scratches: &self.scratches, scene, surfaces, camera, cull, progress }.mask(light, p, settings)
    }

    fn shadow_states(
        &self,
        scene: &Scene,
        camera: &Camera,
        lights: &[LightMaps],
        settings: &MaskSettings,
        cull: Cull,
        progress: &Progress,
    ) -> Result<ShadowStates> {
        let states = no_states(lights, settings.size)?;
        lights.iter().try_for_each(|one| check_maps(one.p, one.resolution))?;
        let gbuffer = &self.gbuffer(scene, camera, settings.size, progress)?;
        let surfaces = gbuffer.surfaces();
        Lighting { scratches: &self.scratches, scene, surfaces, camera, cull, progress }
            .states(lights, settings, states)
    }
}

impl CpuRenderer {
    /// The maps of the instances that `keep` says of each; a map of which it says nothing is empty.
    fn draw_maps<'a>(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        stored: Stored,
        keep: impl Fn(usize) -> Option<Keep<'a>>,
        progress: &Progress,
    ) -> Result<DepthMaps> {
        let size = check_size("resolution", resolution)?;
        check_partitions(p)?;
        let layer = pixel_count(size);
        check_images("resolution", p.partitions.len(), size, size_of::<f32>())?;
        let mut data = unwritten::<f32>(layer * p.partitions.len())?;
        self.scratches.lend(|scratch| {
            for (k, (partition, depth)) in p.partitions.iter().zip(data.chunks_exact_mut(layer)).enumerate() {
                progress.begin_part(k, p.partitions.len());
                match keep(k) {
                    Some(keep) => StoredMap { scene, partition, size, stored, keep }.draw(depth, scratch, progress)?,
                    None => {
                        filled(depth, 1.0);
                    }
                }
            }
            Ok(())
        })?;
        // SAFETY: every layer has been drawn, or the error has been returned.
        let data = unsafe { written(data) };
        Ok(DepthMaps { layers: p.partitions.len() as u32, size, data })
    }
}

/// Refuses what no mask can be made of: no maps, too many, or such as do not fit into memory.
fn check_maps(p: &Parameterization, resolution: [u32; 2]) -> Result<()> {
    check_partitions(p)?;
    check_images("resolution", 1, check_size("resolution", resolution)?, size_of::<f32>())
}

/// Refuses a parameterization without maps.
fn check_partitions(p: &Parameterization) -> Result<()> {
    if p.partitions.is_empty() {
        return Err(Error::argument("parameterization", "at least one partition", "none", "let a technique make it"));
    }
    check_count(p)?;
    Ok(())
}
