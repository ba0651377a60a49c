//! The tables' view, and how maps are compared with them: after the plain crop of theory.md 0, up to a positive scale.

use glam::{DMat4, DVec3};
use serde_json::Value as Json;
use shadowlab::Parameterization;
use shadowlab::fit::crop;
use shadowlab::focus::{Focus, FocusedView, Samples};
use shadowlab::geometry::Rows;
use shadowlab::scene::{Camera, Light, Scene};

use crate::support::by_body::by_body;
use crate::support::tables::{box_scene, camera, matrix, sun, tables, vector};

/// Of f64 through a dozen operations on numbers of size 100.
pub const EXACT: f64 = 1e-9;

/// A scene, a camera and a light.
pub struct View {
    pub scene: Scene,
    pub camera: Camera,
    pub light: Light,
}

impl View {
    /// The view that all matrices of the tables share.
    pub fn of_tables(t: &Json) -> Self {
        let inputs = &t["matrices"]["inputs"];
        let scene = box_scene(vector(&inputs["scene_aabb"][0]), vector(&inputs["scene_aabb"][1]));
        let light = sun(vector(&inputs["light_direction_unnormalised"]));
        Self { scene, camera: camera(&inputs["camera"]), light }
    }
    /// A camera at the origin that looks along -z from depth 1 to 100, as in theory.md E.1, with everything in view: K is the
    /// frustum.
    pub fn of_frustum(aspect: f64, along: DVec3) -> Self {
        let fov = 60.0_f64.to_radians();
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov, aspect, 1.0, 100.0).expect("a camera");
        Self { scene: box_scene(DVec3::splat(-300.0), DVec3::splat(300.0)), camera, light: sun(along) }
    }
    pub fn focused(&self) -> FocusedView<'static> {
        FocusedView::new(&self.scene, &self.camera, &self.light, Focus::SceneFit)
    }
    pub fn try_map(&self, technique: &str, samples: Option<&Samples>) -> shadowlab::Result<Parameterization> {
        let t = by_body(technique);
        t.parameterize_seen(&self.scene, &self.camera, &self.light, [1024; 2], samples)
    }
    pub fn map(&self, technique: &str) -> Parameterization {
        self.try_map(technique, None).unwrap_or_else(|e| panic!("{technique}: {e}"))
    }
    /// The rows of the only map, local to the focused view.
    pub fn rows(&self, technique: &str) -> Rows {
        self.local(&self.map(technique).partitions[0].shadow_clip_from_world)
    }
    pub fn local(&self, clip_from_world: &DMat4) -> Rows {
        Rows::of(&(*clip_from_world * DMat4::from_translation(self.focused().origin)))
    }
    /// The rows after the plain crop to K, which takes away any other crop.
    pub fn cropped(&self, rows: &Rows) -> Rows {
        let view = self.focused();
        crop(rows, &view, view.receivers.vertices(), view.receivers.vertices())
    }
}

/// Largest entry of the difference of two maps' rows x, y, w and, where `depth`, z: each scaled to its largest entry.
pub fn difference(a: &Rows, b: &Rows, depth: bool) -> f64 {
    let kept = |rows: &Rows| if depth { *rows } else { Rows { z: glam::DVec4::ZERO, ..*rows } };
    let normed = |rows: &Rows| {
        let m = kept(rows).matrix();
        m * (1.0 / m.to_cols_array().iter().fold(0.0_f64, |s, x| s.max(x.abs())))
    };
    (normed(a) - normed(b)).to_cols_array().iter().fold(0.0, |s: f64, x| s.max(x.abs()))
}

#[test]
fn the_comparison_sees_a_change_of_one_entry_and_no_other_crop() {
    let t = tables();
    let v = View::of_tables(&t);
    let rows = v.local(&matrix(&t["matrices"]["psm_slide10"]["M"]));
    let mut changed = rows;
    changed.y.z *= 1.0 + 1e-6;
    assert!(difference(&rows, &changed, true) > EXACT);
    let other = rows.cropped(DVec3::new(-2.0, 0.1, -0.3), DVec3::new(1.0, 0.7, 0.5));
    assert!(difference(&rows, &other, true) > 0.1);
    assert!(difference(&v.cropped(&rows), &v.cropped(&other), true) < EXACT);
}
