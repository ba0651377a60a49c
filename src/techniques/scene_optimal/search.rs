//! The search: a grid over the four parameters, then descents with the objective's own derivatives from the best of it and
//! from maps that are known.
//!
//! Source: theory.md 10.2 (25 p by 8 pairs of axes, and a local search from the best few find the optimum). The descent is
//! that of Broyden, Fletcher, Goldfarb and Shanno `[nocedal2006]`, whose lines are halved until they descend; where a
//! corner of the hull takes over from another the objective has a crease, on which a descent may stop early: it begins anew
//! from there with a steepest step, as long as that gains.

use glam::{DMat2, DVec2};

use super::problem::{Problem, Shape};

/// Strengths of the grid: w at one end of the hull over that at the other is e to this power.
const STRENGTHS: [f64; 3] = [0.8, 1.8, 3.2];
/// Directions of the grid.
const DIRECTIONS: usize = 8;
/// Turns of orthogonal axes in the grid, and how many of them come sheared as well.
const TURNS: usize = 6;
/// Samples that the grid looks at, the descents, and the last descent with the walk after it.
const FEW: usize = 96;
const SOME: usize = 192;
const MANY: usize = 1024;
/// Points of the grid from which there is a descent.
const DESCENTS: usize = 4;
/// Steps of a descent.
const STEPS: usize = 14;
/// Directions of either axis where the best map's are turned all around: a map has a least cost by turns for every few sides of
/// the hull.
const ALL_TURNS: usize = 24;
/// Values that a walk looks at, and its first step: of p, and of angles.
const LOOKS: usize = 90;
const FIRST_STEP: f64 = 0.08;
/// Descents begin anew while they gain more than this share.
const GAIN: f64 = 1e-4;
const ANEW: usize = 2;

/// Four numbers without bounds, and the box in whose units the axes' angles are told.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// p, and the angles of the two axes.
    z: [f64; 4],
    scale: DVec2,
}

impl Point {
    fn of(shape: &Shape, problem: &Problem) -> Self {
        let scale = problem.box_of(shape.h);
        let angle = |axis: DVec2| (axis / scale).to_angle();
        let p = problem.p_of(shape.h);
        Self { z: [p.x, p.y, angle(shape.axes[0]), angle(shape.axes[1])], scale }
    }
    /// Its shape, and the derivatives of h by p.
    fn shape(&self, problem: &Problem) -> (Shape, DMat2) {
        let [x, y, a, b] = self.z;
        let (h, by_p) = problem.h_of(DVec2::new(x, y));
        (Shape { h, axes: [a, b].map(|angle| axis(self.scale, angle)) }, by_p)
    }
    /// The value and its derivatives by the four numbers.
    fn slopes(&self, problem: &Problem, most: usize) -> (f64, [f64; 4]) {
        let (shape, by_p) = self.shape(problem);
        let (value, [h_x, h_y, s, t]) = problem.slopes(&shape, most);
        let by_p = by_p.transpose() * DVec2::new(h_x, h_y);
        let turned = |angle: f64| {
            let along = DVec2::from_angle(angle);
            self.scale.x * self.scale.y / (self.scale * along).length_squared()
        };
        (value, [by_p.x, by_p.y, s * turned(self.z[2]), t * turned(self.z[3])])
    }
}

/// The direction of an axis at an angle, told in the units of a box.
fn axis(scale: DVec2, angle: f64) -> DVec2 {
    (scale * DVec2::from_angle(angle)).normalize_or(DVec2::X)
}

/// The shape of least cost that is found, and its cost: never more than that of any of `starts`.
pub fn least(problem: &Problem, starts: &[Shape]) -> Option<(Shape, f64)> {
    let mut grid: Vec<(f64, Shape)> = Vec::new();
    for i in 0..=STRENGTHS.len() * DIRECTIONS {
        let p = match i {
            0 => DVec2::ZERO,
            i => {
                DVec2::from_angle(std::f64::consts::TAU * (i % DIRECTIONS) as f64 / DIRECTIONS as f64)
                    * STRENGTHS[(i - 1) / DIRECTIONS]
            }
        };
        let (h, _) = problem.h_of(p);
        let (scale, warped) = (problem.box_of(h), problem.with(h));
        let axes = pairs().map(|angles| angles.map(|angle| axis(scale, angle)));
        let valued = axes.map(|axes| (warped.value(axes, FEW), Shape { h, axes }));
        grid.extend(valued.min_by(|a, b| a.0.total_cmp(&b.0)));
    }
    grid.sort_by(|a, b| a.0.total_cmp(&b.0));
    let from_grid = grid.iter().take(DESCENTS).map(|(_, shape)| *shape);
    let mut known: Vec<(f64, Shape)> = starts.iter().map(|shape| (problem.value(shape, usize::MAX), *shape)).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let begun = from_grid.chain(known.iter().take(2).map(|(_, shape)| *shape));
    let by_cost = |a: &(f64, Shape), b: &(f64, Shape)| a.0.total_cmp(&b.0);
    let rough = begun.map(|shape| descended(problem, &shape, SOME)).min_by(by_cost);
    let closer = rough.map(|rough| {
        let turned = descended(problem, &turned(problem, &rough.1), SOME);
        let (_, shape) = if turned.0 < rough.0 { turned } else { rough };
        let (_, shape) = descended(problem, &shape, MANY);
        let shape = polished(problem, &shape, |shape| problem.value(shape, MANY));
        (problem.value(&shape, usize::MAX), shape)
    });
    let found = known.into_iter().chain(closer).filter(|(value, _)| value.is_finite());
    found.min_by(by_cost).map(|(value, shape)| (shape, value))
}

/// Angles of pairs of axes: orthogonal ones at several turns, and sheared ones.
fn pairs() -> impl Iterator<Item = [f64; 2]> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let turn = move |i: usize| quarter * i as f64 / TURNS as f64;
    let orthogonal = (0..TURNS).map(move |i| [turn(i), turn(i) + quarter]);
    orthogonal.chain((0..TURNS).map(move |i| [turn(i), turn(i) + quarter * if i % 2 == 0 { 0.6 } else { 1.4 }]))
}

/// The best axes for the same w, of all directions that are no closer than an eighth of a half turn.
fn turned(problem: &Problem, of: &Shape) -> Shape {
    let scale = problem.box_of(of.h);
    let axis = |i: usize| axis(scale, std::f64::consts::PI * i as f64 / ALL_TURNS as f64);
    let apart = ALL_TURNS / 8;
    let pairs = (0..ALL_TURNS).flat_map(|i| (i + apart..=i + ALL_TURNS - apart).map(move |j| (i, j)));
    let warped = problem.with(of.h);
    let valued =
        pairs.map(|(i, j)| (warped.value([axis(i), axis(j)], FEW), Shape { h: of.h, axes: [axis(i), axis(j)] }));
    valued.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(*of, |(_, shape)| shape)
}

/// Descents from a shape, each from where the one before ended, while they gain.
fn descended(problem: &Problem, from: &Shape, most: usize) -> (f64, Shape) {
    let mut best = (problem.value(from, most), *from);
    for _ in 0..ANEW {
        let found = descent(problem, Point::of(&best.1, problem), most);
        let gains = found.0 < best.0 * (1.0 - GAIN);
        if found.0 < best.0 {
            best = found;
        }
        if !gains {
            break;
        }
    }
    best
}

/// One descent.
fn descent(problem: &Problem, mut at: Point, most: usize) -> (f64, Shape) {
    let (mut value, mut slope) = at.slopes(problem, most);
    // The inverse of the curvatures, told as a matrix.
    let mut inverse = identity(0.1 / norm(&slope).max(f64::MIN_POSITIVE));
    for _ in 0..STEPS {
        let mut step = [0.0; 4];
        for (i, step) in step.iter_mut().enumerate() {
            *step = -(0..4).map(|j| inverse[i][j] * slope[j]).sum::<f64>();
        }
        let mut along = dot(&step, &slope);
        if !(along < 0.0) {
            inverse = identity(0.1 / norm(&slope).max(f64::MIN_POSITIVE));
            step = slope.map(|s| -inverse[0][0] * s);
            along = dot(&step, &slope);
        }
        // No further than a turn of half a radian or twice the strength.
        let longest = step.iter().fold(0.0f64, |l, s| l.max(s.abs()));
        let mut length = (0.7 / longest).min(1.0);
        let next = loop {
            let moved = Point { z: std::array::from_fn(|i| at.z[i] + length * step[i]), ..at };
            let (found, slopes) = moved.slopes(problem, most);
            if found <= value + 1e-4 * length * along {
                break Some((moved, found, slopes));
            }
            length *= 0.4;
            if length < 1e-6 {
                break None;
            }
        };
        let Some((moved, found, slopes)) = next else { break };
        let (s, y): ([f64; 4], [f64; 4]) =
            (std::array::from_fn(|i| moved.z[i] - at.z[i]), std::array::from_fn(|i| slopes[i] - slope[i]));
        let gained = value - found;
        (at, value, slope) = (moved, found, slopes);
        let sy = dot(&s, &y);
        if sy > 1e-12 * norm(&s) * norm(&y) {
            inverse = updated(&inverse, &s, &y, sy);
        }
        if gained < 1e-7 * value {
            break;
        }
    }
    (value, at.shape(problem).0)
}

/// The method of Nelder and Mead `[nelder1965]`, which creases do not stop and which needs no derivatives, from a shape.
pub(super) fn polished(problem: &Problem, from: &Shape, value_of: impl Fn(&Shape) -> f64) -> Shape {
    let start = Point::of(from, problem);
    let value = |z: &[f64; 4]| {
        let found = value_of(&Point { z: *z, ..start }.shape(problem).0);
        if found.is_nan() { f64::INFINITY } else { found }
    };
    let mut corners: Vec<([f64; 4], f64)> = (0..5)
        .map(|i| {
            let mut z = start.z;
            if i > 0 {
                z[i - 1] += FIRST_STEP;
            }
            (z, value(&z))
        })
        .collect();
    let between =
        |a: &[f64; 4], b: &[f64; 4], t: f64| -> [f64; 4] { std::array::from_fn(|i| a[i] + t * (b[i] - a[i])) };
    let mut looks = corners.len();
    while looks < LOOKS {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        if corners[4].1 - corners[0].1 <= 1e-7 * corners[0].1 {
            break;
        }
        let middle: [f64; 4] = std::array::from_fn(|i| corners[..4].iter().map(|c| c.0[i]).sum::<f64>() / 4.0);
        let worst = corners[4].0;
        let look = |t: f64| {
            let z = between(&middle, &worst, t);
            (z, value(&z))
        };
        let reflected = look(-1.0);
        looks += 1;
        let next = if reflected.1 < corners[0].1 {
            looks += 1;
            let expanded = look(-2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < corners[3].1 {
            reflected
        } else {
            looks += 1;
            look(if reflected.1 < corners[4].1 { -0.5 } else { 0.5 })
        };
        if next.1 < corners[4].1 {
            corners[4] = next;
            continue;
        }
        let best = corners[0].0;
        for corner in &mut corners[1..] {
            corner.0 = between(&best, &corner.0, 0.5);
            corner.1 = value(&corner.0);
        }
        looks += 4;
    }
    let best = corners.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(start.z, |c| c.0);
    Point { z: best, ..start }.shape(problem).0
}

fn identity(scale: f64) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { scale } else { 0.0 }))
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64; 4]) -> f64 {
    dot(a, a).sqrt()
}

/// (I - s yᵀ/sy) B (I - y sᵀ/sy) + s sᵀ/sy.
fn updated(b: &[[f64; 4]; 4], s: &[f64; 4], y: &[f64; 4], sy: f64) -> [[f64; 4]; 4] {
    let by: [f64; 4] = std::array::from_fn(|i| dot(&b[i], y));
    let yby = dot(&by, y);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| b[i][j] - (s[i] * by[j] + by[i] * s[j]) / sy + s[i] * s[j] * (1.0 + yby / sy) / sy)
    })
}
