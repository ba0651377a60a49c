//! From a scene to projected vertices and binned triangles, a bounded batch at a time.

use std::ops::Range;

use glam::DMat4;
use rayon::prelude::*;

use super::binning::{Binning, fill};
use super::bins::{Bands, Bins, CHUNK_BYTES};
use super::cover::{Cover, Grid};
use super::drawn_mesh::Draw;
use super::pieces::Pieces;
use super::projected::Projected;
use super::vertices::{ScreenVertex, Viewport};
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::render::cpu::faces::Faces;
use crate::render::{Keep, Volume};
use crate::scene::Scene;
use crate::simd::prefetch;

/// Vertices and triangles after which a batch ends. Its vertices take 16 bytes each, 16 MB. One instance is never split, so
/// a mesh beyond this size is a batch of its own.
const BATCH: usize = 1 << 20;
/// Triangles that one thread bins at once: what it writes stays in a level-2 cache.
const CHUNK: u32 = 1 << 12;
/// Chunks that are binned before the bands are drawn: enough for many threads, and for meshes of half a million triangles one
/// round. What they leave is bounded in bytes, chunk by chunk ([`fill`]), so a round takes at most [`BINS_BYTES`] whatever the
/// scene.
pub const ROUND: usize = 128;
/// Bytes that all bins may keep: 32 MB.
const BINS_BYTES: usize = 2 * ROUND * CHUNK_BYTES;
/// Chunks of a round of a small image: what is drawn hides triangles of later rounds before they are binned. A large one would
/// leave the cache between two rounds.
const SHORT_ROUND: usize = 16;
/// Pixels of a small image: 4 MB.
const SMALL_IMAGE: u64 = 1 << 20;
/// Chunks of a slab of depth, whose triangles hide those of the next.
pub const SLAB: usize = 16;
/// Matrices that one thread forms at once: some 50 µs of work.
const MATRICES: usize = 1 << 8;
/// Instances from the one whose matrix is formed to the one that is brought to the cache.
const AHEAD: usize = 8;

/// Memory for one batch, kept from one call to the next: fresh pages cost more than the work on them.
#[derive(Debug, Default)]
pub struct Scratch {
    pub vertices: Vec<ScreenVertex>,
    bins: Vec<Bins>,
    /// What hides triangles.
    cover: Cover,
    /// How many of the bins the present round fills.
    pub chunks: usize,
}

impl Scratch {
    /// The bins of the present round, in the order of submission.
    pub fn bins(&self) -> &[Bins] {
        &self.bins[..self.chunks]
    }
    /// Gives back what only a mesh larger than a batch has needed.
    pub fn shrink(&mut self) {
        self.vertices.truncate(2 * BATCH);
        self.vertices.shrink_to(2 * BATCH);
        self.shrink_bins();
        self.chunks = 0;
    }
    /// Begins a round of so many chunks.
    fn start(&mut self, chunks: usize) {
        if self.bins.len() < chunks {
            self.bins.resize_with(chunks, Bins::default);
        }
        self.shrink_bins();
        self.chunks = chunks;
    }
    /// Gives memory back of bins that have gathered more than their share, which is more than a chunk needs where they are few.
    fn shrink_bins(&mut self) {
        let most = BINS_BYTES / self.bins.len().max(1);
        self.bins.iter_mut().for_each(|bins| bins.shrink(most));
    }
}

/// The instances of a scene that are drawn, cut into batches; after those without an alpha test those with one.
pub struct Batches<'a> {
    scene: &'a Scene,
    clip_from_world: DMat4,
    faces: Faces,
    volume: Volume,
    /// Without alpha tests, and with them in ascending order.
    instances: [Vec<u32>; 2],
}

/// A part of what is drawn, projected and binned.
#[derive(Clone, Copy)]
pub struct Round<'a> {
    /// What it consists of.
    pub scratch: &'a Scratch,
    /// Its draws, where they have alpha tests.
    pub tested: Option<&'a [Draw<'a>]>,
    /// The tiles of the image.
    pub grid: Grid,
    /// Whether some triangles may hide others.
    pub hides: bool,
    /// Whether nothing has been drawn before.
    pub is_first: bool,
    /// Whether nothing is drawn after it.
    pub is_last: bool,
}

/// Whether an image is drawn in short rounds.
pub fn is_small([width, height]: [u32; 2]) -> bool {
    u64::from(width) * u64::from(height) <= SMALL_IMAGE
}

impl Round<'_> {
    /// Whether nothing is left to a band.
    pub fn is_empty(&self, band: usize) -> bool {
        self.scratch.bins().iter().all(|bins| bins.is_empty(band))
    }
}

impl<'a> Batches<'a> {
    /// The instances that `keep` takes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a scene whose triangles cannot be numbered in 32 bits.
    pub fn new(
        scene: &'a Scene,
        clip_from_world: &DMat4,
        viewport: &Viewport,
        faces: Faces,
        keep: Keep,
    ) -> Result<Self> {
        if scene.triangle_count() >= u64::from(u32::MAX) {
            return Err(Error::argument(
                "scene",
                format!("fewer than {} triangles, instances counted each time", u32::MAX),
                scene.triangle_count(),
                "split the scene",
            ));
        }
        let volume = Volume::of_clip(clip_from_world, f64::from(viewport.near));
        let [plain, mut tested] = by_test(scene, keep.instances(scene, &volume));
        // Their triangles are found by number (tested.rs); the hierarchy has an order of its own.
        tested.sort_unstable();
        Ok(Self { scene, clip_from_world: *clip_from_world, faces, volume, instances: [plain, tested] })
    }

    /// Projects each batch and bins it round by round into `scratch`, with the numbers of triangles if fragments are to be
    /// `numbered`; calls `draw` after each round.
    pub fn for_each_round(
        &self,
        viewport: &Viewport,
        bands: Bands,
        numbered: bool,
        scratch: &mut Scratch,
        progress: &Progress,
        mut draw: impl FnMut(Round, &mut Cover) -> Result<()>,
    ) -> Result<()> {
        let triangles = |i: &u32| self.scene.mesh_of(*i as usize).triangles().len() as u64;
        let total = self.instances.iter().flatten().map(triangles).sum();
        progress.set_total(total);
        let is_small = is_small(viewport.size);
        // A thread wants some chunks for itself.
        let short_round = SHORT_ROUND.max(4 * rayon::current_num_threads()).min(ROUND);
        let of_slab = SLAB as u32 * CHUNK;
        let grid = Grid::new(viewport.size, bands);
        let mut cover = std::mem::take(&mut scratch.cover);
        cover.start(grid);
        let (mut rest, mut is_first) = (total, true);
        for (instances, is_tested) in self.instances.iter().zip([false, true]) {
            for batch in batches(self.scene, instances, BATCH) {
                let draws = &self.draws(batch);
                let mut projected = Projected::new(draws, &mut scratch.vertices);
                let mut pieces = Pieces::new(draws);
                let of_batch = batch.iter().map(triangles).sum::<u64>();
                rest -= of_batch;
                progress.advance(of_batch - u64::from(pieces.triangles));
                // One slab alone hides nothing, and many small meshes little: in another order they scatter what is written.
                let hides = (!is_first || rest > 0 || pieces.triangles > of_slab) && is_mostly_clusters(draws);
                let chunks = if is_small && hides { short_round } else { ROUND };
                if hides {
                    pieces.order(draws, viewport, grid, of_slab);
                }
                let mut pending = Pending::new(pieces.triangles);
                while !pending.is_empty() {
                    let before = pending.triangles();
                    let mut round = pending.next_round(chunks);
                    let cover_of_round = (hides && !is_first).then_some(&cover);
                    scratch.start(round.len());
                    for (some, bins) in round.chunks_mut(short_round).zip(scratch.bins.chunks_mut(short_round)) {
                        for chunk in &*some {
                            if let Some(cover) = cover_of_round {
                                pieces.hide(chunk, cover);
                            }
                            projected.need(draws, pieces.of(chunk));
                        }
                        projected.project(draws, viewport, &mut scratch.vertices, progress)?;
                        let work = Binning {
                            draws,
                            pieces: &pieces,
                            cover: cover_of_round,
                            grid,
                            vertices: &scratch.vertices,
                            viewport,
                            bands,
                            numbered: numbered || is_tested,
                        };
                        fill_bins(bins, some, progress, |bins, chunk| fill(&work, bins, chunk))?;
                    }
                    pending.put_back(round);
                    let is_last = rest == 0 && pending.is_empty();
                    let tested = is_tested.then_some(&draws[..]);
                    draw(Round { scratch, tested, grid, hides, is_first, is_last }, &mut cover)?;
                    progress.advance(before - pending.triangles());
                    is_first = false;
                }
            }
        }
        if is_first {
            // Nothing is in view.
            scratch.chunks = 0;
            let (tested, hides, is_last) = (None, false, true);
            draw(Round { scratch, tested, grid, hides, is_first, is_last }, &mut cover)?;
        }
        scratch.cover = cover;
        Ok(())
    }

    /// The draws of a batch.
    fn draws(&self, instances: &[u32]) -> Vec<Draw<'a>> {
        let scene = self.scene;
        let draw = |(k, &i): (usize, &u32)| {
            // They lie all over a large scene.
            if let Some(&next) = instances.get(k + AHEAD) {
                prefetch(std::slice::from_ref(&scene.instances()[next as usize]));
                prefetch(std::slice::from_ref(&scene.first_triangles()[next as usize]));
            }
            let mesh = scene.mesh_of(i as usize);
            let clip_from_local = scene.clip_from_local(&self.clip_from_world, i as usize);
            // All numbers are below 2^32, see `new`.
            let first_id = scene.first_triangles()[i as usize] as u32;
            Draw::new(mesh, &clip_from_local, &self.volume, self.faces, first_id)
        };
        let mut draws: Vec<Draw> = instances.par_iter().enumerate().with_min_len(MATRICES).map(draw).collect();
        let mut vertices = 0;
        for draw in &mut draws {
            draw.first_vertex = vertices;
            vertices += draw.kept.positions.len() as u32;
        }
        draws
    }
}

/// Whether most triangles belong to meshes with clusters.
fn is_mostly_clusters(draws: &[Draw]) -> bool {
    let triangles = |draw: &Draw| draw.kept.triangles.len();
    let of_clusters = draws.iter().filter(|draw| draw.kept.has_clusters()).map(triangles).sum::<usize>();
    2 * of_clusters > draws.iter().map(triangles).sum::<usize>()
}

/// Instances without alpha tests, and with them, in the order in which they come.
pub fn by_test(scene: &Scene, instances: Vec<u32>) -> [Vec<u32>; 2] {
    if scene.meshes().iter().all(|mesh| mesh.alpha_test().is_none()) {
        return [instances, Vec::new()];
    }
    let is_tested = |i: &u32| scene.mesh_of(*i as usize).alpha_test().is_some();
    let (tested, plain) = instances.into_iter().partition(is_tested);
    [plain, tested]
}

/// Instances cut into batches of at most `most` vertices and triangles; one instance is never split.
pub fn batches<'a>(scene: &'a Scene, instances: &'a [u32], most: usize) -> impl Iterator<Item = &'a [u32]> {
    let mut rest = instances;
    std::iter::from_fn(move || {
        let (mut vertices, mut triangles) = (0, 0);
        let is_full = |&i: &u32| {
            let mesh = scene.mesh_of(i as usize);
            vertices += mesh.positions_local().len();
            triangles += mesh.triangles().len();
            vertices.max(triangles) > most
        };
        let len = rest.iter().position(is_full).map_or(rest.len(), |len| len.max(1));
        let (batch, after) = rest.split_at(len);
        rest = after;
        (!batch.is_empty()).then_some(batch)
    })
}

/// Fills bins with a chunk each. `fill` bins its triangles, or the first of them where they write too much, and says which is the
/// first that is not binned: what has not found room is left of the chunk.
///
/// The order of triangles has no say in what is drawn: of equal depths the smaller number wins.
pub fn fill_bins<B: Send>(
    bins: &mut [B],
    chunks: &mut [Range<u32>],
    progress: &Progress,
    fill: impl Fn(&mut B, Range<u32>) -> u32 + Sync,
) -> Result<()> {
    bins.par_iter_mut().zip(chunks).try_for_each(|(bins, chunk)| {
        progress.check()?;
        chunk.start = fill(bins, chunk.clone());
        Ok::<_, Error>(())
    })
}

/// Triangles of a batch that are not binned yet: chunks, the next one last.
#[derive(Debug)]
pub struct Pending(Vec<Range<u32>>);

impl Pending {
    /// So many triangles.
    pub fn new(triangles: u32) -> Self {
        Self((0..triangles).step_by(CHUNK as usize).map(|first| first..triangles.min(first + CHUNK)).rev().collect())
    }
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// How many triangles there are.
    pub fn triangles(&self) -> u64 {
        self.0.iter().map(|chunk| chunk.len() as u64).sum()
    }
    /// Takes at most so many chunks, the next one first.
    pub fn next_round(&mut self, chunks: usize) -> Vec<Range<u32>> {
        let mut round = self.0.split_off(self.0.len().saturating_sub(chunks));
        round.reverse();
        round
    }
    /// Puts back what is left of a round.
    pub fn put_back(&mut self, round: Vec<Range<u32>>) {
        self.0.extend(round.into_iter().rev().filter(|chunk| !chunk.is_empty()));
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, DVec4};
    use proptest::prelude::*;

    use super::super::bins::BandArea;
    use super::super::fill::{Entries, draw};
    use super::super::pixels::{DepthPixels, IdPixels, LayerPixels, Pixels};
    use super::*;
    use crate::render::cpu::passes::{NO_TRIANGLE, Pass};
    use crate::scene::Mesh;

    /// Bumpy sheets of 20,000 triangles, one behind the other in an order that is none, which hide each other in part; their
    /// depths are between 0 and 1.
    fn sheets(depths: &[f64], bumps: f64) -> Scene {
        const N: usize = 100;
        let mut all: Option<Scene> = None;
        for (&depth, k) in depths.iter().zip(1..) {
            let at = |i: usize| {
                let (u, v) = ((i % (N + 1)) as f64 / N as f64, (i / (N + 1)) as f64 / N as f64);
                let z = depth + bumps * (9.0 * u * f64::from(k)).sin() * (7.0 * v).cos();
                // Each leaves another corner free.
                let shift = 0.3 * f64::from(k % 3) - 0.3;
                [2.2 * u - 1.1 + shift, 2.2 * v - 1.1 - shift, z]
            };
            let vertices: Vec<[f64; 3]> = (0..(N + 1) * (N + 1)).map(at).collect();
            let corner = |q: usize| (q / N * (N + 1) + q % N) as i64;
            let pair =
                |q: usize| [[0, 1, N as i64 + 2], [0, N as i64 + 2, N as i64 + 1]].map(|t| t.map(|i| corner(q) + i));
            let mesh = Mesh::new(&vertices, &(0..N * N).flat_map(pair).collect::<Vec<_>>()).unwrap();
            let one = Scene::from_mesh(mesh).unwrap();
            all = Some(all.map_or(one.clone(), |all| all.joined(&one).unwrap()));
        }
        all.expect("some sheets")
    }

    /// Everything drawn in the order of the scene, nothing left out: chunk by chunk into a band as large as the image.
    fn drawn_plainly<P: Pixels>(scene: &Scene, m: &DMat4, size: [u32; 2], pixels: &mut P) {
        let viewport = Viewport::new(size, size, P::FAR);
        let bands = Bands { count: 1, log2_rows: 15, stride: size[0] };
        let batches = Batches::new(scene, m, &viewport, Faces::All, Keep::All).unwrap();
        let draws = &batches.draws(&batches.instances[0]);
        let (mut scratch, progress) = (Scratch::default(), Progress::new());
        let pieces = &Pieces::new(draws);
        let mut projected = Projected::new(draws, &mut scratch.vertices);
        projected.need(draws, pieces.of(&(0..pieces.triangles)));
        projected.project(draws, &viewport, &mut scratch.vertices, &progress).unwrap();
        let (vertices, grid) = (&scratch.vertices[..], Grid::new(size, bands));
        let (cover, numbered, viewport) = (None, true, &viewport);
        let work = Binning { draws, pieces, cover, grid, vertices, viewport, bands, numbered };
        let (mut start, mut bins) = (0, Bins::default());
        while start < pieces.triangles {
            start = fill(&work, &mut bins, start..pieces.triangles);
            let bin = bins.band(0);
            bin.fragments.draw(pixels);
            let area = BandArea { size, stride: size[0] as usize, first_row: 0, rows: size[1] as i32 };
            let (extra, large) = (&bins.extra[..], &bins.large[..]);
            let (entries, large_here) = (&bin.entries[..], &bin.large[..]);
            draw(Entries { entries, vertices, extra, large, large_here, grid, cover: None }, area, pixels);
        }
    }

    #[test]
    fn what_is_nearest_is_drawn_first() {
        // Sheets of five chunks each, in no order; slabs hold three of them.
        let scene = &sheets(&[0.8, 0.3, 0.6, 0.2, 0.9, 0.4, 0.7], 0.0);
        for size in [[600, 600], [1100, 1000]] {
            let viewport = Viewport::new(size, size, 1.0);
            let batches = Batches::new(scene, &DMat4::IDENTITY, &viewport, Faces::All, Keep::All).unwrap();
            let (mut nearest, mut scratch, progress) = (Vec::new(), Scratch::default(), Progress::new());
            let draw = |round: Round, _: &mut Cover| {
                let bands = 0..Bands::new(size).count as usize;
                for bins in round.scratch.bins() {
                    let entries = bands.clone().flat_map(|band| &bins.band(band).entries);
                    let corners = entries.flat_map(|e| e.vertices).map(|v| round.scratch.vertices[v as usize].z);
                    nearest.push(corners.fold(1.0, f32::min));
                }
                Ok(())
            };
            batches.for_each_round(&viewport, Bands::new(size), false, &mut scratch, &progress, draw).unwrap();
            let of_slabs: Vec<f32> = nearest.chunks(SLAB).map(|z| z.iter().copied().fold(1.0, f32::min)).collect();
            assert!(of_slabs.len() > 1 && of_slabs.is_sorted(), "{size:?}: {of_slabs:?}");
        }
    }

    fn bits(depth: impl IntoIterator<Item = f32>) -> Vec<u32> {
        depth.into_iter().map(f32::to_bits).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6))]
        #[test]
        fn what_hides_triangles_changes_no_bit(
            depths in prop::collection::vec(0.1f64..0.9, 4..8),
            bumps in 0.0f64..0.09,
            size in prop_oneof![Just([97u32, 64]), Just([256, 256]), Just([1100, 1000])],
            lean in -0.4f64..0.4,
        ) {
            let scene = &sheets(&depths, bumps);
            let mut m = DMat4::IDENTITY;
            // A little perspective, as of a warp.
            m.x_axis.w = 0.3 * lean;
            m.y_axis = DVec4::new(0.0, 1.0, 0.0, lean);
            let n = size[0] as usize * size[1] as usize;
            let (scratch, progress) = (&mut Scratch::default(), &Progress::new());
            let (faces, keep) = (Faces::All, Keep::InVolume);
            let mut pass = Pass { scene, clip_from_world: m, size, faces, keep, scratch, progress };
            let mut depth = crate::memory::unwritten(n).unwrap();
            pass.depth(&mut depth).unwrap();
            let mut expected = vec![1.0; n];
            drawn_plainly(scene, &m, size, &mut DepthPixels::<false> { depth: &mut expected });
            // SAFETY: drawn.
            prop_assert!(bits(unsafe { crate::memory::written(depth) }) == bits(expected.iter().copied()), "depth");
            prop_assert!(expected.iter().filter(|z| **z < 1.0).count() > n / 2, "little is drawn");

            let to_far = DMat4::from_translation(DVec3::NEG_Z) * m;
            let (mut first, mut second) = (vec![0.0; n], vec![0.0; n]);
            drawn_plainly(scene, &to_far, size, &mut LayerPixels { first: &mut first, second: &mut second });
            let (mut depth, mut behind) = (crate::memory::unwritten(n).unwrap(), crate::memory::unwritten(n).unwrap());
            pass.clip_from_world = m;
            pass.layers_to_far(&mut depth, &mut behind).unwrap();
            // SAFETY: drawn.
            let (depth, behind) = unsafe { (crate::memory::written(depth), crate::memory::written(behind)) };
            prop_assert!(bits(depth) == bits(first) && bits(behind) == bits(second), "layers");

            let (mut expected, mut numbers) = (vec![0.0; n], vec![NO_TRIANGLE; n]);
            drawn_plainly(scene, &to_far, size, &mut IdPixels { depth: &mut expected, id: &mut numbers });
            pass.clip_from_world = to_far;
            let (depth, ids) = pass.depth_and_ids().unwrap();
            prop_assert!(ids == numbers && bits(depth) == bits(expected), "numbers");
        }
    }
}
