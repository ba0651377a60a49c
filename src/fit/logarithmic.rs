//! The fit of a map whose texels are even in the logarithm of w: receivers, border and casters in that coordinate.
//!
//! Source: Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 `[lloyd2008]` (logarithmic perspective shadow maps);
//! theory.md 1.3 and 11. The receivers' ends lie one texel of the logarithmic map inside of y = ±1, and the matrix's
//! own y spans the same rays as the map, border included, so that what its clip volume leaves out is in no texel.
//!
//! ```text
//!   y of the matrix   -1 |.  receivers                                        .| 1     -Pn/w, evenly cut below
//!   y of the map      -1 |.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.|.| 1     ln w, evenly cut
//! ```

use super::map_size::MapSize;
use super::outlined::reaching;
use super::tightening::Tightening;
use super::unit_cube::{Fit, across, cut_to, fit, with_border, with_room};
use crate::focus::FocusedView;
use crate::geometry::{Aabb, Rows};
use crate::parameterization::PostWarp;
use crate::scene::Scene;

/// A map over whose receivers ln w varies less than this is its own logarithm. Derived from f64: the two differ by an eighth
/// of the range, and the rounding of w costs one part in 2^52 over it; this makes both one part in 2^26.
const LEAST_RANGE: f64 = 1.0 / (1_u64 << 26) as f64;

/// As [`fit`], for a map with a logarithm after it: receivers fill y, which is `scale * ln w + offset`, up to one border
/// of texels that are even in it. Without a logarithm where w hardly varies over the receivers.
///
/// `provisional` must have a w that is constant along light rays.
pub fn fit_logarithmic(
    provisional: &Rows,
    view: &FocusedView,
    scene: &Scene,
    size: &MapSize,
    tightening: Tightening,
) -> (Fit, PostWarp) {
    logarithm(provisional, view, scene, size, tightening)
        .unwrap_or_else(|| (fit(provisional, view, scene, size, tightening), PostWarp::None))
}

fn logarithm(
    provisional: &Rows,
    view: &FocusedView,
    scene: &Scene,
    size: &MapSize,
    tightening: Tightening,
) -> Option<(Fit, PostWarp)> {
    let (rows, reference) = reciprocal(provisional)?;
    let tight = across(&rows, view, scene, size, tightening);
    let receivers = with_room(&tight, &rows, view, size);
    // y is reference / w: its ends are those of w, and neither is 0.
    let [low, high] = [tight.min.y, tight.max.y];
    let axis = rows.w.truncate();
    let aside = view.rays.direction_at(view.receivers.vertex_mean())?.cross(axis).try_normalize()?;
    let (left, right) = view.receivers.range(aside.extend(0.0));
    let thickness = (reference / high - reference / low).abs() / axis.length();
    if thickness * size.texels().x < right - left {
        // Thinner along the axis than a texel is across it: the ordinary fit gives it room.
        return None;
    }
    // ln(w1 / w0) of (11.1), without cancellation where w hardly varies.
    let range = ((low - high) / high).ln_1p();
    if !(range.is_finite() && range.abs() > LEAST_RANGE) {
        return None;
    }
    let border = 0.5 * range * (size.inset().y.recip() - 1.0);
    let mut map: Aabb = with_border(&receivers, size);
    (map.min.y, map.max.y) = (low * border.exp(), high * (-border).exp());
    let map = reaching(&rows, map, view, size);
    let mut fitted = cut_to(&rows, &map, view, scene, tightening).canonical(view);
    // y in the middle of the map is 0 before the crop already: where w hardly varies, a constant over w is the difference of
    // far larger terms, which the product of the factors would leave the rounding of.
    fitted.provisional.y -= rows.w * (0.5 * (map.min.y + map.max.y));
    fitted.crop.w_axis.y = 0.0;
    // The fit leaves w alone but for its scale.
    let w_low = reference / low * (fitted.clip_from_local.w.truncate().length() / rows.w.truncate().length());
    let scale = 2.0 * size.inset().y / range;
    Some((fitted, PostWarp::Log { scale, offset: -scale * (w_low.ln() + 0.5 * range) }))
}

/// The same map with its y moved so that it is a constant over w, and that constant. Of a perspective along y this moves y by
/// a constant; a map whose y is anything else loses it, as the logarithm takes its place. Nothing where w is constant.
fn reciprocal(provisional: &Rows) -> Option<(Rows, f64)> {
    let Rows { y, w, .. } = *provisional;
    let (across, along) = (y.truncate(), w.truncate());
    let share = across.dot(along) / along.length_squared();
    let constant = y.w - share * w.w;
    let y = glam::DVec4::W * constant;
    (share.is_finite() && constant != 0.0 && constant.is_finite()).then_some((Rows { y, ..*provisional }, constant))
}
