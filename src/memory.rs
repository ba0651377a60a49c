//! Large arrays: not touched before the threads that work on them do, and refused rather than aborted.
//!
//! Linux promises more memory than there is, and ends the process that uses it. So what a call will use is held against what
//! is there before anything is allocated.

use std::mem::MaybeUninit;

use crate::error::{Error, Result};

/// Bytes that every machine has: less is not asked about, which takes some microseconds.
const SMALL: u64 = 1 << 24;
/// Bytes of a limited address space that are left to threads and to what is small.
const RESERVE: u64 = 1 << 27;

/// An error unless so many bytes are to be had, for what `name` asks for.
///
/// # Errors
/// [`Error::InvalidArgument`].
pub fn check_room(name: &'static str, bytes: u64, got: impl FnOnce() -> String) -> Result<()> {
    match (bytes > SMALL).then(available).flatten() {
        Some(free) if bytes > free => {
            let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
            let expected = format!("what fits into the {:.1} GiB of memory that are free", gib(free));
            let got = format!("{}, which takes {:.1} GiB", got(), gib(bytes));
            Err(Error::argument(name, expected, got, "choose fewer or smaller ones"))
        }
        _ => Ok(()),
    }
}

/// The same for `count` images of so many bytes a pixel.
///
/// # Errors
/// As [`check_room`].
pub fn check_images(name: &'static str, count: usize, size: [u32; 2], pixel_bytes: usize) -> Result<()> {
    let [width, height] = size.map(u64::from);
    let bytes = (width * height).saturating_mul(count as u64).saturating_mul(pixel_bytes as u64);
    check_room(name, bytes, || match count {
        1 => format!("{width} x {height}"),
        _ => format!("{count} of {width} x {height}"),
    })
}

/// An empty array with room for so many values, for what `name` asks for.
///
/// # Errors
/// [`Error::InvalidArgument`] where the memory is not to be had.
pub fn with_room<T>(name: &'static str, len: usize) -> Result<Vec<T>> {
    check_room(name, (len as u64).saturating_mul(size_of::<T>() as u64), || format!("{len} values"))?;
    let mut array = Vec::new();
    array.try_reserve_exact(len).map_err(|_| {
        let got = format!("{len} values of {} bytes", size_of::<T>());
        Error::argument(name, "what fits into memory", got, "choose fewer or smaller ones")
    })?;
    Ok(array)
}

/// Bytes that this process can use now; nothing where the system does not tell.
fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |path: &str| read(path)?.trim().parse::<u64>().ok();
    let line = |text: String| text.lines().find_map(|line| line.strip_prefix("MemAvailable:").map(String::from));
    let machine = read("/proc/meminfo").and_then(line)?.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10;
    // Of a container.
    let group = "/sys/fs/cgroup";
    let limit = number(&format!("{group}/memory.max"));
    let used = number(&format!("{group}/memory.current")).unwrap_or(0);
    let group = limit.map_or(u64::MAX, |limit| limit.saturating_sub(used));
    Some(machine.min(group).min(address_space().unwrap_or(u64::MAX)))
}

/// Bytes that a limit of the address space (`ulimit -v`) leaves to this process; nothing where there is no such limit.
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit = limit.split_whitespace().next()?.parse::<u64>().ok()?;
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let used = status.lines().find_map(|line| line.strip_prefix("VmSize:"))?;
    let used = used.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10;
    Some(limit.saturating_sub(used).saturating_sub(RESERVE))
}

/// An array that is yet to be written.
///
/// # Errors
/// [`Error::InvalidArgument`] where the memory is not to be had.
pub fn unwritten<T: Copy>(len: usize) -> Result<Vec<MaybeUninit<T>>> {
    let mut array: Vec<MaybeUninit<T>> = with_room("size", len)?;
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
        const PAGE: usize = 4096;
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
            let (first, end) = (start / PAGE * PAGE, (start + bytes).next_multiple_of(PAGE));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_there_is_is_refused_before_it_is_asked_for() {
        assert!(check_images("size", 1, [1024; 2], 40).is_ok());
        assert!(check_room("size", SMALL, || unreachable!("it is little")).is_ok());
        if let Some(free) = available() {
            assert!(free > 0);
            let error = check_images("resolution", usize::MAX, [16384; 2], 4).unwrap_err().to_string();
            assert!(error.starts_with("resolution: expected what fits") && error.contains("16384 x 16384"), "{error}");
            assert!(unwritten::<f32>(usize::MAX / 8).unwrap_err().to_string().starts_with("size: "));
        }
        assert!(unwritten::<f32>(usize::MAX / 8).is_err());
    }
}
