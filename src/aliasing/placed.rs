//! Where the receivers of a run lie in a map that is no more than a matrix: what [`crate::Partition::project`] and
//! [`crate::Partition::holds`] find, bit for bit.

use glam::{DMat4, DVec3};

use super::receivers::{RUN, Receivers};
use crate::parameterization::{Held, Parameterization, PostWarp};
use crate::simd::dispatch;

/// Places in a map.
pub struct Placed {
    /// Texel coordinates, x and y.
    pub texel: [[f64; RUN]; 2],
    /// Whether the map holds the receiver. Where it does not the coordinates mean nothing.
    pub is_held: [bool; RUN],
}

impl Placed {
    /// Places yet to be found.
    pub const NONE: Self = Self { texel: [[0.0; RUN]; 2], is_held: [false; RUN] };
}

/// The matrix of maps that are one map without post-warp, which serves all of the light's rays.
pub fn only_matrix(p: &Parameterization) -> Option<&DMat4> {
    match &p.partitions[..] {
        [only] if only.post_warp == PostWarp::None && only.region.functionals().is_empty() => {
            Some(&only.shadow_clip_from_world)
        }
        _ => None,
    }
}

/// The texel coordinates of a place in NDC in a map of `size` texels (width, height).
#[inline(always)]
pub fn texel_of(ndc: DVec3, size: [f64; 2]) -> [f64; 2] {
    [(0.5 + 0.5 * ndc.x) * size[0], (0.5 - 0.5 * ndc.y) * size[1]]
}

dispatch! {
    /// Finds where the receivers of a run lie in the map of a matrix, of `size` texels.
    pub fn place(matrix: &DMat4, size: [f64; 2], run: &Receivers, placed: &mut Placed) = place_body
}

#[inline(always)]
fn place_body(matrix: &DMat4, size: [f64; 2], run: &Receivers, placed: &mut Placed) {
    let matrix = *matrix;
    for i in 0..RUN {
        let clip = matrix * run.point(i).extend(1.0);
        let ndc = clip.truncate() / clip.w;
        (placed.texel[0][i], placed.texel[1][i]) = texel_of(ndc, size).into();
        placed.is_held[i] = Held::of(ndc, clip.w) != Held::Outside;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameterization::Partition;

    #[test]
    fn runs_are_placed_as_single_points_are() {
        // A perspective whose centre has points behind it, and points beyond every side of the map.
        let matrix = DMat4::from_cols_array_2d(&[
            [1.3, 0.1, 0.0, 0.0],
            [0.0, 1.7, 0.2, 0.4],
            [0.3, -0.2, 0.6, 1.0],
            [0.1, 0.0, 0.4, 0.9],
        ]);
        let p = Parameterization::of_partitions(vec![Partition::of_matrix(matrix)], [64, 32]);
        assert_eq!(only_matrix(&p), Some(&matrix));
        let mut run = Receivers::NONE;
        for (i, axis) in (0..3 * RUN).map(|k| (k / 3, k % 3)) {
            run.p[axis][i] = ((i * (7 + 4 * axis)) % 23) as f64 / 7.0 - 1.6;
        }
        let mut placed = Placed::NONE;
        place(&matrix, [64.0, 32.0], &run, &mut placed);
        for i in 0..RUN {
            let held = p.partitions[0].holds(run.point(i)) != Held::Outside;
            assert_eq!(placed.is_held[i], held, "{i}");
            let texel = texel_of(p.partitions[0].project(run.point(i)).0, [64.0, 32.0]);
            assert_eq!([placed.texel[0][i], placed.texel[1][i]].map(f64::to_bits), texel.map(f64::to_bits));
        }
        let held = placed.is_held.iter().filter(|held| **held).count();
        assert!(held > 5 && held < RUN - 5, "{held}");
    }

    #[test]
    fn several_maps_and_what_follows_a_matrix_are_not_taken_for_one() {
        let one = Partition::of_matrix(DMat4::IDENTITY);
        let of = |partitions| Parameterization::of_partitions(partitions, [8; 2]);
        assert!(only_matrix(&of(vec![one.clone(), one.clone()])).is_none());
        let bent = Partition { post_warp: PostWarp::Log { scale: 1.0, offset: 0.0 }, ..one };
        assert!(only_matrix(&of(vec![bent])).is_none());
    }
}
