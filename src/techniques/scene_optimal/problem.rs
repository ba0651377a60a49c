//! Homographies of a light's rays with four free parameters, and what they cost.
//!
//! Source: theory.md 10.2 (10.6). With rays y told from the middle of the hull, w = 1 + h·y and q = y / w, every map whose
//! square circumscribes the hull is given by h and by the directions of its two axes in the plane of q; scale and
//! translation follow. Of a ray's d(pixel) / dy the map's is
//!
//! ```text
//!      G = D (dy / dq) [A1 / N1, A2 / N2],      (dy / dq)ᵀ a = w (a + h (y·a))
//!
//!         .---------.   A1, A2: sides of the parallelogram around
//!      A2/  .-'-.  /    the hull in the plane of q
//!       /  (     )/
//!      '-----A1--'
//! ```
//!
//! h = E p / (p·m), E = e^ρ - 1, ρ = |p|, m = hull's last corner along p - e^ρ its first: w runs from 1 to e^ρ over the hull,
//! so that p has no bounds.

use glam::{DMat2, DMat3, DVec2, DVec3};

use super::objective::Cost;

/// A sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Its ray; in a problem from the middle of the hull, in units of the hull's extent.
    pub y: DVec2,
    /// d(pixel) / dy, two rows; or across an edge in the first, the second zero.
    pub rows: [DVec2; 2],
    /// Pixels that it stands for.
    pub weight: f64,
}

/// A homography up to scale and translation, which containment decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// w = 1 + h·y.
    pub h: DVec2,
    /// Directions of the map's axes in the plane of q, unit vectors.
    pub axes: [DVec2; 2],
}

/// What is searched over.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Middle of the hull and its extent from there, of rays.
    middle: DVec2,
    unit: f64,
    /// Corners, in units of the search.
    hull: Vec<DVec2>,
    /// Samples, so that every beginning is spread over all.
    pub samples: Vec<Sample>,
    /// Texels that receivers fill along x and y.
    texels: DVec2,
    cost: Cost,
}

/// Samples under a w, whatever the axes.
#[derive(Debug, Clone)]
pub struct Warped<'a> {
    problem: &'a Problem,
    h: DVec2,
    /// d(pixel) / dq, and weights.
    rows: Vec<([DVec2; 2], f64)>,
    weights: f64,
    /// Weight of samples that w is not positive at.
    lost: f64,
}

impl Warped<'_> {
    /// The mean cost of a map with these axes.
    pub fn value(&self, axes: [DVec2; 2]) -> f64 {
        let Problem { texels, cost, .. } = self.problem;
        let [a, b] = self.problem.parallelogram(&Shape { h: self.h, axes }).sides();
        let [a, b] = [a / texels.x, b / texels.y];
        let mut sum = if self.lost > 0.0 { self.lost * cost.worst() } else { 0.0 };
        for ([c, d], weight) in &self.rows {
            let g = DMat2::from_cols_array(&[c.dot(a), d.dot(a), c.dot(b), d.dot(b)]);
            sum += weight * cost.of(&g).0;
        }
        if self.weights > 0.0 { sum / self.weights } else { 0.0 }
    }
}

/// The parallelogram around the hull in the plane of q.
struct Parallelogram {
    shape: Shape,
    /// Corners of the hull at whose images it is touched, low and high, by the sides along each axis' other one.
    touched: [[DVec2; 2]; 2],
}

impl Parallelogram {
    fn w(&self, y: DVec2) -> f64 {
        1.0 + self.shape.h.dot(y)
    }
    /// From the lower to the higher of the touched corners, in the plane of q.
    fn spans(&self) -> [DVec2; 2] {
        self.touched.map(|[low, high]| high / self.w(high) - low / self.w(low))
    }
    /// Its sides along both axes.
    fn sides(&self) -> [DVec2; 2] {
        let [s, t] = self.shape.axes;
        let (x, spans) = (cross(s, t), self.spans());
        [s * (cross(spans[0], t) / x), t * (cross(s, spans[1]) / x)]
    }
    /// Derivatives of the sides by h's coordinates.
    fn by_h(&self) -> [[DVec2; 2]; 2] {
        let [s, t] = self.shape.axes;
        let x = cross(s, t);
        [0, 1].map(|j| {
            let by = |y: DVec2| -y * (y[j] / (self.w(y) * self.w(y)));
            let [across, along] = self.touched.map(|[low, high]| by(high) - by(low));
            [s * (cross(across, t) / x), t * (cross(s, along) / x)]
        })
    }
    /// Derivatives of the sides by the angles of the axes.
    fn by_angle(&self) -> [[DVec2; 2]; 2] {
        let [s, t] = self.shape.axes;
        let (x, [across, along]) = (cross(s, t), self.spans());
        let (e_s, e_t) = (cross(across, t), cross(s, along));
        let (turn_s, turn_t) = (s.perp(), t.perp());
        let (x_by_s, x_by_t) = (cross(turn_s, t), cross(s, turn_t));
        [
            [
                turn_s * (e_s / x) - s * (e_s * x_by_s / (x * x)),
                t * (cross(turn_s, along) / x - e_t * x_by_s / (x * x)),
            ],
            [
                s * (cross(across, turn_t) / x - e_s * x_by_t / (x * x)),
                turn_t * (e_t / x) - t * (e_t * x_by_t / (x * x)),
            ],
        ]
    }
}

fn cross(a: DVec2, b: DVec2) -> f64 {
    a.perp_dot(b)
}

impl Problem {
    /// The problem of a hull of rays, with samples told in rays. Nothing for a hull without extent.
    pub fn new(hull: &[DVec2], samples: impl Iterator<Item = Sample>, texels: DVec2, cost: Cost) -> Option<Self> {
        // Inside of the hull, as the middle of its box need not be.
        let middle = hull.iter().sum::<DVec2>() / hull.len().max(1) as f64;
        let unit = hull.iter().map(|p| (*p - middle).abs().max_element()).fold(0.0, f64::max);
        let doubled =
            (0..hull.len()).map(|i| cross(hull[i] - middle, hull[(i + 1) % hull.len()] - middle)).sum::<f64>();
        if !(hull.len() >= 3 && doubled.abs() > f64::EPSILON.sqrt() * unit * unit && unit.is_finite()) {
            return None;
        }
        let hull = hull.iter().map(|p| (*p - middle) / unit).collect();
        let told = |s: Sample| Sample { y: (s.y - middle) / unit, rows: s.rows.map(|row| row * unit), ..s };
        Some(Self { middle, unit, hull, samples: samples.map(told).collect(), texels, cost })
    }
    /// The shape of a homography of rays; nothing where its w is not positive on the hull.
    pub fn shape_of(&self, homography: &DMat3) -> Option<Shape> {
        let told = |i: usize| {
            let row = homography.row(i);
            (row.truncate() * self.unit, row.dot(self.middle.extend(1.0)))
        };
        let (w, w_middle) = told(2);
        let h = w / w_middle;
        let normal = |i: usize| {
            let (along, at_middle) = told(i);
            along - h * at_middle
        };
        let axes = [-normal(1).perp(), normal(0).perp()].map(|axis| axis.try_normalize());
        let shape = Shape { h, axes: [axes[0]?, axes[1]?] };
        (w_middle != 0.0 && h.is_finite() && self.least_w(h) > 0.0 && cross(shape.axes[0], shape.axes[1]) != 0.0)
            .then_some(shape)
    }
    /// The homography of rays, x, y and w up to a positive factor and the crop; its axes turn as rays' do.
    pub fn homography(&self, shape: &Shape) -> DMat3 {
        let [s, t] = shape.axes;
        // Along one axis the other one's coordinate is constant.
        let turn = cross(s, t).signum();
        let rows = [-t.perp() * turn, s.perp()];
        let told = |covector: DVec2, constant: f64| {
            let along = covector / self.unit;
            along.extend(constant - along.dot(self.middle))
        };
        let w: DVec3 = told(shape.h, 1.0);
        DMat3::from_cols(told(rows[0], 0.0), told(rows[1], 0.0), w).transpose()
    }
    fn least_w(&self, h: DVec2) -> f64 {
        self.hull.iter().map(|y| 1.0 + h.dot(*y)).fold(f64::INFINITY, f64::min)
    }
    /// p of a shape's h.
    pub fn p_of(&self, h: DVec2) -> DVec2 {
        let w = self.hull.iter().map(|y| 1.0 + h.dot(*y));
        let (low, high) = w.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), w| (l.min(w), m.max(w)));
        h.try_normalize().map_or(DVec2::ZERO, |along| along * (high / low).ln())
    }
    /// h of p, and its derivatives by p's coordinates.
    pub fn h_of(&self, p: DVec2) -> (DVec2, DMat2) {
        let rho = p.length();
        let Some(along) = p.try_normalize() else { return (DVec2::ZERO, DMat2::ZERO) };
        let by = |y: &&DVec2| along.dot(**y);
        let first = self.hull.iter().min_by(|a, b| by(a).total_cmp(&by(b))).copied().unwrap_or_default();
        let last = self.hull.iter().max_by(|a, b| by(a).total_cmp(&by(b))).copied().unwrap_or_default();
        let (e, grown) = (rho.exp_m1(), rho.exp());
        let m = last - grown * first;
        let scale = p.dot(m).recip();
        let h = p * (e * scale);
        let column = |j: usize| {
            let (unit, growth) = (DVec2::AXES[j], grown * along[j]);
            // d(p·m) = m_j + p·dm
            let below = m[j] - growth * p.dot(first);
            unit * (e * scale) + p * (growth * scale - e * below * scale * scale)
        };
        (h, DMat2::from_cols(column(0), column(1)))
    }
    fn parallelogram(&self, shape: &Shape) -> Parallelogram {
        let Shape { h, axes: [s, t] } = *shape;
        // Ends of the hull along a covector of q, as corners.
        let ends = |covector: DVec2| {
            let (mut low, mut high) = ((f64::INFINITY, DVec2::ZERO), (f64::NEG_INFINITY, DVec2::ZERO));
            for y in &self.hull {
                let at = covector.dot(*y) / (1.0 + h.dot(*y));
                if at < low.0 {
                    low = (at, *y);
                }
                if at > high.0 {
                    high = (at, *y);
                }
            }
            [low.1, high.1]
        };
        // q's extent across the other axis, cross(q, t) for s and cross(s, q) for t.
        Parallelogram { shape: *shape, touched: [ends(-t.perp()), ends(s.perp())] }
    }
    /// The mean cost over the first samples, at most `most`.
    pub fn value(&self, shape: &Shape, most: usize) -> f64 {
        self.with(shape.h, most).value(shape.axes)
    }
    /// The first samples, at most `most`, under a w.
    pub fn with(&self, h: DVec2, most: usize) -> Warped<'_> {
        let (mut weights, mut lost) = (0.0, 0.0);
        let mut rows = Vec::with_capacity(most.min(self.samples.len()));
        for s in self.samples.iter().take(most) {
            let w = 1.0 + h.dot(s.y);
            weights += s.weight;
            if w > 0.0 {
                rows.push((s.rows.map(|row| (row + h * s.y.dot(row)) * w), s.weight));
            } else {
                lost += s.weight;
            }
        }
        Warped { problem: self, h, rows, weights, lost }
    }
    /// The same with its derivatives by h and by the angles of the axes.
    pub fn slopes(&self, shape: &Shape, most: usize) -> (f64, [f64; 4]) {
        let around = self.parallelogram(shape);
        let per = [self.texels.x.recip(), self.texels.y.recip()];
        let told = |sides: [DVec2; 2]| [sides[0] * per[0], sides[1] * per[1]];
        let ([a, b], by_h, by_angle) = (told(around.sides()), around.by_h().map(told), around.by_angle().map(told));
        let (mut sum, mut weights, mut slopes) = (0.0, 0.0, [0.0; 4]);
        for s in self.samples.iter().take(most) {
            let w = 1.0 + shape.h.dot(s.y);
            weights += s.weight;
            if w <= 0.0 {
                sum += s.weight * self.cost.worst();
                continue;
            }
            let moved = s.rows.map(|row| row + shape.h * s.y.dot(row));
            let [c, d] = moved.map(|row| row * w);
            let g = DMat2::from_cols_array(&[c.dot(a), d.dot(a), c.dot(b), d.dot(b)]);
            let (value, by_g) = self.cost.of(&g);
            sum += s.weight * value;
            let product = |m: [f64; 4]| {
                let k = by_g.to_cols_array();
                s.weight * (k[0] * m[0] + k[1] * m[1] + k[2] * m[2] + k[3] * m[3])
            };
            for j in 0..2 {
                // (row + h (y·row)) w by h_j
                let by = |i: usize| moved[i] * s.y[j] + DVec2::AXES[j] * (w * s.y.dot(s.rows[i]));
                let (c_by, d_by, [a_by, b_by]) = (by(0), by(1), by_h[j]);
                slopes[j] += product([
                    c_by.dot(a) + c.dot(a_by),
                    d_by.dot(a) + d.dot(a_by),
                    c_by.dot(b) + c.dot(b_by),
                    d_by.dot(b) + d.dot(b_by),
                ]);
                let [a_by, b_by] = by_angle[j];
                slopes[2 + j] += product([c.dot(a_by), d.dot(a_by), c.dot(b_by), d.dot(b_by)]);
            }
        }
        let per_weight = if weights > 0.0 { weights.recip() } else { 0.0 };
        (sum * per_weight, slopes.map(|x| x * per_weight))
    }
    /// Half extents of the hull in the plane of q.
    pub fn box_of(&self, h: DVec2) -> DVec2 {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for y in &self.hull {
            let q = *y / (1.0 + h.dot(*y));
            (low, high) = (low.min(q), high.max(q));
        }
        0.5 * (high - low)
    }
}
