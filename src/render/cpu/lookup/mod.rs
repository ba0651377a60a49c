//! What receivers read in depth maps that are there: a lookup, the mask of an image, and probes for the causes of errors.

mod asks;
mod bias_distance;
mod blending;
mod comparison;
mod filtered;
#[expect(clippy::module_inception, reason = "the twin of lookup.wgsl has its stem")]
mod lookup;
mod mask;
mod on_planes;
mod parts;
mod probe;
mod projected;
mod run_light;
mod runs;
mod states;
mod warped;
mod wide_run_light;

pub use bias_distance::bias_distance;
pub use blending::Next;
pub use comparison::{Comparison, Reference};
pub use lookup::{Lookups, MapLookup};
pub(super) use mask::MaskInput;
pub use mask::look_up;
pub(super) use states::{OnlyMap, set_states};
