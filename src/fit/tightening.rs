//! How closely a map is cut to what it has to show: the alternatives of the unit-cube clipping article, for study.
//!
//! Source: the unit-cube clipping article, Kapoulkine 2007 `[kapoulkine2007]`; theory.md 1.3; Gusev 2007 `[gusev2007]`
//! for the published step of XPSM. Departures: no
//! alternative but that step loses a caster. Where the article takes casters as points, their boxes are cut in space, so
//! nothing is divided by a w that is not positive; and casters are told from receivers where that can be known: every
//! instance is both, and only a flat one with nothing behind it casts on nothing.
//!
//! ```text
//!          exact             receivers           intersection             none
//!        [ ▄█ ▄▄ ]          ▀[ ▄█ ▄▄ ]▀            . [▄█] .           [   ▄█ ▄▄   ]
//!     receivers' extents,  the same, depth     where anything is    K's extents, depth
//!     casters above them   of casters aside    cast on anything     of the scene's box
//! ```

use glam::{DMat3, DVec3, DVec4};

use crate::focus::FocusedView;
use crate::geometry::{Aabb, ConvexBody, OrientedBox, Plane, Rows};
use crate::rays::LightFrame;
use crate::scene::Scene;

/// How closely a map is cut to receivers and casters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tightening {
    /// x, y and the far plane: the instances' boxes inside K. The near plane: the boxes cut by the sides of the map. Every
    /// receiver is in the map, and no smaller one holds the same boxes. Costs a support function for each box, and a cut for
    /// those that can change a bound.
    Exact,
    /// As [`Tightening::Exact`], but the near plane holds the casters' boxes whole, not only what of them lies above the map:
    /// the article's extents of all casters. As it clips them by the near plane, they are cut where w falls below its least on
    /// the map. Keeps every pair. Costs a cut for each box, and depth precision where boxes stand aside the map.
    Receivers,
    /// x and y: where boxes that can cast on anything lie in or above receivers. The near plane: those boxes. Keeps every
    /// pair; a receiver that nothing is above of may lie outside of the map or before its near plane, and is lit there.
    /// Costs a second pass over the boxes, and one for every flat box.
    Intersection,
    /// x, y and the far plane: K itself. The near plane: the scene's box above the map. Looks at no instance, so the map
    /// does not change when things move inside the scene's box. Keeps every pair; costs the texels and depth of K and that
    /// box where they are empty.
    None,
    /// The step published for XPSM: x, y and the near plane from the corners of casters' boxes; corners with a w below this
    /// are ignored. Loses the casters whose box has such corners above the map.
    Ignoring {
        /// Smallest w of a corner that counts, in units of the provisional map's w.
        least_w: f64,
    },
}

/// The boxes of all instances, local.
pub(super) fn boxes<'a>(view: &'a FocusedView, scene: &'a Scene) -> impl Iterator<Item = OrientedBox> + 'a {
    (0..scene.instances().len()).map(|i| scene.box_of(i, view.origin))
}

/// The boxes that can cast on anything. A flat one cannot shade itself unless the light runs in its plane, and shades
/// nothing else where no other box reaches behind it.
pub(super) fn casting<'a>(view: &'a FocusedView, scene: &'a Scene) -> impl Iterator<Item = OrientedBox> + 'a {
    boxes(view, scene)
        .enumerate()
        .filter(|(i, b)| {
            let Some(behind) = behind(view, b) else { return true };
            let reaches = |b: &OrientedBox| b.range(behind).1 > 0.0;
            let scene_reaches = view.scene_box.corners().iter().any(|p| behind.dot(p.extend(1.0)) > 0.0);
            scene_reaches && boxes(view, scene).enumerate().any(|(j, other)| j != *i && reaches(&other))
        })
        .map(|(_, b)| b)
}

/// A functional that is positive behind a flat box as the light sees it; nothing for a box with a volume, or one without an
/// area, or one in whose plane the light lies.
fn behind(view: &FocusedView, b: &OrientedBox) -> Option<DVec4> {
    let thin = b.half.iter().position(|h| *h == DVec3::ZERO)?;
    let normal = b.half[(thin + 1) % 3].cross(b.half[(thin + 2) % 3]).try_normalize()?;
    let plane = normal.extend(-normal.dot(b.center));
    let light = view.rays.point;
    let height = plane.dot(light);
    // Half of the digits: a light nearer to the plane than that runs in it.
    let least = f64::EPSILON.sqrt() * (light.truncate() - b.center * light.w).length();
    (height.abs() > least).then(|| if height > 0.0 { -plane } else { plane })
}

/// The rectangle in which casters lie in or above receivers: `receivers` is theirs, with their far depth. Nothing where no
/// caster is.
pub(super) fn casters_extent(rows: &Rows, receivers: &Aabb, view: &FocusedView, scene: &Scene) -> Option<Aabb> {
    let mut planes: Vec<Plane> = Vec::with_capacity(6);
    planes.extend(sides(rows, receivers, view).iter().flatten().filter_map(|side| Plane::where_positive(*side)));
    planes.extend(Plane::where_positive(rows.w * receivers.max.z - rows.z));
    let mut found = Aabb::EMPTY;
    for instance in casting(view, scene) {
        let mut body = ConvexBody::from_oriented_box(&instance);
        planes.iter().for_each(|plane| body.clip(plane));
        found = body.vertices().iter().fold(found, |b, p| b.with_point(rows.project(*p)));
    }
    (!found.is_empty()).then_some(found)
}

/// Functionals that are not negative above a rectangle, and beyond a spot's near plane.
pub(super) fn sides(rows: &Rows, extent: &Aabb, view: &FocusedView) -> [Option<DVec4>; 5] {
    let (low, high) = (extent.min, extent.max);
    [
        Some(rows.x - rows.w * low.x),
        Some(rows.w * high.x - rows.x),
        Some(rows.y - rows.w * low.y),
        Some(rows.w * high.y - rows.y),
        view.light_planes().map(|planes| -planes[4].functional()),
    ]
}

/// Smallest NDC z of the boxes wherever they are, cut only where w is below its least above a rectangle.
pub(super) fn nearest_anywhere(rows: &Rows, map: &Aabb, view: &FocusedView, scene: &Scene) -> Option<f64> {
    let floor = least_w(rows, map, view).and_then(|least| Plane::where_positive(rows.w - DVec4::W * least));
    let near_plane = view.light_planes().map(|planes| planes[4]);
    let mut nearest = f64::INFINITY;
    for instance in boxes(view, scene) {
        let mut body = ConvexBody::from_oriented_box(&instance);
        floor.iter().chain(&near_plane).for_each(|plane| body.clip(plane));
        nearest = body.vertices().iter().fold(nearest, |z, p| z.min(rows.project(*p).z));
    }
    nearest.is_finite().then_some(nearest)
}

/// The smallest w above a rectangle; nothing where that is not known.
///
/// On the light's rays 1 (directional) or the depth from the light (spot, at least its near plane's) is a combination
/// `a x + b y + c w` of the map's rows, so over w it is largest at a corner of the rectangle.
fn least_w(rows: &Rows, map: &Aabb, view: &FocusedView) -> Option<f64> {
    let p = view.receivers.vertex_mean();
    let frame = LightFrame::any(view.rays.direction_at(p)?);
    let (unit, floor) = match view.spot() {
        Some(spot) => (spot.depth(), spot.frustum.near),
        None => (DVec4::W, 1.0),
    };
    let probes = [frame.right.extend(0.0), frame.up.extend(0.0), p.extend(1.0)];
    let of = |row: DVec4| DVec3::from_array(probes.map(|v| row.dot(v)));
    let combination = DMat3::from_cols(of(rows.x), of(rows.y), of(rows.w)).inverse() * of(unit);
    let at = |x: f64, y: f64| combination.dot(DVec3::new(x, y, 1.0));
    let [(x0, y0), (x1, y1)] = [map.min, map.max].map(|p| (p.x, p.y));
    let largest = [at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1)].into_iter().fold(0.0, f64::max);
    // A little less: where w hardly varies, its least is a plane in space by rounding alone.
    Some((1.0 - f64::EPSILON.sqrt()) * floor / largest).filter(|w| w.is_finite() && *w > 0.0)
}

/// The published step of XPSM: the box of the corners of instances with w >= `least_w`, NDC; nothing without such a corner.
pub(super) fn corners_extent(rows: &Rows, least_w: f64, view: &FocusedView, scene: &Scene) -> Option<Aabb> {
    let corners = boxes(view, scene).flat_map(|b| b.corners());
    let kept = corners.filter(|p| rows.w.dot(p.extend(1.0)) >= least_w);
    let found = Aabb::from_points(kept.map(|p| rows.project(p)));
    (!found.is_empty()).then_some(found)
}
