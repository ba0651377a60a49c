//! What is looked for along a ray.

use super::alpha::{existing, sift};
use crate::trace::hierarchy::{Packet, TracedMesh};
use crate::trace::kernel::Kernel;
use crate::trace::rays::Line;

/// A triangle of an instance.
pub type Face = (u32, u32);

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
    /// Smallest t at which the ray passes a triangle's edge within the band.
    t_near_edge: f64,
}

impl<const BAND: bool> Closest<BAND> {
    /// For `t_min < t < t_max`.
    pub fn new(t_min: f64, t_max: f64, band: f64) -> Self {
        Self { t_min, band, t: t_max, face: None, t_near_edge: f64::INFINITY }
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
            let first = t[lane] < self.t || (t[lane] == self.t && self.face.is_some_and(|best| face < best));
            if t[lane] > self.t_min && first {
                (self.t, self.face) = (t[lane], Some(face));
            }
        }
    }
}

impl<const BAND: bool> Visitor for Closest<BAND> {
    const IN_ORDER: bool = true;

    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [self.t_min, self.t]
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

/// Whether anything but one face lies strictly between two values of t.
#[derive(Debug, Clone, Copy)]
pub struct Blocked {
    pub t_min: f64,
    pub t_max: f64,
    pub except: Option<Face>,
}

impl Visitor for Blocked {
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
        })
    }
}

/// Whether anything but one face surely lies between two values of t, however the ray moves within the band, and
/// whether something may.
#[derive(Debug, Clone, Copy)]
pub struct SurelyBlocked {
    /// Bounds of what is sure.
    pub sure: [f64; 2],
    /// Bounds of what is possible.
    pub possible: [f64; 2],
    pub band: f64,
    pub except: Face,
    /// Something may be in the way.
    pub is_possible: bool,
}

impl Visitor for SurelyBlocked {
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
            if self.except == (instance, packet.triangles[lane]) {
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
