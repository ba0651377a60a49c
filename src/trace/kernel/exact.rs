//! A ray and one triangle, in f64: what is met, edges included. Both kernels use it, and a test holds their tests of four
//! triangles at once to its bits.

use crate::trace::hierarchy::Packet;
use crate::trace::rays::Line;

/// A ray that meets a triangle, or passes an edge of it within the ray's band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// It meets the triangle, edges included.
    pub is_hit: bool,
    /// It passes inside by more than the band.
    pub is_inside: bool,
    /// Where it meets it; of use where it does.
    pub t: f64,
    /// Bounds on t over the triangle, whatever the displacement; the upper one of a ray that passes inside holds for rays
    /// beside it alone, as in [`MOVED`].
    pub t_low: f64,
    pub t_high: f64,
}

/// Rays that begin within this many bands of another and travel along it meet a triangle that it passes inside at no larger t than
/// is told; those that meet it at t = 1 do so at a negative t where that is negative.
///
/// An edge function changes by at most its margin for each band that a ray moves, so t on the triangle's plane by at most
/// `e = (sum of margins / area) * (t_high - t_low)`; a band along the ray adds as much as it takes to travel that far. Of rays that
/// meet at t = 1, `t' = (t - e) / (1 - e)` has the sign of `t - e` where e is below 1. Chosen because such rays begin at most a band
/// off across a surface and as much above it, which is 1.42; what f64 rounds is below half a band.
pub const MOVED: f64 = 2.0;

impl Pass {
    /// Of a ray that meets a triangle, where edges are not asked about.
    #[inline(always)]
    pub fn met(t: f64) -> Self {
        Self { is_hit: true, is_inside: true, t, t_low: t, t_high: t }
    }
}

/// A vertex in sheared coordinates: the ray is the z axis.
#[inline(always)]
fn sheared(packet: &Packet, ray: &Line, vertex: usize, lane: usize) -> [f64; 3] {
    let v = &packet.vertices[vertex];
    let relative = |axis: usize| f64::from(v[ray.axes[axis] % 3][lane]) - ray.origin[axis];
    let z = relative(2);
    [relative(0) - ray.shear[0] * z, relative(1) - ray.shear[1] * z, z]
}

/// The edge function of the edge a to b: twice the signed area with the ray. Exactly antisymmetric, and its sign is
/// never wrong, only zero at worst: rounding is monotonous. So triangles that share an edge leave no gap.
#[inline(always)]
fn edge(a: [f64; 3], b: [f64; 3]) -> f64 {
    b[0] * a[1] - b[1] * a[0]
}

/// The vertices in sheared coordinates, and the edge function opposite each.
#[inline(always)]
fn edges(packet: &Packet, lane: usize, ray: &Line) -> ([[f64; 3]; 3], [f64; 3]) {
    // Not a map over the three: the compiler leaves that a call.
    let (a, b, c) = (sheared(packet, ray, 0, lane), sheared(packet, ray, 1, lane), sheared(packet, ray, 2, lane));
    ([a, b, c], [edge(b, c), edge(c, a), edge(a, b)])
}

/// Where the ray meets a triangle with these vertices and edge functions.
#[inline(always)]
fn met([a, b, c]: &[[f64; 3]; 3], [u, v, w]: [f64; 3], ray: &Line) -> Option<f64> {
    let area = (u + v) + w;
    let forward = (u >= 0.0) & (v >= 0.0) & (w >= 0.0);
    let backward = (u <= 0.0) & (v <= 0.0) & (w <= 0.0);
    if (forward | backward) & (area != 0.0) {
        Some(((u * a[2] + v * b[2]) + w * c[2]) * ray.t_per_z / area)
    } else {
        None
    }
}

/// Where the ray meets a triangle of a packet, at any t.
#[inline(always)]
pub fn triangle(packet: &Packet, lane: usize, ray: &Line) -> Option<f64> {
    let (vertices, edges) = edges(packet, lane, ray);
    met(&vertices, edges, ray)
}

/// How the ray meets or nearly meets a triangle of a packet, at any t.
#[inline(always)]
pub fn triangle_band(packet: &Packet, lane: usize, ray: &Line) -> Option<Pass> {
    let (vertices, edges) = edges(packet, lane, ray);
    let [a, b, c] = vertices;
    // The band's width times a bound on the edge's length.
    let margin = |a: [f64; 3], b: [f64; 3]| ((b[0] - a[0]).abs() + (b[1] - a[1]).abs()) * ray.band;
    let margins = [margin(b, c), margin(c, a), margin(a, b)];
    let [u, v, w] = edges;
    let [over_a, over_b, over_c] = margins;
    let near_forward = (u >= -over_a) & (v >= -over_b) & (w >= -over_c);
    let near_backward = (u <= over_a) & (v <= over_b) & (w <= over_c);
    if !(near_forward | near_backward) {
        return None;
    }
    let inside_forward = (u > over_a) & (v > over_b) & (w > over_c);
    let inside_backward = (u < -over_a) & (v < -over_b) & (w < -over_c);
    let met = met(&vertices, edges, ray);
    let [ta, tb, tc] = [a[2] * ray.t_per_z, b[2] * ray.t_per_z, c[2] * ray.t_per_z];
    let (t, t_low, mut t_high) = (met.unwrap_or(0.0), ta.min(tb).min(tc), ta.max(tb).max(tc));
    let is_inside = inside_forward | inside_backward;
    let share = ((over_a + over_b) + over_c) / ((u + v) + w).abs();
    let reach = MOVED * (share * (t_high - t_low) + ray.band * ray.t_per_z.abs());
    if is_inside & (reach < 1.0) {
        t_high = t_high.min(t + reach);
    }
    Some(Pass { is_hit: met.is_some(), is_inside, t, t_low, t_high })
}
