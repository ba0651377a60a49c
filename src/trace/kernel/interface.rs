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

/// What is met or nearly met, told apart by how near the edges that is: by a ray of the triangles of a packet, or of one triangle
/// by the rays of a bundle. A bit and an element for each.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct BandMeet<const N: usize> {
    /// Edges included, as in [`Meet`].
    pub hit: u32,
    /// Inside by more than the rays' band.
    pub inside: u32,
    /// Inside, or outside by no more than the band.
    pub near: u32,
    /// Of use where the bit of `hit` is set, and the bounds where that of `near` is.
    pub t: [f64; N],
    /// Bounds on t over the triangle, as in [`Pass`].
    pub t_low: [f64; N],
    pub t_high: [f64; N],
}

impl<const N: usize> BandMeet<N> {
    /// Nothing is met.
    pub const NONE: Self = Self { hit: 0, inside: 0, near: 0, t: [0.0; N], t_low: [0.0; N], t_high: [0.0; N] };

    /// What is told of a lane or a ray that is near.
    #[inline(always)]
    pub fn of(&self, k: usize) -> Pass {
        let has = |bits: u32| (bits >> k) & 1 != 0;
        // One by one: a list of the lists would be a copy of them.
        let (t, t_low, t_high) = (self.t[k], self.t_low[k], self.t_high[k]);
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
    /// Has something brought into the cache that is soon looked at.
    fn fetch<T>(place: &T);
    /// Children whose boxes the ray may meet before `limit` (bits), and where it enters them.
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]);
    /// Children whose boxes a ray within the hull may meet before `limit` (bits), and a lower bound of where.
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]);
    /// The rays that may meet a child's box, each before its limit.
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits;
    /// For each triangle those of some rays that may meet it, or pass it within the rays' band, at any t: none that the exact
    /// tests find to do so is left out (`Rough` in `rays`). With `AHEAD` only those that may meet it at t > 0.
    fn rays_near<const AHEAD: bool>(packet: &Packet, rays: &LocalRays<BUNDLE>, bits: RayBits) -> [RayBits; LEAF];
    /// Those of some rays that meet a triangle, and where, at any t: into `t`, where the bit is set.
    fn rays_meet(
        packet: &Packet,
        lane: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        t: &mut [f64; BUNDLE],
    ) -> RayBits;
    /// Those of some rays that meet or nearly meet a triangle, at any t.
    fn rays_pass(packet: &Packet, lane: usize, rays: &LocalRays<BUNDLE>, bits: RayBits) -> BandMeet<BUNDLE>;
    /// The triangles the ray meets, at any t.
    fn triangles(packet: &Packet, ray: &Line) -> Meet;
    /// The triangles the ray meets or nearly meets, at any t.
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet<LEAF>;
}
