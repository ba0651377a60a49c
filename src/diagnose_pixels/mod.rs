//! What takes maps, rays and errors at once.

mod causes;
mod light;
mod rays;
mod shadow;
mod way;

pub use causes::{Wrong, causes};
