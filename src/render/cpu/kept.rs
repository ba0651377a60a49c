//! Which clusters of a placed mesh a pass looks at, and in which order: those outside of its volume have no triangle in it, and
//! the order of triangles has no say in what is drawn, so the map stays, bit for bit.

use std::ops::Range;

use glam::{DMat4, Vec3};

use crate::render::{PlacedVolume, Volume};
use crate::scene::{BLOCK, CLUSTER, Clusters, Mesh};

/// Vertices of a run, whose blocks have a bit each in a word.
pub const RUN: usize = u64::BITS as usize * BLOCK;

/// The clusters that are not outside.
#[derive(Debug, Clone)]
pub struct Kept<'a> {
    /// Vertices in the mesh's local frame.
    pub positions: &'a [Vec3],
    /// Indices into [`Kept::positions`], in the order in which triangles are looked at.
    pub triangles: &'a [[u32; 3]],
    /// Their numbers in the mesh; empty where that is the order of the mesh.
    pub numbers: &'a [u32],
    /// Without boxes where all of the mesh is looked at.
    found: &'a Clusters,
    /// The box around the mesh.
    whole: [Vec3; 2],
    /// A bit for each cluster.
    clusters: Vec<u64>,
}

impl<'a> Kept<'a> {
    /// Those of a mesh that a matrix takes to the volume's clip space.
    pub fn new(mesh: &'a Mesh, clip_from_local: &DMat4, volume: &Volume) -> Self {
        let found = mesh.clusters();
        let (positions, triangles, numbers) = match found.sorted() {
            Some(sorted) => (&*sorted.positions, &*sorted.triangles, &*sorted.numbers),
            None => (mesh.positions_local(), mesh.triangles(), &[][..]),
        };
        let boxes = found.boxes();
        // Of f32 vertices, so exact.
        let whole = [mesh.bounds_local().min.as_vec3(), mesh.bounds_local().max.as_vec3()];
        if boxes.is_empty() {
            return Self { positions, triangles, numbers, found, whole, clusters: Vec::new() };
        }
        let volume = PlacedVolume::new(volume, clip_from_local);
        let mut clusters = vec![0; boxes.len().div_ceil(64)];
        for (i, cluster) in boxes.iter().enumerate() {
            clusters[i / 64] |= u64::from(!volume.excludes(cluster.min, cluster.max)) << (i % 64);
        }
        Self { positions, triangles, numbers, found, whole, clusters }
    }

    /// The number in the mesh of the triangle at a place.
    #[inline(always)]
    pub fn number(&self, place: u32) -> u32 {
        if self.numbers.is_empty() { place } else { self.numbers[place as usize] }
    }

    /// What is left of a range of places in [`Kept::triangles`], cluster by cluster.
    #[inline]
    pub fn runs(&self, places: Range<u32>) -> impl Iterator<Item = Range<u32>> {
        let whole = !self.has_clusters();
        let size = if whole { u32::MAX } else { CLUSTER as u32 };
        let clusters = places.start / size..places.end.div_ceil(size);
        clusters.filter(move |&i| whole || self.has(i as usize)).map(move |i| {
            let first = i.saturating_mul(size);
            places.start.max(first)..places.end.min(first.saturating_add(size))
        })
    }

    /// What is left, cluster by cluster, or all of a mesh without clusters.
    pub fn pieces(&self) -> impl Iterator<Item = Range<u32>> {
        self.runs(0..self.triangles.len() as u32)
    }

    /// Whether pieces are clusters of a large mesh.
    pub fn has_clusters(&self) -> bool {
        !self.found.boxes().is_empty()
    }

    /// The box around the piece that begins at a place.
    pub fn bounds(&self, place: u32) -> [Vec3; 2] {
        match self.found.boxes().get(place as usize / CLUSTER) {
            Some(cluster) => [cluster.min, cluster.max],
            None => self.whole,
        }
    }

    /// How many runs of [`RUN`] vertices there are.
    pub fn vertex_runs(&self) -> usize {
        self.positions.len().div_ceil(RUN)
    }

    /// Sets the bits of the blocks of vertices that the piece that begins at a place needs, in a word for each run.
    pub fn need(&self, place: u32, runs: &mut [u64]) {
        if !self.has_clusters() {
            runs.fill(u64::MAX);
            return;
        }
        for &block in self.found.blocks(place as usize / CLUSTER) {
            let block = block as usize;
            runs[block / u64::BITS as usize] |= 1 << (block % u64::BITS as usize);
        }
    }

    /// The bits of the blocks that all pieces need.
    pub fn needed(&self) -> Vec<u64> {
        let mut runs = vec![0; self.vertex_runs()];
        self.pieces().for_each(|piece| self.need(piece.start, &mut runs));
        runs
    }

    #[inline(always)]
    fn has(&self, cluster: usize) -> bool {
        self.clusters[cluster / 64] >> (cluster % 64) & 1 == 1
    }
}

/// The vertices of the blocks of a run that have bits set, as ranges in the run, of which so many vertices exist.
pub fn vertices_of(mut bits: u64, count: usize) -> impl Iterator<Item = Range<usize>> {
    std::iter::from_fn(move || {
        let first = bits.trailing_zeros();
        let after = bits.checked_shr(first)?.trailing_ones();
        let end = first + after;
        bits = bits.checked_shr(end).unwrap_or(0).checked_shl(end).unwrap_or(0);
        Some(first as usize * BLOCK..count.min(end as usize * BLOCK))
    })
    .filter(|vertices| !vertices.is_empty())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A strip of 2000 triangles along x, from -1 to 1 in its own frame, two of which take 1/500 of it.
    fn strip() -> Mesh {
        let vertices: Vec<[f64; 3]> = (0..2002).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.0]).collect();
        Mesh::new(&vertices, &(0..2000).map(|i| [i, i + 1, i + 2]).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn runs_are_the_clusters_that_reach_into_the_volume() {
        let mesh = strip();
        let clip_from_local = DMat4::from_translation(DVec3::new(1.0, 0.0, 0.5));
        let kept = Kept::new(&mesh, &clip_from_local, &Volume::of_clip(&clip_from_local, 0.0));
        // The frame is 1024 long, twice the strip's half, so x of -0.98 to 0 is seen.
        let x = |triangle: u32| mesh.positions_local()[mesh.triangles()[triangle as usize][0] as usize].x;
        for range in [0..2000, 130..131, 100..300, 900..1200] {
            let runs: Vec<Range<u32>> = kept.runs(range.clone()).collect();
            assert!(runs.windows(2).all(|r| r[0].end <= r[1].start) && runs.iter().all(|r| !r.is_empty()));
            for i in range.clone() {
                let is_left = runs.iter().any(|r| r.contains(&i));
                assert!(is_left || x(i) > 0.0, "{i} of {range:?} is left out");
                assert!(!is_left || x(i) < 0.3, "{i} of {range:?} is kept");
            }
        }
        let needed = |kept: &Kept, first: u32| {
            let mut runs = vec![0; kept.vertex_runs()];
            kept.need(first, &mut runs);
            let mut ranges = vertices_of(runs[0], kept.positions.len());
            (ranges.next(), ranges.next())
        };
        // A cluster of the strip has 130 vertices, in blocks of 64.
        for (first, vertices) in [(0, 0..192), (128, 128..320), (1920, 1920..2002)] {
            assert_eq!(needed(&kept, first), (Some(vertices), None));
        }
        let all = Volume::new(&clip_from_local, [glam::DVec4::W; 6]);
        let kept = Kept::new(&mesh, &clip_from_local, &all);
        assert_eq!(kept.runs(5..2000).map(|r| r.len()).sum::<usize>(), 1995);
    }

    #[test]
    fn small_meshes_are_one_run() {
        let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
        let far = DMat4::from_translation(DVec3::X * 9.0);
        let kept = Kept::new(&mesh, &far, &Volume::of_clip(&far, 0.0));
        assert!(kept.runs(0..1).eq(std::iter::once(0..1)));
        let mut runs = [0];
        kept.need(0, &mut runs);
        assert_eq!((kept.runs(0..0).count(), runs, kept.vertex_runs()), (0, [u64::MAX], 1));
        assert!(vertices_of(u64::MAX, 3).eq(std::iter::once(0..3)));
    }

    #[test]
    fn blocks_side_by_side_are_one_range() {
        let of = |bits: u64, count: usize| vertices_of(bits, count).collect::<Vec<_>>();
        assert_eq!(of(0, RUN), []);
        assert!(vertices_of(u64::MAX, RUN).eq(std::iter::once(0..RUN)));
        assert_eq!(of(0b1_0110, 300), [64..192, 256..300]);
        assert_eq!(of(1 << 63 | 1, RUN), [0..64, RUN - 64..RUN]);
        assert_eq!(of(1 << 63, 64), [], "beyond the last vertex");
    }
}
