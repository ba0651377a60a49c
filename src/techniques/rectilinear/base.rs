//! The technique whose homography comes before a separable warp.

use crate::error::{Error, Result};
use crate::parameterization::Value;
use crate::techniques::Make;
use crate::techniques::kit::{FIT, Fitting, MARGIN, RANGE, SLACK, Settings, Spacing, Spec, Warp};
use crate::techniques::registry::resolved;
use crate::techniques::text::named;

/// A warp, and the technique that it is of.
#[derive(Debug)]
pub struct Base {
    pub spec: &'static Spec,
    pub warp: Box<dyn Warp>,
}

impl Base {
    /// The base that settings name, with their range, fit, margin and slack.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a technique that has no projective map of its own, and for a range, fit, margin or slack in
    /// the base's text, which are those of the map; what [`technique`](crate::techniques::technique()) says of names and values.
    pub fn new(settings: &Settings) -> Result<Self> {
        let (name, mut params) = named(settings.word("base"))?;
        let refused = |got: String| {
            let expected = "a technique with one projective map that is fitted to what is seen";
            let fix = "name scene_optimal, lispsm, uniform or another warp without a logarithm or a stable grid";
            Err(Error::argument("base", expected, got, fix))
        };
        let (entry, _) = resolved(name, &params)?;
        let Make::Warp(make) = entry.make else { return refused(format!("{name}, which divides the view")) };
        for shared in [RANGE.name, FIT.name, MARGIN.name, SLACK.name] {
            if params.iter().any(|(param, _)| param == shared) {
                let expected =
                    format!("a technique without {shared}: the map has one, which is its own and its base's");
                let fix = format!("write rectilinear:{shared}=... beside base=...");
                return Err(Error::argument("base", expected, format!("{:?}", settings.word("base")), fix));
            }
            let own = settings.values().iter().find(|(param, _)| *param == shared);
            params.extend(own.map(|(param, value)| (param.to_string(), value.clone())));
        }
        let (_, settings) = resolved(name, &params)?;
        let warp = make(&settings)?;
        match (warp.spacing(), warp.fitting()) {
            (Spacing::Projective, Fitting::UnitCube) => Ok(Self { spec: entry.spec, warp }),
            (Spacing::Projective, Fitting::StableGrid) => refused(format!("{name} with stable={}", Value::Flag(true))),
            _ => refused(format!("{name}, whose texels are uneven already")),
        }
    }
}
