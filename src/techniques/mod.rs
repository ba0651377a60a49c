//! The techniques: each turns a view into a [`Parameterization`](crate::Parameterization), and says so in a [`Spec`].

mod spec;

pub use crate::parameterization::Value;
pub use spec::{Kind, LightSupport, ParamSpec, Spec};
