//! What the footprint is held against: central differences of pixels and texels, and how near two numbers are.

use glam::{DMat2, DVec2, DVec3};
use shadowlab::aliasing::footprint::footprint_at;
use shadowlab::aliasing::texel::Texel;
use shadowlab::geometry::Rows;
use shadowlab::image::{Footprint, GBuffer};
use shadowlab::parameterization::PiecewiseLinear;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{Camera, Light};
use shadowlab::{Parameterization, Partition, Progress};

use crate::support::views::{Random, View};

/// Of f64 through a dozen operations on numbers of one size.
pub const EXACT: f64 = 1e-12;

/// Steps of a hundredth of a length over which nothing doubles: the error of differences of the fourth order, 1e-8 times a
/// number of the size of a binomial, and the rounding of a position, 2^-53 times its size over that of the step.
pub const DIFFERENCES: f64 = 1e-6;
const STEP: f64 = 1e-2;

/// Of f32: numbers that were rounded to it, a few times.
pub const SINGLE: f64 = 4.0 * f32::EPSILON as f64;

/// A number's share of another, which is their distance where that is 0.
pub fn apart(a: f64, b: f64) -> f64 {
    (a - b).abs() / if b == 0.0 { 1.0 } else { b.abs() }
}

/// Panics unless one number is the other up to a share of it; NaN is no number's neighbour.
#[track_caller]
pub fn assert_close(what: &str, ours: f64, theirs: f64, tolerance: f64) {
    assert!(apart(ours, theirs) <= tolerance, "{what}: {ours} is not {theirs}, {:e} apart", apart(ours, theirs));
}

/// d(pixel) / d(texel), columns first.
pub fn matrix(texel: &Texel) -> DMat2 {
    let [a, b, c, d] = texel.jacobian;
    DMat2::from_cols(DVec2::new(a, c), DVec2::new(b, d))
}

/// Where a world point is in the image, pixels from the upper left corner.
pub fn pixel(camera: &Camera, size: [u32; 2], p: DVec3) -> DVec2 {
    let clip = camera.clip_from_world() * p.extend(1.0);
    0.5 * DVec2::new(f64::from(size[0]) * (1.0 + clip.x / clip.w), f64::from(size[1]) * (1.0 - clip.y / clip.w))
}

/// Where it is in the map, texels from the upper left corner.
pub fn texel(map: &Partition, size: [u32; 2], p: DVec3) -> DVec2 {
    let (ndc, _) = map.project(p);
    0.5 * DVec2::new(f64::from(size[0]) * (1.0 + ndc.x), f64::from(size[1]) * (1.0 - ndc.y))
}

/// How fast a place moves with a point along a direction: central differences of the fourth order.
pub fn speed(place: impl Fn(DVec3) -> DVec2, p: DVec3, along: DVec3, h: f64) -> DVec2 {
    let over = |h: f64| (place(p + along * h) - place(p - along * h)) / (2.0 * h);
    (over(h) * 4.0 - over(2.0 * h)) / 3.0
}

/// A step that is small beside all that the image and a map make of a point.
pub fn step(camera: &Camera, map: &Partition, p: DVec3) -> f64 {
    smooth_step(camera, map, p).min(to_a_knot(map, p))
}

/// What differences at a point may be off by: more where a knot is so near that the step is short, which rounding is divided by.
pub fn tolerance(camera: &Camera, map: &Partition, p: DVec3) -> f64 {
    DIFFERENCES * (1.0 + 1e-3 * smooth_step(camera, map, p) / step(camera, map, p))
}

/// The step without knots.
fn smooth_step(camera: &Camera, map: &Partition, p: DVec3) -> f64 {
    let w = map.shadow_clip_from_world.row(3);
    let doubling = w.dot(p.extend(1.0)).abs() / w.truncate().length();
    let depth = camera.depth_of(p);
    STEP * if doubling.is_finite() { doubling.min(depth) } else { depth }
}

/// A quarter of the way on which no knot of a rectilinear warp is met.
fn to_a_knot(map: &Partition, p: DVec3) -> f64 {
    let rows = Rows::of(&map.shadow_clip_from_world);
    let per_length = DVec3::AXES.map(|axis| rows.derivative(p, axis));
    let speed = |axis: usize| DVec3::from_array(per_length.map(|d| d[axis])).length();
    0.25 * (gaps(map, p) / DVec2::new(speed(0), speed(1))).min_element()
}

/// How far a point is from the knots of a rectilinear warp, in NDC before it; infinity without knots.
pub fn gaps(map: &Partition, p: DVec3) -> DVec2 {
    let Some(warp) = map.post_warp.rectilinear() else { return DVec2::INFINITY };
    let at = Rows::of(&map.shadow_clip_from_world).project(p);
    let gap = |f: &PiecewiseLinear, x: f64| f.knots().map(|k| (k[0] - x).abs()).fold(f64::INFINITY, f64::min);
    DVec2::new(gap(&warp.x, at.x), gap(&warp.y, at.y))
}

/// How far J is from what moves pixels with texels on the plane across `normal`: as a share of the longest terms.
pub fn from_differences(v: &View, map: &Partition, sizes: Sizes, p: DVec3, normal: DVec3, j: &Texel) -> f64 {
    let n = normal.normalize();
    let u = n.any_orthonormal_vector();
    let h = step(&v.camera, map, p);
    let (j, length) = (matrix(j), j.major);
    // Directions all around, so that one lies along any texel.
    let directions = (0..8).map(|i| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_8).sin_cos();
        u * cos + n.cross(u) * sin
    });
    let shares = directions.map(|d| {
        let pixels = speed(|q| pixel(&v.camera, sizes.image, q), p, d, h);
        let texels = speed(|q| texel(map, sizes.map, q), p, d, h);
        (j * texels - pixels).length() / (length * texels.length() + pixels.length())
    });
    shares.fold(0.0, f64::max)
}

/// Pixels of an image and texels of a map.
#[derive(Debug, Clone, Copy)]
pub struct Sizes {
    pub image: [u32; 2],
    pub map: [u32; 2],
}

/// The texels at some points of surfaces.
pub fn at(v: &View, p: &Parameterization, sizes: Sizes, points: &[DVec3], normals: &[DVec3]) -> Vec<(i16, Texel)> {
    let arrays = |v: &[DVec3]| v.iter().map(|q| q.to_array()).collect::<Vec<_>>();
    let (points, normals) = (arrays(points), arrays(normals));
    footprint_at(&points, &normals, &v.camera, &v.light, p, sizes.map, sizes.image).expect("a footprint")
}

/// The texel at one point that a map holds.
#[track_caller]
pub fn one(v: &View, p: &Parameterization, sizes: Sizes, point: DVec3, normal: DVec3) -> Texel {
    match at(v, p, sizes, &[point], &[normal])[..] {
        [(map, texel)] if map >= 0 => texel,
        ref other => panic!("{}: {other:?} at {point}, {normal}", v.name),
    }
}

pub fn gbuffer(v: &View, size: [u32; 2]) -> GBuffer {
    CpuRenderer::new().gbuffer(&v.scene, &v.camera, size, &Progress::new()).expect("a G-buffer")
}

/// What some pixels show: world points and normals.
pub fn shown(g: &GBuffer, most: usize) -> Vec<(DVec3, DVec3)> {
    let all: Vec<_> = (0..g.triangle.len()).filter_map(|i| g.surfaces().receiver(i)).collect();
    let every = 1 + all.len() / most;
    all.into_iter().step_by(every).map(|(p, n)| (p + g.origin, n)).collect()
}

/// Unit ways from a point to the eye and to the light.
pub fn ways(camera: &Camera, light: &Light, p: DVec3) -> [DVec3; 2] {
    [(camera.eye() - p).normalize(), light.to_light(p).normalize()]
}

/// A normal on the side of both eye and light, not quite across either; nothing where both are opposed.
pub fn facing(random: &mut Random, [to_eye, to_light]: [DVec3; 2]) -> Option<DVec3> {
    let try_one = || Some(random.direction()).filter(|n| n.dot(to_eye) > 0.05 && n.dot(to_light) > 0.05);
    std::iter::repeat_with(try_one).take(300).flatten().next()
}

/// Where the numbers of a pixel lie in [`Picture`].
pub const MAJOR: usize = Footprint::MAJOR;
pub const PERSPECTIVE: usize = Footprint::PERSPECTIVE;
pub const PERSPECTIVE_TS: usize = Footprint::PERSPECTIVE_TS;
pub const PROJECTION: usize = Footprint::PROJECTION;
pub const DEPTH: usize = Footprint::DEPTH;

/// A footprint pixel by pixel: J in four numbers, rows first, then what the constants above name; as many as it has planes.
#[derive(Debug, Clone)]
pub struct Picture {
    pub numbers: Vec<[f32; Footprint::PLANES]>,
    pub map: Vec<i16>,
}

impl Picture {
    pub fn of(f: &Footprint) -> Self {
        let numbers = |i: usize| std::array::from_fn(|k| f.plane(k)[i]);
        Self { numbers: (0..f.map.len()).map(numbers).collect(), map: f.map.clone() }
    }
    pub fn bits(&self) -> (Vec<[u32; Footprint::PLANES]>, Vec<i16>) {
        (self.numbers.iter().map(|n| n.map(f32::to_bits)).collect(), self.map.clone())
    }
    pub fn count(&self, code: i16) -> usize {
        self.map.iter().filter(|k| **k == code).count()
    }
    pub fn measured(&self) -> usize {
        self.map.iter().filter(|k| **k >= 0).count()
    }
}

/// The first pixel in which two footprints differ by more than a share of the numbers (codes: at all); depth aside, which has
/// the unit of the world.
pub fn differing(a: &Picture, b: &Picture, tolerance: f64) -> Option<usize> {
    assert_eq!(a.map.len(), b.map.len());
    (0..a.map.len()).find(|&i| {
        let (ours, theirs) = (&a.numbers[i], &b.numbers[i]);
        // Entries of J are told from the longest extent.
        let scale = |k: usize| f64::from(theirs[k.max(MAJOR)]).abs();
        let near = |k: usize| f64::from((ours[k] - theirs[k]).abs()) <= tolerance * scale(k);
        let same = |k: usize| ours[k].is_nan() && theirs[k].is_nan() || near(k);
        a.map[i] != b.map[i] || !(0..DEPTH).all(same)
    })
}
