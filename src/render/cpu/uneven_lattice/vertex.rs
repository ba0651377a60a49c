//! Vertices among uneven rows and columns, eight side by side.

use glam::{DMat4, Vec3};

use super::lattice::{Lattice, distance};
use super::places::Places;
use super::triangle::Corner;
use crate::simd::dispatch;

/// Vertices that are projected side by side.
const LANES: usize = 8;

/// A projected vertex.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EvenVertex {
    pub corner: Corner,
    /// The first column whose centre is not left of it.
    pub first_column: u32,
    /// The first row whose centre is not above it.
    pub first_row: u32,
}

impl EvenVertex {
    /// Not to be projected as it is.
    pub const CUT: Self =
        Self { corner: Corner { column: 0.0, down: 0.0, z: 0.0 }, first_column: 0, first_row: u32::MAX };

    /// Whether it is [`EvenVertex::CUT`].
    #[inline(always)]
    pub fn is_cut(&self) -> bool {
        self.first_row == u32::MAX
    }
    /// Its first row and column in one number, the row above; the sign bit says whether it is [`EvenVertex::CUT`].
    #[inline(always)]
    pub fn texel(&self) -> u64 {
        u64::from(self.first_row) << 32 | u64::from(self.first_column)
    }
}

dispatch! {
    /// Projects vertices, `out` as long as `positions`.
    pub fn project<C: Places>(lattice: &Lattice, columns: &C, clip_from_local: &DMat4, positions: &[Vec3], out: &mut [EvenVertex]) = project_all
}

#[inline(always)]
pub fn project_all<C: Places>(
    lattice: &Lattice,
    columns: &C,
    clip_from_local: &DMat4,
    positions: &[Vec3],
    out: &mut [EvenVertex],
) {
    let m = clip_from_local.to_cols_array_2d();
    for (positions, out) in positions.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let mut p = [[0.0; LANES]; 3];
        for (l, position) in positions.iter().enumerate() {
            for i in 0..3 {
                p[i][l] = f64::from(position[i]);
            }
        }
        let found = project_block(lattice, columns, &m, &p);
        out.copy_from_slice(&found[..out.len()]);
    }
}

#[inline(always)]
fn project_block<C: Places>(
    lattice: &Lattice,
    columns: &C,
    m: &[[f64; 4]; 4],
    p: &[[f64; LANES]; 3],
) -> [EvenVertex; LANES] {
    let mut clip = [[0.0; LANES]; 4];
    for i in 0..4 {
        for l in 0..LANES {
            clip[i][l] = m[0][i] * p[0][l] + m[1][i] * p[1][l] + m[2][i] * p[2][l] + m[3][i];
        }
    }
    let mut is_cut = [false; LANES];
    for plane in &lattice.planes {
        for l in 0..LANES {
            is_cut[l] |= !(distance(plane, [clip[0][l], clip[1][l], clip[2][l], clip[3][l]]) >= 0.0);
        }
    }
    let half = 0.5 * f64::from(lattice.size[0]);
    let (mut column, mut down, mut z, mut first_column) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0; LANES]);
    for l in 0..LANES {
        let corner = corner_of([clip[0][l], clip[1][l], clip[2][l], clip[3][l]], half);
        (column[l], down[l], z[l]) = (corner.column, corner.down, corner.z);
        first_column[l] = columns.first(corner.column);
    }
    let mut out = [EvenVertex::CUT; LANES];
    for l in 0..LANES {
        if !is_cut[l] {
            let corner = Corner { column: column[l], down: down[l], z: z[l] };
            out[l] = EvenVertex { corner, first_column: first_column[l], first_row: lattice.rows.first(down[l]) };
        }
    }
    out
}

/// The place of a point in front of the projection centre; `half` of the map's width.
#[inline(always)]
fn corner_of([x, down, z, w]: [f64; 4], half: f64) -> Corner {
    let inverse_w = w.recip();
    Corner { column: (x * inverse_w + 1.0) * half, down: down * inverse_w, z: z * inverse_w }
}

/// The vertex that clipping makes.
pub fn vertex_of<C: Places>(lattice: &Lattice, columns: &C, clip: [f64; 4]) -> EvenVertex {
    let corner = corner_of(clip, 0.5 * f64::from(lattice.size[0]));
    let (first_column, first_row) = (columns.first(corner.column), lattice.rows.first(corner.down));
    EvenVertex { corner, first_column, first_row }
}
