//! The renderer on a graphics device, against closed forms and against the one on the processor.

mod against_cpu;
mod agreement;
mod closed_form;
mod filtered;
mod footprint;
mod footprints;
mod holes;
mod selection;
mod stored;
mod strong_warps;
