//! Where the centres of columns lie: a texel apart, or any distance.

use super::ascending::Ascending;

/// Places of columns, even texels from the left.
pub trait Places: Sync {
    /// How many there are.
    fn count(&self) -> usize;
    /// The centre of a column; anything for the one after the last.
    fn place(&self, column: usize) -> f64;
    /// The first column whose centre is not left of a place, [`Places::count`] where all are.
    fn first(&self, place: f64) -> u32;
    /// How far to the right of a column's centre that of the `i`-th after it lies; anything for up to
    /// [`BEHIND`](super::ascending::BEHIND) columns after the last.
    fn steps(&self, column: usize) -> impl Fn(u32) -> f64;
}

/// A texel apart.
#[derive(Debug, Clone, Copy)]
pub struct EvenColumns {
    width: f64,
}

impl EvenColumns {
    pub fn new(width: u32) -> Self {
        Self { width: f64::from(width) }
    }
}

impl Places for EvenColumns {
    #[inline(always)]
    fn count(&self) -> usize {
        self.width as usize
    }
    #[inline(always)]
    fn place(&self, column: usize) -> f64 {
        f64::from(column as i32) + 0.5
    }
    #[inline(always)]
    fn first(&self, place: f64) -> u32 {
        let before = place - 0.5;
        let before = if before > 0.0 { before } else { 0.0 };
        let before = if before < self.width { before } else { self.width };
        // SAFETY: between 0 and the width of a map, and no NaN.
        let whole: i32 = unsafe { before.to_int_unchecked() };
        // Rounded up, by what every processor has vectors of.
        (whole + i32::from(f64::from(whole) < before)) as u32
    }
    #[inline(always)]
    fn steps(&self, _column: usize) -> impl Fn(u32) -> f64 {
        |i| f64::from(i as i32)
    }
}

/// Any distance apart.
impl Places for Ascending {
    #[inline(always)]
    fn count(&self) -> usize {
        self.count()
    }
    #[inline(always)]
    fn place(&self, column: usize) -> f64 {
        self.with_infinities()[column]
    }
    #[inline(always)]
    fn first(&self, place: f64) -> u32 {
        self.first(place)
    }
    #[inline(always)]
    fn steps(&self, column: usize) -> impl Fn(u32) -> f64 {
        let places = &self.with_infinities()[column..];
        move |i| places[i as usize] - places[0]
    }
}
