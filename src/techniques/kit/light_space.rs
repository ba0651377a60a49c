//! Light space as the first factor of every map: a point's ray of the light and its place along it.
//!
//! Source: theory.md 0, (0.2) and (0.3). It depends on the light and the view direction alone, so that the warps of all
//! techniques for one view act in the same space.

use glam::{DMat4, DVec3, DVec4};

use super::light_projection::frame_of_view;
use crate::focus::FocusedView;
use crate::geometry::Rows;
use crate::rays::LightFrame;
use crate::scene::Light;

/// The space that warps act in, relative to the view's local origin.
#[derive(Debug, Clone, Copy)]
pub(super) enum LightSpace {
    /// Across, along the warp axis and along the light; w = 1.
    Directional(LightFrame),
    /// The light's perspective: x and y, w the depth along its axis, z = -1.
    Placed { frame: LightFrame, apex: DVec3, tan_half: f64 },
}

impl LightSpace {
    /// That of a view.
    pub fn of(view: &FocusedView) -> Self {
        match (&view.light, view.spot()) {
            (_, Some(spot)) => {
                Self::Placed { frame: spot.frame, apex: spot.frustum.apex, tan_half: spot.frustum.half[0] }
            }
            (Light::Directional(light), _) => Self::Directional(frame_of_view(view, light.direction())),
            // Refused before: a point light has no single map.
            (light, None) => Self::Directional(LightFrame::any(light.to_light(view.origin))),
        }
    }
    /// Light space from the view's local space.
    pub fn rows(&self) -> Rows {
        match *self {
            Self::Directional(frame) => frame.orthographic(),
            Self::Placed { frame, apex, tan_half } => {
                let row = |v: DVec3| v.extend(-v.dot(apex));
                Rows {
                    x: row(frame.right / tan_half),
                    y: row(frame.up / tan_half),
                    z: DVec4::NEG_W,
                    w: row(frame.along),
                }
            }
        }
    }
    /// The same map from light space, of rows from the view's local space whose x, y and w vanish on the light (0.1).
    pub fn warp(&self, rows: &Rows) -> DMat4 {
        let depth = self.functional(rows.z);
        // The light is (0, 0, 1, 0) up to scale.
        let across = |row: DVec4| self.functional(row).with_z(0.0);
        Rows { x: across(rows.x), y: across(rows.y), z: depth, w: across(rows.w) }.matrix()
    }
    /// A functional of local (p, 1) as one of light space.
    fn functional(&self, row: DVec4) -> DVec4 {
        let v = row.truncate();
        match *self {
            Self::Directional(LightFrame { right, up, along }) => {
                DVec4::new(v.dot(right), v.dot(up), v.dot(along), row.w)
            }
            Self::Placed { frame: LightFrame { right, up, along }, apex, tan_half } => {
                let at_light = v.dot(apex) + row.w;
                DVec4::new(v.dot(right) * tan_half, v.dot(up) * tan_half, -at_light, v.dot(along))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_functional_of_light_space_is_the_one_of_the_world() {
        let frame = LightFrame::any(DVec3::new(0.48, -0.6, 0.64));
        let placed = LightSpace::Placed { frame, apex: DVec3::new(1.0, 2.0, -3.0), tan_half: 0.4 };
        for space in [LightSpace::Directional(frame), placed] {
            for row in [DVec4::new(0.3, -1.0, 2.0, 0.5), DVec4::W, DVec4::X] {
                for p in [DVec3::new(4.0, -5.0, 6.0), DVec3::ZERO] {
                    let there = space.functional(row).dot(space.rows().clip(p));
                    assert!((there - row.dot(p.extend(1.0))).abs() < 1e-14, "{space:?} {row} {p}: {there}");
                }
            }
            let warp = space.warp(&space.rows());
            assert!(warp.abs_diff_eq(DMat4::IDENTITY, 1e-15), "{warp}");
        }
    }
}
