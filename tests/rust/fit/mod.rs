//! What a map is cut to.

mod stable;
mod unit_cube;
