//! The rasteriser on the processor: no driver, deterministic, the rules of graphics hardware.

pub mod lookup;
