//! Comparison of two footprints of one view, with a bound for every number of every pixel.
//!
//! A number may be off by [`ROUNDINGS`] times its *condition*: by how much roundings of what it is made of are magnified on the
//! way to it. All is taken in f64 from the scene, the camera and the map:
//!
//! - the corners of a triangle are rounded to the reach of its instance from the eye, so its plane is off by that, and the point
//!   that a pixel shows by that over the cosine it is seen under; the processor's G-buffer rounds a point relative to the
//!   scene's middle;
//! - the normal of a triangle is off by its longest side over its height;
//! - w, G_x, G_y and R (see footprint.wgsl) are sums: off by their terms over their value;
//! - steps on the surface are long where eye or light graze it, and what is left of them in the image may be short;
//! - eye and light that oppose each other leave little of the direction that halves their angle.

use std::ops::Range;

use glam::{DMat4, DVec3, DVec4};
use shadowlab::image::{Footprint, GBuffer};
use shadowlab::parameterization::PostWarp;

use crate::render::selection::maps::View;

/// Units of f32's last place for each unit of condition. Derived: no sum or product whose terms share a condition has more than
/// two roundings, half a unit each, and WGSL lets a quotient be off by 2.5.
pub const ROUNDINGS: f64 = 4.0;
/// Pixels that may ask another map, or be averted in one image alone: those on a border to a rounding.
pub const OTHER_MAP_SHARE: f64 = 2e-3;
/// What is compared, in the order of [`Agreement::deviations`].
pub const NAMES: [&str; 7] =
    ["jacobian", "major", "perspective", "perspective_t", "perspective_s", "projection", "depth"];

/// What a comparison found.
#[derive(Debug, Default)]
pub struct Agreement {
    /// Pixels of the same triangle.
    pub same: usize,
    /// Of these, those that a map serves in both images.
    pub served: usize,
    /// Of the same triangle, those with another map, or code.
    pub other_map: usize,
    /// Of these, those not on a border: pixel and both maps.
    pub unexplained: Vec<(usize, i16, i16)>,
    /// Relative deviations of what is served, in the order of [`NAMES`].
    pub deviations: [Vec<f64>; 7],
    /// The largest ratio of a deviation to its condition, in units of the last place.
    pub worst_roundings: [f64; 7],
    /// Numbers over their bound: pixel, name, deviation, bound.
    pub over: Vec<(usize, &'static str, f64, f64)>,
}

impl Agreement {
    /// Panics unless every number is within its bound and few pixels ask another map.
    pub fn assert_close(&self, what: &str) {
        let few = |n: usize| &self.over[..self.over.len().min(n)];
        assert!(self.over.is_empty(), "{what}: {} numbers over their bounds: {:?}", self.over.len(), few(5));
        let unexplained = &self.unexplained[..self.unexplained.len().min(5)];
        assert!(unexplained.is_empty(), "{what}: {} maps without reason: {unexplained:?}", self.unexplained.len());
        let share = self.other_map as f64 / self.same.max(1) as f64;
        assert!(share <= OTHER_MAP_SHARE, "{what}: {:.3} % ask another map", 100.0 * share);
    }

    /// The deviation that a share of the pixels stays within, of one of [`NAMES`].
    pub fn quantile(&self, k: usize, share: f64) -> f64 {
        let mut sorted = self.deviations[k].clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0)
    }

    /// One line for people.
    pub fn summary(&self) -> String {
        let parts = (0..NAMES.len()).map(|k| {
            let [half, most, worst] = [0.5, 0.999, 1.0].map(|share| self.quantile(k, share));
            format!("{} {half:.0e} {most:.0e} {worst:.0e} ({:.1})", NAMES[k], self.worst_roundings[k])
        });
        let parts: Vec<String> = parts.collect();
        format!(
            "{} of {} pixels served, {} ask another map; deviations, median 99.9 % worst (roundings): {}",
            self.served,
            self.same,
            self.other_map,
            parts.join(", ")
        )
    }
}

/// Compares two footprints where their G-buffers show the same triangles; points and normals are the second one's.
pub fn compare(v: &View, resolution: [u32; 2], [a, b]: [&Footprint; 2], [of_a, of_b]: [&GBuffer; 2]) -> Agreement {
    assert_eq!((a.size, b.size), (of_a.size, of_b.size));
    let mut found = Agreement::default();
    // How far an instance reaches, by way of its own origin.
    let reach = |i: usize| {
        let place = v.scene.world_from_local(i);
        let corners = v.scene.mesh_of(i).bounds_local().corners();
        let reach = corners.iter().map(|c| place.transform_vector3(*c).length()).fold(0.0, f64::max);
        reach + (place.translation - v.camera.eye()).length()
    };
    let reaches: Vec<f64> = (0..v.scene.instances().len()).map(reach).collect();
    for i in 0..a.map.len() {
        if (of_a.triangle[i], of_a.instance[i]) != (of_b.triangle[i], of_b.instance[i]) {
            continue;
        }
        found.same += 1;
        let at = Pixel::new(v, of_b, i, &reaches);
        if a.map[i] != b.map[i] {
            found.other_map += 1;
            if !at.as_ref().is_some_and(|at| at.is_on_a_border(v, a.map[i])) {
                found.unexplained.push((i, a.map[i], b.map[i]));
            }
            continue;
        }
        let [of_a, of_b] = [a, b].map(|f| numbers(f, i));
        let Some((at, k)) = at.zip(usize::try_from(b.map[i]).ok()) else {
            // Nothing to tell of: the numbers are none in both.
            let some = (0..NAMES.len()).filter(|&k| !of_a[k].iter().chain(&of_b[k]).all(|x| x.is_nan()));
            found.over.extend(some.map(|k| (i, NAMES[k], f64::NAN, 0.0)));
            continue;
        };
        found.served += 1;
        let (bounds, major) = (at.conditions(v, k, resolution, &of_b), of_b[1][0].abs());
        for (k, condition) in bounds.into_iter().enumerate() {
            let apart: f64 = of_a[k].iter().zip(&of_b[k]).map(|(a, b)| (a - b) * (a - b)).sum();
            let size = if k == 0 { major } else { of_b[k][0].abs() };
            let deviation = apart.sqrt() / size;
            let bound = ROUNDINGS * f64::from(f32::EPSILON) * condition;
            found.deviations[k].push(deviation);
            let roundings = deviation / (f64::from(f32::EPSILON) * condition);
            found.worst_roundings[k] = found.worst_roundings[k].max(roundings);
            // Written so that a NaN is over its bound.
            if !(deviation <= bound) {
                found.over.push((i, NAMES[k], deviation, bound));
            }
        }
    }
    found
}

/// The numbers of a pixel, in the order of [`NAMES`].
fn numbers(f: &Footprint, i: usize) -> [Vec<f64>; 7] {
    let (pixels, jacobian) = (f.map.len(), Footprint::JACOBIAN);
    let planes = |planes: Range<usize>| planes.map(|k| f64::from(f.planes[k * pixels + i])).collect::<Vec<_>>();
    let single = [Footprint::MAJOR, Footprint::PERSPECTIVE, Footprint::PERSPECTIVE_TS, Footprint::PERSPECTIVE_TS + 1];
    let [major, perspective, t, s] = single.map(|k| planes(k..k + 1));
    let [projection, depth] = [Footprint::PROJECTION, Footprint::DEPTH].map(|k| planes(k..k + 1));
    [planes(jacobian..jacobian + 4), major, perspective, t, s, projection, depth]
}

/// What a pixel shows.
struct Pixel {
    p_world: DVec3,
    normal: DVec3,
    /// cos of the angle the surface is seen under.
    cos_e: f64,
    /// By how much a unit of the last place moves the point, and by how much that of the processor's image alone.
    place: f64,
    rounding: f64,
    /// How much the normal magnifies roundings.
    sliver: f64,
    /// Of the image, pixels.
    size: [f64; 2],
}

impl Pixel {
    fn new(v: &View, g: &GBuffer, i: usize, reaches: &[f64]) -> Option<Self> {
        let (position, normal) = g.surfaces().receiver(i)?;
        let (p_world, instance) = (g.origin + position, g.instance[i] as usize);
        let mesh = v.scene.mesh_of(instance);
        let corners = mesh.triangles()[g.triangle[i] as usize].map(|k| {
            v.scene.world_from_local(instance).transform_point3(mesh.positions_local()[k as usize].as_dvec3())
        });
        let sides = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
        let longest = sides.iter().map(|s| s.length()).fold(0.0, f64::max);
        let sliver = longest * longest / sides[0].cross(sides[1]).length();
        let from_eye = p_world - v.camera.eye();
        let cos_e = (from_eye.normalize().dot(normal)).abs();
        let rounding = position.abs().max_element();
        let place = (reaches[instance] + sliver * longest) / cos_e + rounding;
        Some(Self { p_world, normal, cos_e, place, rounding, sliver, size: g.size.map(f64::from) })
    }

    /// Whether a point or a normal as near as rounding brings it asks map `map`, or has that code.
    fn is_on_a_border(&self, v: &View, map: i16) -> bool {
        let step = |size: f64| [-1.0, 0.0, 1.0].map(|s| s * ROUNDINGS * f64::from(f32::EPSILON) * size);
        let steps = |size: f64| {
            let s = step(size);
            s.into_iter().flat_map(move |x| s.into_iter().flat_map(move |y| s.map(|z| DVec3::new(x, y, z))))
        };
        let illuminated = |n: DVec3| steps(self.place).map(move |d| v.light.illuminates(self.p_world + d, n));
        match map {
            Footprint::NOTHING => false,
            Footprint::AVERTED => {
                steps(self.sliver).any(|d| !v.light.illuminates(self.p_world, self.normal + d))
                    || illuminated(self.normal).any(|lit| !lit)
            }
            map => {
                let chosen = |p: DVec3| v.p.choose(p, v.camera.depth_of(p)).map_or(Footprint::NO_MAP, |k| k as i16);
                // What asks this map here and is averted there.
                let own = chosen(self.p_world) == map;
                let turned = own && steps(self.sliver).any(|d| v.light.illuminates(self.p_world, self.normal + d));
                turned || steps(self.place).any(|d| chosen(self.p_world + d) == map)
            }
        }
    }

    /// The conditions of the numbers of this pixel in map `k`, in the order of [`NAMES`].
    fn conditions(&self, v: &View, k: usize, resolution: [u32; 2], numbers: &[Vec<f64>; 7]) -> [f64; 7] {
        let eye = v.camera.eye();
        let (p, n) = (self.p_world - eye, self.normal);
        let clip_from_eye = v.p.partitions[k].shadow_clip_from_world * DMat4::from_translation(eye);
        let [x, y, w] = [0, 1, 3].map(|i| clip_from_eye.row(i));
        let (d_x, d_y, d_w) = (x.truncate(), y.truncate(), w.truncate());
        let w_here = w.dot(p.extend(1.0));
        // What a sum's terms and the place of the point make of its value.
        let of_w = (w.abs().dot(p.abs().extend(1.0)) + d_w.length() * self.place) / w_here.abs();
        let gradient = |row: DVec4| {
            let (at_eye, turn) = (w.w * row.truncate() - row.w * d_w, row.truncate().cross(d_w));
            let g = at_eye + p.cross(turn);
            (g, (at_eye.length() + turn.length() * (p.length() + self.place)) / g.length())
        };
        let (g_x, of_x) = gradient(x);
        let is_log = matches!(v.p.partitions[k].post_warp, PostWarp::Log { .. });
        let (g_y, of_y, ray, of_ray) = match v.p.partitions[k].post_warp {
            PostWarp::Rectilinear(_) => unreachable!("the gpu refuses it"),
            PostWarp::Log { scale, .. } => (scale * d_w, 1.0, scale * d_x.cross(d_w), 1.0),
            PostWarp::None => {
                let (g_y, of_y) = gradient(y);
                let (constant, factor) =
                    (w.w * d_x.cross(d_y) + y.w * d_w.cross(d_x) + x.w * d_y.cross(d_w), d_x.cross(d_y).dot(d_w));
                let ray = constant + factor * p;
                let terms = constant.length() + factor.abs() * (p.length() + self.place);
                (g_y, of_y, ray, terms / ray.length())
            }
        };
        let depth = v.camera.depth_of(self.p_world);
        let of_depth = 1.0 + self.place / depth;
        let of_e = 1.0 + self.rounding / depth;
        let e = p.normalize();
        let facing = ray.dot(n);
        let towards = ray * (-facing.signum() / ray.length());
        let cos_d = facing.abs() / ray.length();
        // Pixels that a texel's step would have if nothing of it were lost along the eye's ray, over those it has.
        let [tan_x, tan_y] = v.camera.half_size().to_array();
        let pixels =
            [self.size[0] / tan_x, self.size[1] / tan_y].map(|s| 0.5 * s / depth).into_iter().fold(0.0, f64::max)
                * (p.length() / depth);
        let f_x = 2.0 * w_here.abs() / f64::from(resolution[0]);
        let f_y = if is_log { 2.0 } else { 2.0 * w_here.abs() } / f64::from(resolution[1]);
        let (long_x, long_y) = (pixels * f_x * g_y.length() / ray.length(), pixels * f_y * g_x.length() / ray.length());
        let stretch = (long_x * of_y + long_y * of_x) / (cos_d * numbers[1][0]);
        let flat = long_x.max(long_y) / (cos_d * numbers[1][0]);
        let of_normal = (self.sliver + of_ray) / cos_d;
        let jacobian = of_depth + of_w + of_normal + stretch * of_e + flat * self.sliver;
        let projection = (self.sliver + of_e) / self.cos_e + of_normal;
        let folded = (of_e + of_ray) / (e + towards).length();
        let of_t = of_depth + of_w + of_ray + long_x / numbers[3][0] * (of_y + of_e + folded);
        let of_s = of_depth + of_w + of_ray + long_y / numbers[4][0] * (of_x + of_e + folded);
        let perspective = 2.0 * of_depth + 3.0 * of_w + of_ray;
        [jacobian, jacobian, perspective, of_t, of_s, projection, of_depth]
    }
}
