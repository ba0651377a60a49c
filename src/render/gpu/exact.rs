//! Triangles that single precision would misplace: projected, culled and clipped in f64 by the host.
//!
//! Where w falls far below the terms it is the sum of, f32 clip coordinates have no digit left: under a map whose w varies by
//! 1e5 every texel was wrong. Instances of which [`single_is_enough`](crate::render::precision) says no (a ground far larger
//! than its map, whatever lies near the singular plane of a strong warp) therefore come to the device as NDC of its viewport,
//! w = 1, one corner after the other. Clipping is the cpu renderer's (`[sutherland1974]`), on the viewport of
//! [`GuardBand`](super::guard_band) and both depth planes, so that nothing is left for the device to cut.

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
    /// Appends what shows of a mesh, whose instance has a slot.
    pub fn push(&mut self, mesh: &Mesh, viewport_from_local: &DMat4, slot: u32) {
        let clip: Vec<DVec4> =
            mesh.positions_local().par_iter().map(|p| *viewport_from_local * p.as_dvec3().extend(1.0)).collect();
        let parts: Vec<Self> = mesh
            .triangles()
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, triangles)| {
                let mut part = Self::default();
                let (mut polygons, mut tested) = ([vec![], vec![]], [vec![], vec![]]);
                for (i, triangle) in triangles.iter().enumerate() {
                    let id = [slot + 1, (chunk * CHUNK + i) as u32];
                    let corners = triangle.map(|v| clip[v as usize]);
                    let Some(test) = mesh.alpha_test() else {
                        part.push_triangle(corners, id, &mut polygons);
                        continue;
                    };
                    let uv = test.corners(*triangle);
                    let polygon = part.push_triangle([0, 1, 2].map(|k: usize| (corners[k], uv[k])), id, &mut tested);
                    part.push_coordinates(polygon);
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

    /// Appends what shows of a triangle; that polygon.
    fn push_triangle<'a, C: Corner>(
        &mut self,
        corners: [C; 3],
        id: [u32; 2],
        [polygon, cut]: &'a mut [Vec<C>; 2],
    ) -> &'a [C] {
        polygon.clear();
        let outside = corners.map(|c| outcode(c.clip()));
        if outside[0] & outside[1] & outside[2] != 0 {
            return polygon;
        }
        polygon.extend(corners);
        let crossed = outside[0] | outside[1] | outside[2];
        for plane in (0..PLANES.len()).filter(|k| crossed >> k & 1 != 0) {
            clip_polygon(polygon, PLANES[plane], cut);
            std::mem::swap(polygon, cut);
        }
        // w = 0 is left only where x = y = z = 0 too, which has no direction to be seen in.
        polygon.retain(|c| c.clip().w > 0.0);
        for k in 2..polygon.len() {
            self.corners.extend([polygon[0], polygon[k - 1], polygon[k]].map(|c| ndc(c.clip())));
            self.ids.extend([id; 3]);
        }
        polygon
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

/// The planes a point is beyond.
fn outcode(clip: DVec4) -> u32 {
    // Written so that a NaN (of a matrix at the limits of f64) is outside.
    let beyond = |k: usize| u32::from(!(PLANES[k].dot(clip) >= 0.0)) << k;
    (0..PLANES.len()).map(beyond).sum()
}

/// The part of a polygon inside a plane. An edge is cut from its inner to its outer end, so neighbours cut it alike.
fn clip_polygon<C: Corner>(polygon: &[C], plane: DVec4, out: &mut Vec<C>) {
    out.clear();
    for (i, &current) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (d0, d1) = (plane.dot(current.clip()), plane.dot(next.clip()));
        let cut = |inside: C, outside: C, d0: f64, d1: f64| inside.towards(outside, d0 / (d0 - d1));
        if d0 >= 0.0 {
            out.push(current);
        }
        if d0 >= 0.0 && d1 < 0.0 {
            out.push(cut(current, next, d0, d1));
        } else if d0 < 0.0 && d1 >= 0.0 {
            out.push(cut(next, current, d1, d0));
        }
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
        t.push_triangle(corners.map(DVec4::from_array), [1, 7], &mut Default::default());
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
}
