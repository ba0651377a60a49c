//! LiSPSM: the tables, the search for the warp distance, and the outline that it looks at.

mod optimal;
mod receivers_outline;
mod tables;
