//! Truth by ray casting: which point a ray meets first, and whether light arrives there.
//!
//! Knows no parameterization and no shadow map; its answers are what those are held against.

mod batch;
mod bundle;
mod frame;
mod kernel;
mod packet;
mod ray;
mod together;
mod tracer;
mod traverse;
mod tree;
mod visibility;
mod visit;

pub use batch::Hit;
pub use tracer::Tracer;
