//! Depth maps held against rays in f64: for every texel the least and the largest depth that a right map may have there.
//!
//! A texel's light ray meets a triangle where the centre's homogeneous coordinates in its corners (x, y, w) are not negative
//! (Olano, Greer 1997 `[olano1997]`): no division, so corners behind the
//! projection centre are corners as others. The one freedom is the renderers' grid of 1/256 texel: a centre nearer to an
//! outline than that may or may not be covered.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};
use rayon::prelude::*;
use shadowlab::Scene;

/// How far the grid can move an outline, texels: half a step along both axes, and as much again for rounding to f32 before.
pub const SNAPPING: f64 = std::f64::consts::SQRT_2 / 256.0;
/// Roundings of a depth below 1 in f32: vertices, slopes, sums.
pub const DEPTH_ROUNDING: f64 = 16.0 * f32::EPSILON as f64;
/// Roundings of a clip coordinate in f64, relative to its largest term.
const PROJECTION: f64 = 8.0 * f64::EPSILON;
/// Depths closer than this are told apart by nobody.
const SHARP: f64 = 1e-4;

/// What a right map may hold at a texel.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Of what may cover the centre, the nearest.
    pub low: f64,
    /// Of what certainly covers it, the nearest.
    pub high: f64,
}

impl Bounds {
    /// Whether there is one answer.
    pub fn is_sharp(&self) -> bool {
        self.high - self.low <= SHARP
    }
}

/// A triangle's homogeneous coordinates over the map.
struct Triangle {
    /// Rows: coordinate k of the centre (texel x, texel y, 1), positive inside.
    coordinates: [DVec3; 3],
    /// Lengths of the gradients of those.
    steepness: [f64; 3],
    /// NDC depth as a functional of (texel x, texel y, 1).
    depth: DVec3,
    /// 1 / w as such a functional, times what rounding in f64 makes of a clip coordinate.
    rounding: DVec3,
    /// Least and largest NDC depth of what is in front of the projection centre.
    range: [f64; 2],
    /// Width in texels of the part over the map, if the whole triangle is before the projection centre.
    width: f64,
    /// Texels in a unit of NDC.
    texels: f64,
}

impl Triangle {
    fn new(clip: [DVec4; 3], largest_term: f64, size: [u32; 2]) -> Option<Self> {
        let [width, height] = size.map(f64::from);
        // Corners in homogeneous texel coordinates, each brought to a size of 1: a positive factor moves nothing.
        let corners = clip.map(|c| {
            let p = DVec3::new(0.5 * width * (c.x + c.w), 0.5 * height * (c.w - c.y), c.w);
            let scale = p.abs().max_element();
            (p / scale, c.z / scale, scale)
        });
        if corners.iter().any(|(p, z, _)| !p.is_finite() || !z.is_finite()) {
            return None;
        }
        let m = DMat3::from_cols(corners[0].0, corners[1].0, corners[2].0);
        let inverse = m.inverse();
        if m.determinant() == 0.0 || !inverse.is_finite() {
            return None;
        }
        let coordinates = [inverse.row(0), inverse.row(1), inverse.row(2)];
        let depth: DVec3 = (0..3).map(|k| coordinates[k] * corners[k].1).sum();
        let rounding: DVec3 = (0..3).map(|k| coordinates[k] * (PROJECTION * largest_term / corners[k].2)).sum();
        let in_front = clip.iter().all(|c| c.w > 0.0);
        let depths = clip.map(|c| if c.w > 0.0 { c.z / c.w } else { f64::NAN });
        let range = if in_front {
            [
                depths.iter().fold(f64::INFINITY, |m, &z| m.min(z)),
                depths.iter().fold(f64::NEG_INFINITY, |m, &z| m.max(z)),
            ]
        } else {
            [0.0, 1.0]
        };
        let steepness = coordinates.map(|c| c.truncate().length());
        let thinnest = if in_front {
            let p = clip.map(|c| DVec2::new(0.5 * width * (c.x / c.w), 0.5 * height * (c.y / c.w)));
            let area = (p[1] - p[0]).perp_dot(p[2] - p[0]).abs();
            area / (0..3).map(|k| (p[k] - p[(k + 1) % 3]).length()).fold(0.0, f64::max)
        } else {
            f64::INFINITY
        };
        Some(Self { coordinates, steepness, depth, rounding, range, width: thinnest, texels: 0.5 * width.max(height) })
    }

    /// Adds what this triangle says of a texel.
    fn narrow(&self, centre: DVec3, bounds: &mut Bounds) {
        let mut certain = true;
        let rounding = self.rounding.dot(centre).abs();
        let snapping = SNAPPING + self.texels * rounding;
        for k in 0..3 {
            let distance = self.coordinates[k].dot(centre) / self.steepness[k];
            if distance < -snapping {
                return;
            }
            certain &= distance > snapping;
        }
        let z = self.depth.dot(centre);
        let gradient = self.depth.truncate().length();
        // Thinner than a texel the plane of depth is as good as its corners.
        let (low, high) = if self.width < 1.0 || !certain {
            let reach = 2.0 * SNAPPING * gradient + rounding + DEPTH_ROUNDING;
            if self.width < 1.0 {
                (self.range[0].min(z - reach), self.range[1].max(z + reach))
            } else {
                (z - reach, z + reach)
            }
        } else {
            let reach = 0.5 * SNAPPING * gradient + rounding + DEPTH_ROUNDING;
            (z - reach, z + reach)
        };
        // Cut off where before near or beyond far.
        if high < 0.0 || low > 1.0 {
            return;
        }
        bounds.low = bounds.low.min(low.max(0.0));
        if certain && low >= 0.0 && high < 1.0 {
            bounds.high = bounds.high.min(high);
        }
    }
}

/// The bounds of every texel.
pub fn bounds(scene: &Scene, clip_from_world: &DMat4, size: [u32; 2]) -> Vec<Bounds> {
    let mut triangles = vec![];
    for instance in 0..scene.instances().len() {
        let clip_from_local = scene.clip_from_local(clip_from_world, instance);
        let mesh = scene.mesh_of(instance);
        let at = |i: u32| clip_from_local * mesh.positions_local()[i as usize].as_dvec3().extend(1.0);
        let matrix = clip_from_local.to_cols_array();
        let terms = |i: u32| {
            let p = mesh.positions_local()[i as usize].as_dvec3().extend(1.0).abs();
            matrix.iter().enumerate().map(|(k, m)| m.abs() * p[k / 4]).fold(0.0, f64::max)
        };
        let largest_term = |t: &[u32; 3]| t.iter().map(|&i| terms(i)).fold(0.0, f64::max);
        let new = |t: &[u32; 3]| Triangle::new(t.map(at), largest_term(t), size);
        triangles.extend(mesh.triangles().iter().filter_map(new));
    }
    let mut all = vec![Bounds { low: 1.0, high: 1.0 }; size[0] as usize * size[1] as usize];
    all.par_chunks_mut(size[0] as usize).enumerate().for_each(|(y, row)| {
        for (x, bounds) in row.iter_mut().enumerate() {
            let centre = DVec3::new(x as f64 + 0.5, y as f64 + 0.5, 1.0);
            triangles.iter().for_each(|t| t.narrow(centre, bounds));
        }
    });
    all
}

/// What came of a comparison.
#[derive(Debug, Default)]
pub struct Verdict {
    pub texels: usize,
    /// With one answer.
    pub sharp: usize,
    /// That certainly show something.
    pub covered: usize,
    /// Nearer than anything, or farther than what certainly is there: index, depth, bounds.
    pub wrong: Vec<(usize, f32, Bounds)>,
}

pub fn judge(map: &[f32], bounds: &[Bounds]) -> Verdict {
    assert_eq!(map.len(), bounds.len());
    let is_right = |z: f32, b: &Bounds| (b.low - DEPTH_ROUNDING..=b.high + DEPTH_ROUNDING).contains(&f64::from(z));
    Verdict {
        texels: map.len(),
        sharp: bounds.iter().filter(|b| b.is_sharp()).count(),
        covered: bounds.iter().filter(|b| b.high < 1.0).count(),
        wrong: map
            .iter()
            .zip(bounds)
            .enumerate()
            .filter(|(_, (z, b))| !is_right(**z, b))
            .map(|(i, (&z, &b))| (i, z, b))
            .collect(),
    }
}
