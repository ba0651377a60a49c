//! What is rendered, who looks at it, and what lights it.

mod alpha_test;
mod borders;
mod camera;
mod camera_matrices;
mod clusters;
mod instance_bounds;
mod instance_tree;
pub mod library;
mod light;
mod mesh;
mod moved;
#[allow(clippy::module_inception)]
mod scene;
mod view_volume;

pub use alpha_test::{AlphaTest, AlphaTestParts, AlphaTexture, Presence, Wrap};
pub(crate) use camera::unit;
pub use camera::{Camera, PixelRay};
pub(crate) use clusters::{BLOCK, CLUSTER, Clusters};
pub use instance_tree::{Enter, InstanceTree, Met};
pub use light::{DirectionalLight, EDGE_ON, Light, PointLight, SpotLight};
pub use mesh::{Mesh, Stored};
pub use scene::{Instance, Scene};
pub use view_volume::{Lens, ViewVolume};
