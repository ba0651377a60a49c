//! Convex bodies: cut by half-spaces, swept along a direction, joined with a point.
//!
//! A body is its vertices and the edges between them, each edge with the face on its left and right. A cut looks at the
//! side of each vertex once; everything after that is combinatorial, so faces stay closed whatever rounding does, and
//! flat bodies (a ground plane, a single point) are bodies like others. No heap: `parameterize` is measured in
//! microseconds. Source: the classic edge-based clipping of Sutherland and Hodgman 1974
//! `[sutherland1974]`, carried to polyhedra; the sweep
//! is the Minkowski sum with a segment, read off the silhouette.
//!
//! ```text
//!      from ──── left face ────> to       the left face goes round in the edge's direction,
//!           ──── right face ───           the right one against it, both counter-clockwise from outside
//! ```

mod entry;
mod sweep;

use glam::{DVec3, DVec4};

use super::{Aabb, OrientedBox, Plane};

// Derived from theory.md 1: K, a box cut by a camera frustum (6) and a light frustum (6), has at most 18 faces, so by Euler
// 32 vertices and 48 edges; during a cut old and new vertices exist side by side. Swept and cut again, real views stay below
// as well. 64, so that a set of vertices or of faces is one machine word.
const MAX_VERTICES: usize = 64;
const MAX_EDGES: usize = 128;
const MAX_FACES: usize = 64;
const NONE: u8 = u8::MAX;

/// A vertex this many units in the last place of the coordinates from a plane lies on it. Derived from the error bound of
/// a dot product of three terms plus offset (4 roundings) and of the cut that made the vertex (4 more).
const ON_PLANE_ULPS: f64 = 8.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    /// Nothing yet, to be filled where it stands: a body takes kilobytes, which cost more to move than to cut.
    pub const BLANK: Self = Self {
        vertices: [DVec3::ZERO; MAX_VERTICES],
        edges: [Edge { from: 0, to: 0, left: 0, right: 0 }; MAX_EDGES],
        normals: [DVec3::ZERO; MAX_FACES],
        vertex_count: 0,
        edge_count: 0,
        face_count: 0,
        magnitude: 0.0,
    };
    /// A body with the topology of a box: corners in the order of [`Aabb::corners`], normals in the order -x, +x, -y, +y,
    /// -z, +z. Frustums are such bodies.
    #[inline]
    pub fn from_hexahedron(corners: &[DVec3; 8], normals: &[DVec3; 6]) -> Self {
        let mut body = Self::BLANK;
        body.become_hexahedron(corners, normals);
        body
    }
    /// An axis-aligned box as a body.
    #[inline]
    pub fn from_aabb(bounds: &Aabb) -> Self {
        let mut body = Self::BLANK;
        body.become_aabb(bounds);
        body
    }
    /// Makes it the body that [`ConvexBody::from_hexahedron`] returns.
    fn become_hexahedron(&mut self, corners: &[DVec3; 8], normals: &[DVec3; 6]) {
        self.vertices[..8].copy_from_slice(corners);
        self.normals[..6].copy_from_slice(normals);
        for (edge, [from, to, left, right]) in self.edges.iter_mut().zip(BOX_EDGES) {
            *edge = Edge { from, to, left, right };
        }
        (self.vertex_count, self.edge_count, self.face_count) = (8, 12, 6);
        self.magnitude = corners.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
    }
    /// Makes it an axis-aligned box.
    pub fn become_aabb(&mut self, bounds: &Aabb) {
        const NORMALS: [DVec3; 6] = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z];
        self.become_hexahedron(&bounds.corners(), &NORMALS);
    }
    /// A parallelepiped as a body.
    #[inline]
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
    /// The ends of the edges, each edge once.
    pub fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> {
        self.edges[..self.edge_count].iter().map(|e| [self.vertices[e.from as usize], self.vertices[e.to as usize]])
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
            // `min` and `max` would also ask for NaN.
            (if value < low { value } else { low }, if value > high { value } else { high })
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
        let tolerance = self.tolerance(plane.offset);
        let (mut inside, mut outside) = (Set(0), Set(0));
        // The last vertex first: each moves the bits of those before it up.
        for p in self.vertices().iter().rev() {
            let distance = plane.distance(*p);
            outside.0 = outside.0 << 1 | u64::from(distance > tolerance);
            inside.0 = inside.0 << 1 | u64::from(distance < -tolerance);
        }
        if outside.0 == 0 {
            return;
        }
        if inside.0 == 0 {
            (self.vertex_count, self.edge_count, self.face_count) = (0, 0, 0);
            return;
        }
        if !self.has_room_for_cut(outside) {
            return;
        }
        let cap = self.face_count as u8;
        self.normals[self.face_count] = plane.normal;
        self.face_count += 1;
        // Where each face, gone round, leaves the half-space and where it comes back.
        let mut exit = [NONE; MAX_FACES];
        let mut entry = [NONE; MAX_FACES];
        let (mut cut_faces, mut inner_faces) = (Set(0), Set(0));
        // Dropped vertices are looked at until the last edge is cut, so new ones wait behind all.
        let places = Places { free: outside, behind: self.vertex_count as u8 };
        let (mut left, mut waiting) = (places, self.vertex_count);
        let mut kept = 0;
        for i in 0..self.edge_count {
            let mut e = self.edges[i];
            let (from_out, to_out) = (outside.has(e.from), outside.has(e.to));
            if from_out && to_out {
                continue;
            }
            if from_out != to_out {
                cut_faces.add(e.left);
                cut_faces.add(e.right);
                let (kept_end, lost_end) = if to_out { (e.from, e.to) } else { (e.to, e.from) };
                let on_plane = !inside.has(kept_end);
                let border = if on_plane {
                    kept_end
                } else {
                    self.vertices[waiting % MAX_VERTICES] = self.cut(kept_end, lost_end, plane);
                    waiting += 1;
                    left.next()
                };
                let (leaves, returns) = if to_out { (e.left, e.right) } else { (e.right, e.left) };
                exit[leaves as usize % MAX_FACES] = border;
                entry[returns as usize % MAX_FACES] = border;
                if on_plane {
                    continue;
                }
                inner_faces.add(e.left);
                inner_faces.add(e.right);
                *(if to_out { &mut e.to } else { &mut e.from }) = border;
            }
            self.edges[kept] = e;
            kept += 1;
        }
        self.edge_count = kept;
        // Only where vertices on the plane were all that a face has left inside is the question open.
        if cut_faces.0 & !inner_faces.0 != 0 {
            for e in self.edges[..kept].iter().filter(|e| inside.has(e.from) || inside.has(e.to)) {
                inner_faces.add(e.left);
                inner_faces.add(e.right);
            }
            // A face that keeps nothing but an edge on the plane gives that edge to the cap.
            self.give_edges_to(cap, Set(cut_faces.0 & !inner_faces.0));
        }
        let mut faces = cut_faces.0 & inner_faces.0;
        while faces != 0 {
            let face = faces.trailing_zeros() as u8;
            faces &= faces - 1;
            let (from, to) = (exit[face as usize], entry[face as usize]);
            if from != NONE && to != NONE && from != to && self.edge_count < MAX_EDGES {
                self.edges[self.edge_count] = Edge { from, to, left: face, right: cap };
                self.edge_count += 1;
            }
        }
        self.place_vertices(places, waiting);
    }
    /// Whether the vertices and edges of a cut fit. True for every K of theory.md 1 (see [`MAX_VERTICES`]); elsewhere a body
    /// that stays uncut still holds the cut one.
    fn has_room_for_cut(&self, outside: Set) -> bool {
        let crosses = |e: &Edge| outside.has(e.from) != outside.has(e.to);
        let fits = |new: usize| self.vertex_count + new <= MAX_VERTICES && self.edge_count + new <= MAX_EDGES;
        self.face_count < MAX_FACES
            && (fits(self.edge_count) || fits(self.edges[..self.edge_count].iter().filter(|e| crosses(e)).count()))
    }
    /// Where the edge from an inner to an outer vertex meets the plane.
    fn cut(&self, inside: u8, outside: u8, plane: &Plane) -> DVec3 {
        let [a, b] = [inside, outside].map(|i| self.vertices[i as usize % MAX_VERTICES]);
        let [inner, outer] = [a, b].map(|p| plane.distance(p));
        // Always from the inside out, so that both faces of an edge, and coinciding edges of a flat body, agree to the bit.
        let t = inner / (inner - outer);
        a + (b - a) * t
    }
    /// Gives their places to the vertices that lie behind the others, up to `end`, and closes the gaps that are left.
    fn place_vertices(&mut self, mut places: Places, end: usize) {
        for i in self.vertex_count..end {
            self.vertices[places.next() as usize % MAX_VERTICES] = self.vertices[i % MAX_VERTICES];
        }
        self.vertex_count = places.behind as usize;
        if places.free.0 != 0 {
            self.drop_vertices(places.free);
        }
    }
    /// Puts `cap` in the place of some faces; an edge between two of them goes.
    fn give_edges_to(&mut self, cap: u8, gone: Set) {
        let mut kept = 0;
        for i in 0..self.edge_count {
            let mut e = self.edges[i];
            e.left = if gone.has(e.left) { cap } else { e.left };
            e.right = if gone.has(e.right) { cap } else { e.right };
            if e.left != e.right {
                self.edges[kept] = e;
                kept += 1;
            }
        }
        self.edge_count = kept;
    }
    /// Closes the gaps that vertices without an edge leave: the last ones move there.
    fn drop_vertices(&mut self, dropped: Set) {
        if self.vertex_count == 0 {
            return;
        }
        let all = u64::MAX >> (MAX_VERTICES - self.vertex_count);
        let mut holes = dropped.0 & all;
        let count = self.vertex_count - holes.count_ones() as usize;
        let mut moving = all & !holes & (u64::MAX << count.min(63));
        self.vertex_count = count;
        if moving == 0 || count == MAX_VERTICES {
            return;
        }
        let mut renamed: [u8; MAX_VERTICES] = std::array::from_fn(|i| i as u8);
        while moving != 0 {
            let (from, to) = (moving.trailing_zeros() as usize, holes.trailing_zeros() as usize);
            self.vertices[to] = self.vertices[from];
            renamed[from] = to as u8;
            moving &= moving - 1;
            holes &= holes - 1;
        }
        for e in &mut self.edges[..self.edge_count] {
            e.from = renamed[e.from as usize % MAX_VERTICES];
            e.to = renamed[e.to as usize % MAX_VERTICES];
        }
    }
}

/// Places for the vertices that a cut makes: first those of the vertices that it drops.
#[derive(Clone, Copy)]
struct Places {
    /// What is left of the dropped ones'.
    free: Set,
    /// The first behind all vertices.
    behind: u8,
}

impl Places {
    fn next(&mut self) -> u8 {
        if self.free.0 == 0 {
            self.behind += 1;
            return self.behind - 1;
        }
        let place = self.free.0.trailing_zeros() as u8;
        self.free.0 &= self.free.0 - 1;
        place
    }
}

/// A set of vertices or faces, one bit each. Indices are below 64; the remainder tells the compiler so.
#[derive(Clone, Copy)]
struct Set(u64);

impl Set {
    fn has(self, i: u8) -> bool {
        self.0 >> (i % 64) & 1 == 1
    }
    fn add(&mut self, i: u8) {
        self.0 |= 1 << (i % 64);
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
