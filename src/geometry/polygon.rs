//! Convex polygons of the plane: the hull of points, and its part on one side of a line.
//!
//! Source: Andrew's monotone chain `[andrew1979]`; the clip is that of Sutherland and Hodgman 1974 `[sutherland1974]`.

use glam::{DVec2, DVec3};

/// Replaces points by the corners of their convex hull, counter-clockwise; one or two points where all are one or on a line.
/// `room` is memory to work in.
pub fn convex_hull(points: &mut Vec<DVec2>, room: &mut Vec<DVec2>) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return;
    }
    room.clear();
    chain(points.iter().copied(), room, 0);
    room.pop();
    let kept = room.len();
    chain(points.iter().rev().copied(), room, kept);
    room.pop();
    std::mem::swap(points, room);
}

/// One half of a hull of sorted points, behind the first `kept` of those that are there.
fn chain(points: impl Iterator<Item = DVec2>, hull: &mut Vec<DVec2>, kept: usize) {
    for p in points {
        while hull.len() >= kept + 2 {
            let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
            if (b - a).perp_dot(p - b) > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(p);
    }
}

/// The part of a convex polygon where `functional · (p, 1)` is not negative; a point or a segment is a polygon, too.
pub fn clipped(polygon: &[DVec2], functional: DVec3) -> Vec<DVec2> {
    let height = |p: DVec2| functional.dot(p.extend(1.0));
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (from, to) = (height(p), height(next));
        if from >= 0.0 {
            kept.push(p);
        }
        // A segment has one side, which is gone along twice.
        if (from >= 0.0) != (to >= 0.0) && !(polygon.len() == 2 && i == 1) {
            kept.push(p.lerp(next, from / (from - to)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull(points: &[DVec2]) -> Vec<DVec2> {
        let (mut points, mut room) = (points.to_vec(), Vec::new());
        convex_hull(&mut points, &mut room);
        points
    }

    #[test]
    fn a_hull_has_the_corners_of_its_points_counter_clockwise() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE, DVec2::splat(0.5), DVec2::new(0.5, 0.0)];
        assert_eq!(hull(&square), [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]);
        assert_eq!(hull(&[DVec2::ONE, DVec2::ONE]), [DVec2::ONE]);
        assert_eq!(hull(&[DVec2::splat(2.0), DVec2::ZERO, DVec2::ONE]), [DVec2::ZERO, DVec2::splat(2.0)]);
        assert!(hull(&[]).is_empty());
    }

    #[test]
    fn a_line_cuts_polygons_segments_and_points() {
        let left_of_half = DVec3::new(-1.0, 0.0, 0.5);
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        assert_eq!(clipped(&square, left_of_half), [DVec2::ZERO, DVec2::new(0.5, 0.0), DVec2::new(0.5, 1.0), DVec2::Y]);
        assert_eq!(clipped(&square[..2], left_of_half), [DVec2::ZERO, DVec2::new(0.5, 0.0)]);
        assert_eq!(clipped(&[DVec2::ZERO], left_of_half), [DVec2::ZERO]);
        assert!(clipped(&[DVec2::X], left_of_half).is_empty());
        assert!(clipped(&square, DVec3::new(-1.0, 0.0, -0.5)).is_empty());
    }
}
