//! The outline of samples as the light sees them: the convex polygon of its rays that a map has to hold.
//!
//! Source: theory.md 10.1 to 10.3. A homography with w > 0 maps the corners of a hull to the corners of the hull's image, so
//! one polygon serves every map of the light. Each sample counts with the corners of its pixel.
//!
//! ```text
//!      .-----.        corners are asked for only where the box around a run of
//!     / [..]  \       pixels and their reach sticks out of the hull so far;
//!    |   [..]  |      of a million pixels some thousand are in such runs
//!     \_.___._/
//! ```

use glam::{DMat3, DVec2, DVec3, DVec4};

use super::growing::Growing;
use super::picture::Picture;
use super::runs::{Chosen, RUN, Run};
use crate::geometry::{Rows, clipped};
use crate::rays::LightFrame;
use crate::scene::Light;
use crate::simd::dispatch;

/// Coordinates of a light's rays: two numbers a ray, linear in a plane across the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayFrame {
    frame: LightFrame,
    /// A placed light, relative to the eye, and the tangent of half its cone's angle.
    apex: Option<(DVec3, f64)>,
}

impl RayFrame {
    /// The frame of a light, relative to the eye at `eye`; nothing for a point light, whose rays have no common plane.
    pub fn new(light: &Light, eye: DVec3) -> Option<Self> {
        match light {
            Light::Directional(l) => Some(Self { frame: LightFrame::any(l.direction()), apex: None }),
            Light::Spot(spot) => Some(Self {
                frame: LightFrame::any(spot.direction()),
                apex: Some((spot.position() - eye, (0.5 * spot.cone_angle()).tan())),
            }),
            Light::Point(_) => None,
        }
    }
    /// The ray through a point. Before a placed light only.
    #[inline(always)]
    pub fn ray(&self, p: DVec3) -> DVec2 {
        let LightFrame { right, up, along } = self.frame;
        match self.apex {
            None => DVec2::new(right.dot(p), up.dot(p)),
            Some((apex, _)) => {
                let p = p - apex;
                DVec2::new(right.dot(p), up.dot(p)) / along.dot(p)
            }
        }
    }
    /// A point on a ray, relative to the eye; before a placed light.
    pub fn on_ray(&self, ray: DVec2) -> DVec3 {
        let LightFrame { right, up, along } = self.frame;
        let across = right * ray.x + up * ray.y;
        self.apex.map_or(across, |(apex, _)| apex + across + along)
    }
    /// Gradients of [`RayFrame::ray`] at a point.
    pub fn gradients(&self, p: DVec3) -> [DVec3; 2] {
        let LightFrame { right, up, along } = self.frame;
        match self.apex {
            None => [right, up],
            Some((apex, _)) => {
                let p = p - apex;
                let depth = along.dot(p);
                [right, up].map(|axis| (axis - along * (axis.dot(p) / depth)) / depth)
            }
        }
    }
    /// World length, across the light at a point, of one unit of a ray's coordinates.
    pub fn scale(&self, p: DVec3) -> f64 {
        self.apex.map_or(1.0, |(apex, _)| (p - apex).dot(self.frame.along))
    }
    /// The homography of a map of this light: clip x, y and w, up to a positive factor, of (ray, 1).
    pub fn homography(&self, rows: &Rows) -> DMat3 {
        let LightFrame { right, up, along } = self.frame;
        let of = |row: DVec4| {
            let across = row.truncate();
            let last = if self.apex.is_some() { across.dot(along) } else { row.w };
            DVec3::new(across.dot(right), across.dot(up), last)
        };
        DMat3::from_cols(of(rows.x), of(rows.y), of(rows.w)).transpose()
    }
    /// The rows of a map whose homography of (ray, 1) this is; z is the depth along a directional light, and -1 under a placed
    /// one.
    pub fn rows(&self, homography: &DMat3) -> Rows {
        let LightFrame { right, up, along } = self.frame;
        let (basis, z) = match self.apex {
            None => ([right.extend(0.0), up.extend(0.0), DVec4::W], along.extend(0.0)),
            Some((apex, _)) => ([right, up, along].map(|v| v.extend(-v.dot(apex))), DVec4::NEG_W),
        };
        let row = |i: usize| {
            let h = homography.row(i);
            basis[0] * h.x + basis[1] * h.y + basis[2] * h.z
        };
        Rows { x: row(0), y: row(1), z, w: row(2) }
    }
    /// How far the ray may move as a point moves by `reach`.
    #[inline(always)]
    fn moved(&self, p: DVec3, ray: DVec2, reach: f64) -> f64 {
        match self.apex {
            None => reach,
            Some((apex, _)) => {
                let depth = (p - apex).dot(self.frame.along) - reach;
                if depth > 0.0 { reach * (1.0 + ray.length()) / depth } else { f64::INFINITY }
            }
        }
    }
    /// Whether a point does not lie before a placed light.
    #[inline(always)]
    fn is_behind(&self, p: DVec3) -> bool {
        self.apex.is_some_and(|(apex, _)| (p - apex).dot(self.frame.along) <= 0.0)
    }
    /// A box around the rays of a run's samples and of the corners of their pixels; nothing where it has no bound.
    #[inline(always)]
    fn range(&self, run: &Run, picture: Option<&Picture>) -> Option<[DVec2; 2]> {
        let reach = picture.map_or(0.0, |picture| run.reach(picture));
        let LightFrame { right, up, along } = self.frame;
        let [x, y] = [right, up].map(|axis| run.range(axis));
        let Some((apex, _)) = self.apex else {
            return Some([DVec2::new(x[0], y[0]) - reach, DVec2::new(x[1], y[1]) + reach]);
        };
        let ends = |axis: DVec3, [low, high]: [f64; 2]| {
            let off = axis.dot(apex);
            [low - off - reach, high - off + reach]
        };
        let [near, far] = ends(along, run.range(along));
        let quotients = |[low, high]: [f64; 2]| {
            [if low < 0.0 { low / near } else { low / far }, if high > 0.0 { high / near } else { high / far }]
        };
        let [x, y] = [quotients(ends(right, x)), quotients(ends(up, y))];
        (near > 0.0).then_some([DVec2::new(x[0], y[0]), DVec2::new(x[1], y[1])])
    }
    /// A polygon of rays without what lies outside of a spot's pyramid.
    fn inside(&self, polygon: Vec<DVec2>) -> Vec<DVec2> {
        let Some((_, tan_half)) = self.apex else { return polygon };
        let sides = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
        sides.iter().fold(polygon, |polygon, side| clipped(&polygon, side.extend(tan_half)))
    }
}

/// The rays that a map has to hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Coordinates of its corners.
    pub rays: RayFrame,
    /// Corners of the convex polygon, counter-clockwise; at least one.
    pub corners: Vec<DVec2>,
    /// One of the samples, near their middle; relative to the eye.
    pub middle: DVec3,
}

impl Outline {
    /// The outline of samples, with the corners of their pixels where they come from a picture; nothing without samples.
    pub(super) fn of(rays: RayFrame, chosen: &Chosen) -> Option<Self> {
        let (hull, sum) = hull_of(&rays, chosen);
        let mean = rays.ray(sum / chosen.len().max(1) as f64);
        let off = |p: DVec3| (rays.ray(p) - mean).length_squared();
        let some = chosen.some(MOST_FOR_MIDDLE).map(|(p, _)| p);
        let middle = some.min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
        let corners = rays.inside(hull.corners);
        let corners = if corners.is_empty() { vec![rays.ray(middle)] } else { corners };
        Some(Self { rays, corners, middle })
    }
    /// The images of the corners under a homography of this light's rays; what has less than `least_w` of the largest w is
    /// cut off first.
    pub fn images(&self, homography: &DMat3, least_w: f64, mut visit: impl FnMut(DVec2)) {
        let w_row = homography.row(2);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in &self.corners {
            let w = w_row.dot(p.extend(1.0));
            (low, high) = (low.min(w), high.max(w));
        }
        let least = least_w * high;
        let image = |p: DVec2| {
            let clip = *homography * p.extend(1.0);
            clip.truncate() / clip.z
        };
        if low >= least {
            self.corners.iter().for_each(|p| visit(image(*p)));
        } else {
            // By rounding a corner of the cut may have a little less.
            let floor = DVec3::new(w_row.x, w_row.y, w_row.z - least);
            clipped(&self.corners, floor).into_iter().for_each(|p| visit(image(p)));
        }
    }
}

dispatch! {
    /// The hull of samples and of the corners of their pixels, and about the sum of their positions.
    fn hull_of(rays: &RayFrame, chosen: &Chosen) -> (Growing, DVec3) = hull_of_body
}

#[inline(always)]
fn hull_of_body(rays: &RayFrame, chosen: &Chosen) -> (Growing, DVec3) {
    let mut hull = Growing::default();
    // A hull of a few first, so that the pass over all hardly adds.
    hull.look(None);
    for (p, n) in chosen.some((chosen.len() / SEED_SHARE).clamp(1, MOST_SEEDS)) {
        add(&mut hull, rays, chosen.picture, p, n);
    }
    hull.settle();
    let mut sum = DVec3::ZERO;
    for block in chosen.runs.chunks(BLOCK) {
        let mut boxes = [None; BLOCK];
        // Around all of them.
        let (mut low, mut high, mut is_bound) = (DVec2::INFINITY, DVec2::NEG_INFINITY, true);
        for (found, run) in boxes.iter_mut().zip(block) {
            sum += run.middle * run.len() as f64;
            *found = rays.range(run, chosen.picture);
            match found {
                Some([a, b]) if (*b - *a).is_finite() => (low, high) = (low.min(*a), high.max(*b)),
                _ => is_bound = false,
            }
        }
        if is_bound && hull.holds(low, high) {
            continue;
        }
        for (found, run) in boxes.into_iter().zip(block) {
            if hull.look(found) {
                let (p, n) = chosen.side_by_side(run);
                let is_out = beyond(&hull, rays, chosen.picture, &p, &n);
                for i in (0..run.len()).filter(|&i| is_out[i]) {
                    let vector = |v: &[[f64; RUN]; 3]| DVec3::new(v[0][i], v[1][i], v[2][i]);
                    add(&mut hull, rays, chosen.picture, vector(&p), vector(&n));
                }
            }
        }
    }
    hull.settle();
    (hull, sum)
}

/// Which samples of a run, or corners of their pixels, may lie beyond the hull so far.
#[inline(always)]
fn beyond(
    hull: &Growing,
    rays: &RayFrame,
    picture: Option<&Picture>,
    p: &[[f64; RUN]; 3],
    n: &[[f64; RUN]; 3],
) -> [bool; RUN] {
    let (mut x, mut y, mut reach) = ([0.0; RUN], [0.0; RUN], [0.0; RUN]);
    for i in 0..RUN {
        let (p, n) = (DVec3::new(p[0][i], p[1][i], p[2][i]), DVec3::new(n[0][i], n[1][i], n[2][i]));
        let ray = rays.ray(p);
        (x[i], y[i]) = (ray.x, ray.y);
        reach[i] = picture.map_or(0.0, |picture| rays.moved(p, ray, picture.reach(p, n)));
    }
    hull.squares_beyond(&x, &y, &reach)
}

/// Adds a sample and the corners of its pixel.
#[inline(always)]
fn add(hull: &mut Growing, rays: &RayFrame, picture: Option<&Picture>, p: DVec3, n: DVec3) {
    let ray = rays.ray(p);
    let Some(picture) = picture else { return hull.add(ray) };
    let reach = rays.moved(p, ray, picture.reach(p, n));
    if hull.holds_seen(ray - reach, ray + reach) {
        return;
    }
    // Corners of a grazing plane, cut to a share of the depth, need not lie around the sample.
    hull.add(ray);
    let [a, b, c, d] = picture.corners(p, n);
    if rays.is_behind(a) || rays.is_behind(b) || rays.is_behind(c) || rays.is_behind(d) {
        return;
    }
    let corners = [rays.ray(a), rays.ray(b), rays.ray(c), rays.ray(d)];
    let low = corners[0].min(corners[1]).min(corners[2].min(corners[3]));
    let high = corners[0].max(corners[1]).max(corners[2].max(corners[3]));
    if !hull.holds(low, high) {
        for corner in corners {
            hull.add(corner);
        }
    }
}

/// Runs that are asked about together. Chosen because the box around so many mostly lies in the hull, too.
const BLOCK: usize = 8;
/// Samples that make the first hull: a share of all, and the most. Chosen because most of more would lie in it, and fewer leave
/// more to the pass over all.
const SEED_SHARE: usize = 61;
const MOST_SEEDS: usize = 2048;
/// Samples that are looked at for the one in the middle.
const MOST_FOR_MIDDLE: usize = 1024;
