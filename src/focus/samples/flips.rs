//! Wrong pixels foretold without a map: how often a texel's reach in the picture changes the shadow state.
//!
//! Source: theory.md (10.9). A pixel reads the texel that it falls into, whose depth was sampled anywhere in it; with
//! G = d(pixel) / d(texel), what the pixel gets is the state at `pixel + G δ` for a δ in the texel, as likely any as another.
//!
//! ```text
//!        . . . .         δ on a 4 x 4 grid over the texel; a flip where
//!     ##. . . . .        the picture's state there is not the pixel's own,
//!     ####. . . .        between pixels by the way from one to the other
//! ```

use glam::{DMat2, DVec2};

use super::edges::evenly;
use super::facing::counts;
use super::outline::RayFrame;
use super::part::pixel_per_ray;
use super::picture::Picture;
use super::samples::{Samples, Shadows};
use crate::error::Result;
use crate::image::TruthMask;
use crate::parameterization::Region;
use crate::scene::{Camera, Light};

/// Points of a texel along each of its sides.
const GRID: usize = 4;

/// Samples between two looks at whether to go on: some milliseconds of work.
const AT_ONCE: usize = 1 << 16;

/// Receivers within this share of the picture's longer side of an edge are asked. Chosen because texels of useful maps do not
/// reach farther (theory.md 10.3: 20 of 512 pixels).
const REACH_SHARE: f64 = 20.0 / 512.0;

/// A receiver near the edge of a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearEdge {
    /// Index of the sample.
    pub sample: u32,
    /// Where it is in the picture, pixels.
    pub place: DVec2,
    /// Whether it is in shadow.
    pub in_shadow: bool,
}

/// A receiver near the edge of a shadow, in the coordinates of the light's rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayFlip {
    /// Its ray.
    pub ray: DVec2,
    /// d(pixel) / d(ray), along the surface.
    pub pixel: DMat2,
    /// The receiver.
    pub near: NearEdge,
}

impl Samples {
    /// Up to `count` receivers near the edges of shadows, evenly chosen, and how many pixels each stands for; none without a
    /// picture of the states.
    pub fn near_edges(&self, count: usize) -> (Vec<NearEdge>, f64) {
        // What never stops cannot fail.
        let [near, _, _] = self.by_edges_watched([count, 0, 0], || Ok(())).unwrap_or_default();
        near
    }
    /// Receivers near the edges of shadows, others in shadow, and others in the light: up to a count of each, evenly chosen, and how
    /// many pixels each stands for; none without a picture of the states.
    ///
    /// # Errors
    /// Those of `check`, which is asked now and then.
    pub fn by_edges_watched(
        &self,
        counts: [usize; 3],
        check: impl Fn() -> Result<()>,
    ) -> Result<[(Vec<NearEdge>, f64); 3]> {
        let (Some(shadows), Some(picture)) = (&self.shadows, &self.picture) else { return Ok(Default::default()) };
        if shadows.image.is_empty() {
            return Ok(Default::default());
        }
        let reach = (REACH_SHARE * f64::from(picture.size[0].max(picture.size[1]))).ceil() as u16;
        let distance = shadows.distance(picture.size, &check)?;
        let eye = picture.camera.eye();
        let width = picture.size[0] as usize;
        let receiver = |i: usize| {
            let place = picture.place(self.sample(i).0 - eye);
            let pixel = picture.pixel(place)?;
            let state = shadows.image[pixel[1] * width + pixel[0]];
            let near = NearEdge { sample: i as u32, place, in_shadow: state == TruthMask::SHADOW };
            let is_near = distance[pixel[1] * width + pixel[0]] <= reach;
            let group = if is_near { 0 } else { 2 - usize::from(near.in_shadow) };
            (TruthMask::is_decided(state) && counts[group] > 0).then_some((group, near))
        };
        let mut all: [Vec<NearEdge>; 3] = Default::default();
        for first in (0..self.len()).step_by(AT_ONCE) {
            check()?;
            let found = (first..self.len().min(first + AT_ONCE)).filter_map(receiver);
            found.for_each(|(group, near)| all[group].push(near));
        }
        let [near, dark, lit] = all;
        Ok([thinned(near, counts[0]), thinned(dark, counts[1]), thinned(lit, counts[2])])
    }
    /// For each pixel of a picture, row by row, the index of a sample that it shows; nothing where none is there.
    ///
    /// # Errors
    /// Those of `check`, which is asked now and then.
    pub fn at_pixels(&self, picture: &Picture, check: impl Fn() -> Result<()>) -> Result<Vec<Option<usize>>> {
        let ([width, height], eye) = (picture.size.map(|n| n as usize), picture.camera.eye());
        let mut at = vec![None; width * height];
        for i in 0..self.len() {
            if i.is_multiple_of(AT_ONCE) {
                check()?;
            }
            if let Some([x, y]) = picture.pixel(picture.place(self.sample(i).0 - eye)) {
                at[y * width + x] = Some(i);
            }
        }
        Ok(at)
    }
    /// The same for a part of a view, in the coordinates of the light's rays.
    pub fn ray_flips(
        &self,
        camera: &Camera,
        light: &Light,
        region: &Region,
        count: usize,
    ) -> Option<(RayFrame, Vec<RayFlip>)> {
        let (eye, picture) = (camera.eye(), self.picture.as_ref()?);
        let rays = RayFrame::new(light, eye)?;
        let flip = |near: NearEdge| {
            let (p, n) = self.sample(near.sample as usize);
            if !counts(camera, light, region, p, n) {
                return None;
            }
            Some(RayFlip { ray: rays.ray(p - eye), pixel: pixel_per_ray(picture, &rays, p - eye, n)?, near })
        };
        Some((rays, self.near_edges(count).0.into_iter().filter_map(flip).collect()))
    }
}

/// Up to `count` of receivers, evenly chosen, and how many each stands for.
fn thinned(all: Vec<NearEdge>, count: usize) -> (Vec<NearEdge>, f64) {
    let kept = all.len().min(count);
    let chosen: Vec<NearEdge> = (0..kept).map(|i| all[evenly(i, kept, all.len())]).collect();
    let each = if kept > 0 { all.len() as f64 / kept as f64 } else { 0.0 };
    (chosen, each)
}

impl Shadows {
    /// The share of a texel's points whose state is known and not the receiver's own; `texel` is d(pixel) / d(texel). Between
    /// two pixels of different states lies an edge, anywhere with the same chance: a point between them has the other one's
    /// state with the chance of its way there.
    pub fn flips(&self, picture: &Picture, near: &NearEdge, texel: &DMat2) -> f64 {
        let [width, height] = picture.size.map(|n| n as i64);
        let own = if near.in_shadow { TruthMask::SHADOW } else { TruthMask::LIT };
        let (mut flips, mut points) = (0.0, 0.0);
        for i in 0..GRID * GRID {
            let share = |k: usize| (k as f64 + 0.5) / GRID as f64 - 0.5;
            let at = near.place + *texel * DVec2::new(share(i % GRID), share(i / GRID)) - 0.5;
            let first = at.floor();
            let [x, y] = [first.x as i64, first.y as i64];
            let (mut other, mut known) = (0.0, 0.0);
            for (dx, wx) in [(0, 1.0 - (at.x - first.x)), (1, at.x - first.x)] {
                for (dy, wy) in [(0, 1.0 - (at.y - first.y)), (1, at.y - first.y)] {
                    let (x, y) = (x.saturating_add(dx), y.saturating_add(dy));
                    if !((0..width).contains(&x) && (0..height).contains(&y)) {
                        continue;
                    }
                    let state = self.image[(y * width + x) as usize];
                    if TruthMask::is_decided(state) {
                        known += wx * wy;
                        other += if state == own { 0.0 } else { wx * wy };
                    }
                }
            }
            if known > 0.0 {
                flips += other / known;
                points += 1.0;
            }
        }
        if points > 0.0 { flips / points } else { 0.0 }
    }
    /// Pixels to the nearest edge, the larger of both axes' counts.
    ///
    /// # Errors
    /// Those of `check`, which is asked once a row.
    fn distance(&self, size: [u32; 2], check: impl Fn() -> Result<()>) -> Result<Vec<u16>> {
        let [w, h] = size.map(|n| n as usize);
        let state = |i: usize| self.image[i];
        let decided = |i: usize| TruthMask::is_decided(state(i));
        let differ = |i: usize, j: usize| decided(i) && decided(j) && state(i) != state(j);
        let mut distance = vec![u16::MAX; w * h];
        for y in 0..h {
            check()?;
            for x in 0..w {
                let i = y * w + x;
                if x + 1 < w && differ(i, i + 1) {
                    (distance[i], distance[i + 1]) = (0, 0);
                }
                if y + 1 < h && differ(i, i + w) {
                    (distance[i], distance[i + w]) = (0, 0);
                }
            }
        }
        // Two passes, each over the half of the neighbours that come before.
        let mut pixel = |i: usize, back: isize| {
            let (x, y) = ((i % w) as isize, (i / w) as isize);
            for (dx, dy) in [(1, 0), (-1, 1), (0, 1), (1, 1)] {
                let (nx, ny) = (x - back * dx, y - back * dy);
                if (0..w as isize).contains(&nx) && (0..h as isize).contains(&ny) {
                    let other = distance[(ny * w as isize + nx) as usize];
                    distance[i] = distance[i].min(other.saturating_add(1));
                }
            }
        };
        for y in 0..h {
            check()?;
            (y * w..(y + 1) * w).for_each(|i| pixel(i, 1));
        }
        for y in (0..h).rev() {
            check()?;
            (y * w..(y + 1) * w).rev().for_each(|i| pixel(i, -1));
        }
        Ok(distance)
    }
}
