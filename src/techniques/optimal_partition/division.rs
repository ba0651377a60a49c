//! Where to divide a row of intervals: dynamic programming over what each run of them costs.
//!
//! Source: Bellman 1957 `[bellman1957]`. With c(i, j) the cost of the intervals i to j - 1 as one run, the least cost of the first
//! j intervals in k runs is
//!
//! ```text
//! least(k, j) = min over i of least(k - 1, i) + c(i, j)
//! ```

/// The division of so many intervals into `count` runs, at least one and no more than there are intervals, with the least sum
/// of `cost(first, end)`: the end of each run, and the sum.
pub fn least_division(intervals: usize, count: usize, cost: impl Fn(usize, usize) -> f64) -> (Vec<usize>, f64) {
    let count = count.clamp(1, intervals.max(1));
    // least[j] of so many runs as have been taken so far, and for each number of runs where the last begins.
    let mut least: Vec<f64> = (0..=intervals).map(|j| if j == 0 { f64::INFINITY } else { cost(0, j) }).collect();
    let mut begins = vec![vec![0; intervals + 1]];
    for runs in 2..=count {
        let mut next = vec![f64::INFINITY; intervals + 1];
        let mut begin = vec![0; intervals + 1];
        for j in runs..=intervals {
            for i in runs - 1..j {
                let sum = least[i] + cost(i, j);
                if sum < next[j] || i == runs - 1 {
                    (next[j], begin[j]) = (sum, i);
                }
            }
        }
        least = next;
        begins.push(begin);
    }
    let mut ends = vec![intervals];
    for begin in begins.iter().skip(1).rev() {
        ends.push(begin[ends[ends.len() - 1]]);
    }
    ends.reverse();
    (ends, least[intervals])
}
