//! A small kit for closed meshes: everything is a skin drawn over a sequence of rings.
//!
//! ```text
//!   ring 2   ___          A ring runs counter-clockwise as seen from the end of the sequence. Neighbouring rings are
//!   ring 1  /___\         joined by quads; a ring of one point is a pole; an open end is capped by a fan. The result is
//!   ring 0 /_____\        closed and faces outwards, whatever the rings are: lathe, sphere, tube, beam, arch, cloth.
//! ```
//! Closed casters have a back side for every front side, which truth and techniques may rely on. Numbers of vertices and
//! triangles depend on whole numbers only, never on a floating-point result.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use crate::error::Result;
use crate::scene::Mesh;

/// Vertices and triangles under construction, metres.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    vertices: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
}

impl Shape {
    /// Closed skin over rings that have equally many points each, or one (a pole, at the ends only).
    pub(super) fn skin(rings: &[Vec<DVec3>]) -> Self {
        let width = rings.iter().map(Vec::len).max().unwrap_or(0);
        debug_assert!(rings.len() >= 2 && width >= 3);
        debug_assert!(
            rings
                .iter()
                .enumerate()
                .all(|(k, r)| { r.len() == width || (r.len() == 1 && (k == 0 || k + 1 == rings.len())) })
        );
        let mut shape = Self::default();
        let mut starts = Vec::with_capacity(rings.len());
        for ring in rings {
            starts.push(shape.vertices.len());
            shape.vertices.extend_from_slice(ring);
        }
        let next = |j: usize| (j + 1) % width;
        for k in 1..rings.len() {
            let (low, high) = (starts[k - 1], starts[k]);
            for j in 0..width {
                match (rings[k - 1].len() == 1, rings[k].len() == 1) {
                    (false, false) => {
                        shape.faces.push([low + j, low + next(j), high + next(j)]);
                        shape.faces.push([low + j, high + next(j), high + j]);
                    }
                    (true, _) => shape.faces.push([low, high + next(j), high + j]),
                    (_, true) => shape.faces.push([low + j, low + next(j), high]),
                }
            }
        }
        let (first, last) = (&rings[0], &rings[rings.len() - 1]);
        if first.len() > 1 {
            let center = shape.push_vertex(mean(first));
            (0..width).for_each(|j| shape.faces.push([center, next(j), j]));
        }
        if last.len() > 1 {
            let (start, center) = (starts[rings.len() - 1], shape.push_vertex(mean(last)));
            (0..width).for_each(|j| shape.faces.push([center, start + j, start + next(j)]));
        }
        shape
    }
    /// Surface of revolution about the y axis: `profile` holds [radius, height] from the bottom end to the top end and may
    /// turn back inside (bowls).
    pub(super) fn lathe(profile: &[[f64; 2]], segments: usize) -> Self {
        Self::lathe_modulated(profile, segments, |_, _| 1.0)
    }
    /// As [`Shape::lathe`], the radius multiplied by `factor(turn, height)` with `turn` in [0, 1) around the axis.
    pub(super) fn lathe_modulated(profile: &[[f64; 2]], segments: usize, factor: impl Fn(f64, f64) -> f64) -> Self {
        let last = profile.len() - 1;
        let ring = |(k, &[radius, height]): (usize, &[f64; 2])| {
            if radius == 0.0 && (k == 0 || k == last) {
                return vec![DVec3::new(0.0, height, 0.0)];
            }
            circle(segments)
                .map(|(turn, c)| {
                    let r = radius * factor(turn, height);
                    DVec3::new(r * c.x, height, -r * c.y)
                })
                .collect()
        };
        Self::skin(&profile.iter().enumerate().map(ring).collect::<Vec<_>>())
    }
    /// Upright cylinder that stands on y = 0.
    pub(super) fn cylinder(radius: f64, height: f64, segments: usize) -> Self {
        Self::lathe(&[[radius, 0.0], [radius, height]], segments)
    }
    /// Upright cone that stands on y = 0.
    pub(super) fn cone(radius: f64, height: f64, segments: usize) -> Self {
        Self::lathe(&[[radius, 0.0], [0.0, height]], segments)
    }
    /// Ellipsoid about a center.
    pub(super) fn ellipsoid(center: DVec3, radii: DVec3, segments: usize, rings: usize) -> Self {
        let profile: Vec<[f64; 2]> = (0..=rings)
            .map(|k| match k {
                0 => [0.0, -1.0],
                k if k == rings => [0.0, 1.0],
                k => {
                    let (sin, cos) = (0.5 * TAU * k as f64 / rings as f64).sin_cos();
                    [sin, -cos]
                }
            })
            .collect();
        Self::lathe(&profile, segments).mapped(|p| center + p * radii)
    }
    /// Box between two corners.
    pub(super) fn cuboid(min: DVec3, max: DVec3) -> Self {
        let mut shape = Self::default();
        for i in 0..8 {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            shape.vertices.push(DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z)));
        }
        for [a, b, c, d] in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            shape.faces.extend([[a, b, c], [a, c, d]]);
        }
        shape
    }
    /// Box of a size whose bottom face is centered on the origin.
    pub(super) fn block(size: DVec3) -> Self {
        let half = DVec3::new(0.5 * size.x, 0.0, 0.5 * size.z);
        Self::cuboid(-half, half + DVec3::Y * size.y)
    }
    /// As [`Shape::block`], all edges cut off by `cut`.
    pub(super) fn chamfered_block(size: DVec3, cut: f64) -> Self {
        let ring = |shrink: f64, height: f64| {
            let (x, z) = (0.5 * size.x - shrink, 0.5 * size.z - shrink);
            let corner = |x: f64, z: f64| DVec3::new(x, height, z);
            vec![
                corner(x, z - cut),
                corner(x, cut - z),
                corner(x - cut, -z),
                corner(cut - x, -z),
                corner(-x, cut - z),
                corner(-x, z - cut),
                corner(cut - x, z),
                corner(x - cut, z),
            ]
        };
        Self::skin(&[ring(cut, 0.0), ring(0.0, cut), ring(0.0, size.y - cut), ring(cut, size.y)])
    }
    /// Tube along a path of (point, radius), capped; a radius of 0 at an end makes a tip.
    pub(super) fn tube(path: &[(DVec3, f64)], segments: usize) -> Self {
        let last = path.len() - 1;
        let mut normal: Option<DVec3> = None;
        let rings: Vec<Vec<DVec3>> = (0..=last)
            .map(|k| {
                let (center, radius) = path[k];
                let along = (path[(k + 1).min(last)].0 - path[k.saturating_sub(1)].0).normalize();
                // Parallel transport: the frame of the ring before, turned no more than the path turns.
                let start = normal.unwrap_or_else(|| along.any_orthogonal_vector());
                let across = (start - along * start.dot(along)).normalize();
                normal = Some(across);
                if radius == 0.0 && (k == 0 || k == last) {
                    return vec![center];
                }
                let side = along.cross(across);
                circle(segments).map(|(_, c)| center + (across * c.x + side * c.y) * radius).collect()
            })
            .collect();
        Self::skin(&rings)
    }
    /// Square beam between two points, `width` wide and `height` high (measured across its own run), not twisted.
    pub(super) fn beam(from: DVec3, to: DVec3, width: f64, height: f64) -> Self {
        let along = (to - from).normalize();
        let side = if along.cross(DVec3::Y).length() < 0.5 { along.cross(DVec3::Z) } else { along.cross(DVec3::Y) };
        let side = side.normalize();
        let (s, u) = (side * (0.5 * width), along.cross(side) * (0.5 * height));
        Self::skin(&[from, to].map(|p| vec![p - s - u, p + s - u, p + s + u, p - s + u]))
    }
    /// Plate between a lower and an upper curve in the xy plane (equally many points, x growing), from z0 to z1 > z0:
    /// arches, gables, waves.
    pub(super) fn plate(lower: &[DVec2], upper: &[DVec2], z0: f64, z1: f64) -> Self {
        let rings: Vec<Vec<DVec3>> = lower
            .iter()
            .zip(upper)
            .map(|(low, high)| vec![low.extend(z1), low.extend(z0), high.extend(z0), high.extend(z1)])
            .collect();
        Self::skin(&rings)
    }
    /// The shape with every vertex moved by a map that keeps orientation.
    pub(super) fn mapped(mut self, map: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|p| *p = map(*p));
        self
    }
    /// The shape moved.
    pub(super) fn moved(self, by: DVec3) -> Self {
        self.mapped(|p| p + by)
    }
    /// The shape under an affine map; a mirror image is turned outside in again.
    pub(super) fn placed(self, map: &DAffine3) -> Self {
        let mirrored = map.matrix3.determinant() < 0.0;
        let mut shape = self.mapped(|p| map.transform_point3(p));
        if mirrored {
            shape.faces.iter_mut().for_each(|f| f.swap(1, 2));
        }
        shape
    }
    /// Both shapes as one.
    pub(super) fn with(mut self, other: Self) -> Self {
        self.add(other);
        self
    }
    /// Adds another shape to this one.
    pub(super) fn add(&mut self, other: Self) {
        let offset = self.vertices.len();
        self.vertices.extend(other.vertices);
        self.faces.extend(other.faces.iter().map(|f| f.map(|i| i + offset)));
    }
    /// The mesh.
    pub(super) fn mesh(&self) -> Result<Mesh> {
        let vertices: Vec<[f64; 3]> = self.vertices.iter().map(|p| p.to_array()).collect();
        let faces: Vec<[i64; 3]> = self.faces.iter().map(|f| f.map(|i| i as i64)).collect();
        Mesh::new(&vertices, &faces)
    }
    /// Adds a vertex and returns its index.
    pub(super) fn push_vertex(&mut self, p: DVec3) -> usize {
        self.vertices.push(p);
        self.vertices.len() - 1
    }
    /// Adds a triangle, counter-clockwise as seen from outside.
    pub(super) fn push_face(&mut self, face: [usize; 3]) {
        self.faces.push(face);
    }
}

/// (turn, point) of points on the unit circle, turn in [0, 1).
pub(super) fn circle(segments: usize) -> impl Iterator<Item = (f64, DVec2)> {
    (0..segments).map(move |j| {
        let turn = j as f64 / segments as f64;
        (turn, DVec2::from_angle(TAU * turn))
    })
}

/// `steps` rows for each interval of a table: a cubic through all rows that never overshoots: tangents of at most three times
/// the gentler slope keep every column monotone between rows (`[fritsch1980]`).
pub(super) fn smoothed<const N: usize>(rows: &[[f64; N]], steps: usize) -> Vec<[f64; N]> {
    let last = rows.len() - 1;
    // Half the sum of the slopes on both sides, at most three times the gentler one, 0 at a turning point.
    let tangent = |k: usize, n: usize| {
        let before = rows[k][n] - rows[k.saturating_sub(1)][n];
        let after = rows[(k + 1).min(last)][n] - rows[k][n];
        let limit = 3.0 * before.abs().min(after.abs());
        if before * after <= 0.0 { 0.0 } else { (0.5 * (before + after)).clamp(-limit, limit) }
    };
    let mut curve = Vec::with_capacity(last * steps + 1);
    for k in 0..last {
        for step in 0..steps {
            let t = step as f64 / steps as f64;
            let (t2, t3) = (t * t, t * t * t);
            curve.push(std::array::from_fn(|n| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * rows[k][n]
                    + (t3 - 2.0 * t2 + t) * tangent(k, n)
                    + (3.0 * t2 - 2.0 * t3) * rows[k + 1][n]
                    + (t3 - t2) * tangent(k + 1, n)
            }));
        }
    }
    curve.push(rows[last]);
    curve
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len() as f64
}

/// A closed ring about the y axis: `section` holds [radius, height], counter-clockwise with the radius to the right.
pub(super) fn ring(section: &[[f64; 2]], segments: usize) -> Shape {
    let mut shape = Shape::default();
    let count = section.len();
    for (_, c) in circle(segments) {
        for &[radius, height] in section {
            shape.push_vertex(DVec3::new(radius * c.x, height, -radius * c.y));
        }
    }
    for j in 0..segments {
        for k in 0..count {
            let (low, high) = (k, (k + 1) % count);
            let (here, next) = (j * count, (j + 1) % segments * count);
            shape.push_face([here + low, next + low, next + high]);
            shape.push_face([here + low, next + high, here + high]);
        }
    }
    shape
}
