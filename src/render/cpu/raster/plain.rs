//! The vector operations for every processor: loops over arrays.

use std::array::from_fn;
use std::mem::MaybeUninit;

use super::lanes::{FAR_OF_IDS, Lanes, ORDERS, two_nearest};
use super::simd::{LANES, sign_bits};
use super::triangle_setup::{larger, smaller};
use super::vertices::snapped;

/// For every processor.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl Lanes for Plain {
    type Int = [i32; LANES];
    type Float = [f32; LANES];
    #[inline(always)]
    fn ints(self, x: [i32; LANES]) -> Self::Int {
        x
    }
    #[inline(always)]
    fn unsigned(self, x: &[u32; LANES]) -> Self::Int {
        from_fn(|l| x[l] as i32)
    }
    #[inline(always)]
    fn floats(self, x: [f32; LANES]) -> Self::Float {
        x
    }
    #[inline(always)]
    fn int(self, x: i32) -> Self::Int {
        [x; LANES]
    }
    #[inline(always)]
    fn float(self, x: f32) -> Self::Float {
        [x; LANES]
    }
    #[inline(always)]
    fn to_ints(self, x: Self::Int) -> [i32; LANES] {
        x
    }
    #[inline(always)]
    fn to_floats(self, x: Self::Float) -> [f32; LANES] {
        x
    }
    #[inline(always)]
    fn bits_of(self, x: Self::Float) -> Self::Int {
        from_fn(|l| x[l].to_bits() as i32)
    }
    #[inline(always)]
    fn rounded(self, x: Self::Int) -> Self::Float {
        from_fn(|l| x[l] as f32)
    }
    #[inline(always)]
    fn snapped(self, x: Self::Float) -> Self::Int {
        from_fn(|l| snapped(x[l]))
    }
    #[inline(always)]
    fn add(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l].wrapping_add(b[l]))
    }
    #[inline(always)]
    fn sub(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l].wrapping_sub(b[l]))
    }
    #[inline(always)]
    fn mul(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l].wrapping_mul(b[l]))
    }
    #[inline(always)]
    fn and(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l] & b[l])
    }
    #[inline(always)]
    fn or(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l] | b[l])
    }
    #[inline(always)]
    fn xor(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l] ^ b[l])
    }
    #[inline(always)]
    fn shifted(self, x: Self::Int, by: u32) -> Self::Int {
        from_fn(|l| x[l] >> by)
    }
    #[inline(always)]
    fn least(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l].min(b[l]))
    }
    #[inline(always)]
    fn most(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| a[l].max(b[l]))
    }
    #[inline(always)]
    fn less(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| -i32::from(a[l] < b[l]))
    }
    #[inline(always)]
    fn equal(self, a: Self::Int, b: Self::Int) -> Self::Int {
        from_fn(|l| -i32::from(a[l] == b[l]))
    }
    #[inline(always)]
    fn signs(self, x: Self::Int) -> u32 {
        sign_bits(&x)
    }
    #[inline(always)]
    fn add_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| a[l] + b[l])
    }
    #[inline(always)]
    fn sub_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| a[l] - b[l])
    }
    #[inline(always)]
    fn mul_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| a[l] * b[l])
    }
    #[inline(always)]
    fn fused(self, a: Self::Float, b: Self::Float, c: Self::Float) -> Self::Float {
        from_fn(|l| a[l].mul_add(b[l], c[l]))
    }
    #[inline(always)]
    fn div_floats(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| a[l] / b[l])
    }
    #[inline(always)]
    fn smaller(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| smaller(a[l], b[l]))
    }
    #[inline(always)]
    fn larger(self, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| larger(a[l], b[l]))
    }
    #[inline(always)]
    fn at_most(self, a: Self::Float, b: Self::Float) -> Self::Int {
        from_fn(|l| -i32::from(a[l] <= b[l]))
    }
    #[inline(always)]
    fn pick(self, mask: Self::Int, a: Self::Float, b: Self::Float) -> Self::Float {
        from_fn(|l| if mask[l] < 0 { a[l] } else { b[l] })
    }
    #[inline(always)]
    fn order(self, bits: u32) -> Self::Int {
        let order = ORDERS[bits as usize % ORDERS.len()].to_le_bytes();
        from_fn(|l| order[l].into())
    }
    #[inline(always)]
    fn looked_up(self, table: &[f32], places: Self::Int) -> Self::Float {
        from_fn(|l| table[(places[l] as u32 as usize).min(table.len() - 1)])
    }
    #[inline(always)]
    fn ordered_ints(self, x: Self::Int, order: Self::Int) -> Self::Int {
        from_fn(|l| x[order[l] as usize % LANES])
    }
    #[inline(always)]
    fn ordered_floats(self, x: Self::Float, order: Self::Int) -> Self::Float {
        from_fn(|l| x[order[l] as usize % LANES])
    }
    #[inline(always)]
    fn put_ints(self, x: Self::Int, to: &mut [MaybeUninit<u32>; LANES]) {
        *to = from_fn(|l| MaybeUninit::new(x[l] as u32));
    }
    #[inline(always)]
    fn put_floats(self, x: Self::Float, to: &mut [MaybeUninit<f32>; LANES]) {
        *to = from_fn(|l| MaybeUninit::new(x[l]));
    }
    #[inline(always)]
    fn turned(self, records: [&[f32; 4]; LANES]) -> [Self::Float; 4] {
        from_fn(|k| from_fn(|l| records[l][k]))
    }
    #[inline(always)]
    fn nearest(self, depth: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
        for l in 0..LANES {
            if outside[l] >= 0 && z[l] < depth[l] {
                depth[l] = z[l];
            }
        }
    }
    #[inline(always)]
    fn nearest_two(self, first: &mut [f32; LANES], second: &mut [f32; LANES], z: Self::Float, outside: Self::Int) {
        for l in 0..LANES {
            if outside[l] >= 0 {
                (first[l], second[l]) = two_nearest(first[l], second[l], z[l]);
            }
        }
    }
    #[inline(always)]
    fn nearest_with_id(
        self,
        depth: &mut [f32; LANES],
        id: &mut [u32; LANES],
        z: Self::Float,
        outside: Self::Int,
        new_id: u32,
    ) {
        for l in 0..LANES {
            let first = z[l] == depth[l] && z[l] < FAR_OF_IDS && new_id < id[l];
            if outside[l] >= 0 && (z[l] < depth[l] || first) {
                (depth[l], id[l]) = (z[l], new_id);
            }
        }
    }
}
