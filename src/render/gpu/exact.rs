//! Triangles that single precision would misplace: projected, culled and clipped in f64 by the host.
//!
//! Where w falls far below the terms it is the sum of, f32 clip coordinates have no digit left: under a map whose w varies by
//! 1e5 every texel was wrong. Instances of which [`single_is_enough`](crate::render::precision) says no (a ground far larger
//! than its map, whatever lies near the singular plane of a strong warp) therefore come to the device as NDC of its viewport,
//! w = 1, one corner after the other. Clipping is the cpu renderer's (`[sutherland1974]`), on the viewport of
//! [`GuardBand`](super::guard_band) and both depth planes, so that nothing is left for the device to cut.
//!
//! Devices lay a plane of depth through three corners, and its rounding is relative to the largest of them. The depth of the eye's
//! view is reversed: on a floor under the eye it falls from 1 at the near plane to 1e-6 and less, where nothing would be left of
//! it. [`Depths::Reversed`] therefore cuts such triangles into strips whose depth varies by [`STRIP`] at most.

use glam::{DMat4, DVec2, DVec4};
use rayon::prelude::*;

use crate::scene::Mesh;

/// Triangles that a thread projects at once.
const CHUNK: usize = 1 << 12;

/// The clip volume: where all of these are not negative.
const PLANES: [DVec4; 6] = [
    DVec4::new(0.0, 0.0, 1.0, 0.0),
    DVec4::new(0.0, 0.0, -1.0, 1.0),
    DVec4::new(1.0, 0.0, 0.0, 1.0),
    DVec4::new(-1.0, 0.0, 0.0, 1.0),
    DVec4::new(0.0, 1.0, 0.0, 1.0),
    DVec4::new(0.0, -1.0, 0.0, 1.0),
];

/// Most that a reversed depth varies within what a device interpolates.
const STRIP: f64 = 4.0;
/// The least depth that strips begin at, below which single precision has few digits of its own: 4^-32.
const LEAST: f64 = 1.0 / (1u64 << 32) as f64 / (1u64 << 32) as f64;

/// What depths of a pass mean, and with that how they err.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Depths {
    /// 0 at near to 1 at far: errors are alike everywhere.
    Forward,
    /// 1 at near to 0 at far: errors are relative to a depth.
    Reversed,
}

/// Triangles in the NDC of the viewport, three corners each.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct ExactTriangles {
    pub corners: Vec<[f32; 3]>,
    /// For each corner slot + 1 and the index of its triangle in the mesh, as in ids.wgsl.
    pub ids: Vec<[u32; 2]>,
    /// Of meshes with alpha tests for each corner (u q, v q, 0, q), where q is 1 / w times a factor that a triangle shares.
    pub coordinates: Vec<[f32; 4]>,
}

/// A corner that can be cut: a point of clip space, perhaps with texture coordinates.
trait Corner: Copy {
    fn clip(&self) -> DVec4;
    /// A part of the way to another.
    fn towards(self, other: Self, part: f64) -> Self;
}

impl Corner for DVec4 {
    fn clip(&self) -> DVec4 {
        *self
    }
    fn towards(self, other: Self, part: f64) -> Self {
        self + (other - self) * part
    }
}

impl Corner for (DVec4, DVec2) {
    fn clip(&self) -> DVec4 {
        self.0
    }
    fn towards(self, other: Self, part: f64) -> Self {
        (self.0.towards(other.0, part), self.1 + (other.1 - self.1) * part)
    }
}

impl ExactTriangles {
    /// Appends what shows of a mesh, whose instance has a slot; corners in the order that is outwards under a matrix that
    /// changes nothing, if they are to be turned.
    pub fn push(&mut self, mesh: &Mesh, viewport_from_local: &DMat4, slot: u32, depths: Depths, turns: bool) {
        let is_turned = turns && viewport_from_local.determinant() <= 0.0;
        let clip: Vec<DVec4> =
            mesh.positions_local().par_iter().map(|p| *viewport_from_local * p.as_dvec3().extend(1.0)).collect();
        let parts: Vec<Self> = mesh
            .triangles()
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, triangles)| {
                let mut part = Self::default();
                let (mut opaque, mut tested) = (Polygons::default(), Polygons::default());
                for (i, triangle) in triangles.iter().enumerate() {
                    let id = [slot + 1, (chunk * CHUNK + i) as u32];
                    let [a, b, c] = *triangle;
                    let triangle = &if is_turned { [a, c, b] } else { [a, b, c] };
                    let corners = triangle.map(|v| clip[v as usize]);
                    let Some(test) = mesh.alpha_test() else {
                        opaque.show(corners, depths, |polygon| part.push_polygon(polygon, id));
                        continue;
                    };
                    let uv = test.corners(*triangle);
                    tested.show([0, 1, 2].map(|k: usize| (corners[k], uv[k])), depths, |polygon| {
                        part.push_polygon(polygon, id);
                        part.push_coordinates(polygon);
                    });
                }
                part
            })
            .collect();
        for part in parts {
            self.corners.extend(part.corners);
            self.ids.extend(part.ids);
            self.coordinates.extend(part.coordinates);
        }
    }

    fn push_polygon<C: Corner>(&mut self, polygon: &[C], id: [u32; 2]) {
        for k in 2..polygon.len() {
            self.corners.extend([polygon[0], polygon[k - 1], polygon[k]].map(|c| ndc(c.clip())));
            self.ids.extend([id; 3]);
        }
    }

    /// Appends the texture coordinates of a polygon's triangles.
    fn push_coordinates(&mut self, polygon: &[(DVec4, DVec2)]) {
        // At most 1, whatever the scale of w.
        let least = polygon.iter().map(|(clip, _)| clip.w).fold(f64::INFINITY, f64::min);
        let at = |k: usize| {
            let (clip, uv) = polygon[k];
            let q = least / clip.w;
            [uv.x * q, uv.y * q, 0.0, q].map(|x| x as f32)
        };
        for k in 2..polygon.len() {
            self.coordinates.extend([at(0), at(k - 1), at(k)]);
        }
    }
}

/// Room to cut a triangle in.
struct Polygons<C> {
    polygon: Vec<C>,
    cut: Vec<C>,
    beyond: Vec<C>,
}

impl<C> Default for Polygons<C> {
    fn default() -> Self {
        Self { polygon: vec![], cut: vec![], beyond: vec![] }
    }
}

impl<C: Corner> Polygons<C> {
    /// Hands over the convex polygons that show of a triangle.
    fn show(&mut self, corners: [C; 3], depths: Depths, mut take: impl FnMut(&[C])) {
        let Self { polygon, cut, beyond } = self;
        let outside = corners.map(|c| outcode(c.clip()));
        if outside[0] & outside[1] & outside[2] != 0 {
            return;
        }
        polygon.clear();
        polygon.extend(corners);
        let crossed = outside[0] | outside[1] | outside[2];
        for plane in (0..PLANES.len()).filter(|k| crossed >> k & 1 != 0) {
            split(polygon, PLANES[plane], cut, None);
            std::mem::swap(polygon, cut);
        }
        // w = 0 is left only where x = y = z = 0 too, which has no direction to be seen in.
        polygon.retain(|c| c.clip().w > 0.0);
        if depths == Depths::Reversed {
            let depth = |c: &C| c.clip().z / c.clip().w;
            let nearest = polygon.iter().map(depth).fold(0.0, f64::max);
            let farthest = polygon.iter().map(depth).fold(1.0, f64::min);
            // The same depths for all triangles, so that neighbours are cut at the same points.
            let mut strip = STRIP.powi(nearest.max(LEAST).log(STRIP).ceil() as i32 - 1);
            while strip > farthest && strip >= LEAST {
                split(polygon, DVec4::new(0.0, 0.0, 1.0, -strip), cut, Some(beyond));
                take(cut);
                std::mem::swap(polygon, beyond);
                strip /= STRIP;
            }
        }
        take(polygon);
    }
}

/// The planes a point is beyond.
fn outcode(clip: DVec4) -> u32 {
    // Written so that a NaN (of a matrix at the limits of f64) is outside.
    let beyond = |k: usize| u32::from(!(PLANES[k].dot(clip) >= 0.0)) << k;
    (0..PLANES.len()).map(beyond).sum()
}

/// The part of a polygon inside a plane, and perhaps the part beyond it. An edge is cut from its inner to its outer end, so
/// neighbours, and both parts, cut it alike.
fn split<C: Corner>(polygon: &[C], plane: DVec4, inside: &mut Vec<C>, mut beyond: Option<&mut Vec<C>>) {
    inside.clear();
    beyond.iter_mut().for_each(|corners| corners.clear());
    for (i, &current) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (d0, d1) = (plane.dot(current.clip()), plane.dot(next.clip()));
        let cut = |inner: C, outer: C, d0: f64, d1: f64| inner.towards(outer, d0 / (d0 - d1));
        let crossing = match (d0 >= 0.0, d1 >= 0.0) {
            (true, false) => Some(cut(current, next, d0, d1)),
            (false, true) => Some(cut(next, current, d1, d0)),
            _ => None,
        };
        let own = if d0 >= 0.0 { Some(&mut *inside) } else { beyond.as_deref_mut() };
        own.into_iter().for_each(|corners| corners.push(current));
        inside.extend(crossing);
        beyond.iter_mut().for_each(|corners| corners.extend(crossing));
    }
}

/// NDC within the clip volume, whatever rounding the cuts have left.
fn ndc(clip: DVec4) -> [f32; 3] {
    let [x, y, z] = [clip.x / clip.w, clip.y / clip.w, clip.z / clip.w];
    [x.clamp(-1.0, 1.0) as f32, y.clamp(-1.0, 1.0) as f32, z.clamp(0.0, 1.0) as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of a triangle in clip space.
    fn left(corners: [[f64; 4]; 3]) -> ExactTriangles {
        let mut t = ExactTriangles::default();
        Polygons::default().show(corners.map(DVec4::from_array), Depths::Forward, |p| t.push_polygon(p, [1, 7]));
        t
    }

    fn area(t: &ExactTriangles) -> f32 {
        t.corners
            .chunks(3)
            .map(|p| {
                let [a, b] = [1, 2].map(|k: usize| [p[k][0] - p[0][0], p[k][1] - p[0][1]]);
                0.5 * (a[0] * b[1] - a[1] * b[0])
            })
            .sum()
    }

    #[test]
    fn what_is_inside_stays_and_what_is_outside_goes() {
        let inside = left([[-1.0, -1.0, 0.5, 2.0], [1.0, -1.0, 0.5, 2.0], [0.0, 1.0, 1.0, 1.0]]);
        assert_eq!(inside.corners, [[-0.5, -0.5, 0.25], [0.5, -0.5, 0.25], [0.0, 1.0, 1.0]]);
        assert_eq!(inside.ids, [[1, 7]; 3]);
        assert!(left([[2.0, 0.0, 0.5, 1.0], [3.0, 0.0, 0.5, 1.0], [2.0, 1.0, 0.5, 1.0]]).corners.is_empty());
        assert!(left([[0.0, 0.0, 0.5, -1.0], [1.0, 0.0, 0.5, -1.0], [0.0, 1.0, 0.5, -1.0]]).corners.is_empty());
        assert!(left([[f64::NAN; 4]; 3]).corners.is_empty());
    }

    #[test]
    fn a_triangle_over_everything_becomes_the_whole_viewport() {
        let all = left([[-9.0, -9.0, 0.5, 1.0], [9.0, -9.0, 0.5, 1.0], [0.0, 9.0, 0.5, 1.0]]);
        assert_eq!(area(&all), 4.0);
        // A corner behind the projection centre: the part above y = 1/3 w, where the edges cross w = 0 at infinity.
        let behind = left([[-1.0, 0.0, 0.5, 1.0], [1.0, 0.0, 0.5, 1.0], [0.0, 1.0, -0.5, -1.0]]);
        assert!(area(&behind) > 0.9 && behind.corners.iter().flatten().all(|x| x.is_finite()), "{behind:?}");
    }

    #[test]
    fn strips_cover_the_triangle_and_vary_little_in_depth() {
        // A floor from the near plane to the horizon: depth 1 to 1e-7.
        let corners = [[-0.9, -0.9, 1.0, 1.0], [0.9, -0.9, 1.0, 1.0], [0.0, 0.9e7, 1.0, 1e7]].map(DVec4::from_array);
        let (mut strips, mut whole) = (vec![], ExactTriangles::default());
        Polygons::default().show(corners, Depths::Reversed, |p| {
            strips.push(p.to_vec());
            whole.push_polygon(p, [1, 7]);
        });
        assert_eq!(strips.len(), 12, "4^-11 > 1e-7 > 4^-12");
        for strip in &strips {
            let depths: Vec<f64> = strip.iter().map(|c| c.z / c.w).collect();
            let (least, most) = depths.iter().fold((1.0, 0.0), |(a, b): (f64, f64), &d| (a.min(d), b.max(d)));
            assert!(most <= STRIP * least * (1.0 + 1e-12) && most > least, "{depths:?}");
        }
        for pair in strips.windows(2) {
            let shared = pair[0].iter().filter(|c| pair[1].contains(c)).count();
            assert_eq!(shared, 2, "two strips meet in the same points: {pair:?}");
        }
        assert!((area(&whole) - 1.62).abs() < 1e-6, "{}", area(&whole));
        let forward = left(corners.map(|c| c.to_array()));
        assert_eq!(forward.corners.len(), 3);
    }
}
