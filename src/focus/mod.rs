//! What a map must cover: the receivers' and casters' bodies of a view, and samples of what the camera sees.

mod receivers;
mod samples;
mod view;

pub use receivers::receivers_extent;
pub(crate) use receivers::{is_tightened, receivers_in};
pub use samples::{EdgeSample, NearEdge, Outline, Picture, RayEdge, RayFlip, RayFrame, Samples, Shadows};
pub use view::{Coverage, Focus, FocusedView, NEAREST_SHARE_OF_REACH, SpotFrustum};
