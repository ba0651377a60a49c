//! Plane-optimal maps, and the plane that most receivers lie in.

mod dominant;
mod plane;
