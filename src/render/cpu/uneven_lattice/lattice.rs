//! Where the centres of texels lie in a projective map whose texels a post-warp makes uneven.
//!
//! Source: theory.md 11, (11.1), and 10.7, (10.12). Planes stay planes in a projective map, so triangles that are projected into
//! it and sampled at uneven rows and columns are drawn exactly, for every matrix: no vertex is moved, no triangle bent.
//! - A logarithmic map of a matrix with rows x, y, z, w has at (x/w, ln w) the depth z/w. The projective map with rows x, 1, z,
//!   w has the very same texels at (x/w, 1/w): its columns are even, its rows are not. The matrix's own y does not matter.
//! - A rectilinear map has at (f(x/w), g(y/w)) the depth z/w: its own matrix has the texel with centre (u, v) at
//!   (f⁻¹(u), g⁻¹(v)).
//!
//! Spaces: *even* is (column, down, z), column `(x/w + 1) / 2` times the width, down `scale * (1/w - shift)` under a logarithm
//! and -y/w otherwise, growing downwards, depth in [0, 1].

use glam::{DMat4, DVec4};

use super::ascending::Ascending;
use super::places::EvenColumns;
use crate::error::{Error, Result};
use crate::geometry::Rows;
use crate::parameterization::Rectilinear;

/// Largest |x| / w that is not cut, and |y| / w of a rectilinear map. Derived from f64: columns are then told to 2^-13 of a
/// texel of the largest map.
const GUARD: f64 = (1_u64 << 26) as f64;

/// Above this |1 / scale| 1/w is told from 0, below from 1: either way the rows keep their digits where they are densest.
const STRONG: f64 = 1.0;
/// Largest |1 / scale|: the map's w spans e to the double of that, and all of it must be normal numbers.
const STRONGEST: f64 = 300.0;
/// Least w of a rectilinear map whose largest coefficient of w is 1: its reciprocal times [`GUARD`] is far from overflow, and
/// only the projection centre itself is that near to it.
const LEAST_W: f64 = 1e-100;

/// A projective map with uneven rows and, perhaps, columns.
#[derive(Debug)]
pub struct Lattice {
    /// Clip x, down, z, w of world points.
    pub(super) clip_from_world: DMat4,
    /// Where the centres of rows lie, from the top; ascending.
    pub(super) rows: Ascending,
    pub(super) columns: Columns,
    /// Where the map begins and ends: x/w, and down.
    pub(super) across: [f64; 2],
    pub(super) down: [f64; 2],
    /// What triangles are cut by: near the projection centre, before the near plane, far aside. Coefficients of clip x, down,
    /// z, w, and a constant.
    pub(super) planes: Vec<[f64; 5]>,
    pub(super) size: [u32; 2],
}

/// Where the centres of columns lie.
#[derive(Debug)]
pub(super) enum Columns {
    Even(EvenColumns),
    Uneven(Ascending),
}

impl Lattice {
    /// The map of a matrix, `size` texels, whose NDC y is `scale * ln w + offset`.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a scale and an offset with which no f64 has a place in the map.
    pub fn logarithmic(clip_from_world: &DMat4, scale: f64, offset: f64, size: [u32; 2]) -> Result<Self> {
        let steepness = scale.recip();
        // w at the middle row becomes 1, whatever the matrix was multiplied with.
        let unit = (offset * steepness).exp();
        let Rows { x, z, w, .. } = Rows::of(&(*clip_from_world * unit));
        let strong = steepness.abs() > STRONG;
        let shift = if strong { 0.0 } else { 1.0 };
        let down_at = |y: f64| scale * if strong { (-y * steepness).exp() } else { (-y * steepness).exp_m1() };
        let clip_from_world = Rows { x, y: (DVec4::W - w * shift) * scale, z, w }.matrix();
        let usable = scale.is_finite() && steepness.abs() <= STRONGEST && unit > 0.0 && clip_from_world.is_finite();
        if !usable {
            let expected = format!("a finite scale of at least 1/{STRONGEST} and an offset that fits the matrix");
            let fix = "check where the logarithm comes from";
            return Err(Error::argument("post_warp", expected, format!("scale {scale:e}, offset {offset:e}"), fix));
        }
        let rows = ascending(centres(size[1]).map(|y| down_at(-y)));
        Ok(Self {
            clip_from_world,
            rows: if strong { Ascending::logarithmic(rows) } else { Ascending::even(rows) },
            columns: Columns::Even(EvenColumns::new(size[0])),
            across: [-1.0, 1.0],
            down: [down_at(1.0), down_at(-1.0)],
            planes: planes(0.5 * (-steepness.abs()).exp()).to_vec(),
            size,
        })
    }

    /// The map of a matrix, `size` texels, whose NDC x and y are warped each by itself.
    pub fn rectilinear(clip_from_world: &DMat4, warp: &Rectilinear, size: [u32; 2]) -> Self {
        let Rows { x, y, z, w } = Rows::of(clip_from_world);
        // Clip coordinates are homogeneous.
        let largest = w.abs().max_element();
        let unit = if largest > 0.0 { largest.recip() } else { 1.0 };
        let half = 0.5 * f64::from(size[0]);
        let mut planes = planes(LEAST_W).to_vec();
        // With the far end of depths no w below 0 is left, as in `raster`.
        planes.extend([[0.0, 0.0, -1.0, 2.0, 0.0], [0.0, 1.0, 0.0, GUARD, 0.0], [0.0, -1.0, 0.0, GUARD, 0.0]]);
        Self {
            clip_from_world: Rows { x, y: -y, z, w }.scaled(unit).matrix(),
            rows: Ascending::even(ascending(centres(size[1]).map(|y| -warp.y.before(-y)))),
            columns: Columns::Uneven(Ascending::even(ascending(
                centres(size[0]).map(|x| (warp.x.before(x) + 1.0) * half),
            ))),
            across: [-1.0, 1.0].map(|x| warp.x.before(x)),
            down: [1.0, -1.0].map(|y| -warp.y.before(y)),
            planes,
            size,
        }
    }
}

/// The centres of so many texels, from -1 to 1.
fn centres(count: u32) -> impl Iterator<Item = f64> {
    let step = 2.0 / f64::from(count);
    (0..count).map(move |i| (f64::from(i) + 0.5) * step - 1.0)
}

/// The same places, none before the one that it follows, whatever a rounding at a knot says.
fn ascending(places: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = f64::NEG_INFINITY;
    let held = |place: f64| {
        last = place.max(last);
        last
    };
    places.map(held).collect()
}

/// Near the projection centre, before the near plane, far to the left and right.
fn planes(least_w: f64) -> [[f64; 5]; 4] {
    let w = [0.0, 0.0, 0.0, 1.0, -least_w];
    [w, [0.0, 0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, GUARD, 0.0], [-1.0, 0.0, 0.0, GUARD, 0.0]]
}

/// How far a point is on the inner side of a plane whose last coefficient stands alone.
#[inline(always)]
pub fn distance(plane: &[f64; 5], clip: [f64; 4]) -> f64 {
    plane[4] + (plane[0] * clip[0] + plane[1] * clip[1] + plane[2] * clip[2] + plane[3] * clip[3])
}
