//! The inner tests, of eight boxes against a ray or the hull of a bundle, of a box against eight rays, of four triangles
//! against a ray: portable, and for AVX2 chosen at run time.
//!
//! Triangles give the same bits in both: every operation is an IEEE addition, multiplication, division or comparison in
//! the same order, nothing is contracted. Boxes may differ in the last bits, for which they are padded: which of them are
//! entered has no say in the answer.

#[cfg(all(test, target_arch = "x86_64"))]
mod agreement;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod dispatch;
mod interface;
mod portable;

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
pub(super) use dispatch::dispatched;
#[cfg(target_arch = "x86_64")]
pub use dispatch::has_avx2;
pub use interface::{BandMeet, Kernel};
pub use portable::Portable;
