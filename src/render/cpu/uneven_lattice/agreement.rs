//! All ways to draw a triangle against each other and against the definition of its texels: bit for bit, of any shape, on any lattice.

use std::sync::Arc;

use glam::DMat4;

use super::bins::Bins;
use super::fill::{Filling, fill, fill_with, from_top, less_of};
use super::lattice::{Columns, Lattice};
use super::lists::{Bin, List};
use super::places::Places;
use super::tiny::{TINY, Target, emit_with};
use super::triangle::Corner;
use super::vertex::{EvenVertex, project, project_all};
use crate::parameterization::{PiecewiseLinear, Rectilinear};
use crate::render::cpu::raster::{BandArea, Bands, DepthPixels, LayerPixels, Pixels, Plain, smaller, two_nearest};

/// Numbers from a small generator (Knuth's MMIX constants).
struct Random(u64);

impl Random {
    fn number(&mut self, least: f64, most: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        least + (most - least) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn below(&mut self, count: usize) -> usize {
        self.number(0.0, count as f64) as usize
    }
}

/// Lattices of a size: weak and strong logarithms either way, and uneven columns.
fn lattices(size: [u32; 2]) -> Vec<Lattice> {
    let bent = |power: f64| {
        let at = |i: i32| [2.0 * f64::from(i) / 9.0 - 1.0, 2.0 * (f64::from(i) / 9.0).powf(power) - 1.0];
        PiecewiseLinear::new(&(0..=9).map(at).collect::<Vec<_>>()).unwrap()
    };
    let warp = Arc::new(Rectilinear { x: bent(4.0), y: bent(0.3) });
    let mut all: Vec<Lattice> = [1e9, 2.0, 0.2, -0.2, -3.0, 1.0 / 250.0]
        .map(|scale| Lattice::logarithmic(&DMat4::IDENTITY, scale, 0.0, size).unwrap())
        .into();
    all.push(Lattice::rectilinear(&DMat4::IDENTITY, &warp, size));
    all
}

/// A coordinate between places, at one, or beside it by a rounding; or far from all of them.
fn coordinate(random: &mut Random, places: &[f64], about: f64, reach: f64) -> f64 {
    let at = (about + random.number(-reach, reach)).clamp(0.0, places.len() as f64 - 1.0);
    let (low, share) = (places[at as usize], at.fract());
    let high = places[(at as usize + 1).min(places.len() - 1)];
    let x = low + share * (high - low);
    match random.below(12) {
        0 => low,
        1 => low.next_up(),
        2 => low.next_down(),
        3 => x + (x - places[0]) * 7.0,
        _ => x,
    }
}

/// Triangles of all sizes and shapes, some without area.
fn vertices<C: Places>(lattice: &Lattice, columns: &C, count: usize) -> Vec<EvenVertex> {
    let (mut random, mut all) = (Random(5), Vec::new());
    let centres: Vec<f64> = (0..columns.count()).map(|column| columns.place(column)).collect();
    for i in 0..count {
        let about = [lattice.size[0], lattice.size[1]].map(|n| random.number(0.0, f64::from(n)));
        let reach = [0.7, 2.5, 6.0, 40.0][i % 4];
        let mut corners = [0; 3].map(|_| Corner {
            column: coordinate(&mut random, &centres, about[0], reach),
            down: coordinate(&mut random, &lattice.rows, about[1], reach),
            z: random.number(0.0, 1.3),
        });
        match random.below(10) {
            0 => corners[1] = corners[0],
            1 => corners[2].down = corners[0].down,
            2 => corners[1].column = corners[2].column,
            // In a line, up to a rounding.
            3 => {
                let [a, b, _] = corners;
                let along = |a: f64, b: f64| a + 0.37 * (b - a);
                corners[2] =
                    Corner { column: along(a.column, b.column), down: along(a.down, b.down), z: along(a.z, b.z) };
            }
            _ => {}
        }
        all.extend(corners.map(|corner| EvenVertex {
            corner,
            first_column: columns.first(corner.column),
            first_row: lattice.rows.first(corner.down),
        }));
    }
    all
}

/// Calls `each` with the texels of a triangle, as the header of `triangle.rs` defines them, and their depths.
fn by_definition<C: Places>(
    lattice: &Lattice,
    columns: &C,
    corners: [&EvenVertex; 3],
    mut each: impl FnMut(usize, f64),
) {
    let [a, b, c] = from_top(corners).map(|v| v.corner);
    let (bx, by, bz) = (b.column - a.column, b.down - a.down, b.z - a.z);
    let (cx, cy, cz) = (c.column - a.column, c.down - a.down, c.z - a.z);
    let inverse = (bx * cy - cx * by).recip();
    let (per_column, per_down) = ((bz * cy - cz * by) * inverse, (bx * cz - cx * bz) * inverse);
    let (least, most) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    let slope = |upper: Corner, lower: Corner| (lower.column - upper.column) / (lower.down - upper.down);
    for (row, &down) in lattice.rows.iter().enumerate().filter(|(_, down)| a.down <= **down && **down < c.down) {
        let long = a.column + (down - a.down) * slope(a, c);
        let (upper, lower) = if down < b.down { (a, b) } else { (b, c) };
        let short = upper.column + (down - upper.down) * slope(upper, lower);
        let is_between =
            |column: &usize| long.min(short) <= columns.place(*column) && columns.place(*column) < long.max(short);
        let covered: Vec<usize> = (0..columns.count()).filter(is_between).collect();
        for (i, column) in covered.iter().enumerate() {
            let step = columns.steps(covered[0])(i as u32);
            let first = a.z + (columns.place(covered[0]) - a.column) * per_column + (down - a.down) * per_down;
            each(row * columns.count() + column, (first + step * per_column).max(least).min(most));
        }
    }
}

/// Everything drawn by a function into bands as high as the map's.
fn drawn<P: Pixels>(size: [u32; 2], mut draw: impl FnMut(usize, BandArea, &mut Vec<f32>)) -> Vec<u32> {
    let bands = Bands::new(size);
    let (width, stride) = (size[0] as usize, bands.stride as usize);
    let mut map = Vec::new();
    for band in 0..bands.count as usize {
        let first_row = (band * bands.rows()) as i32;
        let area = BandArea { size, stride, first_row, rows: (size[1] as i32 - first_row).min(bands.rows() as i32) };
        let mut room = vec![P::FAR; area.rows as usize * stride];
        draw(band, area, &mut room);
        map.extend(room.chunks_exact(stride).flat_map(|row| &row[..width]).map(|z| z.to_bits()));
    }
    map
}

/// Tiny triangles by groups, the others one by one, on a lattice; how many texels there are, and how many of
/// the others.
fn compare<C: Places, const TO_FAR: bool>(lattice: &Lattice, columns: &C) -> [usize; 2] {
    let vertices = vertices(lattice, columns, 400);
    let rows = lattice.rows.with_infinities();
    let (bands, less) = (Bands::new(lattice.size), less_of::<DepthPixels<TO_FAR>>());
    let target = &Target { rows, columns, bands, less };
    let far = DepthPixels::<TO_FAR>::FAR;
    let mut expected = vec![far; columns.count() * lattice.rows.len()];
    let mut two = vec![(0.0, 0.0); expected.len()];
    let (mut list, mut texels) = (List::default(), 0);
    let (mut plain, mut best) = (Bins::default(), Bins::default());
    plain.start(bands);
    best.start(bands);
    for (i, corners) in vertices.chunks_exact(3).enumerate() {
        let [a, b, c] = from_top([&corners[0], &corners[1], &corners[2]]);
        by_definition(lattice, columns, [a, b, c], |at, z| {
            expected[at] = smaller((z - less) as f32, expected[at]);
            two[at] = two_nearest(two[at].0, two[at].1, (z - 1.0) as f32);
            texels += 1;
        });
        let columns = [a, b, c].map(|v| v.first_column);
        let is_low = c.first_row - a.first_row <= TINY;
        if is_low && columns.iter().max().unwrap() - columns.iter().min().unwrap() <= TINY {
            for (bins, is_plain) in [(&mut plain, true), (&mut best, false)] {
                let Bins { bands, tiny: [tiny, _], .. } = bins;
                if tiny.push([a.corner, b.corner, c.corner], a.first_row, c.first_row) {
                    emit(tiny, target, bands, is_plain);
                }
            }
        } else {
            list.push([0, 1, 2].map(|k| 3 * i as u32 + k), None);
        }
    }
    for (bins, is_plain) in [(&mut plain, true), (&mut best, false)] {
        let Bins { bands, tiny: [tiny, _], .. } = bins;
        emit(tiny, target, bands, is_plain);
    }
    let expected: Vec<u32> = expected.iter().map(|z| z.to_bits()).collect();
    for (bins, is_plain) in [(&plain, true), (&best, false)] {
        let found = drawn::<DepthPixels<TO_FAR>>(lattice.size, |band, area, depth| {
            let pixels = &mut DepthPixels::<TO_FAR> { depth };
            draw(lattice, columns, &vertices, (&bins.bands[band], &list), area, pixels, is_plain);
        });
        assert!(found == expected, "{:?}, {is_plain}", lattice.size);
        if !TO_FAR {
            continue;
        }
        for second in [false, true] {
            let found = drawn::<LayerPixels>(lattice.size, |band, area, out| {
                let (mut first, mut behind) = (out.clone(), out.clone());
                let pixels = &mut LayerPixels { first: &mut first, second: &mut behind };
                draw(lattice, columns, &vertices, (&bins.bands[band], &list), area, pixels, is_plain);
                *out = if second { behind } else { first };
            });
            let expected: Vec<u32> = two.iter().map(|z| if second { z.1 } else { z.0 }.to_bits()).collect();
            assert!(found == expected, "{:?}, {is_plain}, {second}", lattice.size);
        }
    }
    [texels, list.triangles.len()]
}

fn emit<C: Places>(tiny: &mut super::tiny::Tiny, target: &Target<C>, bins: &mut [Bin], is_plain: bool) {
    if is_plain {
        emit_with(Plain, tiny, target, bins);
        tiny.clear();
    } else {
        tiny.emit(target, bins);
    }
}

fn draw<C: Places, P: Pixels>(
    lattice: &Lattice,
    columns: &C,
    vertices: &[EvenVertex],
    (bin, list): (&Bin, &List),
    area: BandArea,
    pixels: &mut P,
    is_plain: bool,
) {
    let work = &Filling { vertices, extra: &[], rows: lattice.rows.with_infinities(), columns, area };
    bin.fragments.draw(pixels);
    if is_plain { fill_with(Plain, work, list, pixels) } else { fill(work, list, pixels) }
}

#[test]
fn all_ways_draw_the_texels_of_the_definition() {
    let mut all = [0; 2];
    for size in [[1, 1], [3, 70], [7, 5], [16, 33], [37, 29], [200, 130]] {
        for lattice in lattices(size) {
            let found = match &lattice.columns {
                Columns::Even(columns) => {
                    [compare::<_, true>(&lattice, columns), compare::<_, false>(&lattice, columns)]
                }
                Columns::Uneven(columns) => {
                    [compare::<_, true>(&lattice, columns), compare::<_, false>(&lattice, columns)]
                }
            };
            found.iter().for_each(|found| all = [all[0] + found[0], all[1] + found[1]]);
        }
    }
    assert!(all[0] > 100_000 && all[1] > 1_000, "{all:?}");
}

#[test]
fn both_instruction_sets_project_the_same_bits() {
    let mut random = Random(9);
    let clip_from_local = DMat4::from_cols_array(&[0; 16].map(|_| random.number(-1.0, 1.0)));
    let positions: Vec<glam::Vec3> =
        (0..1003).map(|_| glam::Vec3::from([0; 3].map(|_| random.number(-1.0, 1.0) as f32))).collect();
    for lattice in lattices([300, 200]) {
        let (mut best, mut plain) = (vec![EvenVertex::default(); 1003], vec![EvenVertex::default(); 1003]);
        match &lattice.columns {
            Columns::Even(columns) => {
                project(&lattice, columns, &clip_from_local, &positions, &mut best);
                project_all(&lattice, columns, &clip_from_local, &positions, &mut plain);
            }
            Columns::Uneven(columns) => {
                project(&lattice, columns, &clip_from_local, &positions, &mut best);
                project_all(&lattice, columns, &clip_from_local, &positions, &mut plain);
            }
        }
        assert_eq!(best, plain);
        assert!(best.iter().any(EvenVertex::is_cut) && best.iter().any(|v| !v.is_cut()));
    }
}
