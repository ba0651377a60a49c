//! What is rendered, who looks at it, and what lights it.

mod alpha_test;
mod camera;
mod camera_matrices;
pub mod library;
mod light;
mod mesh;
#[allow(clippy::module_inception)]
mod scene;

pub use alpha_test::{AlphaTest, AlphaTestParts, AlphaTexture, Presence, Wrap};
pub use camera::Camera;
pub(crate) use camera::unit;
pub use light::{DirectionalLight, EDGE_ON, Light, PointLight, SpotLight};
pub use mesh::{Mesh, Stored};
pub use scene::{Instance, Scene};
