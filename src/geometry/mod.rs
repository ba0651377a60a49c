//! Geometry in f64, knowing only glam.

mod aabb;
mod convex;
mod frustum;
mod homography;
mod oriented_box;
mod plane;
mod polygon;
mod quadrilateral;

pub use aabb::Aabb;
pub use convex::ConvexBody;
pub use frustum::{Frustum, Sides};
pub use homography::{Rows, planar_image, singular_values};
pub use oriented_box::OrientedBox;
pub use plane::Plane;
pub use polygon::{clipped, convex_hull};
pub use quadrilateral::square_from_quadrilateral;
