//! Bodies grown towards a light: along a direction, or to a point.

use glam::DVec3;

use super::{ConvexBody, Edge, MAX_EDGES, MAX_FACES, MAX_VERTICES, NONE, Set};
use crate::geometry::{Aabb, Plane};

impl ConvexBody {
    /// The body swept along `-direction` (unit) by `length`: everything from which a ray along `direction` of at most that
    /// length meets the body.
    pub fn swept_against(&self, direction: DVec3, length: f64) -> Self {
        // The faces that look against the direction move, the others stay, and the silhouette between them draws sides.
        let moves = |face: u8| self.normals[face as usize].dot(direction) < 0.0;
        let shift = -direction * length;
        if !self.has_room_for(self.vertex_count, self.silhouette(moves)) {
            let box_here = self.aabb();
            return Self::from_aabb(&box_here.union(Aabb { min: box_here.min + shift, max: box_here.max + shift }));
        }
        let mut body = *self;
        let mut top = [NONE; MAX_VERTICES];
        let mut side_out = [NONE; MAX_VERTICES];
        let mut side_in = [NONE; MAX_VERTICES];
        let top_of = |body: &mut Self, top: &mut [u8; MAX_VERTICES], v: u8| {
            if top[v as usize] == NONE {
                top[v as usize] = body.vertex_count as u8;
                body.vertices[body.vertex_count] = self.vertices[v as usize] + shift;
                body.vertex_count += 1;
            }
            top[v as usize]
        };
        for i in 0..self.edge_count {
            let e = self.edges[i];
            let (left, right) = (moves(e.left), moves(e.right));
            if !left && !right {
                continue;
            }
            let (from, to) = (top_of(&mut body, &mut top, e.from), top_of(&mut body, &mut top, e.to));
            if left && right {
                body.edges[i] = Edge { from, to, ..e };
                continue;
            }
            // The lower face on the left, the side on the right; above, the side on the left, the moved face on the right.
            let (low_from, low_to, top_from, top_to, low, moved) = if right {
                (e.from, e.to, from, to, e.left, e.right)
            } else {
                (e.to, e.from, to, from, e.right, e.left)
            };
            let side = body.face_count as u8;
            let along = self.vertices[low_to as usize] - self.vertices[low_from as usize];
            body.normals[body.face_count] = unit_across(along, direction);
            body.face_count += 1;
            body.edges[i] = Edge { from: low_from, to: low_to, left: low, right: side };
            body.push_edge(Edge { from: top_from, to: top_to, left: side, right: moved });
            side_out[low_from as usize] = side;
            side_in[low_to as usize] = side;
        }
        for v in 0..self.vertex_count {
            if side_out[v] != NONE && side_in[v] != NONE {
                body.push_edge(Edge { from: v as u8, to: top[v], left: side_out[v], right: side_in[v] });
            }
        }
        body.finish();
        body
    }
    /// The convex hull of the body and a point.
    pub fn hull_with(&self, p: DVec3) -> Self {
        let mut seen = [false; MAX_FACES];
        for e in &self.edges[..self.edge_count] {
            for face in [e.left, e.right] {
                let plane = Plane::through(self.vertices[e.from as usize], self.normals[face as usize]);
                seen[face as usize] |= plane.distance(p) > self.tolerance(plane.offset);
            }
        }
        if !self.has_room_for(1, self.silhouette(|face| seen[face as usize])) {
            return Self::from_aabb(&self.aabb().with_point(p));
        }
        let mut body = *self;
        let apex = body.vertex_count as u8;
        body.vertices[body.vertex_count] = p;
        body.vertex_count += 1;
        let mut side_out = [NONE; MAX_VERTICES];
        let mut side_in = [NONE; MAX_VERTICES];
        let mut kept = 0;
        for i in 0..self.edge_count {
            let e = self.edges[i];
            let (left, right) = (seen[e.left as usize], seen[e.right as usize]);
            if left && right {
                continue;
            }
            body.edges[kept] = e;
            if left || right {
                let (from, to, low) = if right { (e.from, e.to, e.left) } else { (e.to, e.from, e.right) };
                let side = body.face_count as u8;
                let along = self.vertices[to as usize] - self.vertices[from as usize];
                body.normals[body.face_count] = unit_across(p - self.vertices[from as usize], along);
                body.face_count += 1;
                body.edges[kept] = Edge { from, to, left: low, right: side };
                side_out[from as usize] = side;
                side_in[to as usize] = side;
            }
            kept += 1;
        }
        body.edge_count = kept;
        for v in 0..self.vertex_count {
            if side_out[v] != NONE && side_in[v] != NONE {
                body.push_edge(Edge { from: v as u8, to: apex, left: side_out[v], right: side_in[v] });
            }
        }
        body.finish();
        body
    }
    /// How many edges lie between a chosen face and one that is not.
    fn silhouette(&self, chosen: impl Fn(u8) -> bool) -> usize {
        self.edges[..self.edge_count].iter().filter(|e| chosen(e.left) != chosen(e.right)).count()
    }
    /// Whether so many more vertices fit, and a face and two edges for each edge of the silhouette. True for every K (see
    /// [`MAX_VERTICES`]); otherwise a box around the result is given, which only holds more.
    fn has_room_for(&self, vertices: usize, silhouette: usize) -> bool {
        self.vertex_count + vertices <= MAX_VERTICES
            && self.face_count + silhouette <= MAX_FACES
            && self.edge_count + 2 * silhouette <= MAX_EDGES
    }
    fn push_edge(&mut self, e: Edge) {
        self.edges[self.edge_count] = e;
        self.edge_count += 1;
    }
    fn finish(&mut self) {
        let mut used = Set(0);
        for e in &self.edges[..self.edge_count] {
            used.add(e.from);
            used.add(e.to);
        }
        self.drop_vertices(Set(!used.0));
        self.magnitude = self.vertices().iter().fold(self.magnitude, |m, p| m.max(p.abs().max_element()));
    }
}

/// The unit vector across two others; zero where they are parallel up to rounding: a face between them has no area.
fn unit_across(a: DVec3, b: DVec3) -> DVec3 {
    let cross = a.cross(b);
    let has_area = cross.length() > f64::EPSILON.sqrt() * a.length() * b.length();
    if has_area { cross.normalize() } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_closed, unit_box, volume};
    use super::*;

    #[test]
    fn a_sweep_adds_shadow_times_length_and_the_hull_holds_the_point() {
        let l = DVec3::new(0.3, -0.9, 0.2).normalize();
        let swept = unit_box().swept_against(l, 4.0);
        assert_closed(&swept);
        let shadow = l.x.abs() + l.y.abs() + l.z.abs();
        assert!((volume(&swept) - 1.0 - 4.0 * shadow).abs() < 1e-13);
        let straight = unit_box().swept_against(DVec3::NEG_Y, 2.0);
        assert_closed(&straight);
        assert!((volume(&straight) - 3.0).abs() < 1e-14 && straight.aabb().max.y == 3.0);
        let hull = unit_box().hull_with(DVec3::new(0.5, 3.0, 0.5));
        assert_closed(&hull);
        assert!((volume(&hull) - 1.0 - 2.0 / 3.0).abs() < 1e-14 && hull.vertices().len() == 9);
        assert_eq!(unit_box().hull_with(DVec3::splat(0.5)).vertices().len(), 8);
    }
}
