//! What is looked for along a ray.

use super::alpha::{exists, sifted};
use super::touched::Touched;
use crate::trace::hierarchy::{Face, NO_ITEM, Packet, TracedMesh};
use crate::trace::kernel::{Kernel, Lanes, Pass};
use crate::trace::rays::{BUNDLE, Each, Line, LocalRays, RayBits, Shared};

/// Looks at triangles until it has seen enough.
pub trait Visitor: Clone {
    /// Whether what it sees shortens the part of the ray that matters, so that near boxes are worth entering first.
    const IN_ORDER: bool;
    /// Whether triangles that a ray meets at t <= 0 are nothing to it, and those that it nearly meets neither.
    const AHEAD: bool;
    /// Whether it sees those that a ray nearly meets, too.
    const NEARLY: bool;
    /// What rays of a bundle with this visitor mostly have in common.
    const SHARED: Shared;
    /// The part of the ray that still matters.
    fn range(&self) -> [f64; 2];
    /// Half-width of the band about edges, world units; 0 where the visitor does not ask.
    fn band(&self) -> f64;
    /// Whether a triangle is nothing to it wherever it is met: then it need not be tested.
    #[inline(always)]
    fn skips(&self, _: Face) -> bool {
        false
    }
    /// Looks at one triangle; true ends the walk.
    fn see(&mut self, face: Face, pass: Pass) -> bool;

    /// Looks at four triangles of a mesh; true ends the walk.
    #[inline(always)]
    fn visit<K: Kernel>(&mut self, leaf: &Shown, ray: &Line) -> bool {
        let see = |face, pass| self.see(face, pass);
        if Self::NEARLY { leaf.pass::<K>(ray, see) } else { leaf.meet::<K>(ray, see) }
    }
    /// Lets those of a bundle whose bits are set look at one of them; those whose walk ends.
    #[inline(always)]
    fn visit_together<K: Kernel>(
        visitors: &mut [Self; BUNDLE],
        leaf: &Shown,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
    ) -> RayBits {
        let see = |r: usize, face, pass| visitors[r].see(face, pass);
        if Self::NEARLY {
            leaf.pass_together::<K>(lane, rays, bits, see)
        } else {
            leaf.meet_together::<K>(lane, rays, bits, see)
        }
    }
}

/// Four triangles of a mesh, and the instance whose they are.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    pub mesh: &'a TracedMesh,
    pub packet: &'a Packet,
    pub instance: u32,
}

impl Shown<'_> {
    /// One of them.
    #[inline(always)]
    pub fn face(&self, lane: usize) -> Face {
        (self.instance, self.packet.triangles[lane])
    }
    /// Shows the triangles that a ray meets, and where, until one ends it.
    #[inline(always)]
    fn meet<K: Kernel>(&self, ray: &Line, mut see: impl FnMut(Face, Pass) -> bool) -> bool {
        let meet = K::triangles(self.packet, ray);
        for lane in Lanes(meet.hit) {
            if self.is_there(lane, || *ray) && see(self.face(lane), Pass::met(meet.t[lane])) {
                return true;
            }
        }
        false
    }
    /// Shows one of them to those of some rays that meet it; those that it ends.
    #[inline(always)]
    fn meet_together<K: Kernel>(
        &self,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        mut see: impl FnMut(usize, Face, Pass) -> bool,
    ) -> RayBits {
        let mut t = [0.0; BUNDLE];
        let (hit, face) = (K::rays_meet(self.packet, lane, rays, bits, &mut t), self.face(lane));
        let mut ended = 0;
        for r in Each(hit) {
            let is_seen = self.is_there(lane, || rays.line(r)) && see(r, face, Pass::met(t[r]));
            ended |= u32::from(is_seen) << r;
        }
        ended
    }
    /// Shows the triangles that a ray meets or nearly meets, until one ends it.
    #[inline(always)]
    fn pass<K: Kernel>(&self, ray: &Line, mut see: impl FnMut(Face, Pass) -> bool) -> bool {
        let meet = K::triangles_band(self.packet, ray);
        if meet.near == 0 {
            return false;
        }
        for lane in Lanes(meet.near & self.packet.used()) {
            let face = self.face(lane);
            if self.sifted(lane, meet.of(lane), || *ray, |pass| see(face, pass)) {
                return true;
            }
        }
        false
    }
    /// Shows one of them to those of some rays that meet or nearly meet it; those that it ends.
    #[inline(always)]
    fn pass_together<K: Kernel>(
        &self,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        mut see: impl FnMut(usize, Face, Pass) -> bool,
    ) -> RayBits {
        if self.packet.triangles[lane] == NO_ITEM {
            return 0;
        }
        let (found, face) = (K::rays_pass(self.packet, lane, rays, bits), self.face(lane));
        let mut ended = 0;
        for r in Each(found.near) {
            let is_seen = self.sifted(lane, found.of(r), || rays.line(r), |pass| see(r, face, pass));
            ended |= u32::from(is_seen) << r;
        }
        ended
    }
    /// Whether a triangle that a ray meets exists there; the ray is asked for where that is in question.
    #[inline(always)]
    fn is_there(&self, lane: usize, ray: impl FnOnce() -> Line) -> bool {
        !self.mesh.is_tested || exists(self.mesh, self.packet, lane, &ray())
    }
    /// Shows what is left of a triangle that a ray meets or nearly meets; the ray is asked for where that is in question.
    #[inline(always)]
    fn sifted(&self, lane: usize, pass: Pass, ray: impl FnOnce() -> Line, see: impl FnOnce(Pass) -> bool) -> bool {
        // Without a question the pass stays in registers, which an option of it does not.
        if self.mesh.is_tested {
            sifted(self.mesh, self.packet, lane, pass, &ray()).is_some_and(see)
        } else {
            see(pass)
        }
    }
}

/// The first triangle along a ray. Of several at the same t, the lowest instance, then the lowest triangle.
#[derive(Debug, Clone, Copy)]
pub struct Closest<const BAND: bool> {
    t_min: f64,
    band: f64,
    pub t: f64,
    pub face: Option<Face>,
    /// How much farther another triangle may be met and still tie with the first.
    tie: f64,
    /// Whether any does.
    pub is_tied: bool,
    /// Smallest t at which the ray passes a triangle's edge within the band.
    t_near_edge: f64,
}

impl<const BAND: bool> Closest<BAND> {
    /// For `t_min < t < t_max`.
    pub fn new(t_min: f64, t_max: f64, band: f64) -> Self {
        Self { t_min, band, t: t_max, face: None, tie: 0.0, is_tied: false, t_near_edge: f64::INFINITY }
    }
    /// Notes ties: see [`first_of_ties`](super::first_of_ties).
    #[inline(always)]
    pub fn note_ties(&mut self, tie: f64) {
        self.tie = tie;
    }
    /// Whether a ray within the band of this one may meet another triangle first.
    pub fn is_near_edge(&self) -> bool {
        self.t_near_edge <= self.t
    }
    #[inline(always)]
    fn offer(&mut self, face: Face, t: f64) {
        if t <= self.t_min || t > self.t + self.tie {
            return;
        }
        if let Some(best) = self.face {
            self.is_tied |= t >= self.t - self.tie;
            if t < self.t || (t == self.t && face < best) {
                (self.t, self.face) = (t, Some(face));
            }
        } else if t < self.t {
            (self.t, self.face) = (t, Some(face));
        }
    }
}

impl<const BAND: bool> Visitor for Closest<BAND> {
    const IN_ORDER: bool = true;
    const AHEAD: bool = false;
    const NEARLY: bool = BAND;
    const SHARED: Shared = Shared::Origin;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [self.t_min, self.t + self.tie]
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        if BAND { self.band } else { 0.0 }
    }
    #[inline(always)]
    fn see(&mut self, face: Face, pass: Pass) -> bool {
        if pass.is_hit {
            self.offer(face, pass.t);
        }
        if !pass.is_inside && pass.t_high >= self.t_min {
            self.t_near_edge = self.t_near_edge.min(pass.t_low.max(self.t_min));
        }
        false
    }
}

/// Whether anything but some faces lies strictly between t = 0 and another value.
#[derive(Debug, Clone, Copy)]
pub struct Blocked<'a> {
    pub t_max: f64,
    pub except: Option<Face>,
    /// More that is left out.
    pub touched: &'a Touched,
}

impl Visitor for Blocked<'_> {
    const IN_ORDER: bool = false;
    const AHEAD: bool = true;
    const NEARLY: bool = false;
    const SHARED: Shared = Shared::Direction;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [0.0, self.t_max]
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        0.0
    }
    #[inline(always)]
    fn skips(&self, face: Face) -> bool {
        self.except == Some(face)
    }
    #[inline(always)]
    fn see(&mut self, face: Face, Pass { t, .. }: Pass) -> bool {
        t > 0.0 && t < self.t_max && self.except != Some(face) && !self.touched.has(face)
    }
}

/// Whether anything but some faces surely lies between two values of t, however the ray moves within the band, and
/// whether something may.
#[derive(Debug, Clone, Copy)]
pub struct SurelyBlocked<'a> {
    /// Bounds of what is sure.
    pub sure: [f64; 2],
    /// Bounds of what is possible.
    pub possible: [f64; 2],
    pub band: f64,
    pub except: Face,
    /// More that is left out.
    pub touched: &'a Touched,
    /// Something may be in the way.
    pub is_possible: bool,
}

impl<'a> SurelyBlocked<'a> {
    /// Before it is said where.
    #[inline(always)]
    pub fn nowhere(band: f64, touched: &'a Touched) -> Self {
        Self { sure: [0.0; 2], possible: [0.0; 2], band, except: (0, 0), touched, is_possible: false }
    }
}

impl Visitor for SurelyBlocked<'_> {
    const IN_ORDER: bool = false;
    const AHEAD: bool = false;
    const NEARLY: bool = true;
    const SHARED: Shared = Shared::Direction;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        self.possible
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        self.band
    }
    #[inline(always)]
    fn skips(&self, face: Face) -> bool {
        self.except == face
    }
    #[inline(always)]
    fn see(&mut self, face: Face, pass: Pass) -> bool {
        if self.except == face || self.touched.has(face) {
            return false;
        }
        if pass.is_inside && pass.t > self.sure[0] && pass.t < self.sure[1] {
            return true;
        }
        self.is_possible |= pass.t_high > self.possible[0] && pass.t_low < self.possible[1];
        false
    }
}
