//! The scenes of the library.

mod library;
