//! What a map must cover.

mod bodies;
mod edges;
mod samples;
