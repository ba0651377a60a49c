//! Convex bodies: cut by half-spaces, swept along a direction, joined with a point.
//!
//! A body is its vertices and the edges between them, each edge with the face on its left and right. A cut looks at the
//! side of each vertex once; everything after that is combinatorial, so faces stay closed whatever rounding does, and
//! flat bodies (a ground plane, a single point) are bodies like others. No heap: `parameterize` is measured in
//! microseconds. Source: the classic edge-based clipping of Sutherland and Hodgman 1974, carried to polyhedra; the sweep
//! is the Minkowski sum with a segment, read off the silhouette.
//!
//! ```text
//!      from ──── left face ────> to       the left face goes round in the edge's direction,
//!           ──── right face ───           the right one against it, both counter-clockwise from outside
//! ```

mod sweep;

use glam::{DVec3, DVec4};

use super::{Aabb, OrientedBox, Plane};

// Derived from theory.md 1: a box cut by a camera frustum (6) and a light frustum (6) has at most 18 faces, so 32 vertices
// and 48 edges (Euler); swept, at most 18 more faces; cut by box and light frustum again, 12 more. 48 faces in all give
// 92 vertices and 138 edges; during a cut the old and the new vertices exist side by side.
const MAX_VERTICES: usize = 128;
const MAX_EDGES: usize = 192;
const MAX_FACES: usize = 80;
const NONE: u8 = u8::MAX;

/// A vertex this many units in the last place of the coordinates from a plane lies on it. Derived from the error bound of
/// a dot product of three terms plus offset (4 roundings) and of the cut that made the vertex (4 more).
const ON_PLANE_ULPS: f64 = 8.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Edge {
    from: u8,
    to: u8,
    left: u8,
    right: u8,
}

/// A bounded convex polyhedron, perhaps flat, perhaps empty.
#[derive(Debug, Clone, Copy)]
pub struct ConvexBody {
    vertices: [DVec3; MAX_VERTICES],
    edges: [Edge; MAX_EDGES],
    normals: [DVec3; MAX_FACES],
    vertex_count: usize,
    edge_count: usize,
    face_count: usize,
    /// Largest coordinate the body ever had: the scale of its rounding errors.
    magnitude: f64,
}

/// Corner indices of the edges of a box and the faces (0 -x, 1 +x, 2 -y, 3 +y, 4 -z, 5 +z) left and right of them; corner
/// bits as in [`Aabb::corners`].
const BOX_EDGES: [[u8; 4]; 12] = [
    [0, 1, 2, 4],
    [2, 3, 4, 3],
    [4, 5, 5, 2],
    [6, 7, 3, 5],
    [0, 2, 4, 0],
    [1, 3, 1, 4],
    [4, 6, 0, 5],
    [5, 7, 5, 1],
    [0, 4, 0, 2],
    [1, 5, 2, 1],
    [2, 6, 3, 0],
    [3, 7, 1, 3],
];

impl ConvexBody {
    fn blank() -> Self {
        Self {
            vertices: [DVec3::ZERO; MAX_VERTICES],
            edges: [Edge::default(); MAX_EDGES],
            normals: [DVec3::ZERO; MAX_FACES],
            vertex_count: 0,
            edge_count: 0,
            face_count: 0,
            magnitude: 0.0,
        }
    }
    /// A body with the topology of a box: corners in the order of [`Aabb::corners`], normals in the order -x, +x, -y, +y,
    /// -z, +z. Frustums are such bodies.
    pub fn from_hexahedron(corners: &[DVec3; 8], normals: &[DVec3; 6]) -> Self {
        let mut body = Self::blank();
        body.vertices[..8].copy_from_slice(corners);
        body.normals[..6].copy_from_slice(normals);
        for (edge, [from, to, left, right]) in body.edges.iter_mut().zip(BOX_EDGES) {
            *edge = Edge { from, to, left, right };
        }
        (body.vertex_count, body.edge_count, body.face_count) = (8, 12, 6);
        body.magnitude = corners.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        body
    }
    /// An axis-aligned box as a body.
    pub fn from_aabb(bounds: &Aabb) -> Self {
        const NORMALS: [DVec3; 6] = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z];
        Self::from_hexahedron(&bounds.corners(), &NORMALS)
    }
    /// A parallelepiped as a body.
    pub fn from_oriented_box(b: &OrientedBox) -> Self {
        let mut corners = b.corners();
        let mut normals = b.normals();
        // A mirrored box: its faces must still go round counter-clockwise.
        if b.half[0].cross(b.half[1]).dot(b.half[2]) < 0.0 {
            for i in 0..4 {
                corners.swap(2 * i, 2 * i + 1);
            }
            normals.swap(0, 1);
        }
        Self::from_hexahedron(&corners, &normals)
    }
    /// The vertices.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices[..self.vertex_count]
    }
    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.vertex_count == 0
    }
    /// The mean of the vertices; the origin for an empty body.
    pub fn vertex_mean(&self) -> DVec3 {
        self.vertices().iter().sum::<DVec3>() / (self.vertex_count.max(1) as f64)
    }
    /// The smallest axis-aligned box around it.
    pub fn aabb(&self) -> Aabb {
        Aabb::from_points(self.vertices().iter().copied())
    }
    /// Smallest and largest value over the body of `functional · (p, 1)`; (infinity, -infinity) when empty.
    pub fn range(&self, functional: DVec4) -> (f64, f64) {
        self.vertices().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            let value = functional.dot(p.extend(1.0));
            (low.min(value), high.max(value))
        })
    }
    /// How far a point lies outside of the body: 0 inside and on the border, a lower bound of the distance elsewhere.
    pub fn distance_outside(&self, p: DVec3) -> f64 {
        let beyond = |face: u8, on_face: u8| (p - self.vertices[on_face as usize]).dot(self.normals[face as usize]);
        self.edges[..self.edge_count]
            .iter()
            .fold(0.0, |most: f64, e| most.max(beyond(e.left, e.from)).max(beyond(e.right, e.from)))
    }
    /// How far from a plane with this offset a point of the body may lie by rounding alone.
    pub fn tolerance(&self, offset: f64) -> f64 {
        ON_PLANE_ULPS * f64::EPSILON * (self.magnitude + offset.abs())
    }
    /// Cuts off everything outside the half-space. A body that only touches it is empty afterwards.
    pub fn clip(&mut self, plane: &Plane) {
        #[derive(Clone, Copy, PartialEq)]
        enum Side {
            In,
            On,
            Out,
        }
        let tolerance = self.tolerance(plane.offset);
        let mut distance = [0.0; MAX_VERTICES];
        let mut side = [Side::On; MAX_VERTICES];
        let (mut any_in, mut any_out) = (false, false);
        for (i, p) in self.vertices().iter().enumerate() {
            let d = plane.distance(*p);
            distance[i] = d;
            if d > tolerance {
                side[i] = Side::Out;
                any_out = true;
            } else if d < -tolerance {
                side[i] = Side::In;
                any_in = true;
            }
        }
        if !any_out {
            return;
        }
        if !any_in {
            (self.vertex_count, self.edge_count, self.face_count) = (0, 0, 0);
            return;
        }
        let crossing = |e: &Edge| (side[e.from as usize] == Side::Out) != (side[e.to as usize] == Side::Out);
        let crossings = self.edges[..self.edge_count].iter().filter(|e| crossing(e)).count();
        // Cannot happen by the counts above; if rounding made it happen, an uncut body is still a body that holds the cut one.
        if self.vertex_count + crossings > MAX_VERTICES
            || self.edge_count + crossings > MAX_EDGES
            || self.face_count == MAX_FACES
        {
            debug_assert!(false, "convex body out of room");
            return;
        }
        let cap = self.face_count as u8;
        self.normals[self.face_count] = plane.normal;
        self.face_count += 1;
        // Where each face, gone round, leaves the half-space and where it comes back.
        let mut exit = [NONE; MAX_FACES];
        let mut entry = [NONE; MAX_FACES];
        let mut has_inside = [false; MAX_FACES];
        let mut kept = 0;
        for i in 0..self.edge_count {
            let mut e = self.edges[i];
            let (from, to) = (side[e.from as usize], side[e.to as usize]);
            if from == Side::In || to == Side::In {
                has_inside[e.left as usize] = true;
                has_inside[e.right as usize] = true;
            }
            match (from == Side::Out, to == Side::Out) {
                (true, true) => continue,
                (false, false) => {}
                (false, true) => {
                    let border = if from == Side::In { self.cut(e.from, e.to, &distance) } else { e.from };
                    exit[e.left as usize] = border;
                    entry[e.right as usize] = border;
                    if from == Side::On {
                        continue;
                    }
                    e.to = border;
                }
                (true, false) => {
                    let border = if to == Side::In { self.cut(e.to, e.from, &distance) } else { e.to };
                    entry[e.left as usize] = border;
                    exit[e.right as usize] = border;
                    if to == Side::On {
                        continue;
                    }
                    e.from = border;
                }
            }
            self.edges[kept] = e;
            kept += 1;
        }
        // A face that keeps nothing but an edge on the plane gives that edge to the cap.
        let gone = |face: u8| exit[face as usize] != NONE && !has_inside[face as usize];
        let mut count = 0;
        for i in 0..kept {
            let mut e = self.edges[i];
            if gone(e.left) {
                e.left = cap;
            }
            if gone(e.right) {
                e.right = cap;
            }
            if e.left != e.right {
                self.edges[count] = e;
                count += 1;
            }
        }
        for face in 0..cap {
            let (from, to) = (exit[face as usize], entry[face as usize]);
            if has_inside[face as usize] && from != NONE && to != NONE && from != to && count < MAX_EDGES {
                self.edges[count] = Edge { from, to, left: face, right: cap };
                count += 1;
            }
        }
        self.edge_count = count;
        self.drop_unused_vertices();
    }
    /// A new vertex where the edge from an inner to an outer vertex meets the plane.
    fn cut(&mut self, inside: u8, outside: u8, distance: &[f64; MAX_VERTICES]) -> u8 {
        let (a, b) = (inside as usize, outside as usize);
        // Always from the inside out, so that both faces of an edge, and coinciding edges of a flat body, agree to the bit.
        let t = distance[a] / (distance[a] - distance[b]);
        self.vertices[self.vertex_count] = self.vertices[a] + (self.vertices[b] - self.vertices[a]) * t;
        self.vertex_count += 1;
        (self.vertex_count - 1) as u8
    }
    fn drop_unused_vertices(&mut self) {
        let mut used = [false; MAX_VERTICES];
        for e in &self.edges[..self.edge_count] {
            used[e.from as usize] = true;
            used[e.to as usize] = true;
        }
        let mut renamed = [0; MAX_VERTICES];
        let mut count = 0;
        for i in 0..self.vertex_count {
            if used[i] {
                renamed[i] = count as u8;
                self.vertices[count] = self.vertices[i];
                count += 1;
            }
        }
        self.vertex_count = count;
        for e in &mut self.edges[..self.edge_count] {
            e.from = renamed[e.from as usize];
            e.to = renamed[e.to as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every face of a closed body is gone round: each of its vertices is entered as often as left.
    pub(super) fn assert_closed(body: &ConvexBody) {
        let mut balance = std::collections::BTreeMap::<(u8, u8), i32>::new();
        for e in &body.edges[..body.edge_count] {
            for (face, from, to) in [(e.left, e.from, e.to), (e.right, e.to, e.from)] {
                *balance.entry((face, from)).or_default() -= 1;
                *balance.entry((face, to)).or_default() += 1;
            }
        }
        assert!(balance.values().all(|&b| b == 0), "{balance:?}");
    }

    pub(super) fn unit_box() -> ConvexBody {
        ConvexBody::from_aabb(&Aabb { min: DVec3::ZERO, max: DVec3::ONE })
    }

    /// Volume by tetrahedra from the mean; each edge spans one with either face's own mean.
    pub(super) fn volume(body: &ConvexBody) -> f64 {
        let center = body.vertex_mean();
        let mut total = 0.0;
        for face in 0..body.face_count as u8 {
            let round = body.edges[..body.edge_count].iter().filter_map(|e| {
                let (a, b) = (body.vertices[e.from as usize], body.vertices[e.to as usize]);
                if e.left == face { Some((a, b)) } else { (e.right == face).then_some((b, a)) }
            });
            let sides: Vec<_> = round.collect();
            let middle = sides.iter().map(|s| s.0).sum::<DVec3>() / sides.len().max(1) as f64;
            total +=
                sides.iter().map(|(a, b)| (middle - center).dot((a - middle).cross(b - middle)) / 6.0).sum::<f64>();
        }
        total
    }

    #[test]
    fn faces_of_a_box_go_round_counter_clockwise() {
        let body = unit_box();
        assert_closed(&body);
        for e in &body.edges[..body.edge_count] {
            let (a, b) = (body.vertices[e.from as usize], body.vertices[e.to as usize]);
            for (face, along) in [(e.left, b - a), (e.right, a - b)] {
                let to_left = body.normals[face as usize].cross(along);
                assert!(to_left.dot(DVec3::splat(0.5) - a) > 0.0, "face {face}");
            }
        }
        assert!((volume(&body) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn cuts_through_corners_edges_and_faces() {
        let diagonal = Plane::through(DVec3::splat(0.5), DVec3::new(1.0, -1.0, 0.0).normalize());
        let mut body = unit_box();
        body.clip(&diagonal);
        assert_closed(&body);
        assert!((volume(&body) - 0.5).abs() < 1e-15 && body.vertices().len() == 6);
        let corner = Plane::through(DVec3::new(0.0, 0.0, 1.0), DVec3::ONE.normalize());
        let mut body = unit_box();
        body.clip(&corner);
        assert_closed(&body);
        assert!((volume(&body) - 1.0 / 6.0).abs() < 1e-15 && body.vertices().len() == 4);
        for (offset, vertices) in [(0.0, 8), (-1.0, 0), (-2.0, 0), (1.0, 8)] {
            let mut body = unit_box();
            body.clip(&Plane { normal: DVec3::X, offset: -1.0 - offset });
            assert_eq!(body.vertices().len(), if offset == -1.0 { 0 } else { vertices }, "{offset}");
        }
    }

    #[test]
    fn flat_bodies_stay_bodies() {
        let flat = Aabb { min: DVec3::new(-3.0, 0.25, -3.0), max: DVec3::new(3.0, 0.25, 3.0) };
        let mut body = ConvexBody::from_aabb(&flat);
        body.clip(&Plane::through(DVec3::X, DVec3::new(1.0, 0.2, 0.3).normalize()));
        body.clip(&Plane::through(DVec3::Y * 0.25, DVec3::Y));
        assert_closed(&body);
        assert!(!body.is_empty() && body.vertices().iter().all(|p| p.y == 0.25));
        let point = Aabb { min: DVec3::ONE, max: DVec3::ONE };
        let mut body = ConvexBody::from_aabb(&point);
        body.clip(&Plane::through(DVec3::X * 2.0, DVec3::X));
        assert_eq!(body.aabb(), point);
    }
}
