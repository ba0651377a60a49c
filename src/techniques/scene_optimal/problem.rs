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

use super::kernel::{Block, LANES, Sample, Sides, Sums, blocks_of, slopes, sum};
use super::objective::{Cost, Objective};
use crate::focus::RayEdge;

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
    blocks: Vec<Block>,
    /// The weight of the first 0, 1, 2, ... blocks.
    weights: Vec<f64>,
    /// Texels that receivers fill along x and y.
    texels: DVec2,
    cost: Cost,
}

/// The hull under a w, whatever the axes.
#[derive(Debug, Clone)]
pub struct Warped<'a> {
    problem: &'a Problem,
    h: DVec2,
    /// Corners of the hull in the plane of q.
    corners: Vec<DVec2>,
}

impl Warped<'_> {
    /// The mean cost of a map with these axes over the first samples, about `most`.
    pub fn value(&self, axes: [DVec2; 2], most: usize) -> f64 {
        let [s, t] = axes;
        let span = |covector: DVec2| {
            let at = self.corners.iter().map(|q| covector.dot(*q));
            let (low, high) = at.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (lower(l, x), higher(h, x)));
            high - low
        };
        let x = cross(s, t);
        let sides = [s * (span(-t.perp()) / x), t * (span(s.perp()) / x)];
        self.problem.mean(self.h, sides, self.problem.texels, most)
    }
}

/// The sides of a texel of a map whose parallelogram has these sides.
fn texel(h: DVec2, sides: [DVec2; 2], texels: DVec2) -> Sides {
    let told = |side: DVec2| [side.x, side.y, h.dot(side)];
    Sides { h: h.to_array(), sides: [told(sides[0] / texels.x), told(sides[1] / texels.y)] }
}

/// The lower of two numbers; one that is none is passed over.
fn lower(least: f64, x: f64) -> f64 {
    if x < least { x } else { least }
}

fn higher(most: f64, x: f64) -> f64 {
    if x > most { x } else { most }
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
        let blocks = blocks_of(&samples.map(told).collect::<Vec<_>>());
        let mut weights = vec![0.0];
        weights.extend(blocks.iter().scan(0.0, |sum, block| {
            *sum += block.weight();
            Some(*sum)
        }));
        Some(Self { middle, unit, hull, blocks, weights, texels, cost })
    }
    /// The problem of samples at shadows' edges.
    pub fn of_edges<'a>(
        hull: &[DVec2],
        edges: impl Iterator<Item = &'a RayEdge>,
        texels: DVec2,
        cost: Cost,
    ) -> Option<Self> {
        let rows = |edge: &RayEdge| match cost.objective {
            Objective::Edge => [edge.across, DVec2::ZERO],
            _ => [edge.pixel.row(0), edge.pixel.row(1)],
        };
        Self::new(hull, edges.map(|e| Sample { y: e.ray, rows: rows(e), weight: e.weight }), texels, cost)
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
    /// The first samples in blocks, about `most`, and their weight.
    fn first(&self, most: usize) -> (&[Block], f64) {
        let count = most.div_ceil(LANES).min(self.blocks.len());
        (&self.blocks[..count], self.weights[count])
    }
    fn mean(&self, h: DVec2, sides: [DVec2; 2], texels: DVec2, most: usize) -> f64 {
        let (blocks, weight) = self.first(most);
        let sums = sum(blocks, &texel(h, sides, texels), &self.cost);
        self.mean_of(&sums, weight)
    }
    fn mean_of(&self, sums: &Sums, weight: f64) -> f64 {
        let lost = if sums.lost > 0.0 { sums.lost * self.cost.worst() } else { 0.0 };
        if weight > 0.0 { (sums.value + lost) / weight } else { 0.0 }
    }
    /// The mean cost over the first samples, about `most`; infinite for a shape without a map.
    pub fn value(&self, shape: &Shape, most: usize) -> f64 {
        self.value_of(shape, self.texels, most)
    }
    /// The mean cost over all samples of a map in which receivers fill so many texels.
    pub fn value_with(&self, shape: &Shape, texels: DVec2) -> f64 {
        self.value_of(shape, texels, usize::MAX)
    }
    fn value_of(&self, shape: &Shape, texels: DVec2, most: usize) -> f64 {
        let sides = self.parallelogram(shape).sides();
        let is_map = shape.h.is_finite() && sides.iter().all(|side| side.is_finite());
        if is_map { self.mean(shape.h, sides, texels, most) } else { f64::INFINITY }
    }
    /// The hull under a w.
    pub fn with(&self, h: DVec2) -> Warped<'_> {
        Warped { problem: self, h, corners: self.hull.iter().map(|y| *y / (1.0 + h.dot(*y))).collect() }
    }
    /// The value with its derivatives by h and by the angles of the axes.
    pub fn slopes(&self, shape: &Shape, most: usize) -> (f64, [f64; 4]) {
        let around = self.parallelogram(shape);
        let (h, sides) = (shape.h, around.sides());
        let (blocks, weight) = self.first(most);
        let (sums, slopes) = slopes(blocks, &texel(h, sides, self.texels), &self.cost);
        let per_weight = if weight > 0.0 { weight.recip() } else { 0.0 };
        // A side moves by itself, and h·side with both.
        let by = |moved: [DVec2; 2], with_h: Option<usize>| {
            let texels = self.texels.to_array();
            let side = |k: usize| {
                let by_h = with_h.map_or(0.0, |j| sides[k][j]);
                let [x, y, along] = slopes.by_sides[k];
                (x * moved[k].x + y * moved[k].y + along * (h.dot(moved[k]) + by_h)) / texels[k]
            };
            (side(0) + side(1) + with_h.map_or(0.0, |j| slopes.by_w[j])) * per_weight
        };
        let ([x, y], [s, t]) = (around.by_h(), around.by_angle());
        (self.mean_of(&sums, weight), [by(x, Some(0)), by(y, Some(1)), by(s, None), by(t, None)])
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
