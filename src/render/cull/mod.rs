//! Which instances a map draws: those outside of it cast nothing into it, and those whose shadow no pixel looks up change no mask.

mod asked;
mod keep;
mod rule;
mod volume;

pub use asked::Asked;
pub(crate) use asked::Marks;
pub use keep::Keep;
pub use rule::{Casters, Cull, Rule, looking_pays};
pub use volume::{PlacedVolume, Volume};
