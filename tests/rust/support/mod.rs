//! What tests share.

pub mod boxes;
pub mod by_body;
pub mod cameras;
pub mod cpu;
pub mod foliage;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod measure;
pub mod published_view;
pub mod settings;
pub mod setup;
pub mod tables;
pub mod views;
