//! The tests of the core from outside, one binary: a module a room of `src`, and what holds for all techniques.

mod aliasing;
mod contract;
mod fit;
mod focus;
mod layers;
mod render;
mod scene;
mod support;
mod techniques;
mod trace;
