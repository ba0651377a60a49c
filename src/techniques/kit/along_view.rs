//! What warps along the view under a directional light share: where they act, when there is none, and what they tell.
//!
//! Source: theory.md 5.1 (the warp) and 6 (the centre ray; bodies as the eye sees them).
//!
//! ```text
//!   reference point        eye              near end (Ymin)                far end (Ymax)      along the light: ⊗
//!         x <-- phi_offset κ -->|<-- Ymin -------> |<------------ D --------------> |          warp axis: ->
//!         x <--------------- Pn -----------------> |                               |
//! ```

use glam::DVec3;

use super::light_projection::uniform_rows;
use super::maps::Part;
use super::technique::{Named, Provisional};
use super::warp_space::WarpSpace;
use crate::focus::{Coverage, FocusedView};
use crate::note::Note;
use crate::scene::Light;

/// A view under a directional light whose warp runs along the view direction.
#[derive(Debug, Clone, Copy)]
pub(in crate::techniques) struct AlongView<'a> {
    /// The view.
    pub view: &'a FocusedView<'a>,
    /// Where the warp acts.
    pub space: WarpSpace,
    /// The eye's place on the warp axis.
    pub eye_y: f64,
    /// The angle between light and view, at most a right one: obtuse angles are their supplements' mirror image.
    pub theta: f64,
    /// Unit vector across the view, on the side that the warp axis leaves as theta shrinks: `b = sin θ v - cos θ u`.
    across: DVec3,
}

/// A body as the eye sees it along a warp axis; distances relative to the eye.
#[derive(Debug, Clone, Copy)]
pub(in crate::techniques) struct SeenBody {
    /// Smallest and largest place on the warp axis.
    pub y: [f64; 2],
    /// Near and far eye depth.
    pub depth: [f64; 2],
    /// The angle between the view and the body's outermost point on the side that the warp axis leaves, φ: for a smaller theta
    /// part of the body lies behind the eye as the light sees it.
    pub silhouette: f64,
    /// Extent along the warp axis that there would be at theta = φ.
    pub silhouette_extent: f64,
}

/// The provisional map of a warp along the view whose distance from reference point to near end `distance` tells, in world
/// units, with what it has to say; a uniform map, and a note, where there is no warp.
pub(in crate::techniques) fn warped_along_view(
    view: &FocusedView,
    part: &Part,
    distance: impl FnOnce(&AlongView, &mut Vec<Named>, &mut Vec<Note>) -> f64,
) -> Provisional {
    let (mut values, mut notes) = (Vec::with_capacity(16), Vec::new());
    let clip_from_local = match AlongView::new(view, &mut notes) {
        Some(along) => {
            let AlongView { space, theta, .. } = along;
            let wanted = distance(&along, &mut values, &mut notes);
            let distance = space.limited(wanted, &mut notes);
            values.extend([
                ("warp_distance", distance),
                ("lambda", distance / space.extent()),
                ("kappa", space.rate),
                ("theta", theta),
                ("depth", space.extent()),
                ("y_min", along.eye_distance()),
                ("phi_offset", (distance - along.eye_distance()) / space.rate),
            ]);
            space.warped(distance)
        }
        None => {
            if view.coverage == Coverage::AsAsked {
                values.push(("kappa", 0.0));
            }
            uniform_rows(view, part.scene, &mut notes)
        }
    };
    Provisional { clip_from_local, values, notes }
}

impl<'a> AlongView<'a> {
    /// Nothing where no warp can act; the note says why.
    fn new(view: &'a FocusedView<'a>, notes: &mut Vec<Note>) -> Option<Self> {
        let (Light::Directional(light), Coverage::AsAsked) = (&view.light, view.coverage) else { return None };
        let (forward, along) = (view.camera.forward(), light.direction());
        let space = WarpSpace::directional(view, along, forward)
            .map_err(|reason| notes.push(Note::no_warp(&[reason], &[])))
            .ok()?;
        let cosine = forward.dot(along);
        let towards = if cosine < 0.0 { -along } else { along };
        Some(Self {
            view,
            space,
            eye_y: space.rows.y.dot(view.eye.extend(1.0)),
            theta: space.rate.atan2(cosine.abs()),
            across: (towards - forward * cosine.abs()) / space.rate,
        })
    }
    /// The receivers' body.
    pub fn receivers(&self) -> SeenBody {
        self.seen(self.view.receivers.vertices(), self.view.eye_depth)
    }
    /// The camera's whole frustum.
    pub fn frustum(&self) -> SeenBody {
        let camera = &self.view.camera;
        self.seen(&self.view.camera_frustum().corners(), [camera.near(), camera.far()])
    }
    fn seen(&self, points: &[DVec3], depth: [f64; 2]) -> SeenBody {
        let (forward, eye) = (self.view.camera.forward(), self.view.eye);
        let axis = self.space.rows.y.truncate();
        let mut y = [f64::INFINITY, f64::NEG_INFINITY];
        let mut tangent = f64::NEG_INFINITY;
        for p in points {
            let p = *p - eye;
            let at = axis.dot(p);
            y = [y[0].min(at), y[1].max(at)];
            tangent = tangent.max(self.across.dot(p) / forward.dot(p));
        }
        let silhouette = tangent.atan();
        let (sine, cosine) = silhouette.sin_cos();
        let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
        for p in points {
            let at = (forward * sine - self.across * cosine).dot(*p - eye);
            extent = [extent[0].min(at), extent[1].max(at)];
        }
        SeenBody { y, depth, silhouette, silhouette_extent: extent[1] - extent[0] }
    }
    /// The share `lambda` of a warp at theta = φ, weakened below: λ / tan(π θ / (4 φ)) (6.3), infinite at theta = 0.
    pub fn below_silhouette(&self, body: &SeenBody, lambda: f64) -> f64 {
        // The silhouette of a body whose near end lies behind the eye is wider than theta, up to rounding.
        let quarter = std::f64::consts::FRAC_PI_4 * self.theta / body.silhouette.max(self.theta);
        lambda / quarter.tan()
    }
    /// The eye's distance from the near end of the receivers; negative where part of them lies behind it as the light sees it.
    pub fn eye_distance(&self) -> f64 {
        self.space.y[0] - self.eye_y
    }
    /// GMNPR's warp distance: equal errors at both ends of the centre ray (6.4); below the silhouette (6.3).
    pub fn equal_ends_distance(&self, body: &SeenBody) -> f64 {
        let [near, far] = body.depth;
        if body.y[0] >= 0.0 {
            return self.space.rate * (near * far).sqrt() + body.y[0];
        }
        let at_silhouette = body.silhouette.sin() * (near * far).sqrt() / body.silhouette_extent;
        self.below_silhouette(body, at_silhouette) * (body.y[1] - body.y[0])
    }
    /// The warp distance whose reference point lies `distance` before the near end of another body than the receivers'.
    pub fn distance_of(&self, body: &SeenBody, distance: f64) -> f64 {
        distance + (self.eye_distance() - body.y[0])
    }
}
