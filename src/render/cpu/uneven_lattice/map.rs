//! Depth maps of an uneven lattice: triangles are projected, binned and drawn at its rows and columns.
//!
//! Departure from [`raster`](crate::render::cpu::raster): the one grid of 1/256 cannot be fine enough where rows are dense, so
//! places are f64 and edges are evaluated row by row ([`triangle`](super::triangle)).

use std::mem::MaybeUninit;
use std::ops::Range;

use glam::{DMat4, DVec4, Vec3};
use rayon::prelude::*;

use super::lattice::{Columns, Lattice, Places};
use super::tested::fill_tested;
use super::texels::{Nearest, NearestTwo, Texels};
use super::triangle::{EXTRA, EvenVertex, Polygon, fill_band};
use crate::error::Result;
use crate::memory::filled;
use crate::progress::Progress;
use crate::render::cpu::faces::{FaceTest, Faces};
use crate::render::cpu::kept::{Kept, RUN, vertices_of};
use crate::render::cpu::raster::{Bands, batches, by_test};
use crate::render::cpu::tested_triangle::TestedTriangle;
use crate::render::{Keep, Volume};
use crate::scene::{Mesh, Scene};

/// Vertices or triangles after which a batch ends; its vertices take 4 MB. One instance is never split.
const BATCH: usize = 1 << 17;
/// Triangles that one thread bins at once.
const CHUNK: usize = 1 << 12;
/// Chunks that are binned before the bands are drawn: 480 bytes a triangle where all are cut to heptagons, 63 MB; 710 bytes
/// and 93 MB where they are cut to decagons, as in a rectilinear map.
const ROUND: usize = 32;
/// Bands up to which a triangle is listed in each that it touches; one that touches more is listed once for all.
const FEW_BANDS: u32 = 4;

/// One placed mesh of a batch.
struct Draw<'a> {
    mesh: &'a Mesh,
    kept: Kept<'a>,
    clip_from_local: DMat4,
    faces: FaceTest,
    first_vertex: usize,
    first_triangle: usize,
}

/// What a chunk of triangles leaves.
#[derive(Default)]
struct Bins {
    /// Triangles by band, as indices into the batch's vertices, or with [`EXTRA`] into those that clipping made.
    bands: Vec<Vec<[u32; 3]>>,
    /// Triangles that touch more than [`FEW_BANDS`].
    large: Vec<[u32; 3]>,
    /// Of a batch with alpha tests the numbers of these triangles in it, list by list.
    numbers: Vec<Vec<u32>>,
    large_numbers: Vec<u32>,
    extra: Vec<EvenVertex>,
    polygon: Polygon,
}

impl Lattice {
    /// Draws depth, 1 where nothing is, into all of `depth` (rows from the top).
    pub fn depth(
        &self,
        scene: &Scene,
        faces: Faces,
        keep: Keep,
        depth: &mut [MaybeUninit<f32>],
        progress: &Progress,
    ) -> Result<()> {
        let bands = depth.par_chunks_mut(self.part()).map(|band| Nearest::<false> { depth: filled(band, 1.0) });
        self.draw_all(scene, (faces, keep), bands.collect(), progress)
    }

    /// Draws depth minus 1, 0 where nothing is, into all of `depth`.
    pub fn depth_to_far(
        &self,
        scene: &Scene,
        faces: Faces,
        keep: Keep,
        depth: &mut [MaybeUninit<f32>],
        progress: &Progress,
    ) -> Result<()> {
        let bands = depth.par_chunks_mut(self.part()).map(|band| Nearest::<true> { depth: filled(band, 0.0) });
        self.draw_all(scene, (faces, keep), bands.collect(), progress)
    }

    /// The same for the two nearest depths that differ.
    pub fn layers_to_far(
        &self,
        scene: &Scene,
        keep: Keep,
        first: &mut [MaybeUninit<f32>],
        second: &mut [MaybeUninit<f32>],
        progress: &Progress,
    ) -> Result<()> {
        let bands = first.par_chunks_mut(self.part()).zip(second.par_chunks_mut(self.part()));
        let bands = bands.map(|(first, second)| NearestTwo { first: filled(first, 0.0), second: filled(second, 0.0) });
        self.draw_all(scene, (Faces::All, keep), bands.collect(), progress)
    }

    /// Texels of a band.
    fn part(&self) -> usize {
        Bands::new(self.size).rows() * self.size[0] as usize
    }

    fn draw_all<T: Texels>(
        &self,
        scene: &Scene,
        what: (Faces, Keep),
        mut texels: Vec<T>,
        progress: &Progress,
    ) -> Result<()> {
        let bands = Bands::new(self.size);
        let (mut vertices, mut bins) = (Vec::new(), Vec::new());
        // Those with alpha tests after all others, in batches of their own.
        let by_test = by_test(scene, what.1.instances(scene, &self.volume()));
        for instances in by_test.iter().flat_map(|instances| batches(scene, instances, BATCH)) {
            let batch = self.draws(scene, what.0, instances);
            let triangles = self.project(&batch, &mut vertices, progress)?;
            let chunks: Vec<usize> = (0..triangles).step_by(CHUNK).collect();
            for round in chunks.chunks(ROUND) {
                bins.resize_with(bins.len().max(round.len()), Bins::default);
                let bins = &mut bins[..round.len()];
                bins.par_iter_mut().zip(round).try_for_each(|(bins, &first)| {
                    progress.check()?;
                    self.bin(bins, &batch, &vertices, first..triangles.min(first + CHUNK), bands);
                    Ok(())
                })?;
                let bins = &*bins;
                texels.par_iter_mut().enumerate().try_for_each(|(band, texels)| {
                    progress.check()?;
                    let first_row = band * bands.rows();
                    let rows = first_row..(first_row + bands.rows()).min(self.rows.len());
                    for bins in bins {
                        match &self.columns {
                            Columns::Even(columns) => {
                                self.draw(bins, &batch, &vertices, columns, band, rows.clone(), texels);
                            }
                            Columns::Uneven(columns) => {
                                self.draw(bins, &batch, &vertices, columns, band, rows.clone(), texels);
                            }
                        }
                    }
                    Ok(())
                })?;
            }
        }
        Ok(())
    }

    /// Draws what a chunk leaves to a band.
    #[allow(clippy::too_many_arguments)]
    fn draw<C: Places, T: Texels>(
        &self,
        bins: &Bins,
        batch: &[Draw],
        vertices: &[EvenVertex],
        columns: &C,
        band: usize,
        rows: Range<usize>,
        texels: &mut T,
    ) {
        let (own, large) = (&bins.bands[band], &bins.large);
        if !is_tested(batch) {
            for list in [own, large] {
                fill_band(list, vertices, &bins.extra, &self.rows, columns, rows.clone(), texels);
            }
            return;
        }
        for (list, numbers) in [(own, &bins.numbers[band]), (large, &bins.large_numbers)] {
            let tested = |i: usize| {
                let number = numbers[i] as usize;
                let draw = &batch[batch.partition_point(|draw| draw.first_triangle <= number) - 1];
                TestedTriangle::new(draw.mesh, number - draw.first_triangle, &draw.clip_from_local)
            };
            fill_tested(list, tested, vertices, &bins.extra, &self.rows, columns, rows.clone(), texels);
        }
    }

    /// The draws of a batch.
    fn draws<'a>(&self, scene: &'a Scene, faces: Faces, instances: &[u32]) -> Vec<Draw<'a>> {
        let (mut first_vertex, mut first_triangle) = (0, 0);
        let volume = self.volume();
        let draw = |&i: &u32| {
            let clip_from_local = scene.clip_from_local(&self.clip_from_world, i as usize);
            let (mesh, faces) = (scene.mesh_of(i as usize), FaceTest::new(faces, &clip_from_local));
            let kept = Kept::new(mesh, &clip_from_local, &volume);
            let (vertices, triangles) = (kept.positions.len(), kept.triangles.len());
            let draw = Draw { mesh, kept, clip_from_local, faces, first_vertex, first_triangle };
            first_vertex += vertices;
            first_triangle += triangles;
            draw
        };
        instances.iter().map(draw).collect()
    }

    /// Where the map has texels.
    pub fn volume(&self) -> Volume {
        let ([left, right], [top, bottom]) = (self.across, self.down);
        let (x, down, z, w) = (DVec4::X, DVec4::Y, DVec4::Z, DVec4::W);
        let planes = [x - left * w, right * w - x, down - top * w, bottom * w - down, z, w - z];
        Volume::new(&self.clip_from_world, planes)
    }

    /// Projects the vertices of a batch; the number of its triangles.
    fn project(&self, batch: &[Draw], vertices: &mut Vec<EvenVertex>, progress: &Progress) -> Result<usize> {
        let Some(last) = batch.last() else { return Ok(0) };
        let count = last.first_vertex + last.kept.positions.len();
        if vertices.len() < count {
            vertices.resize(count, EvenVertex::default());
        }
        let mut rest = &mut vertices[..count];
        let mut work = Vec::with_capacity(batch.len());
        for draw in batch {
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
                    for (p, out) in positions[vertices.clone()].iter().zip(&mut out[vertices]) {
                        let clip = clip_of(&draw.clip_from_local, *p);
                        *out = if self.is_whole(clip) { self.vertex(clip) } else { EvenVertex::CUT };
                    }
                }
                Ok(())
            })
        })?;
        Ok(last.first_triangle + last.kept.triangles.len())
    }

    /// Whether a point needs no cut.
    fn is_whole(&self, clip: [f64; 4]) -> bool {
        self.planes.iter().all(|plane| distance(plane, clip) >= 0.0)
    }

    /// The place of a point in front of the projection centre.
    fn vertex(&self, [x, down, z, w]: [f64; 4]) -> EvenVertex {
        let inverse_w = w.recip();
        let (column, down) = ((x * inverse_w + 1.0) * (0.5 * f64::from(self.size[0])), down * inverse_w);
        EvenVertex {
            column,
            down,
            z: z * inverse_w,
            first_column: self.columns.first(column) as u32,
            first_row: self.rows.partition_point(|row| *row < down) as u32,
        }
    }

    /// Bins the triangles of a chunk.
    fn bin(&self, bins: &mut Bins, batch: &[Draw], vertices: &[EvenVertex], chunk: Range<usize>, bands: Bands) {
        bins.bands.resize_with(bands.count as usize, Vec::new);
        bins.bands.iter_mut().for_each(Vec::clear);
        bins.large.clear();
        bins.extra.clear();
        bins.numbers.iter_mut().for_each(Vec::clear);
        bins.large_numbers.clear();
        let is_tested = is_tested(batch);
        if is_tested {
            bins.numbers.resize_with(bands.count as usize, Vec::new);
        }
        let mut d = batch.partition_point(|draw| draw.first_triangle <= chunk.start) - 1;
        let mut start = chunk.start;
        while start < chunk.end {
            let draw = &batch[d];
            let triangles = draw.kept.triangles;
            let end = chunk.end.min(draw.first_triangle + triangles.len());
            let own = &vertices[draw.first_vertex..];
            let places = (start - draw.first_triangle) as u32..(end - draw.first_triangle) as u32;
            for place in draw.kept.runs(places).flatten() {
                let corners = triangles[place as usize];
                let number = is_tested.then(|| draw.first_triangle as u32 + draw.kept.number(place));
                if !draw.faces.takes_all() && !draw.takes(corners) {
                    continue;
                }
                let seen = corners.map(|c| own[c as usize]);
                if seen.iter().any(EvenVertex::is_cut) {
                    self.bin_cut(bins, draw, corners, number, bands);
                } else {
                    bins.add(corners.map(|c| draw.first_vertex as u32 + c), seen, number, bands);
                }
            }
            start = end;
            d += 1;
        }
    }

    /// Bins what is left of a triangle that has to be cut.
    fn bin_cut(&self, bins: &mut Bins, draw: &Draw, corners: [u32; 3], number: Option<u32>, bands: Bands) {
        let positions = draw.kept.positions;
        let clip = corners.map(|c| clip_of(&draw.clip_from_local, positions[c as usize]));
        bins.polygon.start(clip);
        for plane in &self.planes {
            bins.polygon.cut(|clip| distance(plane, clip));
        }
        let first = bins.extra.len();
        bins.extra.extend(bins.polygon.corners().iter().map(|clip| self.vertex(*clip)));
        for k in 2..bins.extra.len() - first {
            let fan = [first, first + k - 1, first + k];
            bins.add(fan.map(|i| i as u32 | EXTRA), fan.map(|i| bins.extra[i]), number, bands);
        }
    }
}

impl Draw<'_> {
    /// Whether a triangle's face is drawn.
    fn takes(&self, corners: [u32; 3]) -> bool {
        let positions = self.kept.positions;
        self.faces.takes(corners.map(|c| clip_of(&self.clip_from_local, positions[c as usize])))
    }
}

impl Bins {
    /// Lists a triangle where it may have a texel's centre, with its number in the batch if that is asked for.
    fn add(&mut self, indices: [u32; 3], corners: [EvenVertex; 3], number: Option<u32>, bands: Bands) {
        let [a, b, c] = corners;
        let rows = [a.first_row.min(b.first_row).min(c.first_row), a.first_row.max(b.first_row).max(c.first_row)];
        let first_column = a.first_column.min(b.first_column).min(c.first_column);
        let last_column = a.first_column.max(b.first_column).max(c.first_column);
        if rows[0] == rows[1] || first_column == last_column {
            return;
        }
        let (first, last) = (rows[0] >> bands.log2_rows, (rows[1] - 1) >> bands.log2_rows);
        if last - first >= FEW_BANDS {
            self.large.push(indices);
            self.large_numbers.extend(number);
        } else {
            (first..=last).for_each(|band| self.bands[band as usize].push(indices));
            if let Some(number) = number {
                (first..=last).for_each(|band| self.numbers[band as usize].push(number));
            }
        }
    }
}

/// Whether a batch has alpha tests; all of its draws have, or none.
fn is_tested(batch: &[Draw]) -> bool {
    batch.first().is_some_and(|draw| draw.mesh.alpha_test().is_some())
}

/// Clip coordinates of a local point.
fn clip_of(m: &DMat4, p: Vec3) -> [f64; 4] {
    (*m * p.as_dvec3().extend(1.0)).to_array()
}

/// How far a point is on the inner side of a plane whose last coefficient stands alone.
fn distance(plane: &[f64; 5], clip: [f64; 4]) -> f64 {
    plane[4] + (0..4).map(|i| plane[i] * clip[i]).sum::<f64>()
}
