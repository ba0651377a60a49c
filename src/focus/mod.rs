//! What a map must cover, and the fit that makes it cover that: shared by all techniques.

mod logarithmic;
mod samples;
mod stable;
mod tightening;
mod unit_cube;
mod view;
mod warp;

pub use logarithmic::fit_logarithmic;
pub use samples::ReceiverSamples;
pub use stable::{StableGrid, scene_depth, stable_grid};
pub use tightening::Tightening;
pub use unit_cube::{BORDER_TEXELS, MapSize, SpotDepths, crop, fit, nearest_caster, receivers_extent, spot_depths};
pub use view::{Coverage, Focus, FocusedView, NEAREST_SHARE_OF_REACH, SpotFrustum};
pub use warp::{LEAST_KAPPA, LEAST_LAMBDA, NoWarp, WarpSpace};
