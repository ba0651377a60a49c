//! What takes maps, rays and errors at once.

mod caster;
mod causes;
mod displaced;
mod kept;
mod light;
mod looker;
mod rays;
mod shadow;
mod way;

pub use causes::{Wrong, causes};
