//! View frustums and light pyramids as corners and half-spaces.
//!
//! ```text
//!            ___---| far
//!     near |-      |          axis ->
//! apex  <  |       |          a pyramid begins at `near` = 0 where only its sides and its base cut
//!            ---___|
//! ```

use glam::DVec3;

use super::{ConvexBody, Plane};

/// How the sides of a frustum run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// Through the apex: a pyramid.
    Converging,
    /// Along the axis: a box.
    Parallel,
}

/// A pyramid with its apex at a point, or a box, cut across its axis; its middle may lie beside the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// Where depths begin; where the sides of a pyramid meet.
    pub apex: DVec3,
    /// Unit vector to the right, across the axis.
    pub right: DVec3,
    /// Unit vector upwards, across the axis.
    pub up: DVec3,
    /// Unit vector along the axis.
    pub forward: DVec3,
    /// How its sides run.
    pub sides: Sides,
    /// Half width and half height: of a pyramid at depth 1, so tangents.
    pub half: [f64; 2],
    /// Its middle, to the right and upwards, in the same measure.
    pub center: [f64; 2],
    /// Depth of the first cut.
    pub near: f64,
    /// Depth of the base.
    pub far: f64,
}

impl Frustum {
    /// Where the sides are: left, right, bottom, top, in the measure of `half`.
    pub fn edges(&self) -> [f64; 4] {
        let [x, y] = self.center;
        let [half_x, half_y] = self.half;
        [x - half_x, x + half_x, y - half_y, y + half_y]
    }
    /// Outward unit normals: left, right, bottom, top, near, far (the face order of [`ConvexBody::from_hexahedron`]).
    fn normals(&self) -> [DVec3; 6] {
        let [left, right, bottom, top] = self.edges();
        let side = |across: DVec3, tangent: f64| match self.sides {
            // Divided by the larger of 1 and the tangent first: the tangent of nearly a right angle squared overflows.
            Sides::Converging => (across - self.forward * tangent) / 1.0_f64.hypot(tangent),
            Sides::Parallel => across,
        };
        [
            side(-self.right, -left),
            side(self.right, right),
            side(-self.up, -bottom),
            side(self.up, top),
            -self.forward,
            self.forward,
        ]
    }
    /// The six half-spaces: left, right, bottom, top, near, far.
    pub fn planes(&self) -> [Plane; 6] {
        let (n, apex) = (self.normals(), self.apex);
        let at = |depth: f64| apex + self.forward * depth;
        let sides = match self.sides {
            Sides::Converging => [apex; 4],
            Sides::Parallel => {
                let [left, right, bottom, top] = self.edges();
                [self.right * left, self.right * right, self.up * bottom, self.up * top].map(|off| apex + off)
            }
        };
        let points = [sides[0], sides[1], sides[2], sides[3], at(self.near), at(self.far)];
        std::array::from_fn(|i| Plane::through(points[i], n[i]))
    }
    /// The point at a place across the axis, in the measure of `half`, and a depth.
    pub fn at(&self, x: f64, y: f64, depth: f64) -> DVec3 {
        match self.sides {
            Sides::Converging => self.apex + (self.right * x + self.up * y + self.forward) * depth,
            Sides::Parallel => self.apex + self.right * x + self.up * y + self.forward * depth,
        }
    }
    /// The eight corners; bit 0 of the index chooses right, bit 1 up, bit 2 far.
    pub fn corners(&self) -> [DVec3; 8] {
        let [left, right, bottom, top] = self.edges();
        std::array::from_fn(|i| {
            let depth = if i & 4 == 0 { self.near } else { self.far };
            let x = if i & 1 == 0 { left } else { right };
            let y = if i & 2 == 0 { bottom } else { top };
            self.at(x, y, depth)
        })
    }
    /// Depth of the middle and radius of the smallest sphere around it with its middle on the line through the middles of its
    /// cuts (1.2).
    pub fn sphere(&self) -> (f64, f64) {
        let (near, far, [half_x, half_y]) = (self.near, self.far, self.half);
        if self.sides == Sides::Parallel {
            return (0.5 * near + 0.5 * far, (0.5 * (far - near)).hypot(half_x.hypot(half_y)));
        }
        // Of the corner that is farthest aside, k to the line's middle and beside it; the line leans by `lean`.
        let ([x, y], k) = (self.center, half_x.hypot(half_y));
        let lean = 1.0_f64.hypot(x.hypot(y));
        let towards = x.abs() * half_x + y.abs() * half_y;
        // Squared distance of that corner at a depth from the line's point at another: lean² Δ² + 2 |Δ| depth towards +
        // (depth k)², over the depth of the base.
        let distance = |depth: f64, center: f64| {
            let apart = (depth - center).abs() / far;
            let own = depth / far;
            ((lean * apart).powi(2) + 2.0 * apart * own * towards + (own * k).powi(2)).sqrt()
        };
        if towards == 0.0 {
            let center = far.min(0.5 * (near + far) * (1.0 + k * k));
            return (center, (far - center).hypot(far * k).max((near - center).hypot(near * k)));
        }
        // Convex in the middle's depth; thirds of f64 come to an end after some 90 steps.
        let radius = |center: f64| distance(near, center).max(distance(far, center));
        let [mut low, mut high] = [near, far];
        for _ in 0..100 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if radius(a) <= radius(b) { high = b } else { low = a }
        }
        let center = 0.5 * (low + high);
        (center, far * radius(center))
    }
    /// The frustum as a body.
    pub fn body(&self) -> ConvexBody {
        let (mut corners, mut normals) = (self.corners(), self.normals());
        // (right, up, forward) of a camera is left-handed where a box's axes are right-handed.
        if self.right.cross(self.up).dot(self.forward) < 0.0 {
            for i in 0..4 {
                corners.swap(2 * i, 2 * i + 1);
            }
            normals.swap(0, 1);
        }
        ConvexBody::from_hexahedron(&corners, &normals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frustums() -> Vec<Frustum> {
        let mut all = Vec::new();
        for right in [DVec3::X, DVec3::NEG_X] {
            for center in [[0.0, 0.0], [0.3, -0.2], [-2.0, 1.5]] {
                for (sides, near) in [(Sides::Converging, 0.5), (Sides::Parallel, 0.5), (Sides::Parallel, -7.0)] {
                    let (apex, up, forward) = (DVec3::new(1.0, 2.0, 3.0), DVec3::Y, DVec3::NEG_Z);
                    all.push(Frustum { apex, right, up, forward, sides, half: [0.8, 0.5], center, near, far: 20.0 });
                }
            }
        }
        all
    }

    #[test]
    fn corners_lie_on_three_planes_each_and_behind_the_others() {
        for f in frustums() {
            let planes = f.planes();
            for p in f.corners() {
                let on = planes.iter().filter(|q| q.distance(p).abs() < 1e-12).count();
                assert!(on == 3 && planes.iter().all(|q| q.distance(p) < 1e-12), "{f:?}");
            }
            let mut body = f.body();
            planes.iter().for_each(|q| body.clip(q));
            assert_eq!(body.vertices().len(), 8, "{f:?}");
        }
    }

    #[test]
    fn no_smaller_sphere_on_the_line_of_the_middles_holds_a_frustum() {
        for f in frustums() {
            let (depth, radius) = f.sphere();
            let farthest = |depth: f64| {
                let center = f.at(f.center[0], f.center[1], depth);
                f.corners().iter().map(|p| (*p - center).length()).fold(0.0, f64::max)
            };
            assert!((farthest(depth) / radius - 1.0).abs() < 1e-12, "{f:?}: {radius} and {}", farthest(depth));
            let least = (0..=4000).map(|i| farthest(f.near + (f.far - f.near) * f64::from(i) / 4000.0));
            assert!(radius <= least.fold(f64::INFINITY, f64::min) * (1.0 + 1e-12), "{f:?}");
        }
    }

    #[test]
    fn a_nearly_flat_cone_has_finite_planes() {
        let f = Frustum {
            apex: DVec3::ZERO,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            sides: Sides::Converging,
            half: [1.6e16, 1e200],
            center: [0.0, 0.0],
            near: 0.0,
            far: 1.0,
        };
        assert!(f.planes().iter().all(|p| p.normal.is_normalized() && p.offset.is_finite()));
    }
}
