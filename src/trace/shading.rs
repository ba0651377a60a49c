//! What light does at a pixel: a ray from the eye through its centre, then one from what it meets to each light.
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

use super::hierarchy::{Face, Inner};
use super::kernel::Kernel;
use super::rays::{BUNDLE, Each, RayBits, WorldRay, WorldRays};
use super::walk::{Blocked, Closest, Stacks, SurelyBlocked, Touched, traverse_together};
use crate::image::TruthMask;
use crate::scene::{Camera, EDGE_ON, Light, PixelRay};

/// Relative error of the cosine between a computed normal and a vector: differences, linear map (3), cross product (3),
/// dot product (3), and the vector itself (3), each 2^-53.
const FACING_ERROR: f64 = 16.0 * (f64::EPSILON / 2.0);
/// f64 roundings of a primary ray relative to the distance of the eye: position, direction (4), t (8).
const EYE_ERROR: f64 = 16.0 * (f64::EPSILON / 2.0);

/// A light, and what it stands on.
pub struct Lamp<'a> {
    light: &'a Light,
    /// The light as a homogeneous point, relative to the scene's origin.
    point: DVec4,
    touched: Touched,
}

impl<'a> Lamp<'a> {
    pub fn new(scene: &Inner, light: &'a Light) -> Self {
        let point = light.point();
        let point = (point.truncate() - point.w * scene.scene.origin()).extend(point.w);
        let touched =
            if point.w == 0.0 { Touched::default() } else { Touched::new(scene, point.truncate(), scene.resolution) };
        Self { light, point, touched }
    }
    /// The vector from a point to the light, both relative to the scene's origin: see [`Light::to_light`].
    #[inline(always)]
    fn to_light(&self, point: DVec3) -> DVec3 {
        self.point.truncate() - self.point.w * point
    }
    /// Where along [`Lamp::to_light`] the light is.
    fn at_light(&self) -> f64 {
        if self.point.w == 0.0 { f64::INFINITY } else { 1.0 }
    }
}

/// Everything a pixel needs to know beside the lights.
pub struct Shader<'a> {
    scene: &'a Inner,
    /// The eye, relative to the scene's origin.
    eye: DVec3,
    /// The depth at which rays begin: 0 at a perspective eye; parallel rays come from anywhere.
    start: f64,
    /// Near and far depth, from there.
    range: [f64; 2],
    /// Half-width of the band about edges for rays from the eye.
    eye_band: f64,
}

/// What four rays meet that pass a ray from the eye on all sides.
struct Moved {
    rays: WorldRays<BUNDLE>,
    closest: [Closest<false>; BUNDLE],
}

impl Moved {
    /// The four.
    const RAYS: RayBits = 0b1111;
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

impl<'a> Shader<'a> {
    pub fn new(scene: &'a Inner, camera: &Camera) -> Self {
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
        Self { scene, eye, start, range, eye_band }
    }

    /// For surfaces that no eye looks for.
    pub fn without_eye(scene: &'a Inner) -> Self {
        Self { scene, eye: DVec3::ZERO, start: 0.0, range: [0.0; 2], eye_band: 0.0 }
    }

    /// The ray of a pixel, from where rays begin.
    #[inline(always)]
    pub fn world_ray(&self, ray: &PixelRay) -> WorldRay {
        WorldRay { origin: self.eye + ray.at(self.start), direction: ray.direction }
    }

    /// Calls `put` with the number of each light and its answers for the rays of a bundle from the eye, which are traced once.
    #[inline(always)]
    pub fn pixels<K: Kernel>(
        &self,
        rays: &WorldRays<BUNDLE>,
        bits: RayBits,
        lamps: &[Lamp],
        stacks: &mut Stacks,
        mut put: impl FnMut(usize, &[i8; BUNDLE]),
    ) {
        let [near, far] = self.range;
        let mut closest = [Closest::<true>::new(near, far, self.eye_band); BUNDLE];
        traverse_together::<K, _>(self.scene, rays, bits, &mut closest, stacks);
        // Of few rays, and of none at all in most bundles.
        let mut moved: Vec<(usize, Moved)> = Vec::new();
        for (i, lamp) in lamps.iter().enumerate() {
            let mut answers = self.shade::<K, true>(lamp, rays, &closest, bits, stacks);
            for r in Each(bits) {
                if closest[r].is_near_edge() && answers[r] != TruthMask::UNDECIDED {
                    let at = moved.iter().position(|m| m.0 == r).unwrap_or_else(|| {
                        moved.push((r, self.moved::<K>(&rays.get(r), stacks)));
                        moved.len() - 1
                    });
                    answers[r] = self.confirmed::<K>(lamp, &moved[at].1, answers[r], stacks);
                }
            }
            put(i, &answers);
        }
    }

    /// What a ray from the eye meets where it moves across the edge that it nearly meets: another triangle may be the one that
    /// is seen.
    #[cold]
    #[inline(never)]
    fn moved<K: Kernel>(&self, ray: &WorldRay, stacks: &mut Stacks) -> Moved {
        let (u, v) = ray.direction.normalize().any_orthonormal_pair();
        let mut rays = WorldRays::from([*ray; BUNDLE]);
        for (r, shift) in [u, -u, v, -v].into_iter().enumerate() {
            rays.set(r, &WorldRay { origin: ray.origin + shift * self.eye_band, ..*ray });
        }
        let [near, far] = self.range;
        let mut closest = [Closest::<false>::new(near, far, 0.0); BUNDLE];
        traverse_together::<K, _>(self.scene, &rays, Moved::RAYS, &mut closest, stacks);
        Moved { rays, closest }
    }

    /// The answer, if it stays the same where the ray from the eye moves.
    #[cold]
    #[inline(never)]
    fn confirmed<K: Kernel>(&self, lamp: &Lamp, moved: &Moved, answer: i8, stacks: &mut Stacks) -> i8 {
        let answers = self.shade::<K, false>(lamp, &moved.rays, &moved.closest, Moved::RAYS, stacks);
        if Each(Moved::RAYS).all(|r| answers[r] == answer) { answer } else { TruthMask::UNDECIDED }
    }

    /// The answers for what rays from the eye meet.
    #[inline(always)]
    pub fn shade<K: Kernel, const BAND: bool>(
        &self,
        lamp: &Lamp,
        rays: &WorldRays<BUNDLE>,
        closest: &[Closest<BAND>; BUNDLE],
        bits: RayBits,
        stacks: &mut Stacks,
    ) -> [i8; BUNDLE] {
        let mut answers = [TruthMask::NOTHING; BUNDLE];
        let mut receivers = [Receiver::NONE; BUNDLE];
        let mut shadow_rays = rays.clone();
        let mut asked = 0;
        for r in Each(bits) {
            let Some(face) = closest[r].face else { continue };
            match self.receiver(lamp, &rays.get(r), face, closest[r].t) {
                Ok(receiver) => {
                    receivers[r] = receiver;
                    let direction = lamp.to_light(receiver.point);
                    shadow_rays.set(r, &WorldRay { origin: receiver.point, direction });
                    asked |= 1 << r;
                }
                Err(answer) => answers[r] = answer,
            }
        }
        if asked == 0 {
            return answers;
        }
        let mut blocked = receivers.map(|receiver| self.surely_blocked(lamp, &receiver));
        let ended = traverse_together::<K, _>(self.scene, &shadow_rays, asked, &mut blocked, stacks);
        for r in Each(asked) {
            answers[r] = if (ended >> r) & 1 != 0 {
                TruthMask::SHADOW
            } else if !blocked[r].is_possible {
                TruthMask::LIT
            } else {
                self.settle::<K>(lamp, &receivers[r], stacks)
            };
        }
        answers
    }

    /// The surface that a ray from the eye meets at `t`, or the answer where that needs no other ray.
    #[inline(always)]
    fn receiver(&self, lamp: &Lamp, ray: &WorldRay, face: Face, t: f64) -> Result<Receiver, i8> {
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
        let to_light = lamp.to_light(point);
        let facing = normal.dot(to_light);
        // The normal of a sliver errs more: by its edges over its height.
        let sliver = ab.length() * ac.length() / area.length();
        let distance = to_light.length();
        let placed_error = if lamp.point.w == 0.0 { 0.0 } else { self.scene.surface_error };
        let facing_error = FACING_ERROR * sliver * distance + placed_error;
        let edge_on = EDGE_ON * distance;
        if facing_error > edge_on && facing != 0.0 && facing.abs() <= facing_error {
            return Err(TruthMask::UNDECIDED);
        }
        if facing <= edge_on || !lamp.light.reaches(point + self.scene.scene.origin()) {
            return Err(TruthMask::SHADOW);
        }
        Ok(Receiver { face, point, normal, facing, distance })
    }

    /// What the shadow ray of a receiver looks for.
    #[inline(always)]
    fn surely_blocked<'l>(&self, lamp: &'l Lamp, receiver: &Receiver) -> SurelyBlocked<'l> {
        let resolution = self.scene.resolution;
        // In units of t: for a directional light `to_light` is a unit vector.
        let at_light = lamp.at_light();
        let slack = resolution / receiver.distance;
        SurelyBlocked {
            sure: [resolution / receiver.facing, at_light - slack],
            possible: [0.0, at_light + slack],
            band: resolution,
            except: receiver.face,
            touched: &lamp.touched,
            is_possible: false,
        }
    }

    /// The answer where one ray does not settle it: that of ten, if they agree.
    #[cold]
    #[inline(never)]
    fn settle<K: Kernel>(&self, lamp: &Lamp, receiver: &Receiver, stacks: &mut Stacks) -> i8 {
        let resolution = self.scene.resolution;
        let (u, v) = receiver.normal.any_orthonormal_pair();
        let shifts = [DVec3::ZERO, u, -u, v, -v];
        let five = 0b11111;
        let mut answer = None;
        for (height, light_side) in [(self.scene.surface_error, 1.0), (resolution, -1.0)] {
            let resting = WorldRay { origin: receiver.point, direction: receiver.normal };
            let mut rays = WorldRays::from([resting; BUNDLE]);
            let none = Blocked { t_max: 0.0, except: Some(receiver.face), touched: &lamp.touched };
            let mut blocked = [none; BUNDLE];
            for (r, shift) in shifts.into_iter().enumerate() {
                let origin = receiver.point + receiver.normal * height + shift * resolution;
                let direction = lamp.to_light(origin);
                rays.set(r, &WorldRay { origin, direction });
                blocked[r].t_max = lamp.at_light() + light_side * resolution / direction.length();
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
}
