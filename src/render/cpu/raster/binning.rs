//! Triangles sorted into the horizontal bands of the image that they may touch.
//!
//! Bands are drawn independently of each other, each by one thread with its part of the image in the cache, so depth needs
//! no atomics. In a fine mesh most triangles end here: those beyond a plane of the clip volume and those whose box holds no
//! pixel centre are gone, and those whose box holds a few become the fragments they cover at once, [`LANES`] triangles side
//! by side. Only what is larger is kept as a triangle, in each of the few bands that it touches.
//!
//! What a chunk of triangles leaves is bounded in bytes: filling stops there, and what is left over waits for a later round.

use std::ops::Range;

use super::bins::{Bands, Bins, Entry};
use super::clip::{clip_triangle, exact_position};
use super::cover::{Cover, Grid, Hidden};
use super::drawn_mesh::Draw;
use super::lanes::Lanes;
use super::pieces::Pieces;
use super::simd::LANES;
use super::tiny::{TINY, Tiny};
use super::triangle_setup::{Boxes, CornerSource, Corners, LargeSetup, SMALL, SmallSetup, box_of, pixels_in_box};
use super::vertices::{CLIP, OUTSIDE, ScreenVertex, Viewport};
use super::with_lanes::with_lanes;

/// Triangles binned between two looks at the bytes written.
const SLICE: u32 = 1 << 8;

/// A batch of triangles on their way into the bands of an image.
#[derive(Debug, Clone, Copy)]
pub struct Binning<'a> {
    pub draws: &'a [Draw<'a>],
    pub pieces: &'a Pieces,
    /// What has been drawn, where that may hide something; the pieces have been held against it.
    pub cover: Option<&'a Cover>,
    /// The tiles of the image.
    pub grid: Grid,
    pub vertices: &'a [ScreenVertex],
    pub viewport: &'a Viewport,
    pub bands: Bands,
    /// Whether fragments bear the numbers of their triangles.
    pub numbered: bool,
}

with_lanes! {
    /// Bins the triangles `range`, or the first of them where they write too much; the first that is not binned.
    pub fn fill(work: &Binning, bins: &mut Bins, range: Range<u32>) -> u32 = fill_with
}

#[inline(always)]
fn fill_with<L: Lanes>(lanes: L, work: &Binning, bins: &mut Bins, range: Range<u32>) -> u32 {
    let Binning { draws, pieces, cover, bands, .. } = *work;
    bins.start(bands);
    let (mut start, mut looked_at) = (range.start, 0);
    let mut p = pieces.at(start);
    while start < range.end {
        let piece = &pieces[p];
        let piece_end = piece.start + piece.count;
        let end = range.end.min(piece_end).min(start + SLICE);
        looked_at += end - start;
        if looked_at > SLICE {
            if bins.is_full() {
                break;
            }
            looked_at = end - start;
        }
        let draw = &draws[piece.draw as usize];
        let first = piece.first + (start - piece.start);
        if piece.hidden != Hidden::All {
            let cover = cover.filter(|_| piece.hidden == Hidden::Some);
            bins.bin_draw(lanes, work, cover, draw, first..first + (end - start));
        }
        start = end;
        p += usize::from(end == piece_end);
    }
    start
}

impl Bins {
    /// Bins the triangles at some places of a draw's order.
    #[inline(always)]
    fn bin_draw<L: Lanes>(&mut self, lanes: L, work: &Binning, cover: Option<&Cover>, draw: &Draw, places: Range<u32>) {
        let own = &work.vertices[draw.first_vertex as usize..][..draw.kept.positions.len()];
        let mut first = places.start;
        let (groups, rest) = draw.kept.triangles[places.start as usize..places.end as usize].as_chunks::<LANES>();
        for group in groups {
            let number = if work.numbered { draw.numbers(first, LANES as u32) } else { [0; LANES] };
            self.bin_group(lanes, work, cover, draw, group, &number, LANES as u32, own);
            first += LANES as u32;
        }
        if let Some(last) = rest.last() {
            // The last one again where there are fewer.
            let group = std::array::from_fn(|l| *rest.get(l).unwrap_or(last));
            let count = rest.len() as u32;
            self.bin_group(lanes, work, cover, draw, &group, &draw.numbers(first, count), count, own);
        }
    }

    /// Bins the first `count` triangles of a group, whose scene-wide numbers are `number`.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn bin_group<L: Lanes>(
        &mut self,
        lanes: L,
        work: &Binning,
        cover: Option<&Cover>,
        draw: &Draw,
        group: &[[u32; 3]; LANES],
        number: &[u32; LANES],
        count: u32,
        own: &[ScreenVertex],
    ) {
        let Binning { viewport, bands, numbered, .. } = *work;
        let corners = Corners::gather(lanes, OfDraw { group, own });
        let [a, b, c] = corners.code;
        let (outside, zero) = (lanes.int(OUTSIDE as i32), lanes.int(0));
        let unseen = lanes.less(zero, lanes.and(lanes.and(lanes.and(a, b), c), outside));
        let seen = !lanes.signs(unseen) & ((1 << count) - 1);
        if seen == 0 {
            return;
        }
        let boxes = Boxes::new(lanes, &corners, viewport.size);
        let [x0, y0, x1, y1] = boxes.at;
        let cut = lanes.signs(lanes.less(zero, lanes.and(lanes.or(lanes.or(a, b), c), lanes.int(CLIP as i32))));
        let (columns, rows) = (lanes.sub(x1, x0), lanes.sub(y1, y0));
        let none = lanes.signs(lanes.or(columns, rows));
        let most = lanes.int(TINY - 1);
        let large = lanes.signs(boxes.large);
        let many = lanes.signs(lanes.or(lanes.less(most, columns), lanes.less(most, rows))) | large;
        let taken = if draw.faces.takes_all() { seen } else { seen & taken(draw, group) };
        let (mut live, clip) = (taken & !cut & !none, taken & cut);
        if let Some(cover) = cover
            && live & !large != 0
        {
            let [z0, z1, z2] = corners.z;
            let nearest = lanes.smaller(lanes.smaller(z0, z1), z2);
            // The depths of large ones are those of f64.
            live &= !cover.tiles().hidden(lanes, boxes.at, nearest) | large;
        }
        let tiny = live & !many;
        if tiny != 0 {
            let setup = SmallSetup::new::<1>(lanes, &corners, &boxes);
            let tiny = Tiny { setup: &setup, boxes: &boxes.at, taken: tiny, number, numbered, grid: work.grid };
            tiny.emit(lanes, viewport.size[0], bands, self);
        }
        let mut rest = (live & many) | clip;
        if rest == 0 {
            return;
        }
        let (first_row, last_row) = (lanes.to_ints(y0), lanes.to_ints(y1));
        while rest != 0 {
            let l = rest.trailing_zeros() as usize % LANES;
            rest &= rest - 1;
            let id = number[l];
            let [a, b, c] = group[l];
            if (clip | large) >> l & 1 == 0 {
                let vertices = [draw.first_vertex + a, draw.first_vertex + b, draw.first_vertex + c];
                self.push(Entry { vertices, id }, [first_row[l], last_row[l]], bands);
                continue;
            }
            let corners = [own[a as usize], own[b as usize], own[c as usize]];
            if clip >> l & 1 == 0 {
                self.bin_large(draw, &group[l], corners, id, viewport, bands);
            } else {
                self.bin_clipped(draw, &group[l], corners, id, viewport, bands);
            }
        }
    }

    #[cold]
    fn bin_large(
        &mut self,
        draw: &Draw,
        indices: &[u32; 3],
        v: [ScreenVertex; 3],
        id: u32,
        viewport: &Viewport,
        bands: Bands,
    ) {
        let positions = draw.kept.positions;
        let exact = [0, 1, 2].map(|k: usize| {
            let clip = draw.projection.clip(positions[indices[k] as usize].as_dvec3());
            exact_position(viewport, clip, v[k])
        });
        if let Some(setup) = LargeSetup::new(v, exact, viewport.size, id) {
            self.push_large(setup, bands);
        }
    }

    #[cold]
    fn bin_clipped(
        &mut self,
        draw: &Draw,
        indices: &[u32; 3],
        v: [ScreenVertex; 3],
        id: u32,
        viewport: &Viewport,
        bands: Bands,
    ) {
        let positions = draw.kept.positions;
        let clip = indices.map(|i| draw.projection.clip(positions[i as usize].as_dvec3()));
        let mut polygon = std::mem::take(&mut self.polygon);
        clip_triangle(viewport, clip, v, &mut polygon);
        let first = Entry::EXTRA | self.extra.len() as u32;
        self.extra.extend(polygon.iter().map(|v| v.screen));
        for k in 2..polygon.len() {
            let corners = [polygon[0], polygon[k - 1], polygon[k]];
            let (min, max) = box_of(corners.map(|v| v.screen));
            if max[0] - min[0] > SMALL || max[1] - min[1] > SMALL {
                let (screen, exact) = (corners.map(|v| v.screen), corners.map(|v| v.exact));
                if let Some(setup) = LargeSetup::new(screen, exact, viewport.size, id) {
                    self.push_large(setup, bands);
                }
                continue;
            }
            let (min, max) = pixels_in_box(min, max, viewport.size);
            if min[0] <= max[0] && min[1] <= max[1] {
                let vertices = [first, first + k as u32 - 1, first + k as u32];
                self.push(Entry { vertices, id }, [min[1], max[1]], bands);
            }
        }
        self.polygon = polygon;
    }
}

/// The corners of some triangles of a draw, with its vertices.
#[derive(Clone, Copy)]
struct OfDraw<'a> {
    group: &'a [[u32; 3]; LANES],
    own: &'a [ScreenVertex],
}

impl CornerSource for OfDraw<'_> {
    #[inline(always)]
    fn corner(&self, l: usize, k: usize) -> &ScreenVertex {
        let i = self.group[l][k] as usize;
        debug_assert!(i < self.own.len());
        // SAFETY: `Mesh::new` has checked every index against the number of vertices, `own` has one for each, and neither
        // meshes nor their clusters change.
        unsafe { self.own.get_unchecked(i) }
    }
}

/// A bit for each of some triangles of a draw whose faces are drawn.
#[cold]
fn taken(draw: &Draw, group: &[[u32; 3]; LANES]) -> u32 {
    let positions = draw.kept.positions;
    let bit = |l: usize| {
        let clip = group[l].map(|i| draw.projection.clip(positions[i as usize].as_dvec3()));
        u32::from(draw.faces.takes(clip)) << l
    };
    (0..LANES).map(bit).sum()
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};
    use rayon::prelude::*;

    use super::super::bins::Bin;
    use super::super::plain::Plain;
    use super::*;
    use crate::render::Volume;
    use crate::render::cpu::faces::Faces;
    use crate::scene::Mesh;

    /// A crumpled sheet larger than the map, of triangles of all sizes, some of which reach through the near plane.
    fn sheet() -> Mesh {
        let at = |i: i64| {
            let (u, v) = ((i % 50) as f64, (i / 50) as f64);
            [1e-3 * u * u - 1.2 + 0.02 * (7.0 * v).sin(), 1e-3 * v * v - 1.2, 0.4 + 0.5 * (u * v).sin()]
        };
        let vertices: Vec<[f64; 3]> = (0..2500).map(at).collect();
        let corner = |k: i64| k / 49 * 50 + k % 49;
        let pair = |k: i64| [[0, 1, 51], [0, 51, 50]].map(|t: [i64; 3]| t.map(|i| corner(k) + i));
        Mesh::new(&vertices, &(0..49 * 49).flat_map(pair).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn both_instruction_sets_leave_the_same_to_each_band() {
        let mesh = sheet();
        let size = [131, 200];
        let viewport = Viewport::new(size, size, 1.0);
        let clip_from_local = DMat4::from_translation(DVec3::Z * 0.1) * DMat4::from_scale(DVec3::new(2.2, 2.2, 0.7));
        let volume = Volume::of_clip(&clip_from_local, 0.0);
        let draw = Draw::new(&mesh, &clip_from_local, &volume, Faces::All, 7);
        let mut vertices = vec![ScreenVertex::default(); draw.kept.positions.len()];
        draw.projection.project(&viewport, draw.kept.positions, &mut vertices);
        let (draws, bands) = (&[draw], Bands::new(size));
        let (grid, viewport, vertices) = (Grid::new(size, bands), &viewport, &vertices);
        let mut pieces = Pieces::new(draws);
        pieces.order(draws, viewport, grid, 1000);
        let count = pieces.triangles;
        let mut cover = Cover::default();
        cover.start(grid);
        cover.bands_mut().enumerate().for_each(|(band, tiles)| {
            tiles.iter_mut().zip(0..).for_each(|(z, i)| *z = [0.2, 0.6, f32::INFINITY][(i + band) % 3]);
        });
        let mut drawn = Vec::new();
        for (numbered, cover) in [(false, None), (true, None), (false, Some(&cover)), (true, Some(&cover))] {
            if let Some(cover) = cover {
                pieces.hide(&(0..count), cover);
            }
            let pieces = &pieces;
            let work = Binning { draws, pieces, cover, grid, vertices, viewport, bands, numbered };
            let (mut best, mut plain) = (Bins::default(), Bins::default());
            assert_eq!(fill(&work, &mut best, 3..count), fill_with(Plain, &work, &mut plain, 3..count));
            let told = |bins: &Bins| (0..7).map(|band| format!("{:?}", bins.band(band))).collect::<Vec<_>>();
            assert_eq!(told(&best), told(&plain));
            assert_eq!(format!("{:?}", best.large), format!("{:?}", plain.large));
            let is_some = |has: fn(&Bin) -> bool| (0..7).any(|band| has(best.band(band)));
            assert!(is_some(|bin| bin.fragments.bytes(Vec::len) > 0) && is_some(|bin| !bin.entries.is_empty()));
            assert!(!best.extra.is_empty(), "some are clipped");
            drawn.push((0..7).map(|band| best.band(band).fragments.bytes(Vec::len)).sum::<usize>());
        }
        assert!(drawn[2] < drawn[0] && drawn[3] < drawn[1], "some are hidden: {drawn:?}");
    }
}
