//! From a mesh's own frame to vertices on the screen.
//!
//! Vertices are projected in f32 where that costs less than a few units in the last place of depth, else, draw by draw, in
//! f64 ([`Projection`]); either way each vertex is projected once and kept as one [`ScreenVertex`], from which all triangles
//! around it take its place on the grid, so shared edges stay closed whatever path draws their triangles. Depth planes of
//! triangles that are clipped or large reach far beyond their vertices' precision in f32 and come from f64 alone.

use glam::{DMat4, DVec3, Vec3};

use super::lanes::Lanes;
use super::simd::LANES;
use super::vertices::{CLIP, FAR_GUARD, ScreenVertex, Viewport};
use super::with_lanes::with_lanes;
use crate::geometry::Aabb;
use crate::render::precision::single_is_enough;
use crate::simd::dispatch;

/// `clip_from_local` of a draw.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    /// See [`normalized`].
    exact: [[f64; 4]; 4],
    single: [[f32; 4]; 4],
    /// Whether f32 is enough for the vertices.
    single_is_enough: bool,
}

impl Projection {
    /// The projection of a mesh in a box.
    pub fn new(clip_from_local: &DMat4, bounds_local: &Aabb) -> Self {
        let exact = normalized(clip_from_local);
        let single_is_enough = single_is_enough(&DMat4::from_cols_array_2d(&exact), bounds_local);
        Self { exact, single: exact.map(|c| c.map(|x| x as f32)), single_is_enough }
    }

    /// `clip_from_local` times a power of two.
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_cols_array_2d(&self.exact)
    }

    /// Clip coordinates of a local point.
    pub fn clip(&self, p: DVec3) -> [f64; 4] {
        clip_of(&self.exact, p)
    }

    /// Projects vertices, `out` as long as `positions`.
    pub fn project(&self, viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) {
        if self.single_is_enough {
            project_all(&self.single, viewport, positions, out);
        } else {
            project_all_exactly(&self.exact, viewport, positions, out);
        }
    }
}

/// `clip_from_local`, column-major, scaled by a power of two so that its largest element is in [1, 2).
///
/// A projective map keeps its meaning under any positive scale; a power of two costs no digit, and a matrix of any
/// magnitude then fits into f32, where clip coordinates of a mesh (local coordinates at most 1) stay below 8.
pub fn normalized(clip_from_local: &DMat4) -> [[f64; 4]; 4] {
    let columns = clip_from_local.to_cols_array_2d();
    let largest = columns.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        // Nothing has w > 0 under it, so nothing is drawn.
        return [[0.0; 4]; 4];
    }
    let exponent = largest.log2().floor() as i32;
    // In two steps: one power of two alone may leave the range of f64.
    let (first, second) = (2f64.powi(-exponent / 2), 2f64.powi(-(exponent - exponent / 2)));
    columns.map(|c| c.map(|x| x * first * second))
}

/// Clip coordinates of vertices. Written in lanes: the compiler makes scalar code of loops over them.
#[inline(always)]
fn clip_positions<L: Lanes>(lanes: L, clip_from_local: &[[f32; 4]; 4], p: &[Vec3; LANES]) -> [[f32; LANES]; 4] {
    let [c0, c1, c2, c3] = clip_from_local;
    let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        (x[l], y[l], z[l]) = (p[l].x, p[l].y, p[l].z);
    }
    let (x, y, z) = (lanes.floats(x), lanes.floats(y), lanes.floats(z));
    let mut clip = [[0.0; LANES]; 4];
    for i in 0..4 {
        let from_z = lanes.fused(z, lanes.float(c2[i]), lanes.float(c3[i]));
        let from_y = lanes.fused(y, lanes.float(c1[i]), from_z);
        clip[i] = lanes.to_floats(lanes.fused(x, lanes.float(c0[i]), from_y));
    }
    clip
}

#[inline(always)]
fn clip_of(clip_from_local: &[[f64; 4]; 4], p: DVec3) -> [f64; 4] {
    let [c0, c1, c2, c3] = clip_from_local;
    std::array::from_fn(|i| p.x.mul_add(c0[i], p.y.mul_add(c1[i], p.z.mul_add(c2[i], c3[i]))))
}

dispatch! {
    /// Projects vertices in f64.
    fn project_all_exactly(m: &[[f64; 4]; 4], viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) = project_all_exactly_body
}

#[inline(always)]
fn project_all_exactly_body(m: &[[f64; 4]; 4], viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) {
    let (guard, near) = (viewport.guard.map(f64::from), f64::from(viewport.near));
    for (p, o) in positions.iter().zip(out) {
        let clip = clip_of(m, p.as_dvec3());
        let [x, y, z, w] = clip;
        let guarded = (x.abs() <= guard[0] * w)
            & (y.abs() <= guard[1] * w)
            & (z >= near * w)
            & (z <= (near + f64::from(FAR_GUARD)) * w)
            & (w >= f64::MIN_POSITIVE);
        let code = viewport.outcode(clip) | if guarded { 0 } else { CLIP };
        let [x, y, z] = if guarded { viewport.project_exactly(clip).map(|v| v as f32) } else { [0.0; 3] };
        *o = ScreenVertex { x, y, z, code };
    }
}

with_lanes! {
    /// Projects vertices, `out` as long as `positions`.
    pub fn project_all(m: &[[f32; 4]; 4], viewport: &Viewport, positions: &[Vec3], out: &mut [ScreenVertex]) = project_all_body
}

#[inline(always)]
fn project_all_body<L: Lanes>(
    lanes: L,
    m: &[[f32; 4]; 4],
    viewport: &Viewport,
    positions: &[Vec3],
    out: &mut [ScreenVertex],
) {
    let (blocks, rest) = positions.as_chunks::<LANES>();
    let (out_blocks, out_rest) = out.as_chunks_mut::<LANES>();
    for (p, o) in blocks.iter().zip(out_blocks) {
        *o = project_block(lanes, m, viewport, p);
    }
    if !rest.is_empty() {
        let mut padded = [Vec3::ZERO; LANES];
        padded[..rest.len()].copy_from_slice(rest);
        out_rest.copy_from_slice(&project_block(lanes, m, viewport, &padded)[..rest.len()]);
    }
}

#[inline(always)]
fn project_block<L: Lanes>(
    lanes: L,
    m: &[[f32; 4]; 4],
    viewport: &Viewport,
    p: &[Vec3; LANES],
) -> [ScreenVertex; LANES] {
    let [x, y, z, w] = clip_positions(lanes, m, p);
    let mut code = [0u32; LANES];
    let mut screen = [[0f32; LANES]; 3];
    for l in 0..LANES {
        let (x, y, z, w) = (x[l], y[l], z[l], w[l]);
        let bit = |condition: bool, bit: u32| u32::from(condition) << bit;
        let guarded = (x.abs() <= viewport.guard[0] * w)
            & (y.abs() <= viewport.guard[1] * w)
            & (z >= viewport.near * w)
            & (z <= (viewport.near + FAR_GUARD) * w)
            // The smallest w whose inverse is finite.
            & (w >= f32::MIN_POSITIVE);
        code[l] = bit(x < -w, 0)
            | bit(x > w, 1)
            | bit(y < -w, 2)
            | bit(y > w, 3)
            | bit(z < viewport.near * w, 4)
            | bit(z > (viewport.near + 1.0) * w, 5)
            | bit(!guarded, 6);
        for (s, v) in screen.iter_mut().zip(viewport.project([x, y, z, w])) {
            s[l] = if guarded { v } else { 0.0 };
        }
    }
    std::array::from_fn(|l| ScreenVertex { x: screen[0][l], y: screen[1][l], z: screen[2][l], code: code[l] })
}

#[cfg(test)]
mod tests {
    use super::super::plain::Plain;
    use super::*;

    #[test]
    fn both_instruction_sets_project_the_same_bits() {
        let m = normalized(&glam::dcamera::rh::proj::directx::perspective(1.0, 1.3, 0.1, 30.0));
        let single = m.map(|c| c.map(|x| x as f32));
        let viewport = Viewport::new([640, 480], [640, 480], 1.0);
        let positions: Vec<Vec3> = (0..1003)
            .map(|i| Vec3::new((i as f32 * 0.37).sin(), (i as f32 * 0.71).cos(), -1.0 + (i as f32 * 0.11).sin() * 1.1))
            .collect();
        let (mut best, mut plain) = (vec![ScreenVertex::default(); 1003], vec![ScreenVertex::default(); 1003]);
        project_all_exactly(&m, &viewport, &positions, &mut best);
        project_all_exactly_body(&m, &viewport, &positions, &mut plain);
        assert_eq!(best, plain);
        project_all(&single, &viewport, &positions, &mut best);
        project_all_body(Plain, &single, &viewport, &positions, &mut plain);
        assert_eq!(best, plain);
        assert!(best.iter().any(|v| v.code & CLIP != 0) && best.iter().any(|v| v.code == 0));
    }

    #[test]
    fn matrices_of_any_magnitude_become_the_same() {
        let m = glam::dcamera::rh::proj::directx::perspective(1.0, 1.3, 0.1, 30.0);
        for exponent in [-1000, -30, 1, 900] {
            assert_eq!(normalized(&(m * 2f64.powi(exponent))), normalized(&m));
        }
        assert_eq!(normalized(&DMat4::ZERO), [[0.0; 4]; 4]);
    }

    #[test]
    fn what_is_divided_by_w_stays_finite() {
        // z is 1, w as small as can be: the quotient would be infinite, and the plane of depth NaN.
        let columns = [[0.0; 4], [0.0; 4], [0.0, 0.0, 8.0, 0.0], [0.0, 0.0, 0.0, f64::from(f32::MIN_POSITIVE)]];
        let (viewport, mut out) = (Viewport::new([64, 64], [64, 64], 1.0), [ScreenVertex::default(); 2]);
        let positions = [Vec3::Z, Vec3::Z * f32::MIN_POSITIVE * 0.125];
        project_all(&columns.map(|c| c.map(|x| x as f32)), &viewport, &positions, &mut out);
        assert!(out[0].z.is_finite() && out[0].code & CLIP != 0 && out[1].code & CLIP == 0, "{out:?}");
        project_all_exactly(&columns, &viewport, &positions, &mut out);
        assert!(out[0].z.is_finite() && out[0].code & CLIP != 0 && out[1].code & CLIP == 0, "{out:?}");
    }
}
