//! Where the rays that go on to a body enter a box: the near end of what can cast on it, without making that body.
//!
//! Source: theory.md (1.3). A ray through y enters by the side across axis k at l · y + (b_k - y_k) / l_k along l, and the box
//! at the largest of the three; the least of these over the body is the optimum of a linear programme with two unknowns.

use glam::DVec3;

use super::{ConvexBody, MAX_VERTICES, Set};
use crate::geometry::Aabb;

impl ConvexBody {
    /// The least of `direction · p` over the points p of `bounds` from which a ray along `direction` (unit) meets the body, which
    /// lies in `bounds` (1.3); infinity for an empty body.
    pub fn least_entry(&self, direction: DVec3, bounds: &Aabb) -> f64 {
        let nearest = DVec3::select(direction.cmpgt(DVec3::ZERO), bounds.min, bounds.max);
        // A side that a ray through the whole box leaves by no more than rounding is along the light.
        let length = 2.0 * bounds.diagonal();
        let counts = [0, 1, 2].map(|k: usize| direction[k].abs() * length > self.tolerance(nearest[k]));
        if self.is_empty() || counts == [false; 3] {
            return self.range(direction.extend(0.0)).0;
        }
        let corner = direction.dot(nearest);
        if counts == [true; 3] && self.is_met(nearest, direction) {
            // No point of the box is nearer.
            return corner;
        }
        let entry = Entry {
            direction,
            nearest: nearest.to_array(),
            per_unit: [0, 1, 2].map(|k: usize| if counts[k] { direction[k].recip() } else { 0.0 }),
            none: counts.map(|counts| if counts { 0.0 } else { f64::NEG_INFINITY }),
        };
        let mut least = f64::INFINITY;
        let mut places = [([0.0; 3], 0_u8); MAX_VERTICES];
        for (p, place) in self.vertices().iter().zip(&mut places) {
            let sides = entry.sides(*p);
            let last = last_of(&sides);
            *place = (sides, last);
            least = least.min(sides[last as usize % 3]);
        }
        for e in &self.edges[..self.edge_count] {
            let [(a, last_a), (b, last_b)] = [e.from, e.to].map(|i| &places[i as usize % MAX_VERTICES]);
            // No place between is less than the largest of the lesser ends.
            let none_below = (0..3).fold(f64::NEG_INFINITY, |most, k| most.max(a[k].min(b[k])));
            if last_a != last_b && none_below < least {
                least = least.min(least_between(a, b));
            }
        }
        least
    }
    /// Whether the line through a point meets the body, up to rounding.
    fn is_met(&self, p: DVec3, direction: DVec3) -> bool {
        let (mut first, mut last, mut known) = (f64::NEG_INFINITY, f64::INFINITY, Set(0));
        for e in &self.edges[..self.edge_count] {
            for face in [e.left, e.right] {
                if known.has(face) {
                    continue;
                }
                known.add(face);
                let normal = self.normals[face as usize];
                let (outside, rate) = (normal.dot(p - self.vertices[e.from as usize]), normal.dot(direction));
                if rate > 0.0 {
                    last = last.min(-outside / rate);
                } else if rate < 0.0 {
                    first = first.max(-outside / rate);
                } else if outside > self.tolerance(0.0) {
                    return false;
                }
            }
        }
        first <= last + self.tolerance(0.0)
    }
}

/// The sides of a box that rays along a direction enter by.
struct Entry {
    direction: DVec3,
    /// The box's corner that is least along the direction: the places of these sides.
    nearest: [f64; 3],
    /// Way along a ray per way along each axis; 0 for an axis that rays do not move along.
    per_unit: [f64; 3],
    /// Minus infinity for such an axis, else 0.
    none: [f64; 3],
}

impl Entry {
    /// Where the ray through a point of the box enters it by each side, along the direction: the box itself at the largest.
    #[inline(always)]
    fn sides(&self, p: DVec3) -> [f64; 3] {
        let at = self.direction.dot(p);
        let p = p.to_array();
        // Points on a side may be beyond it by rounding.
        std::array::from_fn(|k| at - ((p[k] - self.nearest[k]) * self.per_unit[k]).max(0.0) + self.none[k])
    }
}

/// Which of three numbers is the largest.
#[inline(always)]
fn last_of(x: &[f64; 3]) -> u8 {
    let first = u8::from(x[1] > x[0]);
    if x[2] > x[first as usize] { 2 } else { first }
}

/// The least of the largest numbers between two points, them aside, where two are equal. Infinity where there is no such place.
fn least_between(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let mut least = f64::INFINITY;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let (d_a, d_b) = (a[i] - a[j], b[i] - b[j]);
        if (d_a > 0.0) != (d_b > 0.0) && d_a.is_finite() && d_b.is_finite() {
            let t = d_a / (d_a - d_b);
            let at = |k: usize| a[k] + (b[k] - a[k]) * t;
            // The third may be no number, where rays do not enter by it.
            least = least.min(at(i).max(at(j)).max(at(3 - i - j)));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::super::tests::unit_box;
    use super::*;
    use crate::geometry::Plane;

    /// Rounding of sums of numbers of size one, a few cuts deep.
    const TINY: f64 = 1e-13;

    #[test]
    fn rays_into_a_part_of_a_box_enter_where_the_swept_part_ends() {
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let [mut by_corner, mut by_edge, mut by_vertex] = [0; 3];
        for i in 0..2000 {
            // Points of a low-discrepancy sequence (Roberts 2018).
            let at = |k: usize| {
                let place = (DVec3::new(0.8192, 0.6711, 0.5497) * (7 * i + k) as f64).fract();
                (place - 0.5, place)
            };
            let mut body = unit_box();
            for k in 0..4 {
                let normal = at(k).0.normalize();
                body.clip(&Plane::through(at(k + 4).1, normal));
            }
            let direction = if i % 10 == 0 { DVec3::new(0.6, 0.0, -0.8) } else { at(6).0.normalize() };
            if body.is_empty() {
                assert_eq!(body.least_entry(direction, &bounds), f64::INFINITY);
                continue;
            }
            let mut swept = body.swept_against(direction, 2.0 * bounds.diagonal());
            for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                swept.clip(&Plane { normal: -axis, offset: bounds.min[k] });
                swept.clip(&Plane { normal: axis, offset: -bounds.max[k] });
            }
            let (made, found) = (swept.range(direction.extend(0.0)).0, body.least_entry(direction, &bounds));
            assert!((made - found).abs() < TINY, "{i}: {made} {found}");
            let corner = direction.dot(DVec3::select(direction.cmpgt(DVec3::ZERO), bounds.min, bounds.max));
            let own = body.vertices().iter().map(|p| {
                let t = (*p - DVec3::select(direction.cmpgt(DVec3::ZERO), bounds.min, bounds.max)) / direction;
                direction.dot(*p) - t.min_element()
            });
            let own = own.fold(f64::INFINITY, f64::min);
            match () {
                () if (found - corner).abs() < TINY => by_corner += 1,
                () if (found - own).abs() < TINY => by_vertex += 1,
                () => by_edge += 1,
            }
        }
        assert!(by_corner > 100 && by_edge > 100 && by_vertex > 100, "{by_corner} {by_edge} {by_vertex}");
    }

    #[test]
    fn a_flat_part_on_a_side_is_entered_where_it_is() {
        let bounds = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let roof = ConvexBody::from_aabb(&Aabb { min: DVec3::Y, max: DVec3::ONE });
        let down = DVec3::new(0.3, -0.9, 0.1).normalize();
        assert!((roof.least_entry(down, &bounds) - roof.range(down.extend(0.0)).0).abs() < TINY);
        // Along the floor, rays enter by the side across them.
        let floor = ConvexBody::from_aabb(&Aabb { min: DVec3::new(0.5, 0.0, 0.5), max: DVec3::new(0.75, 0.0, 0.75) });
        assert_eq!(floor.least_entry(DVec3::X, &bounds), 0.0);
    }
}
