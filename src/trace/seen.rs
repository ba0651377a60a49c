//! The surfaces that rays of a bundle from the eye meet: all that shading needs of them and that no light changes, side by side.

use glam::DVec3;

use super::hierarchy::{Face, Inner};
use super::rays::{BUNDLE, Each, RayBits, WorldRays};
use super::walk::Closest;

/// Points of surfaces, `[axis][ray]`, relative to the scene's origin.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub struct Seen {
    /// On the planes of the triangles.
    pub point: [[f64; BUNDLE]; 3],
    /// Unit, towards the eye.
    pub normal: [[f64; BUNDLE]; 3],
    /// How much more the normal of a sliver errs: edges over height.
    pub sliver: [f64; BUNDLE],
    pub faces: [Face; BUNDLE],
    /// Rays that meet a surface. The numbers of others have no meaning.
    pub bits: RayBits,
    /// Rays that meet a triangle that has no area in the world: thinner than f64 tells.
    pub flat: RayBits,
}

impl Seen {
    /// Of those rays in `bits` that meet anything.
    #[inline(always)]
    pub fn new<const BAND: bool>(
        scene: &Inner,
        rays: &WorldRays<BUNDLE>,
        closest: &[Closest<BAND>; BUNDLE],
        bits: RayBits,
    ) -> Self {
        let mut seen = Self {
            point: [[0.0; BUNDLE]; 3],
            normal: [[0.0; BUNDLE]; 3],
            sliver: [0.0; BUNDLE],
            faces: [(0, 0); BUNDLE],
            bits: 0,
            flat: 0,
        };
        // Corners, `[corner][axis][ray]`.
        let (mut corners, mut t) = ([[[0.0; BUNDLE]; 3]; 3], [0.0; BUNDLE]);
        for r in Each(bits) {
            let Some(face) = closest[r].face else { continue };
            seen.bits |= 1 << r;
            seen.faces[r] = face;
            t[r] = closest[r].t;
            let [a, b, c] = scene.corners(face.0, face.1);
            for axis in 0..3 {
                corners[0][axis][r] = a[axis];
                corners[1][axis][r] = b[axis];
                corners[2][axis][r] = c[axis];
            }
        }
        if seen.bits == 0 {
            return seen;
        }
        let mut is_flat = [false; BUNDLE];
        for r in 0..BUNDLE {
            let vector = |v: &[[f64; BUNDLE]; 3]| DVec3::new(v[0][r], v[1][r], v[2][r]);
            let [a, b, c] = [vector(&corners[0]), vector(&corners[1]), vector(&corners[2])];
            let (ab, ac) = (b - a, c - a);
            // Scaled, so that the squares of tiny triangles do not underflow.
            let scale = ab.abs().max(ac.abs()).max_element();
            let (ab, ac) = (ab / scale, ac / scale);
            let area = ab.cross(ac);
            let length = area.length();
            let per_length = 1.0 / length;
            is_flat[r] = !((per_length > 0.0) & (per_length < f64::INFINITY));
            let normal = area * per_length;
            let (origin, direction) = (vector(&rays.origin), vector(&rays.direction));
            let side = if normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
            let normal = normal * side;
            let point = origin + t[r] * direction;
            // Onto the plane: the error that is left does not depend on how far away the eye is.
            let point = point - normal * normal.dot(point - a);
            // Where nothing is seen, a number: what is not one takes long ways.
            let point = if is_flat[r] { DVec3::ZERO } else { point };
            for axis in 0..3 {
                seen.point[axis][r] = point[axis];
                seen.normal[axis][r] = normal[axis];
            }
            seen.sliver[r] = ab.length() * ac.length() / length;
        }
        for r in Each(seen.bits) {
            seen.flat |= u32::from(is_flat[r]) << r;
        }
        seen
    }
    /// The point that a ray meets.
    pub fn point(&self, ray: usize) -> DVec3 {
        DVec3::new(self.point[0][ray], self.point[1][ray], self.point[2][ray])
    }
    /// The normal there.
    pub fn normal(&self, ray: usize) -> DVec3 {
        DVec3::new(self.normal[0][ray], self.normal[1][ray], self.normal[2][ray])
    }
}
