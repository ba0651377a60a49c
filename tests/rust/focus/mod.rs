//! What a map must cover.

mod bodies;
