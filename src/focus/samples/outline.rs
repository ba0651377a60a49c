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

use super::picture::Picture;
use crate::geometry::{Rows, clipped, convex_hull};
use crate::rays::LightFrame;
use crate::scene::Light;

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
    fn moved(&self, p: DVec3, ray: DVec2, reach: f64) -> f64 {
        match self.apex {
            None => reach,
            Some((apex, _)) => {
                let depth = (p - apex).dot(self.frame.along) - reach;
                if depth > 0.0 { reach * (1.0 + ray.length()) / depth } else { f64::INFINITY }
            }
        }
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
    /// The outline of so many samples (position relative to the eye, and normal), with the corners of their pixels where they
    /// come from a picture; nothing without samples.
    pub fn of(
        rays: RayFrame,
        picture: Option<&Picture>,
        count: usize,
        sample: impl Fn(usize) -> (DVec3, DVec3),
    ) -> Option<Self> {
        let mut hull = Growing::default();
        let mut sum = DVec2::ZERO;
        let add = |hull: &mut Growing, p: DVec3, n: DVec3| {
            let Some(picture) = picture else {
                hull.add(&[rays.ray(p)]);
                return;
            };
            let corners = picture.corners(p, n);
            let behind =
                rays.apex.is_some_and(|(apex, _)| corners.iter().any(|c| (*c - apex).dot(rays.frame.along) <= 0.0));
            // Corners of a grazing plane, cut to a share of the depth, need not lie around the sample.
            hull.add(&[rays.ray(p)]);
            if !behind {
                hull.add(&corners.map(|c| rays.ray(c)));
            }
        };
        // A hull of a few first, so that the pass over all hardly adds.
        for (p, n) in (0..count).step_by(SEED_STEP).map(&sample) {
            add(&mut hull, p, n);
        }
        hull.settle();
        for first in (0..count).step_by(RUN) {
            // Most runs of neighbours lie in the hull so far as a whole.
            let run = first..(first + RUN).min(count);
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for (p, n) in run.clone().map(&sample) {
                let ray = rays.ray(p);
                sum += ray;
                let reach = picture.map_or(0.0, |picture| rays.moved(p, ray, picture.reach(p, n)));
                (low, high) = (low.min(ray - reach), high.max(ray + reach));
            }
            let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
            if !corners.iter().all(|p| hull.holds(*p)) {
                run.map(&sample).for_each(|(p, n)| add(&mut hull, p, n));
            }
        }
        hull.settle();
        let mean = sum / count.max(1) as f64;
        let off = |p: DVec3| (rays.ray(p) - mean).length_squared();
        let some = (0..count).step_by(count.div_ceil(MOST_FOR_MIDDLE).max(1)).map(|i| sample(i).0);
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

/// Samples, neighbours in the picture, that are asked for together.
const RUN: usize = 32;
/// Every so manyth sample makes the first hull.
const SEED_STEP: usize = 61;
/// Samples that are looked at for the one in the middle.
const MOST_FOR_MIDDLE: usize = 1024;
/// Points that wait for the next hull.
const MOST_WAITING: usize = 4096;

/// A hull that grows.
#[derive(Debug, Default)]
struct Growing {
    /// The hull's corners, and behind them what waits.
    corners: Vec<DVec2>,
    settled: usize,
    /// Index of the hull's rightmost corner; the first is the leftmost.
    rightmost: usize,
    room: Vec<DVec2>,
}

impl Growing {
    fn add(&mut self, points: &[DVec2]) {
        for p in points {
            if p.is_finite() && !self.holds(*p) {
                self.corners.push(*p);
            }
        }
        if self.corners.len() > self.settled + MOST_WAITING {
            self.settle();
        }
    }
    /// The hull of all that was added.
    fn settle(&mut self) {
        convex_hull(&mut self.corners, &mut self.room);
        self.settled = self.corners.len();
        let right = |i: &usize| self.corners[*i].x;
        self.rightmost = (0..self.settled).max_by(|a, b| right(a).total_cmp(&right(b))).unwrap_or(0);
    }
    /// Whether a point lies in the hull so far.
    fn holds(&self, p: DVec2) -> bool {
        let hull = &self.corners[..self.settled];
        if hull.len() < 3 {
            return false;
        }
        // From the leftmost corner below to the rightmost, and back above.
        let (below, above) = (&hull[..=self.rightmost], &hull[self.rightmost..]);
        let i = below.partition_point(|a| a.x <= p.x);
        if i == 0 || i == below.len() {
            return false;
        }
        let over = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a) >= 0.0;
        if !over(below[i - 1], below[i]) {
            return false;
        }
        let j = above.partition_point(|a| a.x > p.x);
        let next = above.get(j).unwrap_or(&hull[0]);
        j > 0 && over(above[j - 1], *next)
    }
}
