//! The pixels of a band that tiny triangles cover.

use std::mem::MaybeUninit;

use super::pixels::{Fragment, Pixels};
use super::simd::LANES;

/// Covered pixels of a band, in no order that matters.
#[derive(Debug, Default)]
pub struct Fragments {
    at: Vec<u32>,
    z: Vec<f32>,
    /// Empty where nobody asks for numbers.
    id: Vec<u32>,
}

impl Fragments {
    pub fn clear(&mut self) {
        self.at.clear();
        self.z.clear();
        self.id.clear();
    }
    /// Bytes of three lists, by the length of one.
    pub fn bytes(&self, length: fn(&Vec<u32>) -> usize) -> usize {
        2 * length(&self.at) * size_of::<u32>() + length(&self.id) * size_of::<u32>()
    }
    /// Draws all of them.
    pub fn draw<P: Pixels>(&self, pixels: &mut P) {
        let places = self.at.iter().zip(&self.z);
        if self.id.is_empty() {
            places.for_each(|(&at, &z)| pixels.draw_fragment(&Fragment { at, z, id: 0 }));
        } else {
            places.zip(&self.id).for_each(|((&at, &z), &id)| pixels.draw_fragment(&Fragment { at, z, id }));
        }
    }
    /// Room for so many more.
    #[inline(always)]
    pub fn room(&mut self, most: usize, numbered: bool) -> Room<'_> {
        self.at.reserve(most);
        self.z.reserve(most);
        self.id.reserve(if numbered { most } else { 0 });
        let id = if numbered { self.id.spare_capacity_mut() } else { &mut [] };
        Room { at: self.at.spare_capacity_mut(), z: self.z.spare_capacity_mut(), id }
    }
    /// Takes in what has been written to the beginning of its room.
    ///
    /// # Safety
    /// That are `count` values, of numbers too where fragments are numbered.
    #[inline(always)]
    pub unsafe fn lengthen(&mut self, count: usize, numbered: bool) {
        // SAFETY: as the caller vouches for.
        unsafe {
            self.at.set_len(self.at.len() + count);
            self.z.set_len(self.z.len() + count);
            if numbered {
                self.id.set_len(self.id.len() + count);
            }
        }
    }
}

/// Where fragments are appended.
#[derive(Debug)]
pub struct Room<'a> {
    pub at: &'a mut [MaybeUninit<u32>],
    pub z: &'a mut [MaybeUninit<f32>],
    /// Empty where nobody asks for numbers.
    pub id: &'a mut [MaybeUninit<u32>],
}

/// Room for [`LANES`] values from index `at`.
#[inline(always)]
pub fn lanes_of<T>(room: &mut [T], at: usize) -> &mut [T; LANES] {
    room[at..].first_chunk_mut().expect("room for a group")
}
