//! A batch of instances: projected, binned chunk by chunk, and drawn band by band.

use std::ops::Range;

use glam::{DMat4, Vec3};
use rayon::prelude::*;

use super::bins::Bins;
use super::fill::{Filling, fill, from_top};
use super::lattice::{Columns, Lattice, distance};
use super::lists::EXTRA;
use super::places::Places;
use super::tested::fill_tested;
use super::tiny::{TINY, Target};
use super::vertex::{EvenVertex, project, vertex_of};
use crate::error::Result;
use crate::progress::Progress;
use crate::render::cpu::faces::{FaceTest, Faces};
use crate::render::cpu::kept::{Kept, RUN, vertices_of};
use crate::render::cpu::raster::{BandArea, Bands, Pixels};
use crate::render::cpu::tested_triangle::TestedTriangle;
use crate::scene::{Mesh, Scene};

/// Triangles that are looked at before those that have texels are binned, and between two looks at the bytes written.
const SLICE: usize = 1 << 8;

/// One placed mesh of a batch.
struct Draw<'a> {
    mesh: &'a Mesh,
    kept: Kept<'a>,
    clip_from_local: DMat4,
    faces: FaceTest,
    first_vertex: usize,
    first_triangle: usize,
}

/// Instances that are drawn together.
pub struct Batch<'a> {
    lattice: &'a Lattice,
    draws: Vec<Draw<'a>>,
    /// Whether they have alpha tests: all of them, or none.
    is_tested: bool,
    bands: Bands,
    /// What depths that are kept are less than those of the map.
    less: f64,
}

impl<'a> Batch<'a> {
    /// Some instances of a scene.
    pub fn new(
        lattice: &'a Lattice,
        scene: &'a Scene,
        faces: Faces,
        instances: &[u32],
        is_tested: bool,
        less: f64,
    ) -> Self {
        let (mut first_vertex, mut first_triangle) = (0, 0);
        let volume = lattice.volume();
        let draw = |&i: &u32| {
            let clip_from_local = scene.clip_from_local(&lattice.clip_from_world, i as usize);
            let (mesh, faces) = (scene.mesh_of(i as usize), FaceTest::new(faces, &clip_from_local));
            let kept = Kept::new(mesh, &clip_from_local, &volume);
            let (vertices, triangles) = (kept.positions.len(), kept.triangles.len());
            let draw = Draw { mesh, kept, clip_from_local, faces, first_vertex, first_triangle };
            first_vertex += vertices;
            first_triangle += triangles;
            draw
        };
        let draws = instances.iter().map(draw).collect();
        Self { lattice, draws, is_tested, bands: Bands::new(lattice.size), less }
    }

    /// Projects the vertices; the number of triangles.
    pub fn project(&self, vertices: &mut Vec<EvenVertex>, progress: &Progress) -> Result<u32> {
        let Some(last) = self.draws.last() else { return Ok(0) };
        let count = last.first_vertex + last.kept.positions.len();
        if vertices.len() < count {
            vertices.resize(count, EvenVertex::default());
        }
        let mut rest = &mut vertices[..count];
        let mut work = Vec::with_capacity(self.draws.len());
        for draw in &self.draws {
            let (own, after) = rest.split_at_mut(draw.kept.positions.len());
            work.push((draw, own));
            rest = after;
        }
        work.into_par_iter().try_for_each(|(draw, out)| {
            let positions = draw.kept.positions.par_chunks(RUN);
            let needed = draw.kept.needed();
            positions.zip(out.par_chunks_mut(RUN)).zip(needed).try_for_each(|((positions, out), needed)| {
                progress.check()?;
                for vertices in vertices_of(needed, out.len()) {
                    let (lattice, clip_from_local) = (self.lattice, &draw.clip_from_local);
                    let (positions, out) = (&positions[vertices.clone()], &mut out[vertices]);
                    match &lattice.columns {
                        Columns::Even(columns) => project(lattice, columns, clip_from_local, positions, out),
                        Columns::Uneven(columns) => project(lattice, columns, clip_from_local, positions, out),
                    }
                }
                Ok(())
            })
        })?;
        Ok((last.first_triangle + last.kept.triangles.len()) as u32)
    }

    /// Draws what a chunk leaves to a band.
    pub fn fill<P: Pixels>(&self, bins: &Bins, vertices: &[EvenVertex], band: usize, area: BandArea, pixels: &mut P) {
        bins.bands[band].fragments.draw(pixels);
        match &self.lattice.columns {
            Columns::Even(columns) => self.fill_between(columns, bins, vertices, band, area, pixels),
            Columns::Uneven(columns) => self.fill_between(columns, bins, vertices, band, area, pixels),
        }
    }

    fn fill_between<C: Places, P: Pixels>(
        &self,
        columns: &C,
        bins: &Bins,
        vertices: &[EvenVertex],
        band: usize,
        area: BandArea,
        pixels: &mut P,
    ) {
        let rows = self.lattice.rows.with_infinities();
        let work = &Filling { vertices, extra: &bins.extra, rows, columns, area };
        for list in [&bins.bands[band].list, &bins.large] {
            if self.is_tested {
                let tested = |number: usize| {
                    let draw = &self.draws[self.draws.partition_point(|draw| draw.first_triangle <= number) - 1];
                    TestedTriangle::new(draw.mesh, number - draw.first_triangle, &draw.clip_from_local)
                };
                fill_tested(work, list, tested, pixels);
            } else {
                fill(work, list, pixels);
            }
        }
    }

    /// Bins the triangles of a chunk, or the first of them where they write too much; the first that is not binned.
    pub fn bin(&self, bins: &mut Bins, vertices: &[EvenVertex], chunk: Range<u32>) -> u32 {
        match &self.lattice.columns {
            Columns::Even(columns) => self.bin_between(columns, bins, vertices, chunk),
            Columns::Uneven(columns) => self.bin_between(columns, bins, vertices, chunk),
        }
    }

    fn bin_between<C: Places>(&self, columns: &C, bins: &mut Bins, vertices: &[EvenVertex], chunk: Range<u32>) -> u32 {
        bins.start(self.bands);
        let target = &Target { rows: self.lattice.rows.with_infinities(), columns, bands: self.bands, less: self.less };
        let mut d = self.draws.partition_point(|draw| draw.first_triangle <= chunk.start as usize) - 1;
        let mut start = chunk.start;
        while start < chunk.end && !bins.is_full() {
            let draw = &self.draws[d];
            let draw_end = (draw.first_triangle + draw.kept.triangles.len()) as u32;
            let end = chunk.end.min(draw_end).min(start + SLICE as u32);
            let own = &vertices[draw.first_vertex..][..draw.kept.positions.len()];
            let first = draw.first_triangle as u32;
            for run in draw.kept.runs(start - first..end - first) {
                self.bin_run(bins, target, draw, own, run);
            }
            start = end;
            d += usize::from(end == draw_end);
        }
        let Bins { bands, tiny, .. } = bins;
        tiny.iter_mut().for_each(|tiny| tiny.emit(target, bands));
        start
    }

    /// Bins the triangles at some places of a draw's order.
    #[inline(always)]
    fn bin_run<C: Places>(
        &self,
        bins: &mut Bins,
        target: &Target<C>,
        draw: &Draw,
        own: &[EvenVertex],
        places: Range<u32>,
    ) {
        // Most triangles have no row or no column. No branch depends on that, as it would be guessed wrongly.
        let (mut passed, mut count) = ([0; SLICE], 0);
        for place in places {
            let texels = draw.kept.triangles[place as usize].map(|i| own[i as usize].texel());
            let [a, b, c] = texels;
            passed[count] = place;
            count += usize::from(are_between(texels) | ((a | b | c) >> 63 != 0));
        }
        for &place in &passed[..count] {
            self.bin_triangle(bins, target, draw, own, place);
        }
    }

    /// Bins a triangle that may have texels.
    #[inline(always)]
    fn bin_triangle<C: Places>(
        &self,
        bins: &mut Bins,
        target: &Target<C>,
        draw: &Draw,
        own: &[EvenVertex],
        place: u32,
    ) {
        let corners = draw.kept.triangles[place as usize];
        if !draw.faces.takes_all() && !draw.takes(corners) {
            return;
        }
        let seen = corners.map(|i| &own[i as usize]);
        if seen.iter().any(|v| v.is_cut()) {
            return self.bin_cut(bins, target, draw, corners, place);
        }
        let [a, b, c] = from_top(seen);
        let (first, end) = (a.first_row, c.first_row);
        let left = a.first_column.min(b.first_column).min(c.first_column);
        let right = a.first_column.max(b.first_column).max(c.first_column);
        if self.is_tested || end - first > TINY || right - left > TINY {
            let number = self.is_tested.then(|| draw.number(place));
            return bins.push(corners.map(|i| draw.first_vertex as u32 + i), first, end, number, self.bands);
        }
        let Bins { bands, tiny, .. } = bins;
        let tiny = &mut tiny[usize::from(end - first > TINY / 2)];
        if tiny.push([a.corner, b.corner, c.corner], first, end) {
            tiny.emit(target, bands);
        }
    }

    /// Bins what is left of a triangle that has to be cut.
    #[cold]
    fn bin_cut<C: Places>(&self, bins: &mut Bins, target: &Target<C>, draw: &Draw, corners: [u32; 3], place: u32) {
        let positions = draw.kept.positions;
        let clip = corners.map(|c| clip_of(&draw.clip_from_local, positions[c as usize]));
        bins.polygon.start(clip);
        for plane in &self.lattice.planes {
            bins.polygon.cut(|clip| distance(plane, clip));
        }
        let first = bins.extra.len();
        let cut = bins.polygon.corners().iter().map(|clip| vertex_of(self.lattice, target.columns, *clip));
        bins.extra.extend(cut);
        let number = self.is_tested.then(|| draw.number(place));
        for k in 2..bins.extra.len() - first {
            let fan = [first, first + k - 1, first + k];
            if are_between(fan.map(|i| bins.extra[i].texel())) {
                let [top, _, bottom] = from_top(fan.map(|i| &bins.extra[i]));
                let (first, end) = (top.first_row, bottom.first_row);
                bins.push(fan.map(|i| i as u32 | EXTRA), first, end, number, self.bands);
            }
        }
    }
}

impl Draw<'_> {
    /// The number in the batch of the triangle at a place.
    fn number(&self, place: u32) -> u32 {
        self.first_triangle as u32 + self.kept.number(place)
    }
    /// Whether a triangle's face is drawn.
    fn takes(&self, corners: [u32; 3]) -> bool {
        let positions = self.kept.positions;
        self.faces.takes(corners.map(|c| clip_of(&self.clip_from_local, positions[c as usize])))
    }
}

/// Whether some rows and some columns lie between corners with these texels.
#[inline(always)]
fn are_between([a, b, c]: [u64; 3]) -> bool {
    let differ = (a ^ b) | (a ^ c);
    (differ >> 32 != 0) & (differ as u32 != 0)
}

/// Clip coordinates of a local point.
fn clip_of(m: &DMat4, p: Vec3) -> [f64; 4] {
    (*m * p.as_dvec3().extend(1.0)).to_array()
}
