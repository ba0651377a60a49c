//! What a search over homographies makes small: sums over samples of what one texel is in the picture.
//!
//! Source: theory.md (10.4), (10.7) and (10.8); Chong, Gortler 2007 `[chong2007]` for l2.

use glam::DMat2;

use crate::simd::exp_of_minus;
use crate::techniques::kit::capped;

/// A sum over samples, of G = d(pixel) / d(texel) of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Objective {
    /// The width of a texel across the shadow's edge; the first row of G is across the edge.
    Edge,
    /// The longest extent of a texel.
    L1,
    /// The squares of both sides of a texel.
    L2,
    /// The area of a texel.
    Area,
}

/// An objective, and the length at which one sample stops to count, pixels (10.8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// What is summed.
    pub objective: Objective,
    /// Infinite for none; areas and squares have none.
    pub cap: f64,
}

/// G of a sample, row by row: of a texel's two sides what each is in a row.
pub(super) type Texel = [[f64; 2]; 2];

/// What a sample counts, without branches, so that loops over samples become vector instructions.
pub(super) trait Measure: Copy {
    /// Rows of G that it looks at.
    const ROWS: usize;
    /// The value, and its derivative by the entries of G.
    fn of(&self, g: Texel) -> (f64, Texel);
}

/// What lengths count: no more than a cap, or as they are.
pub(super) trait Limit: Copy {
    /// The value and its derivative.
    fn of(&self, length: f64) -> (f64, f64);
}

/// Up to a cap, in pixels (10.8).
#[derive(Debug, Clone, Copy)]
pub(super) struct Capped(pub f64);

/// As they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Free;

/// [`Objective::Edge`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Widths<L>(pub L);

/// [`Objective::L1`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Longest<L>(pub L);

/// [`Objective::L2`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Squares;

/// [`Objective::Area`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Areas;

impl Limit for Capped {
    #[inline(always)]
    fn of(&self, length: f64) -> (f64, f64) {
        let left = exp_of_minus(length / self.0);
        (self.0 * (1.0 - left), left)
    }
}

impl Limit for Free {
    #[inline(always)]
    fn of(&self, length: f64) -> (f64, f64) {
        (length, 1.0)
    }
}

impl<L: Limit> Measure for Widths<L> {
    const ROWS: usize = 1;
    #[inline(always)]
    fn of(&self, [[a, b], _]: Texel) -> (f64, Texel) {
        let (value, slope) = self.0.of(a.abs() + b.abs());
        (value, [[slope.copysign(a), slope.copysign(b)], [0.0; 2]])
    }
}

impl<L: Limit> Measure for Longest<L> {
    const ROWS: usize = 2;
    #[inline(always)]
    fn of(&self, [[a, b], [c, d]]: Texel) -> (f64, Texel) {
        // A matrix is a turn with a length plus a mirrored one: the largest singular value is the sum of both lengths by half.
        let length = |x: f64, y: f64| (x * x + y * y).sqrt();
        let (turned, mirrored) = (length(a + d, b - c), length(a - d, b + c));
        let (value, slope) = self.0.of(0.5 * (turned + mirrored));
        // A length of 0 has no direction.
        let (p, q) = (0.5 * slope / turned.max(f64::MIN_POSITIVE), 0.5 * slope / mirrored.max(f64::MIN_POSITIVE));
        let (along, across) = ([p * (a + d), p * (b - c)], [q * (a - d), q * (b + c)]);
        (value, [[along[0] + across[0], along[1] + across[1]], [across[1] - along[1], along[0] - across[0]]])
    }
}

impl Measure for Squares {
    const ROWS: usize = 2;
    #[inline(always)]
    fn of(&self, [[a, b], [c, d]]: Texel) -> (f64, Texel) {
        (a * a + b * b + c * c + d * d, [[2.0 * a, 2.0 * b], [2.0 * c, 2.0 * d]])
    }
}

impl Measure for Areas {
    const ROWS: usize = 2;
    #[inline(always)]
    fn of(&self, [[a, b], [c, d]]: Texel) -> (f64, Texel) {
        let area = a * d - b * c;
        let sign = 1f64.copysign(area);
        (area.abs(), [[sign * d, -sign * c], [-sign * b, sign * a]])
    }
}

impl Cost {
    /// What a sample counts.
    pub fn of(&self, g: &DMat2) -> f64 {
        let g = [g.row(0).to_array(), g.row(1).to_array()];
        match (self.objective, self.cap.is_finite()) {
            (Objective::Edge, true) => capped(g[0][0].abs() + g[0][1].abs(), self.cap),
            (Objective::Edge, false) => Widths(Free).of(g).0,
            (Objective::L1, true) => capped(Longest(Free).of(g).0, self.cap),
            (Objective::L1, false) => Longest(Free).of(g).0,
            (Objective::L2, _) => Squares.of(g).0,
            (Objective::Area, _) => Areas.of(g).0,
        }
    }
    /// What a sample counts that no texel of the map shows.
    pub fn worst(&self) -> f64 {
        if matches!(self.objective, Objective::Edge | Objective::L1) { self.cap } else { f64::INFINITY }
    }
}
