//! Whether light arrives at surface points that are known: those of a G-buffer, wherever their instances have moved since.

use rayon::prelude::*;

use super::hierarchy::{Inner, Tracer};
use super::kernel::{Kernel, dispatched};
use super::rays::{BUNDLE, WorldRay, WorldRays};
use super::seen::Seen;
use super::shading::{Lamp, Shader};
use super::walk::{Closest, Stacks};
use crate::error::{Error, Result};
use crate::image::{Surfaces, TruthMask};
use crate::memory::with_room;
use crate::progress::Progress;
use crate::scene::Light;

/// Pixels between two looks at whether to go on: less than a millisecond of work.
const AT_ONCE: usize = 64 * BUNDLE;

impl Tracer {
    /// What light does at each surface point of an image, on the side of its normal: as [`Tracer::shadow_mask`] answers for
    /// the point that it finds itself. Points are taken onto the plane of their triangle, so that their rounding to single
    /// precision does not lift them off it.
    ///
    /// Triangles are numbered as [`Mesh::triangles`](crate::Mesh::triangles).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for an instance or triangle that the scene has not; [`Error::Interrupted`].
    pub fn shadows_at(&self, surfaces: &Surfaces, light: &Light, progress: &Progress) -> Result<TruthMask> {
        let scene = &*self.inner;
        let pixels = surfaces.triangle.len();
        let unknown = (0..pixels).into_par_iter().find_first(|&i| !exists(scene, surfaces, i));
        if let Some(i) = unknown {
            let got = format!("triangle {} of instance {}", surfaces.triangle[i], surfaces.instance[i]);
            let fix = "draw it in this scene, or in one that this one was moved from";
            return Err(Error::argument("gbuffer", "surfaces of the scene", got, fix));
        }
        let (shader, lamp) = (Shader::without_eye(scene), Lamp::new(scene, light));
        let mut data = with_room("gbuffer", pixels)?;
        data.resize(pixels, TruthMask::NOTHING);
        progress.set_total(pixels.div_ceil(AT_ONCE) as u64);
        data.par_chunks_mut(AT_ONCE).enumerate().try_for_each(|(part, answers)| {
            progress.check()?;
            run(&shader, &lamp, scene, surfaces, part * AT_ONCE, answers);
            progress.advance(1);
            Ok::<_, Error>(())
        })?;
        Ok(TruthMask { size: surfaces.size, data })
    }
}

fn exists(scene: &Inner, surfaces: &Surfaces, pixel: usize) -> bool {
    let (triangle, instance) = (surfaces.triangle[pixel], surfaces.instance[pixel]);
    let is_there = |instance: usize| {
        instance < scene.placed.len() && (triangle as usize) < scene.scene.mesh_of(instance).triangles().len()
    };
    triangle < 0 || usize::try_from(instance).is_ok_and(is_there)
}

dispatched! {
    fn run(
        shader: &Shader<'_>, lamp: &Lamp<'_>, scene: &Inner, surfaces: &Surfaces<'_>, first: usize, answers: &mut [i8]
    ) = run_with;
}

#[inline(always)]
fn run_with<K: Kernel>(
    shader: &Shader,
    lamp: &Lamp,
    scene: &Inner,
    surfaces: &Surfaces,
    first: usize,
    answers: &mut [i8],
) {
    let mut stacks = Stacks::default();
    let shift = surfaces.origin - scene.scene.origin();
    for (bundle, answers) in answers.chunks_mut(BUNDLE).enumerate() {
        let mut rays = WorldRays::UNSET;
        let mut found = [Closest::<false>::new(0.0, f64::INFINITY, 0.0); BUNDLE];
        let mut bits = 0;
        for r in 0..answers.len() {
            let pixel = first + bundle * BUNDLE + r;
            let Some((point, normal)) = surfaces.receiver(pixel) else { continue };
            // A ray that has arrived, against the normal.
            rays.set(r, &WorldRay { origin: point + shift, direction: -normal });
            found[r].t = 0.0;
            found[r].face = Some((surfaces.instance[pixel] as u32, surfaces.triangle[pixel] as u32));
            bits |= 1 << r;
        }
        let shaded = shader.shade::<K>(lamp, &Seen::new(scene, &rays, &found, bits), &mut stacks);
        answers.copy_from_slice(&shaded[..answers.len()]);
    }
}
