//! What takes maps, rays and errors at once.

mod causes;

pub use causes::{Wrong, causes};
