//! Cutting of the few triangles that need it, in clip space.

/// The polygon that is left of a triangle while it is cut, in clip space.
#[derive(Debug, Default)]
pub struct Polygon {
    corners: Vec<[f64; 4]>,
    kept: Vec<[f64; 4]>,
}

impl Polygon {
    /// Begins with a triangle.
    pub fn start(&mut self, corners: [[f64; 4]; 3]) {
        self.corners.clear();
        self.corners.extend(corners);
    }
    /// What is left, in order; fewer than three: nothing.
    pub fn corners(&self) -> &[[f64; 4]] {
        &self.corners
    }
    /// Cuts off where a distance, linear in clip coordinates, is negative (`[sutherland1974]`). An edge is cut from
    /// its inner to its outer end, so that neighbours cut it at the same point.
    pub fn cut(&mut self, distance: impl Fn([f64; 4]) -> f64) {
        self.kept.clear();
        for (i, &current) in self.corners.iter().enumerate() {
            let next = self.corners[(i + 1) % self.corners.len()];
            let (d0, d1) = (distance(current), distance(next));
            let between = |inside: [f64; 4], outside: [f64; 4], d_in: f64, d_out: f64| {
                let t = d_in / (d_in - d_out);
                std::array::from_fn(|i| inside[i] + t * (outside[i] - inside[i]))
            };
            if d0 >= 0.0 {
                self.kept.push(current);
            }
            if d0 >= 0.0 && d1 < 0.0 {
                self.kept.push(between(current, next, d0, d1));
            } else if d0 < 0.0 && d1 >= 0.0 {
                self.kept.push(between(next, current, d1, d0));
            }
        }
        std::mem::swap(&mut self.corners, &mut self.kept);
    }
}
