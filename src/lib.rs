//! The laboratory for shadow-map parameterizations.
//!
//! A shadow map samples the rays of a light. Those rays form a two-dimensional space, and every technique of the
//! literature is a homography on that space plus a depth row chosen independently. So a technique turns a view into a
//! [`Parameterization`], plain data, and renderers, truth and analysis see only that.
//!
//! # Conventions
//! - Right-handed world, column vectors, f64; a matrix is named `target_from_source`.
//! - NDC: x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light (or the eye).
//! - Images: row 0 at the top; texel or pixel (i, j) has its centre at (i + 1/2, j + 1/2).
//! - Angles in radians; lengths in world units unless the name says otherwise.

pub mod aliasing;
pub mod diagnose_pixels;
pub mod digest;
pub mod error;
pub mod fit;
pub mod focus;
pub mod geometry;
pub mod image;
mod memory;
mod names;
pub mod note;
pub mod parameterization;
pub mod picture;
pub mod progress;
#[cfg(feature = "python")]
mod python;
pub mod rays;
pub mod render;
pub mod scene;
mod simd;
pub mod survey;
pub mod techniques;
pub mod threads;
pub mod trace;

pub use error::{Error, Result};
pub use note::Note;
pub use parameterization::{Parameterization, Partition};
pub use progress::Progress;
pub use scene::{Camera, Light, Mesh, Scene};
