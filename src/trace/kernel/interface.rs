//! What a set of instructions has to answer.

use super::exact::Pass;
use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{BUNDLE, Bundle, Hull, Line, LocalRay, LocalRays, RayBits};

/// Which lanes a ray meets, edges included, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meet {
    /// Bit per lane.
    pub hit: u32,
    pub t: [f64; LEAF],
}

/// As [`Meet`], told apart by how near the edges the ray passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandMeet {
    /// Edges included, as in [`Meet`].
    pub hit: u32,
    /// Inside by more than the ray's band.
    pub inside: u32,
    /// Inside, or outside by no more than the band.
    pub near: u32,
    pub t: [f64; LEAF],
    /// Bounds on t over the triangle, whatever the displacement.
    pub t_low: [f64; LEAF],
    pub t_high: [f64; LEAF],
}

impl BandMeet {
    /// What is told of a lane that is near.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> Pass {
        let has = |bits: u32| (bits >> lane) & 1 != 0;
        let [t, t_low, t_high] = [self.t, self.t_low, self.t_high].map(|t| t[lane]);
        Pass { is_hit: has(self.hit), is_inside: has(self.inside), t, t_low, t_high }
    }
}

/// The lanes in a set.
#[derive(Debug, Clone, Copy)]
pub struct Lanes(pub u32);

impl Iterator for Lanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize % LEAF;
        let is_left = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        is_left.then_some(lane)
    }
}

/// A set of instructions.
pub trait Kernel: Copy {
    /// Children whose boxes the ray may meet before `limit` (bits), and where it enters them.
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]);
    /// Children whose boxes a ray within the hull may meet before `limit` (bits), and a lower bound of where.
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]);
    /// The rays that may meet a child's box, each before its limit.
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits;
    /// For each triangle the rays that may meet it, or pass it within the rays' band, at any t: none that the exact tests find
    /// to do so is left out (`Rough` in `rays`).
    fn rays_near(packet: &Packet, rays: &LocalRays<BUNDLE>) -> [RayBits; LEAF];
    /// The triangles the ray meets, at any t.
    fn triangles(packet: &Packet, ray: &Line) -> Meet;
    /// The triangles the ray meets or nearly meets, at any t.
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet;
}
