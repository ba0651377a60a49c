//! The pixels of a band that tiny triangles cover.

use std::mem::MaybeUninit;

use super::pixels::{Fragment, Pixels};

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
    pub fn room<const MOST: usize>(&mut self, numbered: bool) -> Room<'_, MOST> {
        Room { at: behind(&mut self.at), z: behind(&mut self.z), id: numbered.then(|| behind(&mut self.id)) }
    }
    /// Room for so many more places and depths, without numbers.
    #[inline(always)]
    pub fn room_of(&mut self, most: usize) -> (&mut [MaybeUninit<u32>], &mut [MaybeUninit<f32>]) {
        self.at.reserve(most);
        self.z.reserve(most);
        (self.at.spare_capacity_mut(), self.z.spare_capacity_mut())
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

/// Where fragments are appended. As arrays: places in them need no test.
#[derive(Debug)]
pub struct Room<'a, const MOST: usize> {
    pub at: &'a mut [MaybeUninit<u32>; MOST],
    pub z: &'a mut [MaybeUninit<f32>; MOST],
    /// None where nobody asks for numbers.
    pub id: Option<&'a mut [MaybeUninit<u32>; MOST]>,
}

/// The room behind a list.
#[inline(always)]
fn behind<T, const MOST: usize>(list: &mut Vec<T>) -> &mut [MaybeUninit<T>; MOST] {
    list.reserve(MOST);
    list.spare_capacity_mut().first_chunk_mut().expect("reserved")
}
