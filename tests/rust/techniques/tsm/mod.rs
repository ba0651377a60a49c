//! The trapezoidal map.

pub mod trapezoid;
