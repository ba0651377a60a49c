//! The fit shared by all techniques: a provisional map is brought to the unit cube, or to a grid that stands still.

mod above;
mod logarithmic;
mod map_size;
mod outlined;
mod stable;
mod tightening;
mod unit_cube;

pub use above::nearest_caster;
pub use logarithmic::fit_logarithmic;
pub use map_size::{BORDER_TEXELS, MapSize};
pub use outlined::rectangle;
pub use stable::{StableGrid, scene_depth, stable_grid};
pub use tightening::Tightening;
pub(crate) use unit_cube::Room;
pub use unit_cube::{Fit, SpotDepths, crop, fit, receivers_room, spot_depths};
