//! What a search over homographies makes small: sums over samples of what one texel is in the picture.
//!
//! Source: theory.md (10.4), (10.7) and (10.8); Chong, Gortler 2007 `[chong2007]` for l2.

use glam::{DMat2, DVec2};

use crate::geometry::singular_values;
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

impl Cost {
    /// What a sample counts, and its derivative by the entries of G.
    #[inline]
    pub fn of(&self, g: &DMat2) -> (f64, DMat2) {
        match self.objective {
            Objective::Edge => {
                let (a, b) = (g.x_axis.x, g.y_axis.x);
                let (value, slope) = self.capped(a.abs() + b.abs());
                (value, DMat2::from_cols_array(&[slope * a.signum(), 0.0, slope * b.signum(), 0.0]))
            }
            Objective::L1 => {
                let (largest, _) = singular_values(g);
                let (value, slope) = self.capped(largest);
                (value, longest_direction(g, largest) * slope)
            }
            Objective::L2 => (g.x_axis.length_squared() + g.y_axis.length_squared(), *g * 2.0),
            Objective::Area => {
                let area = g.determinant();
                let cofactors = DMat2::from_cols_array(&[g.y_axis.y, -g.y_axis.x, -g.x_axis.y, g.x_axis.x]);
                (area.abs(), cofactors * area.signum())
            }
        }
    }
    #[inline]
    fn capped(&self, length: f64) -> (f64, f64) {
        if self.cap == f64::INFINITY { (length, 1.0) } else { capped(length, self.cap) }
    }
    /// What a sample counts that no texel of the map shows.
    pub fn worst(&self) -> f64 {
        if matches!(self.objective, Objective::Edge | Objective::L1) { self.cap } else { f64::INFINITY }
    }
}

/// The derivative of the largest singular value: the product of its two unit vectors.
fn longest_direction(g: &DMat2, largest: f64) -> DMat2 {
    // Of GᵀG the row that is not zero has the direction.
    let square = g.transpose() * *g;
    let rest = largest * largest;
    let a = DVec2::new(square.y_axis.x, rest - square.x_axis.x);
    let b = DVec2::new(rest - square.y_axis.y, square.y_axis.x);
    let right = if a.length_squared() > b.length_squared() { a } else { b }.normalize_or(DVec2::X);
    let left = (*g * right).normalize_or(DVec2::X);
    DMat2::from_cols(left * right.x, left * right.y)
}
