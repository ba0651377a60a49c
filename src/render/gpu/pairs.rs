//! Numbers as two of single precision, for shaders that have double precision: a number and what rounding leaves of it.
//!
//! Together they keep 48 bits. A shader without double precision sums them to the first.

/// The numbers in single precision, and their rests.
pub(super) fn pairs<const N: usize>(numbers: [f64; N]) -> [[f32; N]; 2] {
    let high = numbers.map(|x| x as f32);
    // An infinity has no rest.
    let rest = |k: usize| if high[k].is_finite() { (numbers[k] - f64::from(high[k])) as f32 } else { 0.0 };
    [high, std::array::from_fn(rest)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_keep_48_bits() {
        let numbers = [1.0 / 3.0, -1e10 / 7.0, 2.5, 0.0, 1e300, std::f64::consts::PI * 1e-20];
        let [high, low] = pairs(numbers);
        for (k, x) in numbers.into_iter().enumerate().filter(|(_, x)| x.abs() < 1e38) {
            let error = (f64::from(high[k]) + f64::from(low[k]) - x).abs();
            assert!(error <= x.abs() * 2f64.powi(-48), "{x}: {error}");
            assert_eq!(high[k] + low[k], high[k], "{x}");
        }
        assert_eq!((high[4], low[4]), (f32::INFINITY, 0.0));
    }
}
