//! Which centres of a triangle with an alpha test exist.
//!
//! Source: homogeneous rasterisation (Olano, Greer 1997 `[olano1997]`): in a projective map the barycentric coordinates of the
//! point that a place (X, Y) shows are, up to a common factor, the products of (X, Y, 1) with the cross products of the
//! corners' (x, y, w). No corner is divided by its w, so triangles that cross the projection centre need no clipping, and the
//! point is where the ray of the texel's centre meets the triangle's plane: the one that truth asks for.

use glam::{DMat4, DVec2, DVec3};

use crate::scene::{AlphaTest, Mesh};

/// A triangle with an alpha test as a map shows it.
#[derive(Debug, Clone, Copy)]
pub struct TestedTriangle<'a> {
    test: &'a AlphaTest,
    /// Of each corner, what gives its barycentric coordinate times a common factor.
    weights: [DVec3; 3],
    uv: [DVec2; 3],
}

impl<'a> TestedTriangle<'a> {
    /// A triangle of a mesh; nothing where that has no test. `clip_from_local` gives x, y and w in rows 0, 1 and 3.
    pub fn new(mesh: &'a Mesh, triangle: usize, clip_from_local: &DMat4) -> Option<Self> {
        let test = mesh.alpha_test()?;
        let corners = mesh.triangles()[triangle];
        let [a, b, c] = corners.map(|i| {
            let clip = *clip_from_local * mesh.positions_local()[i as usize].as_dvec3().extend(1.0);
            DVec3::new(clip.x, clip.y, clip.w)
        });
        // Differences first: the cross products of the nearly parallel corners of a small triangle lose their digits.
        let weights = [b.cross(c - b), c.cross(a - c), a.cross(b - a)];
        Some(Self { test, weights, uv: test.corners(corners) })
    }

    /// Whether the point at a place exists. One that lies beside the triangle by a rounding counts as on its edge.
    #[inline]
    pub fn exists_at(&self, x: f64, y: f64) -> bool {
        let place = DVec3::new(x, y, 1.0);
        let weights = self.weights.map(|weight| weight.dot(place));
        let sign = if weights[0] + weights[1] + weights[2] < 0.0 { -1.0 } else { 1.0 };
        let [a, b, c] = weights.map(|weight| (weight * sign).max(0.0));
        let sum = a + b + c;
        let uv = (self.uv[0] * a + self.uv[1] * b + self.uv[2] * c) / sum;
        // A triangle seen edge on has no point of its own: its middle stands for it.
        let uv = if uv.is_finite() { uv } else { (self.uv[0] + self.uv[1] + self.uv[2]) / 3.0 };
        self.test.exists(uv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AlphaTestParts, AlphaTexture, Wrap};

    #[test]
    fn coordinates_are_those_of_the_point_on_the_ray() {
        let texture = Some(AlphaTexture::new([2, 1], vec![0, 255]).unwrap().into());
        let uv = vec![[0.25, 0.0], [0.75, 0.0], [0.25, 0.0]];
        let parts = AlphaTestParts { texture, uv, cutoff: 0.5, wrap: [Wrap::Clamp; 2], factor: 1.0 };
        let test = Some(AlphaTest::new(parts).unwrap());
        // From depth 1 at the left to depth 9 at the right: the middle of u is at depth 5.
        let vertices = [[-1.0, 0.0, -1.0], [9.0, 0.0, -9.0], [-1.0, 1.0, -1.0]];
        let mesh = Mesh::with_alpha_test(&vertices, &[[0, 1, 2]], test).unwrap();
        let clip = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 0.5, 20.0);
        let clip_from_local = clip * DMat4::from(*mesh.mesh_from_local());
        let triangle = TestedTriangle::new(&mesh, 0, &clip_from_local).unwrap();
        let along = |t: f64| {
            let p = clip * glam::DVec4::new(-1.0 + 10.0 * t, 0.0, -1.0 - 8.0 * t, 1.0);
            p.x / p.w
        };
        for (t, exists) in [(0.0, false), (0.4, false), (0.4999, false), (0.5001, true), (0.9, true), (1.0, true)] {
            assert_eq!(triangle.exists_at(along(t), 0.0), exists, "{t}");
        }
    }
}
