//! Comparison of two depth maps of one scene, with a reason for every texel that differs.
//!
//! Both renderers may snap vertices to a grid of 1/256 texel, each in its own rounding, and that is the only freedom granted
//! beside the rounding of f32. A texel that differs is explained by a triangle whose outline passes its centre within that
//! snapping (edge), by a triangle thinner than a texel there (thin), by one so nearly edge-on that its depth changes by
//! the difference over the rounding of its projected vertices (steep), or by a sliver under two texels wide whose plane tilts
//! by the difference when its vertices move within that snapping, where one of the two maps is right to a tenth of the
//! tolerance (tilted; a device may interpolate between the snapped vertices). Everything is decided in f64 from the scene and
//! the matrix.

use glam::{DMat4, DVec2, DVec4};
use rayon::prelude::*;
use shadowlab::Scene;

/// Depths closer than this agree; 84 units in the last place of a float near 1.
pub const DEPTH_TOLERANCE: f32 = 1e-5;
/// A depth this near to the exact one is right.
const EXACT: f64 = 1e-6;
/// Texels of a map that may differ, explained or not: 0.01 %.
pub const DIFFERING_SHARE: f64 = 1e-4;
/// Steps of the sub-pixel grid along both axes by which two roundings of a vertex can differ.
const SNAPPING: f64 = std::f64::consts::SQRT_2 / 256.0;
/// Roundings of clip coordinates in f32, relative to a map's width: a product of four terms and a quotient in each renderer.
const PROJECTION: f64 = 16.0 * f32::EPSILON as f64;

/// Where two maps differ.
#[derive(Debug)]
pub struct Difference {
    pub texels: usize,
    /// Explained by an outline.
    pub edge: usize,
    /// Explained by a triangle thinner than a texel.
    pub thin: usize,
    /// Explained by a triangle seen nearly edge-on.
    pub steep: usize,
    /// Explained by a sliver whose plane the snapping tilts; one of the two maps is right.
    pub tilted: usize,
    /// None of these: index and the two depths.
    pub unexplained: Vec<(usize, f32, f32)>,
}

impl Difference {
    pub fn count(&self) -> usize {
        self.edge + self.thin + self.steep + self.tilted + self.unexplained.len()
    }

    pub fn share(&self) -> f64 {
        self.count() as f64 / self.texels as f64
    }

    /// Panics unless few enough texels differ and each has its reason.
    pub fn assert_small(&self, what: &str) {
        assert!(
            self.unexplained.is_empty(),
            "{what}: {} texels without reason: {:?}",
            self.unexplained.len(),
            self.unexplained
        );
        assert!(self.share() <= DIFFERING_SHARE, "{what}: {:.6} % differ", 100.0 * self.share());
    }
}

#[derive(Clone, Copy, Default, PartialEq)]
struct Reasons {
    edge: bool,
    thin: bool,
    steep: bool,
    tilted: bool,
}

/// A texel that differs: its index, the two depths.
type Differing = (usize, [f64; 2]);

impl Reasons {
    fn or(self, other: Self) -> Self {
        Self {
            edge: self.edge | other.edge,
            thin: self.thin | other.thin,
            steep: self.steep | other.steep,
            tilted: self.tilted | other.tilted,
        }
    }
}

/// Compares two maps of `size` texels.
pub fn compare(scene: &Scene, clip_from_world: &DMat4, size: [u32; 2], a: &[f32], b: &[f32]) -> Difference {
    let texels = size[0] as usize * size[1] as usize;
    assert_eq!((a.len(), b.len()), (texels, texels));
    let apart = |i: usize| f64::from(a[i] - b[i]).abs();
    // A NaN is a difference, whatever it is compared with.
    let agrees = |i: usize| apart(i) <= f64::from(DEPTH_TOLERANCE);
    let differing: Vec<Differing> =
        (0..texels).filter(|&i| !agrees(i)).map(|i| (i, [f64::from(a[i]), f64::from(b[i])])).collect();
    let reasons = (0..scene.instances().len())
        .into_par_iter()
        .fold(
            || vec![Reasons::default(); differing.len()],
            |mut reasons, instance| {
                explain(scene, instance, clip_from_world, size, &differing, &mut reasons);
                reasons
            },
        )
        .reduce(
            || vec![Reasons::default(); differing.len()],
            |a, b| a.into_iter().zip(b).map(|(a, b)| a.or(b)).collect(),
        );
    let edge = reasons.iter().filter(|r| r.edge).count();
    let thin = reasons.iter().filter(|r| r.thin && !r.edge).count();
    let steep = reasons.iter().filter(|r| r.steep && !r.thin && !r.edge).count();
    let none = differing.iter().zip(&reasons).filter(|(_, r)| **r == Reasons::default());
    let tilted = reasons.iter().filter(|r| r.tilted && !r.steep && !r.thin && !r.edge).count();
    Difference { texels, edge, thin, steep, tilted, unexplained: none.map(|(&(i, _), _)| (i, a[i], b[i])).collect() }
}

fn explain(
    scene: &Scene,
    instance: usize,
    clip_from_world: &DMat4,
    size: [u32; 2],
    differing: &[Differing],
    reasons: &mut [Reasons],
) {
    if differing.is_empty() {
        return;
    }
    let clip_from_local = scene.clip_from_local(clip_from_world, instance);
    let mesh = scene.mesh_of(instance);
    let clips: Vec<DVec4> = mesh.positions_local().iter().map(|p| clip_from_local * p.as_dvec3().extend(1.0)).collect();
    let size_f = DVec2::new(size[0].into(), size[1].into());
    for triangle in mesh.triangles() {
        let mut polygon: Vec<DVec4> = triangle.iter().map(|&i| clips[i as usize]).collect();
        for plane in [DVec4::Z, DVec4::new(0.0, 0.0, -1.0, 1.0)] {
            polygon = clipped(&polygon, plane);
        }
        if polygon.len() < 3 {
            continue;
        }
        let texel: Vec<DVec2> = polygon.iter().map(|c| (DVec2::new(c.x, -c.y) / c.w * 0.5 + 0.5) * size_f).collect();
        let (min, max) = texel.iter().fold((texel[0], texel[0]), |(min, max), &p| (min.min(p), max.max(p)));
        if !(min.is_finite() && max.is_finite()) || max.x < -1.0 || max.y < -1.0 || min.cmpgt(size_f + 1.0).any() {
            continue;
        }
        // Corners are rounded relative to where they lie; new ones, where near or far cuts the triangle, relative to those
        // that they are interpolated from.
        let seen = min.abs().max(max.abs()).max_element();
        let least_w = polygon.iter().map(|c| c.w).fold(f64::INFINITY, f64::min);
        let uncut = triangle.iter().map(|&i| clips[i as usize].truncate().truncate().abs().max_element() / least_w);
        let place = uncut.fold(seen.max(size_f.max_element()), |m, ndc| m.max(0.5 * ndc * size_f.max_element()));
        let rounding = PROJECTION * place;
        let reach = SNAPPING + rounding;
        let first_row = (min.y - 1.0).max(0.0) as usize;
        let from = differing.partition_point(|&(i, _)| i / (size[0] as usize) < first_row);
        let depth: Vec<f64> = polygon.iter().map(|c| c.z / c.w).collect();
        let depth_gradient = gradient(&texel, &depth);
        let [shallowest, deepest] =
            depth.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], &d| [l.min(d), h.max(d)]);
        // A vertex that moves across a sliver tilts its plane by as much of the depth it spans.
        let width = thinnest(&texel);
        let tilt = if width < 2.0 { SNAPPING / width * (deepest - shallowest) } else { 0.0 };
        let thin = width < 1.0;
        for (&(index, depths), reason) in differing[from..].iter().zip(&mut reasons[from..]) {
            let (x, y) = (index % size[0] as usize, index / size[0] as usize);
            let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            if center.y > max.y + 1.0 {
                break;
            }
            if center.x < min.x - 1.0 || center.x > max.x + 1.0 {
                continue;
            }
            let to_edge = edges(&texel).map(|[p, q]| to_segment(center, p, q)).fold(f64::INFINITY, f64::min);
            reason.edge |= to_edge <= reach;
            reason.thin |= thin && to_edge <= 1.0;
            if is_inside(center, &texel) {
                let apart = (depths[0] - depths[1]).abs();
                reason.steep |= apart <= depth_gradient.length() * rounding;
                let exact = depth[0] + depth_gradient.dot(center - texel[0]);
                reason.tilted |= apart <= tilt && depths.iter().any(|d| (d - exact).abs() <= EXACT);
            }
        }
    }
}

fn edges(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    (0..polygon.len()).map(|k| [polygon[k], polygon[(k + 1) % polygon.len()]])
}

/// Whether a point is in a convex polygon of any orientation.
fn is_inside(p: DVec2, polygon: &[DVec2]) -> bool {
    let mut sides = edges(polygon).map(|[a, b]| (b - a).perp_dot(p - a));
    let first = sides.next().expect("a polygon has sides");
    sides.all(|side| side * first >= 0.0)
}

/// What a value that is affine on a polygon gains per unit of x and y; taken from its largest corner.
fn gradient(polygon: &[DVec2], value: &[f64]) -> DVec2 {
    let corner = |k: usize| {
        let (i, j) = ((k + 1) % polygon.len(), (k + 2) % polygon.len());
        let (u, v) = (polygon[i] - polygon[k], polygon[j] - polygon[k]);
        let (du, dv) = (value[i] - value[k], value[j] - value[k]);
        (u.perp_dot(v), DVec2::new(du * v.y - dv * u.y, dv * u.x - du * v.x))
    };
    let largest = (0..polygon.len()).map(corner).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).expect("corners");
    if largest.0 == 0.0 { DVec2::ZERO } else { largest.1 / largest.0 }
}

fn to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t =
        if along.length_squared() > 0.0 { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - t * along).length()
}

/// The smallest width of a convex polygon.
fn thinnest(polygon: &[DVec2]) -> f64 {
    let width = |[p, q]: [DVec2; 2]| {
        let across = (q - p).perp().normalize_or_zero();
        if across == DVec2::ZERO {
            return f64::INFINITY;
        }
        polygon.iter().map(|r| (r - p).dot(across).abs()).fold(0.0, f64::max)
    };
    edges(polygon).map(width).fold(f64::INFINITY, f64::min)
}

/// The part of a polygon with `plane . p >= 0`.
fn clipped(polygon: &[DVec4], plane: DVec4) -> Vec<DVec4> {
    let mut kept = Vec::new();
    for k in 0..polygon.len() {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let (dp, dq) = (plane.dot(p), plane.dot(q));
        if dp >= 0.0 {
            kept.push(p);
        }
        if (dp >= 0.0) != (dq >= 0.0) {
            kept.push(p + (q - p) * (dp / (dp - dq)));
        }
    }
    kept
}
