//! Large arrays: not touched before the threads that work on them do, and refused rather than aborted.

use std::mem::MaybeUninit;

use crate::error::{Error, Result};

/// An array that is yet to be written.
///
/// # Errors
/// [`Error::InvalidArgument`] where the memory is not to be had.
pub fn unwritten<T: Copy>(len: usize) -> Result<Vec<MaybeUninit<T>>> {
    let mut array: Vec<MaybeUninit<T>> = Vec::new();
    array.try_reserve_exact(len).map_err(|_| {
        let got = format!("{len} values of {} bytes", size_of::<T>());
        Error::argument("size", "an image that fits into memory", got, "choose a smaller image")
    })?;
    ask_for_huge_pages(&mut array);
    // SAFETY: the capacity is there, and `MaybeUninit` needs no value.
    unsafe { array.set_len(len) };
    Ok(array)
}

/// Asks for pages of 2 MB, each touched for the first time at a five-hundredth of the price of as many small ones.
fn ask_for_huge_pages<T>(array: &mut Vec<MaybeUninit<T>>) {
    #[cfg(target_os = "linux")]
    {
        const HUGE: usize = 2 << 20;
        const SMALL: usize = 4096;
        /// Linux, asm-generic/mman-common.h.
        const MADV_HUGEPAGE: i32 = 14;
        unsafe extern "C" {
            fn madvise(start: *mut std::ffi::c_void, bytes: usize, advice: i32) -> i32;
        }
        let (start, bytes) = (array.as_mut_ptr().addr(), array.capacity() * size_of::<T>());
        // Arrays smaller than that come from memory that the allocator uses again.
        if bytes >= HUGE {
            // Whole small pages: such an array has its mapping to itself, which begins a few bytes before it, where kernels
            // from 6.7 on align large mappings.
            let (first, end) = (start / SMALL * SMALL, (start + bytes).next_multiple_of(SMALL));
            let first_byte = array.as_mut_ptr().cast::<u8>().wrapping_sub(start - first);
            // SAFETY: advice, of which no byte changes. A kernel that refuses may do so.
            unsafe { madvise(first_byte.cast(), end - first, MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = array;
}

/// A part of an array with one value written all over it.
pub fn filled<T: Copy>(part: &mut [MaybeUninit<T>], value: T) -> &mut [T] {
    for slot in part.iter_mut() {
        slot.write(value);
    }
    // SAFETY: every value has just been written.
    unsafe { written_part(part) }
}

/// Writes all of a part of an array.
///
/// # Panics
/// Where the lengths differ.
pub fn copied<T: Copy>(part: &mut [MaybeUninit<T>], values: &[T]) {
    assert_eq!(part.len(), values.len());
    for (slot, value) in part.iter_mut().zip(values) {
        slot.write(*value);
    }
}

/// A part of an array that has been written.
///
/// # Safety
/// Every value of it has.
pub unsafe fn written_part<T: Copy>(part: &mut [MaybeUninit<T>]) -> &mut [T] {
    // SAFETY: `MaybeUninit<T>` has the layout of `T`, and the caller vouches for the values.
    unsafe { &mut *(std::ptr::from_mut(part) as *mut [T]) }
}

/// The array once it has been written.
///
/// # Safety
/// Every value of it has.
pub unsafe fn written<T: Copy>(array: Vec<MaybeUninit<T>>) -> Vec<T> {
    let mut array = std::mem::ManuallyDrop::new(array);
    // SAFETY: same allocation, same layout; the caller vouches for the values.
    unsafe { Vec::from_raw_parts(array.as_mut_ptr().cast(), array.len(), array.capacity()) }
}
