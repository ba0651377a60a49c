//! A file or folder a technique, named as it is, and what holds of several.

mod along_view;
mod gmnpr;
mod lispsm;
mod log_psm;
mod plane_optimal;
mod psm;
mod registry;
mod storage_factors;
mod tsm;
mod xpsm;
mod z_partition;
