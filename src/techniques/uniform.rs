//! Uniform shadow maps: the light's own projection, cropped.
//!
//! Source: Williams 1978; focusing after Brabec, Annen and Seidel 2002; theory.md 1.3, 1.4 and 2.

use glam::{DVec3, DVec4};

use super::registry::{check_light, single_map};
use super::spec::{Default, Kind, LightSupport, ParamSpec, Spec};
use super::{Settings, Technique};
use crate::error::Result;
use crate::focus::{Focus, FocusedView, MapSize, SpotFrustum, fit, scene_depth, spot_depths, stable_grid};
use crate::geometry::Rows;
use crate::parameterization::{Parameterization, Value};
use crate::rays::LightFrame;
use crate::scene::{Camera, Light, Scene};

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "uniform",
    title: "Uniform shadow map",
    source: "Williams 1978; focused after Brabec, Annen, Seidel 2002",
    lights: LightSupport { directional: true, spot: true, point: false },
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
    ],
};

#[derive(Debug)]
struct Uniform {
    settings: Settings,
    focus: Focus,
    stable: bool,
}

/// The technique from checked settings.
pub fn make(settings: Settings) -> Result<Box<dyn Technique>> {
    let focus = match settings.word("focus") {
        "none" => Focus::Scene,
        "frustum" => Focus::Frustum,
        _ => Focus::SceneFit,
    };
    let stable = settings.flag("stable");
    Ok(Box::new(Uniform { settings, focus, stable }))
}

impl Technique for Uniform {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }
    fn settings(&self) -> Vec<(&'static str, Value)> {
        self.settings.values().to_vec()
    }
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization> {
        check_light(&SPEC, light)?;
        let size = MapSize::new(resolution, 0)?;
        if self.stable {
            return Ok(self.stable_map(scene, camera, light, &size));
        }
        let view = FocusedView::new(scene, camera, light, self.focus);
        let mut notes = Vec::new();
        let rows = fit(&uniform_rows(&view, scene, &mut notes), &view, scene, &size);
        let values = texel_sizes(&view, &rows, &size);
        Ok(single_map(self, &view, &rows.moved_to_world(view.origin), &size, values, notes))
    }
}

impl Uniform {
    fn stable_map(&self, scene: &Scene, camera: &Camera, light: &Light, size: &MapSize) -> Parameterization {
        let whole = FocusedView::new(scene, camera, light, Focus::Scene);
        let (Light::Directional(directional), true) = (light, self.focus != Focus::Scene) else {
            let mut notes =
                vec!["stable: the map covers all that the light reaches, whatever the camera sees".to_string()];
            let rows = fit(&uniform_rows(&whole, scene, &mut notes), &whole, scene, size);
            let values = texel_sizes(&whole, &rows, size);
            return single_map(self, &whole, &rows.moved_to_world(whole.origin), size, values, notes);
        };
        let along = directional.direction();
        let grid = stable_grid(camera, along, scene_depth(scene.bounds(), along), size);
        let values = vec![("texel_x", grid.texel), ("texel_y", grid.texel), ("radius", grid.radius)];
        single_map(self, &whole, &grid.clip_from_world, size, values, Vec::new())
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
        let near = spot.frustum.near;
        notes.push(format!("the light is inside a mesh's box: what is nearer to it than {near:.4} casts no shadow"));
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

/// World size of a texel at the middle of the receivers, across the light.
fn texel_sizes(view: &FocusedView, rows: &Rows, size: &MapSize) -> Vec<(&'static str, f64)> {
    let mean = view.receivers.vertex_mean();
    let clip_w = rows.w.dot(mean.extend(1.0));
    let texel = |row: DVec4| 2.0 * clip_w / (f64::from(size.resolution) * row.truncate().length());
    vec![("texel_x", texel(rows.x)), ("texel_y", texel(rows.y))]
}
