//! The light's own projection, from which every map starts and which a view without a warp keeps.
//!
//! Source: theory.md 1.3, 1.4 and 2.

use glam::DVec3;

use crate::fit::spot_depths;
use crate::focus::{Focus, FocusedView, SpotFrustum};
use crate::geometry::Rows;
use crate::note::{Kind, Note};
use crate::rays::LightFrame;
use crate::scene::{Light, Scene};

/// The light's own projection before the fit (theory.md 2): orthographic, or a spot's perspective over the depths of
/// receivers and casters. The frame leans on the view direction, so that the map stands upright as a warped one does.
pub(in crate::techniques) fn uniform_rows(view: &FocusedView, scene: &Scene, notes: &mut Vec<Note>) -> Rows {
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
pub(in crate::techniques) fn spot_depth_range(
    spot: &SpotFrustum,
    view: &FocusedView,
    scene: &Scene,
    notes: &mut Vec<Note>,
) -> [f64; 2] {
    let depths = spot_depths(spot, view, scene);
    if depths.begins_late {
        notes.push(Note::new(Kind::LightInBox, &[("distance", spot.frustum.near)]));
    }
    depths.range
}

/// The frame whose y axis is the view direction in the shadow plane; the camera's up where the light runs along the view.
pub(super) fn frame_of_view(view: &FocusedView, along: DVec3) -> LightFrame {
    if view.focus == Focus::Scene {
        return LightFrame::any(along);
    }
    let turned =
        LightFrame::towards(along, view.camera.forward()).or_else(|| LightFrame::towards(along, view.camera.up()));
    turned.map_or_else(|| LightFrame::any(along), |(frame, _)| frame)
}
