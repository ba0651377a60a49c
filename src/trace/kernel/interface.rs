//! What a set of instructions has to answer.

use crate::trace::hierarchy::{LEAF, Node, Packet, WIDTH};
use crate::trace::rays::{BUNDLE, Bundle, Hull, Line, LocalRay, RayBits};

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

/// A set of instructions.
pub trait Kernel: Copy {
    /// Children whose boxes the ray may meet before `limit` (bits), and where it enters them.
    fn boxes(node: &Node, ray: &LocalRay, limit: f32) -> (u32, [f32; WIDTH]);
    /// Children whose boxes a ray within the hull may meet before `limit` (bits), and a lower bound of where.
    fn hull_boxes(node: &Node, hull: &Hull, limit: f32) -> (u32, [f32; WIDTH]);
    /// The rays that may meet a child's box, each before its limit.
    fn rays_in_box(node: &Node, child: usize, bundle: &Bundle, limits: &[f32; BUNDLE]) -> RayBits;
    /// The triangles the ray meets, at any t.
    fn triangles(packet: &Packet, ray: &Line) -> Meet;
    /// The triangles the ray meets or nearly meets, at any t.
    fn triangles_band(packet: &Packet, ray: &Line) -> BandMeet;
}
