//! The homography that is best for what is seen.

mod flips;
mod kernel;
mod objective;
mod problem;
mod published;
mod search;
mod warp;

pub use kernel::Sample;
pub use objective::{Cost, Objective};
pub use problem::{Problem, Shape, Warped};
pub use published::{Enclosing, Published, Step, enclosing};
pub use search::least;
pub use warp::{CAP, HELD, SPEC, SUM, cost_of, make};
