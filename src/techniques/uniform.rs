//! Uniform shadow maps: the light's own projection, cropped.
//!
//! Source: Williams 1978; focusing after Brabec, Annen and Seidel 2002; theory.md 1.3, 1.4 and 2.

use glam::{DVec3, DVec4};

use super::kit::focused::begins_late;
use super::kit::{
    Default, FIT, Fitting, Kind, LightSupport, Named, ParamSpec, Part, Provisional, Settings, Spec, Warp,
};
use crate::error::Result;
use crate::fit::{MapSize, spot_depths};
use crate::focus::{Focus, FocusedView, SpotFrustum};
use crate::geometry::Rows;
use crate::rays::LightFrame;
use crate::scene::{Light, Scene};

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
        FIT,
    ],
};

#[derive(Debug)]
struct Uniform {
    focus: Focus,
    fitting: Fitting,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let focus = match settings.word("focus") {
        "none" => Focus::Scene,
        "frustum" => Focus::Frustum,
        _ => Focus::SceneFit,
    };
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
        let mean = view.receivers.vertex_mean();
        let clip_w = clip_from_local.w.dot(mean.extend(1.0));
        let texel = |row: DVec4| 2.0 * clip_w / (f64::from(size.resolution) * row.truncate().length());
        vec![("texel_x", texel(clip_from_local.x)), ("texel_y", texel(clip_from_local.y))]
    }
}

/// The light's own projection before the fit (theory.md 2): orthographic, or a spot's perspective over the depths of
/// receivers and casters. The frame leans on the view direction, so that the map stands upright as a warped one does.
pub(super) fn uniform_rows(view: &FocusedView, scene: &Scene, notes: &mut Vec<String>) -> Rows {
    match (&view.light, view.spot()) {
        (_, Some(spot)) => {
            let [near, far] = spot_depth_range(&spot, view, scene, notes);
            spot.perspective(near, far)
        }
        (Light::Directional(l), _) => frame_of_view(view, l.direction()).orthographic(),
        // Refused before: a point light has no single map.
        (light, None) => LightFrame::any(light.to_light(view.origin)).orthographic(),
    }
}

/// The depths of a spot's map; notes what its beginning leaves out.
pub(super) fn spot_depth_range(
    spot: &SpotFrustum,
    view: &FocusedView,
    scene: &Scene,
    notes: &mut Vec<String>,
) -> [f64; 2] {
    let depths = spot_depths(spot, view, scene);
    if depths.begins_late {
        notes.push(begins_late(spot.frustum.near));
    }
    depths.range
}

/// The frame whose y axis is the view direction in the shadow plane; the camera's up where the light runs along the view.
fn frame_of_view(view: &FocusedView, along: DVec3) -> LightFrame {
    if view.focus == Focus::Scene {
        return LightFrame::any(along);
    }
    let turned =
        LightFrame::towards(along, view.camera.forward()).or_else(|| LightFrame::towards(along, view.camera.up()));
    turned.map_or_else(|| LightFrame::any(along), |(frame, _)| frame)
}
