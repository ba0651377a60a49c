//! Truth by ray casting: which point a ray meets first, and whether light arrives there.
//!
//! Knows no parameterization and no shadow map; its answers are what those are held against.
//!
//! [`hierarchy`] is what rays walk through; [`rays`] takes them into its frames; [`kernel`] has the tests on the way,
//! [`walk`] the way itself. [`shading`] puts rays together into the answer for a pixel, from what is [`seen`] there. [`batch`], in
//! the bundles of [`rows`] and [`nearby`], [`one_by_one`], [`surfaces`] and [`visibility`] answer the questions asked from outside.
//! [`mod@moved_surfaces`] takes points along with what they lie on.

mod batch;
mod hierarchy;
mod kernel;
mod moved_surfaces;
mod nearby;
mod one_by_one;
mod rays;
mod rows;
mod seen;
mod shading;
mod surfaces;
mod visibility;
mod walk;

pub use batch::Hit;
pub use hierarchy::Tracer;
pub use moved_surfaces::moved_surfaces;
pub use one_by_one::OneByOne;
