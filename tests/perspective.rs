//! Perspective shadow maps: the tables of theory.md, closed forms, limits, and what is refused.

#[path = "perspective/psm.rs"]
mod psm;
#[path = "perspective/tables.rs"]
mod tables;
