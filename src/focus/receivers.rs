//! What receivers there can be: the instances' boxes inside K, as a box of NDC or one by one.

use std::ops::ControlFlow;

use glam::DVec4;

use super::view::{Coverage, Focus, FocusedView};
use crate::geometry::{Aabb, ConvexBody, OrientedBox, Rows};
use crate::parameterization::Region;
use crate::scene::{Met, Scene};

/// The NDC box of what receivers there can be.
pub fn receivers_extent(provisional: &Rows, view: &FocusedView, scene: &Scene) -> Aabb {
    let project = |body: &ConvexBody| Aabb::from_points(body.vertices().iter().map(|p| provisional.project(*p)));
    let whole = project(&view.receivers);
    match view.focus {
        _ if is_tightened(view) => tightened(provisional, view, scene, &whole),
        Focus::Frustum if view.coverage == Coverage::AsAsked => {
            // Receivers lie in the frustum and in the scene: the nearer end of both bounds the depth.
            let mut lit = ConvexBody::from_aabb(&view.scene_box);
            view.light_planes().into_iter().flatten().for_each(|plane| lit.clip(plane));
            let deepest = project(&lit).max.z;
            let z = if deepest > whole.min.z { whole.max.z.min(deepest) } else { whole.max.z };
            Aabb { max: whole.max.truncate().extend(z), ..whole }
        }
        _ => whole,
    }
}

/// Whether receivers are known closer than by K: as the instances' boxes in it.
pub(crate) fn is_tightened(view: &FocusedView) -> bool {
    view.focus == Focus::SceneFit && view.coverage == Coverage::AsAsked
}

/// The extents of the instances' boxes inside K; those of K where no box reaches into it.
fn tightened(provisional: &Rows, view: &FocusedView, scene: &Scene, whole: &Aabb) -> Aabb {
    // An extent this close to K's is K's: rounding of the two ways to cut.
    let close = 1e-12 * whole.extent();
    let mut found = Aabb::EMPTY;
    let holds_body = receivers_in(view, scene, |instance, cut| {
        if !found.is_empty() && growth(provisional, &found).iter().all(|f| instance.range(*f).1 <= 0.0) {
            return ControlFlow::Continue(false);
        }
        let Some(cut) = cut else { return ControlFlow::Continue(true) };
        found = cut().vertices().iter().fold(found, |b, p| b.with_point(provisional.project(*p)));
        let reached = found.min.truncate().cmple((whole.min + close).truncate()).all()
            && found.max.cmpge(whole.max - close).all();
        if reached {
            found = *whole;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(true)
    });
    // No box reaches into K: whatever the map covers then is as good.
    if holds_body || found.is_empty() { *whole } else { found }
}

/// Hands over the instances' boxes that may reach into K, each with a way to cut it to K, until told to stop; before them boxes
/// of groups of instances, without one, of which `visit` says whether any in it may count. Stops at a box that holds K: true.
pub(crate) fn receivers_in(
    view: &FocusedView,
    scene: &Scene,
    mut visit: impl FnMut(&OrientedBox, Option<&dyn Fn() -> ConvexBody>) -> ControlFlow<(), bool>,
) -> bool {
    let scene_planes = view.scene_planes();
    // Boxes that stick out of the scene's by no more than this need no cut: far above rounding, far below a texel.
    let slack = f64::EPSILON.sqrt() * view.scene_box.extent().max_element();
    // Six of the camera, six of a light's pyramid, and those of a region.
    let mut outward = [DVec4::ZERO; 12 + Region::MOST];
    let mut planes = 0;
    for plane in view.receiver_planes() {
        outward[planes] = plane.functional();
        planes += 1;
    }
    let is_outside = |b: &OrientedBox| outward[..planes].iter().any(|f| b.range(*f).0 > 0.0);
    let mut holds_body = false;
    let _ = scene.visit(|met| {
        let i = match met {
            Met::One(i) => i,
            Met::Group(bounds) => {
                let group = OrientedBox::around(bounds, view.origin);
                return if is_outside(&group) { ControlFlow::Continue(false) } else { visit(&group, None) };
            }
        };
        let instance = scene.box_of(i, view.origin);
        if is_outside(&instance) {
            return ControlFlow::Continue(false);
        }
        let hull = instance.aabb();
        let holds_scene = hull.min.cmple(view.scene_box.min).all() && hull.max.cmpge(view.scene_box.max).all();
        let axis_aligned = || instance.half.iter().all(|h| h.abs().max_element() == h.abs().element_sum());
        // A box that holds the scene's, or is it up to rounding, holds K.
        if (holds_scene || scene.instances().len() == 1) && axis_aligned() {
            holds_body = true;
            return ControlFlow::Break(());
        }
        let cut = || {
            let mut body = ConvexBody::from_oriented_box(&instance);
            view.receiver_planes().for_each(|plane| body.clip(plane));
            let inside =
                hull.min.cmpge(view.scene_box.min - slack).all() && hull.max.cmple(view.scene_box.max + slack).all();
            if !inside {
                scene_planes.iter().for_each(|plane| body.clip(plane));
            }
            body
        };
        visit(&instance, Some(&cut))
    });
    holds_body
}

/// Functionals that are positive where a point with w > 0 lies beyond a bound that receivers set.
fn growth(rows: &Rows, found: &Aabb) -> [DVec4; 5] {
    [
        rows.w * found.min.x - rows.x,
        rows.x - rows.w * found.max.x,
        rows.w * found.min.y - rows.y,
        rows.y - rows.w * found.max.y,
        rows.z - rows.w * found.max.z,
    ]
}
