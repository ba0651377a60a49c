//! LiSPSM: the tables, the search for the warp distance over the body and over what is seen, and the outline that it looks at.

mod optimal;
mod receivers_outline;
mod seen;
mod tables;
