//! What a technique returns, and the values of its settings: plain data.

mod maps;
mod partition;
mod piecewise_linear;
mod post_warp;
mod region;
mod value;

pub use maps::{Parameterization, Selection};
pub use partition::{Factors, Held, Partition};
pub use piecewise_linear::PiecewiseLinear;
pub use post_warp::{PostWarp, Rectilinear};
pub use region::Region;
pub use value::Value;
