//! The chance that a receiver reads another state in a map than its own, from what the picture shows about it.
//!
//! Source: theory.md (10.9). A texel's centre lies anywhere in the texel, and the map holds there what the light meets first on
//! the centre's ray. Pixels whose rays fall into the same texel know what that is: their own surface, or what shades it.
//!
//! ```text
//!      light   o---- what shades q, a gap before it
//!        \     |
//!         q____|     height of q over the plane, along the ray
//!     ____|____|___________ plane of the receiver
//!      bias above it: what lies higher makes the receiver dark
//! ```

use glam::{DMat2, DVec2, DVec3};

use super::asked_maps::AskedMaps;
use crate::image::TruthMask;
use crate::render::cpu::lookup::{Comparison, MapLookup};

/// Points of a texel along each of its sides.
const GRID: usize = 4;

/// Texels that a pixel's ray may lie off the place of the receiver's plane that the pixel would show: within half a texel the
/// centre's ray meets the same as the pixel's, as far as the map can tell them apart.
const SAME_RAY: f64 = 0.5;

/// A receiver before one map.
pub(super) struct Receiver<'a> {
    /// Relative to the samples' origin.
    pub p: DVec3,
    pub normal: DVec3,
    /// Where it is in the picture, pixels.
    pub place: DVec2,
    pub in_shadow: bool,
    pub map: &'a MapLookup,
    /// d(pixel) / d(texel) along its plane.
    pub texel: DMat2,
}

/// How high over the receiver's plane, along the ray towards the light, lies what the light meets first, world units.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Height {
    /// What a pixel shows.
    Lit(f32),
    /// What shades it.
    Shaded(f32),
}

/// What is known of a picture's pixels.
pub(super) struct Reading<'a> {
    asked: &'a AskedMaps<'a>,
    /// How far before each pixel's point what shades it lies, world units.
    gaps: &'a [f32],
    at_pixel: Vec<Option<usize>>,
    /// Heights over the receiver's plane that were found for the receiver of this turn.
    known: Vec<(u32, Option<Height>)>,
    turn: u32,
}

impl<'a> Reading<'a> {
    pub fn new(asked: &'a AskedMaps<'a>, gaps: &'a [f32], at_pixel: Vec<Option<usize>>) -> Self {
        let known = vec![(0, None); at_pixel.len()];
        Self { asked, gaps, at_pixel, known, turn: 0 }
    }
    /// The chance that a receiver reads another state than its own.
    pub fn chance(&mut self, r: &Receiver) -> f64 {
        let per_pixel = r.texel.inverse();
        if !(r.texel.is_finite() && per_pixel.is_finite()) {
            return 0.5;
        }
        // Carried past the light, or to where the map ends, it is lit.
        let Comparison::At(reference) = r.map.compare_at(r.p, r.normal) else { return f64::from(r.in_shadow) };
        let Some(own) = r.map.place_of(r.p) else { return f64::from(r.in_shadow) };
        self.turn += 1;
        let (mut flips, mut points) = (0.0, 0.0);
        for i in 0..GRID * GRID {
            let share = |k: usize| (k as f64 + 0.5) / GRID as f64 - 0.5;
            let offset = DVec2::new(share(i % GRID), share(i / GRID));
            let bias = r.map.bias_at(&reference, r.p, r.normal, reference.p_texel + offset).unwrap_or(f64::INFINITY);
            let at = r.place + r.texel * offset - 0.5;
            let first = at.floor();
            let (mut other, mut known, mut lit) = (0.0, 0.0, [0.0; 2]);
            for (dx, wx) in [(0.0, 1.0 - (at.x - first.x)), (1.0, at.x - first.x)] {
                for (dy, wy) in [(0.0, 1.0 - (at.y - first.y)), (1.0, at.y - first.y)] {
                    match self.height(r, own, &per_pixel, first + DVec2::new(dx, dy)) {
                        Some(Height::Lit(height)) => {
                            lit[0] += wx * wy;
                            lit[1] += wx * wy * f64::from(height);
                        }
                        Some(Height::Shaded(height)) => {
                            known += wx * wy;
                            other += if (f64::from(height) > bias) == r.in_shadow { 0.0 } else { wx * wy };
                        }
                        None => {}
                    }
                }
            }
            // A lit surface goes on between pixels, so its height does; an edge lies anywhere.
            if lit[0] > 0.0 {
                known += lit[0];
                other += if (lit[1] / lit[0] > bias) == r.in_shadow { 0.0 } else { lit[0] };
            }
            if known > 0.0 {
                flips += other / known;
                points += 1.0;
            }
        }
        if points > 0.0 {
            return flips / points;
        }
        // Of a texel that the picture shows nothing of, the receiver's own ray is what is known.
        let bias = r.map.bias_at(&reference, r.p, r.normal, reference.p_texel).unwrap_or(f64::INFINITY);
        let gap = self
            .asked
            .picture
            .pixel(r.place)
            .map_or(0.0, |[x, y]| self.gaps[y * self.asked.picture.size[0] as usize + x]);
        f64::from(r.in_shadow && f64::from(gap) <= bias)
    }
    /// How high over the receiver's plane, along the ray towards the light, lies what the light meets first on the ray of what a pixel
    /// shows; nothing where that ray falls into another texel, or what it shows has no state, as what faces away from the light.
    fn height(&mut self, r: &Receiver, own: DVec2, per_pixel: &DMat2, pixel: DVec2) -> Option<Height> {
        let [x, y] = self.asked.picture.pixel(pixel + 0.5)?;
        let index = y * self.asked.picture.size[0] as usize + x;
        let (turn, height) = self.known[index];
        if turn == self.turn {
            return height;
        }
        let found = self.found(r, own + *per_pixel * (pixel + 0.5 - r.place), index);
        self.known[index] = (self.turn, found);
        found
    }
    fn found(&self, r: &Receiver, of_plane: DVec2, index: usize) -> Option<Height> {
        let state = self.asked.shadows.image[index];
        let seen = self.at_pixel[index].filter(|_| TruthMask::is_decided(state))?;
        let q = self.asked.samples.sample(seen).0 - self.asked.samples.origin;
        if !((r.map.place_of(q)? - of_plane).abs().max_element() <= SAME_RAY) {
            return None;
        }
        let height = r.normal.dot(q - r.p) / r.normal.dot(r.map.way_to_light(q));
        let height = height.is_finite().then_some(height as f32)?;
        let is_shaded = state == TruthMask::SHADOW;
        Some(if is_shaded { Height::Shaded(height + self.gaps[index]) } else { Height::Lit(height) })
    }
}
