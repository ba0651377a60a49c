//! Functions of one number that are continuous, ascending and linear between knots.

use crate::error::{Error, Result};

/// An ascending function, linear between knots and beyond the outer ones as next to them, so that every number has one value
/// and is the value of one number.
#[derive(Debug, Clone, PartialEq)]
pub struct PiecewiseLinear {
    /// Knots: arguments, and values; both ascend.
    before: Box<[f64]>,
    after: Box<[f64]>,
    /// Of each piece between two knots.
    slopes: Box<[f64]>,
}

impl PiecewiseLinear {
    /// The function through knots (argument, value).
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for fewer than two knots, numbers that are not finite, arguments or values that do not
    /// ascend, and pieces so steep or so flat that their slope is no normal number.
    pub fn new(knots: &[[f64; 2]]) -> Result<Self> {
        let before: Box<[f64]> = knots.iter().map(|knot| knot[0]).collect();
        let after: Box<[f64]> = knots.iter().map(|knot| knot[1]).collect();
        let slopes: Box<[f64]> = knots.windows(2).map(|k| (k[1][1] - k[0][1]) / (k[1][0] - k[0][0])).collect();
        // Written so that a NaN is refused.
        let ascends = knots.windows(2).all(|k| k[0][0] < k[1][0] && k[0][1] < k[1][1]);
        let usable = slopes.iter().all(|slope| slope.is_normal() && slope.recip().is_normal());
        if knots.len() < 2 || !ascends || !usable || !knots.as_flattened().iter().all(|x| x.is_finite()) {
            let expected = "at least two pairs of finite numbers, both of which ascend from pair to pair";
            let shown: Vec<String> = knots.iter().take(4).map(|[x, y]| format!("({x}, {y})")).collect();
            let more = if knots.len() > 4 { format!(" and {} more", knots.len() - 4) } else { String::new() };
            let got = if knots.is_empty() { "none".to_string() } else { shown.join(", ") + &more };
            return Err(Error::argument("knots", expected, got, "give (before, after) of each knot in order"));
        }
        Ok(Self { before, after, slopes })
    }
    /// The knots, (argument, value) each.
    pub fn knots(&self) -> impl ExactSizeIterator<Item = [f64; 2]> + '_ {
        self.before.iter().zip(&self.after).map(|(x, y)| [*x, *y])
    }
    /// The value at an argument; NaN of NaN.
    pub fn after(&self, x: f64) -> f64 {
        let k = piece(&self.before, x);
        self.after[k] + (x - self.before[k]) * self.slopes[k]
    }
    /// The argument that has a value; NaN of NaN.
    pub fn before(&self, y: f64) -> f64 {
        let k = piece(&self.after, y);
        self.before[k] + (y - self.after[k]) / self.slopes[k]
    }
    /// The slope at an argument; at a knot that of the piece after it.
    pub fn slope(&self, x: f64) -> f64 {
        self.slopes[piece(&self.before, x)]
    }
}

/// The piece in which a number lies, the first or last one beyond the ends.
fn piece(knots: &[f64], x: f64) -> usize {
    let inner = &knots[1..knots.len() - 1];
    inner.partition_point(|knot| *knot <= x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [[f64; 2]; 4] = [[-1.0, -1.0], [-0.5, 0.5], [0.75, 0.75], [1.0, 1.0]];

    #[test]
    fn knots_are_met_and_pieces_are_straight() {
        let f = PiecewiseLinear::new(&KNOTS).unwrap();
        assert!(f.knots().eq(KNOTS));
        for [x, y] in KNOTS {
            assert_eq!((f.after(x), f.before(y)), (y, x));
        }
        assert_eq!((f.after(-0.75), f.slope(-0.75)), (-0.25, 3.0));
        assert_eq!((f.slope(-0.5), f.slope(-9.0), f.slope(9.0)), (0.2, 3.0, 1.0));
        assert_eq!((f.after(-2.0), f.after(3.0), f.before(3.0)), (-4.0, 3.0, 3.0), "straight on beyond the ends");
        assert!(f.after(f64::NAN).is_nan() && f.before(f64::NAN).is_nan());
    }

    #[test]
    fn there_and_back_is_where_it_began() {
        let f = PiecewiseLinear::new(&KNOTS).unwrap();
        let mut last = f64::NEG_INFINITY;
        for i in -300..=300 {
            let x = f64::from(i) / 200.0;
            let y = f.after(x);
            assert!(y > last, "{x}: {y} after {last}");
            // Two roundings each way of numbers below 4, divided by the least slope.
            assert!((f.before(y) - x).abs() <= 16.0 * f64::EPSILON / 0.2, "{x}: {y}");
            last = y;
        }
    }

    #[test]
    fn what_does_not_ascend_is_refused() {
        let bad: [&[[f64; 2]]; 7] = [
            &[],
            &[[0.0, 0.0]],
            &[[0.0, 0.0], [0.0, 1.0]],
            &[[0.0, 0.0], [1.0, 0.0]],
            &[[0.0, 0.0], [f64::NAN, 1.0]],
            &[[0.0, 0.0], [1.0, f64::INFINITY]],
            &[[0.0, 0.0], [1e-200, 1e200]],
        ];
        for knots in bad {
            let error = PiecewiseLinear::new(knots).unwrap_err();
            assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "knots"), "{knots:?}: {error}");
        }
    }
}
