//! What techniques are made with: their traits and settings, focusing and fitting around a warp, the space warps act in.

pub(super) mod along_view;
mod edge_width;
pub(super) mod faces;
pub(super) mod focused;
mod kind;
pub(super) mod light_projection;
mod light_space;
mod maps;
mod receivers_outline;
mod settings;
mod spec;
mod technique;
mod warp_space;

pub use edge_width::{CAP_PX, capped, capped_px, edge_width};
pub use maps::{Maps, Part, with_length};
pub use receivers_outline::{ReceiversOutline, receivers_outline};
pub use settings::{Holds, Range, Settings};
pub use spec::{Default, FIT, Kind, LightSupport, MARGIN, ParamSpec, RANGE, SLACK, Spec};
pub use technique::{Fitting, Named, Needs, Provisional, Spacing, Technique, Warp};
pub use warp_space::{LEAST_KAPPA, LEAST_LAMBDA, WarpSpace};
