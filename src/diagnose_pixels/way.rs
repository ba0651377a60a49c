//! The way over a receiver's plane from a pixel to where the ray of a texel's centre meets it, and the edge that lies between.
//!
//! ```text
//!          h        _____             t = 0 at the pixel, 1 at the centre. Light meets surfaces at heights h over the plane. Of
//!   height |  __   |     |            the steps across which the height changes much, the one nearest to the centre has the
//!  ___P____|_|__|__|_____|_q_ plane   edge of what the texel holds, however many others there are. Halving it tells a
//!   t=0                  t=1          silhouette, where the height jumps, from a surface that rises: acne, a crease.
//! ```

use glam::DVec2;

use super::rays::{Asked, LightRays, Met, Receiver};
use crate::aliasing::texel::Eye;
use crate::error::Result;
use crate::progress::Progress;

/// Steps that the way is looked at in: edges nearer together than one may be taken for each other.
const STEPS: usize = 4;
/// The part of the largest change of height that makes a step one with an edge: the next bar stands about as high.
const MUCH: f64 = 0.5;
/// Halvings after which an edge is where it is: 1/16 of the way, which is half a texel long.
const PLACED: u32 = 2;
/// Halvings after which a change of height that follows from a slope is a surface's own: 1/256 of the way.
const CERTAIN: u32 = 6;
/// The steepest rise of a lit surface over the receiver's plane, texels a texel, beside what the plane's own slope adds:
/// derived from 3.6 degrees between the surface and the light.
const STEEPEST: f64 = 16.0;

/// How far beyond its ends an edge of a triangle is taken to go on, edges: that of a finer mesh bends little from one to the next.
const BEYOND: f64 = 1.0;
/// Steps in which a receiver's own surface is followed.
const FOLLOWED: usize = 16;
/// The steepest rise of a surface that is followed, texels a texel, beside what the plane's own slope adds.
const FOLLOWED_RISE: f64 = 8.0;

/// What lies between the ends of a way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// Not known yet.
    Open,
    /// A silhouette.
    Silhouette,
    /// One surface.
    Surface,
}

/// A place on a way, and what light meets there.
type Look = (f64, Met);

/// A way, and the step of it that the edge lies in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// Where it begins.
    pub receiver: Receiver,
    /// The texel's centre, texels.
    pub centre: DVec2,
    /// What lies between its ends.
    pub between: Between,
    /// The step, its end towards the pixel first.
    step: [Look; 2],
    /// Another step that may have the edge, where this one has none.
    other: Option<[Look; 2]>,
}

/// How much higher the second look is, world units.
fn rise([(_, near), (_, far)]: &[Look; 2]) -> f64 {
    if near.height == far.height { 0.0 } else { far.height - near.height }
}

impl Way {
    /// From what light meets at the pixel and at the centre.
    pub fn new(receiver: Receiver, centre: DVec2, [near, far]: [Met; 2]) -> Self {
        Self { receiver, centre, between: Between::Open, step: [(0.0, near), (1.0, far)], other: None }
    }

    fn place(&self, t: f64) -> DVec2 {
        self.receiver.place.lerp(self.centre, t)
    }

    fn middle(&self) -> f64 {
        0.5 * (self.step[0].0 + self.step[1].0)
    }

    /// Takes the step that has the edge, from looks between all of them.
    fn look(&mut self, between: &[Met]) {
        let t = |k: usize| (k + 1) as f64 / STEPS as f64;
        let looks = between.iter().enumerate().map(|(k, &met)| (t(k), met));
        let looks: Vec<Look> = [self.step[0]].into_iter().chain(looks).chain([self.step[1]]).collect();
        let steps = || looks.windows(2).map(|two| [two[0], two[1]]).rev();
        let most = steps().map(|step| rise(&step).abs()).fold(0.0, f64::max);
        let mut edges = steps().filter(|step| rise(step).abs() >= MUCH * most);
        if let Some(step) = edges.next() {
            self.step = step;
            self.other = edges.next();
        }
        self.decide(0);
    }

    /// Takes the half of the step across which the height changes more.
    fn halve(&mut self, met: Met, halvings: u32) {
        let middle = (self.middle(), met);
        let halves = [[self.step[0], middle], [middle, self.step[1]]];
        self.step = if rise(&halves[0]).abs() > rise(&halves[1]).abs() { halves[0] } else { halves[1] };
        self.decide(halvings);
    }

    /// Decides what is between after a number of halvings.
    fn decide(&mut self, halvings: u32) {
        let [(from, near), (to, far)] = self.step;
        let length = (to - from) * self.receiver.place.distance(self.centre) * self.receiver.texel;
        let is_jump = rise(&self.step).abs() > STEEPEST * (1.0 + self.receiver.slope) * length;
        if near.face == far.face || (!is_jump && halvings >= CERTAIN) {
            self.between = Between::Surface;
        } else if is_jump && halvings >= PLACED {
            self.between = Between::Silhouette;
        }
    }

    /// How far the edge lies from the pixel in the image, pixels: the nearest point of the silhouette whose shadow ends within
    /// the step, as far as it is one edge of a triangle; no further than the end of the step towards the centre.
    pub fn displacement(&self, rays: &LightRays, eye: &Eye) -> f64 {
        let receiver = &self.receiver;
        let lookup = rays.lookups.map(receiver.map);
        let in_image = |place: DVec2| eye.pixel_of(lookup.on_plane_at(receiver.p, receiver.normal, place)?);
        let Some(pixel) = eye.pixel_of(receiver.p) else { return f64::INFINITY };
        let [near, far] = self.step.map(|(t, _)| in_image(self.place(t)));
        let (Some(near), Some(far)) = (near, far) else { return f64::INFINITY };
        let at_most = pixel.distance(far);
        let (dark, lit, way) = match rise(&self.step) > 0.0 {
            true => (self.step[1].1, near, far - near),
            false => (self.step[0].1, far, near - far),
        };
        if dark.triangle < 0 {
            return at_most;
        }
        let corners = rays.corners(dark).map(|corner| lookup.place_of(corner).and_then(in_image));
        let [Some(a), Some(b), Some(c)] = corners else { return at_most };
        // Of the triangle's edges that the step crosses, the one nearest to its lit end.
        let crossed = |[a, b]: [DVec2; 2]| {
            let side = way.perp_dot(b - a);
            let (s, t) = ((a - lit).perp_dot(b - a) / side, (a - lit).perp_dot(way) / side);
            ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some((s, [a, b]))
        };
        let edges = [[a, b], [b, c], [c, a]].into_iter().filter_map(crossed);
        let Some((_, [a, b])) = edges.min_by(|(s, _), (t, _)| s.total_cmp(t)) else { return at_most };
        let t = ((pixel - a).dot(b - a) / (b - a).length_squared()).clamp(-BEYOND, 1.0 + BEYOND);
        at_most.min(pixel.distance(a.lerp(b, t)))
    }
}

/// Finds what lies between the ends of ways.
pub(super) fn find(ways: &mut [Way], rays: &LightRays, progress: &Progress) -> Result<()> {
    let between = |way: &Way| {
        let way = *way;
        (1..STEPS).map(move |k| rays.at(&way.receiver, way.place(k as f64 / STEPS as f64)))
    };
    let asked: Vec<_> = ways.iter().flat_map(between).collect();
    for (way, met) in ways.iter_mut().zip(rays.met(&asked, progress)?.chunks(STEPS - 1)) {
        way.look(met);
    }
    halve(ways, rays, progress)?;
    // Where one surface fills the step that changes most, the edge may lie in another.
    for way in ways.iter_mut().filter(|way| way.between == Between::Surface) {
        if let Some(step) = way.other.take() {
            way.step = step;
            way.between = Between::Open;
            way.decide(0);
        }
    }
    halve(ways, rays, progress)
}

/// Halves the steps of open ways until all are decided.
fn halve(ways: &mut [Way], rays: &LightRays, progress: &Progress) -> Result<()> {
    for halvings in 1..=CERTAIN {
        let mut open: Vec<&mut Way> = ways.iter_mut().filter(|way| way.between == Between::Open).collect();
        let asked: Vec<_> = open.iter().map(|way| rays.at(&way.receiver, way.place(way.middle()))).collect();
        for (way, met) in open.iter_mut().zip(rays.met(&asked, progress)?) {
            way.halve(met, halvings);
        }
    }
    Ok(())
}

/// How far a receiver's own surface that is followed to a texel's centre can leave its plane, world units.
pub(super) fn rise_of_followed(receiver: &Receiver, centre: DVec2) -> f64 {
    FOLLOWED_RISE * (1.0 + receiver.slope) * receiver.place.distance(centre) * receiver.texel
}

/// Whether a receiver's own surface goes on below all else to what light meets at a texel's centre.
pub(super) fn continued(ways: &[(Receiver, DVec2, Met)], rays: &LightRays, progress: &Progress) -> Result<Vec<bool>> {
    let mut heights = vec![0.0; ways.len()];
    let mut is_same: Vec<bool> = vec![false; ways.len()];
    let mut open: Vec<usize> = (0..ways.len()).collect();
    for step in 1..=FOLLOWED {
        let rise =
            |(receiver, centre, _): &(Receiver, DVec2, Met)| rise_of_followed(receiver, *centre) / FOLLOWED as f64;
        let ask = |&w: &usize| {
            let (receiver, centre, _) = &ways[w];
            let place = receiver.place.lerp(*centre, step as f64 / FOLLOWED as f64);
            Asked { at_most: heights[w] + rise(&ways[w]), ..rays.at(receiver, place) }
        };
        let met = rays.met(&open.iter().map(ask).collect::<Vec<_>>(), progress)?;
        let mut next = Vec::with_capacity(open.len());
        for (&w, met) in open.iter().zip(met) {
            if met.height >= heights[w] - rise(&ways[w]) {
                next.push(w);
                heights[w] = met.height;
                is_same[w] = step == FOLLOWED && met.face == ways[w].2.face;
            }
        }
        open = next;
    }
    Ok(is_same)
}
