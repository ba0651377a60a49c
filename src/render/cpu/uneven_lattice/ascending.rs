//! Ascending numbers, and where among them others belong: by a table of cells, of which each holds few of them, instead of a search.

use std::ops::Deref;

/// Infinities after the last number: kernels read whole vectors.
pub const BEHIND: usize = 8;
/// Cells for each number.
const CELLS: usize = 2;
/// Numbers of a cell that are looked at one by one; those of a fuller one are searched.
const FEW: usize = 4;

/// The cell that a number falls into; it never falls as numbers rise.
#[derive(Debug, Clone, Copy)]
enum Cells {
    /// Of one width.
    Even { first: f64, per: f64 },
    /// Of one share of a power of two: steps of the upper bits of a float are nearly those of its logarithm.
    Logarithmic { first: i32, shift: u32 },
}

/// Ascending numbers, at least one.
#[derive(Debug)]
pub struct Ascending {
    /// With [`BEHIND`] infinities.
    values: Vec<f64>,
    cells: Cells,
    /// The last cell.
    last: u32,
    /// For each cell how many numbers come before it, and how many there are.
    begins: Vec<u32>,
}

impl Ascending {
    /// Numbers about as far from each other everywhere.
    pub fn even(values: Vec<f64>) -> Self {
        let (cells, first) = (CELLS * values.len(), values[0]);
        let per = cells as f64 / (values[values.len() - 1] - first);
        Self::new(values, Cells::Even { first, per }, cells as u32 - 1)
    }
    /// Numbers of one sign, whose logarithms are about as far from each other everywhere.
    pub fn logarithmic(values: Vec<f64>) -> Self {
        let (first, last) = (upper_bits(values[0]), upper_bits(values[values.len() - 1]));
        let span = last.abs_diff(first);
        let most = (2 * CELLS * values.len()) as u32;
        let shift = (0..32).find(|shift| span >> shift < most).expect("a span of 32 bits");
        Self::new(values, Cells::Logarithmic { first, shift }, span >> shift)
    }

    fn new(mut values: Vec<f64>, cells: Cells, last: u32) -> Self {
        let mut begins = vec![0; last as usize + 2];
        for value in &values {
            begins[cells.of(*value, last) as usize + 1] += 1;
        }
        for cell in 1..begins.len() {
            begins[cell] += begins[cell - 1];
        }
        values.extend([f64::INFINITY; BEHIND]);
        Self { values, cells, last, begins }
    }

    /// How many there are, the infinities not counted.
    pub fn count(&self) -> usize {
        self.values.len() - BEHIND
    }
    /// With [`BEHIND`] infinities.
    #[inline(always)]
    pub fn with_infinities(&self) -> &[f64] {
        &self.values
    }
    /// The place of the first that is not less than a number, [`Ascending::count`] where all are.
    #[inline(always)]
    pub fn first(&self, x: f64) -> u32 {
        let cell = self.cells.of(x, self.last) as usize;
        let (low, high) = (self.begins[cell], self.begins[cell + 1]);
        if (high - low) as usize > FEW {
            let (low, high) = (low as usize, high as usize);
            return (low + self.values[low..high].partition_point(|value| *value < x)) as u32;
        }
        // What comes after the cell is not less.
        let mut at = low;
        for _ in 0..FEW {
            at += u32::from(self.values[at as usize] < x);
        }
        at
    }
}

impl Deref for Ascending {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.count()]
    }
}

impl Cells {
    /// That of a number, the first or the last one for what lies beyond.
    #[inline(always)]
    fn of(self, x: f64, last: u32) -> u32 {
        match self {
            // Casts saturate, and NaN is 0.
            Self::Even { first, per } => (((x - first) * per) as u32).min(last),
            Self::Logarithmic { first, shift } => {
                let steps = i64::from(upper_bits(x)) - i64::from(first);
                (steps.max(0) as u32 >> shift).min(last)
            }
        }
    }
}

/// The upper half of a float's bits as a number that never falls as floats rise.
#[inline(always)]
fn upper_bits(x: f64) -> i32 {
    let upper = (x.to_bits() >> 32) as i32;
    upper ^ (upper >> 31) & i32::MAX
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_belong_where_a_search_finds_them() {
        let logarithmic = |count: u32, ratio: f64, sign: f64| -> Vec<f64> {
            (0..count).map(|i| sign * (sign * ratio.ln() * f64::from(i) / f64::from(count)).exp()).collect()
        };
        let mut bent: Vec<f64> = (0..500).map(|i| (f64::from(i) * 0.02).powi(5)).collect();
        bent.extend([1e5; 20]);
        let all = [
            Ascending::even((0..700).map(|i| 0.3 * f64::from(i) - 50.0).collect()),
            Ascending::even(vec![0.5]),
            Ascending::even(bent.clone()),
            Ascending::logarithmic(vec![-3.0]),
            Ascending::logarithmic(logarithmic(1000, 9.0, 1.0)),
            Ascending::logarithmic(logarithmic(4096, 1e250, 1.0)),
            Ascending::logarithmic(logarithmic(77, 1e6, -1.0)),
            Ascending::logarithmic(bent[1..].to_vec()),
        ];
        for (case, found) in all.iter().enumerate() {
            assert!(found.is_sorted());
            let near = found.iter().flat_map(|x| [x.next_down(), *x, x.next_up(), 0.7 * x, 1.01 * x]);
            let far = [f64::NEG_INFINITY, -1e300, -1.0, -0.0, 0.0, 1e-300, 1.0, 1e300, f64::INFINITY];
            for x in near.chain(far) {
                assert_eq!(found.first(x) as usize, found.partition_point(|value| *value < x), "case {case}, {x}");
            }
            assert!(found.first(f64::NAN) as usize <= found.count());
        }
    }
}
