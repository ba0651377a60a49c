//! Wrong pixels of any homography foretold: the share of receivers whose shadow state changes within their texel.
//!
//! Source: theory.md (10.9). It is a count, which moves by steps: nothing to descend on, but a walk finds less of it.

use glam::{DMat2, DMat3, DVec2};

use super::problem::{Problem, Shape};
use super::search::polished;
use crate::focus::{Picture, RayFlip, Shadows};
use crate::geometry::planar_image;
use crate::techniques::kit::Part;

/// Receivers near shadows' edges that are asked.
const RECEIVERS: usize = 2048;

/// The receivers near the edges of a part's shadows, and the outline that its map holds.
#[derive(Debug)]
pub struct Flips<'a> {
    picture: &'a Picture,
    shadows: &'a Shadows,
    receivers: Vec<RayFlip>,
    hull: &'a [DVec2],
    texels: DVec2,
}

impl<'a> Flips<'a> {
    /// Nothing where no picture of the states is known, or no receiver near an edge.
    pub fn of(part: &'a Part, hull: &'a [DVec2]) -> Option<Self> {
        let samples = part.samples?;
        let (picture, shadows) = (samples.picture.as_ref()?, samples.shadows.as_ref()?);
        let (_, receivers) = samples.ray_flips(&part.camera, &part.light, &part.region, RECEIVERS)?;
        let texels = part.size.receivers_texels();
        (!receivers.is_empty()).then_some(Self { picture, shadows, receivers, hull, texels })
    }
    /// The shape with the least share that a walk from the best of some shapes finds, and its share; nothing without shapes.
    pub fn least(&self, problem: &Problem, from: impl Iterator<Item = Shape>) -> Option<(Shape, f64)> {
        let share = |shape: &Shape| self.share(&problem.homography(shape));
        let valued = |shape: Shape| (shape, share(&shape));
        let best = from.map(valued).min_by(|a, b| a.1.total_cmp(&b.1))?;
        let walked = valued(polished(problem, &best.0, share));
        Some(if walked.1 < best.1 { walked } else { best })
    }
    /// Of the map of a homography that is cropped to the hull.
    pub fn share(&self, homography: &DMat3) -> f64 {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in self.hull {
            let (at, _, _) = planar_image(homography, *corner);
            (low, high) = (low.min(at), high.max(at));
        }
        let texel = DMat2::from_diagonal((high - low) / self.texels);
        let flips = |receiver: &RayFlip| {
            let (at, w, per_ray) = planar_image(homography, receiver.ray);
            let g = receiver.pixel * per_ray.inverse() * texel;
            // Outside of the map all is lit.
            if !(w > 0.0 && g.is_finite() && at.cmpge(low).all() && at.cmple(high).all()) {
                return f64::from(u8::from(receiver.near.in_shadow));
            }
            self.shadows.flips(self.picture, &receiver.near, &g)
        };
        self.receivers.iter().map(flips).sum::<f64>() / self.receivers.len() as f64
    }
}
