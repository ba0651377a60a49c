//! Looks at what light meets, one after the other, that remember what they saw: many wrong pixels share a texel, and what shades
//! one of them shades the next.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::caster::Caster;
use super::kept::Kept;
use super::rays::{LightRays, Met, Receiver};
use super::way::{is_continued, steepest_rise};
use crate::aliasing::causes::Tap;
use crate::trace::{OneByOne, Tracer};

/// How far from a texel's centre what it holds may be met, texels: rasterisers round vertices to 1/256 of a texel, and the
/// ray that grazes what they drew has to lie within.
const SNAP: f64 = 1.0 / 128.0;
/// Where a texel that a ray through its centre does not confirm is asked again.
const ABOUT: [DVec2; 4] =
    [DVec2::new(-SNAP, 0.0), DVec2::new(SNAP, 0.0), DVec2::new(0.0, -SNAP), DVec2::new(0.0, SNAP)];
/// Casters that are remembered of a texel: the last ones.
const REMEMBERED: usize = 8;
/// How far beyond an edge it is looked whether the shadow goes on, ways.
const BEYOND: f64 = 1.0 / 256.0;
/// Triangles whose edges are looked at one by one. Among more of them, narrower than [`STEP`], looks are that far apart.
const SINGLE: usize = 3;
/// An eighth of a texel.
const STEP: f64 = 1.0 / 8.0;
/// Parts of a texel's side within which a shadow that ends at an edge is taken to end all along it.
const ALONG: f64 = 8.0;
/// Parts of a texel within which receivers are about as far from its centre.
const FAR: f64 = 4.0;
/// Parts of a texel's side that are as light as a place in them, where looks are [`STEP`] apart.
const CELLS: f64 = 16.0;

/// What is known of a texel.
#[derive(Debug, Default)]
struct Texel<'a> {
    /// What the map stores of the ray through its centre.
    centre: Option<Kept>,
    /// The same at [`ABOUT`].
    about: Option<[Kept; 4]>,
    /// What shades receivers in it; from [`REMEMBERED`] on in a circle.
    casters: Vec<Caster<'a>>,
    /// Casters that were found.
    found: usize,
    /// Whether what is at the centre continues a receiver's face, from how far, parts of a texel.
    continued: Vec<(From, bool)>,
    /// Edges of triangles behind which it is light, in which part of the map, and down to which distance from the light.
    ends: Vec<(End, f64)>,
}

/// A receiver's face, and how far away it is.
type From = ((i32, i32), i32);
/// An edge of a triangle.
type Edge = ((i32, i32), usize);
/// The same, and where along it.
type End = (Edge, [i32; 2]);

/// A straight way on a receiver's plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// Where it begins, relative to the origin.
    pub from: DVec3,
    /// From there to where it ends.
    pub along: DVec3,
    /// Its ends in the map, texels.
    pub places: [DVec2; 2],
}

impl Way {
    /// From a receiver to where the ray of a place in the map meets its plane.
    pub fn new(receiver: &Receiver, place: DVec2, rays: &LightRays) -> Self {
        let from = receiver.p;
        Self { from, along: rays.at(receiver, place) - from, places: [receiver.place, place] }
    }

    /// The other way.
    pub fn back(&self) -> Self {
        let [a, b] = self.places;
        Self { from: self.from + self.along, along: -self.along, places: [b, a] }
    }

    /// The part that is left from a place on.
    pub fn after(&self, t: f64) -> Self {
        Self { from: self.at(t), along: (1.0 - t) * self.along, places: [self.place(t), self.places[1]] }
    }

    /// A part of the way from its beginning.
    pub fn at(&self, t: f64) -> DVec3 {
        self.from + t * self.along
    }

    /// The same in the map, texels.
    pub fn place(&self, t: f64) -> DVec2 {
        self.places[0].lerp(self.places[1], t)
    }

    /// Texels.
    pub fn length(&self) -> f64 {
        self.places[0].distance(self.places[1])
    }
}

/// How far it is dark along a way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dark {
    /// Up to which part of the way.
    pub to: f64,
    /// The edge of a triangle whose shadow ends there; none where a surface sinks below the receiver's plane or has a hole.
    pub edge: Option<[DVec3; 2]>,
    /// Whether all of it is dark.
    pub is_all: bool,
    /// Whether, on the way or at its end, what light meets falls or rises further than a surface could have.
    pub is_jump: bool,
}

/// Whether a ray gives what a texel holds: within a texel and a step of the map's numbers, both not above the receiver's plane, or
/// rounded to no caster.
fn is_what_is_held(kept: &Kept, receiver: &Receiver, tap: &Tap) -> bool {
    (kept.height - tap.gap).abs() <= receiver.texel * (1.0 + receiver.slope) + tap.step
        || kept.height.max(tap.gap) <= receiver.grain
        || (tap.gap == f64::NEG_INFINITY && kept.is_at_end)
}

/// Looks at what light meets.
pub(super) struct Looker<'a> {
    /// What they are made of.
    pub rays: &'a LightRays<'a>,
    tracer: OneByOne<'a>,
    known: HashMap<(usize, i64, i64), usize>,
    texels: Vec<Texel<'a>>,
    /// Of parts of maps, what shades them: what was met, and the distance from the light above which nothing else is.
    cells: HashMap<(usize, [i32; 2]), (Met, f64)>,
    /// The texel that was asked for last.
    last: ((usize, i64, i64), usize),
}

impl<'a> Looker<'a> {
    /// One that knows nothing.
    pub fn new(rays: &'a LightRays<'a>, tracer: &'a Tracer) -> Self {
        let tracer = tracer.one_by_one();
        Self {
            rays,
            tracer,
            known: HashMap::new(),
            texels: Vec::new(),
            cells: HashMap::new(),
            last: ((usize::MAX, 0, 0), 0),
        }
    }

    /// What light meets behind the near plane on the ray through a point, between two heights.
    pub fn met(&mut self, receiver: &Receiver, point: DVec3, between: [f64; 2]) -> Met {
        self.rays.met(&mut self.tracer, receiver.map, point, between)
    }

    /// What light meets above a point, whether a map holds it or not.
    pub fn met_from_light(&mut self, point: DVec3) -> Met {
        self.rays.met_from_light(&mut self.tracer, point)
    }

    /// What is known of the texel at a place.
    fn texel(&mut self, map: usize, place: DVec2) -> &mut Texel<'a> {
        let key = (map, place.x.floor() as i64, place.y.floor() as i64);
        if self.last.0 != key {
            let next = self.texels.len();
            let k = *self.known.entry(key).or_insert(next);
            if k == next {
                self.texels.push(Texel::default());
            }
            self.last = (key, k);
        }
        &mut self.texels[self.last.1]
    }

    /// What the map stores of the ray through the texel's centre at the end of a way, seen from there.
    pub fn at_end(&mut self, receiver: &Receiver, way: &Way) -> Kept {
        let (point, centre) = (way.at(1.0), way.places[1]);
        let kept = match self.texel(receiver.map, centre).centre {
            Some(kept) => kept,
            None => {
                let kept = self.rays.kept(&mut self.tracer, receiver.map, point);
                self.texel(receiver.map, centre).centre = Some(kept);
                kept
            }
        };
        kept.seen_from(point, self.rays.to_light(point))
    }

    /// The same, where it is what the texel holds. Nothing where light meets nothing that gives the texel's depth.
    pub fn confirmed(&mut self, receiver: &Receiver, way: &Way, tap: &Tap) -> Option<Kept> {
        let is_right = |kept: &Kept| is_what_is_held(kept, receiver, tap);
        let (kept, centre) = (self.at_end(receiver, way), way.places[1]);
        if is_right(&kept) {
            return Some(kept);
        }
        let points = ABOUT.map(|step| self.rays.at(receiver, centre + step));
        let about = match self.texel(receiver.map, centre).about {
            Some(about) => about,
            None => {
                let about = points.map(|point| self.rays.kept(&mut self.tracer, receiver.map, point));
                self.texel(receiver.map, centre).about = Some(about);
                about
            }
        };
        let mut seen = about.into_iter().zip(points).map(|(kept, at)| kept.seen_from(at, self.rays.to_light(at)));
        seen.find(is_right)
    }

    /// Whether the very centre of the texel at the end of a way is in shadow, and the texel holds what its ray gives.
    pub fn is_dark_and_held(&mut self, receiver: &Receiver, way: &Way, tap: &Tap) -> bool {
        let kept = self.at_end(receiver, way);
        kept.first.height > receiver.grain && is_what_is_held(&kept, receiver, tap)
    }

    /// Whether a receiver's own surface goes on below all else to what light meets at the texel's centre at the end of a way:
    /// the same for all of its face that is about as far away.
    pub fn is_continued(&mut self, receiver: &Receiver, way: &Way, end: &Met) -> bool {
        let key = (receiver.face, (FAR * way.length()) as i32);
        let known = self.texel(receiver.map, way.places[1]).continued.iter().find(|(known, _)| *known == key);
        if let Some((_, is_continued)) = known {
            return *is_continued;
        }
        let is_continued = is_continued(self, receiver, way, end);
        self.texel(receiver.map, way.places[1]).continued.push((key, is_continued));
        is_continued
    }

    /// The triangle that was met.
    pub fn caster(&self, met: &Met) -> Caster<'a> {
        Caster::new(met, self.rays.corners(met), self.rays.alpha_test(met), self.rays.light)
    }

    /// Of what shades the receiver's texel elsewhere, the first that keeps the light from a point on the receiver's plane, too.
    pub fn known(&mut self, receiver: &Receiver, point: DVec3) -> Option<Caster<'a>> {
        let to_light = self.rays.to_light(point);
        let shades = |caster: &&Caster| caster.shades(point) && caster.height(point, to_light) > receiver.touch;
        let known = self.texel(receiver.map, receiver.place).casters.iter().filter(shades);
        known.max_by(|a, b| a.height(point, to_light).total_cmp(&b.height(point, to_light))).copied()
    }

    /// What keeps the light from a point on the receiver's plane, by a ray.
    pub fn shade(&mut self, receiver: &Receiver, point: DVec3) -> Option<Caster<'a>> {
        let met = self.met(receiver, point, [receiver.touch, f64::INFINITY]);
        (met.triangle >= 0).then(|| self.remember(receiver, &met))
    }

    /// A triangle that shades receivers in a texel.
    pub fn remember(&mut self, receiver: &Receiver, met: &Met) -> Caster<'a> {
        let caster = self.caster(met);
        let texel = self.texel(receiver.map, receiver.place);
        if !texel.casters.iter().any(|known| known.triangle == caster.triangle) {
            match texel.casters.len() < REMEMBERED {
                true => texel.casters.push(caster),
                false => texel.casters[texel.found % REMEMBERED] = caster,
            }
            texel.found += 1;
        }
        caster
    }

    /// How far the shadow goes along a way that begins in that of a caster.
    pub fn dark(&mut self, receiver: &Receiver, way: &Way, mut caster: Caster<'a>) -> Dark {
        let (mut t, mut triangles, mut is_jump, step) = (0.0, 0, false, STEP / way.length().max(STEP));
        loop {
            let (exit, edge) = caster.exit(way.from, way.along);
            let exit = exit.max(t);
            let hole = caster.hole(way.from, way.along, [t, exit.min(1.0)]);
            let exit = hole.unwrap_or(exit);
            let edge = if hole.is_some() { None } else { Some(edge) };
            let sinks = caster.sinks(way.from, way.along, t);
            if sinks < exit.min(1.0) {
                return Dark { to: sinks, edge: None, is_all: false, is_jump };
            }
            let is_single = triangles < SINGLE || (exit - t) * way.length() >= STEP;
            let next = if is_single { exit + BEYOND } else { (exit + BEYOND).max(t + step) };
            let height = caster.height(way.at(exit), self.rays.to_light(way.at(exit)));
            let rise = steepest_rise(receiver, (next - exit) * way.length());
            let (to, edge_ends) = (exit.min(1.0), edge.map(|k| caster.edge(k)));
            let found = Dark { to, edge: edge_ends, is_all: next >= 1.0, is_jump: is_jump || height > rise };
            if found.is_all {
                return found;
            }
            let beyond = match is_single {
                true => self.beyond(receiver, way, [exit, next], edge.map(|k| (caster.triangle, k))),
                false => self.about(receiver, way, next),
            };
            let Some(beyond) = beyond else { return found };
            let point = way.at(next);
            is_jump |= (beyond.height(point, self.rays.to_light(point)) - height).abs() > rise;
            (caster, t, triangles) = (beyond, next, triangles + 1);
        }
    }

    /// What shades a place on a way, right after the end of a triangle's shadow, at one of its edges or at a hole in it.
    fn beyond(
        &mut self,
        receiver: &Receiver,
        way: &Way,
        [exit, next]: [f64; 2],
        edge: Option<Edge>,
    ) -> Option<Caster<'a>> {
        let point = way.at(next);
        if let Some(known) = self.known(receiver, point) {
            return Some(known);
        }
        // Light of a hole is not all along an edge.
        let Some(edge) = edge else { return self.shade(receiver, point) };
        let end: End = (edge, (ALONG * way.place(exit)).floor().as_ivec2().to_array());
        let distance = self.rays.distance(point);
        let ends = &mut self.texel(receiver.map, receiver.place).ends;
        if ends.iter().any(|(known, down_to)| *known == end && distance <= *down_to) {
            return None;
        }
        let found = self.shade(receiver, point);
        if found.is_none() {
            // As deep as the receiver's plane may lie elsewhere along the edge.
            let down_to = distance + receiver.texel * (1.0 + receiver.slope) / ALONG;
            self.texel(receiver.map, receiver.place).ends.push((end, down_to));
        }
        found
    }

    /// What shades the part of the map about a place on a way.
    pub fn about(&mut self, receiver: &Receiver, way: &Way, t: f64) -> Option<Caster<'a>> {
        let point = way.at(t);
        if let Some(known) = self.known(receiver, point) {
            return Some(known);
        }
        let key = (receiver.map, (CELLS * way.place(t)).floor().as_ivec2().to_array());
        let distance = self.rays.distance(point);
        match self.cells.get(&key) {
            Some((met, down_to)) if met.triangle < 0 && distance <= *down_to => return None,
            Some((met, down_to)) if met.triangle >= 0 && distance - receiver.touch > *down_to => {
                return Some(self.caster(met));
            }
            _ => {}
        }
        let met = self.met(receiver, point, [receiver.touch, f64::INFINITY]);
        let is_dark = met.triangle >= 0;
        let down_to = match is_dark {
            true => self.rays.distance(met.at),
            // As deep as the receiver's plane may lie elsewhere in the part.
            false => distance + receiver.texel * (1.0 + receiver.slope) / CELLS,
        };
        self.cells.insert(key, (met, down_to));
        is_dark.then(|| self.caster(&met))
    }
}
