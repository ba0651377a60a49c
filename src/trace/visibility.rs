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
//! The other end is treated alike: a light within `resolution` of a surface stands on it, and such surfaces
//! ([`Touched`]) are never its own occluders. Which side of a ceiling a lamp is on, with vertices in single precision, is
//! no question that has an answer.
//!
//! The usual case costs one shadow ray; the others are settled by [`Shader::settle`].

use glam::{DVec3, DVec4};
use rayon::prelude::*;

use super::hierarchy::{Face, Inner, Tracer};
use super::kernel::{Kernel, dispatched};
use super::rays::{BUNDLE, Each, RayBits, WorldRay};
use super::walk::{Blocked, Closest, Stacks, SurelyBlocked, Touched, traverse_together};
use crate::error::{Error, Result};
use crate::image::TruthMask;
use crate::memory::{check_images, with_room};
use crate::progress::Progress;
use crate::scene::{Camera, EDGE_ON, Light, PixelRay};

/// Side of the square of pixels whose rays follow each other, so that they find the same boxes in the cache.
const TILE: usize = 8;
/// Sides of the block of pixels whose rays travel together.
const BLOCK: [usize; 2] = [4, 2];
const _: () = assert!(BLOCK[0] * BLOCK[1] == BUNDLE);
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
    /// from the light on the side the eye sees (edge-on included, up to [`EDGE_ON`]), where the light does not reach (cone,
    /// range), and where anything else meets the open segment between it and the light; undecided where that changes when
    /// the rays move by what single precision resolves in this scene (the half extent times 2^-22). A light nearer than
    /// that to a surface stands on it, and the surface shades nothing from it: its light arrives on both sides.
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
        check_images("size", 1, size, size_of::<i8>())?;
        let mut data = with_room("size", width * height)?;
        data.resize(width * height, TruthMask::NOTHING);
        progress.set_total(height as u64);
        data.par_chunks_mut(width * TILE).enumerate().try_for_each(|(band, rows)| {
            for x in (0..width).step_by(TILE) {
                progress.check()?;
                tile(&shader, camera, size, [x, band * TILE], rows);
            }
            progress.advance((rows.len() / width) as u64);
            Ok(())
        })?;
        Ok(TruthMask { size, data })
    }
}

/// Everything a pixel needs to know.
pub(super) struct Shader<'a> {
    scene: &'a Inner,
    light: &'a Light,
    /// The eye, relative to the scene's origin.
    eye: DVec3,
    /// The depth at which rays begin: 0 at a perspective eye; parallel rays come from anywhere.
    start: f64,
    /// Near and far depth, from there.
    range: [f64; 2],
    /// The light as a homogeneous point, relative to the scene's origin.
    light_point: DVec4,
    /// Half-width of the band about edges for rays from the eye.
    eye_band: f64,
    /// What the light stands on.
    touched: Touched,
}

/// The point of a surface that is asked about.
#[derive(Clone, Copy)]
struct Receiver {
    face: Face,
    point: DVec3,
    /// Unit, towards the eye.
    normal: DVec3,
    /// Product of the normal with the vector to the light: positive.
    facing: f64,
    /// Length of the vector to the light.
    distance: f64,
}

impl Receiver {
    /// Stands where nothing is asked.
    const NONE: Self = Self { face: (0, 0), point: DVec3::ZERO, normal: DVec3::ZERO, facing: 1.0, distance: 1.0 };
}

dispatched! {
    fn tile(shader: &Shader<'_>, camera: &Camera, size: [u32; 2], corner: [usize; 2], rows: &mut [i8]) = tile_with;
}

#[inline(always)]
fn tile_with<K: Kernel>(shader: &Shader, camera: &Camera, size: [u32; 2], [left, top]: [usize; 2], rows: &mut [i8]) {
    let width = size[0] as usize;
    let (tile_width, height) = (TILE.min(width - left), rows.len() / width);
    let ray_of = camera.pixel_rays(size);
    let mut stacks = Stacks::default();
    for y in (0..height).step_by(BLOCK[1]) {
        for x in (left..left + tile_width).step_by(BLOCK[0]) {
            let at = |r: usize| [x + r % BLOCK[0], y + r / BLOCK[0]];
            let mut rays = [WorldRay { origin: DVec3::ZERO, direction: DVec3::ZERO }; BUNDLE];
            let mut bits = 0;
            for r in 0..BUNDLE {
                let [x, y] = at(r);
                rays[r] = shader.world_ray(&ray_of(x as f64 + 0.5, (top + y) as f64 + 0.5));
                bits |= u32::from(x < left + tile_width && y < height) << r;
            }
            let answers = shader.pixels::<K>(&rays, bits, &mut stacks);
            for r in Each(bits) {
                let [x, y] = at(r);
                rows[y * width + x] = answers[r];
            }
        }
    }
}

impl<'a> Shader<'a> {
    fn new(scene: &'a Inner, camera: &'a Camera, light: &'a Light) -> Self {
        let origin = scene.scene.origin();
        let eye = camera.eye() - origin;
        let bounds = scene.scene.bounds();
        let (near, far) = (camera.near(), camera.bounded(bounds).far());
        let start = if camera.is_orthographic() {
            // Before all of the scene, yet not farther away than costs digits.
            let nearest = bounds.corners().iter().map(|p| camera.depth_of(*p)).fold(f64::INFINITY, f64::min);
            near.max(nearest - bounds.diagonal())
        } else {
            0.0
        };
        let farthest =
            camera.corners_at(start).iter().fold(0.0, |most: f64, p| most.max((eye + *p).abs().max_element()));
        let eye_band = scene.resolution.max(EYE_ERROR * farthest);
        let range = [near - start, far - start];
        Self { eye, start, range, eye_band, ..Self::of_light(scene, light) }
    }

    /// For surfaces that no eye looks for.
    pub(super) fn of_light(scene: &'a Inner, light: &'a Light) -> Self {
        let point = light.point();
        let light_point = (point.truncate() - point.w * scene.scene.origin()).extend(point.w);
        let touched = if light_point.w == 0.0 {
            Touched::default()
        } else {
            Touched::new(scene, light_point.truncate(), scene.resolution)
        };
        let (eye, start, range, eye_band) = (DVec3::ZERO, 0.0, [0.0; 2], 0.0);
        Self { scene, light, eye, start, range, light_point, eye_band, touched }
    }

    /// The ray of a pixel, from where rays begin.
    #[inline(always)]
    fn world_ray(&self, ray: &PixelRay) -> WorldRay {
        WorldRay { origin: self.eye + ray.at(self.start), direction: ray.direction }
    }

    /// The answers for the rays of a bundle from the eye.
    #[inline(always)]
    fn pixels<K: Kernel>(&self, rays: &[WorldRay; BUNDLE], bits: RayBits, stacks: &mut Stacks) -> [i8; BUNDLE] {
        let [near, far] = self.range;
        let mut closest = [Closest::<true>::new(near, far, self.eye_band); BUNDLE];
        traverse_together::<K, _>(self.scene, rays, bits, &mut closest, stacks);
        let mut answers = self.shade::<K, true>(rays, &closest, bits, stacks);
        for r in Each(bits) {
            if closest[r].is_near_edge() && answers[r] != TruthMask::UNDECIDED {
                answers[r] = self.confirm::<K>(&rays[r], answers[r], stacks);
            }
        }
        answers
    }

    /// The answer, if it stays the same where the ray from the eye moves across the edge that it nearly meets: another
    /// triangle may be the one that is seen.
    #[cold]
    #[inline(never)]
    fn confirm<K: Kernel>(&self, ray: &WorldRay, answer: i8, stacks: &mut Stacks) -> i8 {
        let (u, v) = ray.direction.normalize().any_orthonormal_pair();
        let mut rays = [*ray; BUNDLE];
        for (ray, shift) in rays.iter_mut().zip([u, -u, v, -v]) {
            ray.origin += shift * self.eye_band;
        }
        let four = 0b1111;
        let [near, far] = self.range;
        let mut closest = [Closest::<false>::new(near, far, 0.0); BUNDLE];
        traverse_together::<K, _>(self.scene, &rays, four, &mut closest, stacks);
        let answers = self.shade::<K, false>(&rays, &closest, four, stacks);
        if Each(four).all(|r| answers[r] == answer) { answer } else { TruthMask::UNDECIDED }
    }

    /// The answers for what rays from the eye meet.
    #[inline(always)]
    pub(super) fn shade<K: Kernel, const BAND: bool>(
        &self,
        rays: &[WorldRay; BUNDLE],
        closest: &[Closest<BAND>; BUNDLE],
        bits: RayBits,
        stacks: &mut Stacks,
    ) -> [i8; BUNDLE] {
        let mut answers = [TruthMask::NOTHING; BUNDLE];
        let mut receivers = [Receiver::NONE; BUNDLE];
        let mut shadow_rays = *rays;
        let mut asked = 0;
        for r in Each(bits) {
            let Some(face) = closest[r].face else { continue };
            match self.receiver(&rays[r], face, closest[r].t) {
                Ok(receiver) => {
                    receivers[r] = receiver;
                    shadow_rays[r] = WorldRay { origin: receiver.point, direction: self.to_light(receiver.point) };
                    asked |= 1 << r;
                }
                Err(answer) => answers[r] = answer,
            }
        }
        if asked == 0 {
            return answers;
        }
        let mut blocked = receivers.map(|receiver| self.surely_blocked(&receiver));
        let ended = traverse_together::<K, _>(self.scene, &shadow_rays, asked, &mut blocked, stacks);
        for r in Each(asked) {
            answers[r] = if (ended >> r) & 1 != 0 {
                TruthMask::SHADOW
            } else if !blocked[r].is_possible {
                TruthMask::LIT
            } else {
                self.settle::<K>(&receivers[r], stacks)
            };
        }
        answers
    }

    /// The surface that a ray from the eye meets at `t`, or the answer where that needs no other ray.
    #[inline(always)]
    fn receiver(&self, ray: &WorldRay, face: Face, t: f64) -> std::result::Result<Receiver, i8> {
        let [a, b, c] = self.scene.corners(face.0, face.1);
        let (ab, ac) = (b - a, c - a);
        // Scaled, so that the squares of tiny triangles do not underflow.
        let scale = ab.abs().max(ac.abs()).max_element();
        let (ab, ac) = (ab / scale, ac / scale);
        let area = ab.cross(ac);
        let Some(normal) = area.try_normalize() else {
            // Met by the ray and yet without area in the world: thinner than f64 tells.
            return Err(TruthMask::UNDECIDED);
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
        let facing_error = FACING_ERROR * sliver * distance + placed_error;
        let edge_on = EDGE_ON * distance;
        if facing_error > edge_on && facing != 0.0 && facing.abs() <= facing_error {
            return Err(TruthMask::UNDECIDED);
        }
        if facing <= edge_on || !self.light.reaches(point + self.scene.scene.origin()) {
            return Err(TruthMask::SHADOW);
        }
        Ok(Receiver { face, point, normal, facing, distance })
    }

    /// What the shadow ray of a receiver looks for.
    #[inline(always)]
    fn surely_blocked(&self, receiver: &Receiver) -> SurelyBlocked<'_> {
        let resolution = self.scene.resolution;
        // In units of t: for a directional light `to_light` is a unit vector.
        let at_light = self.at_light();
        let slack = resolution / receiver.distance;
        SurelyBlocked {
            sure: [resolution / receiver.facing, at_light - slack],
            possible: [0.0, at_light + slack],
            band: resolution,
            except: receiver.face,
            touched: &self.touched,
            is_possible: false,
        }
    }

    /// The answer where one ray does not settle it: that of ten, if they agree.
    #[cold]
    #[inline(never)]
    fn settle<K: Kernel>(&self, receiver: &Receiver, stacks: &mut Stacks) -> i8 {
        let resolution = self.scene.resolution;
        let (u, v) = receiver.normal.any_orthonormal_pair();
        let shifts = [DVec3::ZERO, u, -u, v, -v];
        let five = 0b11111;
        let mut answer = None;
        for (height, light_side) in [(self.scene.surface_error, 1.0), (resolution, -1.0)] {
            let mut rays = [WorldRay { origin: receiver.point, direction: receiver.normal }; BUNDLE];
            let none = Blocked { t_min: 0.0, t_max: 0.0, except: Some(receiver.face), touched: &self.touched };
            let mut blocked = [none; BUNDLE];
            for (r, shift) in shifts.into_iter().enumerate() {
                let origin = receiver.point + receiver.normal * height + shift * resolution;
                let direction = self.to_light(origin);
                rays[r] = WorldRay { origin, direction };
                blocked[r].t_max = self.at_light() + light_side * resolution / direction.length();
            }
            let ended = traverse_together::<K, _>(self.scene, &rays, five, &mut blocked, stacks);
            for r in Each(five) {
                let is_blocked = (ended >> r) & 1 != 0;
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
