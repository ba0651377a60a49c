//! Perspective shadow maps and plane-optimal ones: the tables of theory.md, closed forms, limits, and what is refused.

#[path = "perspective/dominant.rs"]
mod dominant;
#[path = "perspective/plane.rs"]
mod plane;
#[path = "perspective/psm.rs"]
mod psm;
#[path = "perspective/tables.rs"]
mod tables;
