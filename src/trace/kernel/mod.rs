//! The inner tests, of eight boxes against a ray or the hull of a bundle, of a box against the rays of a bundle, of four triangles
//! against a ray, of one against those of a bundle, and roughly of four against them: portable, and for AVX2 chosen at run time.
//!
//! Triangles give the same bits in both: every operation is an IEEE addition, multiplication, division or comparison in
//! the same order, nothing is contracted. Boxes and the rough test may differ in the last bits, for which they are padded: which
//! boxes are entered, and which triangles are tested in vain, does not affect the answer.

#[cfg(all(test, target_arch = "x86_64"))]
mod agreement;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx2_exact;
mod dispatch;
pub mod exact;
mod interface;
mod portable;
#[cfg(test)]
mod roughly;

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
pub(super) use dispatch::dispatched;
#[cfg(target_arch = "x86_64")]
pub use dispatch::has_avx2;
pub use exact::Pass;
pub use interface::{Kernel, Lanes};
pub use portable::Portable;
