//! What a map must cover, and the fit that makes it cover that: shared by all techniques.

mod body_error;
mod dominant_plane;
mod logarithmic;
mod receivers;
mod receivers_outline;
mod samples;
mod stable;
mod tightening;
mod unit_cube;
mod view;
mod warp;
mod warp_search;

pub use body_error::{BodyError, ErrorMeasure, ErrorNorm, footprint};
pub use dominant_plane::{DominantPlane, dominant_plane};
pub use logarithmic::fit_logarithmic;
pub use receivers::receivers_extent;
pub use receivers_outline::{ReceiversOutline, receivers_outline};
pub use samples::ReceiverSamples;
pub use stable::{StableGrid, scene_depth, stable_grid};
pub use tightening::Tightening;
pub use unit_cube::{BORDER_TEXELS, Fit, MapSize, SpotDepths, crop, fit, nearest_caster, receivers_room, spot_depths};
pub use view::{Coverage, Focus, FocusedView, NEAREST_SHARE_OF_REACH, SpotFrustum};
pub use warp::{LEAST_KAPPA, LEAST_LAMBDA, NoWarp, WarpSpace};
pub use warp_search::{Strength, best_strength};
