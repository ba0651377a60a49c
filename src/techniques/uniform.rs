//! Uniform shadow maps: the light's own projection, cropped.
//!
//! Source: Williams 1978 `[williams1978]`; focusing after Brabec, Annen and Seidel 2002 `[brabec2002]`; theory.md 1.3,
//! 1.4 and 2. The smallest rectangle: Freeman and Shapira 1975 `[freeman1975]`, one of its sides is on the hull.

use glam::{DVec2, DVec4};

use super::kit::light_projection::uniform_rows;
use super::kit::{
    Default, FIT, Fitting, Kind, LightSupport, MARGIN, Named, ParamSpec, Part, Provisional, RANGE, SLACK, Settings,
    Spec, Warp, receivers_outline,
};
use crate::error::{Error, Result};
use crate::fit::{MapSize, Tightening};
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
        ParamSpec {
            name: "turn",
            unit: "",
            default: Default::Choice("view"),
            kind: Kind::Choice(&["view", "rectangle"]),
            doc: "how the map is turned about the light: its y axis along the view, or as the smallest rectangle around what it \
                  holds (the papers' normal map)",
        },
        // Without samples unless they are asked for: what every engine has, and what others are measured against.
        ParamSpec { default: Default::Choice("body"), ..RANGE },
        ParamSpec { default: Default::Choice("exact"), ..FIT },
        MARGIN,
        SLACK,
    ],
};

#[derive(Debug)]
struct Uniform {
    focus: Focus,
    fitting: Fitting,
    turn: Turn,
    tightening: Tightening,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Turn {
    View,
    Rectangle,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let focus = settings
        .meaning("focus", &[("none", Focus::Scene), ("frustum", Focus::Frustum), ("scene-fit", Focus::SceneFit)])?;
    let fitting = if settings.flag("stable") { Fitting::StableGrid } else { Fitting::UnitCube };
    let turn = settings.meaning("turn", &[("view", Turn::View), ("rectangle", Turn::Rectangle)])?;
    if turn == Turn::Rectangle && fitting == Fitting::StableGrid {
        let fix = "leave stable off, or take turn=view";
        return Err(Error::argument("turn", "view, where stable is on", "rectangle, which turns with the view", fix));
    }
    Ok(Box::new(Uniform { focus, fitting, turn, tightening: settings.tightening()? }))
}

impl Warp for Uniform {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let scene = part.scene;
        let mut notes = Vec::new();
        let upright = uniform_rows(view, scene, &mut notes);
        let clip_from_local = match self.turn {
            Turn::View => upright,
            Turn::Rectangle => turned(&upright, &receivers_outline(&upright, view, scene, self.tightening).corners),
        };
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
        let texel = |row: DVec4, texels: f64| 2.0 * clip_w / (texels * row.truncate().length());
        let texels = size.texels();
        vec![("texel_x", texel(clip_from_local.x, texels.x)), ("texel_y", texel(clip_from_local.y, texels.y))]
    }
}

/// The map turned so that its axes are those of the smallest rectangle around some corners, counter-clockwise.
fn turned(rows: &Rows, corners: &[DVec2]) -> Rows {
    let extent = |axis: DVec2| {
        let along = corners.iter().map(|p| axis.dot(*p));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let sides = (0..corners.len()).map(|i| corners[(i + 1) % corners.len()] - corners[i]);
    let axes = sides.filter_map(DVec2::try_normalize);
    let area = |axis: &DVec2| extent(*axis) * extent(axis.perp());
    let Some(axis) = axes.min_by(|a, b| area(a).total_cmp(&area(b))) else { return *rows };
    // Of its four turns the one closest to upright.
    let turns = [axis, axis.perp(), -axis, -axis.perp()];
    let axis = turns.into_iter().fold(axis, |best, turn| if turn.x > best.x { turn } else { best });
    Rows { x: rows.x * axis.x + rows.y * axis.y, y: rows.y * axis.x - rows.x * axis.y, ..*rows }
}
