//! Truth by ray casting.

mod exact;
mod holes;
mod input;
mod library;
mod shadows;
