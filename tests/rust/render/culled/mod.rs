//! Casters that are not drawn: they change no map, or no pixel of a mask.

mod forests;
mod lists;
#[cfg(feature = "gpu")]
mod on_device;
mod seen;
mod setups;
mod volume;
