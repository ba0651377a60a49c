//! The techniques: each turns a view into a [`Parameterization`](crate::Parameterization), and says so in a [`Spec`].
//!
//! A new technique is one file with a `SPEC` and a `make`, its `mod` line and its line in [`TECHNIQUES`].

mod lispsm;
mod registry;
mod settings;
mod spec;
mod uniform;

pub use crate::parameterization::Value;
pub use registry::{Entry, Technique, specs, technique};
pub use settings::Settings;
pub use spec::{Default, Kind, LightSupport, ParamSpec, Spec};

/// All techniques, in the order of tables.
pub static TECHNIQUES: &[Entry] =
    &[Entry { spec: &uniform::SPEC, make: uniform::make }, Entry { spec: &lispsm::SPEC, make: lispsm::make }];
