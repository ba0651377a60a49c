//! A triangle that stands between the light and receivers, and the extent of its shadow.
//!
//! ```text
//!      light          The planes through the light and an edge bound the shadow's volume: a point lies in it where it is
//!      / | \          inside of all three. The distance from a plane is affine along any line, so where a line leaves the
//!     /__|__\ caster  shadow is exact, and takes no ray.
//!    /   |   \
//!   ~~~~~~~~~~~ receiver
//! ```
//! The distances are in the ratio of the barycentric coordinates of what the light meets on the way to the point, so that they
//! give its texture coordinates, too, where the triangle has an alpha test. Its shadow then also ends at holes, which are found
//! by halving.

use glam::{DVec2, DVec3, DVec4};

use super::rays::Met;
use crate::scene::AlphaTest;

/// Looks for a hole, per texel of an alpha test along the way, and most of them.
const LOOKS_PER_TEXEL: f64 = 2.0;
const MOST_LOOKS: f64 = 256.0;
/// Halvings of the way between two looks, after which the edge of a hole is known.
const HALVINGS: usize = 24;

/// A triangle that shades.
#[derive(Debug, Clone, Copy)]
pub(super) struct Caster<'a> {
    /// Its corners, relative to the origin.
    pub corners: [DVec3; 3],
    /// The instance and the row of its face array.
    pub face: (i32, i32),
    /// The instance and the triangle of its mesh.
    pub triangle: (i32, i32),
    /// Of each edge, from one corner to the next, the plane through the light, inside positive: normal and distance.
    sides: [(DVec3, f64); 3],
    /// Of any length.
    normal: DVec3,
    /// Its alpha test, and the texture coordinates of its corners.
    test: Option<(&'a AlphaTest, [DVec2; 3])>,
}

impl<'a> Caster<'a> {
    /// What was met, with its corners and its alpha test, under a light (unit vector to it, 0) or (position, 1).
    pub fn new(met: &Met, corners: [DVec3; 3], test: Option<(&'a AlphaTest, [DVec2; 3])>, light: DVec4) -> Self {
        let side = |k: usize| {
            let (a, b, opposite) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let normal = (b - a).cross(light.truncate() - light.w * a);
            let normal = if normal.dot(opposite - a) < 0.0 { -normal } else { normal };
            (normal, normal.dot(a))
        };
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let triangle = (met.face.0, met.triangle);
        Self { corners, face: met.face, triangle, sides: [side(0), side(1), side(2)], normal, test }
    }

    /// Whether the ray through a point meets it.
    pub fn shades(&self, point: DVec3) -> bool {
        self.sides.iter().all(|(normal, distance)| normal.dot(point) >= *distance) && self.exists(point)
    }

    /// Whether what the light meets of its plane on the way to a point exists.
    fn exists(&self, point: DVec3) -> bool {
        let Some((test, _)) = self.test else { return true };
        self.coordinates(point).is_none_or(|uv| test.exists(uv))
    }

    /// The texture coordinates of that; nothing where the triangle is seen edge on.
    fn coordinates(&self, point: DVec3) -> Option<DVec2> {
        let (_, corners) = self.test?;
        let (mut sum, mut uv) = (0.0, DVec2::ZERO);
        for (k, (normal, distance)) in self.sides.iter().enumerate() {
            let opposite = (k + 2) % 3;
            let share = (normal.dot(point) - distance) / (normal.dot(self.corners[opposite]) - distance);
            (sum, uv) = (sum + share, uv + share * corners[opposite]);
        }
        Some(uv / sum).filter(|uv| uv.is_finite())
    }

    /// Where a line that is in the shadow of the triangle first meets the light of a hole in it, between two places on it.
    pub fn hole(&self, from: DVec3, way: DVec3, [begin, end]: [f64; 2]) -> Option<f64> {
        let (test, _) = self.test?;
        let at = |t: f64| from + t * way;
        let size = test.parts().texture.as_ref()?.size().map(f64::from);
        let across = (self.coordinates(at(end))? - self.coordinates(at(begin))?).abs();
        let looks = (LOOKS_PER_TEXEL * (across * DVec2::from(size)).max_element()).ceil().clamp(1.0, MOST_LOOKS);
        let place = |k: usize| begin + (end - begin) * (k as f64 / looks);
        let first = (0..=looks as usize).find(|&k| !self.exists(at(place(k))))?;
        let (mut dark, mut light) = (place(first.saturating_sub(1)), place(first));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (dark + light);
            if self.exists(at(middle)) { dark = middle } else { light = middle }
        }
        Some(light)
    }

    /// How far before a point its plane is, along a vector to the light: not finite where that is seen edge on.
    pub fn height(&self, point: DVec3, to_light: DVec3) -> f64 {
        self.normal.dot(self.corners[0] - point) / self.normal.dot(to_light)
    }

    /// What light meets on the ray through a point that it shades.
    pub fn seen_from(&self, point: DVec3, to_light: DVec3) -> Met {
        let height = self.height(point, to_light);
        Met { height, at: point + height * to_light, face: self.face, triangle: self.triangle.1 }
    }

    /// Where a line from a point leaves the shadow, in units of its direction, and across which edge; 0 where it begins outside.
    pub fn exit(&self, from: DVec3, way: DVec3) -> (f64, usize) {
        let mut first = (f64::INFINITY, 0);
        for (k, (normal, distance)) in self.sides.iter().enumerate() {
            let fall = -normal.dot(way);
            let left = (normal.dot(from) - distance) / fall;
            if fall > 0.0 && left < first.0 {
                first = (left, k);
            }
        }
        (first.0.max(0.0), first.1)
    }

    /// Where a line on a receiver's plane goes below its own, in units of its direction, later than a part of it; infinity where
    /// it does not.
    pub fn sinks(&self, from: DVec3, way: DVec3, after: f64) -> f64 {
        let t = self.normal.dot(self.corners[0] - from) / self.normal.dot(way);
        if t > after { t } else { f64::INFINITY }
    }

    /// The ends of an edge.
    pub fn edge(&self, k: usize) -> [DVec3; 2] {
        [self.corners[k], self.corners[(k + 1) % 3]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AlphaTestParts, AlphaTexture, Wrap};

    fn roof(light: DVec4) -> Caster<'static> {
        let met = Met { face: (0, 0), triangle: 0, ..Met::NOTHING };
        Caster::new(
            &met,
            [DVec3::new(0.0, 2.0, 0.0), DVec3::new(2.0, 2.0, 0.0), DVec3::new(0.0, 2.0, 2.0)],
            None,
            light,
        )
    }

    #[test]
    fn a_shadow_ends_where_its_edge_falls() {
        let sun = roof(DVec4::new(0.0, 1.0, 0.0, 0.0));
        let lamp = roof(DVec4::new(0.0, 4.0, 0.0, 1.0));
        let inside = DVec3::new(0.5, 0.0, 0.5);
        assert!(sun.shades(inside) && lamp.shades(inside));
        assert!(!sun.shades(DVec3::new(1.5, 0.0, 1.5)) && lamp.shades(DVec3::new(1.5, 0.0, 1.5)));
        assert_eq!(sun.exit(inside, DVec3::X), (1.0, 1));
        // A lamp at twice the roof's height doubles it.
        assert_eq!(lamp.exit(inside, DVec3::X), (3.0, 1));
        assert_eq!(lamp.exit(inside, DVec3::NEG_X), (0.5, 2));
        assert_eq!(sun.height(inside, DVec3::Y), 2.0);
        assert_eq!(sun.edge(1), [DVec3::new(2.0, 2.0, 0.0), DVec3::new(0.0, 2.0, 2.0)]);
        assert_eq!(sun.exit(DVec3::new(3.0, 0.0, 0.0), DVec3::X).0, 0.0);
    }

    #[test]
    fn a_shadow_ends_at_holes() {
        // Four columns along x, of which the first and the third are there: holes begin at x = 1/2 and end at 1, and so on.
        let texture = AlphaTexture::new([4, 1], vec![255, 0, 255, 0]).unwrap();
        let uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let parts = AlphaTestParts {
            texture: Some(texture.into()),
            uv: uv.to_vec(),
            cutoff: 0.5,
            wrap: [Wrap::Clamp; 2],
            factor: 1.0,
        };
        let test = AlphaTest::new(parts).unwrap();
        let met = Met { face: (0, 0), triangle: 0, ..Met::NOTHING };
        let corners = [DVec3::new(0.0, 2.0, 0.0), DVec3::new(2.0, 2.0, 0.0), DVec3::new(0.0, 2.0, 2.0)];
        let coordinates = Some((&test, test.corners([0, 1, 2])));
        let sun = Caster::new(&met, corners, coordinates, DVec4::new(0.0, 1.0, 0.0, 0.0));
        let lamp = Caster::new(&met, corners, coordinates, DVec4::new(0.0, 4.0, 0.0, 1.0));
        let at = |x: f64| DVec3::new(x, 0.0, 0.1);
        assert!(sun.shades(at(0.4)) && !sun.shades(at(0.6)) && sun.shades(at(1.2)) && !sun.shades(at(1.7)));
        // A lamp at twice the roof's height doubles everything.
        assert!(lamp.shades(at(0.8)) && !lamp.shades(at(1.2)) && lamp.shades(at(2.4)));
        let hole = |caster: &Caster, from: f64, part: [f64; 2]| caster.hole(at(from), DVec3::X, part);
        assert!((hole(&sun, 0.2, [0.0, 1.7]).unwrap() - 0.3).abs() < 1e-6);
        assert!((hole(&lamp, 0.2, [0.0, 3.0]).unwrap() - 0.8).abs() < 1e-6);
        assert!((hole(&sun, 1.2, [0.0, 0.6]).unwrap() - 0.3).abs() < 1e-6);
        assert_eq!(hole(&sun, 0.2, [0.0, 0.25]), None);
        assert_eq!(hole(&sun, 0.6, [0.0, 0.1]), Some(0.0));
        assert_eq!(roof(DVec4::Y).hole(at(0.2), DVec3::X, [0.0, 1.7]), None);
    }

    #[test]
    fn a_ramp_sinks_below_the_floor_that_it_stands_in() {
        let met = Met { face: (0, 0), triangle: 0, ..Met::NOTHING };
        let corners = [DVec3::new(0.0, 1.0, -1.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(2.0, -1.0, 0.0)];
        let ramp = Caster::new(&met, corners, None, DVec4::new(0.0, 1.0, 0.0, 0.0));
        assert!((ramp.sinks(DVec3::ZERO, DVec3::X, 0.0) - 1.0).abs() < 1e-12);
        assert_eq!(ramp.sinks(DVec3::ZERO, DVec3::NEG_X, 0.0), f64::INFINITY);
        assert_eq!(ramp.sinks(DVec3::ZERO, DVec3::Z, 0.0), f64::INFINITY);
    }
}
