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
    // SAFETY: the capacity is there, and `MaybeUninit` needs no value.
    unsafe { array.set_len(len) };
    Ok(array)
}

/// A part of an array with one value written all over it.
pub fn filled<T: Copy>(part: &mut [MaybeUninit<T>], value: T) -> &mut [T] {
    for slot in part.iter_mut() {
        slot.write(value);
    }
    // SAFETY: every value has just been written.
    unsafe { written_part(part) }
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
