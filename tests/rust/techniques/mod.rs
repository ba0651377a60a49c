//! A file or folder a technique, named as it is, and what holds of several.

mod along_view;
mod face_partition;
mod glpr;
mod gmnpr;
mod lispsm;
mod log_psm;
mod optimal_partition;
mod plane_optimal;
mod point_light;
mod psm;
mod rectilinear;
mod registry;
mod samples;
mod scene_optimal;
mod storage_factors;
mod tsm;
mod xpsm;
mod z_partition;
