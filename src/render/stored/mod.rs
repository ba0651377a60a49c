//! What a map stores: which surface, how its depth is spaced, in which format.

mod encoder;
mod format;
mod kind;
mod measure;
mod step;
mod texel_rays;
mod text;

pub(crate) use encoder::{Encoder, Layers};
pub use format::Format;
pub use kind::{Spacing, Stored, StoredSurface};
pub(crate) use measure::DepthMeasure;
pub use measure::depth_measure;
pub use step::step_along_ray;
pub(crate) use texel_rays::TexelRays;
