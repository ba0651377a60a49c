//! Truth by ray casting.

mod exact;
mod input;
mod library;
mod shadows;
