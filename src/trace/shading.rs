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
//! The usual case costs one shadow ray; the others are settled by [`settle`].

use glam::{DVec3, DVec4};

use super::hierarchy::Inner;
use super::kernel::{Kernel, dispatched};
use super::rays::{BUNDLE, Each, RayBits, WorldRay, WorldRays};
use super::seen::Seen;
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

/// Rays that pass a ray from the eye on all sides.
const BESIDE: RayBits = 0b1111;
/// Rays about a receiver that is in doubt.
const ABOUT: usize = 5;
const ABOUT_BITS: RayBits = RayBits::MAX >> (RayBits::BITS - ABOUT as u32);
/// Receivers whose rays travel together.
const IN_DOUBT: usize = BUNDLE / ABOUT;

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
        let seen = Seen::new(self.scene, rays, &closest, bits);
        let near_edges = Each(bits).filter(|&r| closest[r].is_near_edge()).fold(0, |bits, r| bits | 1 << r);
        // Of few rays, and of none at all in most bundles.
        let mut moved: Vec<(usize, Seen)> = Vec::new();
        stacks.blockers.resize(lamps.len(), None);
        for (i, lamp) in lamps.iter().enumerate() {
            // Neighbours are mostly blocked by the same triangles, on the way to the same light.
            stacks.blocker = stacks.blockers[i];
            let mut answers = self.shade::<K>(lamp, &seen, stacks);
            for r in Each(near_edges) {
                if answers[r] != TruthMask::UNDECIDED {
                    let at = moved.iter().position(|m| m.0 == r).unwrap_or_else(|| {
                        moved.push((r, beside(self, &rays.get(r), stacks)));
                        moved.len() - 1
                    });
                    answers[r] = confirmed(self, lamp, &moved[at].1, answers[r], stacks);
                }
            }
            stacks.blockers[i] = stacks.blocker;
            put(i, &answers);
        }
    }

    /// The answers for what rays from the eye meet.
    #[inline(always)]
    pub fn shade<K: Kernel>(&self, lamp: &Lamp, seen: &Seen, stacks: &mut Stacks) -> [i8; BUNDLE] {
        let mut answers = [TruthMask::NOTHING; BUNDLE];
        if seen.bits == 0 {
            return answers;
        }
        let mut shadow_rays = WorldRays { origin: seen.point, direction: [[0.0; BUNDLE]; 3] };
        let [x, y, z, w] = lamp.point.to_array();
        for (a, at) in [x, y, z].into_iter().enumerate() {
            for r in 0..BUNDLE {
                shadow_rays.direction[a][r] = at - w * seen.point[a][r];
            }
        }
        // Product of the normal with the vector to the light, and that one's length.
        let (mut facing, mut distance) = ([0.0; BUNDLE], [0.0; BUNDLE]);
        let (mut is_unclear, mut is_dark) = ([false; BUNDLE], [false; BUNDLE]);
        let placed_error = if w == 0.0 { 0.0 } else { self.scene.surface_error };
        let (to_light, normal) = (&shadow_rays.direction, &seen.normal);
        for r in 0..BUNDLE {
            let [x, y, z] = [to_light[0][r], to_light[1][r], to_light[2][r]];
            facing[r] = normal[0][r] * x + normal[1][r] * y + normal[2][r] * z;
            distance[r] = (x * x + y * y + z * z).sqrt();
            let error = FACING_ERROR * seen.sliver[r] * distance[r] + placed_error;
            let edge_on = EDGE_ON * distance[r];
            is_unclear[r] = (error > edge_on) & (facing[r] != 0.0) & (facing[r].abs() <= error);
            is_dark[r] = facing[r] <= edge_on;
        }
        let mut asked = 0;
        for r in Each(seen.bits) {
            if is_unclear[r] || (seen.flat >> r) & 1 != 0 {
                answers[r] = TruthMask::UNDECIDED;
            } else if is_dark[r] || !lamp.light.reaches(seen.point(r) + self.scene.scene.origin()) {
                answers[r] = TruthMask::SHADOW;
            } else {
                asked |= 1 << r;
            }
        }
        if asked == 0 {
            return answers;
        }
        let resolution = self.scene.resolution;
        let at_light = lamp.at_light();
        let mut blocked = [SurelyBlocked::nowhere(resolution, &lamp.touched); BUNDLE];
        for r in 0..BUNDLE {
            // In units of t: for a directional light the vector to the light has length 1.
            let slack = resolution / distance[r];
            blocked[r].sure = [resolution / facing[r], at_light - slack];
            blocked[r].possible = [0.0, at_light + slack];
            blocked[r].except = seen.faces[r];
        }
        let ended = traverse_together::<K, _>(self.scene, &shadow_rays, asked, &mut blocked, stacks);
        let mut in_doubt = 0;
        for r in Each(asked) {
            answers[r] = if (ended >> r) & 1 != 0 { TruthMask::SHADOW } else { TruthMask::LIT };
            in_doubt |= u32::from(blocked[r].is_possible) << r;
        }
        in_doubt &= !ended;
        if in_doubt != 0 {
            settle(self, lamp, seen, in_doubt, &mut answers, stacks);
        }
        answers
    }
}

/// What is met by rays from the eye that are moved across the edge that one nearly meets: another triangle may be the one that is
/// seen.
#[inline(always)]
fn beside_with<K: Kernel>(shader: &Shader, ray: &WorldRay, stacks: &mut Stacks) -> Seen {
    let (u, v) = ray.direction.normalize().any_orthonormal_pair();
    let mut rays = WorldRays::from([*ray; BUNDLE]);
    for (r, shift) in [u, -u, v, -v].into_iter().enumerate() {
        rays.set(r, &WorldRay { origin: ray.origin + shift * shader.eye_band, ..*ray });
    }
    let [near, far] = shader.range;
    let mut closest = [Closest::<false>::new(near, far, 0.0); BUNDLE];
    traverse_together::<K, _>(shader.scene, &rays, BESIDE, &mut closest, stacks);
    Seen::new(shader.scene, &rays, &closest, BESIDE)
}

/// The answer, if it stays the same where the ray from the eye moves.
#[inline(always)]
fn confirmed_with<K: Kernel>(shader: &Shader, lamp: &Lamp, beside: &Seen, answer: i8, stacks: &mut Stacks) -> i8 {
    let answers = shader.shade::<K>(lamp, beside, stacks);
    if Each(BESIDE).all(|r| answers[r] == answer) { answer } else { TruthMask::UNDECIDED }
}

/// The answers where one ray does not settle it: that of ten, if they agree.
#[inline(always)]
fn settle_with<K: Kernel>(
    shader: &Shader,
    lamp: &Lamp,
    seen: &Seen,
    in_doubt: RayBits,
    answers: &mut [i8; BUNDLE],
    stacks: &mut Stacks,
) {
    let (scene, resolution) = (shader.scene, shader.scene.resolution);
    let mut left = in_doubt;
    while left != 0 {
        let (mut group, mut count) = ([0; IN_DOUBT], 0);
        for r in Each(left).take(IN_DOUBT) {
            group[count] = r;
            count += 1;
            left &= !(1 << r);
        }
        let mut agreed = [None; IN_DOUBT];
        for (height, light_side) in [(scene.surface_error, 1.0), (resolution, -1.0)] {
            let mut rays = WorldRays::UNSET;
            let mut blocked = [Blocked { t_max: 0.0, except: None, touched: &lamp.touched }; BUNDLE];
            let mut asked = 0;
            for k in 0..count {
                let (ray, first) = (group[k], k * ABOUT);
                if agreed[k] == Some(TruthMask::UNDECIDED) {
                    continue;
                }
                let (point, normal) = (seen.point(ray), seen.normal(ray));
                let (u, v) = normal.any_orthonormal_pair();
                for (r, shift) in (first..).zip([DVec3::ZERO, u, -u, v, -v]) {
                    let origin = point + normal * height + shift * resolution;
                    let direction = lamp.to_light(origin);
                    rays.set(r, &WorldRay { origin, direction });
                    blocked[r].t_max = lamp.at_light() + light_side * resolution / direction.length();
                    blocked[r].except = Some(seen.faces[ray]);
                }
                asked |= ABOUT_BITS << first;
            }
            if asked == 0 {
                break;
            }
            let ended = traverse_together::<K, _>(scene, &rays, asked, &mut blocked, stacks);
            for k in (0..count).filter(|k| (asked >> (k * ABOUT)) & 1 != 0) {
                let found = match (ended >> (k * ABOUT)) & ABOUT_BITS {
                    0 => TruthMask::LIT,
                    ABOUT_BITS => TruthMask::SHADOW,
                    _ => TruthMask::UNDECIDED,
                };
                agreed[k] =
                    Some(if agreed[k].is_none_or(|known| known == found) { found } else { TruthMask::UNDECIDED });
            }
        }
        for k in 0..count {
            answers[group[k]] = agreed[k].unwrap_or(TruthMask::UNDECIDED);
        }
    }
}

dispatched! {
    #[cold]
    #[inline(never)]
    fn beside(shader: &Shader<'_>, ray: &WorldRay, stacks: &mut Stacks) -> Seen = beside_with;
    #[cold]
    #[inline(never)]
    fn confirmed(shader: &Shader<'_>, lamp: &Lamp<'_>, beside: &Seen, answer: i8, stacks: &mut Stacks) -> i8 = confirmed_with;
    #[cold]
    #[inline(never)]
    fn settle(
        shader: &Shader<'_>, lamp: &Lamp<'_>, seen: &Seen, in_doubt: RayBits, answers: &mut [i8; BUNDLE],
        stacks: &mut Stacks
    ) = settle_with;
}
