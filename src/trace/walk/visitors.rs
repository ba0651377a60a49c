//! What is looked for along a ray.

use super::alpha::{existing, sift};
use super::touched::Touched;
use crate::trace::hierarchy::{Face, Packet, TracedMesh};
use crate::trace::kernel::Kernel;
use crate::trace::rays::Line;

/// Looks at triangles until it has seen enough.
pub trait Visitor {
    /// Whether near boxes are worth entering first.
    const IN_ORDER: bool;
    /// The part of the ray that still matters.
    fn range(&self) -> [f64; 2];
    /// Half-width of the band about edges, world units; 0 where the visitor does not ask.
    fn band(&self) -> f64;
    /// Looks at four triangles of a mesh; true ends the walk.
    fn visit<K: Kernel>(&mut self, mesh: &TracedMesh, packet: &Packet, ray: &Line, instance: u32) -> bool;
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
    pub fn with_ties(self, tie: f64) -> Self {
        Self { tie, ..self }
    }
    /// Whether a ray within the band of this one may meet another triangle first.
    pub fn is_near_edge(&self) -> bool {
        self.t_near_edge <= self.t
    }
    #[inline(always)]
    fn offer(&mut self, mut hit: u32, t: &[f64; 4], packet: &Packet, instance: u32) {
        while hit != 0 {
            let lane = hit.trailing_zeros() as usize % 4;
            hit &= hit - 1;
            let face = (instance, packet.triangles[lane]);
            if t[lane] <= self.t_min || t[lane] > self.t + self.tie {
                continue;
            }
            if let Some(best) = self.face {
                self.is_tied |= t[lane] >= self.t - self.tie;
                if t[lane] < self.t || (t[lane] == self.t && face < best) {
                    (self.t, self.face) = (t[lane], Some(face));
                }
            } else if t[lane] < self.t {
                (self.t, self.face) = (t[lane], Some(face));
            }
        }
    }
}

impl<const BAND: bool> Visitor for Closest<BAND> {
    const IN_ORDER: bool = true;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [self.t_min, self.t + self.tie]
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        if BAND { self.band } else { 0.0 }
    }
    #[inline(always)]
    fn visit<K: Kernel>(&mut self, mesh: &TracedMesh, packet: &Packet, ray: &Line, instance: u32) -> bool {
        if BAND {
            let mut meet = K::triangles_band(packet, ray);
            if meet.near != 0 {
                if mesh.is_tested {
                    sift(mesh, packet, &mut meet, ray);
                }
                self.offer(meet.hit, &meet.t, packet, instance);
                let mut edge = meet.near & !meet.inside & packet.used();
                while edge != 0 {
                    let lane = edge.trailing_zeros() as usize % 4;
                    edge &= edge - 1;
                    if meet.t_high[lane] >= self.t_min {
                        self.t_near_edge = self.t_near_edge.min(meet.t_low[lane].max(self.t_min));
                    }
                }
            }
        } else {
            let mut meet = K::triangles(packet, ray);
            if mesh.is_tested && meet.hit != 0 {
                meet.hit = existing(mesh, packet, meet.hit, ray);
            }
            self.offer(meet.hit, &meet.t, packet, instance);
        }
        false
    }
}

/// Whether anything but some faces lies strictly between two values of t.
#[derive(Debug, Clone, Copy)]
pub struct Blocked<'a> {
    pub t_min: f64,
    pub t_max: f64,
    pub except: Option<Face>,
    /// More that is left out.
    pub touched: &'a Touched,
}

impl Visitor for Blocked<'_> {
    const IN_ORDER: bool = false;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [self.t_min, self.t_max]
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        0.0
    }
    #[inline(always)]
    fn visit<K: Kernel>(&mut self, mesh: &TracedMesh, packet: &Packet, ray: &Line, instance: u32) -> bool {
        let mut meet = K::triangles(packet, ray);
        if mesh.is_tested && meet.hit != 0 {
            meet.hit = existing(mesh, packet, meet.hit, ray);
        }
        (0..4).any(|lane| {
            let t = meet.t[lane];
            (meet.hit >> lane) & 1 != 0
                && t > self.t_min
                && t < self.t_max
                && self.except != Some((instance, packet.triangles[lane]))
                && !self.touched.has((instance, packet.triangles[lane]))
        })
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

impl Visitor for SurelyBlocked<'_> {
    const IN_ORDER: bool = false;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        self.possible
    }
    #[inline(always)]
    fn band(&self) -> f64 {
        self.band
    }
    #[inline(always)]
    fn visit<K: Kernel>(&mut self, mesh: &TracedMesh, packet: &Packet, ray: &Line, instance: u32) -> bool {
        let mut meet = K::triangles_band(packet, ray);
        if mesh.is_tested && meet.near != 0 {
            sift(mesh, packet, &mut meet, ray);
        }
        let mut near = meet.near & packet.used();
        while near != 0 {
            let lane = near.trailing_zeros() as usize % 4;
            near &= near - 1;
            let face = (instance, packet.triangles[lane]);
            if self.except == face || self.touched.has(face) {
                continue;
            }
            let t = meet.t[lane];
            if (meet.inside >> lane) & 1 != 0 && t > self.sure[0] && t < self.sure[1] {
                return true;
            }
            self.is_possible |= meet.t_high[lane] > self.possible[0] && meet.t_low[lane] < self.possible[1];
        }
        false
    }
}
