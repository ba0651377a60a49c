//! Uniform shadow maps: the light's own projection, cropped.
//!
//! Source: Williams 1978 `[williams1978]`; focusing after Brabec, Annen and Seidel 2002 `[brabec2002]`; theory.md 1.3,
//! 1.4 and 2.

use glam::DVec4;

use super::kit::light_projection::uniform_rows;
use super::kit::{
    Default, FIT, Fitting, Kind, LightSupport, MARGIN, Named, ParamSpec, Part, Provisional, RANGE, Settings, Spec, Warp,
};
use crate::error::Result;
use crate::fit::MapSize;
use crate::focus::{Focus, FocusedView};
use crate::geometry::Rows;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "uniform",
    title: "Uniform shadow map",
    source: "Williams 1978; focused after Brabec, Annen, Seidel 2002",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "focus",
            unit: "",
            default: Default::Choice("scene-fit"),
            kind: Kind::Choice(&["none", "frustum", "scene-fit"]),
            doc: "what the map covers: the whole scene, the camera's frustum, or what the camera can see of the scene",
        },
        ParamSpec {
            name: "stable",
            unit: "",
            default: Default::Flag(false),
            kind: Kind::Flag,
            doc: "texels stand still while the camera moves (a sphere around its frustum, moved in whole texels); \
                  a whole-scene map and a spot's whole cone stand still by themselves",
        },
        // Without samples unless they are asked for: what every engine has, and what others are measured against.
        ParamSpec { default: Default::Choice("body"), ..RANGE },
        ParamSpec { default: Default::Choice("exact"), ..FIT },
        MARGIN,
    ],
};

#[derive(Debug)]
struct Uniform {
    focus: Focus,
    fitting: Fitting,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let focus = settings
        .meaning("focus", &[("none", Focus::Scene), ("frustum", Focus::Frustum), ("scene-fit", Focus::SceneFit)])?;
    let fitting = if settings.flag("stable") { Fitting::StableGrid } else { Fitting::UnitCube };
    Ok(Box::new(Uniform { focus, fitting }))
}

impl Warp for Uniform {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let scene = part.scene;
        let mut notes = Vec::new();
        let clip_from_local = uniform_rows(view, scene, &mut notes);
        Ok(Provisional { clip_from_local, values: Vec::new(), notes })
    }
    fn focus(&self) -> Focus {
        self.focus
    }
    fn fitting(&self) -> Fitting {
        self.fitting
    }
    /// World size of a texel at the middle of the receivers, across the light.
    fn values_of_fit(&self, view: &FocusedView, clip_from_local: &Rows, size: &MapSize) -> Vec<Named> {
        let mean = view.middle();
        let clip_w = clip_from_local.w.dot(mean.extend(1.0));
        let texel = |row: DVec4| 2.0 * clip_w / (f64::from(size.resolution) * row.truncate().length());
        vec![("texel_x", texel(clip_from_local.x)), ("texel_y", texel(clip_from_local.y))]
    }
}
