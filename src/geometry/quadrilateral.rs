//! The plane homography that four points fix.
//!
//! Source: the projective basis theorem (Hartley and Zisserman, `[hartley2004]`, 2.2.1), solved by the lines through
//! pairs of points instead of a linear system: no pivots, and parallel sides are no special case.

use glam::{DMat3, DVec2, DVec3};

/// `square_from_plane`, acting on columns (x, y, 1): the homography that takes the corners of a convex quadrilateral, in
/// order, to (-1, -1), (1, -1), (1, 1), (-1, 1); w = 1 at the mean of the corners and w > 0 inside. Nothing where three corners
/// lie on a line or the quadrilateral is not convex.
///
/// # Examples
/// ```
/// use glam::DVec2;
/// use shadowlab::geometry::square_from_quadrilateral;
/// let trapezoid = [[-3.0, 5.0], [3.0, 5.0], [1.0, 0.0], [-1.0, 0.0]].map(DVec2::from);
/// let h = square_from_quadrilateral(&trapezoid).expect("convex");
/// let image = h * DVec2::new(1.0, 0.0).extend(1.0);
/// assert!((image.truncate() / image.z - DVec2::ONE).length() < 1e-14);
/// ```
pub fn square_from_quadrilateral(corners: &[DVec2; 4]) -> Option<DMat3> {
    // Relative to the mean, so that a quadrilateral far from the origin loses no digits.
    let mean = corners.iter().sum::<DVec2>() / 4.0;
    let [p0, p1, p2, p3] = corners.map(|p| (p - mean).extend(1.0));
    // Lines through pairs of corners: each is 0 on two, and its value on another is twice the area of their triangle.
    let lines = [p1.cross(p2), p2.cross(p0), p0.cross(p1)];
    let at_p3 = lines.map(|line| line.dot(p3));
    let winding = lines[0].dot(p0);
    // Convex: seen from the line p2 p0, p3 lies across from p1; from the other two, on the side of the third corner.
    let convex = [at_p3[0], -at_p3[1], at_p3[2]].iter().all(|area| area * winding > 0.0);
    // Derived from f64: twice the area that rounding of the corners alone can make.
    let size = corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let widest = corners.iter().map(|p| (*p - mean).length()).fold(0.0, f64::max);
    let least = 8.0 * f64::EPSILON * size * widest;
    if !convex || winding.abs() <= least || at_p3.iter().any(|area| area.abs() <= least) {
        return None;
    }
    // (-1, 1) is (-1, -1) - (1, -1) + (1, 1), so these weights take p3 there.
    let targets = [DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, 1.0)];
    let weights = [at_p3[0].recip(), -at_p3[1].recip(), at_p3[2].recip()];
    let row = |i: usize| (0..3).map(|k| lines[k] * (targets[k][i] * weights[k])).sum::<DVec3>();
    let rows = [row(0), row(1), row(2)].map(|r| r / row(2).z);
    let moved = rows.map(|r| DVec3::new(r.x, r.y, r.z - r.truncate().dot(mean)));
    Some(DMat3::from_cols(moved[0], moved[1], moved[2]).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(h: &DMat3, p: DVec2) -> DVec2 {
        let q = *h * p.extend(1.0);
        q.truncate() / q.z
    }

    #[test]
    fn corners_go_to_corners_either_way_round_and_far_away() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(DVec2::from);
        let cases = [
            [[0.0, 0.0], [4.0, 1.0], [3.0, 3.0], [-1.0, 2.0]],
            [[0.0, 0.0], [-1.0, 2.0], [3.0, 3.0], [4.0, 1.0]],
            [[-2.0, 7.0], [2.0, 7.0], [2.0, 3.0], [-2.0, 3.0]],
            [[-2.0, 7.0], [2.0, 7.0], [1e-3, 0.0], [-1e-3, 0.0]],
        ];
        // A rounding of the corners' coordinates is 1e3 times as large in the map of the narrow top, and w is 1e3 times smaller.
        for (shift, tolerance) in [(0.0, 1e-12), (1e4, 1e-6)] {
            for case in cases {
                let corners = case.map(|p| DVec2::from(p) + DVec2::splat(shift));
                let h = square_from_quadrilateral(&corners).expect("convex");
                for (p, expected) in corners.iter().zip(square) {
                    let (w, q) = ((h * p.extend(1.0)).z, image(&h, *p));
                    assert!(w > 0.0 && (q - expected).length() < tolerance, "{case:?} + {shift}: {q}");
                }
                let mean = corners.iter().sum::<DVec2>() / 4.0;
                assert!(((h * mean.extend(1.0)).z - 1.0).abs() < tolerance);
            }
        }
    }

    #[test]
    fn what_has_no_homography_is_nothing() {
        let bad = [
            [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]],
            [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]],
            [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            [[3.0, 3.0]; 4],
            [[0.1, 0.3], [0.2, 0.6], [0.3, 0.9], [0.4, 1.2]],
        ];
        for corners in bad {
            assert!(square_from_quadrilateral(&corners.map(DVec2::from)).is_none(), "{corners:?}");
        }
    }
}
