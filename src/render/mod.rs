//! Depth maps, G-buffers and shadow masks: one trait, a CPU and a GPU implementation that agree texel for texel.

mod bias;
mod blur;
pub mod cpu;
mod cull;
mod filter;
#[cfg(feature = "gpu")]
pub mod gpu;
mod precision;
mod renderer;
mod settings_text;
mod stored;

pub use bias::Bias;
pub use blur::{BlurSettings, BlurStrength, MAX_STEPS, blur};
pub(crate) use cull::{Asked, Keep, Marks, PlacedVolume, Volume};
pub use cull::{Casters, Cull, Rule, looking_pays};
pub use filter::{Extent, FILTERS, Filter, FilterSpec, Kernel, Kernels, MOST_POINTS, Tap, Unit, WIDEST_TEXELS};
pub(crate) use filter::{between, bilinear, first_texel, integral_of_box, integral_of_tent, texels_across};
pub use renderer::{LightMaps, MAX_IMAGE_SIDE, MaskSettings, Renderer, check_size};
pub(crate) use renderer::{check_blend, check_count, check_extent, no_picture, no_states};
pub use stored::{Format, Spacing, Stored, StoredSurface, depth_measure, step_along_ray};
