//! A convex hull that grows, and is asked far more often than it does so.

use glam::DVec2;

use crate::geometry::convex_hull;

/// Points that wait for the next hull, or as many as it has corners: the time stays linear where all are corners. Chosen because the
/// first hulls of a picture are small and leave much outside.
const MOST_WAITING: usize = 512;
/// Most sides of the polygon that boxes are held against. Chosen because hulls of pictures have 20 to 40 corners.
const SIDES: usize = 48;
/// Sides that are looked at together.
const LANES: usize = 4;

/// A hull that grows.
#[derive(Debug, Default)]
pub(super) struct Growing {
    /// The hull's corners, and behind them what waits.
    pub corners: Vec<DVec2>,
    settled: usize,
    sides: Vec<Sides>,
    /// Those that a box of [`Growing::look`] is not within, or all.
    open: Vec<Sides>,
    room: Vec<DVec2>,
}

/// [`LANES`] sides of a polygon in the hull, all of its corners or some: a box lies in it where no side's `x c.x + y c.y - off`,
/// of the box's corner c that is farthest out, is negative. Perspective crowds most pixels in one tip of the hull, so a grid
/// would be too coarse.
#[derive(Debug, Clone, Copy, Default)]
struct Sides {
    x: [f64; LANES],
    y: [f64; LANES],
    off: [f64; LANES],
}

impl Growing {
    #[inline(always)]
    pub fn add(&mut self, p: DVec2) {
        if p.is_finite() && !self.holds(p, p) {
            self.corners.push(p);
        }
        if self.corners.len() > self.settled + MOST_WAITING.max(self.settled) {
            self.settle();
        }
    }
    /// The hull of all that was added.
    pub fn settle(&mut self) {
        convex_hull(&mut self.corners, &mut self.room);
        self.settled = self.corners.len();
        self.find_sides();
    }
    /// Whether a box surely lies in the hull so far.
    #[inline(always)]
    pub fn holds(&self, low: DVec2, high: DVec2) -> bool {
        are_held_by(&self.sides, low, high)
    }
    /// The same of a box that lies in the one of the last [`Growing::look`].
    #[inline(always)]
    pub fn holds_seen(&self, low: DVec2, high: DVec2) -> bool {
        are_held_by(&self.open, low, high)
    }
    /// Which squares about points, `reach` to each side, may lie outside of the hull so far, as far as the sides of the last
    /// [`Growing::look`] tell.
    #[inline(always)]
    pub fn squares_beyond<const N: usize>(&self, x: &[f64; N], y: &[f64; N], reach: &[f64; N]) -> [bool; N] {
        let mut outside = [self.open.is_empty(); N];
        for side in &self.open {
            for k in 0..LANES {
                let across = side.x[k].abs() + side.y[k].abs();
                for i in 0..N {
                    let inside = side.x[k] * x[i] + side.y[k] * y[i] - side.off[k] - across * reach[i];
                    // Written so that a NaN is outside.
                    outside[i] |= !(inside >= 0.0);
                }
            }
        }
        outside
    }
    /// Looks for the sides beyond which a box may reach; false where it surely lies in the hull so far. Of a box without bounds
    /// it is all of them.
    #[inline(always)]
    pub fn look(&mut self, within: Option<[DVec2; 2]>) -> bool {
        self.open.clear();
        let Some([low, high]) = within else {
            self.open.extend_from_slice(&self.sides);
            return true;
        };
        for side in &self.sides {
            if !are_held_by(std::slice::from_ref(side), low, high) {
                self.open.push(*side);
            }
        }
        self.sides.is_empty() || !self.open.is_empty()
    }
    fn find_sides(&mut self) {
        let hull = &self.corners[..self.settled];
        let corners: Vec<DVec2> = hull.iter().step_by(hull.len().div_ceil(SIDES).max(1)).copied().collect();
        self.sides.clear();
        self.open.clear();
        if corners.len() < 3 {
            return;
        }
        // The last group repeats a side.
        for first in (0..corners.len()).step_by(LANES) {
            let mut sides = Sides::default();
            for lane in 0..LANES {
                let i = (first + lane).min(corners.len() - 1);
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                let inward = (b - a).perp();
                // Of both ends, and what the products may be off by.
                let rounding = 4.0 * f64::EPSILON * inward.abs().dot(a.abs().max(b.abs()));
                (sides.x[lane], sides.y[lane]) = inward.into();
                sides.off[lane] = inward.dot(a).max(inward.dot(b)) + rounding;
            }
            self.sides.push(sides);
        }
        self.open.clone_from(&self.sides);
    }
}

/// Whether a box lies on the inner side of some sides; of none it does not.
#[inline(always)]
fn are_held_by(sides: &[Sides], low: DVec2, high: DVec2) -> bool {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let mut outside = u64::from(sides.is_empty());
    for side in sides {
        for i in 0..LANES {
            let inside = side.x[i] * middle.x + side.y[i] * middle.y
                - side.off[i]
                - (side.x[i].abs() * half.x + side.y[i].abs() * half.y);
            // Written so that a NaN is outside.
            outside |= u64::from(!(inside >= 0.0));
        }
    }
    outside == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_held_where_all_of_their_corners_are() {
        for count in [12, 300] {
            let mut hull = Growing::default();
            let on_ellipse = |i: u32| DVec2::from_angle(f64::from(i)) * DVec2::new(3.0, 1e-3) + DVec2::new(100.0, -7.0);
            (0..count).map(on_ellipse).for_each(|p| hull.add(p));
            assert!(!hull.holds(DVec2::new(100.0, -7.0), DVec2::new(100.0, -7.0)), "nothing before it is settled");
            hull.settle();
            let is_inside = |p: DVec2| {
                let next = hull.corners.iter().cycle().skip(1);
                hull.corners.iter().zip(next).all(|(a, b)| (*b - *a).perp_dot(p - *a) >= 0.0)
            };
            let (mut held, mut all) = (0, 0);
            for i in 0..40 {
                for j in 0..40 {
                    let low = DVec2::new(96.5 + 0.2 * f64::from(i), -7.0012 + 6e-5 * f64::from(j));
                    let high = low + DVec2::new(0.1, 5e-5);
                    let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
                    let are_inside = corners.iter().all(|p| is_inside(*p));
                    assert!(are_inside || !hull.holds(low, high), "{low} {high}");
                    held += u32::from(hull.holds(low, high));
                    all += u32::from(are_inside);
                }
            }
            assert!(held <= all && held > 95 * all / 100 && all > 400, "{count}: {held} of {all}");
        }
    }
}
