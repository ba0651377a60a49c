//! Which pixels are lit, by rays: from the eye through the pixel's centre, then from what it meets to the light.
//!
//! No ray offset is chosen by taste. Two lengths are derived from the scene: `surface_error`, a bound on the f64 error of
//! a point on a surface, and `resolution`, what single precision resolves. A pixel whose answer is the same for every
//! offset from the one to the other, and for displacements of both rays up to the latter, is decided:
//!
//! ```text
//!           L            sure: the ray passes all edges by more than the band, and what it
//!          /             meets stands at least `resolution` above the receiver's plane
//!   ______/____ occluder
//!        /
//!  - - -/- - - - - - - - `resolution` above: 10 rays begin here and
//!  - - / - - - - - - - - `surface_error` above: here, where it is not sure
//! ____P_______ receiver  (never its own occluder, whatever the rounding)
//! ```
//!
//! The usual case costs one shadow ray; the others are settled by [`Shader::settle`].

use glam::{DVec3, DVec4};
use rayon::prelude::*;

use super::kernel::{Kernel, dispatched};
use super::tracer::{Inner, Tracer};
use super::traverse::{Blocked, Closest, Face, Stack, SurelyBlocked, WorldRay, traverse};
use crate::error::{Error, Result};
use crate::image::TruthMask;
use crate::progress::Progress;
use crate::scene::{Camera, Light};

/// Side of the square of pixels whose rays follow each other, so that they find the same boxes in the cache.
const TILE: usize = 8;
/// Largest side of an image, the same as the renderers'.
const MAX_SIDE: u32 = 16384;
/// Relative error of the cosine between a computed normal and a vector: differences, linear map (3), cross product (3),
/// dot product (3), and the vector itself (3), each 2^-53.
const FACING_ERROR: f64 = 16.0 * (f64::EPSILON / 2.0);
/// f64 roundings of a primary ray relative to the distance of the eye: position, direction (4), t (8).
const EYE_ERROR: f64 = 16.0 * (f64::EPSILON / 2.0);

impl Tracer {
    /// What light does at each pixel of an image of `size` (width, height): see [`TruthMask`].
    ///
    /// The surface seen is the first one between the camera's near and far depth. It is in shadow where it faces away
    /// from the light on the side the eye sees (exactly edge-on included), where the light does not reach (cone, range),
    /// and where anything else stands between it and the light; undecided where that changes when the rays move by
    /// what single precision resolves in this scene (the half extent times 2^-22).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a side of 0 or above 16384; [`Error::Interrupted`].
    pub fn shadow_mask(
        &self,
        camera: &Camera,
        light: &Light,
        size: [u32; 2],
        progress: &Progress,
    ) -> Result<TruthMask> {
        if !size.iter().all(|n| (1..=MAX_SIDE).contains(n)) {
            let expected = format!("sides between 1 and {MAX_SIDE}");
            return Err(Error::argument("size", expected, format!("{} x {}", size[0], size[1]), "choose another size"));
        }
        let [width, height] = size.map(|n| n as usize);
        let shader = Shader::new(&self.inner, camera, light);
        let mut data = vec![TruthMask::NOTHING; width * height];
        progress.set_total(height as u64);
        data.par_chunks_mut(width * TILE).enumerate().try_for_each(|(band, rows)| {
            for x in (0..width).step_by(TILE) {
                progress.check()?;
                tile(&shader, size, [x, band * TILE], rows);
            }
            progress.advance((rows.len() / width) as u64);
            Ok(())
        })?;
        Ok(TruthMask { size, data })
    }
}

/// Everything a pixel needs to know.
struct Shader<'a> {
    scene: &'a Inner,
    camera: &'a Camera,
    light: &'a Light,
    /// The eye, relative to the scene's origin.
    eye: DVec3,
    /// The light as a homogeneous point, relative to the scene's origin.
    light_point: DVec4,
    /// Half-width of the band about edges for rays from the eye.
    eye_band: f64,
}

/// The point of a surface that is asked about.
struct Receiver {
    face: Face,
    point: DVec3,
    /// Unit, towards the eye.
    normal: DVec3,
    /// Two unit vectors in the plane.
    tangents: [DVec3; 2],
}

dispatched! {
    fn tile(shader: &Shader<'_>, size: [u32; 2], corner: [usize; 2], rows: &mut [i8]) = tile_with;
}

#[inline(always)]
fn tile_with<K: Kernel>(shader: &Shader, size: [u32; 2], [left, top]: [usize; 2], rows: &mut [i8]) {
    let width = size[0] as usize;
    let mut stack = Stack::new();
    for (y, row) in rows.chunks_mut(width).enumerate() {
        for (x, out) in row.iter_mut().enumerate().skip(left).take(TILE) {
            let direction = shader.camera.pixel_ray(x as f64 + 0.5, (top + y) as f64 + 0.5, size);
            *out = shader.pixel::<K>(direction, &mut stack);
        }
    }
}

impl<'a> Shader<'a> {
    fn new(scene: &'a Inner, camera: &'a Camera, light: &'a Light) -> Self {
        let origin = scene.scene.origin();
        let eye = camera.eye() - origin;
        let point = light.point();
        Self {
            scene,
            camera,
            light,
            eye,
            light_point: (point.truncate() - point.w * origin).extend(point.w),
            eye_band: scene.resolution.max(EYE_ERROR * eye.abs().max_element()),
        }
    }

    #[inline(always)]
    fn pixel<K: Kernel>(&self, direction: DVec3, stack: &mut Stack) -> i8 {
        let ray = WorldRay { origin: self.eye, direction };
        let mut closest = Closest::<true>::new(self.camera.near(), self.camera.far(), self.eye_band);
        traverse::<K, _>(self.scene, &ray, &mut closest, stack);
        let answer = self.shade::<K>(&ray, closest.face, closest.t, stack);
        if !closest.is_near_edge() || answer == TruthMask::UNDECIDED {
            return answer;
        }
        // Another triangle may be the one that is seen: it has to give the same answer.
        let (u, v) = direction.normalize().any_orthonormal_pair();
        for shift in [u, -u, v, -v] {
            let ray = WorldRay { origin: self.eye + shift * self.eye_band, direction };
            let mut closest = Closest::<false>::new(self.camera.near(), self.camera.far(), 0.0);
            traverse::<K, _>(self.scene, &ray, &mut closest, stack);
            if self.shade::<K>(&ray, closest.face, closest.t, stack) != answer {
                return TruthMask::UNDECIDED;
            }
        }
        answer
    }

    /// The answer for what a ray from the eye meets at `t`.
    #[inline(always)]
    fn shade<K: Kernel>(&self, ray: &WorldRay, face: Option<Face>, t: f64, stack: &mut Stack) -> i8 {
        let Some(face) = face else { return TruthMask::NOTHING };
        let [a, b, c] = self.scene.corners(face.0, face.1);
        let (ab, ac) = (b - a, c - a);
        // Scaled, so that the squares of tiny triangles do not underflow.
        let scale = ab.abs().max(ac.abs()).max_element();
        let (ab, ac) = (ab / scale, ac / scale);
        let area = ab.cross(ac);
        let Some(normal) = area.try_normalize() else {
            // Met by the ray and yet without area in the world: thinner than f64 tells.
            return TruthMask::UNDECIDED;
        };
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let point = ray.origin + t * ray.direction;
        // Onto the plane: the error that is left does not depend on how far away the eye is.
        let point = point - normal * normal.dot(point - a);
        let to_light = self.to_light(point);
        let facing = normal.dot(to_light);
        // The normal of a sliver errs more: by its edges over its height.
        let sliver = ab.length() * ac.length() / area.length();
        let distance = to_light.length();
        let placed_error = if self.light_point.w == 0.0 { 0.0 } else { self.scene.surface_error };
        if facing == 0.0 {
            return TruthMask::SHADOW;
        }
        if facing.abs() <= FACING_ERROR * sliver * distance + placed_error {
            return TruthMask::UNDECIDED;
        }
        if facing < 0.0 || !self.light.reaches(point + self.scene.scene.origin()) {
            return TruthMask::SHADOW;
        }
        let resolution = self.scene.resolution;
        // In units of t: for a directional light `to_light` is a unit vector.
        let at_light = self.at_light();
        let slack = resolution / distance;
        let mut blocked = SurelyBlocked {
            sure: [resolution / facing, at_light - slack],
            possible: [0.0, at_light + slack],
            band: resolution,
            except: face,
            is_possible: false,
        };
        let shadow_ray = WorldRay { origin: point, direction: to_light };
        if traverse::<K, _>(self.scene, &shadow_ray, &mut blocked, stack) {
            return TruthMask::SHADOW;
        }
        if !blocked.is_possible {
            return TruthMask::LIT;
        }
        self.settle::<K>(&Receiver { face, point, normal, tangents: normal.any_orthonormal_pair().into() }, stack)
    }

    /// The answer where one ray does not settle it: that of ten, if they agree.
    #[cold]
    #[inline(never)]
    fn settle<K: Kernel>(&self, receiver: &Receiver, stack: &mut Stack) -> i8 {
        let resolution = self.scene.resolution;
        let [u, v] = receiver.tangents;
        let mut answer = None;
        for (height, light_side) in [(self.scene.surface_error, 1.0), (resolution, -1.0)] {
            for shift in [DVec3::ZERO, u, -u, v, -v] {
                let origin = receiver.point + receiver.normal * height + shift * resolution;
                let direction = self.to_light(origin);
                let t_max = self.at_light() + light_side * resolution / direction.length();
                let mut blocked = Blocked { t_min: 0.0, t_max, except: Some(receiver.face) };
                let ray = WorldRay { origin, direction };
                let is_blocked = traverse::<K, _>(self.scene, &ray, &mut blocked, stack);
                if *answer.get_or_insert(is_blocked) != is_blocked {
                    return TruthMask::UNDECIDED;
                }
            }
        }
        if answer == Some(true) { TruthMask::SHADOW } else { TruthMask::LIT }
    }

    /// The vector from a point to the light, both relative to the scene's origin: see [`Light::to_light`].
    #[inline(always)]
    fn to_light(&self, point: DVec3) -> DVec3 {
        self.light_point.truncate() - self.light_point.w * point
    }
    /// Where along [`Shader::to_light`] the light is.
    fn at_light(&self) -> f64 {
        if self.light_point.w == 0.0 { f64::INFINITY } else { 1.0 }
    }
}
