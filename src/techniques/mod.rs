//! The techniques: each turns a view into a [`Parameterization`](crate::Parameterization), and says so in a [`Spec`].
//!
//! A new technique is one file or folder with a `SPEC`, a `make` that reads the settings and the [`Warp`] itself, its `mod`
//! line and its line in [`TECHNIQUES`]; focusing and fitting are shared around the warp and lie with all else that techniques
//! are made with in [`kit`].

mod by_body;
mod face_partition;
mod glpr;
mod gmnpr;
mod held;
mod inner;
pub mod kit;
pub mod lispsm;
mod log;
mod log_psm;
pub mod optimal_partition;
pub mod plane_optimal;
mod psm;
pub mod rectilinear;
mod registry;
pub mod scene_optimal;
mod text;
mod tsm;
mod uniform;
mod xpsm;
mod z_partition;

pub use crate::parameterization::Value;
pub use by_body::by_body;
pub use held::{holds, with_slack};
pub use kit::{
    Default, FIT, Fitting, Holds, Kind, LightSupport, MARGIN, Maps, Named, Needs, ParamSpec, Part, Provisional, RANGE,
    SLACK, Settings, Spacing, Spec, Technique, Warp,
};
pub use registry::{Entry, Make, RENAMED, Renamed, specs, technique};
pub use text::{technique_of, techniques_of, text_of};

/// All techniques, in the order of tables.
pub static TECHNIQUES: &[Entry] = &[
    Entry { spec: &uniform::SPEC, make: Make::Warp(uniform::make) },
    Entry { spec: &lispsm::SPEC, make: Make::Warp(lispsm::make) },
    Entry { spec: &psm::SPEC, make: Make::Warp(psm::make) },
    Entry { spec: &tsm::SPEC, make: Make::Warp(tsm::make) },
    Entry { spec: &gmnpr::SPEC, make: Make::Warp(gmnpr::make) },
    Entry { spec: &glpr::SPEC, make: Make::Warp(glpr::make) },
    Entry { spec: &xpsm::SPEC, make: Make::Warp(xpsm::make) },
    Entry { spec: &plane_optimal::SPEC, make: Make::Warp(plane_optimal::make) },
    Entry { spec: &scene_optimal::SPEC, make: Make::Warp(scene_optimal::make) },
    Entry { spec: &rectilinear::SPEC, make: Make::Warp(rectilinear::make) },
    Entry { spec: &log_psm::SPEC, make: Make::Warp(log_psm::make) },
    Entry { spec: &log::SPEC, make: Make::Warp(log::make) },
    Entry { spec: &z_partition::SPEC, make: Make::Scheme(z_partition::make) },
    Entry { spec: &optimal_partition::SPEC, make: Make::Scheme(optimal_partition::make) },
    Entry { spec: &face_partition::SPEC, make: Make::Scheme(face_partition::make) },
];
