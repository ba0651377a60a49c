//! What of a box lies above a rectangle of a map, and how near to the light.
//!
//! Source: theory.md 1.3. The box is cut in space by the four side planes of the rectangle, so nothing is divided by a w that
//! is not positive. Only the least depth is wanted. A depth z / w is a linear-fractional function of position, so it is least
//! at a vertex of what the cut leaves: a corner of the box, an edge where a side cuts it, or a ray through a corner of the
//! rectangle where it meets the box. These are looked at one by one; the cut body is made only for a placed light, whose near
//! plane cuts as well.

use std::ops::ControlFlow;

use glam::{DAffine3, DVec3, DVec4};

use super::tightening::sides;
use crate::focus::FocusedView;
use crate::geometry::{Aabb, ConvexBody, OrientedBox, Plane, Rows};
use crate::scene::{Met, Scene};

/// A vertex this many units in the last place of a side's terms outside of it lies on it. Derived from the error bounds of the
/// side at a corner of a box (8 roundings), and of a place between two (4).
const ON_SIDE_ULPS: f64 = 16.0;

/// Corners of a box, one bit each, at which edges along each axis begin; corner bits as in [`OrientedBox::corners`].
const BEGINS: [u8; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];

/// Smallest NDC z of the instances' boxes above the rectangle of `extent`; nothing where no box is.
pub fn nearest_caster(provisional: &Rows, extent: &Aabb, view: &FocusedView, scene: &Scene) -> Option<f64> {
    let above = Above::new(provisional, extent, view);
    let mut nearest = None;
    let _ = scene.visit(|met| {
        ControlFlow::Continue(match met {
            Met::Group(bounds) => above.may_be_nearer(&OrientedBox::around(bounds, view.origin), nearest),
            Met::One(i) => {
                let instance = scene.box_of(i, view.origin);
                let may = above.may_be_nearer(&instance, nearest);
                if may {
                    nearest = above.nearer(&instance, nearest);
                }
                may
            }
        })
    });
    nearest.filter(|z| z.is_finite())
}

/// Smallest NDC z of some boxes above the rectangle of `extent`.
pub(super) fn nearest_of(
    rows: &Rows,
    extent: &Aabb,
    view: &FocusedView,
    casters: impl Iterator<Item = OrientedBox>,
) -> Option<f64> {
    let above = Above::new(rows, extent, view);
    let mut nearest = None;
    for instance in casters {
        if above.may_be_nearer(&instance, nearest) {
            nearest = above.nearer(&instance, nearest);
        }
    }
    nearest.filter(|z| z.is_finite())
}

/// An axis-aligned box as an oriented one.
pub(super) fn box_of(bounds: &Aabb) -> OrientedBox {
    OrientedBox::new(bounds, &DAffine3::IDENTITY, DVec3::ZERO)
}

/// What lies above a rectangle of a map.
struct Above<'a> {
    rows: &'a Rows,
    sides: [Option<DVec4>; 5],
}

impl<'a> Above<'a> {
    fn new(rows: &'a Rows, extent: &Aabb, view: &FocusedView) -> Self {
        Self { rows, sides: sides(rows, extent, view) }
    }
    /// Whether anything in a box may lie above the rectangle and nearer to the light than the nearest so far.
    fn may_be_nearer(&self, b: &OrientedBox, nearest: Option<f64>) -> bool {
        // Positive for a point (w > 0) nearer to the light than what was found.
        let is_nearer = nearest.is_none_or(|z| !(b.range(self.rows.w * z - self.rows.z).1 <= 0.0));
        is_nearer && !self.sides.iter().flatten().any(|side| b.range(*side).1 < 0.0)
    }
    /// The nearest so far, of a box as well.
    fn nearer(&self, b: &OrientedBox, nearest: Option<f64>) -> Option<f64> {
        let of_box = match self.sides {
            [Some(left), Some(right), Some(bottom), Some(top), None] => {
                least_depth(b, self.rows, &[left, right, bottom, top])
            }
            _ => self.least_depth_cut(b),
        };
        match (of_box, nearest) {
            (Some(z), Some(n)) => Some(n.min(z)),
            (z, n) => z.or(n),
        }
    }
    /// The least NDC z of what all sides leave of a box.
    fn least_depth_cut(&self, b: &OrientedBox) -> Option<f64> {
        let mut body = ConvexBody::from_oriented_box(b);
        self.sides.iter().flatten().filter_map(|side| Plane::where_positive(*side)).for_each(|plane| body.clip(&plane));
        let depths = body.vertices().iter().map(|p| self.rows.project(*p).z);
        depths.fold(None, |nearest, z| Some(nearest.map_or(z, |n: f64| n.min(z))))
    }
}

/// The least NDC z of the part of a box where no side of a rectangle (left, right, bottom, top) is negative; nothing where no
/// part is.
fn least_depth(b: &OrientedBox, rows: &Rows, sides: &[DVec4; 4]) -> Option<f64> {
    let in_box = sides.map(|side| InBox::of(side, b));
    let least = in_box.map(|side| -ON_SIDE_ULPS * f64::EPSILON * side.terms);
    let (z, w) = (InBox::of(rows.z, b), InBox::of(rows.w, b));
    let (z_at, w_at) = (z.at_corners(), w.at_corners());
    let at = in_box.map(|side| side.at_corners());
    let beyond: [u8; 4] =
        std::array::from_fn(|s| at[s].iter().enumerate().fold(0, |set, (i, d)| set | u8::from(*d < least[s]) << i));
    if beyond.contains(&u8::MAX) {
        return None;
    }
    let mut found = Least { least: None, least_w: ON_SIDE_ULPS * f64::EPSILON * w.terms };
    let outside = beyond.iter().fold(0, |all, set| all | set);
    for i in (0..8).filter(|i| outside >> i & 1 == 0) {
        found.add(z_at[i], w_at[i]);
    }
    for s in (0..4).filter(|s| beyond[*s] != 0) {
        for (axis, begins) in BEGINS.into_iter().enumerate() {
            let mut cut = (beyond[s] ^ beyond[s] >> (1 << axis)) & begins;
            while cut != 0 {
                let a = cut.trailing_zeros() as usize % 8;
                let b = (a + (1 << axis)) % 8;
                cut &= cut - 1;
                let t = at[s][a] / (at[s][a] - at[s][b]);
                let between = |at: &[f64; 8]| at[a] + (at[b] - at[a]) * t;
                if (0..4).all(|other| other == s || between(&at[other]) >= least[other]) {
                    found.add(between(&z_at), between(&w_at));
                }
            }
        }
    }
    // A ray through a corner of the rectangle meets no box that one of its two sides does not cut.
    for (across, along) in [(0, 2), (0, 3), (1, 2), (1, 3)] {
        if beyond[across] != 0 && beyond[along] != 0 {
            for u in in_box[across].meets(&in_box[along]).into_iter().flatten() {
                found.add(z.at(u), w.at(u));
            }
        }
    }
    found.least
}

/// The least of some depths z / w.
struct Least {
    least: Option<f64>,
    /// What is no more than this is 0 by rounding.
    least_w: f64,
}

impl Least {
    /// Also of a place. The line through a corner of the rectangle may lie where w is negative: no ray of the map goes there.
    fn add(&mut self, z: f64, w: f64) {
        if w > self.least_w {
            self.least = Some(self.least.map_or(z / w, |least| least.min(z / w)));
        }
    }
}

/// A functional of position in the coordinates of a box, -1 to 1 along each half axis.
#[derive(Debug, Clone, Copy)]
struct InBox {
    slope: DVec3,
    middle: f64,
    /// The sum of the sizes of what is added for a value: what roundings are a share of.
    terms: f64,
}

impl InBox {
    fn of(f: DVec4, b: &OrientedBox) -> Self {
        let direction = f.truncate();
        let slope = DVec3::from_array(b.half.map(|half| direction.dot(half)));
        let middle = direction.dot(b.center) + f.w;
        let terms = (direction * b.center).abs().element_sum() + f.w.abs() + slope.abs().element_sum();
        Self { slope, middle, terms }
    }
    fn at(&self, u: DVec3) -> f64 {
        self.slope.dot(u) + self.middle
    }
    fn at_corners(&self) -> [f64; 8] {
        let signed = |i: usize, k: usize| if i >> k & 1 == 1 { self.slope[k] } else { -self.slope[k] };
        std::array::from_fn(|i| self.middle + signed(i, 0) + signed(i, 1) + signed(i, 2))
    }
    /// Where the line on which this and another functional are 0 enters the box and leaves it.
    fn meets(&self, other: &Self) -> Option<[DVec3; 2]> {
        let along = self.slope.cross(other.slope);
        let square = along.length_squared();
        if !(square > 0.0) {
            return None;
        }
        let on_line = (other.slope.cross(along) * -self.middle + along.cross(self.slope) * -other.middle) / square;
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let ends = [-1.0, 1.0].map(|end| (end - on_line[k]) / along[k]);
            // A line along a pair of sides divides by 0: both ends are infinite, of one sign where it lies outside.
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        (first <= last).then(|| [on_line + along * first, on_line + along * last])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of both ways, as a share of depths of size one.
    const CLOSE: f64 = 1e-9;

    /// Numbers in [-1, 1] of a low-discrepancy sequence (Roberts 2018).
    fn spread(i: usize, k: usize) -> DVec3 {
        (DVec3::new(0.8192, 0.6711, 0.5497) * (11 * i + k) as f64).fract() * 2.0 - 1.0
    }

    #[test]
    fn the_least_depth_is_that_of_the_cut_body() {
        let [mut whole, mut cut, mut aside] = [0; 3];
        for i in 0..3000 {
            let at = |k| spread(i, k);
            let half = [at(0), at(1), at(2) * if i % 7 == 0 { 0.0 } else { 1.0 }].map(|half| half * 0.6);
            let b = OrientedBox { center: at(3), half };
            let light = at(4).normalize();
            let (x, y) = light.any_orthonormal_pair();
            // A perspective across the light, as warps have it; w may be negative on part of the box.
            let w = (x * at(5).x * 3.0 + y * at(5).y * 3.0).extend(1.0);
            let rows = Rows { x: x.extend(0.1), y: y.extend(-0.2), z: light.extend(0.0), w };
            let room = if i % 5 == 0 { 4.0 } else { 0.0 };
            let (low, high) = (at(6).min(at(7)) - room, at(6).max(at(7)) + room);
            let sides = [rows.x - w * low.x, w * high.x - rows.x, rows.y - w * low.y, w * high.y - rows.y];
            let above =
                Above { rows: &rows, sides: [Some(sides[0]), Some(sides[1]), Some(sides[2]), Some(sides[3]), None] };
            let (found, made) = (above.nearer(&b, None), above.least_depth_cut(&b));
            match (found, made) {
                (Some(found), Some(made)) => {
                    let error = (found - made).abs() / made.abs().max(1.0);
                    assert!(error < CLOSE, "{i}: {found} {made}");
                    let is_whole = b.corners().iter().all(|p| sides.iter().all(|s| s.dot(p.extend(1.0)) > 0.0));
                    if is_whole { whole += 1 } else { cut += 1 }
                }
                (None, None) => aside += 1,
                _ => panic!("{i}: {found:?} {made:?}"),
            }
            assert_eq!(above.nearer(&b, Some(f64::NEG_INFINITY)), Some(f64::NEG_INFINITY));
        }
        assert!(whole > 20 && cut > 500 && aside > 500, "{whole} {cut} {aside}");
    }
}
