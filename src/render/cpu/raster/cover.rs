//! What has been drawn hides what comes behind it: the farthest depth of each tile of the image, and triangles left out by it.
//!
//! Source: the pyramid of depths of Greene, Kass and Miller 1993 `[greene1993]`, of which one level is kept.
//!
//! ```text
//!     . . . .      . something in the tile is not covered yet
//!     . 3 4 .      3 the farthest depth in the tile: a triangle over it whose corners are all farther changes no pixel,
//!     . 3 3 .        as depths are held between those of its corners
//! ```
//! Depths only become nearer, so a tile's number that is out of date lets more be drawn than need be, and never less. An image is
//! the same bit by bit with and without it.

use glam::Vec3;
use rayon::prelude::*;
use rayon::slice::ChunksExactMut;

use super::bins::{BandArea, Bands};
use super::drawn_mesh::Draw;
use super::lanes::Lanes;
use super::simd::LANES;
use super::triangle_setup::{larger, smaller};
use super::vertices::Viewport;
use super::with_lanes::with_lanes;
use crate::simd::dispatch;

/// Tiles along a side, at most: their numbers take a quarter of a megabyte and stay in a level-2 cache.
const MOST_TILES: u32 = 256;
/// Least pixels along a tile, chosen by measurement: those of 8 hide a few triangles more and take longer to read than these take
/// to draw.
const LEAST_PIXELS: u32 = 16;
/// Pixels about a box that its triangles may cover: rounding to the grid, and what [`LEAST_W`] leaves of that of f32.
const PAD: f64 = 1.5;
/// What a clip coordinate of f32 loses at most, of the sum of its terms (`render::precision`).
const ROUNDING: f64 = 1.0 / (1 << 23) as f64;
/// Least w of a box's corners, of the largest sum of a clip coordinate's terms: 16384 pixels then lose below one to rounding.
const LEAST_W: f64 = 1.0 / 256.0;

/// The tiles of an image.
#[derive(Debug, Clone, Copy, Default)]
pub struct Grid {
    /// Pixels along a tile, as powers of two. Its rows are in one band.
    log2: [u32; 2],
    /// Tiles along the image.
    tiles: [u32; 2],
    /// Tiles in a row of a band.
    in_band: usize,
    /// Columns of tiles that share a bit of [`Grid::columns`], as a power of two.
    log2_columns: u32,
}

impl Grid {
    pub fn new([width, height]: [u32; 2], bands: Bands) -> Self {
        let side = width.max(height).div_ceil(MOST_TILES).next_power_of_two().max(LEAST_PIXELS).ilog2();
        let log2 = [side, side.min(bands.log2_rows)];
        let rows = 1 << (bands.log2_rows - log2[1]);
        let tiles = [width.div_ceil(1 << side), bands.count * rows];
        let log2_columns = tiles[0].div_ceil(u64::BITS).next_power_of_two().ilog2();
        Self { log2, tiles, in_band: (tiles[0] * rows) as usize, log2_columns }
    }
}

/// Where a run of triangles may be drawn, from its box.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    /// First and last column and row of tiles.
    tiles: [[u16; 2]; 2],
    /// No corner of a triangle is nearer.
    pub nearest: f32,
    /// Nor farther.
    farthest: f32,
}

impl Default for Footprint {
    /// All of an image, at any depth.
    fn default() -> Self {
        Self { tiles: [[0, u16::MAX]; 2], nearest: f32::NEG_INFINITY, farthest: f32::INFINITY }
    }
}

/// The footprints of boxes of one placed mesh.
#[derive(Debug, Clone, Copy)]
pub struct Footprints {
    matrix: [[f64; 4]; 4],
    /// From NDC to tiles, with y down.
    scale: [f64; 2],
    half: [f64; 2],
    pad: [f64; 2],
    last: [f64; 2],
    least_w: f64,
    rounding: f64,
}

impl Footprints {
    pub fn new(draw: &Draw, viewport: &Viewport, grid: Grid) -> Self {
        let matrix = draw.projection.matrix();
        let reach =
            draw.mesh.bounds_local().corners().iter().fold(glam::DVec3::ZERO, |r, p| r.max(p.abs())).extend(1.0);
        let terms = (0..4).map(|i| matrix.row(i).abs().dot(reach)).fold(0.0, f64::max);
        let pixels = viewport.image_size();
        let tile = grid.log2.map(|log2| f64::from(1 << log2));
        let half = [0.5 * pixels[0] / tile[0], 0.5 * pixels[1] / tile[1]];
        Self {
            matrix: matrix.to_cols_array_2d(),
            scale: [half[0], -half[1]],
            half,
            pad: tile.map(|tile| PAD / tile),
            last: grid.tiles.map(|n| f64::from(n - 1)),
            least_w: LEAST_W * terms,
            // Of z and of w, whose quotient is at most 2.
            rounding: 3.0 * ROUNDING * terms,
        }
    }

    /// That of a box in the mesh's own frame.
    pub fn of(&self, min: Vec3, max: Vec3) -> Footprint {
        let mut out = Footprint::default();
        footprint(self, [min, max], &mut out);
        out
    }
}

dispatch! {
    /// Finds a footprint; leaves the one that is there where the box reaches to the projection centre.
    fn footprint(of: &Footprints, ends: [Vec3; 2], out: &mut Footprint) = footprint_body
}

#[inline(always)]
fn footprint_body(of: &Footprints, [min, max]: [Vec3; 2], out: &mut Footprint) {
    let [c0, c1, c2, c3] = &of.matrix;
    // Corner k has the larger coordinates at the bits of k.
    let mut clip = [[0f64; 8]; 4];
    for i in 0..4 {
        let x = [c0[i] * f64::from(min.x), c0[i] * f64::from(max.x)];
        let y = [c1[i] * f64::from(min.y), c1[i] * f64::from(max.y)];
        let z = [c2[i] * f64::from(min.z) + c3[i], c2[i] * f64::from(max.z) + c3[i]];
        for k in 0..8 {
            clip[i][k] = x[k & 1] + y[k >> 1 & 1] + z[k >> 2];
        }
    }
    let mut least_w = f64::INFINITY;
    for k in 0..8 {
        least_w = if clip[3][k] < least_w { clip[3][k] } else { least_w };
    }
    if !(least_w > of.least_w && least_w > 0.0) {
        return;
    }
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for k in 0..8 {
        let inverse = 1.0 / clip[3][k];
        for c in 0..3 {
            let ndc = clip[c][k] * inverse;
            low[c] = if ndc < low[c] { ndc } else { low[c] };
            high[c] = if ndc > high[c] { ndc } else { high[c] };
        }
    }
    for c in 0..2 {
        let (a, b) = (low[c] * of.scale[c] + of.half[c], high[c] * of.scale[c] + of.half[c]);
        let (first, last) = (a.min(b) - of.pad[c], a.max(b) + of.pad[c]);
        out.tiles[c] = [first.clamp(0.0, of.last[c]) as u16, last.clamp(0.0, of.last[c]) as u16];
    }
    let margin = of.rounding / least_w + 2.0 * ROUNDING;
    (out.nearest, out.farthest) = ((low[2] - margin) as f32, (high[2] + margin) as f32);
}

/// What becomes of a run of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hidden {
    /// All of it lies behind what is drawn.
    All,
    /// Some of it may.
    Some,
    /// Nothing of it does.
    None,
}

/// The farthest depth of each tile.
#[derive(Debug, Default)]
pub struct Cover {
    grid: Grid,
    farthest: Vec<f32>,
}

impl Cover {
    /// Forgets everything that has been drawn.
    pub fn start(&mut self, grid: Grid) {
        self.grid = grid;
        self.farthest.clear();
        self.farthest.resize((grid.tiles[0] * grid.tiles[1]) as usize, f32::INFINITY);
    }

    /// What is known of some triangles by their footprint.
    pub fn of(&self, footprint: &Footprint) -> Hidden {
        let [columns, rows] = footprint.tiles.map(|t| t.map(usize::from));
        if footprint.nearest == f32::NEG_INFINITY {
            return Hidden::None;
        }
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in rows[0]..=rows[1] {
            for &z in &self.farthest[row * self.grid.tiles[0] as usize..][columns[0]..=columns[1]] {
                (least, most) = (smaller(least, z), larger(most, z));
            }
        }
        if footprint.nearest > most {
            Hidden::All
        } else if footprint.farthest > least {
            Hidden::Some
        } else {
            Hidden::None
        }
    }

    /// All of them.
    pub fn tiles(&self) -> Tiles<'_> {
        Tiles { grid: self.grid, farthest: &self.farthest }
    }
    /// The tiles of each band.
    pub fn bands_mut(&mut self) -> ChunksExactMut<'_, f32> {
        self.farthest.par_chunks_exact_mut(self.grid.in_band)
    }
}

/// Rows of tiles with their farthest depths.
#[derive(Debug, Clone, Copy)]
pub struct Tiles<'a> {
    pub grid: Grid,
    pub farthest: &'a [f32],
}

impl Tiles<'_> {
    /// A bit for each triangle that lies behind what is drawn: first column and row, last column and row of their boxes, and the
    /// depth of their nearest corners. None for lanes whose boxes hold no pixel.
    #[inline(always)]
    pub fn hidden<L: Lanes>(self, lanes: L, [left, top, right, bottom]: [L::Int; 4], nearest: L::Float) -> u32 {
        let Grid { log2, tiles, .. } = self.grid;
        let (left, right) = (lanes.shifted(left, log2[0]), lanes.shifted(right, log2[0]));
        let (top, bottom) = (lanes.shifted(top, log2[1]), lanes.shifted(bottom, log2[1]));
        let (across, down) = (lanes.sub(right, left), lanes.sub(bottom, top));
        // Two tiles along each side at most.
        let one = lanes.int(1);
        let unknown = lanes.or(lanes.or(across, down), lanes.or(lanes.sub(one, across), lanes.sub(one, down)));
        let (width, table) = (lanes.int(tiles[0] as i32), self.farthest);
        let (above, below) = (lanes.mul(top, width), lanes.mul(bottom, width));
        let at = |row: L::Int, column: L::Int| lanes.looked_up(table, lanes.add(row, column));
        let (a, b, c, d) = (at(above, left), at(above, right), at(below, left), at(below, right));
        let farthest = lanes.larger(lanes.larger(a, b), lanes.larger(c, d));
        !lanes.signs(lanes.or(unknown, lanes.at_most(nearest, farthest)))
    }
}

impl Grid {
    /// Bits of the columns of tiles from one column of the image to another.
    #[inline(always)]
    pub fn columns(self, first: i32, last: i32) -> u64 {
        let by = self.log2[0] + self.log2_columns;
        (u64::MAX << (first >> by)) & (u64::MAX >> (u64::BITS as i32 - 1 - (last >> by)))
    }

    /// Reads the tiles of a band again whose columns of tiles have these bits.
    pub fn read(&self, columns: u64, area: BandArea, depth: &[f32], tiles: &mut [f32]) {
        read(self, columns, area, depth, tiles);
    }
}

with_lanes! {
    fn read(grid: &Grid, columns: u64, area: BandArea, depth: &[f32], tiles: &mut [f32]) = read_with
}

#[inline(always)]
fn read_with<L: Lanes>(lanes: L, grid: &Grid, columns: u64, area: BandArea, depth: &[f32], tiles: &mut [f32]) {
    let (width, stride) = (area.size[0] as usize, area.stride);
    let high = 1 << grid.log2[1];
    for (rows, tiles) in depth.chunks(stride * high).zip(tiles.chunks_exact_mut(grid.tiles[0] as usize)) {
        for (column, tile) in tiles.iter_mut().enumerate() {
            if columns >> (column >> grid.log2_columns) & 1 == 0 {
                continue;
            }
            let first = column << grid.log2[0];
            let end = width.min(first + (1 << grid.log2[0]));
            let nothing = lanes.float(f32::NEG_INFINITY);
            let (mut most, mut of_rest) = ([nothing; 2], f32::NEG_INFINITY);
            for row in rows.chunks_exact(stride) {
                let row = &row[first..end];
                // Nearly all tiles are as wide as that.
                if let Ok(pair) = row.try_into() {
                    most = larger_of(lanes, most, pair);
                    continue;
                }
                let (pairs, rest) = row.as_chunks();
                most = pairs.iter().fold(most, |most, pair| larger_of(lanes, most, pair));
                of_rest = rest.iter().fold(of_rest, |most, z| larger(most, *z));
            }
            *tile = lanes.to_floats(lanes.larger(most[0], most[1])).into_iter().fold(of_rest, larger);
        }
    }
}

/// The larger of some depths and those of neighbouring pixels.
#[inline(always)]
fn larger_of<L: Lanes>(lanes: L, most: [L::Float; 2], pixels: &[f32; 2 * LANES]) -> [L::Float; 2] {
    let half = |k: usize| lanes.floats(std::array::from_fn(|l| pixels[k * LANES + l]));
    [lanes.larger(most[0], half(0)), lanes.larger(most[1], half(1))]
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::render::Volume;
    use crate::render::cpu::faces::Faces;
    use crate::scene::Mesh;

    const SIZE: [u32; 2] = [200, 120];

    /// A cover whose tiles left of the middle hold 0.4, those to the right nothing.
    fn cover() -> Cover {
        let bands = Bands::new(SIZE);
        let grid = Grid::new(SIZE, bands);
        let mut cover = Cover::default();
        cover.start(grid);
        let stride = bands.stride as usize;
        let depth: Vec<f32> = (0..32 * stride).map(|i| if i % stride < 100 { 0.4 } else { 1.0 }).collect();
        for (band, tiles) in cover.farthest.chunks_exact_mut(grid.in_band).enumerate() {
            let area = BandArea { size: SIZE, stride, first_row: 32 * band as i32, rows: 32 };
            grid.read(grid.columns(0, 95), area, &depth, tiles);
        }
        cover
    }

    /// The footprint of a square about NDC of a place, between two depths, under a matrix that changes nothing but w.
    fn footprint(place: [f64; 2], half: f64, depths: [f64; 2], w: f64) -> Footprint {
        let at = |sign: f64, z: f64| [place[0] + sign * half, place[1] + sign * half, z];
        let vertices = [at(-1.0, depths[0]), at(1.0, depths[1]), [place[0] - half, place[1] + half, depths[0]]];
        let mesh = Mesh::new(&vertices, &[[0, 1, 2]]).unwrap();
        let scale = DMat4::from_cols_array(&[w, 0., 0., 0., 0., w, 0., 0., 0., 0., w, 0., 0., 0., 0., w]);
        let clip_from_local = scale * DMat4::from(*mesh.mesh_from_local());
        let volume = Volume::of_clip(&clip_from_local, 0.0);
        let draw = Draw::new(&mesh, &clip_from_local, &volume, Faces::All, 0);
        let grid = Grid::new(SIZE, Bands::new(SIZE));
        let [min, max] = draw.kept.bounds(0);
        Footprints::new(&draw, &Viewport::new(SIZE, SIZE, 1.0), grid).of(min, max)
    }

    #[test]
    fn only_what_lies_behind_all_tiles_of_its_box_is_hidden() {
        let cover = cover();
        let (left, right) = ([-0.6, 0.3], [0.6, 0.3]);
        for w in [1.0, 1e-3, 1e3] {
            let of = |place, half, depths| cover.of(&footprint(place, half, depths, w));
            assert_eq!(of(left, 0.05, [0.5, 0.6]), Hidden::All);
            assert_eq!(of(left, 0.05, [0.3, 0.6]), Hidden::Some);
            assert_eq!(of(left, 0.05, [0.2, 0.3]), Hidden::None);
            assert_eq!(of(right, 0.05, [0.5, 0.6]), Hidden::None, "nothing is drawn there");
            assert_eq!(of([0.0, 0.0], 0.2, [0.5, 0.6]), Hidden::Some, "in part");
        }
        assert_eq!(cover.of(&footprint(left, 0.05, [0.5, 0.6], -1.0)), Hidden::None, "behind the projection centre");
        assert_eq!(cover.of(&Footprint::default()), Hidden::None);
        let mut empty = Cover::default();
        empty.start(cover.grid);
        assert_eq!(empty.of(&footprint(left, 0.05, [0.5, 0.6], 1.0)), Hidden::None);
    }

    #[test]
    fn tiles_hold_the_farthest_depth_of_their_pixels() {
        let size = [70, 40];
        let bands = Bands::new(size);
        let (grid, stride) = (Grid::new(size, bands), bands.stride as usize);
        assert_eq!((grid.tiles, grid.in_band), ([5, 4], 10));
        let area = BandArea { size, stride, first_row: 32, rows: 8 };
        let mut depth = vec![9.0; 8 * stride];
        let mut expected = [f32::NEG_INFINITY; 5];
        for (y, row) in depth.chunks_exact_mut(stride).enumerate() {
            for x in 0..70 {
                row[x] = (x * 7 % 31) as f32 + (y * 5 % 8) as f32 / 8.0;
                expected[x / 16] = expected[x / 16].max(row[x]);
            }
        }
        let mut tiles = [f32::INFINITY; 10];
        grid.read(grid.columns(16, 69), area, &depth, &mut tiles);
        assert_eq!(tiles[0], f32::INFINITY, "not asked for");
        assert_eq!(tiles[1..5], expected[1..]);
        assert_eq!(tiles[5..], [f32::INFINITY; 5], "no rows");
    }

    #[test]
    fn columns_have_a_bit_each_at_any_width() {
        for width in [8, 100, 1024, 5000, 16384] {
            let size = [width, 64];
            let grid = Grid::new(size, Bands::new(size));
            let last = width as i32 - 1;
            assert_eq!(grid.columns(0, last), (0..=last).fold(0, |all, x| all | grid.columns(x, x)));
            assert!((0..=last).all(|x| grid.columns(x, x).count_ones() == 1));
            assert!(grid.columns(last, last) >= grid.columns(0, 0));
        }
    }
}
