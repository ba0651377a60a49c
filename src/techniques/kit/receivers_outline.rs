//! The outline of what receivers span across the light: the convex hull of their images, found in one pass over the instances.
//!
//! A warp maps lines across the light to lines and keeps w > 0, so whatever the warp, its map's extents are those of this
//! hull's corners: one pass serves a search over all warps. Receivers are the instances' boxes inside the view's body, as the
//! fit has them. The hull is rebuilt when a box adds to it; whether one can
//! is asked with support functions of the hull's sides, and not at all of sides that it has in common with the body's
//! own hull.
//!
//! ```text
//!        ________ the body's hull
//!       /  .--.  \
//!      / .' ▄▄ `. \      sides that touch the body's are settled,
//!     | / ▄▄ ▄▄▄ \ |     the others may still move out
//!     |/_▄▄▄_▄▄▄▄_\|
//! ```

use std::ops::ControlFlow;

use glam::{DVec2, DVec3, DVec4};

use crate::fit::Tightening;
use crate::focus::{FocusedView, is_tightened, receivers_in};
use crate::geometry::{OrientedBox, Rows, convex_hull};
use crate::scene::Scene;

/// A side this close to the body's hull, as a share of the hull's extent, is the body's: rounding of the two ways to cut.
const CLOSE: f64 = 1e-12;

/// Corners of a hull for which no memory is asked again: those of a body of 32 vertices, and as many of boxes.
const USUAL_CORNERS: usize = 64;

/// The convex hull of receivers in the NDC x and y of a map.
#[derive(Debug, Clone)]
pub struct ReceiversOutline {
    /// Counter-clockwise; fewer than three where all lie on a line.
    pub corners: Vec<DVec2>,
    /// Whether the fit gives a map these extents; otherwise it may cut it smaller, as the tightening says.
    pub is_fit: bool,
}

/// The outline of the receivers that the fit of a map without a warp, w > 0 on the body, would find.
pub fn receivers_outline(rows: &Rows, view: &FocusedView, scene: &Scene, tightening: Tightening) -> ReceiversOutline {
    if let Some(outline) = view.outline {
        let mut corners = Vec::with_capacity(outline.corners.len());
        outline.images(&outline.rays.homography(rows), 0.0, |p| corners.push(p));
        return ReceiversOutline { corners, is_fit: true };
    }
    let is_fit = !matches!(tightening, Tightening::Intersection | Tightening::Ignoring { .. });
    let body = view.receivers.vertices();
    let mut hull = Hull::new(rows);
    let whole = || {
        let mut hull = Hull::new(rows);
        hull.add(body);
        hull
    };
    if tightening == Tightening::None || !is_tightened(view) {
        return ReceiversOutline { corners: whole().corners, is_fit };
    }
    let holds_body = receivers_in(view, scene, |instance, cut| {
        let may_grow = hull.may_grow(instance);
        if let Some(cut) = cut.filter(|_| may_grow)
            && hull.add(cut().vertices())
        {
            hull.settle(body);
            if hull.open.is_empty() && hull.corners.len() > 2 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(may_grow)
    });
    let corners = if holds_body || hull.corners.is_empty() { whole().corners } else { hull.corners };
    ReceiversOutline { corners, is_fit }
}

/// A hull that grows.
struct Hull<'a> {
    rows: &'a Rows,
    corners: Vec<DVec2>,
    /// Functionals that are positive where a point with w > 0 lies beyond a side that may still move.
    open: Vec<DVec4>,
    /// Room to build the next hull in.
    lower: Vec<DVec2>,
}

impl<'a> Hull<'a> {
    fn new(rows: &'a Rows) -> Self {
        let room = || Vec::with_capacity(USUAL_CORNERS);
        Self { rows, corners: room(), open: Vec::with_capacity(USUAL_CORNERS), lower: room() }
    }
    fn may_grow(&self, instance: &OrientedBox) -> bool {
        // A line has no inside.
        self.corners.len() < 3 || self.open.iter().any(|f| instance.range(*f).1 > 0.0)
    }
    /// Takes in the images of points; whether any was outside.
    fn add(&mut self, points: &[DVec3]) -> bool {
        let is_outside = |p: &DVec3| self.open.iter().any(|f| f.dot(p.extend(1.0)) > 0.0);
        if points.is_empty() || self.corners.len() > 2 && !points.iter().any(is_outside) {
            return false;
        }
        self.corners.extend(points.iter().map(|p| self.rows.project(*p).truncate()));
        convex_hull(&mut self.corners, &mut self.lower);
        true
    }
    /// Finds the sides that may still move, as the body reaches beyond them. Beside the hull's own, those of the rectangle
    /// around it: of a hull as thin as rounding the ends are no corners.
    fn settle(&mut self, body: &[DVec3]) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in &self.corners {
            (low, high) = (low.min(*p), high.max(*p));
        }
        let sides = |i: usize| {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.corners.len()]);
            (a, -(b - a).perp())
        };
        let rectangle = [(low, DVec2::NEG_X), (low, DVec2::NEG_Y), (high, DVec2::X), (high, DVec2::Y)];
        self.open.clear();
        for (at, outward) in (0..self.corners.len()).map(sides).chain(rectangle) {
            let beyond = outward.abs().dot(high - low) * CLOSE;
            let functional = self.rows.x * outward.x + self.rows.y * outward.y - self.rows.w * outward.dot(at);
            let is_beyond = |p: &DVec3| functional.dot(p.extend(1.0)) > beyond * self.rows.w.dot(p.extend(1.0));
            if body.iter().any(is_beyond) {
                self.open.push(functional);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat() -> Rows {
        Rows { x: DVec4::X, y: DVec4::Y, z: DVec4::Z, w: DVec4::W }
    }

    #[test]
    fn a_hull_has_the_corners_of_its_points_counter_clockwise() {
        let rows = flat();
        let mut hull = Hull::new(&rows);
        let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE, DVec3::splat(0.5), DVec3::new(0.5, 0.0, 3.0)];
        assert!(hull.add(&square));
        assert_eq!(hull.corners, [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]);
        let body = [DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0), DVec3::new(3.0, 1.0, 0.0), DVec3::Y];
        hull.settle(&body);
        // The right side and that of the rectangle there.
        assert_eq!(hull.open.len(), 2);
        assert!(!hull.add(&[DVec3::new(0.9, 0.5, 0.0)]));
        assert!(hull.add(&[DVec3::new(2.0, 0.5, 0.0)]));
        assert_eq!(hull.corners, [DVec2::ZERO, DVec2::X, DVec2::new(2.0, 0.5), DVec2::ONE, DVec2::Y]);
    }

    #[test]
    fn points_and_lines_are_hulls() {
        let rows = flat();
        let mut hull = Hull::new(&rows);
        assert!(hull.add(&[DVec3::ONE, DVec3::ONE]));
        assert_eq!(hull.corners, [DVec2::ONE]);
        assert!(hull.add(&[DVec3::ZERO, DVec3::splat(0.5), DVec3::splat(2.0)]));
        assert_eq!(hull.corners, [DVec2::ZERO, DVec2::splat(2.0)]);
        hull.settle(&[DVec3::ZERO, DVec3::splat(9.0)]);
        let beyond = OrientedBox { center: DVec3::splat(5.0), half: [DVec3::ZERO; 3] };
        assert!(hull.may_grow(&beyond));
        assert!(hull.add(&[beyond.center]));
        assert_eq!(hull.corners, [DVec2::ZERO, DVec2::splat(5.0)]);
    }
}
