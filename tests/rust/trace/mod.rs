//! Truth by ray casting.

mod exact;
mod holes;
mod input;
mod library;
mod lights_on_surfaces;
mod moved;
mod piles;
mod shadows;
