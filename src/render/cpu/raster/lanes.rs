//! The vector operations of the kernels, spelled out: left to itself the compiler turns the fill loops into scalar code or into
//! masked stores, from which later loads of the same pixels cannot be forwarded (measured: three times the instructions), and
//! keeps what triangle setup works on in memory.
//!
//! Two implementations with the same results: AVX2, and arrays for every other processor. Kernels write their loops out: what
//! `array::map` calls is no part of its caller and so may know no AVX2.

use std::mem::MaybeUninit;

use super::simd::LANES;

/// Depth of the far plane where triangles are numbered; less than what is there.
pub const FAR_OF_IDS: f32 = 0.0;

/// [`LANES`] 32-bit numbers side by side.
pub trait Lanes: Copy {
    type Int: Copy;
    type Float: Copy;
    /// These numbers.
    fn ints(self, x: [i32; LANES]) -> Self::Int;
    /// The bits of these numbers.
    fn unsigned(self, x: &[u32; LANES]) -> Self::Int;
    /// These numbers.
    fn floats(self, x: [f32; LANES]) -> Self::Float;
    /// One number in all lanes.
    fn int(self, x: i32) -> Self::Int;
    /// One number in all lanes.
    fn float(self, x: f32) -> Self::Float;
    /// The numbers, one after the other.
    fn to_ints(self, x: Self::Int) -> [i32; LANES];
    /// The numbers, one after the other.
    fn to_floats(self, x: Self::Float) -> [f32; LANES];
    /// The bits of floats.
    fn bits_of(self, x: Self::Float) -> Self::Int;
    /// The nearest floats.
    fn rounded(self, x: Self::Int) -> Self::Float;
    /// Coordinates of vertices without `CLIP` rounded to whole numbers, halves to even.
    fn snapped(self, x: Self::Float) -> Self::Int;
    /// Sums, wrapping.
    fn add(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Differences, wrapping.
    fn sub(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Products, wrapping.
    fn mul(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Bitwise and.
    fn and(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Bitwise or.
    fn or(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Bitwise exclusive or.
    fn xor(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// Divided by a power of two, rounded down.
    fn shifted(self, x: Self::Int, by: u32) -> Self::Int;
    /// The smaller numbers.
    fn least(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// The larger numbers.
    fn most(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// All ones where a is less than b, else 0.
    fn less(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// All ones where both are equal, else 0.
    fn equal(self, a: Self::Int, b: Self::Int) -> Self::Int;
    /// The smallest of the numbers.
    #[inline(always)]
    fn least_of(self, x: Self::Int) -> i32 {
        let x = self.to_ints(x);
        let mut least = x[0];
        for l in 1..LANES {
            least = least.min(x[l]);
        }
        least
    }
    /// The largest of the numbers.
    #[inline(always)]
    fn most_of(self, x: Self::Int) -> i32 {
        let x = self.to_ints(x);
        let mut most = x[0];
        for l in 1..LANES {
            most = most.max(x[l]);
        }
        most
    }
    /// Bit l says whether lane l is negative.
    fn signs(self, x: Self::Int) -> u32;
    /// Sums.
    fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// Differences.
    fn sub_floats(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// Products.
    fn mul_floats(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// a b + c, rounded once.
    fn fused(self, a: Self::Float, b: Self::Float, c: Self::Float) -> Self::Float;
    /// Quotients.
    fn div_floats(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// The smaller of numbers that are no NaN.
    fn smaller(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// The larger of numbers that are no NaN.
    fn larger(self, a: Self::Float, b: Self::Float) -> Self::Float;
    /// All ones where a is at most b, else 0.
    fn at_most(self, a: Self::Float, b: Self::Float) -> Self::Int;
    /// a where the mask is negative, else b.
    fn pick(self, mask: Self::Int, a: Self::Float, b: Self::Float) -> Self::Float;
    /// The order in which the lanes of some bits come first, in ascending order.
    fn order(self, bits: u32) -> Self::Int;
    /// Numbers of a table that is not empty, by their places; the last one for places beyond it.
    fn looked_up(self, table: &[f32], places: Self::Int) -> Self::Float;
    /// Lanes in an order.
    fn ordered_ints(self, x: Self::Int, order: Self::Int) -> Self::Int;
    /// Lanes in an order.
    fn ordered_floats(self, x: Self::Float, order: Self::Int) -> Self::Float;
    /// Writes all lanes.
    fn put_ints(self, x: Self::Int, to: &mut [MaybeUninit<u32>; LANES]);
    /// Writes all lanes.
    fn put_floats(self, x: Self::Float, to: &mut [MaybeUninit<f32>; LANES]);
    /// Records of four numbers, turned: lane l of result k is number k of record l.
    fn turned(self, records: [&[f32; 4]; LANES]) -> [Self::Float; 4];
    /// `z` held between two others; none may be NaN.
    #[inline(always)]
    fn clamp(self, z: Self::Float, low: Self::Float, high: Self::Float) -> Self::Float {
        self.smaller(self.larger(z, low), high)
    }
    /// Three sums.
    #[inline(always)]
    fn add_three(self, a: [Self::Int; 3], b: [Self::Int; 3]) -> [Self::Int; 3] {
        [self.add(a[0], b[0]), self.add(a[1], b[1]), self.add(a[2], b[2])]
    }
    /// Three products.
    #[inline(always)]
    fn times_three(self, a: [Self::Int; 3], b: Self::Int) -> [Self::Int; 3] {
        [self.mul(a[0], b), self.mul(a[1], b), self.mul(a[2], b)]
    }
    /// a0 b1 - b0 a1.
    #[inline(always)]
    fn cross(self, a: [Self::Float; 2], b: [Self::Float; 2]) -> Self::Float {
        self.sub_floats(self.mul_floats(a[0], b[1]), self.mul_floats(b[0], a[1]))
    }
    /// Floats where the mask is negative, else whole numbers.
    #[inline(always)]
    fn pick_three(self, mask: Self::Int, f: [Self::Float; 3], i: [Self::Int; 3]) -> [Self::Float; 3] {
        [
            self.pick(mask, f[0], self.rounded(i[0])),
            self.pick(mask, f[1], self.rounded(i[1])),
            self.pick(mask, f[2], self.rounded(i[2])),
        ]
    }
    /// Three rows of numbers.
    #[inline(always)]
    fn three_rows(self, x: [Self::Int; 3]) -> [[i32; LANES]; 3] {
        [self.to_ints(x[0]), self.to_ints(x[1]), self.to_ints(x[2])]
    }
    /// Number `l` of each of three rows in all lanes.
    #[inline(always)]
    fn of_three(self, rows: &[[i32; LANES]; 3], l: usize) -> [Self::Int; 3] {
        [self.int(rows[0][l]), self.int(rows[1][l]), self.int(rows[2][l])]
    }
    /// Keeps the smaller depth where `outside` is not negative.
    fn nearest(self, depth: &mut [f32; LANES], z: Self::Float, outside: Self::Int);
    /// Keeps the two smallest depths that differ, where `outside` is not negative.
    fn nearest_two(self, first: &mut [f32; LANES], second: &mut [f32; LANES], z: Self::Float, outside: Self::Int);
    /// Keeps the smaller depth, with the number of the triangle; of equal depths before the far plane the smaller
    /// number.
    fn nearest_with_id(
        self,
        depth: &mut [f32; LANES],
        id: &mut [u32; LANES],
        z: Self::Float,
        outside: Self::Int,
        new_id: u32,
    );
}

/// The two smallest of two depths and a third that differ from each other; the order in which depths come does not matter.
#[inline(always)]
pub fn two_nearest(first: f32, second: f32, z: f32) -> (f32, f32) {
    if z < first {
        (z, first)
    } else if z > first && z < second {
        (first, z)
    } else {
        (first, second)
    }
}

/// For each set of lanes these in ascending order, then lane 0 as often as it takes; a byte each, the first one lowest.
pub const ORDERS: [u64; 1 << LANES] = {
    let mut orders = [0; 1 << LANES];
    let mut bits = 0;
    while bits < orders.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if bits >> lane & 1 == 1 {
                orders[bits] |= (lane as u64) << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    orders
};
