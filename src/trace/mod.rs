//! Truth by ray casting: which point a ray meets first, and whether light arrives there.
//!
//! Knows no parameterization and no shadow map; its answers are what those are held against.
//!
//! `tree` is built over `packet`s of triangles by `tracer`; `ray` takes rays into a frame, alone or in a `bundle`;
//! `traverse` and `together` walk with them, `kernel` has the tests on the way, `visit` what is looked for; `batch` and
//! `visibility` answer the questions asked from outside.

mod batch;
mod bundle;
mod frame;
mod from_light;
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
pub use from_light::FirstLit;
pub use tracer::Tracer;
