//! What maps store, and lookups into it: surfaces, spacings, formats.

mod closed;
mod draws;
pub mod oracle;
mod planes;
pub mod surfaces;
