//! How a map is read: theory.md 14. A filter as a value and as text, and the kernel that it is at one receiver.

mod disc;
mod kernel;
mod kernels;
mod text;
mod value;

pub use kernel::{Kernel, Tap};
pub(crate) use kernel::{between, bilinear, first_texel, integral_of_box, integral_of_tent, texels_across};
pub use kernels::Kernels;
pub use text::{FILTERS, FilterSpec};
pub use value::{Extent, Filter, MOST_POINTS, Unit, WIDEST_TEXELS};
