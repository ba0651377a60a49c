//! LiSPSM: the warp, and the search for the warp distance with the least error.

mod body_error;
mod measure;
mod search;
mod seen_error;
mod seen_flips;
mod warp;

pub use crate::techniques::kit::{ReceiversOutline, receivers_outline};
pub use body_error::{BodyError, ErrorMeasure, ErrorNorm, footprint};
pub use measure::Measure;
pub use search::{Strength, best_strength};
pub use seen_error::SeenError;
pub use seen_flips::SeenFlips;
pub use warp::{SPEC, make};
