//! Many rays in bundles of neighbours: those of an image, which mostly come row by row, in squares of pixels.
//!
//! Rays of a square part later than those of a piece of a row, so they enter fewer boxes. Which rays travel together
//! changes no answer.

use super::rays::BUNDLE;

/// Sides of a bundle's square: four runs of rays that follow each other.
pub const RUN: usize = 4;
const _: () = assert!(RUN * RUN == BUNDLE);
/// Lengths of the step from ray to ray that a longer step is taken for the way to the next row.
const JUMP: f64 = 8.0;
/// The longest row that is looked for.
const LONGEST: usize = 1 << 14;

/// Four runs of rays: the first begins at `first`, and each of the others `step` behind the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Runs {
    pub first: usize,
    step: usize,
}

impl Runs {
    /// Sixteen rays in a row.
    pub fn in_a_row(first: usize) -> Self {
        Self { first, step: RUN }
    }
    /// Where a ray of the bundle is.
    #[inline(always)]
    pub fn index(&self, ray: usize) -> usize {
        self.first + ray / RUN * self.step + ray % RUN
    }
}

/// The length of the rows that rays come in, a multiple of [`RUN`], as far as the first two rows tell; none where they do not.
pub fn row_of(origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Option<usize> {
    let apart = |a: usize, b: usize| {
        let of = |v: &[[f64; 3]]| (0..3).map(|k| (v[a][k] - v[b][k]).powi(2)).sum::<f64>();
        of(origins) + of(directions)
    };
    let count = origins.len();
    if count < 2 {
        return None;
    }
    let longest = JUMP * JUMP * apart(0, 1);
    let row = (1..count.min(LONGEST + 1)).find(|&i| !(apart(i - 1, i) <= longest))?;
    let is_row =
        row % RUN == 0 && RUN * row <= count && apart(0, row) <= longest && !(apart(2 * row - 1, 2 * row) <= longest);
    is_row.then_some(row)
}

/// The bundles of so many rays: squares where they come in rows, as far as there are whole ones.
pub fn bundles(count: usize, row: Option<usize>) -> impl Iterator<Item = Runs> {
    let row = row.unwrap_or(count.max(1));
    let squares_until = count / (RUN * row) * RUN * row;
    let tops = (0..squares_until).step_by(RUN * row);
    let squares = tops.flat_map(move |top| (top..top + row).step_by(RUN).map(move |first| Runs { first, step: row }));
    squares.chain((squares_until..count).step_by(BUNDLE).map(Runs::in_a_row))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
        let direction = |i: usize| [(i % width) as f64 * 1e-3 - 0.2, 0.1 - (i / width) as f64 * 1e-3, -1.0];
        (vec![[1.0, 2.0, 3.0]; width * height], (0..width * height).map(direction).collect())
    }

    #[test]
    fn rows_of_an_image_are_found() {
        let row = |(origins, directions): (Vec<[f64; 3]>, Vec<[f64; 3]>)| row_of(&origins, &directions);
        assert_eq!(row(image(64, 48)), Some(64));
        assert_eq!(row(image(64, 4)), Some(64));
        // Too few rows, no whole squares, no row that ends.
        assert_eq!(row(image(64, 3)), None);
        assert_eq!(row(image(65, 48)), None);
        assert_eq!(row(image(500, 1)), None);
        // Parallel rays from a grid of points.
        let (origins, directions) = image(32, 8);
        assert_eq!(row_of(&directions, &origins), Some(32));
        // Rays that have no order, and rays that are no numbers.
        let mixed: Vec<[f64; 3]> = (0..400).map(|i| [f64::from(i * 7919 % 400), 1.0, 0.0]).collect();
        assert_eq!(row_of(&vec![[0.0; 3]; 400], &mixed), None);
        assert_eq!(row_of(&[[f64::NAN; 3]; 40], &[[f64::INFINITY; 3]; 40]), None);
        assert_eq!(row_of(&[], &[]), None);
    }

    #[test]
    fn every_ray_is_in_one_bundle() {
        for (count, row) in
            [(64 * 8, Some(64)), (64 * 7 + 5, Some(64)), (100, None), (3, None), (0, None), (64, Some(4))]
        {
            let mut times = vec![0; count];
            for runs in bundles(count, row) {
                (0..BUNDLE).map(|r| runs.index(r)).filter(|&i| i < count).for_each(|i| times[i] += 1);
            }
            assert!(times.iter().all(|&n| n == 1), "{count} {row:?}: {times:?}");
        }
        assert_eq!(bundles(64 * 8, Some(64)).next().map(|runs| runs.index(5)), Some(65));
    }
}
