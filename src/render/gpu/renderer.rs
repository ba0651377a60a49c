//! The [`Renderer`] on a graphics device.

use std::sync::Mutex;

use wgpu::Features;

use super::adapter::AdapterInfo;
use super::device::Gpu;
use super::failure::{guarded, lock};
use super::kernel::Kernel;
use super::mask_pipelines::MaskKind;
use super::passes::{InUse, Session, State};
use super::pipelines::Pipelines;
use super::readback::{STAGING, copy_depth, depth_bytes, finish_and_read, unpad};
use super::surface::EyeSpace;
use crate::aliasing::texel::Eye;
use crate::error::{Error, Result};
use crate::image::{DepthMaps, Footprint, GBuffer, ShadowMask, Surfaces};
use crate::memory::check_images;
use crate::parameterization::{Parameterization, Partition, PostWarp};
use crate::progress::Progress;
use crate::render::cpu::{asked_of, casters_of, keep_of};
use crate::render::{
    Asked, Casters, Cull, Keep, Kernels, MaskSettings, Renderer, Stored, check_count, check_extent, check_size,
};
use crate::scene::{Camera, Light, Scene};

/// Bytes of depth maps that are drawn in one submission; more are drawn in several. Chosen to hold sixteen maps at 2048²
/// and to keep what one call takes on the device, twice this, well inside any device's memory.
const BATCH_BYTES: u64 = 256 << 20;

/// What is used of a device where it has it: numbers of triangles in shaders, and double precision.
pub(super) const FEATURES: Features = Features::PRIMITIVE_INDEX.union(Features::SHADER_F64);

/// Draws on a graphics device. Scenes, textures and buffers stay there between calls; threads take turns.
pub struct GpuRenderer {
    gpu: Gpu,
    pipelines: Pipelines,
    state: Mutex<State>,
}

impl GpuRenderer {
    /// A renderer on the adapter whose name or backend contains `adapter`, in any case; without one, on a discrete one if
    /// there is any, else an integrated one, else a software one.
    ///
    /// # Errors
    /// [`crate::Error::NoAdapter`] with the adapters found, [`crate::Error::Device`] where it cannot be opened.
    pub fn new(adapter: Option<&str>) -> Result<Self> {
        guarded(|| Self::on(Gpu::open(adapter, FEATURES)?))
    }

    pub(super) fn on(gpu: Gpu) -> Result<Self> {
        let pipelines = Pipelines::new(&gpu)?;
        Ok(Self { gpu, pipelines, state: Mutex::default() })
    }

    /// The adapter in use.
    pub fn adapter_info(&self) -> &AdapterInfo {
        &self.gpu.info
    }

    /// Whether positions and places in maps are computed in double precision, so that masks have the light of the processor but
    /// for the rounding of weights; without it places are rounded to a few 2^-24 of the map's size (docs/filters.md).
    pub fn has_double(&self) -> bool {
        self.gpu.device.features().contains(Features::SHADER_F64)
    }

    /// How many maps of so many bytes are drawn in one submission.
    fn maps_at_once(&self, map_bytes: u64, bytes: u64) -> usize {
        (bytes / map_bytes).clamp(1, self.gpu.limits.max_texture_array_layers.into()) as usize
    }

    /// The maps, each of what it keeps.
    fn draw_maps(
        &self,
        scene: &Scene,
        p: &Parameterization,
        resolution: [u32; 2],
        stored: Stored,
        keep: &[Keep],
        progress: &Progress,
    ) -> Result<DepthMaps> {
        check_size("resolution", resolution)?;
        self.gpu.check_texture("a shadow map", resolution, 1)?;
        self.gpu.check_buffer("a shadow map on its way back (bytes)", depth_bytes(resolution, 1))?;
        let count = p.partitions.len();
        let texels = resolution[0] as usize * resolution[1] as usize;
        let batch = self.maps_at_once(depth_bytes(resolution, 1), BATCH_BYTES.min(self.gpu.limits.max_buffer_size));
        check_images("resolution", count, resolution, size_of::<f32>())?;
        let mut data = vec![0.0; texels * count];
        self.work(progress, |session| {
            let batches = p.partitions.chunks(batch).zip(keep.chunks(batch));
            for ((partitions, keep), maps) in batches.zip(data.chunks_mut(texels * batch)) {
                session.depth_batch(scene, partitions, resolution, (stored, keep), maps)?;
            }
            Ok(())
        })?;
        Ok(DepthMaps { layers: count as u32, size: resolution, data })
    }

    /// Does one call's work while no other thread is at work.
    fn work<T>(&self, progress: &Progress, work: impl FnOnce(&mut Session) -> Result<T>) -> Result<T> {
        let mut state = lock(&self.state);
        let (gpu, pipelines) = (&self.gpu, &self.pipelines);
        guarded(|| {
            gpu.check()?;
            work(&mut Session { gpu, pipelines, state: &mut state, progress })
        })
    }
}

impl Renderer for GpuRenderer {
    fn backend(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> String {
        self.gpu.info.to_string()
    }

    fn release(&self) -> Result<()> {
        guarded(|| {
            lock(&self.state).release();
            self.gpu.settle()
        })
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
        check_partitions(p)?;
        self.draw_maps(scene, p, resolution, stored, &vec![keep_of(cull)?; p.partitions.len()], progress)
    }

    /// Of a map that no pixel asks what is in its volume: drawing it costs a device little.
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
        let asked = texels_asked(surfaces, camera, light, p, settings, progress)?;
        let keep: Vec<Keep> = asked.iter().map(|asked| asked.as_ref().map_or(Keep::InVolume, Keep::Asked)).collect();
        self.draw_maps(scene, p, settings.resolution, settings.stored, &keep, progress)
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
        casters_of(scene, p, cull, picture, settings, progress, texels_asked)
    }

    fn gbuffer(&self, scene: &Scene, camera: &Camera, size: [u32; 2], progress: &Progress) -> Result<GBuffer> {
        check_size("size", size)?;
        check_extent(scene)?;
        self.gpu.check_texture("a G-buffer", size, 1)?;
        check_images("size", 1, size, GBuffer::BYTES)?;
        let pixels = size[0] as usize * size[1] as usize;
        let mut gbuffer = GBuffer {
            size,
            origin: scene.origin(),
            depth: vec![0.0; pixels],
            position: vec![[0.0; 3]; pixels],
            normal: vec![[0.0; 3]; pixels],
            triangle: vec![0; pixels],
            instance: vec![0; pixels],
        };
        self.work(progress, |session| {
            let mut in_use = InUse::default();
            let mut encoder = self.gpu.encoder("G-buffer");
            let drawn = session.draw_ids(&mut encoder, &mut in_use, scene, camera, size)?;
            session.read_gbuffer(encoder, &drawn, &mut gbuffer)?;
            in_use.release(&mut session.state.pool);
            Ok(())
        })?;
        Ok(gbuffer)
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
        check_size("size", size)?;
        check_maps(p)?;
        check_extent(scene)?;
        self.gpu.check_texture("a footprint", size, 1)?;
        let space = EyeSpace::new(scene, camera);
        let (choice, maps) = (space.choice(light, p), space.maps(p, resolution)?);
        let pixels = size[0] as usize * size[1] as usize;
        check_images("size", 1, size, Footprint::BYTES)?;
        let mut footprint = Footprint { size, planes: vec![0.0; Footprint::PLANES * pixels], map: vec![0; pixels] };
        self.work(progress, |session| {
            let mut in_use = InUse::default();
            let mut encoder = self.gpu.encoder("footprint");
            let drawn = session.draw_ids(&mut encoder, &mut in_use, scene, camera, size)?;
            session.read_footprint(encoder, &mut in_use, &drawn, &choice, &maps, &mut footprint)?;
            in_use.release(&mut session.state.pool);
            Ok(())
        })?;
        Ok(footprint)
    }

    /// [`Cull::Seen`] draws what [`Cull::Volume`] does: the picture stays on the device here. A G-buffer drawn for the processor to
    /// mark what its pixels look up left out a third of the casters of a forest of 10,000 trees, and the mask took 1.25 times as long
    /// (llvmpipe, a map of 1024²). [`Renderer::seen_maps`] is given the picture, and leaves them out.
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
        let keep = if cull == Cull::Seen { Keep::InVolume } else { keep_of(cull)? };
        let size = check_size("size", settings.size)?;
        let resolution = check_size("resolution", settings.resolution)?;
        check_partitions(p)?;
        check_extent(scene)?;
        self.gpu.check_texture("a shadow mask", size, 1)?;
        self.gpu.check_texture("a shadow map", resolution, 1)?;
        let space = EyeSpace::new(scene, camera);
        let kernels = Kernels::new(settings.filter, Some(Eye::new(camera, scene.origin(), size)))?;
        let (kind, kernel) = (MaskKind::new(settings), Kernel::new(&settings.filter, &kernels));
        let (choice, lookup) = (space.choice(light, p), space.lookup(settings, kernel)?);
        let maps = space.maps_of(p, resolution, settings.stored)?;
        let pixels = size[0] as usize * size[1] as usize;
        let mut mask = ShadowMask { size, data: vec![0.0; pixels], partition: vec![ShadowMask::NO_MAP; pixels] };
        let batch = self.maps_at_once(depth_bytes(resolution, 1), BATCH_BYTES);
        self.work(progress, |session| {
            let mut in_use = InUse::default();
            let mut encoder = self.gpu.encoder("shadow mask");
            let drawn = session.draw_ids(&mut encoder, &mut in_use, scene, camera, size)?;
            for (first, partitions) in (0..p.partitions.len()).step_by(batch).zip(p.partitions.chunks(batch)) {
                let mut in_use = InUse::default();
                let (stored, keep) = (settings.stored, vec![keep; partitions.len()]);
                let depth_maps =
                    session.draw_stored(&mut encoder, &mut in_use, scene, partitions, resolution, stored, &keep)?;
                let lookup = lookup.part(first..first + partitions.len());
                let recorded = std::mem::replace(&mut encoder, self.gpu.encoder("shadow mask"));
                session.read_mask(
                    recorded,
                    &mut in_use,
                    &drawn,
                    (kind, &choice, &lookup),
                    &maps,
                    &depth_maps,
                    &mut mask,
                )?;
                in_use.release(&mut session.state.pool);
            }
            in_use.release(&mut session.state.pool);
            Ok(())
        })?;
        Ok(mask)
    }
}

impl Session<'_> {
    /// Depth maps drawn in one submission and read into `maps`.
    fn depth_batch(
        &mut self,
        scene: &Scene,
        partitions: &[Partition],
        size: [u32; 2],
        (stored, keep): (Stored, &[Keep]),
        maps: &mut [f32],
    ) -> Result<()> {
        let mut in_use = InUse::default();
        let mut encoder = self.gpu.encoder("depth maps");
        let texture = self.draw_stored(&mut encoder, &mut in_use, scene, partitions, size, stored, keep)?;
        let bytes = depth_bytes(size, partitions.len() as u32);
        let staging = self.state.pool.buffer(self.gpu, STAGING, bytes)?;
        copy_depth(&mut encoder, &texture, &staging);
        finish_and_read(self.gpu, &mut self.state.pool, encoder, staging, bytes, self.progress, |padded| {
            unpad(padded, size[0] as usize, maps);
        })?;
        in_use.release(&mut self.state.pool);
        Ok(())
    }
}

/// What the pixels of a picture look up in each map, depths aside: a device may give a texel of a sliver any depth.
fn texels_asked(
    surfaces: Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
    progress: &Progress,
) -> Result<Vec<Option<Asked>>> {
    let asked = asked_of(surfaces, camera, light, p, settings, progress)?;
    Ok(asked.into_iter().map(|asked| asked.map(Asked::of_texels)).collect())
}

/// A parameterization has maps that can be drawn: [`check_maps`], and all are projective.
fn check_partitions(p: &Parameterization) -> Result<()> {
    check_maps(p)?;
    let kind = p.partitions.iter().find_map(|p| match p.post_warp {
        PostWarp::None => None,
        PostWarp::Log { .. } => Some("a logarithmic post-warp"),
        PostWarp::Rectilinear(_) => Some("a rectilinear post-warp"),
    });
    match kind {
        None => Ok(()),
        Some(kind) => {
            let fix = "draw it with the cpu renderer, which is exact";
            Err(Error::argument("parameterization", "projective maps", kind, fix))
        }
    }
}

/// A parameterization has maps, and each has a finite matrix.
fn check_maps(p: &Parameterization) -> Result<()> {
    if p.partitions.is_empty() {
        return Err(Error::argument("partitions", "at least one", "none", "parameterize again"));
    }
    check_count(p)?;
    if p.partitions.iter().any(|p| !p.shadow_clip_from_world.is_finite()) {
        let fix = "check where the matrix comes from";
        return Err(Error::argument("shadow_clip_from_world", "16 finite numbers", "a NaN or an infinity", fix));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DVec3};

    use super::super::device::tests::opened;
    use super::*;
    use crate::Mesh;
    use crate::scene::Instance;

    /// A renderer that uses at most the given features; none on a machine without adapters.
    fn renderer(allowed: Features) -> Option<GpuRenderer> {
        opened(allowed).map(|gpu| GpuRenderer::on(gpu).unwrap())
    }

    /// Instances of two meshes, in turn, on a spiral.
    fn spiral() -> Scene {
        let tent = [[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
        let sides = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let floor = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
        let meshes = [Mesh::new(&tent, &sides), Mesh::new(&floor, &[[0, 1, 2], [0, 2, 3]])];
        let instances = (0..60).map(|i| {
            let angle = f64::from(i) * 0.7;
            let place =
                DVec3::new(angle.cos(), 0.02 * f64::from(i), angle.sin()) * DVec3::new(0.4 * angle, 1.0, 0.4 * angle);
            let size = DVec3::new(1.0, if i % 3 == 0 { -1.0 } else { 1.0 }, 0.7);
            let turn = DAffine3::from_rotation_y(angle);
            let world_from_mesh = DAffine3::from_translation(place) * turn * DAffine3::from_scale(size);
            Instance { mesh: i % 2, world_from_mesh }
        });
        Scene::new(meshes.map(|m| Arc::new(m.unwrap())).to_vec(), instances.collect()).unwrap()
    }

    #[test]
    fn triangles_are_told_alike_with_and_without_the_feature() {
        let (Some(with), Some(without)) = (renderer(Features::PRIMITIVE_INDEX), renderer(Features::empty())) else {
            return;
        };
        let (scene, progress) = (spiral(), Progress::new());
        let eye = DVec3::new(8.0, 12.0, 9.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 1.2, 1.5, 0.1, 100.0).unwrap();
        let a = with.gbuffer(&scene, &camera, [300, 200], &progress).unwrap();
        let b = without.gbuffer(&scene, &camera, [300, 200], &progress).unwrap();
        assert!(a.triangle.iter().filter(|&&t| t > 1).count() > 500);
        assert_eq!(a, b);
    }

    #[test]
    fn a_size_over_a_limit_of_the_device_names_the_limit() {
        let Some(mut renderer) = renderer(Features::PRIMITIVE_INDEX) else { return };
        let (scene, progress) = (spiral(), Progress::new());
        let camera = Camera::look_at(DVec3::splat(20.0), DVec3::ZERO, DVec3::Y, 1.0, 1.0, 0.1, 100.0).unwrap();
        let named = |result: Result<GBuffer>, limit: &str| match result {
            Err(Error::Device { what, .. }) => assert!(what.contains(limit), "{what}"),
            other => panic!("{:?}", other.map(|g| g.size)),
        };
        renderer.gpu.limits.max_texture_dimension_2d = 64;
        named(renderer.gbuffer(&scene, &camera, [65, 3], &progress), "max_texture_dimension_2d");
        renderer.gpu.limits.max_storage_buffer_binding_size = 16;
        named(renderer.gbuffer(&scene, &camera, [32, 32], &progress), "max_storage_buffer_binding_size");
        renderer.gpu.limits.max_buffer_size = 16;
        named(renderer.gbuffer(&scene, &camera, [32, 32], &progress), "max_buffer_size");
    }

    #[test]
    fn meshes_that_share_no_binding_are_drawn_in_groups() {
        let Some(mut renderer) = renderer(Features::PRIMITIVE_INDEX) else { return };
        let (scene, progress) = (spiral(), Progress::new());
        let eye = DVec3::new(8.0, 12.0, 9.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 1.2, 1.5, 0.1, 100.0).unwrap();
        let together = renderer.gbuffer(&scene, &camera, [150, 100], &progress).unwrap();
        lock(&renderer.state).scenes = Default::default();
        // Room for the five vertices of the larger mesh, not for both meshes; the other limits do not matter here.
        renderer.gpu.limits.max_buffer_size = renderer.gpu.limits.max_storage_buffer_binding_size.min(1 << 30);
        let whole = renderer.gpu.limits.max_storage_buffer_binding_size;
        renderer.gpu.limits.max_storage_buffer_binding_size = 5 * 12;
        lock(&renderer.state).scenes.get(&renderer.gpu, &scene, &progress).unwrap();
        renderer.gpu.limits.max_storage_buffer_binding_size = whole;
        assert_eq!(lock(&renderer.state).scenes.get(&renderer.gpu, &scene, &progress).unwrap().groups.len(), 2);
        assert_eq!(renderer.gbuffer(&scene, &camera, [150, 100], &progress).unwrap(), together);
    }
}
